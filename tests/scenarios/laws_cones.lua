-- laws_cones.lua: ball joints with stops, the cone of their swing and the range of their twist: chains that lie on them, whip into them and
-- are flung from where they are straight, so that the swing has no direction yet. No stop is passed, and nothing is made up.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- Ten planks of 0.3 m in a row along x; joint(plank, before, at) for each, `first` before the first
local function row(world, first, joint)
  local list, before = {}, first
  for i = 1, 10 do
    local plank = world:box { size = { 0.3, 0.05, 0.2 }, mass = 0.5 * (i % 3 + 1), at = { 0.3 * (i - 0.5), 0, 0 }, collides = false }
    if before then joint(plank, before, { 0.3 * (i - 1), 0, 0 }) end
    before, list[i] = plank, plank
  end
  return list
end

local unturned = digbox.quat { axis = { 0, 1, 0 }, angle = 0 }

-- rad  The greatest angle between an axis of one and of the next; of all ten, the world before the first, or of all but that
local function swing(list, axis, grounded)
  local most = 0
  for i = grounded and 1 or 2, #list do
    local a, b = list[i].rotation:rotate(axis), (i > 1 and list[i - 1].rotation or unturned):rotate(axis)
    most = math.max(most, math.atan(#a:cross(b), a:dot(b)))
  end
  return most
end

-- rad  The greatest twist about z, grounded
local function twist(list)
  local most = 0
  for i = 1, #list do
    local a, b = list[i].rotation, i > 1 and list[i - 1].rotation or unturned
    local ua, va, ub, vb = a:rotate { 1, 0, 0 }, a:rotate { 0, 1, 0 }, b:rotate { 1, 0, 0 }, b:rotate { 0, 1, 0 }
    most = math.max(most, math.abs(math.atan(vb:dot(ua) - ub:dot(va), ub:dot(ua) + vb:dot(va))))
  end
  return most
end

-- run(open, per_second) with each accuracy and frame step; open{...} -> a world with these
local function each(title, accuracies, run)
  for _, per_second in ipairs { 30, 60 } do
    for _, accuracy in ipairs(accuracies) do
      scenario(("%s, 1/%d s [%s]"):format(title, per_second, accuracy), function(s)
        run(function(fields)
          fields.step, fields.accuracy, fields.sleeping = 1 / per_second, accuracy, false
          return s:world(fields)
        end, per_second)
      end)
    end
  end
end

-- They sway across their cones at 900 rad/s: 160 to 270 J were made up in 6 s, and they were 1 to 1.9 rad beyond
each("a row of planks lies on its narrow cones", { "sketch", "play" }, function(open, per_second)
  local world = open {}
  local list, most = row(world, world, function(a, b, at)
    world:ball_joint { a = a, b = b, at = at, axis = { 1, 0, 0 }, swing = 0.05 }
  end), 0
  for _ = 1, 3 * per_second do
    world:step()
    most = math.max(most, swing(list, { 1, 0, 0 }, true))
  end
  expect(most):below(0.05 + 1e-4)
  expect(world.energy.numerical):below(0.2)
end)

-- From straight: 0.24 rad beyond its cone in the first frame of 1/30 s, 0.03 in one of 1/60 s. Chains on hinges, too, lost 1e-3 of
-- 23 N m s at 1/30 s.
each("a straight chain that is flung finds its cones", { "play", "study" }, function(open, per_second)
  for _, kind in ipairs { "ball_joint", "hinge" } do
    local world = open { gravity = { 0, 0, 0 } }
    local list, most = row(world, nil, function(a, b, at)
      if kind == "hinge" then
        world:hinge { a = a, b = b, at = at, axis = { 0, 0, 1 }, limits = { -0.3, 0.3 } }
      else
        world:ball_joint { a = a, b = b, at = at, axis = { 1, 0, 0 }, swing = 0.3 }
      end
    end), 0
    list[10]:teleport { velocity = { 0, 8, 0 } }
    local before, kinetic = world.angular_momentum, world.energy.kinetic
    for _ = 1, per_second do
      world:step()
      most = math.max(most, swing(list, { 1, 0, 0 }))
    end
    expect(most):below(0.3 + 1e-4)
    expect(#(world.angular_momentum - before)):below(1e-11)
    expect(world.energy.kinetic):below(kinetic)
  end
end)

-- Both stops of each joint, whipped down and aside: 0.48 to 1.3 rad beyond, and 3 to 23 J made up. Now 3e-4 to 7e-3 rad, by chance:
-- over steps of 1/24 to 1/36 s at sketch
each("cones and twists hold in a whip", { "sketch", "play" }, function(open, per_second)
  local world = open {}
  local list, most = row(world, world, function(a, b, at)
    world:ball_joint { a = a, b = b, at = at, axis = { 0, 0, 1 }, twist = { -0.3, 0.3 }, swing = 0.2 }
  end), 0
  for i, plank in ipairs(list) do plank:teleport { velocity = { 0, 0, 0.5 * i * (-1) ^ i } } end
  for _ = 1, 3 * per_second do
    world:step()
    most = math.max(most, swing(list, { 0, 0, 1 }, true) - 0.2, twist(list) - 0.3)
  end
  expect(most):below(0.02)
  expect(world.energy.numerical):below(0.1)
end)
