-- api_errors.lua: what the API says when it is misused: the script's line, what, which, value, unit, bound. Never ignored.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- The message without its position, and the position's line.
local function message_of(fn)
  local text = expect(fn):fails()
  local line, rest = text:match "^[^:]*api_errors%.lua:(%d+): (.*)$"
  expect(line):is_not(nil)
  return rest or text, tonumber(line)
end

local function says(fn, wanted)
  expect((message_of(fn))):is(wanted)
end

scenario("an unknown field is named, with the one that was meant", function(s)
  local world = s.world
  says(function() world:sphere { radus = 0.1 } end, "world:sphere: unknown field 'radus' (did you mean 'radius'?)")
  says(function() world:ball { radius = 0.1, frictoin = 1 } end, "world:ball: unknown field 'frictoin' (did you mean 'friction'?)")
  says(function() world:hinge { axsi = { 0, 1, 0 } } end, "world:hinge: unknown field 'axsi' (did you mean 'axis'?)")
  says(function() world:bucket { heigt = 1 } end, "world:bucket: unknown field 'heigt' (did you mean 'height'?)")
  says(function() world:rod { lenght = 1 } end, "world:rod: unknown field 'lenght' (did you mean 'length'?)")
  says(function() world:sun { form = { 1, 1, 1 } } end, "world:sun: unknown field 'form' (did you mean 'from'?)")
  says(function() digbox.world { gravty = 0 } end, "digbox.world: unknown field 'gravty' (did you mean 'gravity'?)")
  says(function() digbox.box { siez = 1 } end, "digbox.box: unknown field 'siez' (did you mean 'size'?)")
  says(function() world:sphere { 0.1 } end,
    "world:sphere: unknown field 1 (fields have names: world:sphere{ radius = 0.1, at = {0, 1, 0} })")
  expect((message_of(function() world:sphere { zzzzzz = 1 } end))):contains "(known: at, collides, colour, "
  says(function() return world:snapshot().restore end, "snapshot has no field or method 'restore': it has none")
end)

