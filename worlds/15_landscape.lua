-- 15_landscape.lua: balls are dropped on hills and come to rest in the valleys.
--   Look at:   every ball ends in a hollow; the hills have no ball left.
--   Law:       a ball stays where the slope of the ground is below its rolling friction, so at the bottom of a hollow of
--              y = h (cos(2 pi x / L) + cos(2 pi z / L)) / 2 its centre is r above -h (r is small against the hollow).
--   Expected:  all 16 at rest, each within 1 cm of that height and nearer to a hollow than a tenth of their spacing.
--   digbox run worlds/15_landscape.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local h, L, side, r, cells = 0.12, 1, 4, 0.06, 80

local world = digbox.world { seed = 3 }
local rows = {}
for i = 0, cells do
  rows[i + 1] = {}
  for j = 0, cells do
    local x, z = (j / cells - 0.5) * side, (i / cells - 0.5) * side
    rows[i + 1][j + 1] = h * (math.cos(2 * math.pi * x / L) + math.cos(2 * math.pi * z / L)) / 2
  end
end
world:heightfield { name = "ground", material = "felt", size = { side, 0, side }, heights = rows, rolling_friction = 0.03 }
local balls = {}
for i = 0, 15 do                            -- somewhere above the sixteen hollows, which are at half-integers
  local x, z = i % 4 - 1.5 + 0.5 * (math.random() - 0.5), i // 4 - 1.5 + 0.5 * (math.random() - 0.5)
  balls[#balls + 1] = world:ball { material = i % 2 == 0 and "rubber" or "ivory", radius = r, at = { x, 0.4, z }, restitution = 0.3,
                                   rolling_friction = 0.03, friction = 0.6 }
end
local eye = world:camera { at = { 2.6, 2.7, 4.0 }, look_at = { 0, -0.15, 0.15 }, fov = "42 deg" }
if opt.film then world:record { camera = eye, to = "15_landscape-%05d.png", fps = 30 } end
local function all_rest()
  for _, b in ipairs(balls) do if not b.asleep then return false end end
  return true
end
world:run { seconds = 20, stop_when = all_rest }

local worst, farthest, resting = 0, 0, 0
for _, b in ipairs(balls) do
  local p = b.position
  local hollow = digbox.vec(math.floor(p.x) + 0.5, r - h, math.floor(p.z) + 0.5)
  worst, farthest = math.max(worst, math.abs(p.y - hollow.y)), math.max(farthest, #(p - hollow))
  if b.mode == "resting" then resting = resting + 1 end
end
local law = {
  { "balls at rest", resting, 16, 0 },
  { "highest over its hollow", worst, 0, 0.01 },
  { "farthest from it, m", farthest, 0, 0.1 * L },
}
for _, row in ipairs(law) do print(("%-24s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
