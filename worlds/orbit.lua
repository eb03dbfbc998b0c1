-- orbit.lua: two planets under a law of gravitation that the script wrote itself, with world:add_effect.
--   Look at:   the inner planet goes round eight times while the outer one goes round once; its path is an ellipse that stays.
--   Law:       F = -k m x / |x|^3, so that T = 2 pi sqrt(a^3 / k) and the energy of a planet is -k m / (2 a).
--   Expected:  a = 1 m and 4 m, k = 4 pi^2 m^3/s^2: T = 1 s and 8 s; after 8 s both are where they were.
--   digbox run worlds/orbit.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local k, m = 4 * math.pi ^ 2, 2

local world = digbox.world { gravity = { 0, 0, 0 }, accuracy = "study" }
local function planet(name, a, excentricity, colour)        -- at its nearest point
  local near = a * (1 - excentricity)
  return world:ball { name = name, radius = 0.14 * a ^ 0.5, mass = m, at = { near, 0, 0 }, colour = colour,
                      velocity = { 0, 0, -math.sqrt(k * (2 / near - 1 / a)) } }
end
local inner, outer = planet("inner", 1, 0.3, { 0.8, 0.3, 0.1 }), planet("outer", 4, 0.05, { 0.1, 0.3, 0.7 })
world:box { name = "sun", fixed = true, collides = false, size = 0.4, colour = { 0.9, 0.7, 0.1 } }

world:add_effect {
  name = "gravitation", law = "F = -k m x / |x|^3",
  step = function(_, bodies)                -- at every evaluation of the equations of motion
    for _, b in ipairs(bodies) do
      b.force = -k * b.mass / (#b.position) ^ 3 * b.position
    end
  end,
  energy = function(_, bodies)
    local sum = 0
    for _, b in ipairs(bodies) do sum = sum - k * b.mass / #b.position end
    return sum
  end,
}

world:sky "black"
local eye = world:camera { at = { 0.6, 7.4, 7.4 }, look_at = { 0.1, 0, 0.5 }, fov = "44 deg" }
if opt.film then world:record { camera = eye, to = "orbit-%05d.png", fps = 30, overlay = { "trails" } } end
local start = { inner.position, outer.position }
world:run "8 s"

local energy = world.energy
local law = {
  { "inner, off its start, m", #(inner.position - start[1]), 0, 1e-6 },
  { "outer, off its start, m", #(outer.position - start[2]), 0, 1e-6 },
  { "energy, J", energy.total, -k * m * (1 / 2 + 1 / 8), 1e-7 },
  { "ledger, J", energy.numerical, 0, 1e-7 },
  { "outside its plane, m", math.abs(inner.position.y) + math.abs(outer.position.y), 0, 0 },
}
for _, row in ipairs(law) do print(("%-24s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
