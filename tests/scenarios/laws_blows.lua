-- Blows of many: energy where they are not located in time, and none that nobody saw.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- 216 elastic balls in a lattice that is a little out of order fall on a floor: one group of more bodies than have their blows
-- located. A simultaneous solve of all restitutions doubled their energy at the first blow.
scenario("a lattice of elastic balls that strikes the floor neither gains nor loses much energy", function()
  local world = digbox.world { sleeping = false }
  world:floor { restitution = 1, friction = 0 }
  local n = 0
  for i = 0, 5 do
    for j = 0, 5 do
      for k = 0, 5 do
        n = n + 1
        local function off(m) return 0.001 * (n * m % 97) / 97 end
        world:ball { radius = 0.1, mass = 10, at = { 0.21 * i + off(31), 1.101 + 0.21 * k + off(57), 0.21 * j + off(83) },
                     restitution = 1, friction = 0 }
      end
    end
  end
  local start = world.energy.kinetic + world.energy.potential
  for _ = 1, 50 do
    world:step()
    expect(world.energy.kinetic + world.energy.potential):near(start, 0.06 * start)
  end
end)

-- A ball that is struck may get in the same step where nobody looked. Before such steps were done again, two of these
-- forty passed into each other about once in five seconds, by up to a fifth of their radius.
scenario("forty elastic balls in a small room never pass into each other", function()
  local world = digbox.world { gravity = { 0, 0, 0 }, sleeping = false }
  world:room { size = { 1, 1, 1 }, restitution = 1, friction = 0 }
  for i = 1, 40 do
    local cell = digbox.vec(i % 4, i // 4 % 4, i // 16) / 4 + digbox.vec(0.125, 0.125, 0.125)
    local way = digbox.vec(math.sin(12.9 * i), math.sin(78.2 * i), math.sin(37.7 * i)):normalized()
    world:ball { mass = 0.1, radius = 0.03, at = cell - digbox.vec(0.5, 0, 0.5), velocity = 2 * way, restitution = 1, friction = 0 }
  end
  local kinetic = world.energy.kinetic
  world:run(6)
  expect(world:stats().worst_penetration):below(1e-9)
  expect(world.energy.kinetic):near(kinetic, 1e-9 * kinetic)
end)

-- The deepest that any two balls are in each other, or one in the plane z = 0
local function deepest(balls, plane)
  local depth = 0
  for i, a in ipairs(balls) do
    if plane then depth = math.max(depth, 0.1 - a.position.z) end
    for k = i + 1, #balls do depth = math.max(depth, 0.2 - #(a.position - balls[k].position)) end
  end
  return depth
end

-- A plane is in no tree of boxes: a ball struck down to it ended 4.3 cm deep in it, and was pushed out with energy that nobody gave
scenario("a ball at rest that is struck down onto a plane bounces there in the same frame", function()
  for _, accuracy in ipairs { "play", "study", "reference" } do
    local world = digbox.world { gravity = { 0, 0, 0 }, sleeping = false, accuracy = accuracy }
    world:plane { normal = { 0, 0, 1 }, friction = 0, restitution = 1 }
    local lower = world:ball { radius = 0.1, at = { 0, 0, 0.13 }, mass = 1, restitution = 1, friction = 0 }
    local upper = world:ball { radius = 0.1, at = { 0, 0, 0.34 }, velocity = { 0, 0, -5 }, mass = 1, restitution = 1, friction = 0 }
    world:step()
    expect(deepest({ lower, upper }, true)):below(1e-12)
    world:run(0.1)
    expect(upper.velocity.z):near(5, 1e-12)                                 -- the speed went down to the plane and came back
    expect(#lower.velocity):below(1e-12)
    expect(world:stats().gave_up):is(0)
  end
end)

-- Each is struck by what is not in the other's group, and neither was where the other was looked for: they ended up to 9 cm in each other
scenario("two balls struck towards each other in one frame bounce in it", function()
  for _, gap in ipairs { 0.14, 0.18, 0.22 } do
    local world, balls = digbox.world { gravity = { 0, 0, 0 }, sleeping = false }, {}
    for side = -1, 1, 2 do
      local z = side * (0.1 + gap / 2)
      balls[#balls + 1] = world:ball { mass = 0.1, radius = 0.1, at = { 0, 0, z }, restitution = 1, friction = 0 }
      balls[#balls + 1] = world:ball { mass = 100, radius = 0.1, at = { side * 0.004, 0, z + side * 0.204 },
                                       velocity = { -3.7 * side, 0, -3.7 * side }, restitution = 1, friction = 0 }
    end
    local kinetic = world.energy.kinetic
    for _ = 1, 4 do
      world:step()
      expect(deepest(balls)):below(1e-12)
    end
    expect(world.energy.kinetic):near(kinetic, 1e-12 * kinetic)
    expect(world:stats().gave_up):is(0)
  end
end)

-- Random world 1966, the frame before: the disc lies 15 um deep in the floor, so that it is swept. Where healing that overlap brought
-- it to the ball, the blow was looked for 64 times at the same instant, for the gap that had healed was not put back; then a
-- guess from the last blow's impulses bounced, and energy rose from 25 to 278 J. At the reference 25.23 J are left.
scenario("a ball that falls on a whirling disc an edge of which is in the floor gains no energy", function()
  local world = digbox.world { sleeping = false }
  world:floor { friction = 1 }
  world:cylinder { friction = 1, height = 0.05481, mass = 2.2, radius = 0.1807, restitution = 1,
                   at = { 5.2921894185679532, 0.16987952734206122, 0.36340418419207771 },
                   velocity = { 0.32230966597272898, 0.0072943397217447312, -2.8944127482011921 },
                   spin = { -14.133657361648474, -7.3659077817283158, -1.5769510398017095 },
                   rotation = digbox.quat{0.14991826946881637, -0.031811071017511676, -0.8540808161583805, -0.49704982417301868} }
  world:ball { friction = 0, mass = 0.3441, radius = 0.16, restitution = 1,
               at = { 5.2025083333332454, 0.44696886453869999, 0.14043791666666805 },
               velocity = { -0.52210000000000001, -6.0412268363099182, 0.006025 } }
  world:step()
  expect(world.energy.kinetic + world.energy.potential):near(25.23, 0.05)
  expect(world:stats().substeps):below(20)
end)

-- Where a blow came, the step was made three times to its last digit, with 28 evaluations in all; and where points that lie still came
-- at each other by rounding, their blow was swept a thousand times for less than rounding. Points that stick take one solve of all at once.
scenario("the blows of a block that rocks cost few evaluations, and one solve each", function()
  local world = digbox.world {}
  world:floor { friction = 2 }
  local turn = digbox.quat { axis = { 0, 0, 1 }, angle = 0.1 }
  local corner = turn:rotate { -0.25, -0.5, 0 }
  local block = world:box { size = { 0.5, 1, 0.5 }, friction = 2, rotation = turn, at = { -corner.x, -corner.y, 0 } }
  local events, evaluations, iterations = 0, 0, 0
  while world.time < 1.1 do
    world:step()
    local stats = world:stats()
    if stats.events == events + 1 then evaluations = math.max(evaluations, stats.evaluations) end
    iterations, events = iterations + stats.iterations, stats.events
  end
  expect(events):above(20)
  expect(evaluations):at_most(21)
  expect(iterations):at_most(2 * events)
  expect(block.position):near({ 0.25, 0.5, 0 }, 1e-3)
  expect(block.speed):below(1e-9)
end)

-- What `make` puts into a world without gravity, on this side of a wall of 10 mm at x = 0: how many are beyond it after 0.2 s?
local function behind_wall(accuracy, wall, make)
  local world = digbox.world { gravity = { 0, 0, 0 }, accuracy = accuracy }
  wall.size, wall.at = { 0.01, 12, 12 }, { 0.005, 0, 0 }
  world:box(wall)
  local bodies, behind = make(world), 0
  world:run(0.2)
  for _, body in ipairs(bodies) do behind = behind + (body.position.x > 0 and 1 or 0) end
  return behind
end

-- Contacts were looked for by the speeds before the blow, and what was at rest got none with a wall a decimetre away: it ended 2.9 m
-- behind that, for strikers of 15 to 165 m/s.
scenario("what is struck at rest does not pass through a thin wall in the same step", function()
  for _, accuracy in ipairs { "sketch", "play", "study", "reference" } do
    for _, wall in ipairs { { fixed = true }, { kinematic = true }, { mass = 1000 } } do
      for _, kind in ipairs { "ball", "box" } do
        for _, speed in ipairs { 15, 30, 90, 165 } do
          expect(behind_wall(accuracy, wall, function(world)
            local function body(x, v) return world[kind](world, { [kind == "ball" and "radius" or "size"] = kind == "ball" and 0.05 or 0.1,
                                                                  restitution = 1, at = { x, 0, 0 }, velocity = { v, 0, 0 } }) end
            return { body(-0.15, 0), body(-0.35, speed) }
          end)):is(0)
        end
      end
    end
  end
end)

-- Too many for their blows to be located: each got the wall's row a substep late, and four (at "sketch" 13, two still) got out.
scenario("of a hundred lively balls in a box with thin walls all are still in it", function()
  for _, accuracy in ipairs { "play", "study" } do
    local world, balls = digbox.world { gravity = { 0, 0, 0 }, accuracy = accuracy }, {}
    for side = -1, 1, 2 do
      world:box { fixed = true, size = { 0.01, 2.2, 2.2 }, at = { 1.005 * side, 0, 0 } }
      world:box { fixed = true, size = { 2.2, 0.01, 2.2 }, at = { 0, 1.005 * side, 0 } }
      world:box { fixed = true, size = { 2.2, 2.2, 0.01 }, at = { 0, 0, 1.005 * side } }
    end
    for i = 0, 99 do
      local way = digbox.vec(math.sin(12.9 * i), math.sin(78.2 * i), math.sin(37.7 * i))
      balls[i + 1] = world:ball { radius = 0.04 + 0.0004 * i, restitution = 1, velocity = i % 3 == 0 and 80 * way or { 0, 0, 0 },
                                  at = { 0.25 * (i % 6) - 0.62, 0.25 * (i // 6 % 6) - 0.62, 0.25 * (i // 36) - 0.62 } }
    end
    for _ = 1, 30 do
      world:step()
      for _, ball in ipairs(balls) do
        expect(math.max(math.abs(ball.position.x), math.abs(ball.position.y), math.abs(ball.position.z))):below(1)
      end
    end
  end
end)

-- A wall hands no blow on, and so nobody looked at it again for who had been struck; or its row was left out, for what is thrown may go
-- past. 15 balls of 999 got through, and 21 boxes.
scenario("a crowd that is thrown at a thin wall stays before it", function()
  for _, accuracy in ipairs { "sketch", "play" } do
    expect(behind_wall(accuracy, { fixed = true }, function(world)
      local balls = {}
      for i = 0, 332 do
        local fast = 0.5 + 0.5 * math.sin(12.9 * i)
        local velocity = { 1 + 199 * fast, 10 * math.sin(78.2 * i), 10 * math.sin(37.7 * i) }
        balls[i + 1] = world:ball { radius = 0.05, restitution = 0.3, velocity = velocity,
                                    at = { -1.5 - 0.15 * (i // 100), -2 + 0.4 * (i % 10), -2 + 0.4 * (i // 10 % 10) } }
      end
      return balls
    end)):is(0)
  end
end)

-- The last of the row is struck by one that was itself at rest: where it ends, two metres behind the wall, there is nothing.
scenario("the last ball of a row that is struck does not pass through a thin wall", function()
  for _, accuracy in ipairs { "sketch", "play", "study" } do
    for _, count in ipairs { 10, 40 } do
      expect(behind_wall(accuracy, { fixed = true }, function(world)
        local balls = {}
        for i = 1, count do balls[i] = world:ball { radius = 0.05, restitution = 1, at = { -0.15 - 0.12 * (i - 1), 0, 0 } } end
        world:ball { radius = 0.05, restitution = 1, at = { -0.23 - 0.12 * count, 0, 0 }, velocity = { 120, 0, 0 } }
        return balls
      end)):is(0)
    end
  end
end)

-- Too many for impacts to be located. The lowest layer stops within a substep in which the next one, a centimetre above it, comes on by
-- more.
scenario("layers of balls that fall together land on each other without overlap", function(s)
  for _, height in ipairs { 0.2, 0.24, 0.31 } do
    local world = s:world { step = 1 / 30 }
    world:floor { friction = 0, restitution = 0 }
    for i = 0, 215 do
      world:ball { radius = 0.1, friction = 0, restitution = 0, at = { 0.21 * (i % 6), height + 0.21 * (i // 36), 0.21 * (i // 6 % 6) } }
    end
    local deep = 0
    for _ = 1, 15 do
      world:step()
      deep = math.max(deep, world:stats().penetration)
    end
    expect(deep):below "0.2 mm"             -- 18 mm when what lands on what was stopped got no row
  end
end)

-- What 100 kg press down on 10 g bounces hundreds of times in a frame: more than the trace may follow.
scenario("a column of 10 g, 100 g and 100 kg that bounces without loss keeps its energy", function(s)
  for _, rate in ipairs { 30, 60, 120 } do
    local world = s:world { step = 1 / rate }
    world:floor { restitution = 1, friction = 0 }
    for i, mass in ipairs { 0.01, 0.1, 100 } do
      world:ball { radius = 0.1, mass = mass, restitution = 1, friction = 0, at = { 0, 0.25 + 0.25 * i, 0 } }
    end
    local before = world.energy.total
    for _ = 1, 3 * rate do world:step() end
    expect(world.energy.total):near(before, 1e-10 * before)     -- half was lost at 30 a second
    s:expect_reliable()
  end
end)

-- Newton's cradle: after the first blow those between hang side by side, and press each other by what their threads are off; from the
-- second one on they took it as one block would, and 40 degrees became 20 at "play". What rests on something, as by its weight, still takes
-- its share at once.
local function cradle(s, options, count, let_go)
  local world, balls, length, angle = s:world(options), {}, 0.5, math.rad(30)
  for i = 1, count do
    local away = i <= let_go and angle or 0
    balls[i] = world:ball { material = "steel", radius = 0.05, restitution = 1, friction = 0,
                            at = { 0.1 * i - length * math.sin(away), -length * math.cos(away), 0 } }
    world:ball_joint { a = balls[i], at = { 0.1 * i, 0, 0 } }
  end
  local widest = {}
  local function watch()
    for i, ball in ipairs(balls) do
      widest[i] = math.max(widest[i] or 0, math.deg(math.abs(math.atan(ball.position.x - 0.1 * i, -ball.position.y))))
    end
    return false
  end
  world:run "6 s"                               -- four swings to and fro of 1.45 s each
  world:run { seconds = 1.5, stop_when = watch }
  return widest
end

scenario("Newton's cradle goes on as it began: as many balls in, as many out, those between stay", function(s)
  for _, plan in ipairs { "play", "study", "reference" } do
    for _, step in ipairs { 1 / 30, 1 / 60, 1 / 300 } do
      for let_go = 1, 2 do
        local widest = cradle(s, { accuracy = plan, step = step }, 5, let_go)
        for i = 1, 5 do
          local swings = i <= let_go or i > 5 - let_go
          expect(widest[i]):near(swings and 30 or 0, swings and 0.15 or 1e-3)      -- at 1/30 s the widest may fall between two frames
        end
      end
    end
  end
end)

-- The same without weight, a spring holding the row together by next to nothing.
scenario("a row of balls that a faint spring presses together hands a blow on, one in, one out", function(s)
  for _, stiffness in ipairs { 0, 1e-9, 1e-6 } do
    local world, balls = s:world { gravity = { 0, 0, 0 } }, {}
    for i = 0, 4 do
      balls[i] = world:ball { radius = 0.05, mass = 1, restitution = 1, friction = 0, at = { 0.1 * i - (i == 0 and 0.2 or 0), 0, 0 } }
    end
    local a, b = balls[1], balls[4]
    if stiffness > 0 then world:spring { a = a, b = b, at_a = a.position, at_b = b.position, length = 0, stiffness = stiffness } end
    world:run "0.5 s"
    balls[0]:hit { impulse = { 1, 0, 0 } }
    world:run "0.5 s"
    for i = 0, 4 do expect(balls[i].velocity.x):near(i == 4 and 1 or 0, 1e-5) end
  end
end)

-- The edge that it comes down on first lifts off by its turn before the other one is down, by 0.2 mm. When something pushed it back it was
-- put on the belt at once, one corner of the two: that took 5 mJ, and turned the box out of its plane.
scenario("a box that falls on a belt edge first stays in its plane, and keeps its books", function()
  for k = 0, 99 do
    local world = digbox.world { step = 1 / 30 }
    local belt = world:box { kinematic = true, size = { 40, 0.1, 2 }, at = { 0, -0.05, 0 }, friction = 0.5, restitution = 0 }
    belt:drive { velocity = { -3 + 0.06 * k, 0, 0 } }
    local box = world:box { size = { 0.27, 0.21, 0.2 }, at = { 0, 0.4 + 0.003 * k, 0 }, friction = 0.5, restitution = 0,
                            rotation = digbox.quat { axis = { 0, 0, 1 }, angle = 0.1 + 0.013 * k } }
    world:run "1 s"
    expect(world.energy.numerical):near(0, 1e-4)
    expect(box.centre.z):near(0, 1e-8)
  end
end)
