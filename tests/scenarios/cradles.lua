-- tests/scenarios/cradles.lua - Newton's cradles of many kinds: what comes in on one side goes out on the other, with all its energy.
local digbox = require "digbox"
local test = require "digbox.test"

-- count balls of radius r on threads of length threads x r, `struck` of them pulled aside by 0.45 rad; gap: between them, in radii
local function cradle(world, c)
  local length, balls, frame = c.threads * c.r, {}, c.frame or digbox.quat {}
  for k = 1, c.count do
    local x = 0.37 * c.r + (k - 1) * (2 + c.gap) * c.r
    local a = k <= c.struck and 0.45 or 0
    local at = digbox.vec(x - length * math.sin(a), -length * math.cos(a), 0)
    balls[k] = world:ball { radius = c.r, restitution = 1, friction = 0, at = frame:rotate(at) }
    if c.hinges then
      world:hinge { a = balls[k], at = frame:rotate { x, 0, 0 }, axis = frame:rotate { 0, 0, 1 } }
    else
      for side = -1, 1, 2 do
        world:distance { a = balls[k], at_a = frame:rotate(at), at_b = frame:rotate { x, 0, 0.5 * length * side } }
      end
    end
  end
  return balls, length
end

-- One that had come to hang in balance, without speed and without acceleration, was moved to nowhere: energy over no work.
test.scenario("a ball that comes to rest in balance stays where it is", function(s)
  for _, struck in ipairs { 1, 2 } do
    local world = s:world { step = 1 / 30, accuracy = "study" }
    local aside = 0
    world:on("disabled", function() aside = aside + 1 end)
    cradle(world, { r = 0.03, count = 3 + struck, struck = struck, gap = 0, threads = 10 })
    world:run(struck == 1 and 7.7 or 2.2)
    test.expect(aside):is(0)
  end
end)
