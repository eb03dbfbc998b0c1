-- squeezed.lua: what two things squeeze that nothing moves goes with the mean of both, equally deep in each.
local digbox = require "digbox"
local test = require "digbox.test"
local expect = test.expect

local shapes = {
  { "a box", function(w, p) p.size = 1 return w:box(p) end },
  { "a ball", function(w, p) p.radius = 0.5 return w:ball(p) end },
  { "a barrel", function(w, p)
    p.radius, p.height, p.rotation = 0.5, 1, digbox.quat { axis = { 0, 0, 1 }, angle = "90 deg" }
    return w:cylinder(p)
  end },
}

for _, shape in ipairs(shapes) do
  test.each_accuracy(shape[1] .. " between a wall and a piston", function(s, accuracy)
    for _, case in ipairs { { 0.5, 0.6 }, { 5, 0.6 }, { 0.5, 0 } } do
      local speed, friction = table.unpack(case)
      local w = s:world { accuracy = accuracy, gravity = { 0, 0, 0 } }
      w:box { fixed = true, size = { 1, 4, 4 }, at = { 1, 0, 0 }, friction = friction }
      local thing = shape[2](w, { mass = 1, friction = friction, at = { 0, 0, 0 } })
      local piston = w:box { kinematic = true, size = { 1, 4, 4 }, at = { -1.25, 0, 0 }, velocity = { speed, 0, 0 }, friction = friction }
      w:run(0.25 / speed + 0.4 / speed)                           -- it gets there, and on by 0.4 m
      expect(thing.position.x):near(0.2, 0.02)
      expect(#thing.velocity):at_most(0.6 * speed)
      expect(w:stats().penetration):near(0.2, 0.03)
      piston:drive { velocity = { -speed, 0, 0 } }
      w:run(0.8 / speed)
      expect(thing.position.x):between(-1, 0.02)                  -- and is let go, out of the wall
      expect(#thing.velocity):at_most(0.75 * speed)
      expect(w:stats().penetration):below(1e-3)
    end
  end)
end

-- Between plates that leave it its room, or press beside each other, it is as free as before.
test.each_accuracy("a lid that glides over a box takes no hold of it, a slab pressed at two ends turns", function(s, accuracy)
  local w = s:world { accuracy = accuracy }
  w:floor { friction = 0.5 }
  local box = w:box { size = 1, mass = 1, friction = 0.5, at = { 0, 0.5, 0 } }
  w:box { kinematic = true, size = { 40, 1, 1 }, at = { 0, 1.5, 0 }, velocity = { 3, 0, 0 }, friction = 0.5 }
  w:run(1)
  expect(box.position.x):near(0, 0.05)
  local v = s:world { accuracy = accuracy, gravity = { 0, 0, 0 } }
  local slab = v:box { size = { 0.2, 4, 1 }, mass = 1, at = { 0, 0, 0 }, friction = 0 }
  v:box { fixed = true, size = { 1, 0.5, 1 }, at = { 0.6, 1.5, 0 }, friction = 0 }
  v:box { kinematic = true, size = { 1, 0.5, 1 }, at = { -0.6, -1.5, 0 }, velocity = { 0.2, 0, 0 }, friction = 0 }
  v:run(1)
  expect(v:stats().penetration):below(0.01)
  expect(math.abs(slab.spin.z)):above(0.05)
end)

-- Pressed down by 1 mm/s, a plate that goes on at 1 m/s rolls it along.
test.each_accuracy("a ball between the floor and a plate that glides and presses rolls", function(s, accuracy)
  local w = s:world { accuracy = accuracy }
  w:floor { friction = 0.6 }
  local ball = w:ball { radius = 0.5, mass = 1, friction = 0.6, at = { 0, 0.5, 0 } }
  w:box { kinematic = true, size = { 40, 1, 4 }, at = { 0, 1.5, 0 }, velocity = { 1, -1e-3, 0 }, friction = 0.6 }
  w:run(1)
  expect(ball.velocity.x):near(0.5, 0.05)
  expect(ball.spin.z):near(-1, 0.1)
end)

-- Each plate takes it round the axis of the gripper; on the tangent it would get out by half the square of the turn of a step, in each.
test.each_accuracy("what a gripper that turns holds goes round with it", function(s, accuracy)
  for _, spin in ipairs { 0.5, 6 } do
    local w = s:world { accuracy = accuracy, gravity = { 0, 0, 0 } }
    local grip = w:body { kinematic = true, friction = 0.8, spin = { 0, spin, 0 }, parts = {
      digbox.box { size = { 4, 0.2, 1 }, at = { 1.5, 0.59, 0 } }, digbox.box { size = { 4, 0.2, 1 }, at = { 1.5, -0.59, 0 } } } }
    local box = w:box { size = 1, mass = 1, friction = 0.8, at = { 1.5, 0, 0 }, velocity = { 0, 0, -1.5 * spin }, spin = { 0, spin, 0 } }
    w:run(1)
    expect(grip.rotation:inverse():rotate(box.position)):near({ 1.5, 0, 0 }, 1e-9)
    expect(#box.velocity):near(1.5 * spin, 1e-9)
  end
end)
