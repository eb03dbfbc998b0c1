-- One body on one hinge: a step of it is one evaluation and exact, with a spring, a damper and friction, too; and nothing that ends it is
-- overlooked. A region far away is enough to have the tracer follow it instead.
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
