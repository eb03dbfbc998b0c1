-- 06_pendulum.lua: a heavy bar on a hinge swings far out.
--   Look at:   the bar: at 120 degrees it takes much longer than a small swing would.
--   Law:       let go at the angle A it takes T = 2 pi sqrt(I / (m g d)) / agm(1, cos(A/2)), where agm is Gauss' arithmetic-
--              geometric mean (the complete elliptic integral), I the inertia about the hinge, d its distance from the centre.
--   Expected:  T = 2.2501 s for a bar of 1 m and A = 120 deg; a small swing would take 1.639 s. Its energy stays.
--   digbox run worlds/06_pendulum.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local l, w, A, g = 1, 0.05, math.rad(120), 9.81

local world = digbox.world { accuracy = "study" }
world:floor { material = "tile" }
local pivot = digbox.vec(0, 1.4, 0)
local post = world:box { name = "post", fixed = true, material = "oak", size = { 0.1, 1.5, 0.1 }, at = { 0, 0.75, -0.12 } }
local turn = digbox.quat { axis = { 0, 0, 1 }, angle = A }
local bar = world:box {
  name = "bar", material = "steel", size = { w, l, w }, at = pivot - turn:rotate { 0, l / 2, 0 }, rotation = turn,
}
local hinge = world:hinge { a = bar, b = post, at = pivot, axis = { 0, 0, 1 } }
world:camera { name = "eye", at = { 1.2, 1.4, 4 }, look_at = { 0, 1.2, 0 }, fov = "40 deg" }
if opt.film then world:record { to = "06_pendulum-%05d.png", fps = 30 } end

local function agm(a, b)
  for _ = 1, 8 do a, b = (a + b) / 2, math.sqrt(a * b) end
  return a
end
local crossings, last = {}, hinge.angle + A       -- the angle from hanging down, and when it passes 0
local start = bar.energy
while #crossings < 5 do
  world:step()
  local now = hinge.angle + A
  if now * last < 0 then crossings[#crossings + 1] = world.time - world.frame * now / (now - last) end
  last = now
end
local I_over_m, d = (l * l + w * w) / 12 + l * l / 4, l / 2
local T = 2 * math.pi * math.sqrt(I_over_m / (g * d)) / agm(1, math.cos(A / 2))
world:run "0.4 s"
local law = {
  { "period, s", (crossings[5] - crossings[1]) / 2, T, 1e-3 },
  { "energy lost, J", start - bar.energy, 0, 1e-3 * start },
  { "hinge apart by, m", hinge.error, 0, 1e-4 },
}
for _, row in ipairs(law) do print(("%-24s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
