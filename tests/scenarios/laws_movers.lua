-- laws_movers.lua: kinematic movers, snapshot and restore, and questions in space: against what they must give.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local g = 9.81

scenario("mover: it goes where it is told, on time, whatever stands in its way", function(s)
  local world = s.world
  world:floor {}
  local lift = world:box { name = "lift", kinematic = true, size = { 1, 0.1, 1 }, at = { 0, 0.05, 0 } }
  local load = world:box { name = "load", size = 0.3, mass = 400, at = { 0, 0.25, 0 } }
  world:run "0.2 s"
  lift:move_to { at = { 0, 2.05, 0 }, over = "2 s" }
  world:run "1 s"
  expect(lift.position.y):near(1.05, 1e-9)
  expect(lift.velocity.y):near(1, 1e-9)
  expect(load.velocity.y):near(1, 1e-3)                 -- it rides along
  world:run "1 s"
  expect(lift.position):near({ 0, 2.05, 0 }, 1e-9)
  world:run "0.5 s"
  expect(lift.velocity):is(digbox.vec(0, 0, 0))
  expect(load.position.y):near(2.25, 2e-3)
  -- The books: the mover lifted 400 kg by 2 m, and started it with a plastic hit, which takes m v^2: half stays, half is lost.
  -- What it had when the lift stopped at once carried it on, up 5 cm and down again.
  expect(world.energy.work_in):near(400 * g * 2 + 400 * 1 ^ 2, 1)
  expect(lift.dig == nil or lift.dig ~= load.dig):is(true)                  -- a mover is no member of its load's DIG
end)

scenario("mover: where no time is said it gets there in one frame step", function(s)
  local world = s.world
  local plate = world:box { kinematic = true, size = 0.5, at = { 0, 1, 0 } }
  plate:move_to { at = { 0.1, 1, 0 } }
  world:step()
  expect(plate.position):near({ 0.1, 1, 0 }, 1e-12)
  plate:move_to { rotation = digbox.quat { angle = 0.1 }, over = 0 }
  world:step()
  expect(plate.position):near({ 0.1, 1, 0 }, 1e-12)
  expect(plate.rotation.angle):near(0.1, 1e-12)
  world:step()
  expect(plate.velocity):is(digbox.vec(0, 0, 0))
  expect(function() plate:move_to { over = -1 } end):fails()
end)

-- Journeys of 1.003 s end within a frame: at 2 m away, and never faster than asked, at whatever step.
for _, rate in ipairs { 30, 37, 50, 60, 100, 120, 240 } do
  scenario(("mover: where it stops within a frame, what it carries and pushes ends where it should (1/%d s)"):format(rate), function(s)
    local mu, over = 0.5, 1.003
    local world = s:world { step = 1 / rate }
    world:floor { friction = mu }
    local tray = world:box { kinematic = true, size = { 4, 0.1, 1 }, at = { 0, 1, 0 }, friction = mu }
    local load = world:box { size = 0.2, at = { 0, 1.15, 0 }, friction = mu }
    local ram = world:box { kinematic = true, size = { 0.2, 0.2, 1 }, at = { 0, 0.2, 5 }, friction = 0 }
    local pushed = world:box { size = 0.2, at = { 0.2, 0.1, 5 }, friction = mu }
    world:step(10)
    tray:move_to { at = { 2, 1, 0 }, over = over }
    ram:move_to { at = { 2, 0.2, 5 }, over = over }
    local frames = math.ceil(over * rate)
    local speed = ram.velocity.x
    expect(speed):near(2 * rate / frames, 1e-9)
    world:step(frames - 1)
    expect(ram.velocity.x):near(speed, 1e-12)
    expect(ram.at.x):near(2 - speed / rate, 1e-9)
    world:step()
    expect(ram.at.x):is(2)
    expect(ram.velocity.x):is(0)
    world:run "2 s"
    expect(load.at.x):near(2, 1e-4)                       -- it slips back at the start by as much as on at the end
    expect(pushed.at.x):near(2.2 + speed ^ 2 / (2 * mu * g), 1e-4)
  end)
