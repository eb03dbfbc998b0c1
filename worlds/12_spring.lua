-- 12_spring.lua: three masses hang on equal springs.
--   Look at:   the heavier, the lower and the slower. The third is damped and comes to rest.
--   Law:       a mass sinks by m g / k and swings with T = 2 pi sqrt(m / k); with damping c an amplitude falls to
--              exp(-c T / (2 m)) of itself in a swing, and T grows by 1 / sqrt(1 - c^2 / (4 k m)).
--   Expected:  sag 0.0981 and 0.1962 m; T = 0.6283 and 0.8886 s for k = 100 N/m and 1 and 2 kg.
--   digbox run worlds/12_spring.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local k, c, g, length, top = 100, 4, 9.81, 0.5, 1.5

local world = digbox.world { accuracy = "study" }
world:floor { material = "oak" }
local bar = world:box { name = "bar", fixed = true, material = "pine", size = { 1.2, 0.05, 0.1 }, at = { 0, top + 0.025, 0 } }
local function hang(m, x, damping)          -- let go where the spring is without force
  local size = 0.12 * m ^ (1 / 3)
  local body = world:box { material = "brass", mass = m, size = size, at = { x, top - length - size / 2, 0 } }
  local spring = world:spring { a = body, b = bar, at_a = { x, top - length, 0 }, at_b = { x, top, 0 },
                                stiffness = k, damping = damping, length = length }
  return { m = m, body = body, spring = spring, highest = {}, lowest = math.huge, deepest = 0 }
end
local weights = { hang(1, -0.4), hang(2, 0), hang(1, 0.4, c) }
local eye = world:camera { at = { 0.6, 1.1, 2.6 }, look_at = { 0, 1.05, 0 }, fov = "34 deg" }
if opt.film then world:record { camera = eye, to = "12_spring-%05d.png", fps = 30, overlay = { "joints" } } end

local function watch(w, before)             -- the moments at which the speed goes from up to down
  local now = w.body.velocity.y
  if before > 0 and now <= 0 then w.highest[#w.highest + 1] = world.time - world.frame * now / (now - before) end
  w.deepest = math.max(w.deepest, w.spring.distance - length)
end
while world.time < 6 do
  local before = {}
  for i, w in ipairs(weights) do before[i] = w.body.velocity.y end
  world:step()
  for i, w in ipairs(weights) do watch(w, before[i]) end
end
local function period(w) return (w.highest[4] - w.highest[1]) / 3 end
local function T(m) return 2 * math.pi * math.sqrt(m / k) end
local damped = T(1) / math.sqrt(1 - c * c / (4 * k))
local law = {
  { "1 kg: period, s", period(weights[1]), T(1), 1e-3 },
  { "2 kg: period, s", period(weights[2]), T(2), 1e-3 },
  { "1 kg: sinks to, m", weights[1].deepest, 2 * g / k, 1e-3 },             -- to twice the sag, by energy
  { "damped: period, s", period(weights[3]), damped, 1e-3 },
  { "damped: overshoot", weights[3].deepest * k / g - 1, math.exp(-c * damped / 4), 2e-3 },
  { "damped: sag at rest, m", weights[3].spring.distance - length, g / k, 2e-4 },    -- sleeps below 2 mm/s: 2 mm/s / sqrt(k / m)
}
for _, row in ipairs(law) do print(("%-24s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
