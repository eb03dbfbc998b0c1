-- tests/scenarios/dead_points.lua - a motor without a bound on a linkage that cannot turn all round.
--
-- Where crank and coupler come to lie in one line the crank can go no farther. To reach that at its speed the rest would have to move
-- infinitely fast: 3 kg of rods were thrown about at 25 to 19,400 m/s, their joints 0.9 to 80 m apart, with warnings. Now the motor
-- stalls: in a loop it gives ten times what brings all of it to the motor's speed in a frame, and a hundred times its weight
-- (group_motor_most in engine/solve/joint_rows.c).
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- Where circles about p and q, of radii a and b, meet above the line from p to q
local function meet(p, a, q, b)
  local d = q - p
  local along = (a * a - b * b + d:dot(d)) / (2 * #d)
  local across = math.sqrt(a * a - along * along)
  local u = d:normalized()
  return p + u * along + digbox.vec(-u.y, u.x, 0) * across
end

-- Rods of 1 kg on hinges: crank and rocker stand on the ground `base` apart; the crank begins at an angle (rad)
local function four_bar(world, crank, coupler, rocker, base, angle, motor)
  local axis, foot, far = { 0, 0, 1 }, digbox.vec(0, 0, 0), digbox.vec(base, 0, 0)
  local elbow = digbox.vec(crank * math.cos(angle), crank * math.sin(angle), 0)
  local knee = meet(elbow, coupler, far, rocker)
  local function rod(from, to) return world:rod { from = from, to = to, radius = 0.02, mass = 1, collides = false } end
  local m = { knee = knee, rods = { rod(foot, elbow), rod(elbow, knee), rod(far, knee) } }
  local a, b, c = table.unpack(m.rods)
  m.joints = { world:hinge { a = a, at = foot, axis = axis, motor = motor }, world:hinge { a = b, b = a, at = elbow, axis = axis },
               world:hinge { a = c, b = b, at = knee, axis = axis }, world:hinge { a = c, at = far, axis = axis } }
  return m
end

local function run(world, m, seconds, rate)
  local top, apart, off = 0, 0, 0
  while world.time < seconds - 1e-9 do
    world:step()
    for _, rod in ipairs(m.rods) do top = math.max(top, rod.speed) end
    for _, joint in ipairs(m.joints) do apart = math.max(apart, joint.error) end
    off = math.max(off, math.abs((m.joints[1].angle or 0) - rate * world.time))
  end
  return top, apart, off
end

for _, step in ipairs { 30, 60, 240 } do
  for _, speed in ipairs { 1, 2, 5 } do
    scenario(("a crank driven at %g rad/s comes to a dead point and stalls, 1/%d s"):format(speed, step), function(s)
      local world = s:world { step = 1 / step }
      local top, apart = run(world, four_bar(world, 1, 2, 1, 2.5, 1.2, { speed = speed }), 4, speed)
      expect(apart):below "5 cm"
      expect(top):below "80 m/s"                                   -- 55; of its power there is an end, not of what it throws about
      expect(math.abs(world.energy.numerical)):below "4 J"
      expect(world:stats().warnings):is(0)
      s:expect_reliable()
    end)
  end
end

-- The piston of a crank of 0.5 m and a rod of 1 m, on a slider with a motor
local function piston(world, speed)
  local elbow, axis = digbox.vec(0.3, 0.4, 0), { 0, 0, 1 }
  local at = digbox.vec(0.3 + math.sqrt(1 - 0.4 ^ 2), 0, 0)
  local crank = world:rod { from = { 0, 0, 0 }, to = elbow, radius = 0.02, mass = 1, collides = false }
  local link = world:rod { from = elbow, to = at, radius = 0.02, mass = 1, collides = false }
  local head = world:box { size = 0.1, mass = 2, at = at, collides = false }
  return { rods = { crank, link, head }, joints = {
    world:slider { a = head, along = { 1, 0, 0 }, motor = { speed = speed } }, world:hinge { a = crank, at = { 0, 0, 0 }, axis = axis },
    world:hinge { a = link, b = crank, at = elbow, axis = axis }, world:hinge { a = head, b = link, at = at, axis = axis } } }
end

for _, step in ipairs { 30, 60, 240 } do
  for _, speed in ipairs { -1, 1 } do
    scenario(("a piston driven at %g m/s comes to a dead point and stalls, 1/%d s"):format(speed, step), function(s)
      local world = s:world { step = 1 / step }                    -- 55 to 3000 m/s, 1.5 to 5 m apart
      local top, apart = run(world, piston(world, speed), 4, 0)
      expect(apart):below "1 cm"
      expect(top):below "20 m/s"
      expect(math.abs(world.energy.numerical)):below "1 J"
      s:expect_reliable()
    end)
  end
end

-- A base on the floor, and three links whose motors fold them and press the last one into the ground: it lifts itself, and jams in the end.
for _, step in ipairs { 30, 60, 240 } do
  scenario(("an excavator without a bound to its motors lifts itself and jams, 1/%d s"):format(step), function(s)
    local world = s:world { step = 1 / step }                      -- 1450 and 1850 m/s, 4.5 GJ, 1 m apart at 1/30 and 1/60 s
    local axis = { 0, 0, 1 }
    world:floor {}
    local last, at = world:box { size = { 1, 0.5, 1 }, mass = 200, at = { 0, 0.25, 0 } }, { 0, 0.55, 0 }
    local m = { rods = { last }, joints = {} }
    for i, to in ipairs { { 1, 1.3, 0 }, { 1.8, 0.9, 0 }, { 2, 0.5, 0 } } do
      local rod = world:rod { from = at, to = to, radius = 0.03, mass = ({ 5, 3, 2 })[i] }
      m.rods[i + 1] = rod
      m.joints[i] = world:hinge { a = rod, b = last, at = at, axis = axis, motor = { speed = ({ -0.6, -1, -2 })[i] } }
      last, at = rod, to
    end
    local top, apart = run(world, m, 5, 0)
    expect(top):below "4 m/s"
    expect(apart):below "1 mm"
    s:expect_reliable()
  end)
end

for _, load in ipairs { 0, 1000 } do
  scenario(("a crank that can turn all round keeps its speed, with %g kg at the rocker"):format(load), function(s)
    local world = s.world
    local m = four_bar(world, 0.5, 2, 1.5, 2, 0, { speed = 2 })
    if load > 0 then
      world:ball_joint { a = world:box { size = 0.3, mass = load, at = m.knee, collides = false }, b = m.rods[3], at = m.knee }
    end
    local _, apart, off = run(world, m, 4, 2)
    expect(off):below(5e-3)                                        -- rad: 4.2e-3 of it in the first frame, as before
    expect(apart):below "0.1 mm"
  end)
end

scenario("a brake in a loop holds whatever comes", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local m = four_bar(world, 1, 2, 1, 2, math.pi / 2, { speed = 0 })
  m.rods[1].collides = true
  world:ball { radius = 0.1, mass = 5, at = { -1, 0.9, 0 }, velocity = { 8, 0, 0 } }
  local _, apart, off = run(world, m, 2, 0)
  expect(off):below(1e-6)
  expect(apart):below "0.1 mm"
end)
