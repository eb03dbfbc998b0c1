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

-- what is written, where, and what it is called here
local elsewhere = {
  { "world:ball { position = { 0, 1, 0 } }", "at" }, { "world:ball { pos = { 0, 1, 0 } }", "at" },
  { "world:ball { static = true }", "fixed" }, { "world:ball { isStatic = true }", "fixed" },
  { "world:ball { isKinematic = true }", "kinematic" },
  { "world:ball { weight = 1 }", "mass" }, { "world:ball { color = 'red' }", "colour" }, { "world:ball { bounciness = 1 }", "restitution" },
  { "world:ball { linearVelocity = { 1, 0, 0 } }", "velocity" }, { "world:ball { angular_velocity = { 1, 0, 0 } }", "spin" },
  { "world:ball { diameter = 1 }", "radius" }, { "world:ball { frictionCoefficient = 1 }", "friction" },
  { "world:ball { userData = 1 }", "data" }, { "world:ball { quaternion = 1 }", "rotation" },
  { "world:box { halfExtents = { 1, 1, 1 } }", "size" }, { "world:box { width = 1 }", "size" },
  { "world:addBall { radius = 1 }", "ball" }, { "world:cube { size = 1 }", "box" }, { "world:BoxGeometry(1, 1, 1)", "box" },
  { "world:ground {}", "floor" }, { "world:stepSimulation()", "step" }, { "world:simulate(3)", "run" },
  { "world:setGravity(0, -10, 0)", "gravity" },
  { "world:raycast { from = 1 }", "ray" }, { "world:getBodies()", "bodies" }, { "world:createRevoluteJoint {}", "hinge" },
  { "world:prismatic {}", "slider" }, { "world:FixedJoint {}", "weld" }, { "world:point2point {}", "ball_joint" },
  { "world:light {}", "sun" },
  { "world:draw()", "render" }, { "world:film {}", "record" }, { "world:getTime()", "time" },
  { "print(ball.pos)", "position" }, { "print(ball:getPosition())", "position" }, { "print(ball.linvel)", "velocity" },
  { "print(ball.omega)", "spin" }, { "print(ball.orientation)", "rotation" }, { "print(ball.com)", "centre" },
  { "ball:setPosition(0, 1, 0)", "teleport" }, { "ball:set_velocity { 1, 0, 0 }", "teleport" }, { "ball:applyForce { 1, 0, 0 }", "push" },
  { "ball:AddForce { 1, 0, 0 }", "push" }, { "ball:apply_impulse { 1, 0, 0 }", "hit" }, { "ball:addTorque { 1, 0, 0 }", "twist" },
  { "ball:destroy()", "remove" }, { "ball:get_contacts()", "neighbours" }, { "print(ball.sleeping)", "asleep" },
  { "ball.bounce = 1", "restitution" }, { "ball.gravity = 0", "gravity_scale" },
  { "ball:push { force = { 1, 0, 0 }, duration = 1 }", "lasts" }, { "ball:push { force = 1, direction = { 1, 0, 0 } }", "along" },
  { "ball:hit { force = { 1, 0, 0 } }", "impulse" }, { "ball:twist { torque = 1, axis = { 1, 0, 0 } }", "along" },
  { "ball:teleport { position = { 0, 1, 0 } }", "at" }, { "ball:on('collision', print)", "contact_begin" },
  { "world:on('onCollisionEnter', print)", "contact_begin" }, { "world:on('EndContact', print)", "contact_end" },
  { "world:run { duration = 1 }", "seconds" }, { "world:camera { position = { 1, 1, 1 } }", "at" },
  { "world:camera { at = { 1, 1, 1 }, target = ball }", "look_at" }, { "world:record { file = 'a.mp4' }", "to" },
  { "world:render { to = 'a.png', width = 640 }", "size" }, { "digbox.world { dt = 0.01 }", "step" }, { "digbox.createWorld()", "world" },
  { "digbox.Vector3(1, 2, 3)", "vec" }, { "world:hinge { bodyA = ball }", "a" }, { "world:hinge { a = ball, connectedBody = ball }", "b" },
  { "world:hinge { a = ball, anchor = { 0, 1, 0 } }", "at" }, { "world:hinge { a = ball, lower = 1 }", "limits" },
  { "world:spring { a = ball, k = 100 }", "stiffness" }, { "world:spring { a = ball, stiffness = 1, rest_length = 1 }", "length" },
  { "world:bucket { radius = 1 }", "top_radius" }, { "world:water { depth = 1 }", "level" },
  { "world:region { at = { 0, 1, 0 }, gravity = { 0, 1, 0 } }", "laws" }, { "print(ball.velocity:magnitude())", "length" },
  { "print(ball.velocity:normalize())", "normalized" },
  { "world:weld { a = ball, breakForce = 10 }", "breaks_at" }, { "world:ball { radius = 1, material = 'metal' }", "steel" },
}

