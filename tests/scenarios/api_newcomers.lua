-- api_newcomers.lua: what somebody writes who knows other programs and the first page: it works, or the error says what to write.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- The message without its position, and the position's line.
local function message_of(fn)
  local text = expect(fn):fails()
  local line, rest = text:match "^[^:]*api_newcomers%.lua:(%d+): (.*)$"
  expect(line):is_not(nil)
  return rest or text, tonumber(line)
end

local function says(fn, wanted)
  expect((message_of(fn))):is(wanted)
end

-- A tail call gives up the frame of who makes it; functions in C leave it, so ours that are written in Lua are called through one.
scenario("an error after a tail call names the line of the call", function(s)
  local world = s.world
  local ball = world:ball { radius = 0.1, at = { 0, 1, 0 } }
  local base = select(2, message_of(function() error "here" end))
  local calls = {
    function() return error "own" end,
    function() return world:ball { raduis = 1 } end,
    function() return world:record { too = "x" } end,
    function() return ball:on("contact_begni", print) end,
    function() return digbox.load(3) end,
    function() return digbox.parts.clock { hours = 1 } end,
    function() return digbox.material "cork" end,
    function() return string.format("%d", "x") end,
    function() return ("%d"):format "x" end,
    function() return string.pack("i17", 1) end,
    function() return utf8.codepoint("abc", 9) end,
    function() return tonumber("z", 99) end,
    function() return setmetatable(1, {}) end,
  }
  for i, call in ipairs(calls) do
    local text, line = message_of(function() call() end)
    if line ~= base + 1 + i then expect(text):is("line " .. base + 1 + i .. ", not " .. line) end
  end
  says(function() return string.format("%d", 1.5) end, "bad argument #2 to 'format' (number has no integer representation)")
  says(function() return ("%d"):format(1.5) end, "bad argument #1 to 'format' (number has no integer representation)")
  says(function() return utf8.codepoint("abc", 9) end, "bad argument #3 to 'codepoint' (out of bounds)")
end)

