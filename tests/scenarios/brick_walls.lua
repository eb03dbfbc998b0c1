-- brick_walls.lua: a wall of bricks that balls strike loses some of them, and what is left of it comes to rest.
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

-- Of 100 such walls (16 rows, friction 1, restitution 0.3, in a pen, too) 83 made up over 1 J in a frame over three seconds after they
-- were struck, up to 2350 J of their 8800, and 67 trembled on at the end. Known to fail: 20 of them still make up 1 to 860 J, and 12 stir.
local cases = { { 1, 12, 0.5, 0 }, { 2, 12, 0.5, 0 }, { 3, 12, 0.5, 0 }, { 4, 12, 0.5, 0 }, { 1, 12, 1, 0 }, { 1, 12, 0.5, 0.3 } }
for _, case in ipairs(cases) do
  local seed, rows, friction, restitution = table.unpack(case)
  local name = "a wall of %d rows that is struck comes to rest: seed %d, friction %g, restitution %g"
  scenario(name:format(rows, seed, friction, restitution), function(s)
    local world, bricks = wall(s, seed, rows, friction, restitution)
    world:run "3 s"
    local before, rise = world.energy.total, 0
    for _ = 1, 180 do
      world:step()
      local now = world.energy.total
      rise, before = math.max(rise, now - before), now
    end
    expect(rise):below "1 J"          -- what a row of bricks gains when its overlap is put right is 0.27 J
    local moving = 0
    for _, b in ipairs(bricks) do moving = moving + (b.speed > 0.01 and 1 or 0) end
    expect(moving):at_most(4)         -- one that has rolled off may still rock
  end)
end
