-- One body that hangs by one joint: a step of it is one evaluation and exact, on a hinge (with a spring, a damper and friction, too), on a
-- ball joint, and on a rod or a rope without mass; and nothing that ends it is overlooked. A region far away is enough to have the tracer
-- follow it instead.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- A rod of 1 m and 2 kg on a post, level at first. more: options of the hinge, then those of the rod and of the world; is_b: of its joint.
local function rod_on_post(more, rod_more, world_more, is_b)
  local world = digbox.world(world_more or {})
  local post = world:box { size = { 0.1, 0.1, 0.1 }, at = { 0, 5, 0 }, fixed = true }
  local options = { size = { 1, 0.05, 0.05 }, at = { 0.5, 5, 0.3 }, mass = 2 }
  for key, value in pairs(rod_more or {}) do options[key] = value end
  local rod = world:box(options)
  local hinge = { a = is_b and post or rod, b = is_b and rod or post, at = { 0, 5, 0 }, axis = { 0, 0, 1 } }
  for key, value in pairs(more or {}) do hinge[key] = value end
  return world, rod, world:hinge(hinge)
end

local inertia = 2 * (1 + 0.05 ^ 2) / 12 + 2 * 0.25      -- kg m^2 about the hinge

scenario("a rod pendulum is where its elliptic functions are, at every plan, at one evaluation a step", function()
  for _, accuracy in ipairs { "sketch", "play", "study", "reference" } do
    local world = digbox.world { accuracy = accuracy }
    local rod = world:box { size = { 1, 0.1, 0.1 }, mass = 1, at = { 0.5, 0, 0 } }
    local hinge = world:hinge { a = rod, at = { 0, 0, 0 }, axis = { 0, 0, 1 } }
    -- angle against straight down, of the closed form (elliptic functions of modulus sin 45 degrees)
    local angles = { [60] = -1.56322222501368957, [120] = 1.54050078863994443, [300] = -1.38166932062409884, [600] = 0.82746667874679126 }
    for k = 1, 600 do
      world:step()
      expect(world:stats().evaluations):is(1)
      if angles[k] then expect(hinge.angle):near(angles[k] - math.pi / 2, 2e-12) end
    end
    expect(hinge.speed):near(-4.4572277905732990, 1e-11)
    expect(world.energy.total - world.energy.initial):near(0, 1e-13)
    expect(hinge.error):below(1e-15)
  end
end)

scenario("what a hinge does to its bodies is what the tracer finds, whichever of them swings", function()
  local hinges = {
    {}, { friction = 0.4 }, { spring = { stiffness = 30, damping = 0.5, rest = 0.2 } }, { spring = { stiffness = 0, damping = 0.7 } },
    { limits = { -4, 4 } },
  }
  for _, more in ipairs(hinges) do
    for _, is_b in ipairs { false, true } do
      local world, rod, hinge = rod_on_post(more, {}, {}, is_b)
      local other, its_rod, its_hinge = rod_on_post(more, {}, {}, is_b)
      other:region { box = { size = { 1, 1, 1 } }, at = { 0, 100, 0 }, laws = { time_rate = 0.5 } }
      for k = 1, 120 do
        world:step()
        other:step()
        if k % 8 == 1 then
          expect(rod.position):near(its_rod.position, 1e-7)
          expect(rod.velocity):near(its_rod.velocity, 1e-6)
          expect(hinge.angle):near(its_hinge.angle, 1e-7)
          expect(hinge.force):near(its_hinge.force, 2e-5)
          expect(hinge.torque):near(its_hinge.torque, 2e-5)
          expect(world.energy.lost):near(other.energy.lost, 1e-6)
        end
      end
      expect(world.energy.total - world.energy.initial + world.energy.lost):near(0, 1e-9)
      expect(other:stats().evaluations):above(1)
    end
  end
end)

