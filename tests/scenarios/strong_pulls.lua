-- strong_pulls.lua: what is pushed hard within one frame gets nowhere that nobody looked: a plate stops it.

local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- A ball of 1 kg at the origin, 0.875 m from a plate of 5 cm; the push alone would take it far beyond within a frame.
local function plate(world) world:box { name = "plate", fixed = true, size = { 0.05, 4, 4 }, at = { 1, 0, 0 } } end

for _, accuracy in ipairs { "sketch", "play", "study" } do
  for _, force in ipairs { 1e4, 1e5, 1e6 } do
    scenario(("at %s a push of %g N does not send a ball through a plate"):format(accuracy, force), function(s)
      local world = s:world { gravity = { 0, 0, 0 }, accuracy = accuracy }
      plate(world)
      local ball = world:ball { radius = 0.1, mass = 1 }
      ball:push { force = { force, 0, 0 }, lasts = 0.05 }
      for _ = 1, 12 do
        world:step()
        expect(ball.position.x):below(0.9)
      end
    end)
  end

  scenario(("at %s neither a heavy share of gravity nor that of a region does"):format(accuracy), function(s)
    local world = s:world { accuracy = accuracy, gravity = { -9.81, 0, 0 } }
    plate(world)
    local ball = world:ball { radius = 0.1, mass = 1, gravity_scale = -900 }
    world:run(0.1)
    expect(ball.position.x):below(0.9)
    world = s:world { accuracy = accuracy, gravity = { 0, 0, 0 } }
    plate(world)
    ball = world:ball { radius = 0.1, mass = 1 }
    world:region { box = { size = { 10, 10, 10 } }, laws = { gravity = { 9000, 0, 0 } } }
    world:run(0.1)
    expect(ball.position.x):below(0.9)
  end)
end

-- Half a ton swings on a rope of ten rods of 0.1 kg as its crane starts down: the rope goes slack and is all but straight when it is taut
-- again. What sweeps left of its joints was taken for impossible after 12 iterations, where 14 put it right: 2e10 J, and nothing finite.
test.scenario("a crane lets half a ton down by a light rope", function(s)
  local world = s.world
  local load = world:box { size = 1, mass = 500, at = { 5.5, 2.5, 0 }, velocity = { 0.7, 0, 0 } }
  local crane = world:box { kinematic = true, size = 0.3, at = { 5.5, 6, 0 } }
  world:rope { a = crane, b = load, at = { 5.5, 5.85, 0 }, to = { 5.5, 3, 0 }, segments = 10, radius = 0.015, mass = 1 }
  world:run "1 s"
  crane:drive { velocity = { 0, -1, 0 } }
  world:run "4 s"
  test.expect(world.energy.numerical):near(0, 20)
  test.expect((load.position - crane.position):length()):near(3.5, 0.02)
  test.expect(#world:warnings()):is(0)
end)
