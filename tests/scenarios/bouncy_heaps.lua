-- bouncy_heaps.lua: where blows are not located in time, what bounces makes no energy.
--
-- Bounces were struck off the approaches that the solve began with, guessed impulses of the substep before included. A guess that is far
-- off, as after a blow, drives together what is parting; the solve took the guess back, but not the bounce.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- Numbers in [0, 1) (Park, Miller 1988)
local function dice(seed)
  local state = seed
  return function(low, high)
    state = state * 48271 % 2147483647
    return low + (high - low) * state / 2147483647
  end
end

local shapes = {
  function(s, d) return "ball", { radius = s / 2 * d(0.6, 1) } end,
  function(s, d) return "box", { size = { s * d(0.5, 1), s * d(0.5, 1), s * d(0.5, 1) } } end,
  function(s) return "capsule", { radius = s / 4, length = s / 2 } end,
  function(s, d) return "cylinder", { radius = s / 2 * d(0.5, 1), height = s * d(0.3, 1) } end,
}

local function heap(world, count, seed, spread)
  local d = dice(seed)
  world:floor { friction = 0.6 }
  for _, n in ipairs { { 1, 0 }, { -1, 0 }, { 0, 1 }, { 0, -1 } } do world:plane { normal = { n[1], 0, n[2] }, offset = -1 } end
  for i = 0, count - 1 do
    local kind, fields = shapes[1 + math.floor(d(0, 4))](0.3, d)
    fields.at = { 0.4 * (i % 4) - 0.6 + d(-0.02, 0.02), 0.3 + 0.4 * (i // 16), 0.4 * (i // 4 % 4) - 0.6 }
    fields.friction, fields.restitution, fields.density = d(0.1, 1), d(0.3, 1), 1000 * 10 ^ d(-spread, spread)
    fields.velocity = { d(-2, 2), d(-2, 2), d(-2, 2) }
    world[kind](world, fields)
  end
end

-- J  The most that was made in a frame, and the most that moved
local function made(world, seconds)
  local worst, most, before = 0, 0, nil
  for _ = 1, math.floor(seconds / world.frame + 0.5) do
    world:step()
    local e = world.energy
    local made_up = e.total - e.initial - e.work_in
    worst, most, before = math.max(worst, made_up - (before or made_up)), math.max(most, e.kinetic), made_up
  end
  return worst, most
end

for _, case in ipairs { { 50, 1, 0.5 }, { 60, 2, 1.5 }, { 64, 3, 1.5 }, { 72, 4, 0.5 }, { 80, 5, 1.5 } } do
  local count, seed, spread = table.unpack(case)
  scenario(("%d things that bounce and rub make no energy as they fall (densities apart by 10^%g)"):format(count, 2 * spread), function(s)
    local world = s:world {}
    heap(world, count, seed, spread)
    local worst, most = made(world, 1.2)
    expect(worst / most):below(1e-3)
  end)
end

-- A blow is handed to and fro between boxes that bounce on each other; each is solved to the last digit where tracing follows them.
for _, mu in ipairs { 0.1, 0.5, 1 } do
  scenario(("stacks of five that bounce, on a plate that tilts, take no frame of 200,000 sweeps (friction %g)"):format(mu), function(s)
    local world = s:world {}
    local plate = world:box { kinematic = true, size = { 6, 0.2, 1.5 }, at = { 0, 1, 0 }, friction = mu }
    for stack = -1, 1 do
      for i = 1, 5 do world:box { size = 0.3, mass = 1, friction = mu, restitution = 0.5, at = { 0.8 * stack, 0.95 + 0.3 * i, 0 } } end
    end
    world:step(12)
    plate:move_to { at = { 0, 1, 0 }, rotation = digbox.quat { axis = { 0, 0, 1 }, angle = "1.7 deg" }, over = 0.5 }
    local most, highest = 0, 0
    for _ = 1, 60 do
      local before = world.energy
      world:step()
      local after = world.energy
      most = math.max(most, world:stats().iterations)
      highest = math.max(highest, after.total - after.work_in - before.total + before.work_in)
    end
    expect(most):below(30000)
    expect(highest):below(2e-3 * 15 * 9.81 * 0.3)       -- of their weight times their size
  end)
end
