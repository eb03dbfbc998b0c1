-- What is laid into each other parts without a force between: nobody knows where it would press (engine/solve/idle.c).
local test = require "digbox.test"

-- Within 1 s: sweeps of all steps, and the most speed, m/s.
local function part(world, bodies)
  local sweeps, most = 0, 0
  for _ = 1, 60 do
    world:step()
    sweeps = sweeps + world:stats().iterations
    for _, b in ipairs(bodies) do most = math.max(most, b.speed) end
  end
  return sweeps, most
end

-- 28,600 sweeps when the blow of each box that lands pressed it against its neighbours, and that stress went on from substep to substep.
test.scenario("eight boxes in one place come apart in few sweeps, unturned", function(s)
  local world, boxes = s.world, {}
  world:floor { friction = 0.6 }
  for i = 1, 8 do
    local d = 0.05 * (i - 1)
    boxes[i] = world:box { size = 1, mass = 1, friction = 0.6, at = { d, 0.5 + d, d } }
  end
  local sweeps, speed = part(world, boxes)
  test.expect(sweeps):below(2000)
  test.expect(speed):below(2.7)               -- m/s, of a fall by 0.35 m
  test.expect(world:stats().penetration):below(1e-9)
  for _, b in ipairs(boxes) do
    test.expect(b.position.y):near(0.5, 1e-6)
    test.expect(math.abs(b.rotation.w)):above(1 - 1e-9)
  end
end)
