-- Worlds that lie in a plane.
local digbox = require "digbox"
local test = require "digbox.test"
local expect = test.expect

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
