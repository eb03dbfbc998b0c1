-- What several joints hold at one point overlaps there, and does not touch: ropes at one hook, bars on one pin.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local function chandelier()
  local world = digbox.world {}
  local hub = world:ball { radius = 0.06, mass = 1, at = { 0, 2, 0 } }
  for k = 0, 2 do
    local a = k * 2.1
    world:rope { a = hub, at_b = { math.cos(a), 3, math.sin(a) }, segments = 6, mass = 0.05 }
  end
  return world, hub
end

scenario("three ropes hold a lamp at its centre, and do not press each other out of it", function()
  local world, hub = chandelier()
  world:run "2 s"
  expect(world:stats().worst_penetration):below(1e-12)
  expect(world.energy.numerical):near(0, 1e-9)          -- where rods touched they were 32 mm inside each other
  expect(hub.position):near({ 0, 2, 0 }, 0.02)
end)

-- Two rods of 1 m with bobs of 0.2 m at their ends, hung on one pin of the world or of a body
local function pendulums(world, pin, collides)
  local function rod(angle)
    local turn = digbox.quat { axis = { 0, 0, 1 }, angle = angle }
    local body = world:body {
      at = turn:rotate { 0, -0.5, 0 }, rotation = turn,
      parts = { digbox.box { size = { 0.04, 1, 0.04 }, density = 10 },
                digbox.sphere { radius = 0.1, at = { 0, -0.5, 0 }, density = 1000 } },
      restitution = 1, friction = 0 }
    return body, world:hinge { a = body, b = pin, at = { 0, 0, 0 }, axis = { 0, 0, 1 }, collides = collides }
  end
  local left, joint = rod(-0.6)
  return left, rod(0.6), joint
end

scenario("bobs of two pendulums on one pin strike each other, their rods do not", function()
  for _, on_body in ipairs { false, true } do
    local world = digbox.world {}
    local pin = on_body and world:box { fixed = true, size = 0.02 } or nil
    local left, right = pendulums(world, pin)
    local blows = 0
    world:on("impact", function() blows = blows + 1 end)
    world:run "2 s"
    expect(blows):at_least(2)
    expect(left.position.x):below(-0.04)
    expect(right.position.x):above(0.04)
    expect(world:stats().worst_penetration):below(1e-3)
    expect(world.energy.numerical):near(0, 1e-3)
  end
end)

scenario("they touch where their joints say so, and once one is gone", function()
  local world = digbox.world { gravity = { 0, 0, 0 } }
  pendulums(world, nil, true)
  world:step()
  expect(world:stats().contacts):above(0)
  world = digbox.world { gravity = { 0, 0, 0 } }
  local _, _, joint = pendulums(world)
  world:step()
  expect(world:stats().contacts):is(0)
  joint:remove()
  world:step()
  expect(world:stats().contacts):above(0)
end)
