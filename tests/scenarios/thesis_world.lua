-- thesis_world.lua: rows 64, 79, 80, 81, 82, 83, 85 and 90 of the behaviours: time of impact, room, plane, one frame at a time,
-- composite bodies, the edge, and every field of the thesis' Appendix B.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local g = 9.81

scenario("row 64: the time of an impact is found, far finer than the step", function(s)
  for _, h in ipairs { 0.3, 1, 2.7, 19 } do
    local world = s:world { step = 1 / 30 }
    world:floor {}
    local ball = world:ball { name = "ball", radius = 0.25, at = { 0, 0.25 + h, 0 }, restitution = 0.5 }
    local hit
    ball:on("impact", function(e) hit = hit or e end)
    s:eventually("impact", "3 s", function() return hit end)
    expect(hit.time):near(math.sqrt(2 * h / g), world.frame * 2 ^ -20)      -- as good as twenty bisections of the step
    expect(hit.speed):near(math.sqrt(2 * g * h), 1e-5 * math.sqrt(2 * g * h))
  end
end)

scenario("row 79: nothing gets out of a closed room; through an opened wall it does, and says so", function(s)
  local world = s:world { seed = 3 }
  local half = 1.5
  local room = world:room { size = { 2 * half, 2 * half, 2 * half }, restitution = 0.9, friction = 0.1 }
  local bodies = {}
  for i = 1, 24 do
    local at = { i % 3 - 1, 0.4 + (i // 3 % 3) * 0.9, i // 9 - 1 }
    local velocity = { 20 * (math.random() - 0.5), 20 * (math.random() - 0.5), 20 * (math.random() - 0.5) }
    local common = { at = at, velocity = velocity, restitution = 0.9, friction = 0.1 }
    if i % 2 == 0 then
      common.radius = 0.1
      bodies[i] = world:ball(common)
    else
      common.size = { 0.15, 0.2, 0.25 }
      bodies[i] = world:box(common)
    end
  end
  expect(#world:bodies()):is(24)                        -- the walls are no bodies
  local out = {}
  world:on("out_of_world", function(e) out[#out + 1] = e.a end)
  s:always("all are inside", "10 s", function()
    for _, b in ipairs(bodies) do
      local p = b.position
      local inside = math.max(math.abs(p.x), math.abs(p.y - half), math.abs(p.z)) < half        -- false for a NaN
      if not inside then return false end
    end
    return true
  end)
  expect(out):is_empty()
  room:open "+x"
  bodies[2]:teleport { at = { half - 0.4, 2 * half - 0.4, 0 }, velocity = { 5, 0, 0 } }
  s:eventually("it is out", "2 s", function() return #out > 0 end)
  expect(out[1]):is(bodies[2])
  expect(bodies[2].position.x):above(half)
  world:run "0.5 s"
  for _, b in ipairs(bodies) do expect(#b.position):below(1000) end         -- false for a NaN
end)

scenario("row 80: a world kept in the plane xy does not drift in z by a single bit", function(s)
  local world = s:world { plane = "xy" }
  world:floor {}
  local bodies = {}
  for i = 1, 10 do
    bodies[i] = world:box { size = { 0.2, 0.15, 0.3 }, at = { 0.03 * (i % 3), 0.2 * i, 0 }, velocity = { 0, 0, 1 },
                            spin = { 0.3, 0.2, -1 }, rotation = digbox.quat { axis = { 0, 0, 1 }, angle = 0.3 * i } }
  end
  local ball = world:ball { radius = 0.1, at = { -1, 0.1, 0.7 }, velocity = { 4, 0, 0.5 } }
  bodies[1]:push { force = { 0, 0, 50 }, lasts = "1 s" }
  local turned = 0
  s:always("in the plane", "3 s", function()
    for _, b in ipairs(bodies) do
      turned = math.max(turned, math.abs(b.spin.z))
      if b.position.z ~= 0 or world.steps > 0 and (b.velocity.z ~= 0 or b.spin.x ~= 0 or b.spin.y ~= 0) then return false end
    end
    return ball.position.z == 0.7
  end)
  expect(turned):above(0.5)                             -- and they did move in it
  expect(function() digbox.world { plane = "xw" } end):fails()
end)

scenario("row 81: one frame at a time: each step is one frame, and every quantity can be read between", function(s)
  local world = s:world { step = 0.01 }
  local ball = world:ball { name = "ball", radius = 0.1, mass = 2, at = { 0, 5, 0 }, velocity = { 1, 0, 0 } }
  local snap = world:snapshot()
  for n = 1, 20 do
    local before = ball.position
    world:step(1)
    local d, t = ball.debug, n * 0.01
    expect(world.steps):is(n)
    expect(d.prev_pos):is(before)
    expect(d.curr_pos):is(ball.position)
    expect(d.curr_pos):near({ t, 5 - g * t * t / 2, 0 }, 1e-9)
    expect(d.next_pos):near({ t + 0.01, 5 - g * (t + 0.01) ^ 2 / 2, 0 }, 1e-9)          -- where it will be
    expect(d.velocity):near({ 1, -g * t, 0 }, 1e-9)
    expect(d.res_force):near({ 0, -2 * g, 0 }, 1e-6)
  end
  local there = world:checksum()
  world:restore(snap)                                   -- rewind
  expect(world.steps):is(0)
  expect(ball.position):is(digbox.vec(0, 5, 0))
  world:step(20)
  expect(world:checksum()):is(there)
end)

scenario("row 82: two balls hit a third from both sides in one frame: the result is symmetric", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local balls = {}
  for i = -1, 1 do
    balls[i] = world:ball { name = "ball " .. i, radius = 0.1, mass = 1, at = { i, 0, 0 }, velocity = { -2 * i, 0, 0 }, restitution = 0.8 }
  end
  local hits = {}
  world:on("impact", function(e) hits[#hits + 1] = e.time end)
  world:run "0.8 s"
  expect(#hits):is(2)                                   -- both directions of a pair are reported as one
  expect(hits[1]):near(0.4, 1e-6)
  expect(hits[2]):is(hits[1])
  expect(balls[0].position):near({ 0, 0, 0 }, 1e-12)    -- rounding; a pair after the other would give centimetres
  expect(balls[-1].velocity):near({ -1.6, 0, 0 }, 1e-9)
  expect(balls[1].velocity):near({ 1.6, 0, 0 }, 1e-9)
end)

scenario("row 83: a composite body is one body: mass, centre and inertia of its parts together", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local hammer = world:body { name = "hammer", at = { 0, 0, 0 }, parts = {
    digbox.box { size = { 0.1, 0.1, 0.3 }, at = { 0, 0.5, 0 }, material = "steel" },
    digbox.box { size = { 0.04, 1, 0.04 }, at = { 0, 0, 0 }, material = "pine" } } }
  local head, handle = 7850 * 0.003, 500 * 0.0016
  expect(hammer.mass):near(head + handle, 1e-9)
  local centre = head * 0.5 / (head + handle)
  expect(hammer.centre):near({ 0, centre, 0 }, 1e-9)
  local Ixx = head * ((0.1 ^ 2 + 0.3 ^ 2) / 12 + (0.5 - centre) ^ 2) + handle * ((1 + 0.04 ^ 2) / 12 + centre ^ 2)
  expect(hammer.inertia[1][1]):near(Ixx, 1e-9)
  expect(hammer.inertia[1][2]):near(0, 1e-12)
  hammer:hit { impulse = { 0, 0, 3 }, at = { 0, -0.5, 0 } }                 -- at the end of the handle
  expect(hammer.velocity):near({ 0, 0, 3 / hammer.mass }, 1e-9)
  expect(hammer.spin):near({ -3 * (0.5 + centre) / Ixx, 0, 0 }, 1e-9)
  expect(#world:bodies()):is(1)
  -- both parts can be touched
  expect(world:ray { from = { 1, 0.5, 0 }, to = { -1, 0.5, 0 } }[1].body):is(hammer)
  expect(world:ray { from = { 1, -0.4, 0 }, to = { -1, -0.4, 0 } }[1].distance):near(0.98, 1e-9)
end)

scenario("row 85: a box balanced on an edge tips when its centre of mass passes it", function(s)
  local w, h = 0.3, 0.5
  local function tips(past)
    local world = s:world {}
    world:floor { friction = 1 }
    local turn = digbox.quat { axis = { 0, 0, 1 }, angle = -(math.atan(w / h) + math.rad(past)) }
    local box = world:box { size = { w, h, 0.2 }, at = turn:rotate { -w / 2, h / 2, 0 }, rotation = turn, friction = 1, restitution = 0 }
    world:run "4 s"
    return math.abs(box.rotation:rotate({ 0, 1, 0 }).y) < 0.1
  end
  expect(tips(-0.3)):is(false)
  expect(tips(0.3)):is(true)
end)

scenario("row 90: every field of the thesis' Appendix B can be read, and says what is so", function(s)
  local world = s.world
  world:floor {}
  local ball = world:ball { name = "ball", material = "steel", radius = 0.1, mass = 2, at = { 0, 0.5, 0 }, velocity = { 1, 0, 0 },
                            spin = { 0, 3, 0 }, restitution = 0.5, rolling_friction = 0.2 }
  local other = world:ball { name = "other", radius = 0.1, at = { 3, 0.1, 0 } }
  world:step()
  local d = ball.debug
  for _, field in ipairs { "m_id", "db_id", "mess_type", "dig_id", "mess_time", "floor", "collided", "euler", "curr_pos", "prev_pos",
    "next_pos", "curr_rot", "prev_rot",
    "next_rot", "itensor", "iti", "itiws", "mo_inertia", "res_force", "torque", "c_mass", "ang_mom", "velocity",
    "omega", "mass", "rest", "object", "sp", "matrix", "object_type" } do
    expect(d[field]):is_not(nil)
  end
  local I = 2 / 5 * 2 * 0.1 ^ 2
  expect(d.mass):is(2.0)
  expect(d.rest):is(0.5)
  expect(d.sp):is "steel"
  expect(d.object_type):is "sphere"
  expect(d.object == ball):is(true)
  expect(d.dig_id):is(ball.dig.id)
  expect(d.mo_inertia):near(I, 1e-12)
  for i = 1, 3 do
    for j = 1, 3 do
      expect(d.itensor[i][j]):near(i == j and I or 0, 1e-12)
      expect(d.iti[i][j]):near(i == j and 1 / I or 0, 1e-6)
      expect(d.itiws[i][j]):near(i == j and 1 / I or 0, 1e-6)
    end
  end
  expect(d.ang_mom):near({ 0, 3 * I, 0 }, 1e-12)
  expect(d.omega):near({ 0, 3, 0 }, 1e-12)
  expect(d.velocity):is(ball.velocity)
  expect(d.res_force):near({ 0, -2 * g, 0 }, 1e-6)
  expect(d.torque):near({ 0, 0, 0 }, 1e-9)
  expect(d.c_mass):is(ball.position)
  expect(d.prev_pos):is(digbox.vec(0, 0.5, 0))
  expect(d.matrix[1][4]):near(ball.position.x, 1e-15)
  expect(d.matrix[2][4]):near(ball.position.y, 1e-15)
  expect(d.matrix[4][4]):is(1.0)
  expect(d.matrix[1][1]):near(math.cos(3 * world.time), 1e-6)
  expect(d.floor):is(false)
  expect(d.collided):is(false)
  expect(d.m_id):is(0.0)
  expect(d.mess_type):is ""

  s:eventually("it strikes", "1 s", function() return ball.debug.collided end)
  s:eventually("it rests", "9 s", function() return ball.debug.floor end)
  other:send(ball, "hello", 5)
  world:step()
  d = ball.debug
  expect(d.mess_type):is "hello"
  expect(d.origin):is(other)
  expect(d.m_id):above(0)
  expect(d.mess_time):near(world.time, 2 * world.frame)
  local message = world:messages()[#world:messages()]   -- the packet: me, you, direction
  expect(message.from):is(other)
  expect(message.to):is(ball)
  expect(message.direction):is_not(nil)
  expect(message.id):is(math.tointeger(d.m_id))
end)