scenario("on a spring with a damper a wheel swings as the closed form says", function()
  local stiffness, damping = 40, 0.3
  local world = digbox.world {}
  local wheel = world:cylinder {
    radius = 0.5, height = 0.1, mass = 3, at = { 0, 2, 0 }, rotation = { axis = { 1, 0, 0 }, angle = math.pi / 2 }
  }
  local spring = { stiffness = stiffness, damping = damping, rest = 1 }
  local hinge = world:hinge { a = wheel, at = { 0, 2, 0 }, axis = { 0, 0, 1 }, spring = spring }
  local turned = 0.5 * 3 * 0.25
  local b = damping / turned / 2
  local w = math.sqrt(stiffness / turned - b * b)
  for k = 1, 300 do
    world:step()
    local t = k / 60
    expect(hinge.angle):near(1 - math.exp(-b * t) * (math.cos(w * t) + b / w * math.sin(w * t)), 1e-12)
  end
  expect(world:stats().evaluations):is(1)
  expect(world.energy.total - world.energy.initial + world.energy.lost):near(0, 1e-12)
end)

scenario("friction of a hinge takes its torque times the angle, and holds in the end", function()
  local world, rod, hinge = rod_on_post { friction = 0.4 }
  local turned, last = 0, 0
  for _ = 1, 30 do
    world:step()
    turned = turned + math.abs(hinge.angle - last)
    last = hinge.angle
    expect(world.energy.lost):near(0.4 * turned, 1e-9)
  end
  world:run "60 s"
  expect(rod.spin:length()):below(1e-9)
  expect(math.abs(2 * 9.81 * 0.5 * math.cos(hinge.angle))):below(0.4)
end)

scenario("a stop ends a swing where it is, at 1 and at 300 rad/s", function()
  for _, speed in ipairs { -1, -300 } do
    local world, rod, hinge = rod_on_post({ limits = { -1, 2 } }, { restitution = 0 }, { gravity = { 0, 0, 0 } })
    rod:teleport { velocity = { 0, speed * 0.5, 0 }, spin = { 0, 0, speed } }
    world:run "1.5 s"
    expect(hinge.angle):near(-1, 1e-9)
    expect(hinge.at_limit):is(true)
    expect(rod.spin.z):near(0, 1e-9)
  end
end)

-- 5 mm long, it swings through 2.9 rad and back by half within a step of 0.1 s. From its stop it swings to the other side and back; while
-- it was put back to the stop as soon as it was pulled that way, it stayed there in steps of 0.1 s, and swung on in shorter ones.
scenario("a stop ends a swing that comes back within the same step", function()
  local function swing(step, stop)
    local world = digbox.world { step = step }
    local rod = world:box { size = { 0.005, 0.0005, 0.0005 }, mass = 1, at = { 0.0025, 0, 0 }, restitution = 0 }
    local hinge = world:hinge { a = rod, at = { 0, 0, 0 }, axis = { 0, 0, 1 }, limits = { stop, 1 } }
    world:step()
    return world, hinge
  end
  for _, stop in ipairs { -1.8, -2.5 } do
    local world, hinge = swing(0.1, stop)
    expect(world:stats().evaluations):above(1)
    local short, other = swing(1e-3, stop)
    for _ = 1, 10 do
      world:run "0.1 s"
      short:run(world.time - short.time)
      expect(hinge.angle):between(stop - 1e-9, -math.pi - stop + 1e-4)
      expect(hinge.angle):near(other.angle, 1e-3)
    end
  end
end)

scenario("turns are counted, at 700 rad/s, too", function()
  local world, rod, hinge = rod_on_post({}, {}, { gravity = { 0, 0, 0 } })
  rod:teleport { velocity = { 0, 350, 0 }, spin = { 0, 0, 700 } }
  for k = 1, 60 do
    world:step()
    expect(hinge.angle):near(700 * k / 60, 1e-9)
  end
  expect(hinge.force:length()):near(2 * 700 ^ 2 * 0.5 * math.abs(math.sin(700 / 120) / (700 / 120)), 1e-3)    -- the mean over the step
end)

