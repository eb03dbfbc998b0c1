-- 05_cradle.lua: Newton's cradle: five steel balls in a row, one let go.
--   Look at:   one ball in, one ball out on the other side, as high as the first was; the three between stay.
--   Law:       equal masses exchange their velocities at an elastic hit, and a pendulum keeps m g h + m v^2 / 2.
--   Expected:  the last ball swings out to the angle the first was let go from, 40 degrees, and back again.
--   digbox run worlds/05_cradle.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local n, r, length, angle = 5, 0.05, 0.5, math.rad(40)

local world = digbox.world { accuracy = "study" }
world:floor { material = "oak" }
local frame = world:box { name = "frame", fixed = true, material = "pine", size = { 0.9, 0.03, 0.3 }, at = { 0, 0.8, 0 } }
local balls = {}
for i = 1, n do
  local x = (i - (n + 1) / 2) * 2 * r
  local away = i == 1 and angle or 0
  balls[i] = world:ball {
    name = "ball " .. i, material = "steel", radius = r, restitution = 1, friction = 0,
    at = { x - length * math.sin(away), 0.785 - length * math.cos(away), 0 },
  }
  for side = -1, 1, 2 do                    -- two threads each, so that it swings in one plane
    world:distance { a = balls[i], b = frame, at_a = balls[i].position, at_b = { x, 0.785, 0.12 * side } }
  end
end
local eye = world:camera { at = { 0.5, 0.75, 2 }, look_at = { 0, 0.5, 0 }, fov = "36 deg" }
if opt.film then world:record { camera = eye, to = "05_cradle-%05d.png", fps = 30, overlay = { "joints" } } end

local function swing(i)                     -- rad, out to the right
  return math.atan(balls[i].position.x - (i - (n + 1) / 2) * 2 * r, 0.785 - balls[i].position.y)
end
local out, between = 0, 0
world:run { seconds = 1.2, stop_when = function()
  out = math.max(out, swing(n))
  for i = 2, n - 1 do between = math.max(between, math.abs(swing(i))) end
  return out > angle / 2 and swing(n) < out - math.rad(0.2)
end }

local law = {
  { "last ball swings to, deg", math.deg(out), 40, 0.5 },
  { "those between, deg", math.deg(between), 0, 1 },
}
for _, row in ipairs(law) do print(("%-24s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
