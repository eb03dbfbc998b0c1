-- Worlds that lie in a plane.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- In each plane, with a joint about its normal, what happens in space as well.
test.each_accuracy("what joints do in a plane is what they do in space", function(s, accuracy)
  for plane, c in pairs { xy = { digbox.vec(1, 0, 0), digbox.vec(0, -9.81, 0), digbox.vec(0, 0, 1) }, yz = { digbox.vec(0, 1, 0),
    digbox.vec(0, 0, -9.81), digbox.vec(1, 0, 0) }, xz = { digbox.vec(1, 0, 0), digbox.vec(0, 0, -9.81), digbox.vec(0, 1, 0) } } do
    for _, motor in ipairs { false, { speed = 3, max_torque = 1 } } do
      local ends = {}
      for _, flat in ipairs { false, true } do
        local world = s:world { plane = flat and plane or nil, gravity = motor and { 0, 0, 0 } or c[2], accuracy = accuracy }
        local box = world:box { size = 0.2, at = motor and { 0, 0, 0 } or c[1] }
        local hinge = world:hinge { a = box, at = { 0, 0, 0 }, axis = c[3], motor = motor or nil }
        world:run(0.5)
        ends[#ends + 1] = { at = box.position, speed = hinge.speed, angle = hinge.angle }
      end
      expect(math.abs(ends[1].angle)):above(0.5)
      local near = accuracy == "sketch" and 2e-3 or 1e-6
      expect(ends[2].at):near(ends[1].at, near)
      expect(ends[2].speed):near(ends[1].speed, near)
      expect(ends[2].angle):near(ends[1].angle, near)
    end
  end
end)

-- Joints, contacts and masses of 2000:1 at once, in each of the planes
for _, case in ipairs { { "xy", "x", "y", "z" }, { "yz", "z", "y", "x" }, { "xz", "x", "z", "y" } } do
  local plane, right, up, out = table.unpack(case)
  scenario("a heavy ball on a chain goes through a wall, and its chain holds, in plane " .. plane, function()
    local function to(x, y, z) return digbox.vec { [right] = x, [up] = y, [out] = z } end
    local normal, tilt = to(0, 0, 1), math.rad(-55)
    local turned = digbox.quat { from = { 0, 1, 0 }, to = to(-math.sin(tilt), math.cos(tilt), 0) }
    local function along(way) return to(0, 5, 0) + to(math.sin(tilt), -math.cos(tilt), 0) * way end
    local world = digbox.world { plane = plane, gravity = to(0, -9.81, 0) }
    world:box { fixed = true, size = to(40, 1, 4), at = to(0, -0.5, 0), friction = 0.6 }
    local last
    for i = 1, 8 do
      local rod = world:capsule { radius = 0.03, length = 0.3, at = along(0.4 * (i - 0.5)), rotation = turned, collides = false }
      world:hinge { a = rod, b = last, at = along(0.4 * (i - 1)), axis = normal }
      last = rod
    end
    local ball = world:ball { radius = 0.4, mass = 2000, at = along(3.6) }
    world:hinge { a = ball, b = last, at = along(3.2), axis = normal }
    for row = 0, 7 do
      for column = 0, 3 do
        world:box { size = to(0.2, 0.15, 0.3), at = to(0.4 + 0.22 * column, 0.075 + row * 0.15, 0), friction = 0.6, density = 1800 }
      end
    end
    world:run "1.5 s"
    local stats = world:stats()
    expect(ball.position:dot(to(1, 0, 0))):above(0.5)
    expect(ball.position:dot(normal)):near(0, 1e-12)
    expect(stats.worst_joint_error):below(1e-3)         -- 0.2 m when joints in a plane were left to the sweeps
    expect(world.energy.numerical):between(-50, 50)     -- J of 61 kJ
  end)
end