scenario("what has another name elsewhere is known by its meaning", function(s)
  local env = { world = s.world, digbox = digbox, print = print, ball = s.world:ball { radius = 0.1, at = { 0, 1, 0 } } }
  for _, case in ipairs(elsewhere) do
    local text = expect(assert(load(case[1], "=line", "t", env))):fails()
    local meant = text:match "did you mean '([^']*)'"
    if meant ~= case[2] then expect(case[1] .. ": " .. text):is(case[2]) end
  end
  local world, ball = s.world, env.ball
  says(function() world:add { shape = "box" } end, "world has no field or method 'add' "
    .. "(things are made by their kind: world:ball{...}, world:box{...})")
  expect((message_of(function() world:on("update",
    print) end))):contains "world:spawn(function(task) while true do ... task:wait() end end)"
  expect((message_of(function() world:joint { type = "hinge" } end))):contains "joints are made by their kind"
  expect((message_of(function() ball.onCollision = print end))):contains "body:on('contact_begin', function(e) ... end)"
  says(function() return digbox.ball { radius = 1 } end,
    "digbox has no function 'ball': it is one of a world (world:ball); as a shape digbox.sphere")
  says(function() return digbox:world {} end, "digbox.world is called with a point: digbox.world{...}")
  says(function() world:sun { direction = { 0, -1, 0 } } end, "world:sun: unknown field 'direction' "
    .. "(from = {3, 6, 2} is where its light comes from)")
  says(function() world:room {} end, "world:room: size is missing (from wall to wall)")
  expect((message_of(function() ball.k = 1 end))):contains "(known: "             -- not the nearest letter
end)

