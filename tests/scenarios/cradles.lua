-- tests/scenarios/cradles.lua - Newton's cradles of many kinds: what comes in on one side goes out on the other, with all its energy.
--
-- Balls that hang side by side press each other by 1e-31 N or pull by as much, whose sign is chance. While that counted as a force
-- contacts opened and closed for ever, the frame was swept, and what had last touched was one block there: a third to nine tenths of
-- the energy went.
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

-- Share of the energy of the pulled balls that is left after `periods`
local function left(s, c)
  local frame = c.frame or digbox.quat {}
  local world = s:world { step = c.step or 1 / 60, accuracy = c.plan or "play", gravity = frame:rotate { 0, -9.81, 0 } }
  local balls, length = cradle(world, c)
  local function energy() return world.energy.kinetic + world.energy.potential end
  local begin, lift = energy(), c.struck * balls[1].mass * 9.81 * length * (1 - math.cos(0.45))
  world:run { seconds = (c.periods or 4) * 2 * math.pi * math.sqrt(length / 9.81) }
  return 1 - (begin - energy()) / lift
end

-- 0.16, 0.40, 0.32, 0.55 and 0.26 were left of the first five
test.scenario("touching balls hand on what strikes them, on threads and on hinges, in any direction", function(s)
  test.expect(left(s, { r = 0.03, count = 7, struck = 1, gap = 0, threads = 10 })):near(1, 1e-3)
  test.expect(left(s, { r = 0.5, count = 5, struck = 2, gap = 0, threads = 10, periods = 8 })):near(1, 1e-3)
  test.expect(left(s, { r = 0.03, count = 5, struck = 1, gap = 0, threads = 20, step = 1 / 30, periods = 5 })):near(1, 1e-3)
  test.expect(left(s, { r = 0.03, count = 7, struck = 3, gap = 0, threads = 10 })):near(1, 1e-3)
  test.expect(left(s, { r = 0.01, count = 7, struck = 2, gap = 0, threads = 10, hinges = true })):near(1, 1e-3)
  local over = digbox.quat { axis = { 0, 0, 1 }, angle = math.pi / 2 }
  test.expect(left(s, { r = 0.05, count = 5, struck = 2, gap = 0, threads = 20, step = 1 / 30, frame = over })):near(1, 1e-3)
end)

-- A dozen blows within a ten-thousandth of a second are followed, each of them: 0.27, 0.45 and 0.03 were left.
test.scenario("balls with little between them hand on what strikes them blow by blow", function(s)
  for _, c in ipairs {
    { r = 0.01, count = 7, struck = 2, threads = 10 }, { r = 0.03, count = 7, struck = 3, threads = 20, step = 1 / 30 },
    { r = 0.01, count = 7, struck = 3, threads = 10, step = 1 / 30, hinges = true },
  } do
    c.gap, c.periods = 1e-3, 8
    test.expect(left(s, c)):near(1, 2e-2)
  end
end)

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
