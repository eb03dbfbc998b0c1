-- One body that slides, rolls or flies on: a step of it needs one evaluation, and is exact; and nothing that ends it is overlooked.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local function slide()
  local world = digbox.world { sleeping = false }
  world:floor { friction = 0.4, restitution = 0 }
  local box = world:box { size = { 0.4, 0.1, 0.4 }, friction = 0.4, restitution = 0, at = { 0, 0.05, 0 }, velocity = { 3, 0, 0 } }
  return world, box
end

scenario("a box that slides needs one evaluation a step, and brakes as friction says", function()
  local world, box = slide()
  world:step()
  for k = 2, 40 do
    world:step()
    local t, a = k / 60, 0.4 * 9.81
    expect(world:stats().evaluations):is(1)
    expect(box.position):near({ 3 * t - a * t * t / 2, 0.05, 0 }, 1e-13)
    expect(box.velocity):near({ 3 - a * t, 0, 0 }, 1e-13)
  end
  world:run(1)
  expect(box.position.x):near(9 / (2 * 0.4 * 9.81), 1e-9)
  expect(box.speed):below(1e-12)
end)

scenario("a ball that rolls down a slope needs one evaluation a step, and has 5/7 of the weight's pull", function()
  local world = digbox.world {}
  local turn = digbox.quat { axis = { 0, 0, 1 }, angle = -math.rad(20) }
  world:plane { normal = turn:rotate { 0, 1, 0 }, friction = 0.5 }
  local ball = world:ball { radius = 0.1, friction = 0.5, at = turn:rotate { 0, 0.1, 0 } }
  world:step()
  for k = 2, 90 do
    world:step()
    local v = 5 / 7 * 9.81 * math.sin(math.rad(20)) * k / 60
    expect(world:stats().evaluations):is(1)
    expect(ball.speed):near(v, 1e-12)
    expect(ball.spin.z):near(-v / 0.1, 1e-11)
  end
end)

-- A ball of 10 cm at x = 1 m on a table that turns or moves along: what pulls it is 2/7 of what would keep it there (engine/trace/glide.c).
local function carried(step, drive, velocity, spin)
  local world = digbox.world { step = step }
  local table = world:box { kinematic = true, size = { 8, 0.2, 8 }, at = { 0, -0.1, 0 }, friction = 0.5 }
  table:drive(drive)
  return world, world:ball { radius = 0.1, mass = 2, friction = 0.5, at = { 1, 0.1, 0 }, velocity = velocity, spin = spin }, table
end

