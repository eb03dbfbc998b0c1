-- What springs and motors throw from rest meets what is in its way, however thin that is, and however many of its swings fit into a step;
-- a motor without a bound is stalled by a wall.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local function world_of(step, more)
  local options = { gravity = { 0, 0, 0 }, step = step }
  for key, value in pairs(more or {}) do options[key] = value end
  return digbox.world(options)
end

-- Calls run with each combination of values, one of each list.
local function each(lists, run, ...)
  local count = select("#", ...)
  if count == #lists then return run(...) end
  for _, value in ipairs(lists[count + 1]) do
    local values = table.pack(...)
    values[count + 1] = value
    each(lists, run, table.unpack(values, 1, count + 1))
  end
end

local steps = { 1 / 60, 1 / 30 }

local function peg(world, x, y) return world:box { size = { 0.02, 0.02, 0.3 }, at = { x, y, 0 }, fixed = true, restitution = 0 } end

-- A rod of 1 m and 1 kg on a hinge at its end, and a peg in its way, `gap` rad on, 0.9 m from the hinge.
local function rod_and_peg(step, gap, hinge, more)
  local world = world_of(step, more)
  local rod = world:box { size = { 1, 0.05, 0.05 }, mass = 1, at = { 0.5, 0, 0 }, restitution = 0 }
  hinge.a, hinge.at, hinge.axis = rod, { 0, 0, 0 }, { 0, 0, 1 }
  local joint = world:hinge(hinge)
  peg(world, 0.9 * math.cos(gap), 0.9 * math.sin(gap))
  return world, joint, rod
end

-- where the rod lies against the peg, rad before the peg's middle: its half height and the peg's corner, seen from the hinge
local function touches_at(gap)
  local x, y = 0.9 * math.cos(gap), 0.9 * math.sin(gap)
  local least = math.huge
  for _, corner in ipairs { { -0.01, -0.01 }, { -0.01, 0.01 }, { 0.01, -0.01 }, { 0.01, 0.01 } } do
    local cx, cy = x + corner[1], y + corner[2]
    least = math.min(least, math.atan(cy, cx) - math.asin(0.025 / math.sqrt(cx * cx + cy * cy)))
  end
  return least
end

scenario("a rod that a spring throws from rest does not pass a peg", function()
  each({ steps, { 0.3, 0.6, 1 }, { 100, 1000, 10000, 30000 }, { 0, 1 } }, function(step, gap, stiffness, damping)
    local world, hinge = rod_and_peg(step, gap, { spring = { stiffness = stiffness, rest = 2, damping = damping } })
    for _ = 1, math.ceil(0.2 / step) do
      world:step()
      expect(hinge.angle):at_most(touches_at(gap) + 1e-6)
    end
  end)
end)

