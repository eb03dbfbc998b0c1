-- tests/scenarios/wrecked_stacks.lua - a heavy ball flies into stacks of things of many masses and shapes.
--
-- Dozens of blows and edges in a frame leave slivers of substeps, of 1e-18 s by the rounding of sums of times. What a gap may close with in
-- such a one is any speed; the numbers of it once took all digits of the solve, and the stacks flew apart with ten times the ball's energy
-- (160 to 400 kJ in one frame for three of seven speeds of the ball from 11 to 15 m/s; 0.15 kJ since, where what overlaps is lifted).
local test = require "digbox.test"

local HULL = { { -0.3, -0.15, -0.3 }, { 0.3, -0.15, -0.3 }, { 0.3, -0.15, 0.3 }, { -0.3, -0.15, 0.3 },
               { -0.25, 0.15, -0.25 }, { 0.25, 0.15, -0.25 }, { 0.25, 0.15, 0.25 }, { -0.25, 0.15, 0.25 } }

-- Eight things one on the other, of which make(i, at) makes the i-th.
local function stack(x, make)
  for i = 0, 7 do make(i, { x, 0.15 + 0.3 * i, 0 }) end
end

local function stacks(world)
  stack(3, function(i, at) world:cylinder { radius = 0.3, height = 0.3, at = at, mass = 10 * 2 ^ i } end)
  stack(4.5, function(_, at) world:hull { points = HULL, at = at, mass = 10 } end)
  stack(6, function(i, at)
    local long = i % 2 == 0
    world:box { size = { long and 1.2 or 0.3, 0.3, long and 0.3 or 1.2 }, at = at, mass = 10 }
  end)
end

test.scenario("a heavy ball through three stacks brings all the energy there is", function(s)
  local world = s:world {}
  world:floor { friction = 0.6 }
  stacks(world)
  local ball = world:ball { radius = 0.4, mass = 300, at = { 1, 1.2, 0 }, velocity = { 13, 2, 0 } }
  local brought, last, fastest = ball.energy, world.energy.total, 0
  for _ = 1, 100 do
    world:step()
    local now = world.energy.total
    test.expect(now - last):below(0.01 * brought)
    last = now
    for _, body in ipairs(world:bodies()) do fastest = math.max(fastest, body.speed) end
  end
  test.expect(fastest):below(1.02 * math.sqrt(13 ^ 2 + 2 ^ 2))
  test.expect(#world:warnings()):near(0, 0)
end)
