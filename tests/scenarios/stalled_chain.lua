-- tests/scenarios/stalled_chain.lua - a chain of six bodies with welds strikes a wall and gains nothing by it.
--
-- Sweeps stalled at its five joints, 1 to 11 m/s off, and that pumped 55 J into 40 in half a step (seed 14017 of the random worlds,
-- shrunk); all rows solved at once agree in two to six factorisations.
local digbox = require "digbox"
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

-- The direct solve that takes over there reckons with taut joints that turn along with nothing: a plate that whirled at 25 rad/s was
-- braked to 21 by a torque from nowhere, within 4 ms (seed 24288 of the random worlds, shrunk).
test.scenario("what whirls keeps its angular momentum where sweeps stall", function()
  local world = digbox.world { gravity = { 0, 0, 0 } }
  local block = world:box { at = { 2.6, 1, -0.03758 }, friction = 0.6, mass = 1, restitution = 0.5, size = { 0.4698, 0.3256, 0.3884 },
                            spin = { 1.96, 0.4809, -2.201 }, velocity = { 0.7921, -0.5996, 0.3421 } }
  local plate = world:box { at = { 0, 2.3, -0.09677 }, friction = 0.6, mass = 1, restitution = 0.5, size = { 0.3045, 0.2885, 0.05565 },
                            velocity = { 0.6452, -0.2449, 0.1241 } }
  local disc = world:cylinder { at = { 1.3, 2.3, 0.03319 }, friction = 0.6, height = 0.05986, mass = 1, radius = 0.1142, restitution = 0,
                                spin = { 2.473, 1.653, -1.32 }, velocity = { 8.299, 4.633, -0.2822 } }
  local peg = world:box { at = { 2.6, 2.3, -0.02234 }, friction = 0.6, mass = 1, restitution = 0.5, size = { 0.05642, 0.05884, 0.09493 },
                          spin = { -1.826, -1.579, 2.112 }, velocity = { -1.691, -3.064, -0.7034 } }
  world:spring { a = block, b = plate, damping = 0, stiffness = 45.65 }
  world:hinge { a = plate, b = disc, at = { 0.65, 2.3, -0.03179 }, axis = { 1, 0, 0 } }
  world:slider { a = disc, b = peg, at = { 1.95, 2.3, 0.005425 }, axis = { 1, 0, 0 } }
  local start = world.angular_momentum
  world:run(1)
  test.expect((world.angular_momentum - start):length() / start:length()):below(1e-11)
end)

-- Eight rods of 1 and 100 kg in a row that whirls, with something beside it for which it is not traced or conserved at "sketch". What
-- pulls at rods that turn as one turns along; when it was taken to stand still, 2.4 % of the angular momentum went in three frames, and
-- 4.4 % of the energy.
test.scenario("so does a chain that whirls beside something", function()
  local world, before = digbox.world { gravity = { 0, 0, 0 }, accuracy = "sketch" }, nil
  for i = 1, 8 do
    local rod = world:box { size = { 0.6, 0.1, 0.2 }, mass = i % 2 == 1 and 1 or 100, at = { 0.7 * i, 0, 0 }, spin = { 0, 25, 0 },
                            velocity = { 0, 0, -25 * 0.7 * i } }
    if before then world:ball_joint { a = before, b = rod, at = { 0.7 * i - 0.35, 0, 0 } } end
    before = rod
  end
  world:box { size = 0.3, at = before.position + digbox.vec(0.2, 0.3, 0), mass = 1, velocity = before.velocity }
  local start, energy = world.angular_momentum, world.energy.kinetic
  world:run(2)
  test.expect((world.angular_momentum - start):length() / start:length()):below(1e-12)
  test.expect(world.energy.kinetic / energy):near(1, 1e-3)
end)
