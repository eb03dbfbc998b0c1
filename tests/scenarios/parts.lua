-- parts.lua: what digbox.parts makes behaves as the thing does: doors open and are held by bolts, lifts carry, ragdolls come to rest.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect
local parts = digbox.parts
local g = 9.81

scenario("a door opens when it is pushed, stops at its limit, and its bolt holds up to its strength", function(s)
  local world = s.world
  world:floor {}
  local post = world:box { name = "post", fixed = true, size = { 0.1, 2.2, 0.1 }, at = { -0.06, 1.1, 0 } }
  local door = parts.door(world, { name = "cellar", at = { 0, 0, 0 }, into = post, bolted = true, strength = "400 N" })
  local function push(force, seconds) door.leaf:push { force = { 0, 0, -force }, at = { 0.75, 1, 0 }, lasts = seconds } end
  push(60, 0.5)
  world:run(0.6)
  expect(door.angle):near(0, 1e-3)
  expect(door.bolted):is(true)
  local answer = door.leaf:can_move { along = { 0, 0, -1 }, with = 60, at = { 0.75, 1, 0 }, by = "20 cm" }
  expect(answer.held_by.name):is "cellar bolt"
  door:unbolt()
  push(20, 0.5)
  world:run(0.5)
  -- Angular momentum about the hinge: (F 0.75 - friction) t = m b^2 / 3 w
  expect(door.hinge.speed):near((20 * 0.75 - 0.2) * 0.5 / (door.leaf.mass * (0.8 ^ 2 / 3 + 0.04 ^ 2 / 12)), 0.03)
  world:run(4)
  expect(door.angle):between(0.5, math.pi / 2 + 0.01)
  expect(function() door:bolt() end):fails()
  door.leaf:teleport { at = { 0.4, 1.01, 0 }, rotation = digbox.quat { axis = { 0, 1, 0 }, angle = 0 }, velocity = { 0, 0, 0 },
    spin = { 0, 0, 0 } }
  door:bolt()
  push(3000, 0.3)
  world:run(0.4)
  expect(door.bolted):is(false)                                 -- 3 kN was more than it bore
end)

scenario("a drawer comes out as far as it goes, with what lies in it; bolted it stays", function(s)
  local world = s.world
  local cabinet = world:box { fixed = true, size = { 0.5, 0.5, 0.5 }, at = { 0, 0.25, 0 } }
  local drawer = parts.drawer(world, { at = { 0, 0.57, 0 }, along = { 0, 0, 1 }, into = cabinet, mass = 2, friction = 3, bolted = true })
  local coin = world:cylinder { radius = 0.02, height = 0.01, at = { 0, 0.53, 0.05 }, material = "steel" }
  local function pull(force, seconds) drawer.box:push { force = { 0, 0, force }, lasts = seconds } end
  pull(30, 0.5)
  world:run(0.6)
  expect(drawer.distance):near(0, 1e-3)
  drawer:unbolt()
  pull(2.5, 1)
  world:run(1)
  expect(drawer.distance):near(0, 1e-3)                         -- its runners rub with 3 N
  local from = coin.position.z - drawer.box.position.z
  pull(8, 2)
  world:run(3)
  expect(drawer.distance):near(0.36, 2e-3)
  expect(coin.position.y):between(0.51, 0.56)                   -- still in it
  expect(coin.position.z - drawer.box.position.z - from):between(-0.3, 0.4)
  pull(-8, 2)
  world:run(3)
  expect(drawer.distance):near(0, 2e-3)
  drawer:bolt()
  expect(drawer.bolted):is(true)
end)

scenario("a lift that is saved on its way goes on to where it was sent, just as it would have", function(s)
  local world = s.world
  world:floor {}
  local lift = parts.lift(world, { at = { 0, 0.2, 0 }, height = 6, speed = 0.5, name = "hoist" })
  lift:go "2 m"
  world:run(1.5)
  expect(lift.guide.speed):near(0.5, 1e-3)
  world:save "lift.digbox"
  local there = digbox.load "lift.digbox"
  local again = there:find "hoist"
  world:run(1)
  there:run(1)
  expect(again.distance):near(lift.distance, 1e-9)
  world:run(4)
  there:run(4)
  expect(again.distance):near(2, 0.01)
  expect(again.distance):near(lift.distance, 1e-9)
  there:save "lift.digbox"                      -- arrived: nothing is left to do
  local at_rest = digbox.load "lift.digbox":find "hoist"
  at_rest.guide:set { motor = { speed = -0.5, max_force = 5000 } }
  at_rest.platform.world:run(1)
  expect(at_rest.guide.speed):near(-0.5, 1e-2)
end)

