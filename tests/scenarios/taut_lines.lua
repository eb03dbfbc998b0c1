-- Light things that are taut between heavy or fixed ones: ropes of cranes, straight bridges, nets.
-- Only in the plain build: figures of long runs; test_direct.c and soft_planks.lua run the same code under sanitizers.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local g = 9.81

-- ---- a crane whose slewing hinge is driven: what is 2800 times as heavy as what carries it ----

scenario("a wrecking ball of 1.4 t hangs on a rope of 6 kg from a jib with a motor", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  world:floor {}
  local mast = world:box { fixed = true, size = { 0.3, 6, 0.3 }, at = { -3, 3, 0 } }
  local jib = world:box { size = { 4, 0.2, 0.2 }, at = { -1.2, 6.1, 0 }, mass = 200 }
  local slew = world:hinge { a = jib, b = mast, at = { -3, 6.1, 0 }, axis = { 0, 1, 0 }, motor = { speed = 0, max_torque = 5000 } }
  local ball = world:ball { radius = 0.35, material = "steel", at = { 0.7, 1.7, -3 } }
  local rope = world:rope { a = jib, b = ball, at = { 0.7, 6, 0 }, to = { 0.7, 2, -2.9 }, segments = 12, mass = 6, radius = 0.02 }
  local top, apart, worst = world.energy.total, 0, 0
  for _ = 1, 180 do
    world:step()
    worst = math.max(worst, math.abs(rope.error))
    apart = math.max(apart, slew.error)
  end
  expect(worst):below "5 mm"
  expect(apart):below "1 mm"
  expect(ball.speed):below(6)
  expect(world.energy.total):below(top)
  s:expect_reliable()
end)

-- The ball pulls the jib round under it; the rope goes slack, and taut again with a jerk.
for _, slewing in ipairs { { friction = 100 }, { motor = { speed = 0.5, max_torque = 2e4 } } } do
  scenario("a wrecking ball of 10 t jerks at a rope of 6 kg from a jib with a " .. (slewing.motor and "motor" or "stiff hinge"), function(s)
    local world = s:world { gravity = { 0, -g, 0 } }
    local jib = world:box { size = { 4, 0.2, 0.2 }, at = { -1.2, 6.1, 0 }, mass = 200 }
    world:hinge { a = jib, at = { -3, 6.1, 0 }, axis = { 0, 1, 0 }, friction = slewing.friction, motor = slewing.motor }
    local ball = world:ball { radius = 0.35, mass = 10000, at = { 0.7, 1.7, -3 } }
    local rope = world:rope { a = jib, b = ball, at = { 0.7, 6, 0 }, to = { 0.7, 2, -2.9 }, segments = 12, mass = 6, radius = 0.02 }
    local apart, off = 0, 0
    for _ = 1, 120 do
      world:step()
      apart, off = math.max(apart, rope.error), math.max(off, math.abs(world.energy.numerical))
    end
    expect(apart):below "5 mm"
    expect(off):below(0.01 * 10000 * g * 4)
    s:expect_reliable()
  end)
end