scenario("a swing meets what is in its way", function()
  for _, is_b in ipairs { false, true } do
    local world, rod, hinge = rod_on_post({}, { restitution = 0 }, {}, is_b)
    world:box { size = { 0.2, 0.2, 0.4 }, at = { 0, 4.3, 0.3 }, fixed = true, restitution = 0 }
    local lowest = 5
    for _ = 1, 240 do
      world:step()
      lowest = math.min(lowest, rod.position.y)
    end
    -- its end of 0.025 m on the box's side, 0.1 m from the middle
    expect(lowest):above(4.5)
    expect(rod.spin:length()):below(1e-6)
    expect(math.abs(hinge.angle)):above(1.3)
    expect(math.abs(hinge.angle)):below(1.48)
  end
end)

-- From rest, with 100 N m/rad and more on a third of a kg m^2: through half a radian and more in the first step.
scenario("what is near is met by what a spring throws at it from rest", function()
  for _, stiffness in ipairs { 100, 200, 400 } do
    for _, angle in ipairs { 0.2, 0.4 } do
      local spring = { stiffness = stiffness, rest = 1 }
      local world, _, hinge = rod_on_post({ spring = spring }, { restitution = 0 }, { step = 1 / 30, gravity = { 0, 0, 0 } })
      world:box {
        size = { 0.9, 0.02, 1 }, at = { 0.9 * math.cos(angle), 5.02 + 0.9 * math.sin(angle), 0 },
        rotation = { axis = { 0, 0, 1 }, angle = angle }, fixed = true, restitution = 0
      }
      for _ = 1, 15 do
        world:step()
        expect(hinge.angle):below(angle + 0.02)
      end
    end
  end
end)

scenario("what a script changes is felt at once", function()
  local world, rod, hinge = rod_on_post()
  world:run "0.2 s"
  local speed = hinge.speed
  rod:push { force = { 0, 40, 0 }, lasts = 1 }
  local pull = 2 * 9.81 * 0.5 * math.cos(hinge.angle)
  world:step()
  expect(hinge.speed - speed):near((40 * 0.5 * math.cos(hinge.angle) - pull) / inertia / 60, 0.02)
  hinge:set { friction = 100 }
  world:run "0.2 s"
  expect(hinge.speed):near(0, 1e-9)
end)

-- ---- on a ball joint ----

local function far_region(world) world:region { box = { size = { 1, 1, 1 } }, at = { 0, 100, 0 }, laws = { time_rate = 0.5 } } end

-- J  That the books do not explain.
local function astray(world) return world.energy.total - world.energy.initial + world.energy.lost end

-- A disc at 1 m on a stick without mass, 60 degrees from the vertical: it precesses steadily at a root w of
-- A cos w^2 - C s w + m g l = 0, A and C the moments about the point across and along its axis, s its spin about that.
scenario("a top precesses steadily at every plan, at one evaluation a step", function()
  local tilt, spin, radius, height = math.rad(60), 60, 0.5, 0.02
  local a, c = (radius ^ 2 / 4 + height ^ 2 / 12 + 1) * math.cos(tilt), radius ^ 2 / 2 * spin
  local rate = 2 * 9.81 / (c + math.sqrt(c * c - 4 * a * 9.81))
  for _, accuracy in ipairs { "sketch", "play", "reference" } do
    local world = digbox.world { accuracy = accuracy }
    local axis = digbox.vec(math.sin(tilt), math.cos(tilt), 0)
    local turn = digbox.vec(0, rate, 0) + axis * (spin - rate * math.cos(tilt))
    local disc = world:cylinder {
      radius = radius, height = height, mass = 1, at = axis, rotation = digbox.quat { from = { 0, 1, 0 }, to = axis },
      spin = turn, velocity = turn:cross(axis), collides = false
    }
    world:ball_joint { a = disc, at = { 0, 0, 0 } }
    for k = 1, 600 do
      world:step()
      expect(world:stats().evaluations):is(1)
      local angle = rate * k / 60
      if k % 50 == 0 then
        expect(disc.position):near({ math.sin(tilt) * math.cos(angle), math.cos(tilt), -math.sin(tilt) * math.sin(angle) }, 1e-10)
      end
    end
    expect(astray(world)):near(0, 1e-10)
  end
end)

