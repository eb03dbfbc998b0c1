-- everything.lua: something for every effect there is, in one small yard; what each costs is shown by
--   digbox cost --effects worlds/everything.lua
--   Look at:   a stack, a ball that rolls, a pendulum, a crate that floats, a hot iron on a plate, a ball that drifts where
--              there is no gravity, a box that is pushed along, and a leaf in a wind that the script wrote.
--   Law:       an effect is on when a scene calls for it, and says which line did.
--   Expected:  every effect that world:effects() lists takes part.
--   digbox run worlds/everything.lua
local digbox = require "digbox"
local world = digbox.world {}
local vec = digbox.vec

world:air {}                                                              -- drag
world:floor { friction = 0.5, rolling_friction = 0.01 }
for i = 1, 4 do                                                           -- contact, friction
  world:box { name = "box " .. i, material = "oak", size = 0.2, at = { 0.01 * (i % 2) - 2, 0.2 * i - 0.1, 0 } }
end
world:ball { name = "roller", material = "steel", radius = 0.1, at = { -1, 0.1, 1 }, velocity = { 0.8, 0, 0 }, rolling_friction = 0.01 }
local bob = world:ball { name = "bob", material = "brass", radius = 0.08, at = { 0.6, 1.4, -1 } }
world:hinge { a = bob, at = { 0, 1.4, -1 }, axis = { 0, 0, 1 } }          -- joints
local sledge = world:box { name = "sledge", material = "oak", size = { 0.3, 0.15, 0.2 }, at = { -1.6, 0.075, 1.6 } }
sledge:push { force = { 18, 0, 0 }, lasts = "10 s" }                      -- push

world:water { level = 0.5, at = { 2, 0.25, 0 }, size = { 1.4, 0.5, 1.4 } }        -- buoyancy
for _, side in ipairs { { 0.75, 0, 0.05, 1.5 }, { -0.75, 0, 0.05, 1.5 }, { 0, 0.75, 1.5, 0.05 }, { 0, -0.75, 1.5, 0.05 } } do
  world:box { fixed = true, material = "glass", size = { side[3], 0.6, side[4] }, at = { 2 + side[1], 0.3, side[2] } }
end
world:box { name = "crate", material = "pine", density = 500, size = 0.3, at = { 2, 0.7, 0 } }

world:box { name = "pond", fixed = true, collides = false, size = { 1.4, 0.48, 1.4 }, at = { 2, 0.25, 0 }, colour = { 0.05, 0.22, 0.33 } }

-- heat
world:box { name = "plate", fixed = true, material = "steel", size = { 0.6, 0.1, 0.4 }, at = { 0.6, 0.05, 1 }, temperature = 293 }
world:box { name = "iron", material = "iron", size = { 0.2, 0.1, 0.1 }, at = { 0.6, 0.15, 1 }, temperature = 500 }

world:region { box = { size = { 1, 1, 1 } }, at = { 0.6, 2.4, 0 }, laws = { gravity = { 0, 0, 0 } } }
world:ball { name = "drifter", radius = 0.1, at = { 0.3, 2.4, 0 }, velocity = { 0.1, 0, 0 } }

local leaf = world:box { name = "leaf", density = 200, size = { 0.2, 0.01, 0.2 }, at = { -0.6, 2, -0.4 } }
world:add_effect { name = "gusts", bodies = { leaf }, law = "F = m a sin t", step = function(effect, bodies)
  for _, b in ipairs(bodies) do b.force = b.mass * vec(2 * math.sin(3 * effect.time), 9, 0) end
end }

world:run "2 s"

local law = {}
for name, e in pairs(world:effects()) do law[#law + 1] = { name .. " is called for", e.calls > 0 and 1 or 0, 1, 0 } end
table.sort(law, function(a, b) return a[1] < b[1] end)
for _, row in ipairs(law) do print(("%-28s measured %d   expected %d   +- %g"):format(table.unpack(row))) end
return law
