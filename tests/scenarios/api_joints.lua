-- api_joints.lua: every joint type from Lua: its fields, what it reads, what it refuses.
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- A bar of 1 m along x with its left end at the origin, and nothing else.
local function bar(world, fields)
  local f = { size = { 1, 0.1, 0.1 }, at = { 0.5, 0, 0 }, mass = 1, name = "bar" }
  for k, v in pairs(fields or {}) do f[k] = v end
  return world:box(f)
end

scenario("a hinge swings like a pendulum, and reads its angle", function(s)
  local world = s.world
  local b = bar(world)
  local hinge = world:hinge { name = "pivot", a = b, at = { 0, 0, 0 }, axis = { 0, 0, 1 } }
  expect(hinge.type):is "hinge"
  expect(hinge.name):is "pivot"
  expect(hinge.a):is(b)
  expect(hinge.b):is(nil)
  expect(hinge.angle):near(0, 1e-9)
  s:eventually("hangs down", "2 s", function() return hinge.angle < -1.5 end)
  -- A uniform bar let go level: omega^2 = 3 g sin(angle) / l
  expect(math.abs(hinge.speed)):near(math.sqrt(3 * 9.81 * math.sin(-hinge.angle)), "0.1 rad/s")
  expect(hinge.error):below("1 mm")
  expect(tostring(hinge)):is "hinge 'pivot'"
  expect(world:joints()):is { hinge }
  expect(world:find "pivot"):is(hinge)
end)

scenario("limits, springs and motors are tables with units", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local b = bar(world)
  local hinge = world:hinge { a = b, at = { 0, 0, 0 }, axis = { 0, 1, 0 }, limits = { "-45 deg", "45 deg" },
    motor = { speed = "10 rpm", max_torque = "5 N m" } }
  s:settle "0.5 s"
  expect(hinge.speed):near("10 rpm", "0.1 rpm")
  hinge.motor = { speed = "-10 rpm" }
  s:settle "0.5 s"
  expect(hinge.speed):near("-10 rpm", "0.1 rpm")
  hinge:set { motor = { speed = 3 } }
  s:settle "2 s"
  expect(hinge.angle):near("45 deg", "1 deg")
  expect(hinge.at_limit):is(true)
  expect(function() hinge.limits = { 1, -1 } end):fails()
  local text = expect(function() hinge.moter = {} end):fails()
  expect(text):contains "hinge has no parameter 'moter' (did you mean 'motor'?)"
end)

scenario("parameters are read as they are set, in tables of their own", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local b = bar(world)
  local hinge = world:hinge { a = b, at = { 0, 0, 0 }, axis = { 0, 1, 0 }, limits = { -1, 1 }, motor = { speed = 2, max_torque = 5 } }
  local limits, motor = hinge.limits, hinge.motor
  expect(limits[1]):is(-1)
  expect(limits[2]):is(1)
  expect(motor.speed):is(2)
  expect(motor.max_torque):is(5)
  expect(function() motor.speed = 3 end):fails()
  expect(hinge.motor.speed):is(2)
  hinge.motor = { speed = 7 }
  expect(hinge.motor.speed):is(7)
  expect(hinge.motor.max_torque):is(5)
  expect(hinge.breaks_at):is(math.huge)
  expect(world:hinge { a = b, at = { 0, 0, 0 }, axis = { 0, 1, 0 } }.limits):is(nil)
  local far = world:ball { radius = 0.1, at = { 3, 0, 0 } }
  local gear = world:gear { a = hinge, b = world:hinge { a = far, at = { 3, 0, 0 }, axis = { 0, 1, 0 } }, ratio = { 1, 12 } }
  expect(gear.ratio[2]):is(12)
end)

scenario("what is set together is checked together, and all or nothing of it is done", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local a, b = world:ball { radius = 0.1, mass = 1 }, world:ball { radius = 0.1, mass = 1, at = { 1.5, 0, 0 } }
  local range = world:distance { a = a, b = b, min = 1, max = 2 }
  range:set { min = 3, max = 4 }                    -- past the old range on either side
  range:set { min = 0.1, max = 0.2 }
  expect(range.min):is(0.1)
  expect(range.max):is(0.2)
  expect(function() range:set { breaks_at = 50, max = 0.5, min = 0.6 } end):fails()
  expect(function() range:set { max = 0.5, length = 1 } end):fails()
  expect(range.max):is(0.2)
  expect(range.breaks_at):is(math.huge)
end)

