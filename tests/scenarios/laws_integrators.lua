-- laws_integrators.lua: rows 61 to 64 and 82 of the behaviours: Euler, Verlet and the switch between them, the impulse equation,
-- the three casts, bisection for the time of an impact, and collisions as messages.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local g = 9.81
local ways = { "euler", "verlet", "switch", "auto" }

-- s, the substep of a world in which nothing is struck
local function substep(world) return world.frame * world:stats().groups / world:stats().substeps end

scenario("row 61: after a drop of 1 s Verlet is exact, Euler off by g h t / 2, switching by g h^2 / 2 for each Euler substep", function(s)
  for _, step in ipairs { 1 / 30, 1 / 60, 1 / 120 } do
    for _, way in ipairs(ways) do
      local world = s:world { step = step }
      local ball = world:ball { radius = 0.1, at = { 0, 10, 0 }, integrator = way }
      world:step()
      local h = way == "auto" and step or substep(world)
      world:run { steps = math.floor(1 / step + 0.5) - 1 }
      local want = { euler = g * h * 1 / 2, switch = step / h * g * h * h / 2, verlet = 0, auto = 0 }
      expect(ball.velocity.y):near(-g, 1e-9)
      expect(10 - g / 2 - ball.position.y):near(want[way], 1e-9)
    end
  end
end)

scenario("row 61: the equations of the founding document, step by step", function(s)
  local world = s:world { step = 1 / 60 }
  local a, v0 = digbox.vec(0, -g, 0), digbox.vec(2, 3, -1)
  local euler = world:ball { radius = 0.1, at = { 0, 5, 0 }, velocity = v0, integrator = "euler" }
  local verlet = world:ball { radius = 0.1, at = { 0, 5, 3 }, velocity = v0, integrator = "verlet" }
  local x, v, before = euler.position, v0, verlet.position
  world:step()
  local h, H = substep(world), world.frame
  local now = before + v0 * H + a * (H * H / 2)         -- there is no position before the first: from the velocity
  for _ = 1, 60 do
    for _ = 1, math.floor(H / h + 0.5) do
      v = v + a * h                                     -- (2)
      x = x + v * h                                     -- (1)
    end
    expect(euler.position):near(x, 1e-11)
    expect(euler.velocity):near(v, 1e-11)
    expect(verlet.position):near(now, 1e-11)
    now, before = now * 2 - before + a * (H * H), now   -- (4), (5)
    expect(verlet.integrating):is "verlet"
    expect(euler.integrating):is "euler"
    world:step()
  end
end)

scenario("row 61: switching: Euler at birth and after a collision, then Verlet; the flag shows it and nothing jumps", function(s)
  local world = s.world
  world:floor { restitution = 1 }
  local ball = world:ball { radius = 0.1, at = { 0, 1.6, 0 }, velocity = { 0.3, 0, 0 }, restitution = 1, integrator = "switch" }
  expect(ball.integrator):is "switch"
  expect(ball.integrating):is "euler"
  local struck, flags, from = 0, 0, nil
  for _ = 1, 150 do
    local was = ball.integrating
    world:step()
    local d = ball.debug
    expect(ball.integrating):is(d.collided and "euler" or "verlet")
    expect(d.euler):is(d.collided)
    if d.collided then struck, from = struck + 1, nil end
    if was == "euler" then flags = flags + 1 end
    if was == "euler" and not d.collided then from = { x = ball.position, v = ball.velocity, t = world.time } end
    if from then                                        -- from the switch on: the parabola of the state at the switch
      local t = world.time - from.t
      expect(ball.position):near(from.x + from.v * t + digbox.vec(0, -g / 2, 0) * (t * t), 1e-12)
      expect(ball.velocity):near(from.v + digbox.vec(0, -g, 0) * t, 1e-12)
    end
  end
  expect(struck):is(2)                                  -- at sqrt(2 h / g) = 0.553 s and three times that
  expect(flags):is(3)
end)