scenario("a ball on a turntable needs one evaluation a step, and goes round at 2/7 of its rate", function()
  local rate, velocity, spin = 3.5, { 0, 0, -0.5 }, { 30, 7, 0 }        -- it rolls: -0.5 - 0.1 * 30 = -3.5
  local world, ball = carried(1 / 60, { spin = { 0, rate, 0 } }, velocity, spin)
  local fine, twin = carried(1 / 1920, { spin = { 0, rate, 0 } }, velocity, spin)
  world:step()
  for k = 2, 120 do
    world:step()
    local t = k / 60
    expect(world:stats().evaluations):is(1)
    expect(ball.position):near({ 0.5 + 0.5 * math.cos(t), 0.1, -0.5 * math.sin(t) }, 1e-12)
    expect(ball.spin.y):near(7, 1e-12)
    expect(ball.force):near({ -math.cos(t - 1 / 120), 0, math.sin(t - 1 / 120) }, 1e-4)      -- 2 kg, 0.5 m/s2; the mean of the step
  end
  fine:run "2 s"
  expect(ball.rotation:rotate { 1, 0, 0 }):near(twin.rotation:rotate { 1, 0, 0 }, 1e-7)
  for _, w in ipairs { world, fine } do                 -- it keeps its speed; its spin goes round with its course
    expect(w.energy.numerical):near(0, 1e-10)
  end
  expect(world.energy.work_in):near(0.5 * 0.4 * 2 * 0.01 * ((#ball.spin) ^ 2 - 30 ^ 2 - 7 ^ 2), 1e-10)
end)

scenario("a ball on a belt goes straight on, and one on a tilted turntable across the slope", function()
  local world, ball = carried(1 / 60, { velocity = { 2, 0, 0 } }, { 3, 0, 0.5 }, { 5, 0, -10 })
  world:step()
  for k = 2, 60 do
    world:step()
    expect(world:stats().evaluations):is(1)
    expect(ball.position):near({ 1 + 3 * k / 60, 0.1, 0.5 * k / 60 }, 1e-12)
    expect(ball.spin):near({ 5, 0, -10 }, 1e-11)
  end
  local tilted = digbox.quat { axis = { 0, 0, 1 }, angle = 0.1 }
  world = digbox.world {}
  local table = world:box { kinematic = true, size = { 8, 0.2, 8 }, at = tilted:rotate { 0, -0.1, 0 }, rotation = tilted, friction = 0.5 }
  table:drive { spin = tilted:rotate { 0, 3.5, 0 } }
  ball = world:ball { radius = 0.1, friction = 0.5, at = tilted:rotate { 0.5, 0.1, 0 }, spin = tilted:rotate { 17.5, 0, 0 } }
  local pull, t = 5 / 7 * 9.81 * math.sin(0.1), 1       -- across the slope at pull over 2/7 of the rate, 1, and round a circle besides
  world:run "1 s"
  expect(tilted:inverse():rotate(ball.position)):near({ 0.5 - pull * (1 - math.cos(t)), 0.1, pull * (t - math.sin(t)) }, 1e-7)
end)

scenario("what lifts a ball gives it its weight times the height", function()
  local world, ball = carried(1 / 60, { velocity = { 0.3, 1, 0 } }, { 0.3, 1, 0 }, { 0, 4, 0 })
  world:step()
  local given, weight = world.energy.work_in, 2 * 9.81
  for k = 2, 60 do
    world:step()
    expect(world:stats().evaluations):is(1)
    expect(ball.position.y):near(0.1 + k / 60, 1e-12)
    expect(world.energy.work_in - given):near(weight * (k - 1) / 60, 1e-11)
    expect(world.energy.numerical):near(0, 1e-11)
  end
end)

scenario("a ball is left behind where its table turns too fast for friction, and by one that stops", function()
  local world, ball, table = carried(1 / 60, { spin = { 0, 3.5, 0 } }, { 0, 0, -0.5 }, { 30, 0, 0 })
  world:run "0.5 s"
  table:drive { spin = { 0, 0, 0 } }
  world:run "1.5 s"
  local before = ball.velocity
  expect(world:stats().evaluations):is(1)
  world:run "0.5 s"
  expect(ball.velocity):near(before, 1e-12)
  -- 2/7 of 30 a second times 1 m/s is more than 0.5 g
  world, ball = carried(1 / 60, { spin = { 0, 30, 0 } }, { 0, 0, -1 }, { 290, 0, 0 })
  world:step()
  expect(#ball.force):at_most(0.5 * 2 * 9.81 * 1.0001)
  expect(world:stats().evaluations):above(1)
end)

-- By the forces of the step before a change nothing of it would be felt for as long as the body slid on.
scenario("who slides feels at once what a script changes", function()
  local changes = {
    { function(_, box) box.friction = 0.1 end, function(v) return v - 0.2 * 9.81 / 60 end },            -- the root of 0.1 times 0.4
    { function(world) world.gravity = { 0, -20, 0 } end, function(v) return v - 0.4 * 20 / 60 end },
    { function(_, box) box.mass = 2 * box.mass end, function(v) return v - 0.4 * 9.81 / 60 end },
    { function(_, box) box:push { force = { 30 * box.mass, 0, 0 }, lasts = 1 } end, function(v) return v + (30 - 0.4 * 9.81) / 60 end },
    { function(_, box) box:teleport { velocity = { 5, 0, 0 } } end, function() return 5 - 0.4 * 9.81 / 60 end },
    { function(_, box) box:teleport { velocity = { -1, 0, 0 } } end, function() return -1 + 0.4 * 9.81 / 60 end },
  }
  for _, change in ipairs(changes) do
    local world, box = slide()
    world:run "0.2 s"
    local before = box.velocity.x
    change[1](world, box)
    world:step()
    expect(box.velocity.x):near(change[2](before), 1e-11)
    expect(box.position.y):near(0.05, 1e-12)
  end
end)

scenario("who slides is stopped by a wall", function()
  local world, box = slide()
  world:box { fixed = true, size = { 0.02, 1, 1 }, at = { 0.81, 0.5, 0 }, restitution = 0, friction = 0 }
  world:run "0.5 s"
  expect(box.position.x):near(0.6, 1e-9)
end)

scenario("who slides pushes a box that lies in the way", function()
  local world, box = slide()
  local other = world:box { size = { 0.4, 0.1, 0.4 }, friction = 0.4, restitution = 0, at = { 0.8, 0.05, 0 } }
  world:run "0.5 s"
  expect(other.position.x):above(0.85)
  expect(other.position.x - box.position.x):at_least(0.4 - 1e-9)
end)

scenario("who slides over an edge tips there, and not before", function()
  local world = digbox.world {}
  world:box { fixed = true, size = { 2, 0.2, 1 }, at = { -0.5, -0.1, 0 }, friction = 0 }
  local box = world:box { size = { 0.4, 0.1, 0.4 }, friction = 0, restitution = 0, at = { 0, 0.05, 0 }, velocity = { 1, 0, 0 } }
  while box.position.x + 1 / 60 < 0.5 do
    world:step()
    expect(box.spin):near({ 0, 0, 0 }, 1e-9)
  end
  world:run "0.2 s"
  expect(box.spin.z):below(-0.5)
end)

-- Of a frame in which a box got more than half its length over the edge only the end was looked at: it left without tipping, 38 mm off in
-- 0.4 s. And corners that would have had to pull pressed on: forces that are constant in a frame were taken for those of its end.
scenario("who slides off a slope tips over its edge as in short steps, however far it gets in one", function()
  local function leave(rate, before, speed)
    local world, q = digbox.world { step = 1 / rate }, digbox.quat { axis = { 0, 0, 1 }, angle = "-20 deg" }
    world:box { fixed = true, size = { 2, 0.1, 1 }, rotation = q, friction = 0.2 }
    local box = world:box { size = { 0.2, 0.1, 0.2 }, rotation = q, at = q:rotate { 0.6 - before, 0.1, 0 }, friction = 0.2, restitution = 0,
                            velocity = q:rotate { speed, 0, 0 } }
    world:run "0.4 s"
    return box.centre
  end
  for k = 0, 19 do
    for _, speed in ipairs { 1.5, 2.5, 3.5 } do
      expect(leave(30, 0.013 * k, speed)):near(leave(240, 0.013 * k, speed), 1e-3)
    end
  end
end)

-- Its line on the table became another one on the edge, and the step in which it did was taken as a whole: up to 7 cm beyond the edge. At
-- others it hung on the edge, for the distance of a circle from a point has no sign. (v^2 > g r: it flies from the edge on.)
scenario("a cylinder that rolls off a table is in free flight from its edge on, at whatever step", function()
  for _, rate in ipairs { 30, 60, 120, 240 } do
    for k = 0, 9 do
      local r, v, before = 0.06 + 0.01 * k, 1.8 + 0.23 * k, 0.3 + 0.037 * k
      local world = digbox.world { step = 1 / rate }
      world:box { fixed = true, size = { 2, 1, 1 }, at = { -1, 0.5, 0 }, friction = 0.8 }
      local roller = world:cylinder { radius = r, height = 0.2, rotation = digbox.quat { axis = { 1, 0, 0 }, angle = "90 deg" },
        at = { -before, 1 + r, 0 }, velocity = { v, 0, 0 }, spin = { 0, 0, -v / r }, friction = 0.8 }
      world:run(before / v + 0.15)
      local fallen = world.time - before / v
      expect(roller.centre):near({ v * fallen, 1 + r - 9.81 * fallen ^ 2 / 2, 0 }, 2e-5)
    end
  end
end)

scenario("a wheel that meets a step climbs it, or comes back, as in short steps", function()
  local function meet(rate, r, high, v, bounce)
    local world = digbox.world { step = 1 / rate }
    world:floor { friction = 0.8 }
    world:box { fixed = true, size = { 2, 2 * high, 1 }, at = { 1.6, 0, 0 }, friction = 0.8 }
    local wheel = world:cylinder { radius = r, height = 0.2, rotation = digbox.quat { axis = { 1, 0, 0 }, angle = "90 deg" },
      at = { 0, r, 0 }, velocity = { v, 0, 0 }, spin = { 0, 0, -v / r }, friction = 0.8, restitution = bounce }
    world:run "1.2 s"
    return wheel.centre, world.energy.numerical
  end
  local close = 0
  for k = 0, 15 do
    local r, v, bounce = 0.1 + 0.012 * k, 1 + 0.19 * (k * 7 % 16), k % 2 * 0.3
    local high = r * (0.1 + 0.6 * (k * 5 % 16) / 16)
    local at, books = meet(30, r, high, v, bounce)
    local off = (at - meet(240, r, high, v, bounce)):length()
    expect(off):below(6e-3)                                 -- one is swept for half of its frames; before, all were, up to 13 cm off
    expect(books):near(0, 1e-5)                             -- and 0.17 J made up
    close = close + (off < 1e-6 and 1 or 0)
  end
  expect(close):at_least(14)
end)

-- Ball and floor are near enough to be a pair in every step. Steps without a blow are flights, each from its start alone.
scenario("a ball that bounces needs one evaluation in all steps without a blow but those just before one", function()
  local world = digbox.world {}
  world:floor { restitution = 1 }
  local ball, blows, more = world:ball { radius = 0.5, restitution = 1, at = { 0, 0.6, 0 } }, 0, 0
  ball:on("contact_begin", function() blows = blows + 1 end)
  for _ = 1, 240 do
    world:step()
    more = more + (world:stats().evaluations > 1 and 1 or 0)
  end
  local half = math.sqrt(2 * 0.1 / 9.81)
  local t = (4 + half) % (2 * half) - half              -- after the last top
  expect(blows):is(math.floor((4 + half) / (2 * half)))
  expect(ball.position.y):near(0.6 - 9.81 * t * t / 2, 1e-11)
  expect(more):at_most(2 * blows)
end)

scenario("who flies just over a floor lands when it gets there", function()
  for i = 1, 20 do
    local world = digbox.world {}
    world:floor { restitution = 0 }
    local height, landed = 0.001 * i * i, nil
    local ball = world:ball { radius = 0.1, restitution = 0, at = { 0, 0.1 + height, 0 }, velocity = { 1, 0.3, 0 } }
    ball:on("contact_begin", function(e) landed = landed or e.time end)
    world:run "1 s"
    expect(landed):near((0.3 + math.sqrt(0.09 + 2 * 9.81 * height)) / 9.81, 1e-9)
    expect(ball.position.y):near(0.1, 1e-9)
  end
end)

-- A flight looks for what is near within all of the step. What the sweep's first part cannot reach is not near to that, and no reason for a
-- shorter one. (A cone is not traced.)
scenario("who might meet something in a step, and is swept, is swept in as many parts as before it might", function()
  local parts = { [0.1] = 8, [0.15] = 4, [0.3] = 1 }    -- near, in reach of the step but not of a part, out of reach
  for height, count in pairs(parts) do
    local world = digbox.world { gravity = { 0, 0, 0 } }
    world:floor {}
    world:cone { radius = 0.2, height = 0.3, at = { 0, height, 0 }, spin = { 0, 40, 0 } }
    world:step()
    expect(world:stats().substeps):is(count)
  end
end)
