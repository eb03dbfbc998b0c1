-- spinning_eggs.lua: two balls in one, which spin fast on a floor, stepped by rows as they are in company.
--
-- The place where a ball touches turns with the body when it is beside the centre of mass, though the floor's normal does not. Rows at the
-- start of a substep pressed behind where the ball went, and the spin grew: from 200 to 600 rad/s in 10 s at 2 mm.
local digbox = require "digbox"
local test = require "digbox.test"
local expect = test.expect

local function egg(world, k, x, spin, way)
  return world:body { parts = { digbox.sphere { radius = 0.04 * k }, digbox.sphere { radius = 0.03 * k, at = { 0.04 * k, 0, 0 } } },
                      at = { x, 0.045 * k, 0 }, spin = { 0, spin, 0 }, friction = 0.4, integrator = way }
end

-- J over J at the start, after ten seconds
local function kept(s, k, spin, way, rate)
  local world = s:world { step = 1 / rate }
  world:floor { friction = 0.3 }
  egg(world, k, 0, spin, way)
  local start = world.energy.total
  world:run(10)
  return world.energy.total / start
end

for _, case in ipairs { { 1, 28 }, { 1, 60 }, { 1, 120 }, { 0.02, 200 } } do
  local k, spin = case[1], case[2]
  test.scenario(("an egg of %g mm that spins at %g rad/s keeps its energy, swept as traced"):format(110 * k, spin), function(s)
    local exact = kept(s, k, spin, "auto", 60)
    expect(exact):between(0.88, 0.93)
    for _, rate in ipairs { 30, 60 } do expect(kept(s, k, spin, "verlet", rate)):near(exact, 0.02) end    -- 1.03 to 3.9 before
  end)
end

test.scenario("an egg that spins between tops gains no energy", function(s)
  local world = s:world {}
  world:floor { friction = 0.3 }
  local mine, last = egg(world, 0.02, 0, 140), nil
  for i = 1, 3 do
    world:cone { radius = 1e-3, height = 2e-3, at = { 8e-3 * i, 1.6e-3, 0 }, rotation = { axis = { 1, 0, 0 }, angle = 3 },
                 spin = { 0, 400, 0 }, friction = 0.3 }
  end
  for second = 1, 10 do
    world:run(1)
    local now = mine.energy
    if second > 1 then expect(now):below(1.002 * last) end         -- 1.0011 at most
    last = now
  end
  expect(#mine.spin):below(140)
end)
