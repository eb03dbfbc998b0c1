-- lava_lamp.lua: a blob of wax in a glass of water that is warm below and cool above goes up and down by itself.
--   Look at:   below, the blob takes up heat, swells and rises; above it gives the heat off, shrinks and sinks.
--   Law:       rho(T) = rho (1 - beta (T - T0)) of the water, V (1 + beta (T - T0)) of the blob, m c dT/dt = h A (T_water - T); Stokes'
--              drag 6 pi mu r v.
--   Expected:  the same equations integrated by hand give the same number of turns and the same mean period; over the last five minutes
--              as much heat went in as out; a blob as warm as its water rises from (0.4 % / (beta - beta')) = 6.78 K above 25 C on.
--   digbox run worlds/lava_lamp.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local zero, g = 273.15, 9.81
local height, warm, cool = 0.3, 50 + zero, 30 + zero            -- m, K below and above
local gradient = (cool - warm) / height
local water = { density = 1000, expansion = 0.21e-3, expansion_from = 25 + zero, viscosity = 0.01 }
local wax = { expansion = 0.8e-3, density = 1000 * 1.0087, capacity = 2000, radius = 0.02, convection = 900 }

local world = digbox.world { gravity = { 0, -g, 0 }, sleeping = false }   -- about to float, it is slow
world:ambient { temperature = warm, gradient = gradient }
world:water { level = 0.4, density = water.density, expansion = water.expansion, expansion_from = water.expansion_from,
              viscosity = water.viscosity }
world:cylinder { name = "foot", fixed = true, radius = 0.08, height = 0.05, at = { 0, -0.025, 0 }, material = "steel", restitution = 0 }
world:cylinder { name = "lid", fixed = true, radius = 0.06, height = 0.03, at = { 0, height + 0.015, 0 }, material = "steel",
                 restitution = 0 }
local blob = world:ball { name = "wax", at = { 0, wax.radius + 0.01, 0 }, radius = wax.radius, density = wax.density, drag_coefficient = 0,
                          restitution = 0, friction = 0, temperature = warm, expansion = wax.expansion, expansion_from = 25 + zero,
                          heat_capacity = wax.capacity, convection = wax.convection, colour = { 0.9, 0.25, 0.05 } }
local eye = world:camera { at = { 0, 0.18, 0.75 }, look_at = { 0, 0.14, 0 }, fov = "38 deg" }
if opt.film then world:record { camera = eye, to = "lava_lamp-%05d.png", fps = 2, overlay = { "time" } } end

-- Turns: how often it comes up past the middle; heat in and out by its own temperature, over the whole turns of the last five minutes
local area, mass = 4 * math.pi * wax.radius ^ 2, blob.mass
local function watch(seconds, dt, step)
  local turns, first, last, side, into, out, begun, done = 0, nil, nil, -1, 0, 0, nil, nil
  for i = 1, math.floor(seconds / dt + 0.5) do
    local y, T = step()
    local flow = wax.convection * area * (warm + gradient * y - T) * dt
    into, out = into + math.max(flow, 0), out + math.max(-flow, 0)
    if side < 0 and y > 0.6 * height then
      side, turns, first, last = 1, turns + 1, first or i * dt, i * dt
      if last > seconds - 300 then
        begun = begun or { into, out }
        done = { into - begun[1], out - begun[2] }
      end
    elseif side > 0 and y < 0.4 * height then
      side = -1
    end
  end
  return { turns = turns, period = (last - first) / (turns - 1), into = done[1], out = done[2] }
end

local seconds = 600
local seen = watch(seconds, world.frame, function()
  world:step()
  return blob.position.y, blob.temperature
end)

-- By hand, semi-implicit Euler in steps of half a millisecond; foot and lid stop it
local y, v, T, h = wax.radius + 0.01, 0, warm, 5e-4
local volume = mass / wax.density
local byhand = watch(seconds, h, function()
  local about = warm + gradient * y
  local rho = water.density * (1 - water.expansion * (about - water.expansion_from))
  local size = volume * (1 + wax.expansion * (T - 25 - zero))
  local r = (3 * size / (4 * math.pi)) ^ (1 / 3)
  v = (v + h * g * (rho * size / mass - 1)) / (1 + h * 6 * math.pi * water.viscosity * r / mass)
  y = y + h * v
  if y < wax.radius then y, v = wax.radius, math.max(v, 0) end
  if y > height - wax.radius then y, v = height - wax.radius, math.min(v, 0) end
  T = T + h * wax.convection * area * (about - T) / (mass * wax.capacity)
  return y, T
end)

local e = world.energy
local law = {
  { "turns in ten minutes", seen.turns, byhand.turns, 1 },
  { "mean period, s", seen.period, byhand.period, 0.02 * byhand.period },
  { "heat out over heat in", seen.out / seen.into, 1, 0.02 },
  { "more than three turns", seen.turns > 3 and 1 or 0, 1, 0 },
  { "books: in - stored - lost, J", e.numerical, 0, 1e-3 },
}
for _, row in ipairs(law) do print(("%-30s measured %12.6f   expected %12.6f   +- %g"):format(table.unpack(row))) end
return law
