-- 09_stack.lua: five boxes stand on each other.
--   Look at:   nothing moves; nothing trembles. Every link knows the force it carries.
--   Law:       what lies under box i carries all boxes from i on: (n - i + 1) m g.
--   Expected:  49.05, 39.24, 29.43, 19.62, 9.81 N for boxes of 1 kg.
--   digbox run worlds/09_stack.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local n, m, a, g = 5, 1, 0.2, 9.81

local world = digbox.world {}
local floor = world:floor { material = "tile" }
local boxes = { [0] = floor }
for i = 1, n do
  boxes[i] = world:box {
    name = "box " .. i, material = "oak", mass = m, size = a, at = { 0.01 * (i % 2), (i - 0.5) * a, 0 }, restitution = 0,
    rotation = digbox.quat { axis = { 0, 1, 0 }, angle = 0.2 * i },
  }
end
local eye = world:camera { at = { 1.2, 0.9, 2 }, look_at = { 0, 0.48, 0 }, fov = "36 deg" }
if opt.film then world:record { camera = eye, to = "09_stack-%05d.png", fps = 30 } end
world:run "2 s"

local function carried(i)                   -- N, up, by the link from what lies below
  for _, link in ipairs(boxes[i]:links()) do
    if link.a == boxes[i - 1] then return link.effort.y end                 -- effort is the force on b
    if link.b == boxes[i - 1] then return -link.effort.y end
  end
end
local law = {}
for i = 1, n do
  law[i] = { ("under box %d, N"):format(i), carried(i), (n - i + 1) * m * g, 0.01 * m * g }
end
law[n + 1] = { "members of its DIG", boxes[1].dig.size, n, 0 }
for _, row in ipairs(law) do print(("%-24s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