end

scenario("mover: a conveyor drags what lies on it up to its own speed, with mu g", function(s)
  local world = s.world
  local belt = world:box { name = "belt", kinematic = true, size = { 100, 0.1, 1 }, at = { 0, -0.05, 0 }, friction = 0.25 }
  local box = world:box { size = 0.2, at = { 0, 0.1, 0 }, friction = 0.25 }
  belt:drive { velocity = { 2, 0, 0 } }
  world:run "0.5 s"
  expect(box.velocity.x):near(0.25 * g * 0.5, 0.05)     -- up to one frame later
  world:run "1 s"
  expect(box.velocity.x):near(2, 1e-4)
  expect(belt.velocity):is(digbox.vec(2, 0, 0))
end)

scenario("mover: a ball bounces off a wall that comes towards it with e of the relative speed", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local wall = world:box { kinematic = true, size = { 0.2, 2, 2 }, at = { 3, 0, 0 }, restitution = 0.5 }
  local ball = world:ball { radius = 0.1, at = { 0, 0, 0 }, velocity = { 2, 0, 0 }, restitution = 0.5 }
  wall:drive { velocity = { -1, 0, 0 } }
  world:run "1.5 s"
  expect(ball.velocity):near({ -1 - 0.5 * 3, 0, 0 }, 1e-6)
  expect(wall.position.x):near(3 - 1.5, 1e-9)
end)

-- What sleeps is told by its joints, too: nothing else tells it that the hook goes.
for _, way in ipairs { "drive", "move_to", "teleport", "slow" } do
  for _, joint in ipairs { "rope", "distance", "spring", "hinge", "weld", "ball_joint", "slider" } do
    scenario(("mover: what sleeps at its %s comes along (%s)"):format(joint, way), function(s)
      local world = s:world { gravity = { 0, -9.81, 0 } }
      world:floor {}
      local hook = world:box { kinematic = true, size = 0.1, at = { 0, 0.05, 0 } }
      local load = world:box { size = 0.1, mass = 1, at = { 0.3, 0.05, 0 }, friction = 0.3 }
      local held = world[joint](world, { a = load, b = hook, stiffness = joint == "spring" and 1e4 or nil,
        axis = (joint == "hinge" or joint == "slider") and { 0, 1, 0 } or nil })
      world:run(2)
      expect(load.asleep):is(true)
      if way == "move_to" then hook:move_to { at = { -0.2, 0.05, 0 }, over = 1 }
      elseif way == "teleport" then hook:teleport { at = { -0.01, 0.05, 0 } }
      else hook:drive { velocity = { way == "slow" and -1e-3 or -0.2, 0, 0 } } end
      world:run(way == "slow" and 3 or 1)
      local gone = way == "teleport" and 0.01 or way == "slow" and 0.003 or 0.2
      expect(load.at.x):near(0.3 - gone, joint == "spring" and 1e-3 or 1e-4)
      if joint ~= "spring" then expect(held.error):below "0.1 mm" end
      expect(world.energy.numerical):near(0, 0.01)
    end)
  end
end

scenario("only what is kinematic can be driven", function(s)
  local ball = s.world:ball { radius = 0.1 }
  expect(function() ball:move_to { at = { 1, 0, 0 }, over = 1 } end):fails()
  expect(expect(function() ball:drive { velocity = { 1, 0, 0 } } end):fails()):contains "drive: body #"
end)

-- A world with a bit of everything: a stack, a pendulum, a rolling ball, a push under way
local function busy(world)
  world:floor { friction = 0.6 }
  for i = 1, 4 do world:box { size = 0.2, at = { 0.01 * i, 0.2 * i - 0.1, 0 }, restitution = 0.1 } end
  local bar = world:box { size = { 0.1, 0.6, 0.1 }, at = { 2, 1.3, 0 } }
  world:hinge { a = bar, at = { 2, 1.6, 0 }, axis = { 0, 0, 1 }, friction = 0.01 }
  bar:hit { impulse = { 5, 0, 0 } }
  local ball = world:ball { radius = 0.1, at = { -2, 0.1, 0 }, velocity = { 1, 0, 0 }, material = "rubber" }
  ball:push { force = { 3, 0, 0 }, lasts = "1 s" }
  return ball
