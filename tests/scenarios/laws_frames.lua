-- laws_frames.lua: small scenes of one or two bodies do the same whatever the frame: what happens within one is found there, and none is
-- given up.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local function turn(axis, angle) return digbox.quat { axis = axis, angle = angle } end

-- make(world) returns the bodies that are looked at. After `time` seconds in steps of 1/30, 1/60 and 1/240 s their middles are within
-- `near` metres of each other, no step was swept (or no more than `swept`) and nothing made energy up.
local function alike(time, near, make, swept)
  local first
  for _, rate in ipairs { 240, 60, 30 } do
    local world = digbox.world { step = 1 / rate }
    local bodies, places = make(world), {}
    for _ = 1, math.floor(time * rate + 0.5) do world:step() end
    for i, body in ipairs(bodies) do places[i] = body.centre end
    first = first or places
    for i, at in ipairs(places) do expect((at - first[i]):length()):at_most(near) end
    expect(world:stats().all_swept):at_most(swept or 0)
    expect(world.energy.numerical):at_most(1e-6 * math.abs(world.energy.total))
  end
end

-- The last of what its edge presses on the wall goes from both corners at once; one at a time they took each other's load in turn.
scenario("a ladder that slides down a wall leaves it with both its corners", function()
  for _, case in ipairs { { 0.031, 1.58, 1.025 }, { 0.0685, 1.036, 1.2237 }, { 0.1, 1.3, 1.1 } } do
    alike(0.9, 1e-5, function(world)
      local mu, length, angle, thick = case[1], case[2], case[3], 0.04
      world:floor { friction = mu }
      world:plane { normal = { 1, 0, 0 }, friction = mu }
      local x, y = math.cos(angle), math.sin(angle)
      return { world:box { size = { length, thick, 0.3 }, rotation = turn({ 0, 0, 1 }, math.pi - angle), friction = mu,
                           at = { length / 2 * x + thick / 2 * y, length / 2 * y + thick / 2 * x, 0 } } }
    end)
  end
end)

-- What pushes has the box at the bound of its friction, where it stays, and shares its load with the table in more than one way. Over the
-- edge it tips with nothing but its rear edge on the table, and leans on what pushes when that comes off.
scenario("a box that is pushed off a table leaves it when its rear edge does", function()
  for _, case in ipairs { { 1.33, 170, 0.15 }, { 1.87, 128, 0.1945 }, { 1.82, 135, 0.2736 } } do
    alike(0.9, 2e-5, function(world)
      world:box { fixed = true, size = { 2, 1, 1 }, at = { -1, 0.5, 0 }, friction = 0.4 }
      local pusher = world:box { size = { 0.1, 0.2, 0.3 }, at = { -0.9, 1.11, 0 }, friction = 0.2 }
      world:slider { a = pusher, axis = { 1, 0, 0 }, motor = { speed = case[1], max_force = case[2] } }
      return { pusher, world:box { size = { 0.2, case[3], 0.2 }, at = { -0.5, 1 + case[3] / 2, 0 }, friction = 0.4 } }
    end)
  end
end)

-- Friction at its bound slides from there on; through a step on the brink it had one direction whatever the box did.
scenario("a box on a plank that tips begins to slide when it must", function()
  for _, case in ipairs { { -0.2491, 0.0997, 1.2062, 0.3742 }, { -0.23, -0.0027, 1.4023, 0.2661 } } do
    alike(0.9, 2e-5, function(world)
      world:box { fixed = true, size = { 1, 1, 1 }, at = { -0.5, 0.5, 0 }, friction = 0.5 }
      local plank = world:box { size = { 1, 0.05, 0.3 }, at = { case[1], 1.025, 0 }, friction = 0.5, density = 500 }
      return { plank, world:box { size = 0.12, at = { case[2], 1.11, 0 }, velocity = { case[3], 0, 0 }, friction = case[4] } }
    end)
  end
end)

-- From rest its slip got so fast within one step that it had to turn, and was held in its direction to the end.
scenario("a cylinder that tumbles slips the way its friction lets it", function()
  alike(1.2, 2e-5, function(world)
    world:floor { friction = 0.4029 }
    return { world:cylinder { radius = 0.1, height = 0.24728, at = { 0, 0.36803, 0 }, rotation = turn({ -0.47894, 0.59578, 1 }, 1.24157),
                              velocity = { 0.99341, 0, 0.37252 }, spin = { -2.39419, -1.81361, -4.59104 },
                              friction = 0.0763, restitution = 0 } }
  end)
end)

-- At the end of a step too long edges lie so deep in each other that they seem to cross elsewhere. That step is halved.
scenario("boxes that turn and meet in the air are followed to where they do", function()
  alike(0.6, 1e-5, function(world)
    world.gravity = { 0, 0, 0 }
    local first = world:box { size = { 0.3, 0.2, 0.1 }, rotation = turn({ 0.9923, -0.4292, 1 }, 2.9574),
                              spin = { 0.7998, -0.3105, 0.8318 }, friction = 0.4, restitution = 0 }
    return { first, world:box { size = { 0.2, 0.2, 0.3 }, at = { 0.8, 0.0375, 0.0982 }, rotation = turn({ -0.2786, 0.3147, 1 }, 0.1997),
                                velocity = { -1.9344, 0, 0 }, friction = 0.4, restitution = 0 } }
  end)
end)