scenario("row 61: what has no history begins with Euler: a teleport, a new choice; a snapshot keeps it", function(s)
  local world = s.world
  local ball = world:ball { radius = 0.1, at = { 0, 1, 0 }, integrator = "switch" }
  world:step(3)
  expect(ball.integrating):is "verlet"
  ball:teleport { at = { 1, 2, 3 } }
  expect(ball.integrating):is "euler"
  local snap = world:snapshot()
  world:step(5)
  local there = ball.position
  world:restore(snap)
  expect(ball.integrating):is "euler"
  world:step(5)
  expect(ball.position):is(there)
  ball.integrator = "verlet"
  expect(ball.integrating):is "verlet"
  ball.integrator = "euler"
  expect(ball.integrating):is "euler"
  expect(world:ball { radius = 1, at = { 9, 0, 0 } }.integrator):is "auto"
  expect(expect(function() world:ball { radius = 1, integrator = "eulr" } end):fails()):contains "did you mean 'euler'?"
  expect(expect(function() ball.integrating = "euler" end):fails()):contains "cannot be assigned"
end)

scenario("row 61: contacts and joints hold whatever moves the bodies", function(s)
  for _, way in ipairs(ways) do
    local world = s:world {}
    world:floor {}
    local top
    for k = 1, 4 do top = world:box { size = 0.2, at = { 0, 0.21 * k - 0.1, 0 }, integrator = way } end
    local bob = world:ball { radius = 0.05, at = { 4, 3, 0 }, integrator = way }
    world:hinge { a = bob, at = { 3, 3, 0 }, axis = { 0, 0, 1 } }
    s.world = world
    for _ = 1, 180 do
      world:step()
      expect(#(bob.position - digbox.vec(3, 3, 0))):near(1, 1e-3)
    end
    expect(top.position):near({ 0, 0.7, 0 }, 1e-4)
    expect(top.speed):below "1 mm/s"
  end
end)

-- Equation (6): J = (1 + e) v / (1/m + 1/M + n . (I^-1 (r x n) x r)), here with n = x and a box that has not turned yet.
scenario("row 62: the impulse of an off-centre hit is that of equation (6)", function(s)
  local m, M, v, radius = 2, 5, 3, 0.1
  local size, n = digbox.vec(0.4, 1, 0.6), digbox.vec(1, 0, 0)
  for _, way in ipairs { "auto", "switch" } do
    for _, e in ipairs { 0.2, 0.5, 1 } do
      for _, offset in ipairs { { 0, 0 }, { 0.35, 0 }, { -0.3, 0.2 } } do
        local world = s:world { gravity = { 0, 0, 0 } }
        local r = digbox.vec(-size.x / 2, offset[1], offset[2])
        local box = world:box { size = size, mass = M, at = { 0, 0, 0 }, restitution = e, friction = 0, integrator = way }
        local ball = world:ball { radius = radius, mass = m, at = r + digbox.vec(-radius - 0.5, 0, 0), velocity = n * v, restitution = e,
                                  friction = 0, integrator = way }
        local hit
        world:on("impact", function(event) hit = hit or event end)
        local p, l = world.momentum, world.angular_momentum
        s:eventually("they meet", "0.3 s", function() return hit end)
        local I = digbox.vec(size.y ^ 2 + size.z ^ 2, size.x ^ 2 + size.z ^ 2, size.x ^ 2 + size.y ^ 2) * (M / 12)
        local turn = r:cross(n)
        local spin = digbox.vec(turn.x / I.x, turn.y / I.y, turn.z / I.z)         -- I^-1 (r x n)
        local J = (1 + e) * v / (1 / m + 1 / M + n:dot(spin:cross(r)))
        expect(hit.time):near(0.5 / v, 1e-9)
        expect(hit.speed):near(v, 1e-9)
        expect(hit.impulse):near(J, 1e-9)
        expect(ball.velocity):near(n * (v - J / m), 1e-9)
        expect(box.velocity):near(n * (J / M), 1e-9)
        expect(box.debug.ang_mom):near(turn * J, 1e-9)
        expect(#(world.momentum - p)):at_most(1e-12 * #p)
        expect(#(world.angular_momentum - l)):at_most(1e-12 * (1 + #l))
        local L = box.debug.ang_mom                     -- stays; the spin at the hit follows from it
        local w = digbox.vec(L.x / I.x, L.y / I.y, L.z / I.z)
        expect(n:dot(box.velocity + w:cross(r) - ball.velocity)):near(e * v, 1e-9)       -- separation = -e approach
      end
    end
  end
end)

scenario("row 63: a bullet of 300 m/s meets a plate of 5 mm by ray, by capped cylinder, by arc, and in the simulation", function(s)
  local face, radius, v = 2 - 0.0025, 0.004, digbox.vec(300, 0, 0)
  local function scene()
    local world = s:world {}
    return world, world:box { name = "plate", fixed = true, size = { 0.005, 1, 1 }, at = { 2, 0, 0 } }
  end
  local world, plate = scene()
  local time, want = world.frame, (face - radius) / 300
  local ray = world:ray { from = { 0, 0, 0 }, to = v * time }
  expect(ray[1].body):is(plate)
  expect(ray[1].fraction * time):near(face / 300, 1e-5)
  local ball = digbox.sphere { radius = radius }
  local straight = world:sweep { shape = ball, velocity = v, time = time }
  expect(straight.body):is(plate)
  expect(straight.fraction * time):near(want, 1e-5)
  local arc = world:sweep { shape = ball, velocity = v, acceleration = { 0, -g, 0 }, time = time }
  expect(arc.body):is(plate)
  expect(arc.fraction * time):near(want, 1e-5)
  for _, way in ipairs(ways) do
    world, plate = scene()
    local bullet, hit = world:ball { radius = radius, mass = 0.01, velocity = v, integrator = way }, nil
    bullet:on("impact", function(event) hit = hit or event end)
    world:step(2)
    expect(hit.other):is(plate)
    expect(hit.time):near(want, 1e-5)
    expect(bullet.position.x):below(face)
  end
end)

scenario("row 63: a thin bar at the top of the arc: straight lines miss it, the arc finds it", function(s)
  local v, radius, half = 10, 0.05, 0.01
  local x, top, time = v * v / g, v * v / (2 * g), 2 * v / g        -- thrown at 45 degrees: highest at x, down again after time
  local function scene()
    local world = s:world {}
    return world, world:box { name = "bar", fixed = true, size = { 2 * half, 2 * half, 2 }, at = { x, top, 0 } }
  end
  local world, bar = scene()
  local ball = digbox.sphere { radius = radius }
  local want = (x - half - radius) / v                  -- it meets the bar's upright side
  expect(world:ray { from = { 0, 0, 0 }, to = { v * time, 0, 0 } }):is_empty()
  expect(world:sweep { shape = ball, velocity = { v, 0, 0 }, time = time }):is(nil)      -- from the start to the end
  local arc = world:sweep { shape = ball, velocity = { v, v, 0 }, acceleration = { 0, -g, 0 }, time = time }
  expect(arc.body):is(bar)
  expect(arc.fraction * time):near(want, 1e-5)
  expect(arc.normal.x):near(-1, 1e-6)
  for _, way in ipairs { "verlet", "auto" } do
    world, bar = scene()
    local thrown, hit = world:ball { radius = radius, velocity = { v, v, 0 }, integrator = way }, nil
    thrown:on("impact", function(event) hit = hit or event end)
    s.world = world
    world:run(1.2)
    expect(hit.other):is(bar)
    expect(hit.time):near(want, 1e-5)
  end
end)

scenario("row 64: twenty bisections between the positions before and after give the time of impact", function(s)
  for _, h0 in ipairs { 0.6, 1.7, 8 } do
    local r = 0.25
    local world = s:world { step = 1 / 30 }
    local ghost = world:ball { radius = r, at = { 0, h0, 0 }, collides = false, integrator = "verlet" }
    local v
    repeat
      v = ghost.velocity.y
      world:step()
    until ghost.position.y < r
    local from, h = ghost.debug.prev_pos.y, world.frame
    local low, high = 0, h
    for _ = 1, 20 do
      local middle = (low + high) / 2
      if from + v * middle - g / 2 * middle * middle > r then low = middle else high = middle end
    end
    local found, want = world.time - h + (low + high) / 2, math.sqrt(2 * (h0 - r) / g)
    expect(found):near(want, h * 2 ^ -20)
    for _, way in ipairs { "verlet", "auto" } do        -- the simulation finds it better than that
      local other = s:world { step = 1 / 30 }
      other:floor {}
      local ball, hit = other:ball { radius = r, at = { 0, h0, 0 }, integrator = way }, nil
      ball:on("impact", function(event) hit = hit or event.time end)
      other:run(want + 0.1)
      expect(hit):near(want, h * 2 ^ -20)
    end
  end
end)

scenario("row 82: two balls strike a third at one instant: stored velocities make the result symmetric, in any order", function(s)
  local u, r, e = 2, 0.1, 0.8
  local c, d = math.sqrt(3) / 2, 0.5                    -- the line of centres is 30 degrees off the flight
  local J = (1 + e) * u * c / (1 + 2 * c * c)           -- over m: e u c = v0.n - v1.n, v0 = 2 J c, v1.n = u c - J
  local places = { middle = { 0, 0, 0 }, upper = { -1 - 2 * r * c, 2 * r * d, 0 }, lower = { -1 - 2 * r * c, -2 * r * d, 0 } }
  for _, way in ipairs { "auto", "switch" } do
    for _, order in ipairs { { "middle", "upper", "lower" }, { "lower", "middle", "upper" }, { "upper", "lower", "middle" } } do
      local world = s:world { gravity = { 0, 0, 0 } }
      local ball = {}
      for _, name in ipairs(order) do
        ball[name] = world:ball { name = name, radius = r, mass = 1, friction = 0, restitution = e, at = places[name],
                                  velocity = { name == "middle" and 0 or u, 0, 0 }, integrator = way }
      end
      local hits = {}
      world:on("impact", function(event) hits[#hits + 1] = event end)
      world:run "0.6 s"
      expect(#hits):is(2)                               -- A strikes B and B strikes A are one impact
      for _, hit in ipairs(hits) do
        expect(hit.time):near(0.5, 1e-9)
        expect(hit.speed):near(u * c, 1e-9)             -- both with the velocities before
        expect(hit.impulse):near(J, 1e-9)
      end
      expect(ball.middle.velocity):near({ 2 * J * c, 0, 0 }, 1e-9)
      expect(ball.upper.velocity):near({ u - J * c, J * d, 0 }, 1e-9)
      expect(ball.upper.velocity.y + ball.lower.velocity.y):near(0, 1e-12)
      expect(ball.middle.position.y):near(0, 1e-12)
    end
  end
end)

scenario("row 82: the queue of messages is apart from the flags: each party is told once, and the flag is gone a step later", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local a = world:ball { name = "a", radius = 0.1, at = { -0.5, 0, 0 }, velocity = { 2, 0, 0 }, restitution = 1 }
  local b = world:ball { name = "b", radius = 0.1, at = { 0, 0, 0 }, restitution = 1 }
  s:eventually("they meet", "0.3 s", function() return a.debug.collided end)
  expect(b.debug.collided):is(true)
  local function told(from, to)
    local count = 0
    for _, message in ipairs(world:messages()) do
      if message.from == from and message.to == to then
        count = count + 1
        expect(message.direction:normalized()):near({ from == a and 1 or -1, 0, 0 }, 1e-9)
      end
    end
    return count
  end
  expect(told(a, b)):is(1)
  expect(told(b, a)):is(1)
  expect(#world:messages()):is(2)
  world:step(2)
  expect(a.debug.collided):is(false)
  expect(b.debug.collided):is(false)
  expect(#world:messages()):is(2)                       -- still there to be read
end)
