-- Heaps that a mover stirs are spared solves that come to nothing (engine/solve/toil.c), and behave all the same.
local digbox = require "digbox"
local test = require "digbox.test"

-- A bucket with forty of something in it, moved to and fro by 15 cm at 3 rad/s; what three seconds after the second one took.
local function shake(s, put)
  local world = s.world
  world:floor {}
  local bucket = world:bucket { height = 0.5, top_radius = 0.35, bottom_radius = 0.25, mass = 3, kinematic = true }
  for i = 0, 39 do put(world, { 0.12 * math.cos(2.4 * i), 0.2 + 0.05 * i, 0.12 * math.sin(2.4 * i) }, i) end
  local factors, deepest = 0, 0
  for frame = 1, 300 do
    bucket:move_to { at = { 0.15 * math.sin(frame / 20), 0, 0 }, over = 1 / 60 }
    world:step()
    local stats = world:stats()
    factors = factors + (frame > 120 and stats.factors or 0)
    deepest = math.max(deepest, stats.penetration)
  end
  local around = digbox.cylinder { radius = 0.4, height = 1, at = bucket.position + digbox.vec(0, 0.5, 0) }
  test.expect(#world:overlap(around)):is(42)      -- the bucket and the floor, too
  return factors / 180, deepest
end

-- Factorisations a frame: 214 before, 13 now, and 19 of the next ones.
test.scenario("forty balls in a bucket that is moved to and fro stay in it, and take few direct solves", function(s)
  local factors, deepest = shake(s, function(world, at) world:ball { radius = 0.04, at = at } end)
  test.expect(factors):below(30)
  test.expect(deepest):below(1e-3)
end)

test.scenario("so do forty balls of 0.05 to 6 kg", function(s)
  local factors, deepest = shake(s, function(world, at, i) world:ball { radius = 0.04, at = at, mass = 0.05 * 2 ^ (5 * i % 8) } end)
  test.expect(factors):below(30)
  test.expect(deepest):below(1e-3)
end)
