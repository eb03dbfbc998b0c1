-- api_events.lua: events, messages, DIGs and tasks.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- A ball 1 m above a floor.
local function drop(world)
  local floor = world:floor {}
  local ball = world:ball { name = "ball", radius = 0.1, at = { 0, 1.1, 0 }, restitution = 0.5 }
  return floor, ball
end

scenario("a contact begins when and as fast as free fall says", function(s)
  local world = s.world
  local floor, ball = drop(world)
  local seen = {}
  ball:on("contact_begin", function(e) seen[#seen + 1] = e end)
  world:run(1)
  local e = seen[1]
  expect(e.time):near(math.sqrt(2 / 9.81), "1 ms")
  expect(e.speed):near(math.sqrt(2 * 9.81), "1 cm/s")
  expect(e.self):is(ball)
  expect(e.other):is(floor)
  expect(e.point):near({ 0, 0, 0 }, "2 mm")
  expect(math.abs(e.normal.y)):near(1, 1e-6)
  expect(e.event):is "contact_begin"
end)

scenario("the normal of an event points away from its body", function(s)
  local world = s.world
  local floor, ball = drop(world)
  local from_ball, from_floor
  ball:on("contact_begin", function(e) from_ball = from_ball or e.normal end)
  floor:on("contact_begin", function(e) from_floor = from_floor or e.normal end)
  world:run(1)
  expect(from_ball):near({ 0, -1, 0 }, 1e-6)
  expect(from_floor):near({ 0, 1, 0 }, 1e-6)
end)

scenario("what lies there from the start tells where it touches, and that it came with no speed", function(s)
  local world, seen = s.world, {}
  local floor = world:floor { name = "floor" }
  world:on("contact_begin", function(e) seen[#seen + 1] = e end)
  local box = world:box { size = 0.2, at = { 1, 0.1, 2 } }
  world:ball { radius = 0.1, at = { 1, 0.3, 2 } }
  world:step()
  expect(#seen):is(2)
  for _, e in ipairs(seen) do
    local up = e.self == floor and 1 or e.other == floor and -1 or e.self == box and 1 or -1
    expect(e.point):near({ 1, e.self == floor and 0 or e.other == floor and 0 or 0.2, 2 }, 1e-6)
    expect(e.normal):near({ 0, up, 0 }, 1e-6)
    expect(e.speed):is(0.0)
  end
end)

scenario("a contact ends in the middle between where its bodies are nearest then", function(s)
  local world, seen = s.world, {}
  local _, ball = drop(world)
  ball:on("contact_end", function(e) seen[#seen + 1] = { e = e, gap = ball.position.y - 0.1 } end)
  world:run(1)
  local first = seen[1]
  expect(first.gap):above(1e-4)
  expect(first.e.point):near({ 0, first.gap / 2, 0 }, 1e-9)
  expect(first.e.normal):near({ 0, -1, 0 }, 1e-9)
end)

scenario("bodies of many shapes part where two of these do, and from a wall of the room at the wall", function(s)
  local world, ends = s.world, {}
  world:room { size = { 10, 10, 10 }, restitution = 0.5 }
  local low = { size = { 0.2, 0.2, 0.2 }, restitution = 0.5, at = { 0, -0.5, 0 } }
  local two = world:body { at = { 1, 2, 0 }, parts = { digbox.box { size = { 0.2, 0.2, 0.2 } }, digbox.box(low) } }
  local ball = world:ball { radius = 0.1, at = { 4, 5, 0 }, velocity = { 20, 0, 0 }, restitution = 0.5 }
  local start = two.position.y
  for _, body in ipairs { two, ball } do
    body:on("contact_end", function(e) ends[body] = ends[body] or { e = e, at = body.position } end)
  end
  world:run(1)
  local gap = 1.4 + ends[two].at.y - start                -- the lower box begins at 1.4 m
  expect(gap):above(1e-5)
  expect(ends[two].e.point.y):near(gap / 2, 1e-9)
  expect(ends[two].e.normal):near({ 0, -1, 0 }, 1e-9)
  expect(ends[ball].e.point):near({ 5 - (4.9 - ends[ball].at.x) / 2, ends[ball].at.y, 0 }, 1e-9)
end)

scenario("filters keep what is not asked for away", function(s)
  local world = s.world
  local floor, ball = drop(world)
  local other = world:ball { radius = 0.1, at = { 5, 1.1, 0 } }
  local counts = { slow = 0, fast = 0, floor = 0, other = 0, all = 0 }
  local function counter(key) return function() counts[key] = counts[key] + 1 end end
  ball:on("impact", { faster_than = "0.1 m/s" }, counter "slow")
  ball:on("impact", { faster_than = "100 m/s" }, counter "fast")
  ball:on("impact", { with = floor }, counter "floor")
  ball:on("impact", { with = other }, counter "other")
  world:on("impact", counter "all")
  world:run(1)
  expect(counts.slow):above(0)
  expect(counts.fast):is(0)
  expect(counts.floor):at_least(counts.slow)
  expect(counts.other):is(0)
  expect(counts.all):above(counts.floor)
end)

scenario("handlers run in the order they were added, and off means off", function(s)
  local world = s.world
  local _, ball = drop(world)
  local order = {}
  world:on("contact_begin", function() order[#order + 1] = "w1" end)
  ball:on("contact_begin", function() order[#order + 1] = "b" end)
  local sub = world:on("contact_begin", function() order[#order + 1] = "off" end)
  world:on("contact_begin", function() order[#order + 1] = "w2" end)
  sub:off()
  s:eventually("contact", "1 s", function() return #order > 0 end)
  expect(order):is { "w1", "b", "w2" }
end)

scenario("anything may be made and removed in a handler, but not stepped", function(s)
  local world = s.world
  local _, ball = drop(world)
  local message, made
  ball:on("contact_begin", function(e)
    message = expect(function() world:step() end):fails()
    expect(function() world:run(1) end):fails()
    expect(function() world:close() end):fails()
    made = world:ball { name = "made", radius = 0.1, at = { 3, 1, 0 } }
    e.self:remove()
  end)
  world:run(1)
  expect(message):contains "world:step() cannot be called inside a handler of 'contact_begin'"
  expect(ball.valid):is(false)
  expect(made.valid):is(true)
  expect(made.position.y):below(1)
end)

-- H7: a plank falls flat on two boxes, so that its handler is called twice after one step.
scenario("what two handlers of a step remove is removed once, with one warning", function(s)
  local world = s.world
  world:floor {}
  for i = 0, 1 do world:box { size = 1, fixed = true, at = { 1.2 * i, 0.5, 0 } } end
  local plank = world:box { name = "plank", size = { 3, 0.1, 1 }, at = { 0.6, 1.1, 0 } }
  local calls = 0
  plank:on("contact_begin", function(e)
    calls = calls + 1
    e.self:remove()
    expect(e.self.valid):is(false)
  end)
  world:run(0.5)
  expect(calls):is(2)
  expect((expect(function() plank:remove() end):fails())):contains "body 'plank' was removed at"
end)

scenario("an error in a handler names the event and the time", function(s)
  local world = s.world
  local _, ball = drop(world)
  ball:on("contact_begin", function() error "oops" end)
  local message = expect(function() world:run(1) end):fails()
  expect(message):contains "oops (in a handler of 'contact_begin' at t = 0.45"
  expect(message):contains((" s, step %d of body 'floor' and body 'ball')"):format(world.steps))
  world:step()                              -- and the world goes on
end)

scenario("a handler cannot yield, and is told where it tried", function(s)
  local world = s.world
  local _, ball = drop(world)
  local sub = ball:on("contact_begin", function() coroutine.yield() end)
  local function refused(message)
    expect(message):contains "api_events.lua:"
    expect(message):contains "cannot yield here: the world waits for this function to return (in a handler of 'contact_begin'"
  end
  local start = world:snapshot()
  refused(expect(function() world:run(1) end):fails())
  world:restore(start)
  coroutine.wrap(function() refused(expect(function() world:run(1) end):fails()) end)()
  sub:off()
  expect(expect(function() table.sort({ 3, 2, 1 }, function() coroutine.yield() end) end):fails()):contains "api_events.lua:"
end)

scenario("a body falls asleep and wakes", function(s)
  local world = s.world
  world:floor {}
  local box = world:box { size = 0.2, at = { 0, 0.1, 0 } }
  local slept, woke = 0, 0
  box:on("slept", function() slept = slept + 1 end)
  box:on("woke", function() woke = woke + 1 end)
  s:eventually("asleep", "5 s", function() return box.asleep end)
  expect(slept):is(1)
  expect(box.mode):is "resting"
  box:hit { impulse = { 0, box.mass, 0 } }
  world:step(2)
  expect(woke):is(1)
  expect(box.awake):is(true)
end)

scenario("who moves is told in every step, who rests is not", function(s)
  local world = s.world
  world:floor {}
  local ball = world:ball { name = "ball", radius = 0.1, at = { 0, 0.6, 0 } }
  world:box { name = "box", size = 0.2, at = { 3, 0.1, 0 } }
  local lift = world:box { name = "lift", size = 0.2, kinematic = true, at = { 6, 1, 0 } }
  local mine, all = {}, {}
  ball:on("moved", function(e) mine[#mine + 1] = e.time end)
  world:on("moved", function(e) all[e.self.name] = (all[e.self.name] or 0) + 1 end)
  world:run "3 s"
  expect(ball.asleep):is(true)
  expect(mine[1]):is(world.frame)
  expect(#mine):between(math.sqrt(2 * 0.5 / 9.81) / world.frame, 25)       -- as long as it falls, and until it is at rest
  expect(all.ball):is(#mine)
  expect(all.box or 0):below(3)
  expect(all.lift):is(nil)
  lift:move_to { at = { 6, 2, 0 }, over = "0.5 s" }
  world:run "2 s"
  expect(all.lift):is(30)
end)

scenario("DIGs merge when things meet and split when they part", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local a = world:ball { name = "a", radius = 0.5, at = { 0, 0, 0 }, mass = 1 }
  local b = world:ball { name = "b", radius = 0.5, at = { 2, 0, 0 }, mass = 1, velocity = { -1, 0, 0 } }
  local merged, split = 0, 0
  world:on("merged", function(e) merged = merged + 1; expect(e.dig):is_not(nil) end)
  world:on("split", function(e) split = split + 1; expect(e.other_dig):is_not(nil) end)
  expect(a.dig == b.dig):is(false)
  expect(#world:digs()):is(2)
  s:eventually("met", "2 s", function() return merged == 1 end)
  expect(a.dig == b.dig):is(true)
  expect(a.dig.size):is(2)
  expect(a.velocity):near({ -0.5, 0, 0 }, "1 mm/s")        -- restitution 0: they go on together
  b:hit { impulse = { 1, 0, 0 } }
  s:eventually("parted", "2 s", function() return split == 1 end)
  expect(a.dig == b.dig):is(false)
  expect(a.dig.size):is(1)
end)

scenario("who acts on whom, through whom", function(s)
  local world = s.world
  local floor = world:floor {}
  local low = world:box { name = "low", size = 0.2, at = { 0, 0.1, 0 }, mass = 1 }
  local high = world:box { name = "high", size = 0.2, at = { 0, 0.3, 0 }, mass = 1 }
  s:settle "1 s"
  expect(high:neighbours()):is { low }
  expect(low:neighbours { kind = "contact" }):contains(floor)
  expect(low:neighbours { kind = "joint" }):is_empty()
  expect(low.dig == high.dig):is(true)
  expect(floor.dig):is(nil)
  expect(low.dig.size):is(2)
  expect(low.dig:members()):is { low, high }
  expect(digbox.path(high, floor)):is { high, low, floor }
  expect(high:links()[1].kind):is "contact"
  expect(#high:links()[1].effort):near("9.81 N", "0.1 N")
  expect(high:dig_of "mechanical"):is(high.dig)
  expect(high:dig_of "electrical"):is(nil)
  expect(function() high:neighbours { kind = "contakt" } end):fails()
end)

scenario("messages reach who they are sent to", function(s)
  local world = s.world
  world:floor {}
  local low = world:box { name = "low", size = 0.2, at = { 0, 0.1, 0 } }
  local high = world:box { name = "high", size = 0.2, at = { 0, 0.3, 0 } }
  local got = {}
  world:on("message", { kind = "hello" }, function(e) got[#got + 1] = e end)
  s:settle "0.5 s"
  high:send(low, "hello", digbox.vec(1, 2, 3))
  world:step(2)
  expect(#got):is(1)
  expect(got[1].from):is(high)
  expect(got[1].to):is(low)
  expect(got[1].value):is(1.0)
  expect(got[1].values):is { 1.0, 2.0, 3.0, 0.0 }
  low.dig:broadcast("hello", 7)
  world:step(2)
  expect(#got):is(3)
  local all = world:messages()
  expect(all[#all].kind):is "hello"
  expect(high:flood("hello", 1)):at_least(1)
end)

scenario("tasks wait for times and for conditions", function(s)
  local world = s:world { step = 0.01 }
  local ball = world:ball { radius = 0.1, at = { 0, 10, 0 } }
  local log = {}
  world:spawn(function(task)
    log[#log + 1] = world.time
    task:wait()                           -- until after the next step
    expect(world.steps):is(1)
    task:wait(0.5 - world.time)
    log[#log + 1] = world.time
    log[#log + 1] = task:wait_until(function() return ball.position.y < 8 end, "3 s")
    log[#log + 1] = world.time
    log[#log + 1] = task:wait_until(function() return false end, "0.1 s")
  end)
  expect(world.tasks):is(1)
  world:run(2)
  expect(world.tasks):is(0)
  expect(log[1]):is(0.0)
  expect(log[2]):near(0.5, 1e-9)
  expect(log[3]):is(true)
  expect(log[4]):near(math.sqrt(4 / 9.81), 0.011)
  expect(log[5]):is(false)
end)

scenario("an error in a task comes out with its own line", function(s)
  local world = s.world
  world:spawn(function(task)
    task:wait(0.1)
    error "in the task"
  end)
  expect(expect(function() world:run(1) end):fails()):contains "in the task"
  expect(function() world:spawn(3) end):fails()
end)

scenario("a filter names the body by its name, too", function(s)
  local world = s.world
  world:floor()
  world:ball { name = "one", radius = 0.5, at = { 0, 0.6, 0 } }
  world:ball { name = "two", radius = 0.5, at = { 5, 0.6, 0 } }
  local met = {}
  world:on("contact_begin", { with = "two" }, function(e) met[#met + 1] = { e.a, e.b } end)
  world:run(0.5)
  expect(#met):is(1)
  expect(met[1][1].name == "two" or met[1][2].name == "two"):is(true)
  local message = expect(function() world:on("contact_begin", { with = { "one", "three" } }, print) end):fails()
  expect(message):contains "world:on.with[2]: there is no body 'three'"
end)

scenario("what breaks says where, and who is not there is not found", function()
  local world = digbox.world {}
  local post, weight = world:box { fixed = true, size = 0.1, at = { 3, 5, 1 } }, world:box { size = 0.1, mass = 1, at = { 3, 4, 1 } }
  local joint = world:weld { name = "thread", a = weight, b = post, at = { 3, 4.5, 1 }, breaks_at = 5 }
  local at
  world:on("broken", function(e) at = e.point end)
  world:run(0.1)
  expect(joint.valid):is(false)
  expect(at):near({ 3, 4.5, 1 }, 0.01)
  expect(select("#", world:find "thread")):is(1)
  expect(world:find "thread"):is(nil)
end)

scenario("members hear that their DIGs merge and split", function(s)
  local world = s.world
  world:floor()
  local low, high = world:box { size = 0.2, at = { 0, 0.1, 0 } }, world:box { size = 0.2, at = { 0, 0.6, 0 } }
  local far, heard = world:box { size = 0.2, at = { 5, 0.1, 0 } }, {}
  for _, body in ipairs { low, high, far } do
    for _, kind in ipairs { "merged", "split" } do
      body:on(kind, function(e)
        expect(e.self):is(body)
        heard[#heard + 1] = e.event
      end)
    end
  end
  world:run(1)
  expect(table.concat(heard, " ")):is "merged merged"
  high:hit { impulse = { 0, 30, 0 } }
  world:run(0.2)
  expect(table.concat(heard, " ")):is "merged merged split split"
end)

scenario("a message tells where it came from", function(s)
  local world = s.world
  local a = world:ball { radius = 0.1, at = { 1, 2, 3 }, gravity_scale = 0 }
  local b = world:ball { radius = 0.1, at = { 1, 2, 5 }, gravity_scale = 0 }
  local way
  b:on("message", function(e) way = e.direction end)
  a:send(b, "hello", 1)
  world:step()
  expect(way):near({ 0, 0, 2 }, 1e-12)
end)

-- The room for points is there, and no pair: a chain that finds no solution hands on what it never touched.
scenario("a world whose contacts are switched off in a crowd with a chain goes on", function(s)
  local world = s.world
  world:floor { material = "concrete" }
  for row = 0, 7 do
    for k = 0, 5 do
      world:box { material = "brick", size = { 0.1, 0.1, 0.2 }, at = { 0, 0.05 + 0.1 * row, (k - 2.5) * 0.2 + (row % 2) * 0.1 } }
    end
  end
  local ball = world:ball { material = "iron", radius = 0.2, at = { -2.5, 2.5, 0 } }
  world:rope { a = ball, to = { 0, 3, 0 }, segments = 10, radius = 0.015, mass = 4 }
  world:effect("contact", false)
  world:run(1)
  expect(ball.position.y):below(1)
end)