scenario("a hull needs a few points that span something", function(s)
  local world, flat = s.world, "world:hull: hull needs 4 points not in one plane "
  local function hull(n, point)
    local points = {}
    for i = 1, n do points[i] = point(i) end
    return (message_of(function() world:hull { points = points } end))
  end
  expect(hull(0)):is(flat .. "(got 0)")
  expect(hull(3, function(i) return { i, i * i, 0 } end)):is(flat .. "(got 3)")
  expect(hull(4, function(i) return { i, i * i, 1 } end)):is(flat .. "(the 4 given lie in one plane)")
  expect(hull(4, function() return { 1, 2, 3 } end)):is(flat .. "(the 4 given are one point)")
  expect(hull(65535, function(i) return { i, i, 0 } end)):is(flat .. "(the 65535 given lie on one line)")
  local one = { 1, 1, 1 }
  expect(hull(1000000, function() return one end)):is "world:hull.points has 1000000 entries, must have at most 65535"
  expect(hull(5, function(i) return { i, i == 3 and 0 / 0 or i * i, i ^ 3 } end)):is "world:hull.points[3].y = nan, must be a finite number"
  expect(#world:bodies()):is(0)
end)

-- Lua's own order of a table's keys is another one in every run.
scenario("of several mistakes the first in the alphabet is told, in every run", function(s)
  local world = s.world
  local a, b = world:ball { radius = 1 }, world:ball { radius = 1, at = { 0, 3, 0 } }
  local hinge = world:hinge { name = "h", a = a, b = b, at = { 0, 1, 0 }, axis = { 0, 0, 1 } }
  says(function() a:send(b, "x", { zone = 3, at = 1, after = 2, when = 4 }) end,
    "body:send: a message carries numbers without names; got 'after'")
  says(function() a:send(b, "x", { 1, 2, [true] = 3 }) end, "body:send: a message carries a list of numbers; a key of it is a boolean")
  says(function() hinge:set { speed = 1, motor = "x", limits = 3, breaks_at = -2, zeal = 1 } end,
    "joint 'h': breaks_at = -2 N, must be >= 0")
  local friction = hinge.friction
  says(function() hinge:set { friction = friction + 1, motor = "x" } end, "joint.motor wants a table; got string")
  expect(hinge.friction):is(friction)                       -- nothing is half done
  says(function() hinge:set { [print] = 1, friction = 1 } end, "joint:set: a parameter has a name; got a function")
  says(function() world:ball { [true] = 1, [7] = 2, [-2.5] = 3, [print] = 4, radus = 1 } end,
    "world:ball: unknown field -2.5 (fields have names: world:ball{ radius = 0.1, at = {0, 1, 0} })")
  says(function() world:ball { [print] = 4, [true] = 1, [{}] = 1 } end,
    "world:ball: unknown field boolean (fields have names: world:ball{ radius = 0.1, at = {0, 1, 0} })")
  says(function() world:record { to = "x-%d.png", fps = -1, crf = -1, bitrate = 1 } end, (message_of(function()
    world:record { bitrate = 1, crf = -1, fps = -1, to = "x-%d.png" }
  end)))
end)

scenario("a far-off name lists what is known", function(s)
  local text = message_of(function() s.world:sphere { flavour = 1 } end)
  expect(text):contains "world:sphere: unknown field 'flavour' (known: "
  expect(text):contains "radius"
  expect(text):contains "restitution"
end)

scenario("a wrong dimension says both", function(s)
  local world = s.world
  says(function() world:sphere { radius = "5 kg" } end, "world:sphere.radius wants a length; '5 kg' is a mass")
  says(function() world:sphere { radius = "5 cm", mass = "5 cm" } end, "world:sphere.mass wants a mass; '5 cm' is a length")
  says(function() world:run "3 m" end, "world:run wants a time; '3 m' is a length")
  says(function() world:sphere { radius = "5" } end, "world:sphere.radius: '5' has no unit (write '5 m' or a plain number)")
  says(function() world:sphere { radius = "5 furlong" } end, "world:sphere.radius: '5 furlong': unknown unit 'furlong'")
  says(function() world:box { size = { "1 m", "2 kg", 1 } } end, "world:box.size.y wants a length; '2 kg' is a mass")
  says(function() world:sphere { radius = {} } end, "world:sphere.radius wants a number or a string such as '1 m'; got table")
  local ball = world:sphere { radius = 1 }
  says(function() ball:push { force = "5 kg", along = { 1, 0, 0 } } end, "body:push.force wants a force; '5 kg' is a mass")
end)

scenario("a value out of bounds comes with its unit and the bound", function(s)
  local world = s.world
  says(function() world:box { name = "plank 7", size = 1, mass = -3 } end, "body 'plank 7': mass = -3 kg, must be > 0")
  says(function() world:box { name = "plank 7", size = 1, mass = 0 } end, "body 'plank 7': mass = 0 kg, must be > 0")
  says(function() world:box { name = "plank 7", size = 1, friction = -1 } end, "body 'plank 7': friction = -1, must be >= 0")
  says(function() world:sphere { radius = -1 } end, "world:sphere: radius = -1 m, must be > 0")
  says(function() world:sphere { radius = 0 } end, "world:sphere: radius = 0 m, must be > 0")
  says(function() world:box { size = { 1, 0, 1 } } end, "world:box: size.y = 0 m, must be > 0")
end)

scenario("no number that is not finite gets in", function(s)
  local world = s.world
  local nan, before = 0 / 0, s.world:checksum()
  says(function() world:sphere { name = "b", radius = 1, mass = nan } end, "body 'b': mass = nan kg, must be a finite number")
  says(function() world:sphere { radius = nan } end, "world:sphere: radius = nan m, must be a finite number")
  says(function() world:sphere { radius = 1, at = { 0, nan, 0 } } end, "world:sphere.at.y = nan, must be a finite number")
  says(function() world:sphere { radius = 1, at = { 0, 1 / 0, 0 } } end, "world:sphere.at.y = inf, must be a finite number")
  expect(world:checksum()):is(before)
  local ball = world:sphere { radius = 1 }
  before = world:checksum()
  says(function() ball:push { force = { nan, 0, 0 } } end, "body:push.force.x = nan, must be a finite number")
  says(function() ball:hit { impulse = { 0, 0, 1 / 0 } } end, "body:hit.impulse.z = inf, must be a finite number")
  says(function() ball:teleport { velocity = { 0, nan, 0 } } end, "body:teleport.velocity.y = nan, must be a finite number")
  says(function() world.gravity = { 0, nan, 0 } end, "world.gravity.y = nan, must be a finite number")
  says(function() world:run(nan) end, "world:run = nan, must be a finite number")
  expect(world:checksum()):is(before)
end)

scenario("a removed body is named, with the line that removed it", function(s)
  local world = s.world
  local crate = world:box { name = "crate", size = 1 }
  local other = world:box { name = "other", size = 1, at = { 3, 0, 0 } }
  local pin = world:hinge { name = "pin", a = crate, b = other, at = { 1, 0, 0 }, axis = { 0, 1, 0 } }
  local _, line = message_of(function() error("here", 1) end)
  crate:remove()
  local removed = ("body 'crate' was removed at %s:%d"):format("tests/scenarios/api_errors.lua", line + 1)
  local function gone(fn)
    local text = message_of(fn)
    expect(text:gsub("at .*/", "at ")):is(removed:gsub("at .*/", "at "))
  end
  gone(function() return crate.position end)
  gone(function() crate:push { force = { 1, 0, 0 } } end)
  gone(function() crate:remove() end)
  gone(function() crate.friction = 1 end)
  gone(function() return other:touches(crate) end)
  expect(crate.valid):is(false)
  expect(crate.name):is "crate"
  expect(pin.valid):is(false)
  expect((message_of(function() return pin.angle end))):contains "joint 'pin' was removed with its body at"
end)

scenario("a slot that is used again does not bring a handle back", function(s)
  local world = s.world
  local first = world:sphere { name = "first", radius = 1 }
  first:remove()
  local second = world:sphere { name = "second", radius = 1 }
  expect(first.valid):is(false)
  expect(first == second):is(false)
  expect((message_of(function() return first.mass end))):contains "body 'first' was removed at"
end)

scenario("fields, methods, events and modules that do not exist are errors", function(s)
  local world = s.world
  local ball = world:ball { name = "ball", radius = 1 }
  says(function() return world.bll end, "world has no field or method 'bll' (did you mean 'ball'?)")
  says(function() return ball.positon end, "body 'ball' has no field or method 'positon' (did you mean 'position'?)")
  says(function() ball:psuh {} end, "body 'ball' has no field or method 'psuh' (did you mean 'push'?)")
  says(function() ball.frction = 1 end, "body has no parameter 'frction' (did you mean 'friction'?)")
  says(function() world:on("contact_begn", print) end, "world:on: unknown event 'contact_begn' (did you mean 'contact_begin'?)")
  says(function() ball:on("slpt", print) end, "body:on: unknown event 'slpt' (did you mean 'slept'?)")
  says(function() world:on("impact", { faster = 1 }, print) end,
    "world:on: unknown field 'faster' (known: faster_than, harder_than, kind, layer, region, wall, with)")
  says(function() return digbox.wrold end, "digbox has no function 'wrold' (did you mean 'world'?)")
  says(function() return ball.position.w end, "vector has no field or method 'w' (known: cross, dot, length, normalized, unpack, x, y, z)")
  says(function() world:sphere { radius = 1, material = "oka" } end, "world:sphere.material: unknown material 'oka' (did you mean 'oak'?)")
  says(function() require "nonsense" end, "module 'nonsense' not found beside the script")
end)

scenario("a body without a name is told by its number everywhere", function(s)
  local world = s.world
  local a, b = world:box { size = 1, fixed = true }, world:box { size = 1, fixed = true, at = { 3, 0, 0 } }
  local ball = world:ball { radius = 1, at = { 9, 9, 9 } }
  expect(tostring(ball)):is "body #2"
  says(function() a:push { force = { 1, 0, 0 } } end, "push: body #0 is fixed: nothing can push it")
  says(function() world:hinge { a = a, b = b } end, "world:hinge: nothing to hold: neither body #0 nor body #1 can move")
  says(function() world:hinge { a = ball, b = ball } end, "world:hinge: a and b are the same body #2")
  says(function() ball.mass = -1 end, "body #2: mass = -1 kg, must be > 0")
  ball:remove()
  expect(tostring(ball)):is "removed body #2"
end)

scenario("a body that was never made has no number, and what would have made it is named", function(s)
  says(function() s.world:box { size = 1, fixed = true, kinematic = true } end, "world:box: fixed and kinematic exclude each other")
  says(function() s.world:box { name = "b", size = 1, fixed = true, kinematic = true } end,
    "body 'b': fixed and kinematic exclude each other")
end)

scenario("what an answer, a hit or a link does not have is no nil", function(s)
  local world = s.world
  world:floor {}
  local box = world:box { size = 1, at = { 0, 0.5, 0 } }
  world:step()
  local answer = box:can_move { along = { 0, 1, 0 } }
  expect(answer.held_by):is(nil)                      -- it may have one
  says(function() return answer.verdikt end, "answer has no field 'verdikt' (did you mean 'verdict'?)")
  local hit = world:ray { from = { 0, 3, 0 }, along = { 0, -1, 0 } }[1]
  expect(hit.body):is(box)
  says(function() return hit.distanse end, "hit has no field 'distanse' (did you mean 'distance'?)")
  local link = box:links()[1]
  expect(link.joint):is(nil)
  says(function() return link.efort end, "link of a body has no field 'efort' (did you mean 'effort'?)")
end)

scenario("state cannot be assigned", function(s)
  local ball = s.world:ball { radius = 1 }
  says(function() ball.position = { 0, 1, 0 } end, "body.position is state and cannot be assigned: use :teleport")
  says(function() s.world.plane = "xy" end, "world.plane is decided when a world is made: digbox.world{ plane = ... }")
  says(function() s.world.threads = 2 end, "world.threads is decided when a world is made: digbox.world{ threads = ... }")
  says(function() s.world.time = 2 end, "world.time cannot be assigned (gravity and accuracy can)")
  says(function() ball.velocity = { 0, 1, 0 } end, "body.velocity is state and cannot be assigned: use :teleport")
  says(function() ball.postion = { 0, 1, 0 } end,
    "body has no parameter 'postion' (did you mean 'position'? it is state and cannot be assigned: use :teleport)")
  says(function() ball.position.x = 1 end, "vector.x cannot be assigned: "
    .. "vectors do not change, make another ({x, y, z}; body:teleport{ at = ... })")
  says(function() s.world.time = 1 end, "world.time cannot be assigned (gravity and accuracy can)")
end)

scenario("what is called or passed wrongly is said", function(s)
  local world = s.world
  local ball = world:ball { name = "ball", radius = 1 }
  local elsewhere = digbox.world {}
  local stranger = elsewhere:ball { name = "stranger", radius = 1 }
  says(function() world.sphere { radius = 1 } end, "expected a world, got table (methods are called with ':')")
  says(function() ball:touches(stranger) end, "body 'stranger' belongs to another world")
  says(function() ball:touches(3) end, "expected a body, got number")
  says(function() ball:touches(world) end, "expected a body, got world")
  says(function() world:sphere(3) end,
    "world:sphere wants a table of fields; got number (write world:sphere{ radius = 0.1, at = {0, 1, 0} })")
  says(function() world:sphere { radius = 1, fixed = 1 } end, "world:sphere.fixed wants true or false; got number")
  says(function() world:sphere { radius = 1, at = { 1, 2 } } end, "world:sphere.at wants {x, y, z}; component z is missing")
  says(function() world:sphere { radius = 1, at = { 1, 2, 3, 4 } } end, "world:sphere.at wants {x, y, z}; got 4 components")
  says(function() world:sphere { radius = 1, group = 1.5 } end, "world:sphere.group wants a whole number; got 1.5")
  says(function() world:sphere { radius = 1, group = "7" } end, "world:sphere.group wants a whole number; got string")
  says(function() world:sphere { radius = 1, name = ("x"):rep(100) } end, "world:sphere.name has 100 bytes, must have at most 63")
  says(function() world:sphere { radius = 1, name = "a\nb" } end, "world:sphere.name holds a control character")
  says(function() world:sphere {} end, "world:sphere: radius is missing")
  says(function() ball:push { force = 3 } end, "body:push: force is a number; it needs along = {x, y, z}")
  elsewhere:close()
  says(function() return stranger.position end, "the body's world is closed")
  says(function() elsewhere:step() end, "the world is closed")
end)

scenario("handles and vectors keep their secrets", function(s)
  local ball = s.world:ball { radius = 1 }
  expect(getmetatable(ball)):is(false)
  expect(getmetatable(ball.position)):is(false)
  expect(getmetatable("")):is(false)
  expect(function() setmetatable(ball, {}) end):fails()
  expect(rawget(_G, "os")):is(nil)
  expect(rawget(_G, "io")):is(nil)
  expect(rawget(_G, "debug")):is(nil)
  expect(rawget(_G, "package")):is(nil)
  expect(string.dump):is(nil)
  expect(load("\27Lua")):is(nil)
  expect(tostring({}):find "0x"):is(nil)
end)

scenario("an effect is named by a text, cells are whole, a heater says its power", function(s)
  local world = s.world
  local ball = world:ball { radius = 0.1 }
  local wants = "world:effect(name, on) wants the name of an effect, as in world:effect('drag', true); got "
  says(function() world:effect() end, wants .. "nil")
  says(function() world:effect({}) end, wants .. "table")
  says(function() world:effect(3, true) end, wants .. "number")
  local function lattice(cells)
    return function() world:lattice { at = { 0, 0, 0 }, size = 1, cells = cells, mass = 1, stiffness = 1 } end
  end
  says(lattice(2.5), "world:lattice.cells = 2.5, must be a whole number")
  says(lattice { 2, 2, 1.5 }, "world:lattice.cells = 1.5, must be a whole number")
  says(lattice(0), "world:lattice.cells = 0, must be at least 1")
  says(function() world:heater { on = ball } end, "world:heater: power is missing (in W; 0 for one that is to be set later)")
  expect(world:heater { on = ball, power = 0 }.power):is(0)
end)

-- A table whose length is `border`, with some 60 entries: Lua finds a border by doubling and halving, and any will do.
local function with_border(border)
  local t = load("return { " .. ("k = nil, "):rep(250) .. " }")()         -- room for keys, so that none moves to the array part
  local low, high = 0, 1
  while high <= border do
    t[high] = 1
    low, high = high, 2 * high
  end
  while high - low > 1 do
    local middle = (low + high) // 2
    if middle <= border then t[middle], low = 1, middle else high = middle end
  end
  return t
end

-- Lengths that are negative as a number of 32 bits: five entries too few were made room for, and six written.
scenario("lists with holes may have any length", function(s)
  local world, corners = s.world, { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 0, 1 } }
  local long = with_border(2 ^ 32 - 5)
  expect(#long):is(2 ^ 32 - 5)
  says(function() world:mesh { vertices = corners, triangles = { long, { 1, 2, 3, 1, 2, 3 } }, fixed = true } end,
    "world:mesh.triangles has more than 4000000 entries")
  says(function() world:mesh { vertices = corners, triangles = long, fixed = true } end,
    "world:mesh.triangles has 4294967291 entries, must have at most 4000000")
  local seen = {}
  local ball = world:ball { radius = 0.1, at = { 0, 5, 0 } }
  world:add_effect { name = "longer", bodies = { ball }, step = function(_, bodies)
    seen[#seen + 1] = #bodies
    for k, v in next, with_border(2 ^ 40) do
      if k > 1 then rawset(bodies, k, v) end
    end
  end }
  world:step(2)
  expect(#seen > 1):is(true)
end)

scenario("a push that no step could follow is refused at once, and nothing of it stays", function(s)
  local world = s.world
  world:floor {}
  local crate = world:box { name = "crate", size = 0.2, mass = 1, at = { 0, 0.1, 0 } }
  says(function() crate:push { force = { 0, 0, 1e30 }, lasts = 1 } end,
    "push: 1e+30 N would bring body 'crate' to 1.66667e+28 m/s within a step, must be at most 1e+12")
  says(function() crate:push { force = { 0, 1e13, 0 }, at = { 1e3, 0, 0 } } end,
    "push: 1e+16 N m would bring body 'crate' to 2.5e+16 rad/s within a step, must be at most 1e+12")
  -- No moment now, but as soon as the crate turns: the step after that never ended.
  says(function() crate:push { force = { 1, 0, 0 }, at = { 1e140, 0.1, 0 }, lasts = 1 } end,
    "push: 1e+140 N m would bring body 'crate' to 2.5e+140 rad/s within a step, must be at most 1e+12")
  local wire = world:cylinder { radius = 0.001, height = 1, at = { 5, 5, 0 } }
  wire:push { force = { 0, 1000, 0 }, at = { 5, 5.5, 0 } }        -- along itself: what is thin gets no moment about its axis
  wire:push { force = { 0, 0, 0 }, at = { 1e200, 0, 0 } }
  says(function() crate:twist { torque = { 0, 1e30, 0 } } end,
    "twist: 1e+30 N m would bring body 'crate' to 2.5e+30 rad/s within a step, must be at most 1e+12")
  world:run(0.5)
  expect(crate.position):near({ 0, 0.1, 0 }, 1e-6)
  expect(crate.work_received):is(0)
end)

scenario("an error names the argument, the numbers there are, and nothing twice", function(s)
  local world = s.world
  local ball, other = world:ball { name = "ball", radius = 0.1 }, world:ball { name = "other", radius = 0.1, at = { 1, 0, 0 } }
  local cloth = world:cloth { at = { 0, 3, 0 }, across = { 1, 0, 0 }, down = { 0, 0, 1 }, columns = 4, rows = 5, mass = 0.1,
                              stiffness = 100 }
  says(function() cloth:node(9, 9) end, "cloth:node(9, 9, 1): there is none, of 4 columns, 5 rows")
  says(function() return digbox.path(ball) end, "path: argument 2: expected a body, got nil")
  says(function() ball:send(3, "word") end, "body:send wants a body to send to; got number")
  says(function() world:spring { a = ball, b = other } end, "world:spring: stiffness is missing")
  says(function() world:camera { at = { 1, 2, 3 }, look_at = { 1, 2, 3 } } end,
    "world:camera: at and look_at are the same point (1, 2, 3) m")
  expect(tostring(-digbox.vec(0, 1, 0))):is "(0, -1, 0)"
end)

scenario("a call that is refused changes nothing: who slept sleeps on", function(s)
  local world = s.world
  world:floor {}
  local crate = world:box { name = "crate", size = 0.2, mass = 1, at = { 0, 0.1, 0 }, temperature = 300 }
  local lift = world:box { name = "lift", kinematic = true, size = 0.2, at = { 2, 0.1, 0 } }
  local load = world:box { size = 0.2, at = { 2, 0.3, 0 } }
  s:settle "2 s"
  local far = { 1e300, 0, 0 }
  local before, energy = world:checksum(), world.energy
  local function refused(f, text)
    expect(expect(f):fails()):contains(text)
    expect(crate.asleep and load.asleep):is(true)
    expect(world:checksum()):is(before)
    expect(world.energy.work_in):is(energy.work_in)
  end
  refused(function() crate:hit { impulse = far } end, "hit: impulse = {1e+300, 0, 0} N s makes body 'crate' too fast for a number")
  refused(function() crate:hit { impulse = { 1e13, 0, 0 } } end, "too fast for a number")
  refused(function() crate:hit { impulse = { 1, 0, 0 }, at = { 0, 1e30, 0 } } end, "too fast for a number")
  refused(function() crate:push { force = far } end, "push: force")
  refused(function() crate:push { force = { 1, 0, 0 }, at = { 0, 1e300, 0 } } end, "push: inf N m")
  refused(function() crate:twist { torque = far } end, "twist: torque")
  refused(function() crate:teleport { at = { 1, 0, 0 }, velocity = far } end, "teleport: velocity")
  refused(function() crate:warm { energy = 1e300 } end, "warm: body 'crate' would have")
  refused(function() crate.mass = 1e300 end, "mass = 1e+300 kg, must be at most 1e+15 kg")
  refused(function() lift:drive { velocity = { 1, 0, 0 }, spin = far } end, "drive: spin")
  refused(function() lift:move_to { at = far, over = 1 } end, "move_to: at")
  refused(function() lift:move_to { at = { 1e14, 0, 0 } } end, "move_to: velocity = {6e+15, ")     -- such a world could not be loaded
  refused(function() lift:move_to { at = { 3, 0, 0 }, over = 1e300 } end, "move_to: over = 1e+300 s, must be at most 1e+15 s")
end)
