-- 08_tipping.lua: seven boxes let go on one edge, each tilted 0.6 degrees more than the one before.
--   Look at:   those before the middle fall back on their feet, those behind it tip over.
--   Law:       a box w wide and h high on its edge tips when its centre of mass has passed the edge: at atan(w / h).
--   Expected:  26.565 degrees for w = 0.2 m and h = 0.4 m; found between the last that fell back and the first that tipped.
--   digbox run worlds/08_tipping.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local w, h, n, between = 0.2, 0.4, 7, math.rad(0.6)
local critical = math.atan(w / h)

local world = digbox.world {}
world:floor { material = "tile" }
local boxes = {}
for i = 1, n do                             -- tilted about the lower edge on the +x side, which stays on the floor
  local tilt = critical + (i - n // 2 - 0.5) * between
  local turn = digbox.quat { axis = { 0, 0, 1 }, angle = -tilt }
  local edge = digbox.vec(0, 0, 0.3 * (n - i))
  local box = world:box { material = "pine", friction = 0.8, restitution = 0, size = { w, h, 0.2 }, rotation = turn,
                          at = edge + turn:rotate { -w / 2, h / 2, 0 } }
  boxes[i] = { body = box, tilt = tilt }
end
local eye = world:camera { at = { 2.4, 1.6, 3.1 }, look_at = { 0.1, 0.1, 0.8 }, fov = "38 deg" }
if opt.film then world:record { camera = eye, to = "08_tipping-%05d.png", fps = 30 } end
world:run "4 s"

local back, over                            -- the greatest tilt that fell back, the least that tipped over
for _, box in ipairs(boxes) do
  local upright = math.abs(box.body.rotation:rotate({ 0, 1, 0 }).y) > 0.99
  if upright then back = box.tilt else over = over or box.tilt end
end
local law = {
  { "fell back up to, deg", math.deg(back), math.deg(critical - between / 2), 1e-6 },
  { "tipped over from, deg", math.deg(over), math.deg(critical + between / 2), 1e-6 },
  { "so it tips at, deg", math.deg(back + over) / 2, math.deg(critical), 0.3 },
}
for _, row in ipairs(law) do print(("%-24s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
