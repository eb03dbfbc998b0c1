-- thesis_rest.lua: row 87 of the behaviours: the five tests of the thesis' chapter 6, with the closed form of each.
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local g = 9.81

scenario("row 87 a: a ball at rest on the floor stays at rest, and sleeps", function(s)
  local world = s.world
  local floor = world:floor {}
  local ball = world:ball { name = "ball", radius = 0.1, mass = 1, at = { 0.3, 0.1, -0.2 }, restitution = 0.5 }
  local impacts = 0
  ball:on("impact", function() impacts = impacts + 1 end)
  world:step(5)
  expect(ball.mode):is "resting"
  expect(ball.velocity):is(ball.velocity * 0)           -- exactly, not nearly
  expect(ball.position):near({ 0.3, 0.1, -0.2 }, 1e-9)
  expect(ball:links()[1].effort.y * (ball:links()[1].a == ball and -1 or 1)):near(g, 0.01)
  s:eventually("the ball is asleep", "2 s", function() return ball.asleep end)
  local sum, steps = world:stats().iterations, world.steps
  world:run "1 s"
  expect(sum):at_least(0)
  expect(world.steps):is(steps + 60)
  expect(world:stats().groups):is(0)                    -- a sleeping DIG costs no solver group
  expect(ball.position):near({ 0.3, 0.1, -0.2 }, 1e-9)
  expect(impacts):is(0)
  expect(ball:neighbours()):is { floor }
end)

scenario("row 87 b: a dropped ball bounces to h e^(2 n), for sqrt(2 h / g) (1 + e) / (1 - e), then rests", function(s)
  local world = s.world
  local h, e, r = 1, 0.5, 0.1
  world:floor {}
  local ball = world:ball { name = "ball", radius = r, at = { 0, r + h, 0 }, restitution = e }
  local impacts, ends = {}, nil
  ball:on("impact", function(event) impacts[#impacts + 1] = event end)
  s:eventually("it rests", "3 s", function()
    if ball.mode == "resting" then ends = ends or world.time end
    return ends
  end)
  for n = 1, 5 do
    local rise = g * (impacts[n + 1].time - impacts[n].time) ^ 2 / 8
    expect(rise):near(h * e ^ (2 * n), 0.01 * h * e ^ (2 * n))
    expect(impacts[n].speed):near(math.sqrt(2 * g * h) * e ^ (n - 1), 0.01 * math.sqrt(2 * g * h) * e ^ (n - 1))
  end
  expect(#impacts):between(6, 60)                       -- finitely many
  local total = math.sqrt(2 * h / g) * (1 + e) / (1 - e)
  expect(impacts[#impacts].time):near(total, 0.02 * total)
  expect(ends):between(total * 0.98, total * 1.02 + 4 * world.frame)        -- the mode needs two still frames
  expect(ball.velocity):is(ball.velocity * 0)
  expect(ball.position.y):near(r, "1 mm")
  s:eventually("it sleeps", "1 s", function() return ball.asleep end)
end)

-- Speeds after a head-on hit: u1 = (m1 v1 + m2 v2 - m2 e (v1 - v2)) / (m1 + m2), and the like.
local function after(m1, v1, m2, v2, e)
  local p, m = m1 * v1 + m2 * v2, m1 + m2
  return (p - m2 * e * (v1 - v2)) / m, (p + m1 * e * (v1 - v2)) / m
end

scenario("row 87 c: two moving balls hit", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local e = 0.7
  local a = world:ball { name = "a", radius = 0.1, mass = 1, at = { -1, 0, 0 }, velocity = { 3, 0, 0 }, restitution = e }
  local b = world:ball { name = "b", radius = 0.1, mass = 2.5, at = { 1, 0, 0 }, velocity = { -1, 0, 0 }, restitution = e }
  local time
  a:on("impact", { with = b }, function(event) time = event.time end)
  world:run "0.6 s"
  local u, w = after(1, 3, 2.5, -1, e)
  expect(time):near(1.8 / 4, 1e-6)
  expect(a.velocity):near({ u, 0, 0 }, 1e-9)
  expect(b.velocity):near({ w, 0, 0 }, 1e-9)
  expect(a.position.x):near(-1 + 3 * 0.45 + u * 0.15, 1e-5)
end)

scenario("row 87 d: a moving ball hits one at rest on the floor", function(s)
  local world = s.world
  local e = 0.6
  world:floor { friction = 0 }
  local a = world:ball { name = "a", radius = 0.1, mass = 1, at = { -1, 0.1, 0 }, velocity = { 2, 0, 0 }, restitution = e, friction = 0 }
  local b = world:ball { name = "b", radius = 0.1, mass = 3, at = { 0, 0.1, 0 }, restitution = e, friction = 0 }
  s:settle "0.3 s"
  expect(b.mode):is "resting"
  expect(b.velocity):is(b.velocity * 0)
  s:settle "0.3 s"
  local u, w = after(1, 2, 3, 0, e)
  expect(a.velocity):near({ u, 0, 0 }, 1e-6)
  expect(b.velocity):near({ w, 0, 0 }, 1e-6)
  expect(b.mode):is "moving"
end)

scenario("row 87 e: a ball goes to and fro between side walls, and one rests against a wall", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  world:room { size = { 2, 2, 2 }, restitution = 1, friction = 0 }
  local ball = world:ball { name = "ball", radius = 0.1, at = { 0, 1, 0 }, velocity = { 3, 0, 0 }, restitution = 1, friction = 0 }
  local times = {}
  ball:on("impact", function(event) times[#times + 1] = event.time end)
  world:run "3 s"
  expect(#times):is(5)                                  -- 0.3 s, then every 1.8 m at 3 m/s
  for n, time in ipairs(times) do expect(time):near(0.3 + 0.6 * (n - 1), 1e-6) end
  expect(ball.speed):near(3, 1e-9)

  world = s:world { gravity = { 4, -g, 0 } }            -- leaning: pressed into a corner
  world:room { size = { 2, 2, 2 }, friction = 0 }
  local still = world:ball { name = "still", radius = 0.1, at = { 0.9, 0.1, 0 }, friction = 0 }
  s:settle "1 s"
  expect(still.velocity):is(still.velocity * 0)
  expect(still.mode):is "resting"
  expect(still.position):near({ 0.9, 0.1, 0 }, "1 mm")
  world.gravity = { -4, -g, 0 }
  world:run "0.3 s"
  expect(still.position.x):near(0.9 - 4 * 0.3 ^ 2 / 2, 1e-3)                -- and off it goes as from free
end)