-- They touch without a force, and what friction does by that has no direction. (Where that force comes to nothing, rounding of what
-- the axles bear may hide it: 3 steps, where it was 47.)
scenario("wheels on a gear that also touch turn on", function()
  alike(0.25, 1e-5, function(world)
    local first = world:cylinder { radius = 0.2, height = 0.05, rotation = turn({ 1, 0, 0 }, math.pi / 2), spin = { 0, 0, 14 } }
    local second = world:cylinder { radius = 0.3, height = 0.05, at = { 0.5, 0, 0 }, rotation = turn({ 1, 0, 0 }, math.pi / 2) }
    local axle = world:hinge { a = first, axis = { 0, 0, 1 } }
    world:gear { a = axle, b = world:hinge { a = second, at = { 0.5, 0, 0 }, axis = { 0, 0, 1 }, limits = { -2.8, 6 } }, ratio = { 2, -3 } }
    return { first, second }
  end, 4)
end)

-- A slip that starts has a little speed left the other way, which is gone before that could be seen. It was taken to end there, again and
-- again.
scenario("what begins to slip may come from the other side", function()
  local world = digbox.world { step = 1 / 240 }
  world:floor { friction = 0.27411 }
  world:cylinder { radius = 0.1, height = 0.1188, at = { 0, 0.70463, 0 }, rotation = turn({ 0.98102, -0.14533, 1 }, 1.48737),
                   velocity = { 1.05755, 0, -0.27024 }, spin = { -4.63329, 3.9157, -3.29944 }, friction = 0.6755, restitution = 0 }
  for _ = 1, 216 do world:step() end
  expect(world:stats().all_swept):is(0)
  expect(world.energy.numerical):at_most(1e-6 * math.abs(world.energy.total))
end)

-- The slips of a coin that begins to slide are slow for long, and turn all the while: they follow their forces before the frame is given
-- up.
scenario("a coin that spins on its edge is followed as it starts to slide", function()
  for _, case in ipairs { { 0.198, 0.0146, 0.6823, 0.22516, 29.5234, -0.13267, 0.004 },
                          { 0.30145, 0.01503, 0.2975, 0.48278, 30.4374, 0.0745, 0 } } do
    for _, rate in ipairs { 240, 60, 30 } do
      local world = digbox.world { step = 1 / rate }
      local radius, tilt = case[2], case[4]
      local height = radius * case[3]
      world:floor { friction = case[1], rolling_friction = 0.004 }
      world:cylinder { radius = radius, height = height, friction = 0.3, rolling_friction = case[7], spin = { 0, case[5], 0 },
                       at = { 0, radius * math.cos(tilt) + height / 2 * math.sin(tilt) + 1e-6, 0 }, velocity = { case[6], 0, 0 },
                       rotation = turn({ 1, 0, 0 }, math.pi / 2 - tilt) }
      for _ = 1, math.floor(1.5 * rate + 0.5) do world:step() end
      expect(world:stats().all_swept):is(0)
      expect(world.energy.numerical):at_most(1e-6 * math.abs(world.energy.total))
    end
  end
end)

-- Where that is of no use the step is tried as it was before, not from one so much longer down.
scenario("a step in which slips follow their forces may fail without much ado", function()
  local world = digbox.world { step = 1 / 30 }
  world:floor { friction = 0.5469 }
  world:cylinder { radius = 0.13928, height = 0.2, at = { 0, 0.25, 0 }, rotation = turn({ 0.73622, 0, 0.12065 }, 0.07388),
                   spin = { -0.53364, 8.17392, -0.0551 }, velocity = { 0.02148, 0, 0 }, friction = 0.12397 }
  for _ = 1, 45 do world:step() end
  expect(world:stats().all_swept):is(0)
end)

-- How long a step may hold the direction of a slip goes with the accuracy: it was a part of the frame, whatever that.
scenario("a finer accuracy follows a slip from rest finer", function()
  for _, case in ipairs { { "study", 1e-6 }, { "reference", 1e-8 } } do
    local first
    for _, rate in ipairs { 240, 60, 30 } do
      local world = digbox.world { step = 1 / rate, accuracy = case[1] }
      local radius, height, tilt = 0.19738, 0.06517, 0.52259
      world:floor { friction = 0.20187 }
      local disc = world:cylinder { radius = radius, height = height, friction = 0.3, spin = { 0, 10.41193, 0 },
                                    at = { 0, radius * math.cos(tilt) + height / 2 * math.sin(tilt) + 1e-6, 0 },
                                    velocity = { -0.11779, 0, 0 }, rotation = turn({ 1, 0, 0 }, math.pi / 2 - tilt) }
      for _ = 1, math.floor(1.5 * rate + 0.5) do world:step() end
      first = first or disc.centre
      expect((disc.centre - first):length()):at_most(case[2])
    end
  end
end)