scenario("a motor drives a rod against a peg, and holds it there, with a bound or without", function()
  each({ { "play", "study" }, { 0.3, 1.3 }, { 1, 20, 100 }, { 1e4, math.huge } }, function(accuracy, gap, speed, most)
    local world, hinge = rod_and_peg(1 / 60, gap, { motor = { speed = speed, max_torque = most } }, { accuracy = accuracy })
    for _ = 1, math.ceil(60 * gap / speed) + 5 do
      world:step()
      expect(hinge.angle):at_most(touches_at(gap) + 1e-6)
    end
    expect(hinge.angle):near(touches_at(gap), 1e-6)
    expect(hinge.speed):near(0, 1e-6)
    expect(#world:warnings()):is(0)
  end)
end)

scenario("a motor without a bound is at its speed at once", function()
  local world = world_of(1 / 60)
  local rod = world:box { size = { 1, 0.05, 0.05 }, mass = 1, at = { 0.5, 0, 0 } }
  local hinge = world:hinge { a = rod, at = { 0, 0, 0 }, axis = { 0, 0, 1 }, motor = { speed = 30 } }
  for k = 1, 10 do
    world:step()
    expect(hinge.angle):near(0.5 * k, 1e-3)
    expect(hinge.speed):near(30, 1e-9)
  end
end)

scenario("what hangs on what is thrown does not pass either", function()
  for _, step in ipairs { 1 / 60, 1 / 30 } do
    for _, gap in ipairs { 0.2, 0.4, 0.6 } do
      for _, speed in ipairs { 30, 60, 100 } do
        local world = world_of(step)
        local arm = world:box { size = { 0.5, 0.05, 0.05 }, mass = 1, at = { 0.25, 0, 0 }, restitution = 0 }
        local fore = world:box { size = { 0.5, 0.05, 0.05 }, mass = 1, at = { 0.75, 0, 0 }, restitution = 0 }
        local motor = { speed = speed, max_torque = 3000 }
        local hinge = world:hinge { a = arm, at = { 0, 0, 0 }, axis = { 0, 0, 1 }, motor = motor }
        world:weld { a = arm, b = fore }
        peg(world, 0.9 * math.cos(gap), 0.9 * math.sin(gap))
        for _ = 1, 10 do
          world:step()
          expect(hinge.angle):at_most(touches_at(gap) + 1e-4)
        end
      end
    end
  end
end)

-- A ball of 0.1 kg, 0.5 m off its rest, on a spring; a peg in its way.
local function ball_and_peg(step, gap, kind, stiffness, damping)
  local world = world_of(step)
  local ball = world:ball { radius = 0.02, mass = 0.1, at = { 0, 0, 0 }, restitution = 0 }
  if kind == "spring" then
    local post = world:box { size = { 0.01, 0.01, 0.01 }, at = { 0, 2, 0 }, fixed = true, collides = false }
    world:spring { a = ball, b = post, stiffness = stiffness, length = 1.5, damping = damping }
  else
    world:slider { a = ball, axis = { 0, 1, 0 }, spring = { stiffness = stiffness, rest = 0.5, damping = damping } }
  end
  peg(world, 0, gap)
  return world, ball
end

scenario("a ball whose swings are many in a step does not pass a peg between its ends", function()
  each({ steps, { 0.15, 0.3 }, { 1e3, 1e4, 1e5, 1e6 }, { 0, 1 }, { "spring", "slider" } }, function(step, gap, stiffness, damping, kind)
    local world, ball = ball_and_peg(step, gap, kind, stiffness, damping)
    local into = stiffness < 1e6 and 1e-6 or 3e-3       -- m: with 1e6 N/m it strikes at 1500 m/s
    for _ = 1, 10 do
      world:step()
      expect(ball.at.y):at_most(gap - 0.03 + into)
    end
  end)
end)

scenario("a peg beyond its swing changes nothing", function()
  for _, stiffness in ipairs { 1e4, 1e6 } do
    local near, ball = ball_and_peg(1 / 60, 1.1, "spring", stiffness)
    local far, other = ball_and_peg(1 / 60, 50, "spring", stiffness)
    for _ = 1, 30 do
      near:step()
      far:step()
      expect(ball.at.y):near(other.at.y, 1e-9)
      expect(near:stats().evaluations):is(1)
    end
    expect(near.energy.total):near(0.125 * stiffness, 1e-9 * stiffness)
  end
end)

scenario("see-saws and free rods meet what they are turned into", function()
  for _, step in ipairs { 1 / 60, 1 / 30 } do
    for _, gap in ipairs { 0.15, 0.3, 0.5, 0.8 } do
      local world = world_of(step)
      local rod = world:box { size = { 1, 0.05, 0.05 }, mass = 1, at = { 0.4, 0, 0 }, restitution = 0 }
      local hinge = world:hinge { a = rod, at = { 0, 0, 0 }, axis = { 0, 0, 1 } }
      local post = world:box { size = { 0.01, 0.01, 0.01 }, at = { -0.1, -1, 0 }, fixed = true, collides = false }
      world:spring { a = rod, b = post, at_a = { -0.1, 0, 0 }, stiffness = 1e5, length = 0.5 }
      peg(world, 0.85 * math.cos(gap), 0.85 * math.sin(gap))
      for _ = 1, 10 do
        world:step()
        expect(hinge.angle):at_most(gap)
      end
      local free = world_of(step)
      local turning, hits = free:box { size = { 1, 0.05, 0.05 }, mass = 1, at = { 0, 0, 0 }, restitution = 0 }, 0
      free:motor { a = turning, axis = { 0, 0, 1 }, speed = 20, max_torque = 1e4 }
      turning:on("contact_begin", function() hits = hits + 1 end)
      peg(free, 0.45 * math.cos(gap), 0.45 * math.sin(gap))
      for _ = 1, math.ceil(gap / 20 / step) do free:step() end
      expect(hits):above(0)
    end
  end
end)

-- Two balls of 0.1 kg, 0.3 m apart: the first on a spring, the second on the first; a peg in the way of the second.
-- Of 7106 and 28424 N/m whole periods fit into a thirtieth of a second.
scenario("what hangs on what a spring throws does not pass a peg, nor by whole periods within a step", function()
  for _, step in ipairs { 1 / 60, 1 / 30 } do
    for _, gap in ipairs { 0.15, 0.3 } do
      for _, stiffness in ipairs { 1000, 7106, 10000, 28424 } do
        for _, kind in ipairs { "weld", "slider", "hinge" } do
          local world, hits = world_of(step), 0
          local first = world:ball { radius = 0.02, mass = 0.1, at = { 0, 0, 0 }, restitution = 0 }
          local second = world:ball { radius = 0.02, mass = 0.1, at = { 0.3, 0, 0 }, restitution = 0 }
          world:slider { a = first, axis = { 0, 1, 0 }, spring = { stiffness = stiffness, rest = 0.5 } }
          world[kind](world, { a = second, b = first, axis = kind == "slider" and { 1, 0, 0 } or { 0, 0, 1 } })
          world:box { size = { 0.02, 0.02, 0.3 }, at = { 0.3, gap, 0 }, fixed = true, restitution = 0 }
          second:on("contact_begin", function() hits = hits + 1 end)
          for _ = 1, 3 do
            world:step()
            expect(second.at.y):at_most(gap)
          end
          expect(hits):above(0)
        end
      end
    end
  end
end)

test.each_accuracy("a brake without a bound holds what pushes and springs pull at, however light it is itself", function(s, accuracy)
  for _, step in ipairs { 1 / 60, 1 / 30 } do
    for _, push in ipairs { 1e4, 1e6 } do
      for _, near in ipairs { false, true } do
        local world = s:world { gravity = { 0, 0, 0 }, step = step, accuracy = accuracy }
        local brake = world:box { size = 0.02, mass = 0.01, at = { 0, 0, 0 } }
        world:slider { a = brake, axis = { 1, 0, 0 }, motor = { speed = 0 } }
        if near then world:box { size = 0.02, at = { 0, 0.0202, 0 }, fixed = true } end
        brake:push { force = { push, 0, 0 }, lasts = 1 }
        world:run(0.2)
        expect(brake.at.x):near(0, 1e-6)
        local post = world:box { size = 0.01, at = { 2, 0, 0 }, fixed = true, collides = false }
        local tied = world:box { size = 0.02, mass = 0.01, at = { 0, 1, 0 } }
        world:slider { a = tied, axis = { 1, 0, 0 }, motor = { speed = 0 } }
        world:spring { a = tied, b = post, stiffness = push, length = 1 }
        world:run(0.2)
        expect(tied.at.x):near(0, 1e-5)
      end
    end
  end
end)