scenario("a lift takes 80 kg up to where it is sent, stops, holds, and cannot take more than its motor bears", function(s)
  local world = s.world
  world:floor {}
  local lift = parts.lift(world, { at = { 0, 0.2, 0 }, height = 6, speed = 0.5, force = 4000 })
  local crate = world:box { size = 0.5, mass = 80, at = { 0, 0.45, 0 } }
  world:run(0.5)
  local energy = world.energy
  lift:go "3 m"
  world:run(2)
  expect(lift.guide.speed):near(0.5, 1e-3)
  s:eventually("it is there", "5 s", function() return math.abs(lift.guide.speed) < 1e-3 end)
  expect(lift.distance):near(3, 0.01)
  expect(crate.position.y):near(3.45, 0.015)
  expect(crate:touches(lift.platform)):is(true)
  -- The motor's work is the weight's rise, and nothing else.
  expect(world.energy.work_in - energy.work_in):near(280 * g * lift.distance, 0.005 * 280 * g * 3)
  world:run(2)
  expect(lift.distance):near(3, 0.01)
  lift:go(0)
  s:eventually("it is down", "8 s", function() return lift.distance < 0.01 end)
  world:box { size = 0.5, mass = 200, at = { 0, 1.2, 0 } }                   -- 480 kg weigh 4.7 kN, the motor gives 4
  world:run(1)
  lift:go(2)
  world:run(2)
  expect(lift.distance):near(0, 0.01)
  expect(function() lift:go "7 m" end):fails()
end)

scenario("a clock shows the time that passes, at its rate", function(s)
  local world = s.world
  local clock = parts.clock(world, { at = { 0, 1, 0 }, shows = "3 h", rate = 600 })
  world:run(9)
  expect(clock.time):near(3 * 3600 + 600 * 9, 15)
  expect(clock.minute.angle):near(2 * math.pi * 1.5, 0.02)
  expect(clock.minute_hand.position.y):near(1 - 0.4 * 0.9 * 0.3, 1e-3)      -- half past four
  clock:set_rate(0)
  world:run(1)
  expect(clock.time):near(3 * 3600 + 600 * 9, 20)
end)

scenario("a clock that keeps the time of day does not fall asleep, slow as its hands are", function(s)
  local world = s.world
  local clock = parts.clock(world, { at = { 0, 1, 0 } })
  world:run(10)
  expect(clock.time):near(10, 1e-3)
  expect(clock.hour_hand.awake):is(true)
  clock:set_rate(0)
  world:run(2)
  expect(clock.time):near(10, 0.05)
  expect(clock.hour_hand.asleep):is(true)
end)

scenario("a motor that is held fast lets its load sleep, one that creeps does not", function(s)
  local world = s.world
  world:floor {}
  local box = world:box { size = 0.2, at = { 0, 0.1, 0 }, mass = 100 }
  local drive = world:slider { a = box, along = { 1, 0, 0 }, motor = { speed = 0.1, max_force = 1 } }
  world:run(2)
  expect(box.asleep):is(true)
  drive:set { motor = { speed = 1e-3, max_force = 1000 } }
  world:run(3)
  expect(drive.distance):near(3e-3, 1e-5)
end)

