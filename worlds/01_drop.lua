-- 01_drop.lua: a rubber ball falls and bounces.
--   Look at:   every bounce keeps the same share of the speed, so of the height its square.
--   Law:       the first impact comes at t = sqrt(2 h / g); bounce n rises to h e^(2 n).
--   Expected:  t = 0.4515 s; heights 0.5625, 0.3164, 0.1780 m for h = 1 m and e = 0.75.
--   digbox run worlds/01_drop.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local h, e, g = 1, 0.75, 9.81

local world = digbox.world {}
world:floor { material = "tile" }
local ball = world:ball { name = "ball", material = "rubber", radius = "10 cm", at = { 0, 0.1 + h, 0 }, restitution = e }
world:box { name = "post", fixed = true, material = "pine", size = { 0.04, 1.2, 0.04 }, at = { 0.3, 0.6, -0.2 } }
for n = 0, 3 do                             -- shelves at the heights the law promises
  world:box { fixed = true, material = "oak", size = { 0.24, 0.01, 0.1 }, at = { 0.3, h * e ^ (2 * n), -0.2 } }
end
local eye = world:camera { at = { 0.6, 0.9, 3 }, look_at = { 0.1, 0.6, 0 }, fov = "36 deg" }
if opt.film then world:record { camera = eye, to = "01_drop-%05d.png", fps = 30 } end

local impacts = {}
ball:on("impact", function(event) impacts[#impacts + 1] = event.time end)
world:run { seconds = 10, stop_when = function() return #impacts >= 5 end }

local function rise(n)                      -- thrown up, it is back after T = 2 v / g, so it rose g T^2 / 8
  return g * (impacts[n + 1] - impacts[n]) ^ 2 / 8
end
local law = {
  { "first impact, s", impacts[1], math.sqrt(2 * h / g), 1e-5 },
  { "bounce 1 rises to, m", rise(1), h * e ^ 2, 1e-4 },
  { "bounce 2 rises to, m", rise(2), h * e ^ 4, 1e-4 },
  { "bounce 3 rises to, m", rise(3), h * e ^ 6, 1e-4 },
}
for _, row in ipairs(law) do print(("%-24s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
world:run(0.5)
return law
