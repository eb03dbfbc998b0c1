-- laws_joints.lua: one scenario for each type of joint, against a closed form.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local g = 9.81
local none = { gravity = { 0, 0, 0 } }

-- Where a quantity goes from down to up through 0, between frames
local function crossings(world, count, value)
  local list, last = {}, value()
  while #list < count and world.time < 20 do
    world:step()
    local now = value()
    if last < 0 and now >= 0 then list[#list + 1] = world.time - world.frame * now / (now - last) end
    last = now
  end
  return list
end

scenario("hinge: a small swing takes 2 pi sqrt(I / (m g d))", function(s)
  local world = s:world { accuracy = "study" }
  local w, h, a = 0.2, 0.6, 0.02
  local turn = digbox.quat { axis = { 0, 0, 1 }, angle = a }
  local bar = world:box { size = { w, h, 0.1 }, at = turn:rotate { 0, -h / 2, 0 }, rotation = turn }
  local hinge = world:hinge { a = bar, at = { 0, 0, 0 }, axis = { 0, 0, 1 } }
  local t = crossings(world, 4, function() return hinge.angle + a end)
  local I = (w * w + h * h) / 12 + h * h / 4            -- over the mass
  local T = 2 * math.pi * math.sqrt(I / (g * h / 2))
  expect((t[4] - t[1]) / 3):near(T, 2e-4 * T)           -- a^2 / 16 = 2.5e-5 of it is the amplitude
  expect(#hinge.force):between(bar.mass * g * 0.99, bar.mass * g * 1.01)
end)

scenario("hinge: its motor gives no more than its torque, its friction no more than its own", function(s)
  local world = s:world(none)
  local wheel = world:cylinder { radius = 0.2, height = 0.1, mass = 5 }     -- I = m r^2 / 2 = 0.1 about y
  local hinge = world:hinge { a = wheel, at = { 0, 0, 0 }, axis = { 0, 1, 0 }, motor = { speed = 100, max_torque = 0.2 } }
  world:run "1 s"
  expect(hinge.speed):near(2, 1e-3)                     -- 0.2 N m on 0.1 kg m^2 for 1 s
  expect(hinge.angle):near(1, 0.02)
  hinge:set { motor = { speed = 0, max_torque = 0 }, friction = 0.1 }
  world:run "1 s"
  expect(hinge.speed):near(1, 1e-3)                     -- dry friction takes 1 rad/s every second
  world:run "1.5 s"
  expect(hinge.speed):near(0, 1e-6)
end)

-- Nothing bounds what it may press with, and the stop is as hard.
for _, accuracy in ipairs { "sketch", "play", "study" } do
  scenario("a motor without a bound stops at its joint's stop, holds there and comes back (" .. accuracy .. ")", function(s)
    local world = s:world { accuracy = accuracy }
    local rod = world:box { size = { 1, 0.1, 0.1 }, mass = 3, at = { 0.5, 0, 0 } }
    local hinge = world:hinge { a = rod, at = { 0, 0, 0 }, axis = { 0, 0, 1 }, motor = { speed = 100 }, limits = { -1, 1 } }
    local cart = world:box { size = 0.3, mass = 3, at = { 5, 0, 0 } }       -- its weight pulls it off the stop that it is driven at
    local slider = world:slider { a = cart, axis = { 0, 1, 0 }, motor = { speed = 2 }, limits = { -1, 1 } }
    world:run "2 s"
    expect(hinge.angle):near(1, 1e-6)
    expect(slider.distance):near(1, 1e-6)
    expect(rod.asleep and cart.asleep):is(true)
    expect(#world:warnings()):is(0)
    expect(math.abs(world.energy.numerical)):at_most(1e-3 * world.energy.work_in)
    slider:set { motor = { speed = -0.5 } }
    world:run "2 s"
    expect(slider.distance):near(0, 1e-2)
    world:run "3 s"
    expect(slider.distance):near(-1, 1e-6)
    expect(cart.asleep):is(true)
  end)
end

-- What a step leaves its joints off, 1e-8 m, is put right: that stops no motor and no friction that pushes with all it has.
scenario("hinge: friction of 1 mN m takes from a swinging rod what it takes along its way, and no more", function(s)
  local world = s.world
  local rod = world:box { size = { 1, 0.1, 0.1 }, mass = 1, at = { 0.5, 0, 0 }, collides = false }
  local hinge = world:hinge { a = rod, at = { 0, 0, 0 }, axis = { 0, 0, 1 }, friction = 0.001 }
  local last, way = 0, 0
  s:always("no dead stop", "4 s", function()
    last, way = hinge.angle, way + math.abs(hinge.angle - last)
    return world.energy.lost < 0.0011 * way + 1e-4
  end)
  rod:teleport { at = rod.position + digbox.vec(0, 1e-7, 0) }
  local before = hinge.speed
  world:step()
  expect(hinge.speed):near(before, 0.3)                 -- gravity changes it by 0.25 rad/s a frame at most
end)

scenario("hinge: a motor brakes a falling rod, and lets it turn back at its highest", function(s)
  local exact = { [0.5] = { -1.463257, 7.139195 }, [0.1] = { -1.489977, 9.330105 } }     -- I a = -m g l cos(angle) - torque sgn(speed)
  for torque, want in pairs(exact) do
    local world = s:world {}
    local rod = world:box { size = { 0.3, 0.04, 0.04 }, mass = 3, at = { 0.15, 0, 0 }, collides = false }
    local hinge = world:hinge { a = rod, at = { 0, 0, 0 }, axis = { 0, 0, 1 }, motor = { speed = 0, max_torque = torque } }
    world:run "0.8 s"
    expect(hinge.angle):near(want[1], 1e-5)
    expect(hinge.speed):near(want[2], 1e-5)
    expect(world:stats().gave_up):is(0)
  end
end)

scenario("hinge: over a rack, a motor too weak for its load lets it fall with what is left", function(s)
  for _, step in ipairs { 1 / 30, 1 / 60, 1 / 120 } do
    local world = s:world { step = step }
    local wheel = world:cylinder { radius = 0.3, height = 0.05, mass = 5, at = { 0, 1, 0 }, collides = false,
                                   rotation = { axis = { 1, 0, 0 }, angle = math.pi / 2 } }
    local hinge = world:hinge { a = wheel, at = { 0, 1, 0 }, axis = { 0, 0, 1 }, motor = { speed = 2, max_torque = 12 } }
    local load = world:box { size = 0.2, mass = 30, at = { 1, 1, 0 }, collides = false }
    local slider = world:slider { a = load, along = { 0, 1, 0 } }
    world:rack { a = hinge, b = slider, ratio = 0.3 }
    world:run "2 s"
    expect(slider.speed):near(-2 * (30 * g - 12 / 0.3) / (30 + 0.225 / 0.09), 1e-4)     -- I = m r^2 / 2 = 0.225
  end
end)

-- Linkages turn slowly and fast in turn, and go from the way that conserves energy to the trace and back.
local function bar_between(world, a, b, mass, thick)
  local d = b - a
  return world:box { size = { #d, 0.05, thick }, mass = mass, at = (a + b) / 2, collides = false,
                     rotation = digbox.quat { from = { 1, 0, 0 }, to = d:normalized() } }
end

local function four_bar(world)
  local p = { digbox.vec(0, 0, 0), digbox.vec(-0.3, 1, 0), digbox.vec(1.7, 1.4, 0), digbox.vec(2, 0, 0) }
  local bars = {}
  for i, mass in ipairs { 2, 1, 5 } do bars[i] = bar_between(world, p[i], p[i + 1], mass, 0.05) end
  for i = 1, 4 do world:hinge { a = bars[i] or bars[3], b = i < 4 and bars[i - 1] or nil, at = p[i], axis = { 0, 0, 1 } } end
  return bars
end

local function ring_of_bars(world, n)
  local bars = {}
  local function corner(i) return digbox.vec(math.cos(2 * math.pi * i / n), math.sin(2 * math.pi * i / n), 0) end
  for i = 1, n do bars[i] = bar_between(world, corner(i - 1), corner(i), 0.5 + 0.1 * i, 0.1) end
  for i = 1, n do world:hinge { a = bars[i], b = bars[i % n + 1], at = corner(i), axis = { 0, 0, 1 } } end
  world:hinge { a = bars[3], at = corner(3), axis = { 0, 0, 1 } }
end

scenario("hinge: linkages keep their energy, whichever way takes them", function(s)
  for _, case in ipairs { { 1 / 30, four_bar }, { 1 / 60, ring_of_bars, 6 }, { 1 / 60, ring_of_bars, 12 } } do
    local world = s:world { step = case[1] }
    case[2](world, case[3])
    local start, greatest = world.energy.total, 0
    s:always("it changes by rounding", "20 s", function()
      greatest = math.max(greatest, world.energy.kinetic)
      return math.abs(world.energy.total - start) <= 1e-6 * greatest + 1e-9
    end)
    expect(world.energy.lost):near(0, 1e-12)
  end
end)

scenario("hinge: a linkage is where finer steps have it", function(s)
  local fine, places = s:world { accuracy = "study" }, {}
  local bars = four_bar(fine)
  fine:run "10 s"
  for i = 1, 3 do places[i] = bars[i].position end
  local coarse = s:world { step = 1 / 30 }
  bars = four_bar(coarse)
  coarse:run "10 s"
  for i = 1, 3 do expect(bars[i].position):near(places[i], 1e-3) end     -- of a way of 40 m
end)

scenario("hinge: a mass on its spring swings with 2 pi sqrt(I / k), and its limits stop it", function(s)
  local world = s:world { gravity = { 0, 0, 0 }, accuracy = "study" }
  local wheel = world:cylinder { radius = 0.2, height = 0.1, mass = 5, spin = { 0, 2, 0 } }     -- I = 0.1
  local hinge = world:hinge { a = wheel, at = { 0, 0, 0 }, axis = { 0, 1, 0 }, spring = { stiffness = 10 } }
  local t = crossings(world, 4, function() return hinge.angle end)
  expect((t[4] - t[1]) / 3):near(2 * math.pi * math.sqrt(0.1 / 10), 1e-3)
  expect(world.energy.total):near(0.1 * 2 ^ 2 / 2, 1e-3)
  hinge:set { spring = { stiffness = 0 }, limits = { -0.1, 0.1 } }
  s:always("within its limits", "2 s", function() return math.abs(hinge.angle) < 0.1 + 1e-2 end)
end)

scenario("slider: on a slope it runs down with g sin, and stops at its limit", function(s)
  local world = s.world
  local along = digbox.vec(1, -1, 0):normalized()
  local box = world:box { size = 0.2, mass = 3, at = { 0, 0, 0 } }
  local slider = world:slider { a = box, along = along, limits = { -1, 2 } }
  world:run "0.5 s"
  local a = g * math.sqrt(0.5)
  expect(slider.distance):near(a * 0.125, 1e-3)
  expect(slider.speed):near(a * 0.5, 1e-3)
  expect(#slider.force):near(3 * g * math.sqrt(0.5), 0.05)                  -- what keeps it on the line
  expect(box.position:cross(along)):near({ 0, 0, 0 }, 1e-4)
  s:eventually("at the limit", "2 s", function() return slider.at_limit end)
  world:run "2 s"
  expect(slider.distance):near(2, 1e-3)
  expect(box.rotation.angle):near(0, 1e-4)
end)

scenario("slider: its motor holds a load up to its force, its friction likewise", function(s)
  local world = s.world
  local function lift(most, friction)
    local box = world:box { size = 0.2, mass = 2, at = { 1 + #world:bodies(), 0, 0 } }
    local motor = most and { speed = 0.5, max_force = most }
    return world:slider { a = box, along = { 0, 1, 0 }, motor = motor, friction = friction }
  end
  local strong, weak, stuck, slips = lift(30), lift(15), lift(nil, 25), lift(nil, 10)
  world:run "1 s"
  expect(strong.speed):near(0.5, 1e-4)
  expect(strong.force.y):near(2 * g, 0.05)
  expect(weak.speed):near((15 - 2 * g) / 2, 1e-2)       -- falls with what is left
  expect(stuck.distance):near(0, 1e-6)
  expect(slips.speed):near((10 - 2 * g) / 2, 1e-2)
end)

scenario("ball joint: a conical pendulum goes round with omega^2 = g / (l cos)", function(s)
  local world = s:world { accuracy = "study" }
  local l, tilt = 0.8, math.rad(30)
  local omega = math.sqrt(g / (l * math.cos(tilt)))
  local r = l * math.sin(tilt)
  local bob = world:ball { radius = 0.01, mass = 1, at = { r, -l * math.cos(tilt), 0 }, velocity = { 0, 0, -omega * r },
                           spin = { 0, omega, 0 } }
  local joint = world:ball_joint { a = bob, at = { 0, 0, 0 } }
  local T = 2 * math.pi / omega
  local lowest, highest = math.huge, -math.huge
  while world.time < T do
    world:step()
    lowest, highest = math.min(lowest, bob.position.y), math.max(highest, bob.position.y)
  end
  expect(highest - lowest):below("1 mm")
  local over = (world.time - T) * omega                 -- the last frame ends a little after a whole turn
  expect(bob.position):near({ r * math.cos(over), -l * math.cos(tilt), -r * math.sin(over) }, "4 mm")
  expect(#joint.force):near(g / math.cos(tilt), 0.02 * g)
  expect(joint.error):below(1e-4)
end)

-- The stop turns with the rod.
for _, c in ipairs { { "sketch", 0.05 }, { "play", 0.03 }, { "study", 1e-3 } } do
  scenario("ball joint: a rod that whirls along its cone keeps its energy (" .. c[1] .. ")", function(s)
    local world = s:world { gravity = { 0, 0, 0 }, accuracy = c[1] }
    local rod = world:box { size = { 0.1, 1, 0.1 }, mass = 2, at = { 0, 1.5, 0 } }
    world:ball_joint { a = rod, at = { 0, 2, 0 }, axis = { 0, 1, 0 }, swing = 0.6, friction = 1e-6 }
    local top, turn = digbox.vec(0, 2, 0), digbox.quat { angle = 0.6, axis = { 0, 0, 1 } }
    local arm = turn * digbox.vec(0, -0.5, 0)
    local spin = (digbox.vec(0, 1, 0) - turn * digbox.vec(0, 1, 0)) * 20
    rod:teleport { at = top + arm, rotation = turn, velocity = spin:cross(arm), spin = spin }
    local before = world.energy.total
    world:run "1 s"
    expect(world.energy.total):near(before, c[2] * before)
  end)
end

-- Friction along the spin alone: rows across it would hold its direction, against a stop that turns it.
scenario("ball joint: its friction takes from what whirls along its cone what it takes along the way, and is followed", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local rod = world:box { size = { 0.1, 1, 0.1 }, mass = 2, at = { 0, 1.5, 0 } }
  world:ball_joint { a = rod, at = { 0, 2, 0 }, axis = { 0, 1, 0 }, swing = 0.6, friction = 0.01 }
  local top, turn = digbox.vec(0, 2, 0), digbox.quat { angle = 0.6, axis = { 0, 0, 1 } }
  local arm = turn * digbox.vec(0, -0.5, 0)
  local spin = (digbox.vec(0, 1, 0) - turn * digbox.vec(0, 1, 0)) * 20
  rod:teleport { at = top + arm, rotation = turn, velocity = spin:cross(arm), spin = spin }
  local before, way = world.energy.total, 0
  for _ = 1, 60 do
    local last = #rod.spin
    world:step()
    way = way + 0.5 * (last + #rod.spin) * world.frame
  end
  expect(before - world.energy.total):near(0.01 * way, 1e-3 * way * 0.01)
  expect(world:stats().all_swept):is(0)
end)

scenario("weld: two boxes move as one body about their common centre", function(s)
  local world = s:world(none)
  local a = world:box { size = 0.2, mass = 1, at = { -0.3, 0, 0 } }
  local b = world:box { size = 0.2, mass = 2, at = { 0.3, 0, 0 } }
  local weld = world:weld { a = a, b = b, at = { 0, 0, 0 } }
  b:hit { impulse = { 0, 0, 3 } }
  world:run "1 s"
  local I = (1 + 2) * 0.2 ^ 2 / 6 + 1 * 0.4 ^ 2 + 2 * 0.2 ^ 2               -- about the centre at x = 0.1
  local spin = -3 * 0.2 / I
  expect(a.spin):near({ 0, spin, 0 }, 1e-3)
  expect(b.spin):near({ 0, spin, 0 }, 1e-3)
  expect((a.position + b.position * 2) / 3):near({ 0.1, 0, 1 }, 1e-6)
  expect(#(a.position - b.position)):near(0.6, 1e-4)
  expect(weld.error):below(1e-4)
end)

-- Their faces are covered by each other for all but themselves (engine/solve/cover.c): between them no other normal will do.
scenario("weld: boxes that touch face to face stay where they are when the weld lets them touch", function(s)
  for _, kind in ipairs { "weld", "bolt" } do
    for _, overlap in ipairs { 0, 1e-6, 1e-3 } do
      local world = s:world { gravity = { 0, 0, 0 } }
      local a = world:box { size = 0.1 }
      local b = world:box { size = 0.1, at = { 0.1 * (1 - overlap), 0, 0 } }
      world[kind](world, { a = a, b = b, at = { 0.05, 0, 0 }, collides = true })
      world:run "1 s"
      expect(#a.position):near(0, 2e-4)
      expect(#(b.position - digbox.vec(0.1, 0, 0))):near(0, 2e-4)
      expect(math.abs(a.rotation.w)):near(1, 1e-8)           -- 0.3 mrad: a weld and an overlap contradict each other
      expect(world:stats().warnings):is(0)
    end
  end
end)

-- Four cubes and three welds, six cylinders about one: who is not welded to each other touches exactly, and is held by the rest.
local function square(world, first, turned, kind)
  local cubes, welds = {}, {}
  for i, c in ipairs { { -1, -1 }, { 1, -1 }, { 1, 1 }, { -1, 1 } } do
    cubes[i] = world:box { size = 0.2, mass = 1, at = first + turned * digbox.vec(0.1 * c[1], 0.1 * c[2], 0), rotation = turned }
    if i > 1 then
      local at = (cubes[i].position + cubes[i - 1].position) * 0.5
      local def = { a = cubes[i], b = cubes[i - 1], at = at, breaks_at = kind == "bolt" and 1e5 or nil }
      welds[#welds + 1] = world[kind or "weld"](world, def)
    end
  end
  return cubes, welds
end

local function flower(world, kind)
  local bodies = { world:cylinder { radius = 0.1, height = 0.3, mass = 1 } }
  for i = 1, 6 do
    local angle = i * math.pi / 3
    bodies[#bodies + 1] = world:cylinder { radius = 0.1, height = 0.3, mass = 1, at = { 0.2 * math.cos(angle), 0, 0.2 * math.sin(angle) } }
    world[kind](world, { a = bodies[#bodies], b = bodies[1], breaks_at = kind == "bolt" and 1e5 or nil })
  end
  return bodies
end

for _, accuracy in ipairs { "sketch", "play", "study" } do
  scenario("weld, bolt: parts of one thing that touch exactly tumble as that thing does, at " .. accuracy, function(s)
    local function four(world, kind) return square(world, digbox.vec(0, 0, 0), digbox.quat { 0, 0, 0, 1 }, kind) end
    for _, build in ipairs { four, flower } do
      for _, kind in ipairs { "weld", "bolt" } do
        local world = s:world { gravity = { 0, 0, 0 }, accuracy = accuracy }
        local spin = digbox.vec(3, 7, 2)
        local bodies = build(world, kind)
        for _, b in ipairs(bodies) do b:teleport { spin = spin, velocity = spin:cross(b.position) } end
        local before, energy = world.angular_momentum, world.energy.total
        world:run "2 s"
        expect(#(world.angular_momentum - before) / #before):below(1e-9)
        expect(world.energy.total / energy):near(1, 1e-6)
        expect(world:stats().contacts):is(0)
      end
    end
  end)
end

-- A feather beside them, and they touch each other as what lies there does.
for _, accuracy in ipairs { "sketch", "play", "study" } do
  scenario("bolt: parts of one thing tumble as that thing does near another, at " .. accuracy, function(s)
    for kind, spin in pairs { bricks = digbox.vec(3, 7, 2), square = digbox.vec(0, 0, 3) } do
      local world = s:world { gravity = { 0, 0, 0 }, accuracy = accuracy }
      local bodies, broken = {}, 0
      world:on("broken", function() broken = broken + 1 end)
      if kind == "square" then
        bodies = square(world, digbox.vec(0, 0, 0), digbox.quat { 0, 0, 0, 1 }, "bolt")
      else
        for i, at in ipairs { { -0.2, -0.2, 0 }, { 0.2, -0.2, 0 }, { 0, 0, 0 }, { -0.2, 0.2, 0 }, { 0.2, 0.2, 0 } } do
          bodies[i] = world:box { size = { 0.4, 0.2, 0.2 }, mass = 1, at = at }
          if i > 1 then world:bolt { a = bodies[i], b = bodies[i - 1], breaks_at = 1e5 } end
        end
      end
      for _, b in ipairs(bodies) do b:teleport { spin = spin, velocity = spin:cross(b.position) } end
      world:ball { radius = 0.01, mass = 1e-6, at = { 0, 0, 0.115 } }
      local before, energy = world.angular_momentum, world.energy.total
      world:run "1 s"
      expect(#(world.angular_momentum - before) / #before):below(1e-9)
      expect(world.energy.total / energy):near(1, 1e-2)
      expect(broken):is(0)
    end
  end)
end

scenario("bolt: parts of one thing touch each other where something is near", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  world:floor {}
  local cubes = square(world, digbox.vec(0, 0.2, 0), digbox.quat { 0, 0, 0, 1 }, "bolt")
  world:run "0.5 s"
  expect(cubes[4]:touches(cubes[1])):is(true)
  for _, c in ipairs(cubes) do c:teleport { at = c.position + digbox.vec(0, 1, 0) } end
  world:run "0.2 s"
  expect(cubes[4]:touches(cubes[1])):is(false)
  world:run "1.5 s"                                -- and again when it has fallen
  expect(cubes[4]:touches(cubes[1])):is(true)
end)

scenario("weld: a block of cubes tips off an edge as fast as one body of these parts", function(s)
  local when = {}
  for _, kind in ipairs { "one body", "welded" } do
    local world = s:world { gravity = { 0, -g, 0 } }
    world:floor {}
    local turned = digbox.quat { angle = math.rad(40), axis = { 0, 0, 1 } }
    local centre = turned * digbox.vec(0.2, 0.2, 0) + digbox.vec(0, 1e-4, 0)
    local first
    if kind == "one body" then
      local parts = {}
      for i, c in ipairs { { -1, -1 }, { 1, -1 }, { 1, 1 }, { -1, 1 } } do
        parts[i] = digbox.box { size = 0.2, at = { 0.1 * c[1], 0.1 * c[2], 0 } }
      end
      first = world:body { mass = 4, parts = parts, at = centre, rotation = turned }
    else
      first = square(world, centre, turned)[1]
    end
    while world.time < 2 and (first.rotation * digbox.vec(0, 1, 0)).y < 0.9999 do world:step() end
    when[#when + 1] = world.time
  end
  expect(when[1]):near(0.567, 0.01)
  expect(when[2]):near(when[1], 0.02)
end)

scenario("bolt: a block of eight cubes tips off an edge as fast as one body of these parts", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  world:floor {}
  local turned = digbox.quat { angle = math.rad(40), axis = { 0, 0, 1 } }
  local centre = turned * digbox.vec(0.2, 0.2, 0) + digbox.vec(0, 1e-4, 0)
  local last, first
  for i = 0, 7 do
    local at = digbox.vec((i // 4 - 0.5) * 0.2, (i // 2 % 2 - 0.5) * 0.2, (i % 2 - 0.5) * 0.2)
    local cube = world:box { size = 0.2, mass = 1, at = turned * at + centre, rotation = turned }
    if last then world:bolt { a = cube, b = last, at = (cube.position + last.position) * 0.5, breaks_at = 1e5 } end
    last, first = cube, first or cube
  end
  while world.time < 2 and (first.rotation * digbox.vec(0, 1, 0)).y < 0.9999 do world:step() end
  expect(world.time):near(0.567, 0.02)
end)

scenario("weld: what a chain of welds made one thing touches again once it is two", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  world:floor {}
  local cubes, welds = square(world, digbox.vec(0, 0.2, 0), digbox.quat { 0, 0, 0, 1 })
  world:run "0.2 s"
  expect(world:stats().contacts):is(2)             -- with the floor
  welds[3]:remove()                                -- the upper left one lies on the lower left one now
  world:run "0.5 s"
  expect(cubes[4].position):near({ -0.1, 0.3, 0 }, 1e-6)
  expect(cubes[4]:touches(cubes[1])):is(true)
  cubes[4]:hit { impulse = { 0, 0, -1 } }
  world:run "0.1 s"
  expect(cubes[4].position.z):below(-0.05)
end)

-- What of the corner's middle cube was left was the normal along its edge, 0.2 m deep: the fourth cube was pushed out along it.
scenario("weld: a cube lies in the inner corner of three", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  world:floor {}
  local cubes, welds = square(world, digbox.vec(0, 0.2, 0), digbox.quat { 0, 0, 0, 1 })
  welds[3]:remove()
  world:run "1 s"
  for i, c in ipairs { { -1, -1 }, { 1, -1 }, { 1, 1 }, { -1, 1 } } do
    expect(cubes[i].position):near({ 0.1 * c[1], 0.2 + 0.1 * c[2], 0 }, 1e-9)
  end
  expect(world:stats().worst_penetration):below(1e-9)
end)

scenario("weld: a touch that was there before the chain of welds is over with it", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  world:floor {}
  local cubes = {}
  for i, c in ipairs { { -1, -1 }, { 1, -1 }, { 1, 1 }, { -1, 1 } } do
    cubes[i] = world:box { size = 0.2, mass = 1, at = { 0.1 * c[1], 0.2 + 0.1 * c[2], 0 } }
  end
  world:run "0.2 s"
  local ended = 0
  cubes[4]:on("contact_end", function(event) if event.other == cubes[1] then ended = ended + 1 end end)
  for i = 2, 4 do world:weld { a = cubes[i], b = cubes[i - 1] } end
  world:run "0.2 s"
  expect(ended):is(1)
  expect(world:stats().contacts):is(2)
  expect(cubes[4].dig == cubes[1].dig):is(true)
end)

scenario("distance: two bodies whirl about each other with the tension m omega^2 r", function(s)
  local world = s:world(none)
  local omega = 3
  local a = world:ball { radius = 0.05, mass = 2, at = { 0.5, 0, 0 }, velocity = { 0, 0, -0.5 * omega } }
  local b = world:ball { radius = 0.05, mass = 2, at = { -0.5, 0, 0 }, velocity = { 0, 0, 0.5 * omega } }
  local rod = world:distance { a = a, b = b }
  world:run(2 * math.pi / omega)
  expect(rod.distance):near(1, 1e-4)
  expect(#rod.force):near(2 * omega ^ 2 * 0.5, 0.02)
  expect(a.speed):near(0.5 * omega, 1e-3)
end)

scenario("distance: between min and max it is free, at either it holds", function(s)
  local world = s:world(none)
  local post = world:box { size = 0.1, fixed = true, at = { 0, 0, 0 } }
  local a = world:ball { radius = 0.05, mass = 1, at = { 1, 0, 0 }, velocity = { 1, 0, 0 } }
  local joint = world:distance { a = a, b = post, min = 0.5, max = 1.25 }
  world:run "0.2 s"
  expect(a.velocity):near({ 1, 0, 0 }, 1e-9)
  world:run "1 s"
  expect(joint.distance):near(1.25, 1e-3)
  expect(joint.at_limit):is(true)
end)

scenario("rope: slack it does nothing, taut it bears the weight", function(s)
  local world = s.world
  local ball = world:ball { radius = 0.05, mass = 1.5, at = { 0, 0, 0 } }
  local rope = world:rope { a = ball, at = { 0, 0.5, 0 }, length = 1.5 }
  world:run "0.4 s"
  expect(ball.velocity):near({ 0, -g * 0.4, 0 }, 1e-9)  -- falls free
  expect(#rope.force):near(0, 1e-9)
  s:settle "3 s"
  expect(rope.distance):near(1.5, 1e-3)
  expect(rope.force.y):near(1.5 * g, 0.02)
end)

scenario("rope: a pendulum on it keeps its energy", function(s)
  local world = s.world
  local ball = world:ball { radius = 0.05, mass = 1, at = { 1, 2, 0 } }
  local rope = world:rope { a = ball, to = { 0, 2, 0 } }
  for _ = 1, 300 do
    world:step()
    expect(rope.distance):near(1, 1e-8)
  end
  expect(world.energy.lost):near(0, 1e-9)
  expect(world.energy.numerical):near(0, 1e-5)          -- of 9.8 J that swing
  expect(world:stats().gave_up):is(0)
end)

-- Falls 0.8 m beside its pivot, 0.6 m from it, until a rope of 1 m is taut: that takes the part of the speed along it.
scenario("rope, and distance with a max: what is whirled at 20 rad/s keeps its energy at sketch, too", function(s)
  local world = s:world { gravity = { 0, 0, 0 }, accuracy = "sketch" }
  for i, type in ipairs { "rope", "distance" } do
    local ball = world:ball { radius = 0.1, mass = 1, at = { 10 * i + 1, 0, 0 }, velocity = { 0, 0, 20 } }
    world[type](world, { a = ball, at_b = { 10 * i, 0, 0 }, [type == "rope" and "length" or "max"] = 1 })
  end
  local box = world:box { size = { 0.4, 0.1, 0.1 }, mass = 1, at = { 1.2, 0, 0 }, velocity = { 0, 0, 24 }, spin = { 0, -20, 0 } }
  world:rope { a = box, at = { 1, 0, 0 }, to = { 0, 0, 0 } }
  local before = world.energy.total
  world:run "3 s"
  expect(world.energy.total):near(before, 1e-4 * before)
end)

scenario("rope: a jerk takes the speed along it, and no more", function(s)
  local world = s.world
  local ball = world:ball { radius = 0.05, mass = 1, at = { 0.6, 0, 0 } }
  local rope = world:rope { a = ball, to = { 0, 0, 0 }, length = 1 }
  world:run "0.45 s"                                     -- taut at 0.404 s
  expect(rope.at_limit):is(true)
  expect(world.energy.lost):near(g * 0.8 * 0.8 ^ 2, 1e-9)
  world:run "2 s"
  expect(world.energy.numerical):near(0, 1e-6)
  expect(world:stats().gave_up):is(0)
end)

scenario("rope: a mover that draws it taut lifts a box with one jerk", function(s)
  local world = s.world
  world:floor {}
  local box = world:box { size = { 0.2, 0.2, 0.2 }, mass = 1, at = { 0, 0.1, 0 } }
  local hook = world:box { kinematic = true, size = { 0.1, 0.1, 0.1 }, at = { 0, 1, 0 } }
  world:rope { a = box, b = hook, at_a = { 0, 0.2, 0 }, at_b = { 0, 0.95, 0 }, length = 1 }
  hook:drive { velocity = { 0, 0.3, 0 } }
  world:run "2 s"
  expect(box.position.y):near(0.1 + 0.3 * (2 - 0.25 / 0.3), 1e-9)
  expect(world.energy.lost):near(0.5 * 0.3 ^ 2, 1e-9)
  expect(world.energy.work_in):near(0.3 ^ 2 + g * (box.position.y - 0.1), 1e-9)
end)

scenario("rope: two balls on two of them, one below the other", function(s)
  local world = s.world
  local upper = world:ball { radius = 0.05, mass = 1, at = { 0.7, 0, 0 } }
  local lower = world:ball { radius = 0.05, mass = 1, at = { 1.4, 0, 0 } }
  world:rope { a = upper, to = { 0, 0, 0 } }
  world:rope { a = upper, b = lower }
  world:run "5 s"                                        -- they jerk, too
  expect(world.energy.numerical):near(0, 1e-4)          -- of 14 J
  expect(world:stats().gave_up):is(0)
end)

scenario("hinge and slider: what runs into a stop loses its speed there, and rests on it", function(s)
  local world = s.world
  local bar = world:box { mass = 2, size = { 1, 0.05, 0.05 }, at = { 0.5, 0, 0 } }
  world:hinge { a = bar, at = { 0, 0, 0 }, axis = { 0, 0, 1 }, limits = { "-60 deg", "45 deg" } }
  local block = world:box { mass = 3, size = { 0.2, 0.2, 0.2 }, at = { 0, 0, 3 } }
  world:slider { a = block, at = { 0, 0, 3 }, axis = { 0, 1, 0 }, limits = { -0.7, 0.1 } }
  world:run "2 s"
  expect(bar.position):near({ 0.5 * math.cos(math.pi / 3), -0.5 * math.sin(math.pi / 3), 0 }, 1e-9)
  expect(block.position.y):near(-0.7, 1e-9)
  expect(world.energy.lost):near(2 * g * 0.5 * math.sin(math.pi / 3) + 3 * g * 0.7, 1e-8)
  expect(world.energy.numerical):near(0, 1e-9)
  expect(world:stats().gave_up):is(0)
end)

-- A ball on a spring that turns its phase by so much in a frame; its swing of 1e-7 m lies far below the tolerance of "play".
scenario("spring: a swing that no tolerance shows gains no energy, however fast it is", function(s)
  for _, phase in ipairs { 0.5, 1.1, 2, 3, 4, 5, 5.9, 6.1, 20 } do
    local step, swing = 1 / 60, 1e-7
    local k = (phase / step) ^ 2
    local world = s:world { gravity = { 0, 0, 0 }, sleeping = false, step = step }
    local ball = world:ball { radius = 0.1, mass = 1, at = { 0, -1, 0 }, velocity = { 0, swing * phase / step, 0 } }
    world:spring { a = ball, at_b = { 0, 0, 0 }, length = 1, stiffness = k }
    local start, most = world.energy.kinetic, 0
    for _ = 1, 600 do
      world:step()
      most = math.max(most, world.energy.kinetic + k * (ball.position.y + 1) ^ 2 / 2)
    end
    expect(most / start):near(1, 1e-3)
  end
end)

scenario("spring: in series with a mass it swings with 2 pi sqrt(m / k)", function(s)
  local world = s:world(none)
  local k, m, M = 50, 1, 3                              -- two free masses: the reduced mass counts
  local a = world:ball { radius = 0.05, mass = m, at = { 0, 0, 0 } }
  local b = world:ball { radius = 0.05, mass = M, at = { 1, 0, 0 }, velocity = { 0, 0, 0 } }
  local spring = world:spring { a = a, b = b, stiffness = k, length = 0.9 }
  local t = crossings(world, 4, function() return spring.distance - 0.9 end)
  local T = 2 * math.pi * math.sqrt(m * M / (m + M) / k)
  expect((t[4] - t[1]) / 3):near(T, 1e-3 * T)
  expect(world.energy.total):near(k * 0.1 ^ 2 / 2, 1e-3)
  expect(#world.momentum):near(0, 1e-12)
end)

scenario("wheel: with a damped spring at its stop it falls at sketch as far as anything", function(s)
  local world = s:world { accuracy = "sketch" }
  local hull = world:box { size = { 2, 0.5, 1 }, mass = 600, at = { 0, 7, 0 } }
  local tyre = world:box { size = 0.3, mass = 60, at = { 0, 6.4, 0 } }
  world:wheel { a = tyre, b = hull, axis = { 0, 1, 0 }, spin_axis = { 0, 0, 1 }, limits = { -0.1, 0.1 },
    spring = { stiffness = 30000, rest = -0.2, damping = 3000 } }
  local function height() return (600 * hull.centre.y + 60 * tyre.centre.y) / 660 end
  local top = height()
  world:run "0.8 s"
  expect(top - height()):near(g * 0.8 ^ 2 / 2, 1e-9)
  expect(world.energy.numerical):near(0, 1e-3)
end)

scenario("gear: torque goes up as speed goes down", function(s)
  local world = s:world(none)
  local small = world:cylinder { radius = 0.1, height = 0.1, mass = 2, at = { 0, 0, 0 } }       -- I = 0.01
  local large = world:cylinder { radius = 0.4, height = 0.1, mass = 5, at = { 1, 0, 0 } }       -- I = 0.4
  local h1 = world:hinge { a = small, at = { 0, 0, 0 }, axis = { 0, 1, 0 } }
  local h2 = world:hinge { a = large, at = { 1, 0, 0 }, axis = { 0, 1, 0 } }
  world:gear { a = h1, b = h2, ratio = { 1, 4 } }       -- speed of a * 1 = speed of b * 4
  small:twist { torque = { 0, 0.7, 0 }, lasts = "1 s" }
  world:run "1 s"
  expect(h1.speed):near(0.7 / (0.01 + 0.4 / 16), 0.01)  -- the large wheel weighs 1 / 4^2 of its inertia
  expect(h1.speed / h2.speed):near(4, 1e-6)
end)

scenario("rack: a pinion drives it by its radius", function(s)
  local world = s:world(none)
  local pinion = world:cylinder { radius = 0.1, height = 0.1, mass = 2, at = { 0, 0, 0 } }      -- I = 0.01
  local bar = world:box { size = { 1, 0.1, 0.1 }, mass = 3, at = { 0, 0, 1 } }
  local hinge = world:hinge { a = pinion, at = { 0, 0, 0 }, axis = { 0, 1, 0 } }
  local slider = world:slider { a = bar, along = { 1, 0, 0 } }
  world:rack { a = hinge, b = slider, ratio = 0.1 }
  pinion:twist { torque = { 0, 0.4, 0 }, lasts = "1 s" }
  world:run "1 s"
  local omega = 0.4 / (0.01 + 3 * 0.1 ^ 2)
  expect(hinge.speed):near(omega, 0.01)
  expect(slider.speed):near(omega * 0.1, 1e-3)
  expect(math.abs(slider.distance / hinge.angle)):near(0.1, 1e-4)
end)

scenario("wheel: its spring sinks by m g / k, its motor spins it", function(s)
  local world = s.world
  local body = world:box { size = { 1, 0.2, 0.5 }, mass = 10, at = { 0, 1, 0 }, fixed = true }
  local tyre = world:cylinder { radius = 0.2, height = 0.1, mass = 4, at = { 0, 0.5, 0 },       -- I = 0.08 about its axis
                                rotation = digbox.quat { axis = { 1, 0, 0 }, angle = "90 deg" } }
  local wheel = world:wheel { a = tyre, b = body, axis = { 0, 1, 0 }, spin_axis = { 0, 0, 1 },
                              spring = { stiffness = 400, damping = 40 }, motor = { speed = 50, max_torque = 0.4 } }
  world:run "4 s"
  expect(tyre.position.y):near(0.5 - 4 * g / 400, 1e-3)
  expect(math.abs(wheel.speed)):near(0.4 / 0.08 * 4, 0.05)
  expect(math.abs(tyre.spin.z)):near(0.4 / 0.08 * 4, 0.05)
  expect(tyre.position.x):near(0, 1e-4)
end)

scenario("bolt: it holds up to its strength and breaks above it", function(s)
  local world = s.world
  local function hung(mass, x)
    local box = world:box { size = 0.2, mass = mass, at = { x, 0, 0 } }
    return box, world:bolt { holds = box, strength = "50 N" }
  end
  local light, holds = hung(5, 0)                       -- 49.05 N
  local heavy, breaks = hung(5.2, 1)                    -- 51.01 N
  world:run "1 s"
  expect(holds.valid):is(true)
  expect(light.position.y):near(0, 1e-6)
  expect(breaks.valid):is(false)
  expect(heavy.position.y):below(-4)
end)

scenario("motor: it spins a against b, and b takes the reaction", function(s)
  local world = s:world(none)
  local a = world:cylinder { radius = 0.2, height = 0.1, mass = 5, at = { 0, 0, 0 } }           -- I = 0.1
  local b = world:cylinder { radius = 0.2, height = 0.1, mass = 15, at = { 0, 1, 0 } }          -- I = 0.3
  local motor = world:motor { a = a, b = b, axis = { 0, 1, 0 }, speed = 8, max_torque = 100 }
  world:run "0.5 s"
  expect(motor.speed):near(8, 1e-6)
  expect(a.spin.y):near(6, 1e-6)                        -- 0.1 * 6 = 0.3 * 2
  expect(b.spin.y):near(-2, 1e-6)
  expect(#world.angular_momentum):near(0, 1e-9)
end)

scenario("a motor without a bound is at its speed after a step, and stays there whatever turns against it", function(s)
  for _, kind in ipairs { "motor", "hinge" } do
    local world = s:world(none)
    local wheel = world:cylinder { radius = 0.2, height = 0.1, mass = 5, at = { 0, 0, 0 } }     -- I = 0.1
    local motor = kind == "motor" and world:motor { a = wheel, axis = { 0, 1, 0 }, speed = 6 }
      or world[kind](world, { a = wheel, axis = { 0, 1, 0 }, motor = { speed = 6 } })
    world:step()
    expect(wheel.spin.y):near(6, 1e-9)
    expect(world.energy.work_in):near(0.5 * 0.1 * 36, 1e-9)
    wheel:twist { torque = { 0, -50, 0 }, lasts = 0.1 }
    world:run "0.3 s"
    expect(wheel.spin.y):near(6, 1e-9)
    expect(motor.angle):near(6 * world.time, 0.11)              -- the first step brings it to its speed
  end
end)

-- One wheel lands after the other, and slips: rolling resistance with a bound from predicted forces, which may be negative, would drive it.
scenario("hinges and a guide: a wagon of 20 t that lands on slipping wheels gets no faster", function(s)
  for n = 1, 14 do
    local world = s:world { accuracy = "sketch" }           -- swept, not traced
    world:plane { normal = { 0, 1, 0 }, material = "wood" }
    local r, angle, speed = 0.4, 0.005 * (n % 7), 4
    local y, tilt = r + 2 * math.sin(angle) + 0.002 * n, digbox.quat { axis = { 0, 0, 1 }, angle = angle }
    local wagon = world:box { material = "steel", mass = 20000, size = { 6.4, 1.2, 1.6 }, at = { 0, y + 0.7, 0 }, rotation = tilt,
                              velocity = { speed, -0.5, 0 } }
    world:guide { a = wagon, axis = { 0, 0, 1 }, keeps = "flat" }
    for _, dx in ipairs { 2, -2 } do
      local wheel = world:cylinder { material = "iron", mass = 200, radius = r, height = 1.7,
        at = { dx * math.cos(angle), y + dx * math.sin(angle), 0 }, rotation = digbox.quat { axis = { 1, 0, 0 }, angle = "90 deg" },
        velocity = { speed, -0.5, 0 }, spin = { 0, 0, -speed / r + 0.1 * (n % 5 - 2) } }
      world:hinge { a = wheel, b = wagon, at = wheel.position, axis = { 0, 0, 1 } }
    end
    world:run "0.6 s"
    local e = world.energy
    expect(wagon.velocity.x):near(speed, 0.05 * speed)
    expect(e.lost):at_least(0)
    expect(math.abs(e.numerical)):below(1e-3 * e.initial)
  end
end)

-- A limb of length r that turns by a in a substep opens its hinge by r a^2 / 2: 0.7 mm here, if nobody closed it before the frame ends.
scenario("hinge: limbs that whirl over the floor are not seen apart", function(s)
  local world = s:world {}
  world:floor { friction = 0.5 }
  local last
  local hinges = {}
  for i = 1, 8 do
    local whirls = i == 8                               -- about its hinge
    local link = world:box { size = { 0.24, 0.06, 0.06 }, at = { 0.25 * i, 0.03, 0 }, mass = 1, friction = 0.5, group = -1,
                             spin = { 0, whirls and 40 or 0, 0 }, velocity = { 0, 0, whirls and -5 or 0 } }
    if last then
      hinges[#hinges + 1] = world:hinge { a = link, b = last, at = { 0.25 * i - 0.125, 0.03, 0 }, axis = { 0, 1, 0 } }
    end
    last = link
  end
  local worst = 0
  for _ = 1, 30 do
    world:step()
    for _, h in ipairs(hinges) do worst = math.max(worst, h.error) end
  end
  expect(worst):below(2.5e-4)
end)

scenario("a joint that begins beyond its stop is led back to it, with nothing that moves it", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local turned = world:hinge { a = world:box { size = 0.2, at = { 0, 0, 0 } }, at = { 0, 0, 0 }, axis = { 0, 0, 1 }, limits = { 1, 2 } }
  local slid = world:slider { a = world:box { size = 0.2, at = { 3, 0, 0 } }, at = { 3, 0, 0 }, axis = { 0, 0, 1 }, limits = { 0.5, 1 } }
  world:run "0.5 s"
  expect(turned.angle):near(1, 1e-3)
  expect(slid.distance):near(0.5, 1e-3)
  turned:set { limits = { -2, 0.4 } }
  world:run "0.5 s"
  expect(turned.angle):near(0.4, 1e-3)
  expect(turned.a.speed):below(1e-6)
end)

scenario("boxes fall on a train of gears, and it runs on", function(s)
  local world = s.world
  world:floor {}
  local hinges = {}
  for i = 1, 3 do
    local wheel = world:cylinder { name = "wheel " .. i, radius = 0.2, height = 0.1, at = { 0.41 * i, 0.6, 0 },
      rotation = { axis = { 1, 0, 0 }, angle = "90 deg" } }
    hinges[i] = world:hinge { a = wheel, at = wheel.position, axis = { 0, 0, 1 } }
    if i > 1 then world:gear { a = hinges[i - 1], b = hinges[i], ratio = { 1, -1 } } end
  end
  for i = 1, 30 do world:box { size = 0.1, mass = 1, at = { 0.2 * i, 1 + 0.05 * i, 0 } } end
  world:run "2 s"
  for i = 2, 3 do expect(hinges[i].angle):near((-1) ^ (i - 1) * hinges[1].angle, 1e-3) end
  s:expect_reliable()
end)

-- Springs that are gentle for the step are swept, stiff ones are solved with the contacts at once: both bear what touches.
for _, stiffness in ipairs { 1000, 1e6 } do
  scenario(("a box lies on a plate that hangs on eight springs of %g N/m"):format(stiffness), function(s)
    local world = s:world { gravity = { 0, -g, 0 } }
    local plate = world:box { size = { 1, 0.1, 1 }, at = { 0, 1, 0 }, mass = 10, friction = 0.5 }
    world:box { size = 0.2, at = { 0, 1.15, 0 }, mass = 1, friction = 0.5 }
    for i = 0, 7 do
      local x, z = 0.4 * math.cos(math.pi / 4 * i), 0.4 * math.sin(math.pi / 4 * i)
      world:spring { a = plate, at_a = { x, 1, z }, at_b = { x, 3, z }, stiffness = stiffness, damping = 0.05 * stiffness, length = 2 }
    end
    world:run "4 s"
    local sag = 11 * g / (8 * stiffness)
    expect(1 - plate.position.y):near(sag, 1e-3 * sag)
    expect(plate.rotation.angle):below(1e-6)
    s:expect_reliable()
  end)
end
