-- tests/scenarios/jointed_heaps.lua - what joints hold together and comes to lie on something: nets, figures whose joints rub, carts.
--
-- Its rows are solved all at once, from soft to hard. A round that begins where the last one ended finds most contacts open and the hinges
-- on the wrong side of their dry friction, and Newton's method takes them back one by one, up to 75 steps a round; one that is carried on
-- along the answers of the last takes five to seven. Work is counted (world:stats().work), so that it is the same on any machine.
local test = require "digbox.test"
local digbox = require "digbox"
local expect = test.expect

local function steps(world, count)
  local got = { gained = 0, dearest = 0 }
  local last = world:stats().work
  for _ = 1, count do
    world:step()
    local work = world:stats().work
    got.dearest, last = math.max(got.dearest, work - last), work
    got.gained = math.max(got.gained, world.energy.numerical)
  end
  got.work, got.gap = last, 0
  for _, joint in ipairs(world:joints()) do got.gap = math.max(got.gap, joint.error) end
  return got
end

test.scenario("a net of 81 knots on a box", function(s)
  local world, knot = s.world, {}
  world:floor {}
  world:box { fixed = true, size = { 0.5, 0.5, 0.5 }, at = { 0.01, 0.25, 0.02 } }
  for i = 1, 9 do
    knot[i] = {}
    for k = 1, 9 do
      knot[i][k] = world:ball { radius = 0.03, mass = 0.05, at = { (i - 5) * 0.1, 0.7 + 0.001 * ((3 * i + 5 * k) % 7), (k - 5) * 0.1 } }
      if i > 1 then world:distance { a = knot[i - 1][k], b = knot[i][k], length = 0.1 } end
      if k > 1 then world:distance { a = knot[i][k - 1], b = knot[i][k], length = 0.1 } end
    end
  end
  local got = steps(world, 120)
  expect(knot[5][5].position.y):near(0.53, 1e-3)
  expect(got.gap):below(1e-4)                   -- m; 2.5e-6
  expect(got.gained):below(0.1)                 -- J of 28; 0.068, before as much
  expect(got.work):below(1.9e8)                 -- 2.5e8 where rounds are not carried on, now 1.4e8
end)

test.scenario("four figures whose joints rub", function(s)
  local world = s.world
  world:floor {}
  for n = 0, 3 do
    local x, y, z, friction = 0.03 * (n * 7 % 4), 1 + 1.2 * n, 0.02 * (n * 5 % 3), 1
    local trunk = world:box { size = { 0.3, 0.5, 0.2 }, mass = 20, at = { x, y, z } }
    local head = world:ball { radius = 0.12, mass = 4, at = { x, y + 0.38, z } }
    world:ball_joint { a = trunk, b = head, at = { x, y + 0.26, z }, swing = 0.6, friction = friction }
    for side = -1, 1, 2 do
      for _, limb in ipairs { { out = 0.26, up = 0.2, long = 0.3 }, { out = 0.16, up = -0.3, long = 0.4 } } do
        local lx, top = x + side * limb.out, y + limb.up
        local upper = world:capsule { radius = 0.05, length = limb.long, mass = 3, at = { lx, top - limb.long / 2, z } }
        local lower = world:capsule { radius = 0.04, length = limb.long, mass = 2, at = { lx, top - 1.5 * limb.long - 0.1, z } }
        world:ball_joint { a = trunk, b = upper, at = { lx, top, z }, swing = 1.2, friction = friction }
        world:hinge { a = upper, b = lower, at = { lx, top - limb.long - 0.05, z }, axis = { 1, 0, 0 }, limits = { 0, 2.3 },
                      friction = friction }
      end
    end
  end
  local before = world.energy.total
  local got = steps(world, 240)
  expect(got.gap):below(1e-4)
  expect(got.gained):below(0.02 * before)       -- 0.005, before as much: legs are made inside the figure below, and are put apart
  expect(got.work):below(1.2e8)                 -- 1.56e8, now 0.86e8
end)

-- Wheels of two of them skid under load. Directions of slip come nearer by little in each turn there, up to 130 in each evaluation of the
-- equations of motion; in another start that was a frame of 158 ms whose neighbours take 1 to 10.
test.scenario("six carts on each other", function(s)
  local world, seed = s.world, 42
  local function random()
    seed = (seed * 1103515245 + 12345) % 2147483648
    return seed / 2147483648
  end
  world:floor {}
  local lying = digbox.quat { axis = { 1, 0, 0 }, angle = math.pi / 2 }
  for n = 0, 5 do
    local x, y, z = 0.2 * random(), 0.6 + 0.8 * n, 0.2 * random()
    local bed = world:box { size = { 1, 0.2, 0.5 }, mass = 30, at = { x, y, z } }
    for i = -1, 1, 2 do
      for k = -1, 1, 2 do
        local at = { x + 0.35 * i, y - 0.1, z + 0.32 * k }
        local wheel = world:cylinder { radius = 0.15, height = 0.08, mass = 2, at = at, rotation = lying }
        world:hinge { a = bed, b = wheel, at = at, axis = { 0, 0, 1 }, friction = 0.05 }
      end
    end
  end
  local got = steps(world, 60)
  expect(got.gap):below(5e-4)                   -- m; 6e-6, before 2e-5; in other starts up to 2e-4 in a frame
  expect(got.gained):below(2)                   -- J of 5800; 0.27, before as much, in other starts up to 0.8
  expect(got.dearest):below(2.3e6)              -- 2.8e6 where turns do not count in its budget, now 1.85e6
end)