scenario("a slider keeps to its line", function(s)
  local world = s.world
  local b = bar(world)
  local slider = world:slider { a = b, along = { 1, 0, 0 }, limits = { 0, "30 cm" } }
  b:push { force = "1 N", along = { 1, 0, 0 }, lasts = "2 s" }
  s:settle "1.5 s"
  expect(slider.distance):near("30 cm", "1 mm")
  expect(b.position.y):near(0, "1 mm")
end)

scenario("ball joints, welds, distances, ropes and springs hold", function(s)
  local world = s.world
  local function hung(x, name) return bar(world, { at = { x, 0, 0 }, size = 0.2, name = name }) end
  local ball = world:ball_joint { a = hung(0, "b"), at = { 0, 0.5, 0 } }
  local weld = world:weld { a = hung(2, "w") }
  local rope = world:rope { a = hung(4, "r"), at = { 4, 1, 0 }, length = "1.2 m" }
  local mass = hung(6, "s")
  local spring = world:spring { a = mass, at = { 6, 1, 0 }, stiffness = "200 N/m", damping = "20 N s/m", length = "1 m" }
  expect(ball.type):is "ball"
  s:settle "4 s"
  expect(ball.error):below("1 mm")
  expect(weld.a.position):near({ 2, 0, 0 }, "1 mm")
  expect(rope.distance):near("1.2 m", "2 mm")
  expect(spring.distance):near(1 + 9.81 / 200, "2 mm")
end)

scenario("a gear couples two hinges by the ratio of their teeth", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local small = world:cylinder { radius = 0.1, height = 0.1, at = { 0, 0, 0 } }
  local large = world:cylinder { radius = 0.3, height = 0.1, at = { 1, 0, 0 } }
  local h1 = world:hinge { a = small, at = { 0, 0, 0 }, axis = { 0, 1, 0 }, motor = { speed = "12 rad/s", max_torque = 100 } }
  local h2 = world:hinge { a = large, at = { 1, 0, 0 }, axis = { 0, 1, 0 } }
  world:gear { a = h1, b = h2, ratio = { 1, 12 } }
  s:settle "1 s"
  expect(h1.speed):near(12, 0.05)
  expect(h2.speed):near(1, 0.01)
  expect(function() world:gear { a = h1, b = small, ratio = { 1, 2 } } end):fails()
end)

