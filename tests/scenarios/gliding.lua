-- One body that slides, rolls or flies on: a step of it needs one evaluation, and is exact; and nothing that ends it is overlooked.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- Ball and floor are near enough to be a pair in every step. Steps without a blow are flights, each from its start alone.
scenario("a ball that bounces needs one evaluation in all steps without a blow but those just before one", function()
  local world = digbox.world {}
  world:floor { restitution = 1 }
  local ball, blows, more = world:ball { radius = 0.5, restitution = 1, at = { 0, 0.6, 0 } }, 0, 0
  ball:on("contact_begin", function() blows = blows + 1 end)
  for k = 1, 240 do
    world:step()
    more = more + (world:stats().evaluations > 1 and 1 or 0)
  end
  local half = math.sqrt(2 * 0.1 / 9.81)
  local t = (4 + half) % (2 * half) - half              -- after the last top
  expect(blows):is(math.floor((4 + half) / (2 * half)))
  expect(ball.position.y):near(0.6 - 9.81 * t * t / 2, 1e-11)
  expect(more):at_most(2 * blows)
end)

scenario("who flies just over a floor lands when it gets there", function()
  for i = 1, 20 do
    local world = digbox.world {}
    world:floor { restitution = 0 }
    local height, landed = 0.001 * i * i, nil
    local ball = world:ball { radius = 0.1, restitution = 0, at = { 0, 0.1 + height, 0 }, velocity = { 1, 0.3, 0 } }
    ball:on("contact_begin", function(e) landed = landed or e.time end)
    world:run "1 s"
    expect(landed):near((0.3 + math.sqrt(0.09 + 2 * 9.81 * height)) / 9.81, 1e-9)
    expect(ball.position.y):near(0.1, 1e-9)
  end
end)
