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