scenario("fields have names, and an error shows how they are written", function(s)
  local world = s.world
  local ball = world:ball { radius = 0.1, at = { 0, 1, 0 } }
  says(function() world:ball { 1, 2, 3 } end, "world:ball: unknown field 1 (fields have names: world:ball{ radius = 0.1, at = {0, 1, 0} })")
  says(function() ball:push { 0, 0, 5 } end, "body:push: unknown field 1 (fields have names: body:push{ force = {0, 0, 5} })")
  says(function() world:hinge(ball, ball) end, "world:hinge wants a table of fields; got body "
    .. "(write world:hinge{ a = door, b = frame, at = {0, 1, 0}, axis = {0, 1, 0} })")
  says(function() world:record "film.mp4" end, "world:record wants a table of fields; got string (write world:record{ to = 'film.mp4' })")
  says(function() return #world.bodies end, "bodies is a method: #world:bodies()")
  says(function() world.gravity = -9.81 end, "world.gravity wants a vector {x, y, z}; got number (y is up: {0, -9.81, 0})")
  says(function() world:camera { at = ball } end, "world:camera.at wants a vector {x, y, z}; got body (its place is body.position)")
  says(function() world:hinge { a = ball, axis = "z" } end, "world:hinge.axis wants a vector {x, y, z}; got string (z is {0, 0, 1})")
  says(function() ball:push { force = 1, along = "-y" } end, "body:push.along wants a vector {x, y, z}; got string (y, up, is {0, 1, 0})")
  says(function() world:ball { radius = 1, colour = { 255, 0, 0 } } end,
    "world:ball: colour.x = 255, must be at most 1.0 (write {1, 0.5, 0}, '#ff8000' or a name)")
  says(function() world:step(0.1) end, "world:step wants a whole number of steps >= 0; got 0.1 (world:run goes by time)")
  says(function() ball.force = { 1, 0, 0 } end, "body.force is state and cannot be assigned: use :push or :hit")
  says(function() ball.fixed = true end, "body #0: 'fixed' is decided when a body is made"
    .. " (what is held for a while is welded to the world, until the weld is removed)")
end)

-- 10 / 2 is 5.0 in Lua
scenario("a whole number may come from a division", function(s)
  local world = s.world
  world:step(10 / 2)
  expect(world.steps):is(5)
  world:run { steps = 10 / 2 }
  expect(world.steps):is(10)
  world:heightfield { columns = 8 / 2, rows = 8 / 2, size = { 1, 1 }, height = function() return 0 end }
  local block = world:lattice { at = { 0, 3, 0 }, size = 0.2, mass = 1, stiffness = 100 }
  expect(block:node(4 / 2, 2, 2)):is(block:node(2, 2, 2))
  world:render { to = "half.png", size = { 128 / 2, 72 / 2 } }
  expect(function() world:render { to = "half.png", size = { 128 / 3, 72 } } end):fails "must be a whole number from 1 to 16384"
  expect(function() world:step(1 / 2) end):fails "whole number of steps >= 0; got 0.5"
  expect(function() world:step "5" end):fails "whole number of steps >= 0; got 5"
end)

scenario("a sweep that says no way is refused", function(s)
  local world = s.world
  world:ball { radius = 0.1, at = { 1, 0, 0 } }
  local wants = "world:sweep wants a way: from, and to or along, or at and velocity"
  expect(function() world:sweep { sphere = { radius = 0.1 } } end):fails(wants)
  expect(world:sweep { sphere = { radius = 0.1 }, velocity = { 2, 0, 0 } }.fraction):near(0.4, 1e-6)
end)

-- Every answer of lua/bind_mean.c's examples is a call that works
scenario("what an error shows can be written", function(s)
  local world = s.world
  local env = { world = world, digbox = digbox, body = world:ball { radius = 0.1, at = { 0, 9, 0 } } }
  for _, call in ipairs { "world:ball", "world:sphere", "world:box", "world:capsule", "world:cylinder", "world:cone",
    "world:rod", "world:room",
    "world:floor", "world:plane", "digbox.sphere", "digbox.box", "digbox.capsule", "digbox.cylinder", "body:push", "body:hit", "body:twist",
    "body:teleport", "body:can_move", "world:sun", "world:lamp", "world:ray", "digbox.world" } do
    local text = expect(assert(load(call .. "{ 1 }", "=line", "t", env))):fails()
    local example = text:match "fields have names: (.*)%)$" or text:match "write (.*)%)$"
    if not example then expect(call .. ": " .. text):is "an example" end
    assert(load(example, "=line", "t", env))()
  end
end)

scenario("a handler that takes the event for a body hears of it", function(s)
  local world = s.world
  world:floor {}
  local ball = world:ball { radius = 0.1, at = { 0, 0.2, 0 } }
  local sub = ball:on("contact_begin", function(other) print(other.name) end)
  local text = expect(function() world:run(1) end):fails()
  expect(text):contains "event has no field 'name' (a handler gets an event, with its bodies: e.self, e.other)"
  sub:off()
  ball:teleport { at = { 0, 1, 0 } }
  local seen
  ball:on("contact_begin", function(e)
    e.note = "own"
    seen = { e.note, e.joint, e[1], e.other.kind, pcall(function() return e.position end) }
  end)
  world:run(1)
  expect(seen[1]):is "own"
  expect(seen[2]):is(nil)
  expect(seen[#seen]):contains "event has no field 'position' (did you mean 'point'?)"
end)
