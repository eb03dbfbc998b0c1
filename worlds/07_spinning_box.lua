-- 07_spinning_box.lua: a box spins in free space about its middle axis, and turns over again and again (Dzhanibekov).
--   Look at:   the red cap: it points along the spin, then against it, then along it, at even times.
--   Law:       Euler's equations. With L the angular momentum, E the energy and L^2 > 2 E I2, the spin about the middle axis is
--              an elliptic sine; it changes sign every 2 K(k) / p = pi / (p agm(1, sqrt(1 - k^2))), where
--              p^2 = (I3 - I2)(L^2 - 2 E I1) / (I1 I2 I3) and k^2 = (I2 - I1)(2 E I3 - L^2) / ((I3 - I2)(L^2 - 2 E I1))
--              (Landau, Lifshitz, Mechanics, section 37). L and E never change.
--   Expected:  see the table it prints.
--   digbox run worlds/07_spinning_box.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local spin, a, b, c, m = digbox.vec(0.02, 8, 0.2), 0.5, 0.3, 0.1, 10        -- least inertia along x, middle y, greatest z

local world = digbox.world { gravity = { 0, 0, 0 }, accuracy = "study" }
local box = world:body { name = "box", mass = m, spin = spin, parts = { digbox.box { size = { a, b, c }, material = "oak" } } }
local cap = world:box { name = "cap", size = { a, 0.01, c }, at = { 0, b / 2 + 0.005, 0 }, mass = 1e-6, colour = { 0.8, 0.05, 0.03 },
                        spin = spin, velocity = spin:cross { 0, b / 2 + 0.005, 0 } }
world:weld { a = cap, b = box }
local eye = world:camera { at = { 0.5, 0.35, 1.6 }, look_at = { 0, 0, 0 }, fov = "34 deg" }
if opt.film then world:record { camera = eye, to = "07_spinning_box-%05d.png", fps = 30 } end

local L0, E0 = world.angular_momentum, world.energy.kinetic
local flips, last = {}, nil
while #flips < 5 do                         -- the spin about the box's own middle axis changes sign
  world:step()
  local now = box.rotation:inverse():rotate(box.spin).y
  if last and now * last < 0 then flips[#flips + 1] = world.time - world.frame * now / (now - last) end
  last = now
end

local I1, I2, I3 = m * (b * b + c * c) / 12, m * (a * a + c * c) / 12, m * (a * a + b * b) / 12
local E2 = I1 * spin.x ^ 2 + I2 * spin.y ^ 2 + I3 * spin.z ^ 2             -- 2 E
local L2 = (I1 * spin.x) ^ 2 + (I2 * spin.y) ^ 2 + (I3 * spin.z) ^ 2
local p = math.sqrt((I3 - I2) * (L2 - E2 * I1) / (I1 * I2 * I3))
local k2 = (I2 - I1) * (E2 * I3 - L2) / ((I3 - I2) * (L2 - E2 * I1))
local x, y = 1, math.sqrt(1 - k2)
for _ = 1, 9 do x, y = (x + y) / 2, math.sqrt(x * y) end                    -- agm
local law = {
  { "turns over every, s", (flips[5] - flips[1]) / 4, math.pi / (p * x), 2e-3 },
  { "ang. momentum, of itself", #(world.angular_momentum - L0) / #L0, 0, 1e-7 },
  { "energy, of itself", (world.energy.kinetic - E0) / E0, 0, 1e-5 },
}
for _, row in ipairs(law) do print(("%-24s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