end

scenario("snapshot: what happens after restore is what happened before, bit for bit, as often as one likes", function(s)
  local world = s.world
  local ball = busy(world)
  world:run "0.7 s"                                     -- in the middle of the push, some asleep
  local snap = world:snapshot()
  local start, trace = world:checksum(), {}
  for i = 1, 60 do
    world:step()
    trace[i] = world:checksum()
  end
  ball:remove()
  world:box { size = 0.3, at = { 0, 3, 0 } }
  world:run "0.5 s"
  for _ = 1, 2 do
    world:restore(snap)
    expect(world:checksum()):is(start)
    expect(world.steps):is(42)
    for i = 1, 60 do
      world:step()
      if world:checksum() ~= trace[i] then expect(i):is "the same bits" end
    end
  end
  expect(ball.valid):is(true)
end)

scenario("snapshot: it remembers sleep, and only its own world takes it", function(s)
  local world = s.world
  world:floor {}
  local box = world:box { size = 0.2, at = { 0, 0.1, 0 } }
  s:eventually("asleep", "2 s", function() return box.asleep end)
  local snap = world:snapshot()
  box:hit { impulse = { 0, 20, 0 } }
  world:run "0.1 s"
  expect(box.asleep):is(false)
  world:restore(snap)
  expect(box.asleep):is(true)
  expect(world:stats().awake):is(0)
  local other = digbox.world {}
  expect(function() other:restore(snap) end):fails()
end)

