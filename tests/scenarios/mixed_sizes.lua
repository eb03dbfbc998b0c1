-- tests/scenarios/mixed_sizes.lua - heaps of large and small things cost about what heaps of alike things do.
--
-- What is large is heavy: of one density a box four times as wide has 64 times the mass. Groups with masses of over 30:1 were no crowds
-- and were solved at once in each substep: 200 boxes for 54 s instead of 3, for a heap no better to look at (engine/step/groups.c).
-- Only in the plain build: figures of long runs; heaps of alike things run the same code under sanitizers.
local test = require "digbox.test"
local expect = test.expect

-- Numbers of [0, 1).
local function chances(seed)
  local state = seed * 7919
  return function()
    state = (state * 1103515245 + 12345) % 2147483648
    return state / 2147483648
  end
end

-- Pours things of sizes from `least` to 0.45 m into a pit. Returns them.
local function pour(world, kind, count, least, seed)
  world:floor {}
  for i = 0, 3 do
    local x, z = math.cos(i * math.pi / 2), math.sin(i * math.pi / 2)
    world:box { size = { 0.2 + 3.4 * math.abs(z), 6, 0.2 + 3.4 * math.abs(x) }, at = { 1.7 * x, 3, 1.7 * z }, fixed = true }
  end
  local chance, things = chances(seed), {}
  for i = 1, count do
    local size, at = least + (0.45 - least) * chance(), { 2.3 * (chance() - 0.5), 0.5 + 0.125 * i, 2.3 * (chance() - 0.5) }
    things[i] = kind == "boxes" and world:box { size = size, at = at } or world:ball { radius = size / 2, at = at }
  end
  return things
end

-- Runs for so many seconds. Returns the work of a step on average, m of the deepest overlap in the last second, what was made up on
-- the whole of the energy that there was, and how many still move.
local function watch(world, seconds, things)
  local r = { deep = 0, moving = 0 }
  local start, before, steps = world.energy.total, world:stats().work, 0
  while world.time < seconds do
    world:step()
    steps = steps + 1
    if world.time > seconds - 1 then r.deep = math.max(r.deep, world:stats().penetration) end
  end
  r.work = (world:stats().work - before) / steps
  r.made = world.energy.numerical / start
  for _, thing in ipairs(things) do r.moving = r.moving + (thing.speed > 0.05 and 1 or 0) end
  return r
end

-- Measured (before): work of a step 6.0e5 (38e5), 3.5e5 (47e5), 1.9e5 (33e5), and of boxes of 0.3 to 0.45 m 6.0e5; overlap at the end
-- 2.8, 2.9 and 0.07 mm, 9.3 of such boxes; made up 5e-4, 1.3e-4 and nothing.
for _, case in ipairs {
  { kind = "boxes", least = 0.1, seed = 1, work = 1.2e6 },
  { kind = "boxes", least = 0.05, seed = 2, work = 1.2e6 },
  { kind = "balls", least = 0.1, seed = 3, work = 5e5 },
} do
  test.scenario(("200 %s of %g to 0.45 m"):format(case.kind, case.least), function(s)
    local r = watch(s.world, 6, pour(s.world, case.kind, 200, case.least, case.seed))
    expect(r.work):below(case.work)
    expect(r.deep):below(0.01)
    expect(r.made):below(1e-3)
    expect(r.moving):below(3)
  end)
end

-- As a crowd it sank in by 0.4 to 53 mm, made up as much as 230 J a frame and did not lie still (in half of eight heaps).
for seed = 2, 3 do
  test.scenario(("a car body of 1500 kg drops on gravel of 8 to 14 cm (%d)"):format(seed), function(s)
    local world, chance, things = s.world, chances(seed), {}
    world:floor {}
    for i = 0, 3 do
      local x, z = math.cos(i * math.pi / 2), math.sin(i * math.pi / 2)
      world:box { size = { 0.1 + 2.2 * math.abs(z), 0.6, 0.1 + 2.2 * math.abs(x) }, at = { 1.1 * x, 0.3, 1.1 * z }, fixed = true }
    end
    for i = 1, 100 do
      things[i] = world:box { size = 0.08 + 0.06 * chance(), density = 2500,
        at = { 1.8 * (chance() - 0.5), 0.1 + 0.002 * i, 1.8 * (chance() - 0.5) } }
    end
    things[#things + 1] = world:box { size = { 1.2, 0.4, 0.8 }, mass = 1500, at = { 0, 2.5, 0 } }
    local r = watch(world, 4, things)
    expect(r.deep):below(1e-4)
    expect(r.made):below(1e-3)
    expect(r.moving):is(0)
  end)
end
