-- laws_regions.lua: other laws inside a region against closed forms: its gravity, drag, rate of time and own force; what happens
-- at its border; and the books of energy.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, each_accuracy, expect = test.scenario, test.each_accuracy, test.expect

local g = 9.81
local everywhere = { size = { 200, 200, 200 } }

-- The books close: nothing comes from nowhere but what the integration made up, J.
local function expect_books(world, most)
  local e = world.energy
  expect(e.initial + e.work_in + e.law):near(e.total + e.lost - e.numerical, 1e-9 * math.max(1, math.abs(e.total), e.lost))
  expect(e.numerical):near(0, most)
end

-- ---- the rate of time ----

each_accuracy("at half the rate of time a fall takes twice as long: y = g (r t)^2 / 2", function(s)
  local world = s.world
  world:region { box = everywhere, laws = { time_rate = 0.5 } }
  local ball = world:ball { radius = 0.1, mass = 3 }
  world:run(1)
  expect(ball.position.y):near(-g / 8, 1e-12)
  expect(ball.velocity.y):near(-g / 4, 1e-12)
  expect(ball.mass):is(3)
  expect(world.energy.kinetic):near(3 * g * g / 8, 1e-9)          -- that of a fall by g / 8
  expect_books(world, 1e-9)
end)

scenario("a pendulum, a spring and a bounce go by the clock inside", function(s)
  local function motion(rate)
    local world = s:world { accuracy = "study" }
    world:region { box = everywhere, laws = { time_rate = rate } }
    world:floor { restitution = 0.5, friction = 0 }
    local bob = world:ball { radius = 0.05, mass = 2, at = { math.sin(0.4), 2 - math.cos(0.4), 0 } }
    world:distance { a = bob, at_a = bob.position, at_b = { 0, 2, 0 } }
    local weight = world:ball { radius = 0.05, mass = 1, at = { 5, 2, 0 }, velocity = { 0, rate, 0 } }
    world:spring { a = weight, at_a = weight.position, at_b = { 5, 3, 0 }, stiffness = 200, damping = 0, length = 1 }
    local ball = world:ball { radius = 0.1, mass = 1, at = { 9, 1, 0 }, restitution = 0.5, friction = 0 }
    world:run(1.2 / rate)
    expect_books(world, 1e-6)
    return { bob.position, weight.position, ball.position, bob.velocity / rate, weight.velocity / rate, ball.velocity / rate }
  end
  local outside = motion(1)
  for _, rate in ipairs { 0.5, 0.3, 2 } do
    for i, v in ipairs(motion(rate)) do expect(v):near(outside[i], 1e-6) end
  end
end)

scenario("drag acts by the time inside: v = v0 exp(-c r t), and takes the energy away", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  world:region { box = everywhere, laws = { time_rate = 0.5, drag = 1.5 } }
  local ball = world:ball { radius = 0.1, mass = 2, velocity = { 3, 0, 0 }, spin = { 0, 4, 0 } }
  local start = world.energy.kinetic
  world:run(1)
  expect(ball.velocity.x):near(3 * math.exp(-0.75), 1e-6)
  expect(ball.spin.y):near(4 * math.exp(-0.75), 1e-6)
  expect(world.energy.lost):near(start * (1 - math.exp(-1.5)), 1e-6)
  expect_books(world, 1e-6)
end)

