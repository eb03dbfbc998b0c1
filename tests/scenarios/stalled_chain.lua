-- tests/scenarios/stalled_chain.lua - a chain of six bodies with welds strikes a wall and gains nothing by it.
--
-- Sweeps stalled at its five joints, 1 to 11 m/s off, and that pumped 55 J into 40 in half a step (seed 14017 of the random worlds,
-- shrunk); all rows solved at once agree in two to six factorisations.
local test = require "digbox.test"

test.scenario("a welded chain gains nothing where sweeps stall", function(s)
  local world = s.world
  world:floor { friction = 0.6 }
  for _, normal in ipairs { { 1, 0, 0 }, { -1, 0, 0 }, { 0, 0, 1 }, { 0, 0, -1 } } do
    world:plane { normal = normal, offset = -6, friction = 0.6 }
  end
  local b1 = world:ball { at = { 0, 1, -0.01069 }, friction = 0.6, mass = 0.3758, radius = 0.3292, velocity = { -6.107, 2.955, -5.079 } }
  local b2 = world:capsule { at = { 1.3, 1, 0.03291 }, friction = 0.6, length = 0.1253, mass = 0.3952, radius = 0.08134, restitution = 1,
                             velocity = { 0.2993, -0.9048, 0.1124 } }
  local b3 = world:ball { at = { 2.6, 1, -0.06297 }, friction = 0.6, mass = 1.654, radius = 0.3364, spin = { -19.54, -8.382, 22.28 } }
  local b4 = world:ball { at = { 0, 2.3, 0.08611 }, friction = 0, mass = 0.4388, radius = 0.07914, restitution = 1,
                          spin = { 2.638, 1.35, -0.8537 } }
  local b5 = world:ball { at = { 1.3, 2.3, -0.03634 }, friction = 0.6, mass = 2.589, radius = 0.06159, restitution = 1,
                          spin = { -2.649, -0.2753, 2.034 }, velocity = { -0.6666, -0.4811, 0.8068 } }
  local b6 = world:box { at = { 2.6, 2.3, 0.03383 }, friction = 0.6, mass = 0.521, size = { 0.5497, 0.3957, 0.06826 },
                         spin = { -12.38, -1.013, 3.767 }, velocity = { 0.7785, -0.05125, -0.07481 } }
  world:ball_joint { a = b1, b = b2, at = { 0.65, 1, 0.01111 } }
  world:weld { a = b2, b = b3, at = { 1.95, 1, -0.01503 } }
  world:hinge { a = b3, b = b4, at = { 1.3, 1.65, 0.01157 }, axis = { 0, 1, 0 } }
  world:hinge { a = b4, b = b5, at = { 0.65, 2.3, 0.024885 }, axis = { 0, 1, 0 } }
  world:weld { a = b5, b = b6, at = { 1.95, 2.3, -0.001255 } }
  local last, gained = math.huge, 0
  for _ = 1, 120 do
    world:step()
    local e = world.energy
    local now = e.kinetic + e.potential
    gained, last = math.max(gained, now - last), now
  end
  test.expect(gained):below(0.5)                -- J in a step, of 114
  test.expect(#world:warnings()):is(0)
end)
