-- Blows of many: energy where they are not located in time, and none that nobody saw.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- 216 elastic balls in a lattice that is a little out of order fall on a floor: one group of more bodies than have their blows
-- located. A simultaneous solve of all restitutions doubled their energy at the first blow.
scenario("a lattice of elastic balls that strikes the floor neither gains nor loses much energy", function()
  local world = digbox.world { sleeping = false }
  world:floor { restitution = 1, friction = 0 }
  local n = 0
  for i = 0, 5 do
    for j = 0, 5 do
      for k = 0, 5 do
        n = n + 1
        local function off(m) return 0.001 * (n * m % 97) / 97 end
        world:ball { radius = 0.1, mass = 10, at = { 0.21 * i + off(31), 1.101 + 0.21 * k + off(57), 0.21 * j + off(83) },
                     restitution = 1, friction = 0 }
      end
    end
  end
  local start = world.energy.kinetic + world.energy.potential
  for _ = 1, 50 do
    world:step()
    expect(world.energy.kinetic + world.energy.potential):near(start, 0.06 * start)
  end
end)

-- A ball that is struck may get in the same step where nobody looked. Before such steps were done again, two of these
-- forty passed into each other about once in five seconds, by up to a fifth of their radius.
scenario("forty elastic balls in a small room never pass into each other", function()
  local world = digbox.world { gravity = { 0, 0, 0 }, sleeping = false }
  world:room { size = { 1, 1, 1 }, restitution = 1, friction = 0 }
  for i = 1, 40 do
    local cell = digbox.vec(i % 4, i // 4 % 4, i // 16) / 4 + digbox.vec(0.125, 0.125, 0.125)
    local way = digbox.vec(math.sin(12.9 * i), math.sin(78.2 * i), math.sin(37.7 * i)):normalized()
    world:ball { mass = 0.1, radius = 0.03, at = cell - digbox.vec(0.5, 0, 0.5), velocity = 2 * way, restitution = 1, friction = 0 }
  end
  local kinetic = world.energy.kinetic
  world:run(6)
  expect(world:stats().worst_penetration):below(1e-9)
  expect(world.energy.kinetic):near(kinetic, 1e-9 * kinetic)
end)