scenario("what a ball joint does to its bodies is what the tracer finds, whichever of them turns", function()
  for _, is_b in ipairs { false, true } do
    local worlds = {}
    for k = 1, 2 do
      local world = digbox.world {}
      local post = world:box { size = { 0.1, 0.1, 0.1 }, at = { 0, 5, 0 }, fixed = true }
      local brick = world:box {
        size = { 0.3, 0.2, 0.1 }, mass = 2, at = { 0.4, 5, 0.3 }, spin = { 3, -5, 2 },
        velocity = digbox.vec(3, -5, 2):cross { 0.4, -0.05, 0.3 }
      }
      local at = { 0, 5.05, 0 }
      local joint = world:ball_joint { a = is_b and post or brick, b = is_b and brick or post, at = at }
      if k == 2 then far_region(world) end
      worlds[k] = { world = world, brick = brick, joint = joint }
    end
    for k = 1, 120 do
      for i = 1, 2 do worlds[i].world:step() end
      if k % 8 == 1 then
        expect(worlds[1].brick.position):near(worlds[2].brick.position, 1e-6)
        expect(worlds[1].brick.spin):near(worlds[2].brick.spin, 1e-5)
        expect(worlds[1].joint.force):near(worlds[2].joint.force, 1e-4)
        expect(worlds[1].joint.torque):near(worlds[2].joint.torque, 1e-4)
        expect(worlds[1].joint.error):below(1e-14)
      end
    end
    expect(worlds[1].world:stats().evaluations):is(1)
    expect(worlds[2].world:stats().evaluations):above(1)
    expect(astray(worlds[1].world)):near(0, 1e-11)
  end
end)

-- ---- on a rod or a rope without mass ----

-- angle against straight down, of the closed form (elliptic functions of modulus sin 45 degrees)
scenario("a bob is where its elliptic functions are, on a rod at every plan, and on a rope", function()
  for _, how in ipairs { "sketch", "play", "reference", "rope" } do
    local world = digbox.world { accuracy = how == "rope" and "play" or how }
    local bob = world:ball { radius = 0.05, mass = 1, at = { 1, 0, 0 }, spin = { 1, 2, 3 }, collides = false }
    local joint = { a = bob, at_b = { 0, 0, 0 }, length = 1 }
    joint = how == "rope" and world:rope(joint) or world:distance(joint)
    local work = 0
    for _ = 1, 600 do
      world:step()
      work = work + world:stats().evaluations
    end
    expect(work):between(600, how == "rope" and 900 or 600)             -- where it turns back its pull is none: it could go slack
    local tolerance = how == "rope" and 1e-6 or 1e-11
    expect(bob.position):near({ 0.27508746257611686, -0.96141920509912506, 0 }, tolerance)
    expect(astray(world)):near(0, how == "rope" and 1e-8 or 1e-12)
    expect(bob.spin):near({ 1, 2, 3 }, 1e-12)
    expect(joint.error):below(1e-14)
  end
end)

-- At an angle a from straight down, round at w^2 = g / (R cos a), with the pull m g / cos a.
scenario("a bob goes round as a cone, and its rod holds it so", function()
  for _, is_b in ipairs { false, true } do
    local world = digbox.world {}
    local angle, length = math.rad(40), 2
    local rate = math.sqrt(9.81 / (length * math.cos(angle)))
    local radius, down = length * math.sin(angle), length * math.cos(angle)
    local post = world:box { size = { 0.1, 0.1, 0.1 }, at = { 0, 3, 0 }, fixed = true }
    local bob = world:box { size = { 0.2, 0.1, 0.1 }, mass = 3, at = { radius, 3 - down, 0 }, velocity = { 0, 0, -rate * radius } }
    local rod = world:distance { a = is_b and post or bob, b = is_b and bob or post }
    for k = 1, 300 do
      world:step()
      local turned = rate * k / 60
      expect(bob.position):near({ radius * math.cos(turned), 3 - down, -radius * math.sin(turned) }, 1e-11)
    end
    expect(world:stats().evaluations):is(1)
    local mean = 3 * 9.81 * math.tan(angle) * math.sin(rate / 120) / (rate / 120)       -- across, over a step
    expect(rod.force:length()):near(math.sqrt((3 * 9.81) ^ 2 + mean ^ 2), 1e-9)
  end
end)

