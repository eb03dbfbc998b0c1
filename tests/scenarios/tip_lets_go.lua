-- tests/scenarios/tip_lets_go.lua - a rod that spins about its tip on the floor: held there, the tip would pull; let go, it would sink.
--
-- Between the two it slips: the friction that would hold it is more than its cone has. Looked for by letting go and taking hold alone,
-- there was no agreement, and the place was passed by a step of low order.
local digbox = require "digbox"
local test = require "digbox.test"
local expect = test.expect

local function spinning_rod(world, pull)
  local length, radius, tilt = 1, 0.01, math.rad(30)
  world:floor { friction = 0.6 }
  -- Of a rod: held, N / m = g (1 - 3/4 cos^2 tilt) - w^2 l/2 sin tilt, and the free tip sinks with g - w^2 l/2 sin tilt
  local w = math.sqrt(pull * 9.80665 / (length / 2 * math.sin(tilt)))
  local along = digbox.vec(math.cos(tilt), math.sin(tilt), 0)
  local at = along * (length / 2) + digbox.vec(0, radius, 0)
  return world:capsule { radius = radius, length = length, mass = 1, friction = 0.6, at = at,
    rotation = { axis = { 0, 0, 1 }, angle = tilt - math.pi / 2 }, spin = { 0, 0, -w }, velocity = { w * at.y, -w * at.x, 0 } }
end

test.scenario("the tip of a spinning rod slips where it can neither stick nor part", function(s)
  for _, pull in ipairs { 0.55, 0.7, 0.85 } do
    local world = s:world { accuracy = "study" }
    spinning_rod(world, pull)
    world:step(3)
    expect(world:stats().gave_up, "places passed"):is(0)
    expect(world:stats().traced, "traced"):above(0)
    expect(world.energy.lost, "J that friction took"):above(0)
    expect(world.energy.numerical, "J from nowhere"):near(0, 1e-6)
  end
end)