scenario("a ragdoll that is struck falls and comes to rest, and never has more energy than it was given", function(s)
  local world = s.world
  world:floor {}
  local doll = parts.ragdoll(world, { at = { 0, 0, 0 }, height = 1.8, mass = 80 })
  expect(doll.mass):near(80, 1e-9)
  expect(#doll.bodies):is(10)
  expect(doll.position.y / 1.8):between(0.55, 0.6)              -- of the height: people have it at 0.56 to 0.58
  doll.trunk:hit { impulse = { 60, 0, 20 } }
  local most, before, last = -math.huge, 0, math.huge
  for i = 1, 300 do
    world:step()
    local e = world.energy
    local now = e.kinetic + e.potential - e.work_in
    most, last = math.max(most, now - last), now
    expect(now - e.initial):below(0)
    if i == 60 then before = doll.position.y end
  end
  expect(before):below(0.9)
  expect(most):below(0.5)                                       -- J from one frame to the next, of 790 that its fall takes away
  s:eventually("it lies still", "20 s", function() return doll.trunk.asleep end)
  expect(doll.position.y):below(0.3)
  for _, joint in ipairs(doll.joints) do expect(joint.valid and joint.error or 1):below "1 cm" end
  for _, body in ipairs(doll.bodies) do expect(body.position.y):above(0) end
end)

scenario("a truck speeds up by its torque, carries its load, and brakes", function(s)
  local world = s.world
  world:floor {}
  local truck = parts.truck(world, { at = { 0, 0, 0 } })
  world:run(1)
  local empty = truck.chassis.position.y
  local crate = world:box { name = "load", size = 0.8, mass = 500, at = truck.bed + digbox.vec(0, 0.42, 0), friction = 0.6 }
  world:run(2)
  -- Its springs give way: 500 g / (4 k), more in the rear, where the load is; k holds 2400 kg at 6 cm
  expect(empty - truck.chassis.position.y):between(0.8 * 0.06 * 500 / 2400, 1.3 * 0.06 * 500 / 2400)
  local start = world.time
  truck:drive "6 m/s"
  world:run(2)
  -- (2 T / r) = (m + 4 I / r^2) a, with I = m_w r^2 / 2
  expect(truck.speed):near(2 * 900 / 0.4 / (2400 + 500 + 240 + 120) * (world.time - start), 0.05)
  world:run(4)
  expect(truck.speed):near(6, 0.05)
  expect(crate.position.x - truck.bed.x):near(0, 0.15)          -- it stays where it was put
  expect(math.abs(truck.chassis.position.z)):below(0.05)        -- straight ahead
  truck:coast()
  world:run(1)
  expect(truck.speed):near(6, 0.05)
  truck:brake()
  world:run(3)
  expect(math.abs(truck.speed)):below "2 mm/s"
end)

scenario("a lava lamp's wax rises and sinks", function(s)
  local world = s:world { sleeping = false }
  local lamp = parts.lava_lamp(world, { at = { 0, 0.5, 0 } })
  local turns, side = 0, -1
  for _ = 1, 60 * 200 do
    world:step()
    local y = lamp.wax.position.y - 0.5
    if side < 0 and y > 0.18 or side > 0 and y < 0.12 then side, turns = -side, turns + 1 end
  end
  expect(turns):at_least(3)                                     -- up, down and up again, each in about a minute
  expect(lamp.wax.temperature):between(303.15, 323.15)
end)

scenario("a part is found by its name in a world that was loaded", function(s)
  local world = s.world
  world:floor {}
  parts.door(world, { name = "front", at = { 0, 0, 0 }, bolted = true })
  parts.truck(world, { at = { 0, 0, 5 } }):drive "3 m/s"
  parts.lift(world, { at = { 9, 1, 0 }, height = 2 })
  world:run(0.5)
  world:save "parts.digbox"
  local there = digbox.load "parts.digbox"
  there:find("front"):unbolt()
  expect(there:find("front").bolted):is(false)
  expect(world:find("front").bolted):is(true)
  there:find("truck"):brake()
  there:find("lift"):go(1)
  there:run(3)
  expect(math.abs(there:find("truck").speed)):below "2 mm/s"
  expect(there:find("lift").distance):near(1, 0.01)
end)

scenario("what is wrong is said, and nothing is left half made", function(s)
  local world = s.world
  local function says(text, fn) expect(expect(fn):fails()):contains(text) end
  says("did you mean 'width'", function() parts.door(world, { at = { 0, 0, 0 }, widht = 1 }) end)
  says("parts.door: at is missing", function() parts.door(world, {}) end)
  says("digbox.parts has no part 'dor' (did you mean 'door'?)", function() return parts.dor end)
  says("parts.lift: height is missing", function() parts.lift(world, { at = { 0, 0, 0 } }) end)
  says("wants a mass", function() parts.ragdoll(world, { at = { 0, 0, 0 }, mass = "3 m" }) end)
  says("must be level", function() parts.truck(world, { at = { 0, 0, 0 }, along = { 0, 1, 0 } }) end)
  says("less than half", function() parts.drawer(world, { at = { 0, 0, 0 }, wall = 0.2 }) end)
  says("must be more than cool", function() parts.lava_lamp(world, { at = { 0, 0, 0 }, warm = 300 }) end)
  says("cannot be assigned", function() parts.clock(world, { at = { 0, 0, 0 } }).time = 3 end)
  says("wants a world", function() parts.door { at = { 0, 0, 0 } } end)
  says("has no field or method 'leef' (did you mean 'leaf'?)", function() return parts.door(world, { at = { 0, 0, 0 } }).leef end)
  expect(#world:bodies()):is(4)                                 -- of the clock, and of one door
end)