-- With v^2 = 3.5 g R at the bottom the rope is slack from where cos a = -(v^2 / (g R) - 2) / 3 = -1/2 on, 120 degrees from straight down.
scenario("a rope goes slack where its pull ends, and the bob flies on as a parabola", function()
  local world = digbox.world {}
  local bob = world:ball { radius = 0.05, mass = 1, at = { 0, -1, 0 }, velocity = { math.sqrt(3.5 * 9.81), 0, 0 }, collides = false }
  world:rope { a = bob, at_b = { 0, 0, 0 }, length = 1 }
  local highest, slack = -1, false
  for _ = 1, 40 do
    world:step()
    highest = math.max(highest, bob.position.y)
    slack = slack or #bob.position < 1 - 1e-4
  end
  expect(slack):is(true)
  -- speed there: v^2 = 3.5 g - 2 g 1.5 = g / 2, at 60 degrees against level: up by v^2 sin^2 60 / (2 g) from 0.5 m
  expect(highest):near(0.5 + 0.5 * 0.75 / 2, 3e-3)
  expect(astray(world)):near(0, 1e-6)
end)

-- On the same circle from 112 degrees on: a centimetre long, it is slack and taut again within a step of 0.07 s, and pulls alike
-- before and after.
scenario("a rope goes slack in the midst of a step, too", function()
  local length, angle = 0.01, math.rad(112)
  local speed = math.sqrt(9.81 * length * (1.5 + 2 * math.cos(angle)))
  local world = digbox.world { step = 0.07 }
  local bob = world:ball {
    radius = 0.0005, mass = 1, at = { length * math.sin(angle), -length * math.cos(angle), 0 }, collides = false,
    velocity = { speed * math.cos(angle), speed * math.sin(angle), 0 }
  }
  world:rope { a = bob, at_b = { 0, 0, 0 }, length = length }
  world:step()
  expect(#bob.position):below(0.5 * length)
end)

scenario("a bob meets what is in its way", function()
  local world = digbox.world {}
  local bob = world:ball { radius = 0.1, mass = 1, at = { 1, 3, 0 }, restitution = 0 }
  world:distance { a = bob, at_b = { 0, 3, 0 } }
  world:box { size = { 0.4, 2, 1 }, at = { -0.2, 2, 0 }, fixed = true, restitution = 0, friction = 0 }
  for _ = 1, 240 do
    world:step()
    expect(bob.position.x):above(0.1 - 1e-6)
  end
  expect(bob.speed):below(0.05)
end)

scenario("what hangs at rest stays so, to the last bit, and bears its weight", function()
  local joints = {
    function(world, body) return world:hinge { a = body, at = { 0, 1, 0 }, axis = { 0, 0, 1 } } end,
    function(world, body) return world:ball_joint { a = body, at = { 0, 1, 0 } } end,
    function(world, body) return world:distance { a = body, at_b = { 0, 1, 0 } } end,
    function(world, body) return world:rope { a = body, at_b = { 0, 1, 0 }, length = 1 } end,
  }
  for _, join in ipairs(joints) do
    local world = digbox.world { sleeping = false }
    local body = world:box { size = { 0.2, 0.4, 0.1 }, mass = 2, at = { 0, 0, 0 } }
    local joint = join(world, body)
    world:run "1 s"
    expect(body.position):near({ 0, 0, 0 }, 0)
    expect(body.velocity):near({ 0, 0, 0 }, 0)
    expect(joint.force):near({ 0, 2 * 9.81, 0 }, 1e-12)
    expect(world:stats().evaluations):is(1)
  end
end)
