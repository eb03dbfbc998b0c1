-- tests/scenarios/full_buckets.lua - balls poured into a bucket that could move come to rest, and cost what little they do.
--
-- Each ball rolls and slides on others and on a wall that tilts a little: the direct solve of such contacts has to follow how fast each
-- slips. Where it did so by half the way in a round, most substeps failed, after 60 to 150 factorisations each.
-- Only in the plain build: figures of long runs; the worlds with buckets run the same code under sanitizers.
local test = require "digbox.test"
local expect = test.expect

-- Poured from `seed`, each ball's density up to e^spread squared times that of water or as much less. Returns bucket, balls.
local function pour(world, count, spread, seed)
  world:floor { material = "tile" }
  local bucket = world:bucket { name = "bucket", material = "tin", height = 0.4, top_radius = 0.22, bottom_radius = 0.16, wall = 0.004 }
  local state = seed * 7919
  local function chance()
    state = (state * 1103515245 + 12345) % 2147483648
    return state / 2147483648
  end
  local balls = {}
  for i = 1, count do
    local dense = math.exp(spread * (2 * chance() - 1))
    balls[i] = world:ball { radius = 0.03 + 0.01 * chance(), density = 1000 * dense ^ 2, material = "rubber",
      at = { 0.08 * (2 * chance() - 1), 0.1 + 0.09 * i, 0.08 * (2 * chance() - 1) } }
  end
  return bucket, balls
end

for _, case in ipairs {         -- factorisations measured: 15,000 now and 72,000 before, 28,000 and 68,000, 33,000 and 99,000
  { count = 15, spread = 0, seed = 2, factors = 30000 },
  { count = 15, spread = 1.5, seed = 3, factors = 45000 },
  { count = 30, spread = 0, seed = 1, factors = 50000 },
} do
  local title = ("%d balls in a bucket, densities %.0f to 1"):format(case.count, math.exp(4 * case.spread))
  test.scenario(title, function(s)
    local world = s.world
    local bucket, balls = pour(world, case.count, case.spread, case.seed)
    local factors = 0
    for _ = 1, 180 do
      world:step()
      factors = factors + world:stats().factors
    end
    for _, ball in ipairs(balls) do
      expect(bucket:contains(ball)):is(true)
      expect(ball.speed):below(1e-3)
    end
    expect(math.abs(world.energy.numerical)):below(3e-4 * world.energy.lost)
    expect(factors):below(case.factors)
  end)
end