-- Straight from pier to pier: what opens a joint by a little lets the planks sag by far more, and what closes it would lift them so far.
for _, load in ipairs { { mass = 20, apart = "0.01 mm", off = 5 }, { mass = 200, apart = "0.01 mm", off = 10 } } do
  scenario(("a box of %g kg lands on twenty planks without slack, and lies there"):format(load.mass), function(s)
    local world = s:world { gravity = { 0, -g, 0 } }
    local function pier(x) return world:box { fixed = true, size = { 1, 4, 2 }, at = { x, 2, 0 } } end
    local joints, last = {}, pier(-0.5)
    local function hold(plank, x)
      for _, z in ipairs { -0.7, 0.7 } do joints[#joints + 1] = world:ball_joint { a = last, b = plank, at = { x, 4, z } } end
      last = plank
    end
    for i = 1, 20 do hold(world:box { size = { 0.48, 0.06, 1.6 }, at = { (i - 0.5) / 2, 4, 0 }, mass = 8 }, (i - 1) / 2) end
    hold(pier(10.5), 10)
    local box = world:box { size = { 1.5, 0.6, 1.2 }, mass = load.mass, at = { 2, 4.5, 0 }, friction = 0.5 }
    local apart, off = 0, 0
    for _ = 1, 180 do
      world:step()
      for _, j in ipairs(joints) do apart = math.max(apart, j.error) end
      off = math.max(off, math.abs(world.energy.numerical))
    end
    expect(apart):below(load.apart)
    expect(off):below(load.off)
    expect(box.speed):below "0.2 m/s"
    s:expect_reliable()
  end)
end

-- With slack between ends one above the other it hangs aside, in rods of one length; drawn taut it bears 10,000 times a rod.
scenario("a hoist draws a slack rope of rods of 200 g taut and lifts 2 t", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  world:floor {}
  local hook = world:box { size = 0.3, kinematic = true, at = { 0, 5, 0 }, velocity = { 0, 0.5, 0 } }
  local load = world:box { size = 1, mass = 2000, at = { 0, 0.5, 0 } }
  local rope = world:rope { a = hook, b = load, at = { 0, 4.85, 0 }, to = { 0, 1, 0 }, segments = 20, length = 4.2, mass = 4,
                            radius = 0.02 }
  for i = 2, 10 do expect((rope.bodies[i].at - rope.bodies[i - 1].at):length()):near(0.21, 1e-9) end
  local apart = 0
  for _ = 1, 180 do
    world:step()
    apart = math.max(apart, rope.error)
  end
  expect(apart):below "5 mm"
  expect(load.at.y):near(0.5 + 0.5 * 3 - 0.35, 0.02)
  expect(world.energy.numerical):near(0, 100)         -- of 20 kJ that it weighs in a metre
  s:expect_reliable()
end)

-- ---- nets: light nodes between taut ropes, and what falls into them ----

-- Nine by nine nodes of 50 g, those of the rim fixed. Without slack a ball stays where it lands, else where ropes are at their length.
local function net(s, joint, slack)
  local world, n, a, node, joints = s:world { gravity = { 0, -g, 0 } }, 9, 0.4, {}, {}
  local function rim(i) return i == 1 or i == n end
  for i = 1, n do
    node[i] = {}
    for k = 1, n do
      node[i][k] = world:ball { radius = 0.03, mass = 0.05, fixed = rim(i) or rim(k), at = { (i - 5) * a, 3, (k - 5) * a } }
    end
  end
  local function tie(i, k, i2, k2)
    joints[#joints + 1] = world[joint](world, { a = node[i][k], b = node[i2][k2], length = a * (1 + slack) })
  end
  for i = 1, n do
    for k = 1, n do
      if i < n and not rim(k) then tie(i, k, i + 1, k) end
      if k < n and not rim(i) then tie(i, k, i, k + 1) end
    end
  end
  return world, joints
end

for _, way in ipairs { { "distance", 0, 200 }, { "distance", 0, 2000 }, { "rope", 0, 20 }, { "rope", 0.05, 20 }, { "rope", 0.05, 2000 } } do
  local joint, slack, mass = table.unpack(way)
  scenario(("a net of nodes of 50 g, tied by %s joints with %g %% slack, catches %g kg"):format(joint, 100 * slack, mass), function(s)
    local world, joints = net(s, joint, slack)
    local ball = world:ball { radius = 0.5, mass = mass, at = { 0.1, 5, 0.07 } }
    local fell, longest = 0, 0
    for _ = 1, 180 do
      world:step()
      fell = math.max(fell, 5 - ball.at.y)
      for _, j in ipairs(joints) do longest = math.max(longest, j.distance - 0.4 * (1 + slack)) end
    end
    local work = mass * g * fell
    expect(longest):below(0.025)
    expect(ball.at.y):near(slack > 0 and 2.97 or 3.45, 0.03)
    expect(ball.speed):below "0.3 m/s"
    expect(world.energy.numerical):near(0, 0.01 * work)
    expect(world.energy.lost):near(mass * g * (5 - ball.at.y), 0.02 * work)
  end)
end

-- ---- a mobile: bars that are light for what they carry, and flip when a blow takes the load off one end ----

scenario("a mobile of bars of 100 g and more carries 32 balls of 30 kg", function(s)
  local world, ropes = s:world { gravity = { 0, -g, 0 } }, {}
  local function tie(above, below, from, to)
    ropes[#ropes + 1] = world:rope { a = above, b = below, at_a = from, at_b = to }
  end
  local function hang(at, above, level)
    local x, y = at[1], at[2]
    if level == 0 then
      tie(above, world:ball { radius = 0.08, mass = 30, at = { x, y - 0.3, 0 } }, at, { x, y - 0.22, 0 })
      return
    end
    local half = 0.22 * 2.1 ^ (level - 1)
    local bar = world:box { size = { 2 * half, 0.03, 0.03 }, mass = 0.1 * level, at = { x, y - 0.4, 0 } }
    tie(above, bar, at, { x, y - 0.385, 0 })
    hang({ x - half, y - 0.4, 0 }, bar, level - 1)
    hang({ x + half * 0.98, y - 0.4, 0 }, bar, level - 1)
  end
  hang({ 0, 4.9, 0 }, world:box { fixed = true, size = 0.2, at = { 0, 5, 0 } }, 5)
  local length, longest, off = {}, 0, 0
  for i, rope in ipairs(ropes) do length[i] = rope.distance end
  for _ = 1, 360 do
    world:step()
    for i, rope in ipairs(ropes) do longest = math.max(longest, rope.distance - length[i]) end
    off = math.max(off, math.abs(world.energy.numerical))
  end
  expect(longest):below "3 cm"
  expect(off):below(250)                  -- of 25 kJ
  s:expect_reliable()
end)

-- ---- a tank: two closed chains of plates between heavy wheels and the floor ----

scenario("a tank of 300 kg drives on two tracks of 36 plates", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  world:floor { friction = 0.9 }
  local hull = world:box { size = { 2.4, 0.4, 0.8 }, mass = 300, at = { 0, 0.9, 0 } }
  local half, radius, count, joints = 1, 0.35, 36, {}
  local outer = radius + 0.03
  local straight, bow = 2 * half, math.pi * outer
  local length = 2 * (straight + bow)
  local function at(way)
    way = way % length
    local back = way >= length / 2
    if back then way = way - length / 2 end
    local x, y = way - half, -outer
    if way > straight then
      local angle = (way - straight) / outer - math.pi / 2
      x, y = half + outer * math.cos(angle), outer * math.sin(angle)
    end
    return back and -x or x, 0.5 + (back and -y or y)
  end
  local function track(z)
    local plates = {}
    for _, x in ipairs { -half, half } do
      local wheel = world:cylinder { radius = radius, height = 0.3, mass = 20, at = { x, 0.5, z }, friction = 1.5, group = -1,
                                     rotation = { axis = { 1, 0, 0 }, angle = math.pi / 2 } }
      joints[#joints + 1] = world:hinge { a = wheel, b = hull, at = { x, 0.5, z }, axis = { 0, 0, 1 },
                                          motor = { speed = -4, max_torque = 300 } }
    end
    for i = 1, count do
      local x1, y1 = at((i - 1) * length / count)
      local x2, y2 = at(i * length / count)
      plates[i] = world:box { size = { 0.9 * length / count, 0.04, 0.3 }, mass = 1.5, at = { (x1 + x2) / 2, (y1 + y2) / 2, z },
                              rotation = { axis = { 0, 0, 1 }, angle = math.atan(y2 - y1, x2 - x1) }, friction = 1 }
    end
    for i = 1, count do
      local x, y = at(i * length / count)
      joints[#joints + 1] = world:hinge { a = plates[i], b = plates[i % count + 1], at = { x, y, z }, axis = { 0, 0, 1 } }
    end
  end
  track(0.7)
  track(-0.7)
  local apart = 0
  for _ = 1, 120 do
    world:step()
    for _, j in ipairs(joints) do apart = math.max(apart, j.error) end
  end
  expect(apart):below "2 cm"
  expect(hull.at.x):between(0.5, 5)
  expect(world.energy.numerical):near(0, 100)         -- of 3.6 kJ
  s:expect_reliable()
end)

-- ---- what cannot be: rings that are too tight ----

-- The plates' inner faces lie within the drum by so much, and their hinges would have to open for them to come out.
for _, ring in ipairs { { 6, "1 mm", true }, { 6, "1 mm" }, { 12, "0.1 mm" }, { 12, "1 mm", true }, { 12, "1 mm" }, { 24, "0.1 mm" } } do
  local n, over, fixed = ring[1], digbox.quantity(ring[2], "m"), ring[3]
  local drum_is = fixed and "a fixed drum" or "a drum"
  scenario(("a ring of %d hinged plates that is %s too tight for %s stays on it"):format(n, ring[2], drum_is), function(s)
    local world = s:world { gravity = { 0, -g, 0 } }
    local drum = world:cylinder { radius = 0.3, height = 0.5, fixed = fixed, mass = not fixed and 10 or nil, friction = 0.5,
                                  rotation = { from = { 0, 1, 0 }, to = { 0, 0, 1 } } }
    if not fixed then world:hinge { a = drum, at = { 0, 0, 0 }, axis = { 0, 0, 1 } } end
    local half, mid, plates, joints = math.pi / n, 0.31 - over, {}, {}
    local function at(angle, r) return { r * math.cos(angle), r * math.sin(angle), 0 } end
    for i = 1, n do
      plates[i] = world:box { size = { 0.02, 1.9 * mid * math.tan(half), 0.4 }, mass = 0.4, friction = 0.8, group = -1,
                              at = at(2 * half * i, mid), rotation = { axis = { 0, 0, 1 }, angle = 2 * half * i } }
    end
    for i = 1, n do
      joints[i] = world:hinge { a = plates[i], b = plates[i % n + 1], axis = { 0, 0, 1 },
                                at = at(2 * half * i + half, mid / math.cos(half)) }
    end
    local apart, fast = 0, 0
    for _ = 1, 120 do
      world:step()
      for i = 1, n do apart, fast = math.max(apart, joints[i].error), math.max(fast, plates[i].speed) end
    end
    expect(apart):below(1.5 * over)
    expect(fast):below "5 cm/s"
    expect(world.energy.numerical):near(0, 1)
  end)
end

-- ---- a pallet in slings, below a chain on a hook that is moved: the chain jerks taut, and its joints close again ----

local function crane(world, links, mass, boxes)
  world:floor {}
  local pallet = world:box { size = { 1, 0.12, 0.8 }, mass = 20, friction = 0.7, at = { 0, 0.06, 0 } }
  for i = 0, boxes - 1 do
    world:box { size = 0.3, mass = 500 / boxes, friction = 0.7, at = { -0.2 + 0.4 * (i % 2), 0.27, -0.18 + 0.36 * (i // 2) } }
  end
  local hook = world:box { kinematic = true, size = 0.2, at = { 0, 2.5, 0 } }
  local block = world:ball { radius = 0.12, mass = 15, at = { 0, 1.5, 0 } }
  world:rope { a = hook, b = block, length = 1, segments = links, mass = mass, radius = 0.02 }
  for _, c in ipairs { { -1, -1 }, { -1, 1 }, { 1, -1 }, { 1, 1 } } do
    world:rope { a = block, b = pallet, at_a = block.position, at_b = { 0.48 * c[1], 0.12, 0.38 * c[2] } }
  end
  return hook
end

for _, case in ipairs { { 30, 1, 12, 5, 1 }, { 30, 1, 6, 1, 1 }, { 30, 2, 12, 1, 4 }, { 60, 2, 12, 1, 1 }, { 60, 3, 12, 5, 1 } } do
  local rate, speed, links, mass, boxes = table.unpack(case)
  scenario(("a hook at %g m/s, a chain of %d links and %g kg, %d boxes in slings: joints give no energy (1/%d s)"):format(
    speed, links, mass, boxes, rate), function(s)
    local world = s:world { step = 1 / rate }
    local hook = crane(world, links, mass, boxes)
    local highest, before = 0, nil
    for frame = 0, 5 * rate - 1 do
      local t = frame / rate
      local up = t >= 0.5 and t < 2 and speed or t >= 3 and t < 4 and -speed or 0
      hook:drive { velocity = { t >= 2 and t < 3 and speed or 0, up, 0 } }
      world:step()
      local e = world.energy
      highest, before = math.max(highest, e.total - e.work_in - (before or e.total - e.work_in)), e.total - e.work_in
    end
    expect(highest):below(10)                             -- J, of 1.4 to 28 kJ; 59, 89 and 590 in three of them before
  end)
end