scenario("ray: all it meets, in order, with points and normals that lie on them", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local ball = world:ball { name = "ball", radius = 0.5, at = { 2, 0.3, 0 } }
  local box = world:box { name = "box", size = { 1, 1, 1 }, at = { 4, 0, 0 },
                          rotation = digbox.quat { axis = { 0, 1, 0 }, angle = "45 deg" } }
  local cylinder = world:cylinder { name = "cylinder", radius = 0.5, height = 2, at = { 6, 0, 0.3 } }
  local hits = world:ray { from = { 0, 0, 0 }, to = { 10, 0, 0 } }
  local found = {}
  for _, h in ipairs(hits) do
    if h.body ~= found[#found] then found[#found + 1] = h.body end
  end
  expect(found):is { ball, box, cylinder }
  local function first(body)
    for _, h in ipairs(hits) do if h.body == body then return h end end
  end
  expect(first(ball).distance):near(2 - 0.4, 1e-9)      -- sqrt(0.5^2 - 0.3^2)
  expect(first(ball).normal):near({ -0.8, -0.6, 0 }, 1e-9)
  expect(first(box).distance):near(4 - math.sqrt(0.5), 1e-9)
  expect(first(cylinder).distance):near(6 - 0.4, 1e-9)
  expect(first(cylinder).normal):near({ -0.8, 0, -0.6 }, 1e-9)
  for i, h in ipairs(hits) do
    expect(h.point):near({ h.distance, 0, 0 }, 1e-9)
    expect(h.distance):at_least(i > 1 and hits[i - 1].distance or 0)
  end
end)

-- A plate at 4 m/s strikes balls that touch each other: they leave at (1 + e) 4 m/s, be they 100 or, as a crowd, 1296.
for _, side in ipairs { 10, 36 } do
  scenario(("mover: a plate throws %d balls as their restitution says"):format(side * side), function(s)
    local world = s:world { gravity = { 0, 0, 0 } }
    local plate = world:box { kinematic = true, size = { 9, 0.2, 9 }, at = { 0, -0.1, 0 }, restitution = 0.8 }
    local balls = {}
    for i = 1, side do
      for j = 1, side do
        balls[#balls + 1] = world:ball { radius = 0.1, restitution = 0.8, friction = 0, at = { i * 0.2 - 4, 0.1, j * 0.2 - 4 } }
      end
    end
    plate:move_to { at = { 0, 0.9, 0 }, over = "0.25 s" }
    world:run "0.2 s"
    local slowest, fastest = math.huge, -math.huge
    for _, b in ipairs(balls) do
      slowest, fastest = math.min(slowest, b.velocity.y), math.max(fastest, b.velocity.y)
    end
    expect(slowest):near(7.2, 1e-6)
    expect(fastest):near(7.2, 1e-6)
    expect(world.energy.numerical / world.energy.work_in):near(0, 1e-9)
  end)
end

-- Columns of resting balls in a crowd, so far apart that none is near the next; who is pushed into the next one pushes that in turn, within
-- the frame.
for _, case in ipairs { { 1, 0.004 }, { 5, 0.004 }, { 5, 0.03 }, { 20, 0.15 } } do
  local speed, apart = table.unpack(case)
  scenario(("mover: a plate at %g m/s pushes columns of balls %g mm apart, and none into another"):format(speed, 1000 * apart), function(s)
    local world = s:world { gravity = { 0, 0, 0 }, sleeping = false }
    world:box { size = { 9, 0.1, 9 }, at = { 0, -0.06, 0 }, kinematic = true }:drive { velocity = { 0, speed, 0 } }
    local columns = {}
    for i = 1, 36 do
      local column = {}
      for k = 1, 12 do
        column[k] = world:ball { radius = 0.1, mass = 1, restitution = 0, friction = 0.3,
                                 at = { (i % 6 - 3) * 0.21, 0.1 + apart + (k - 1) * (0.2 + apart), (i // 6 - 3) * 0.21 } }
      end
      columns[i] = column
    end
    local deepest = 0
    for _ = 1, 20 do
      world:step()
      for _, column in ipairs(columns) do
        for k = 2, #column do
          local way = column[k].position - column[k - 1].position
          expect(way.y):above(0)                -- none went through the next
          deepest = math.max(deepest, 0.2 - #way)
        end
      end
    end
    expect(deepest):below(0.01)
    expect(world:stats().swept):above(0)
  end)
end

-- Deep in the wall on one side, it just touches the piston that goes back on the other: a touch that once turned it by 31 degrees in a
-- frame of 1/30 s, so that it rose by 19 cm and fell.
for _, step in ipairs { 1 / 30, 1 / 60 } do
  for _, speed in ipairs { 0.5, 50 } do
    scenario(("mover: what it pressed half into a wall at %g m/s comes out behind it, steps of 1/%d s"):format(speed, 1 / step), function(s)
      local world = s:world { step = step }
      world:floor { friction = 0.6 }
      world:box { name = "wall", fixed = true, size = { 1, 4, 4 }, at = { 1, 2, 0 } }
      local box = world:box { name = "box", size = 1, mass = 1, friction = 0.6, at = { 0, 0.5, 0 } }
      local piston = world:box { name = "piston", kinematic = true, size = { 1, 4, 4 }, at = { -1.5, 2, 0 } }
      local release, high, tilt, pieces = 1 / speed + 2, 0, 0, 0
      for i = 0, math.floor((release + 2.5) / step) do
        local t, x = i * step, piston.position.x
        local v = t < release and math.min(speed, (-0.5 - x) / step) or -math.min(0.5, (x + 1.5) / step)
        piston:drive { velocity = { v, 0, 0 } }
        world:step()
        pieces = t > 1.2 and t < release and math.max(pieces, world:stats().substeps) or pieces
        if t > release then
          high = math.max(high, box.position.y)
          tilt = math.max(tilt, math.deg(math.acos(math.min(1, (box.rotation * digbox.vec(0, 1, 0)).y))))
          expect(box.speed):below(1)
        end
      end
      expect(high):below(0.6)
      expect(tilt):below(10)
      -- at 1/60 s 8, and 13 were a slow piston's cut as short as a fast one's; at 1/30 s 15, for no corner may sink in by over 0.5 %
      expect(pieces):below(step < 0.02 and 10 or 17)
      expect(box.position):near({ 0, 0.5, 0 }, 0.15)
      expect(box.speed):below(1e-6)
    end)
  end
end

scenario("overlap: what lies in it, and nothing else", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local list = {}
  for i = 1, 10 do list[i] = world:ball { name = "ball " .. i, radius = 0.1, at = { i, 0, 0 } } end
  -- a sphere of radius 2 at x = 5: touches those whose centre is nearer than 2.1
  expect(world:overlap { digbox.sphere { radius = 2 }, at = { 5, 0, 0 } }):is { list[3], list[4], list[5], list[6], list[7] }
  expect(world:overlap { digbox.sphere { radius = 1.89 }, at = { 5, 0, 0 } }):is { list[4], list[5], list[6] }
  expect(world:overlap { digbox.box { size = { 20, 0.1, 0.1 } }, at = { 0, 0.2, 0 } }):is_empty()
end)

scenario("sweep: a falling ball meets a floor after sqrt(2 h / g), an arc misses what a line would hit", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  world:floor {}
  local bar = world:box { name = "bar", fixed = true, size = { 0.05, 0.05, 2 }, at = { 1, 1.2, 0 } }
  local ball = { digbox.sphere { radius = 0.1 }, at = { -2, 3.1, 0 }, acceleration = { 0, -g, 0 }, time = 5 }
  local hit = world:sweep(ball)
  local t = math.sqrt(2 * 3 / g)
  expect(hit.body.name):is "floor"
  expect(hit.fraction * 5):near(t, 1e-6)
  expect(hit.normal):near({ 0, 1, 0 }, 1e-6)
  -- thrown from x = 0 at the same height as the bar: up and over it, while a straight line meets it
  local arc = { digbox.sphere { radius = 0.1 }, at = { 0, 1.2, 0 }, velocity = { 2, 5, 0 }, acceleration = { 0, -g, 0 }, time = 0.9 }
  expect(world:sweep(arc)):is(nil)
  local line = { digbox.sphere { radius = 0.1 }, at = { 0, 1.2, 0 }, velocity = { 2, 0, 0 }, time = 0.9 }
  expect(world:sweep(line).body):is(bar)
  expect(world:sweep(line).distance):near(1 - 0.025 - 0.1, 1e-6)
end)

-- Its speed changes a little in each frame, which stands for a smooth motion; a launch is a blow.
test.each_accuracy("mover: what rides on a lift, or on what does, is not struck by it", function(s, accuracy)
  local world = s:world { accuracy = accuracy }
  world:floor {}
  local plate = world:box { kinematic = true, size = { 2, 0.1, 1 }, at = { 0, 0.5, 0 } }
  local boxes, impacts = {}, 0
  for i = 0, 3 do boxes[i + 1] = world:box { size = 0.3, mass = 5, at = { 0.6 * (i % 2), 0.7 + 0.3 * (i // 2), 0 } } end
  world:run(0.5)
  for _, box in ipairs(boxes) do box:on("impact", function() impacts = impacts + 1 end) end
  for i = 1, 90 do
    plate:drive { velocity = { 0, 0.3 * math.sin(i / 12), 0 } }
    world:step()
  end
  expect(impacts):is(0)
  plate:drive { velocity = { 0, 3, 0 } }
  world:step()
  expect(impacts):at_least(2)
end)

-- A ball on a rod of 10 g that hangs on a shaft, which turns so fast that the rod swings by 0.05 rad across its axis in a substep. About
-- that axis its inertia is 1/5000 of that across it, and errors of its spin came back larger from substep to substep: 6e13 J and joints
-- 200 m apart after 4 s.
for _, case in ipairs { { "sketch", 60, 12 }, { "play", 30, 6 }, { "play", 60, 12 }, { "study", 60, 12 } } do
  local accuracy, rate, speed = table.unpack(case)
  scenario(("a thin rod stays on a hinge that a motor turns at %g rad/s, at %s and 1/%d s"):format(speed, accuracy, rate), function(s)
    local world = s:world { accuracy = accuracy, step = 1 / rate }
    local shaft = world:box { size = 0.1, mass = 1, at = { 0, 2, 0 } }
    local ball = world:ball { radius = 0.05, mass = 1, at = { 0.3, 1.05, 0 }, turns = false }
    local rod = world:box { size = { 0.01, 1, 0.01 }, mass = 0.01, at = { 0.15, 1.52, 0 },
                            rotation = digbox.quat { from = { 0, -1, 0 }, to = { 0.3, -0.95, 0 } } }
    world:hinge { a = shaft, at = shaft.position, axis = { 0, 1, 0 }, motor = { speed = speed } }
    world:hinge { a = rod, b = shaft, at = shaft.position, axis = { 0, 0, 1 } }
    world:ball_joint { a = ball, b = rod, at = ball.position }
    local most = 0
    for _ = 1, 4 * rate do
      world:step()
      for _, j in ipairs(world:joints()) do most = math.max(most, j.error) end
    end
    expect(most):below(0.01)
    expect(ball.speed):below(2 * speed)         -- at most sqrt(2 w^2 r^2 + 4 g r) of 1 m
  end)
end

-- A crowd in a bucket that starts with a jerk: at the end of the frame many balls have left it, and it gave them their speed all the same.
for _, friction in ipairs { 0.1, 0.6 } do
  scenario(("mover: the books have its work on what has left it by the end of the frame (friction %g)"):format(friction), function(s)
    local world = s:world { step = 1 / 30 }
    local d = 0.03
    local cup = world:bucket { kinematic = true, at = { 0, 0.6, 0 }, height = 0.3, top_radius = 0.12, bottom_radius = 0.09,
      friction = friction }
    for i = 0, 29 do
      local turn = 2.4 * i
      local at = { 0.05 * math.cos(turn), 0.65 + 0.5 * d * i, 0.05 * math.sin(turn) }
      world:ball { radius = 0.45 * d, friction = friction, restitution = 0.5, at = at }
    end
    world:step(30)
    cup:move_to { at = { 0, 0.9, 0 }, rotation = digbox.quat { axis = { 0, 0, 1 }, angle = "178 deg" }, over = 0.3 }
    local most, highest = 0, 0
    for _ = 1, 30 do
      local before = world.energy
      world:step()
      local after = world.energy
      most = math.max(most, after.kinetic)
      highest = math.max(highest, after.total - after.work_in - before.total + before.work_in)
    end
    expect(highest / most):below(1e-6)
    expect(world:warnings()):is_empty()
  end)
end

-- A column on a turntable that starts, as a crowd: friction about the contacts' normal turns it along, whose rows did not know that the
-- table turns. The table gives I w^2, of which half goes into the slip.
for _, case in ipairs { { 30, 1, "cylinder", { radius = 0.2, height = 0.05 }, 0.2 ^ 2 / 2 },
                        { 20, 3, "box", { size = { 0.3, 0.05, 0.3 } }, 0.3 ^ 2 / 6 } } do
  local count, rate, shape, fields, each = table.unpack(case)         -- each: kg m^2 of a plate of 1 kg
  scenario(("mover: a turntable at %g rad/s turns a column of %d plates along"):format(rate, count), function(s)
    local world, plates = s:world { accuracy = "sketch" }, {}
    local work = count * each * rate ^ 2
    fields.mass, fields.friction = 1, 0.8
    local disc = world:cylinder { kinematic = true, radius = 1, height = 0.1, at = { 0, 0.5, 0 }, friction = 0.8 }
    for i = 1, count do
      fields.at = { 0, 0.525 + 0.05 * i, 0 }
      plates[i] = world[shape](world, fields)
    end
    world:step(20)
    disc:drive { spin = { 0, rate, 0 } }
    world:run(3)
    for _, plate in ipairs(plates) do expect(plate.spin.y):near(rate, 1e-3 * rate) end      -- 0 before
    expect(world.energy.work_in):near(work, 0.03 * work)
  end)
end