scenario("a bolt holds until it is withdrawn", function(s)
  local world = s.world
  local cabinet = world:box { name = "cabinet", fixed = true, size = 0.5, at = { 0, 1, 0 } }
  local box = world:box { name = "box", size = 0.2, at = { 0, 0.6, 0 }, mass = 2 }
  local bolt = world:bolt { name = "bolt", holds = box, into = cabinet, strength = "500 N" }
  expect(bolt.a):is(box)
  expect(bolt.b):is(cabinet)
  s:settle "1 s"
  expect(box.position):near({ 0, 0.6, 0 }, "1 mm")
  expect(#bolt.force):near("19.62 N", "0.5 N")
  bolt:withdraw()
  expect(bolt.valid):is(false)
  s:eventually("it falls", "1 s", function() return box.position.y < 0 end)
  expect(expect(function() return bolt.force end):fails()):contains "joint 'bolt' was removed at "
end)

scenario("a joint breaks at its limit and says so", function(s)
  local world = s.world
  local box = world:box { name = "box", size = 0.2, at = { 0, 2, 0 }, mass = 2 }
  local joint = world:weld { name = "glue", a = box, breaks_at = "10 N" }
  local broken
  world:on("broken", function(e) broken = e.joint and e.joint.name or "?" end)
  s:eventually("it breaks", "1 s", function() return not joint.valid end)
  expect(broken):is "glue"
  expect(function() return joint.force end):fails "joint 'glue' is no more: it broke (the event broken says when)"
end)

scenario("a joint that sleeps under more than its new limit breaks", function(s)
  local world = s.world
  local box = world:box { size = 0.2, at = { 0, 2, 0 }, mass = 10 }
  local joint = world:weld { a = box }
  s:eventually("it sleeps", "3 s", function() return box.asleep end)
  joint.breaks_at = "200 N"                                   -- it bears 98.1 N
  world:run "1 s"
  expect(joint.valid and box.asleep):is(true)
  joint.breaks_at = "50 N"
  world:run "0.1 s"
  expect(joint.valid):is(false)
end)

scenario("a rope of segments hangs between its ends", function(s)
  local world = s.world
  local a = world:box { name = "a", fixed = true, size = 0.1, at = { -1, 3, 0 } }
  local b = world:box { name = "b", fixed = true, size = 0.1, at = { 1, 3, 0 } }
  local rope = world:rope { name = "rope", a = a, b = b, length = "3 m", segments = 10, radius = "1 cm", mass = "1 kg" }
  expect(rope.mass):near(1, 1e-9)                             -- of all of it
  expect(rope.links[3].mass):near(0.1, 1e-9)
  expect(#rope.links):is(10)
  expect(#rope.joints):is(11)
  s:settle "3 s"
  local lowest = 3
  for _, link in ipairs(rope.links) do lowest = math.min(lowest, link.position.y) end
  expect(lowest):between(1.5, 2.2)
  expect(function() world:rope { a = a, b = b, length = 1, segments = 4 } end):fails()
end)

scenario("a rope of segments begins and ends at points of the world where no bodies are given", function(s)
  local world = s.world
  local rope = world:rope { at = { -1, 3, 0 }, to = { 1, 3, 0 }, length = 2.1, segments = 10, radius = 0.01, mass = 1 }
  local ball = world:ball { radius = 0.1, mass = 2, at = { 5, 1, 0 } }
  local hung = world:rope { at = { 5, 3, 0 }, b = ball, segments = 4, radius = 0.01, mass = 0.4 }
  world:run(3)
  expect(rope.error):below(1e-3)
  expect(rope.distance):near(2, 1e-3)
  expect(hung.force.y):near(-(2 + 0.4) * world.gravity:length(), 0.05)
  expect(function() world:rope { to = { 1, 3, 0 }, segments = 4 } end):fails "wants a, or at"
  expect(function() world:rope { at = { 1, 3, 0 }, segments = 4 } end):fails "wants b, or to"
  expect(function() world:rope { at = { 0, 3, 0 }, to = { 1, 3, 0 }, mass = 1 } end)
    :fails "mass is that of a rope of segments: give segments, too"
end)

scenario("a plain rope begins at `at` and ends at `to`, as one of segments does", function(s)
  local world = s.world
  local a, b = world:box { size = 1, at = { 0, 3, 0 } }, world:box { size = 1, at = { 2, 3, 0 } }
  local function length(fields) return world:rope(fields).length end
  expect(length { a = a, to = { 0, 5, 0 } }):near(2, 1e-12)
  expect(length { a = a, at = { 0, 3.5, 0 }, to = { 0, 5, 0 } }):near(1.5, 1e-12)
  expect(length { a = a, b = b, at = { 0, 3.5, 0 }, to = { 2, 3.5, 0 } }):near(2, 1e-12)
  expect(length { a = a, b = b, at = { 0, 3.5, 0 } }):near(math.sqrt(4.25), 1e-12)
  expect(length { a = a, at = { 0, 5, 0 } }):near(2, 1e-12)
  expect(expect(function() world:rope { a = a, to = { 0, 5, 0 }, at_b = { 0, 6, 0 } } end):fails()):contains "either to or at_b"
end)

scenario("a rope is not made shorter than its ends are apart, and may be taken in afterwards", function(s)
  local world = s.world
  local a = world:ball { radius = 0.1, at = { 0, 0, 0 }, name = "a" }
  expect(expect(function() world:rope { a = a, to = { 0, 2, 0 }, length = "50 cm" } end):fails())
    :contains "world:rope: length = 0.5 m, must be at least the distance of its ends (2 m)"
  world:rope { a = a, to = { 0, 2, 0 }, length = 1.99 }:remove()         -- rounded
  local rope = world:rope { a = a, to = { 0, 2, 0 } }
  for i = 1, 60 do
    rope.length = 2 - i / 100
    world:step()
  end
  expect(a.position.y):near(0.6, 1e-3)
end)

scenario("a rope of segments ends at a point of the world as the plain one does, and is asked as a joint is", function(s)
  local world = s.world
  local ball = world:ball { radius = 0.1, mass = 2, at = { 0, 1, 0 }, name = "bob" }
  local rope = world:rope { name = "line", a = ball, at = { 0, 2, 0 }, segments = 6, breaks_at = "40 N" }
  expect(rope.length):is(1)
  expect(world:find "line"):is(rope)
  expect(rope.links[6].position.y):above(rope.links[1].position.y)
  s:settle "0.5 s"
  expect(rope.force.y):near(2 * 9.81, 1e-3)                   -- N, on the ball
  expect(rope.distance):near(1, 1e-6)
  expect(rope.error):below "1 um"
  expect(rope.stress):near((2 + rope.mass) * 9.81 / 40, 1e-3)
  expect(rope.valid):is(true)
  expect(expect(function() return rope.lenth end):fails()):contains "rope has no field or method 'lenth' (did you mean 'length'?)"
  ball:push { force = { 0, -30, 0 } }
  s:eventually("it tears", "0.1 s", function() return rope.broken > 0 end)
  expect(rope.valid):is(false)
  rope:remove()
  expect(#world:bodies()):is(1)
  expect(expect(function() world:rope { a = ball, segments = 3 } end):fails()):contains "wants b, or at"
end)

scenario("a rope that begins within two boxes does not throw itself out of them", function(s)
  local world = s.world
  local a = world:box { name = "a", size = 0.2, at = { 0, 1, 0 } }
  local b = world:box { name = "b", size = 0.2, at = { 0.4, 1, 0 } }
  world:rope { a = a, b = b, length = 0.5, segments = 5 }
  world:run "0.2 s"
  expect(world.energy.total):at_most(world.energy.initial + 1e-3)
  expect(#(a.velocity - b.velocity)):below "5 cm/s"
end)

scenario("what a joint cannot be is refused, with its name", function(s)
  local world = s.world
  local b, other = bar(world), world:box { size = 0.1, at = { 5, 0, 0 } }
  local function says(fn, wanted) expect((expect(fn):fails():gsub("^.-:%d+: ", ""))):contains(wanted) end
  says(function() world:hinge { a = b, axis = { 0, 0, 0 } } end, "axis = {0, 0, 0}, must not be zero: it is a direction")
  says(function() world:hinge { a = b, limits = { 1, -1 } } end, "limits = {1.0, -1.0} rad, must have the lower bound first")
  says(function() world:hinge { name = "h", a = b, breaks_at = -1 } end, "joint 'h': breaks_at = -1 N, must be >= 0")
  says(function() world:hinge { a = b, motor = { sped = 1 } } end, "world:hinge.motor: unknown field 'sped' (did you mean 'speed'?)")
  says(function() world:hinge { a = b, motor = { speed = "1 m/s" } } end,
    "world:hinge.motor.speed wants an angular speed; '1 m/s' is a speed")
  says(function() world:hinge { a = b, b = b } end, "world:hinge")
  says(function() world:hinge { a = world } end, "world:hinge.a wants a body; got world (give the body as a, and b = world or no b)")
  says(function() world:bolt { holds = b, a = other } end, "world:bolt: holds and a are the same field")
  says(function() world:spring { a = b, stiffness = "5 N" } end, "world:spring.stiffness wants a stiffness; '5 N' is a force")
end)

scenario("numbers next to nothing are nothing, and a world that was given them can be loaded", function(s)
  local world = s:world { gravity = { 1e-300, -9.81, 0 } }
  digbox.material("thin air", { density = 1, rolling_friction = 5e-324 })
  local b = world:box { material = "thin air", size = 0.2, at = { 0, 1, 0 } }
  local motor = world:motor { a = b, along = { 0, 1, 0 }, speed = 5e-324 }
  world:region { shape = digbox.box { size = 4 }, laws = { drag = 1e-300 } }
  world:room { size = { 1e3, 1e3, 1e3 } }
  expect(motor.speed):is(0)
  motor:set { speed = 1e-251 }
  s:settle "0.1 s"
  world:save "specks.dig"
  expect(digbox.load("specks.dig"):checksum()):is(world:checksum())
end)
