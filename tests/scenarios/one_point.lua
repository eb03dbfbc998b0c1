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
  world = digbox.world { gravity = { 0, 0, 0 } }
  local pin = world:box { fixed = true, size = 0.02, collides = false }
  pendulums(world, pin)
  world:step()
  expect(world:stats().contacts):is(0)
  pin:remove()
  world:step()
  expect(world:stats().contacts):above(0)
end)

scenario("a world that is saved and loaded knows what is held at one point", function()
  local world, file = digbox.world { gravity = { 0, 0, 0 } }, "one_point.dig"
  pendulums(world)
  world:save(file)
  world = digbox.load(file)
  world:step()
  expect(world:stats().contacts):is(0)
end)

-- Legs of which the ends miss the top by 5 mm, and links of a chain that hangs there with 300 kg on it
scenario("legs and links that end before the point that holds them do not press each other", function()
  local world, apex = digbox.world {}, digbox.vec(0, 2, 0)
  world:floor { friction = 0.7 }
  local hub = world:ball { radius = 0.08, mass = 1, at = apex }
  for k = 0, 2 do
    local foot = digbox.vec(math.cos(k * 2.0944), 0.05, math.sin(k * 2.0944))
    local length = #(apex - foot)
    local turned = digbox.quat { from = { 0, 1, 0 }, to = apex - foot }
    local leg = world:capsule { radius = 0.05, length = length - 0.11, mass = 3, at = (apex + foot) / 2, rotation = turned }
    world:weld { a = leg, b = hub, at = apex }
  end
  local last, tip = hub, apex
  for _ = 1, 3 do
    local link = world:capsule { radius = 0.03, length = 0.22, mass = 0.2, at = tip - digbox.vec(0, 0.15, 0) }
    world:ball_joint { a = link, b = last, at = tip }
    last, tip = link, tip - digbox.vec(0, 0.3, 0)
  end
  local load = world:box { size = 0.4, mass = 300, at = tip - digbox.vec(0, 0.2, 0) }
  world:ball_joint { a = load, b = last, at = tip }
  world:run "2 s"
  local stats = world:stats()
  expect(hub.position.y):near(2, 0.06)                  -- its feet are 5 cm above the floor at first
  expect(stats.worst_joint_error):below(1e-3)           -- 0.2 m, and it fell to pieces, when only what reached the point was let be
  expect(stats.worst_penetration):below(1e-3)
  expect(world.energy.numerical):near(0, 0.1)           -- J; 76 to 281 then
end)

scenario("balls that hang side by side from one pin touch", function()
  local world = digbox.world {}
  local balls = {}
  for k = -1, 1, 2 do
    local turn = digbox.quat { axis = { 0, 0, 1 }, angle = 0.9 * k }
    balls[#balls + 1] = world:ball { radius = 0.1, mass = 1, at = turn:rotate { 0, -0.15, 0 } }
    world:ball_joint { a = balls[#balls], at = { 0, 0, 0 } }
  end
  world:run "2 s"
  expect(#(balls[1].position - balls[2].position)):near(0.2, 1e-3)
end)
