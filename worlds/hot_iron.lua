-- hot_iron.lua: a red-hot iron lies on a steel plate; a cold one beside it slides until friction stops it.
--   Look at:   the iron glows dull red and loses its glow; the plate warms under it; a third iron beside the plate stays cold.
--   Law:       m c dT/dt = sum G (T' - T) + h A (Ta - T) + eps sigma A (Ta^4 - T^4); what friction takes, m v^2 / 2, is heat.
--   Expected:  the temperatures of the same equations integrated by hand in steps of a millisecond, with 20 W/K between iron and
--              plate; the slider's share of its 0.7 J, by the effusivities sqrt(k rho c) of iron and steel.
--   digbox run worlds/hot_iron.lua -- --film [--overlay]
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" },
                          overlay = { default = false, help = "colours by temperature" } }
local sigma, ambient, seconds = 5.670374419e-8, 293.15, 120

local world = digbox.world {}
world:ambient { temperature = ambient }
world:floor { material = "tile" }
local plate = world:box { name = "plate", fixed = true, size = { 0.5, 0.02, 0.3 }, at = { 0, 0.01, 0 }, material = "steel",
                          temperature = ambient, emissivity = 0.3, convection = 8 }
local G = 20                                -- W/K
local iron = world:box { name = "iron", size = { 0.16, 0.05, 0.1 }, at = { -0.12, 0.0451, 0 }, material = "iron", temperature = 1050,
                         emissivity = 0.8, convection = 10, contact_conductance = G }
local slider = world:box { name = "slider", size = 0.06, at = { 0.02, 0.05, 0 }, material = "iron", friction = 0.4, temperature = ambient,
                           contact_conductance = 1e-6, velocity = { 0.9, 0, 0 } }
local beside = world:box { name = "beside", size = { 0.12, 0.05, 0.1 }, at = { -0.45, 0.025, 0 }, material = "iron", temperature = ambient }

local eye = world:camera { at = { 0.35, 0.55, 0.95 }, look_at = { -0.05, 0.02, 0 }, fov = "38 deg" }
local overlay = opt.overlay and { "temperature", "time" } or { "time" }
if opt.film then world:record { camera = eye, to = "hot_iron-%05d.png", fps = 1, overlay = overlay } end

-- Friction first: the slider comes to rest within the first second.
local kinetic = slider.mass * 0.9 ^ 2 / 2
world:run(1)
local warmed = slider.mass * 449 * (slider.temperature - ambient)
local stopped = slider.speed
local share = math.sqrt(80 * 7870 * 449) / (math.sqrt(80 * 7870 * 449) + math.sqrt(45 * 7850 * 490))

-- The same two bodies by hand, in steps of a millisecond (Heun's rule), from what they are now.
local function air(body, T)
  return body.surface * (body.convection * (ambient - T) + body.emissivity * sigma * (ambient ^ 4 - T ^ 4))
end
local C = { iron.mass * 449, 0.5 * 0.02 * 0.3 * 7850 * 490 }
local function rates(a, b)
  return (air(iron, a) - G * (a - b)) / C[1], (air(plate, b) + G * (a - b)) / C[2]
end
local a, b, h = iron.temperature, plate.temperature, 1e-3
for _ = 1, (seconds - 1) / h do
  local a1, b1 = rates(a, b)
  local a2, b2 = rates(a + h * a1, b + h * b1)
  a, b = a + h * (a1 + a2) / 2, b + h * (b1 + b2) / 2
end
world:run(seconds - 1)

local e = world.energy
local law = {
  { "iron after 2 min, K", iron.temperature, a, 0.05 },
  { "plate after 2 min, K", plate.temperature, b, 0.05 },
  { "iron beside it, K", beside.temperature, ambient, 1e-9 },
  { "slider at rest, m/s", stopped, 0, 1e-9 },
  { "friction into the slider, J", warmed, share * kinetic, 0.02 },
  { "books: in - stored - lost, J", e.numerical, 0, 1e-6 },
}
for _, row in ipairs(law) do print(("%-30s measured %12.6f   expected %12.6f   +- %g"):format(table.unpack(row))) end
return law
