-- brick_walls.lua: a wall of bricks that balls strike loses some of them, and what is left of it comes to rest.
-- Only in the plain build: figures of long runs; wrecked_stacks.lua and test_crowd.c run the same code under sanitizers.
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- Rows of ten bricks with gaps between them, every other row shifted by half a brick; three balls of the weight of a brick at up to 25 m/s.
local function wall(s, seed, rows, friction, restitution)
  local world = s:world { seed = seed }
  local function between(low, high) return low + (high - low) * math.random() end
  world:floor { friction = friction, restitution = restitution }
  local bricks = {}
  for y = 0, rows - 1 do
    for x = 0, 9 do
      local at = { -1.2 + 0.26 * x + y % 2 * 0.125, 0.125 + 0.25 * y, 0 }
      bricks[#bricks + 1] = world:box { size = { 0.2475, 0.25, 0.25 }, at = at, mass = 5, friction = friction, restitution = restitution }
    end
  end
  for i = 1, 3 do
    local at, velocity = { between(-0.5, 0.5), between(0.5, 2.5), 1.5 + 0.1 * i }, { 0, 0, -between(5, 25) }
    world:ball { at = at, velocity = velocity, radius = 0.2, mass = 5, friction = friction, restitution = restitution }
  end
  return world, bricks
end

-- Of 64 such walls (12 and 16 rows, friction 0.5 and 1, restitution 0 and 0.3) over 1 J was made up in a frame in 14, up to 478 of 12,000,
-- mostly where they fall over. Known to fail: three of them still make up up to 19 J.
local stand = { { 1, 12, 0.5, 0 }, { 2, 12, 0.5, 0 }, { 3, 12, 0.5, 0 }, { 4, 12, 0.5, 0 }, { 1, 12, 1, 0 }, { 1, 12, 0.5, 0.3 } }

-- J  The most that was made up in a frame in the three seconds after three.
local function most_made(world)
  world:run "3 s"
  local before, rise = world.energy.total, 0
  for _ = 1, 180 do
    world:step()
    local now = world.energy.total
    rise, before = math.max(rise, now - before), now
  end
  return rise
end

for _, case in ipairs(stand) do
  local seed, rows, friction, restitution = table.unpack(case)
  local name = "a wall of %d rows that is struck comes to rest: seed %d, friction %g, restitution %g"
  scenario(name:format(rows, seed, friction, restitution), function(s)
    local world, bricks = wall(s, seed, rows, friction, restitution)
    expect(most_made(world)):below "1 J"          -- what a row of bricks gains when its overlap is put right is 0.27 J
    local moving = 0
    for _, b in ipairs(bricks) do moving = moving + (b.speed > 0.01 and 1 or 0) end
    expect(moving):at_most(4)         -- one that has rolled off may still rock
  end)
end

-- These made up 113, 197, 29, 199, 333 and 35 J: all that had sagged was lifted by rows as hard as one corner needed. One of them makes
-- up 16 J still (the worst of the 64: 19).
local thrown = { { 7, 12, 0.5, 0 }, { 2, 16, 0.5, 0 }, { 4, 16, 0.5, 0 }, { 7, 16, 0.5, 0 }, { 6, 12, 0.5, 0.3 }, { 10, 16, 1, 0.3 } }
scenario("walls that balls strike are not thrown up, falling or not", function(s)
  local over = 0
  for _, case in ipairs(thrown) do
    local made = most_made((wall(s, table.unpack(case))))
    expect(made):below "25 J"
    over = over + (made > 1 and 1 or 0)
  end
  expect(over):at_most(1)
end)