scenario("what a method of ours waits for may be waited for after a tail call, too", function(s)
  local times = {}
  s.world:spawn(function(task)
    local function pause() return task:wait "0.1 s" end
    pause()
    times[#times + 1] = s.world.time
    return task:wait(0.1)
  end)
  s.world:run(0.5)
  expect(times[1]):near(0.1, 1e-9)
  expect(s.world.tasks):is(0)
end)

scenario("b = world is a joint to the world", function(s)
  local world = s.world
  local a = world:box { size = 0.2, at = { 0, 2, 0 } }
  local hinge = world:hinge { a = a, b = world, at = { 0, 2, 0 }, axis = { 0, 0, 1 } }
  expect(hinge.b):is(nil)
  world:bolt { holds = world:box { size = 0.1, at = { 1, 2, 0 } }, into = world }
  world:spring { a = world:ball { radius = 0.1, at = { 2, 2, 0 } }, b = world, at = { 2, 3, 0 }, stiffness = 10 }
  world:rope { a = world:ball { radius = 0.1, at = { 3, 2, 0 } }, b = world, at = { 3, 3, 0 } }
  local rope = world:rope { a = world:ball { radius = 0.1, at = { 4, 2, 0 } }, b = world, at = { 4, 3, 0 }, segments = 3, length = 1 }
  expect(#rope.bodies):at_least(3)
  says(function() world:weld { a = world, b = a } end, "world:weld.a wants a body; got world (give the body as a, and b = world or no b)")
  says(function() world:weld { a = a, b = digbox.world {} } end,
    "world:weld.b wants a body; got another world (what is held by the world has none)")
  says(function() world:weld { a = "box" } end, "world:weld.a wants a body; got the text 'box' (world:find gives the body of a name)")
  says(function() world:weld { a = rope } end, "world:weld.a wants a body; got rope")
end)

scenario("a motor, limits and a spring are taken away with nil or false", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local a = world:box { size = 0.2, at = { 0, 2, 0 } }
  local hinge = world:hinge { name = "h", a = a, at = { 0, 2, 0 }, axis = { 0, 0, 1 }, motor = { speed = 3, max_torque = 5 },
    limits = { -1, 1 }, spring = false }
  hinge.motor = nil
  expect(hinge.motor):is { max_torque = math.huge }
  hinge.limits = false
  expect(hinge.limits):is(nil)
  hinge:set { motor = { speed = 2 }, limits = { -2, 2 }, spring = { stiffness = 3 }, friction = 1, breaks_at = 7 }
  hinge:set { motor = false, limits = false, spring = false, friction = false, breaks_at = false }
  expect(hinge.motor.speed):is(nil)
  expect(hinge.limits):is(nil)
  expect(hinge.spring.stiffness):is(0)
  expect(hinge.friction):is(0)
  expect(hinge.breaks_at):is(math.huge)
  a:teleport { spin = { 0, 0, 3 } }
  s:settle "2 s"
  expect(hinge.angle):near(6, 1e-3)                     -- nothing drives or stops it
  local motor = world:motor { a = a, along = { 0, 0, 1 }, speed = 3 }
  says(function() motor.speed = nil end, "joint.speed cannot be taken away, it has to have a value")
  expect(motor.speed):is(3)
end)

scenario("what is read of a joint in tables cannot be changed there", function(s)
  local world = s.world
  local hinge = world:hinge { a = world:box { size = 0.2, at = { 0, 2, 0 } }, at = { 0, 2, 0 }, axis = { 0, 0, 1 },
    motor = { speed = 3, max_torque = 5 }, limits = { -1, 2 } }
  says(function() hinge.motor.speed = 5 end, "joint.motor is a copy, changing it would change nothing: "
    .. "write joint.motor = { speed = 5 }; what is not given stays")
  says(function() hinge.limits[1] = 5 end, "joint.limits is a copy, changing it would change nothing: write joint.limits = { ..., ... }")
  expect(tostring(hinge.motor)):is "{max_torque = 5.0, speed = 3.0}"
  expect(tostring(hinge.limits)):is "{-1.0, 2.0}"
  expect(#hinge.limits):is(2)
  expect({ table.unpack(hinge.limits) }):is { -1, 2 }
  expect(hinge.limits):is { -1, 2 }
  expect(hinge.limits):is_not { -1, 3 }
  local names = {}
  for name in pairs(hinge.motor) do names[#names + 1] = name end
  expect(names):is { "max_torque", "speed" }
  local box = world:box { size = 0.2, at = { 1, 2, 0 } }
  local other = world:hinge { a = box, axis = { 0, 0, 1 }, motor = hinge.motor, limits = hinge.limits }
  expect(other.motor):is { speed = 3, max_torque = 5 }
  other:set { motor = { speed = 1 } }
  hinge.motor = other.motor
  expect(hinge.motor.speed):is(1)
end)

scenario("a joint that lets its bodies touch is told so later, too", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local a = world:box { name = "a", size = 0.2, at = { 0, 0, 0 }, fixed = true }
  local b = world:box { name = "b", size = 0.2, at = { 0.5, 0, 0 }, velocity = { -1, 0, 0 } }
  local rail = world:slider { a = b, b = a, along = { 1, 0, 0 } }
  expect(rail.collides):is(false)
  rail.collides = true
  expect(rail.collides):is(true)
  s:settle "1 s"
  expect(b.position.x):at_least(0.199)                  -- it came to a halt at the other
  rail:set { collides = false }
  b:teleport { velocity = { -0.5, 0, 0 } }
  s:settle "1 s"
  expect(b.position.x):below(0)
  local gear = world:gear { a = world:hinge { a = world:ball { radius = 0.1, at = { 3, 0, 0 } } },
    b = world:hinge { a = world:ball { radius = 0.1, at = { 4, 0, 0 } } }, ratio = { 1, 2 } }
  expect(gear.collides):is(true)
  expect((message_of(function() gear.collides = false end))):is "gear: collides is a matter of the joints it couples"
  says(function() rail.collides = 1 end, "joint.collides wants true or false; got number")
end)

scenario("what a joint cannot be told is refused with what can", function(s)
  local world = s.world
  local hinge = world:hinge { a = world:box { size = 0.2, at = { 0, 2, 0 } }, at = { 0, 2, 0 }, axis = { 0, 0, 1 } }
  says(function() return hinge.frction end, "hinge has no field or method 'frction' (did you mean 'friction'?)")
  says(function() hinge.angle = 1 end, "joint.angle is state and cannot be assigned: a motor or a spring of the joint brings it there "
    .. "(digbox api world:hinge)")
  says(function() hinge.a = hinge.a end, "joint.a cannot be assigned")
end)

scenario("numbers of radians that are hardly meant to be are refused with both ways to write them", function(s)
  local world = s.world
  local a = world:box { size = 0.2, at = { 0, 2, 0 } }
  local hinge = world:hinge { a = a, at = { 0, 2, 0 }, axis = { 0, 0, 1 }, limits = { "-90 deg", "90 deg" } }
  local hint = " is 14.3 turns: write '90 deg' if degrees are meant, else '90 rad'"
  says(function() world:hinge { a = a, limits = { 0, 90 } } end, "world:hinge.limits = 90 rad" .. hint)
  says(function() hinge.limits = { 0, 90 } end, "joint.limits = 90 rad" .. hint)
  says(function() world:hinge { a = a, spring = { stiffness = 1, rest = 90 } } end, "world:hinge.spring.rest = 90 rad" .. hint)
  says(function() world:ball_joint { a = a, swing = 90 } end, "world:ball_joint.swing = 90 rad" .. hint)
  says(function() world:camera { at = { 1, 1, 1 }, fov = 90 } end, "world:camera.fov = 90 rad" .. hint)
  says(function() a:can_move { turn = { 0, 1, 0 }, by = 90 } end, "body:can_move.by = 90 rad" .. hint)
  hinge.limits = { -20 * math.pi, "90 rad" }            -- many turns
  hinge.limits = { -6.2, math.huge }
  world:slider { a = world:box { size = 0.2, at = { 3, 2, 0 } }, limits = { -90, 90 } }
  says(function() world:box { size = 1, rotation = { 0, 90, 0 } } end,
    "world:box.rotation wants {axis = {0, 1, 0}, angle = '90 deg'} or {x, y, z, w}; got 3 components")
end)