scenario("at the border of slow time the velocity changes by the rate, within a step, and comes back bit by bit", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local region = world:region { box = { size = { 2, 2, 2 } }, laws = { time_rate = 0.3 } }
  local ball = world:ball { radius = 0.1, mass = 2, at = { -2, 0, 0 }, velocity = { 3, 0, 0 }, spin = { 0, 1, 0 }, friction = 0.3 }
  local twin = world:ball { radius = 0.1, mass = 2, at = { -2, 9, 0 }, velocity = { 3, 0, 0 }, spin = { 0, 1, 0 }, friction = 0.3 }
  local energy = world.energy.total
  local seen = {}
  local function note(e) seen[#seen + 1] = { e.event, e.region, e.self, e.self.position.x, e.self.velocity.x, e.time } end
  world:on("entered", note)
  world:on("left", note)
  world:run(4)
  expect(#seen):is(2)
  for i, row in ipairs { { "entered", -1, 0.9 }, { "left", 1, 3 } } do
    expect(seen[i][1]):is(row[1])
    expect(seen[i][2]):is(region)
    expect(seen[i][3]):is(ball)
    expect(seen[i][4]):between(row[2], row[2] + 3 * world.frame)        -- noticed at the end of the step
    expect(seen[i][5]):near(row[3], 1e-15)
  end
  local late = (seen[1][4] + 1) / 3                                     -- it was seen so long after it had entered, at 3 m/s
  expect(seen[1][6]):near(1 / 3, 1e-12)
  expect(seen[2][6]):near(1 / 3 + late + (2 - 3 * late) / 0.9, 1e-12)
  for _, key in ipairs { "mass", "friction", "velocity", "spin" } do expect(ball[key]):is(twin[key]) end
  expect(world.energy.total):is(energy)
end)

scenario("who is teleported or whose region comes and goes takes over the rate of time", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local ball = world:ball { radius = 0.1, velocity = { 1, 0, 0 } }
  local energy = world.energy.total
  local region = world:region { box = { size = { 4, 4, 4 } }, laws = { time_rate = 0.25 } }
  expect(ball.velocity.x):is(0.25)
  world:step()
  local entered, left = 0, 0
  world:on("entered", { region = region }, function() entered = entered + 1 end)
  world:on("left", { region = region }, function() left = left + 1 end)
  ball:teleport { at = { 9, 0, 0 } }
  expect(ball.velocity.x):is(1)
  world:step()
  ball:teleport { at = { 0, 0, 0 }, velocity = { 1, 0, 0 } }            -- as it is seen
  expect(ball.velocity.x):is(1)
  world:step()
  expect(entered):is(1)
  expect(left):is(1)
  region:remove()
  expect(ball.velocity.x):is(4)
  expect(world.energy.total):near(16 * energy, 1e-12)
  expect_books(world, 1e-12)
end)

scenario("an impulse moves what is in fast time more: p = m v / r^2", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  world:region { box = { size = { 4, 4, 4 } }, laws = { time_rate = 2 } }
  local ball = world:ball { radius = 0.1, mass = 3 }
  ball:hit { impulse = { 6, 0, 0 } }
  expect(ball.velocity):near({ 8, 0, 0 }, 1e-12)
  expect(world.momentum):near({ 6, 0, 0 }, 1e-12)
  expect(world.energy.kinetic):near(0.5 * 3 * 4 * 4, 1e-12)
end)

scenario("a region and the rate of time of the bodies in it are restored and part of the checksum", function(s)
  local world = s:world {}
  world:region { box = everywhere, laws = { time_rate = 0.5, drag = 0.1, conduct = 3, gravity = { 0, -1, 0 } } }
  local ball = world:ball { radius = 0.1, velocity = { 1, 2, 0 } }
  world:run(0.2)
  local snap = world:snapshot()
  world:run(0.5)
  local sum, at = world:checksum(), ball.position
  world:restore(snap)
  world:run(0.5)
  expect(world:checksum()):is(sum)
  expect(ball.position):is(at)
end)

-- ---- the work of laws ----

each_accuracy("the potential jump of a region's gravity is the work of the law", function(s)
  local world = s.world
  world:region { box = { size = { 20, 2, 20 } }, laws = { gravity = { 0, 3, 0 } } }
  local ball = world:ball { radius = 0.1, mass = 2, at = { 0, 3, 0 } }
  world:run { seconds = 3, stop_when = function() return ball.position.y < -2 end }
  local law = -2 * (3 + g) * 2                                          -- N over 2 m
  expect(world.energy.law):near(law, s.accuracy == "sketch" and 4 or 1e-3)
  expect(world.energy.work_in):is(0)
  local fallen = 3 - ball.position.y
  expect(0.5 * 2 * ball.velocity.y ^ 2):near(2 * g * fallen + world.energy.law, 1e-6)
  expect_books(world, 1e-6)
end)

scenario("the work of a region's own force is the law's, not that of a push", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  world:region { box = everywhere, laws = { force = function(b) return -40 * b.mass * b.position end } }
  local ball = world:ball { radius = 0.1, mass = 2, at = { 1, 0, 0 } }
  world:run(0.25)
  local e = world.energy
  expect(e.law):near(e.kinetic, 1e-9)
  expect(e.law):above(1)
  expect(e.work_in):is(0)
  expect(ball.work_received):is(0)
  expect_books(world, 1e-9)
end)

-- x'' = -w^2 x, held through each step: the determinant of a step is 1 + w^2 h^2 / 2, the square of what it widens a swing by. (Within
-- 2 %: to the next order in w h, and where in its swing it ends.)
scenario("a force that is held through a step widens a swing by exp(w^2 h t / 4)", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  world:region { box = everywhere, laws = { force = function(b) return -50 * b.mass * b.position end } }
  local ball = world:ball { radius = 0.1, mass = 2, at = { 0.5, 0, 0 } }
  local function energy() return ball.velocity:dot(ball.velocity) / 2 + 25 * ball.position:dot(ball.position) end
  local start = energy()
  world:run(10)
  expect(math.sqrt(energy() / start)):near(math.exp(50 * 10 / 60 / 4), 0.15)
end)

scenario("drag of a region is lost, on a pile, a chain and a spring as on a ball", function(s)
  local world = s:world { accuracy = "sketch" }
  world:region { box = everywhere, laws = { drag = 1, gravity = { 0, -5, 0 } } }
  world:floor {}
  for i = 0, 59 do
    world:ball { radius = 0.1, at = { 0.23 * (i % 5), 0.2 + 0.23 * (i // 25), 0.23 * (i // 5 % 5) }, restitution = 0.2 }
  end
  for k = 1, 30 do
    local last
    for i = 1, 30 do
      local link = world:capsule { radius = 0.02, length = 0.16, at = { 0.2 * i - 0.1, 9, k }, mass = 0.1, collides = false,
                                   rotation = digbox.quat { axis = { 0, 0, 1 }, angle = math.pi / 2 } }
      world:ball_joint { a = link, b = last, at = { 0.2 * i - 0.2, 9, k } }
      last = link
    end
  end
  world:run(1)
  expect(world.energy.lost):above(100)
  expect_books(world, 1e-6 * world.energy.lost)
end)

-- ---- borders ----

scenario("what slides over ice keeps its speed there, and brakes where the ice ends", function(s)
  local world = s:world { accuracy = "study" }
  world:floor { friction = 0.5 }
  world:region { box = { size = { 4, 4, 4 } }, at = { 2, 0, 0 }, laws = { friction_scale = 0 } }
  local box = world:box { size = 0.2, at = { 0.113, 0.1, 0 }, velocity = { 3, 0, 0 }, friction = 0.5 }
  world:run { seconds = 3, stop_when = function() return box.position.x > 4 end }
  expect(box.velocity.x):near(3, 1e-9)
  local from = box.position.x                                           -- the first step that begins outside brakes
  expect(from):between(4, 4 + 3 * world.frame)
  world:run(2)
  expect(box.position.x):near(from + 9 / (2 * 0.5 * g), 1e-6)
  expect_books(world, 1e-6)
end)

scenario("an error in a region's force names the region, at the script's line", function(s)
  local world = s:world {}
  local region = world:region { box = everywhere, laws = { force = function(b) return b.nothing end } }
  world:ball { radius = 0.1 }
  local ok, message = pcall(function() world:step() end)
  expect(ok):is(false)
  expect(message:match("laws_regions.lua:%d+: ") ~= nil):is(true)
  expect(message:find("(in laws.force of " .. tostring(region) .. ")", 1, true) ~= nil):is(true)
end)
