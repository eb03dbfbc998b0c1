-- laws_springs.lua: what one spring moves along its line follows the closed form of its swing, however stiff it is.
local digbox = require "digbox"
local test = require "digbox.test"
local expect = test.expect

local g = 9.81

-- Length over the rest, and its rate, after t seconds: s'' = a - u (k s + c s')
local function exact(s0, r0, a, u, k, c, t)
  local w2, b = u * k, u * c / 2
  local y0, d = s0 - a / w2, w2 - b * b
  local even, odd
  if d > 0 then
    local w = math.sqrt(d)
    even, odd = math.exp(-b * t) * math.cos(w * t), math.exp(-b * t) * math.sin(w * t) / w
  elseif d == 0 then
    even, odd = math.exp(-b * t), math.exp(-b * t) * t
  else
    local q = math.sqrt(-d)
    local slow, fast = math.exp(-w2 / (b + q) * t), math.exp(-(b + q) * t)
    even, odd = (slow + fast) / 2, (slow - fast) / (2 * q)
  end
  return a / w2 + y0 * even + (r0 + b * y0) * odd, r0 * even - (b * r0 + w2 * y0) * odd
end

-- In parts of critical damping: free, below it, at it, beyond it, far beyond it
for _, damping in ipairs { 0, 0.1, 1, 5, 1000 } do
  test.each_accuracy(("a mass hung on a spring, damped by %g of critical"):format(damping), function(s, accuracy)
    for _, k in ipairs { 10, 1e4, 1e8 } do
      local world = s:world { accuracy = accuracy }
      local m = 2
      local c = damping * 2 * math.sqrt(k * m)
      local ball = world:ball { radius = 0.1, mass = m, at = { 3, -20, 1 }, spin = { 1, 2, 3 } }
      world:spring { a = ball, at_b = { 3, 0, 1 }, length = 20, stiffness = k, damping = c }
      for _ = 1, 30 do
        world:step()
        local off, rate = exact(0, 0, g, 1 / m, k, c, world.time)
        expect(-ball.position.y - 20):near(off, 1e-8 * m * g / k + 2e-13)     -- of what was given it keeps ten digits in 30 steps
        expect(-ball.velocity.y):near(rate, 1e-8 * math.sqrt(m / k) * g + 2e-13 * math.sqrt(k / m))
      end
      expect(world:stats().evaluations):is(1)
      expect(world.energy.total + world.energy.lost):near(world.energy.initial, 1e-9 * m * g)
      expect(ball.spin):near({ 1, 2, 3 }, 0)
    end
  end)
end

test.scenario("two bodies on a spring swing about their centre of mass, on any line, with any levers on it", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local along = digbox.vec { 1, 2, 2 } / 3
  local a = world:box { size = 0.2, mass = 1, at = along * 2, velocity = along * 4 }
  local b = world:box { size = 0.2, mass = 3, at = { 0, 0, 0 } }
  local k = 1e5
  world:spring { a = a, b = b, at_a = along * 1.9, at_b = along * 0.1, length = 1.8, stiffness = k }
  for _ = 1, 20 do
    world:step()
    local off, rate = exact(0, 4, 0, 4 / 3, k, 0, world.time)
    expect(along:dot(a.position - b.position) - 2):near(off, 1e-10)
    expect(along:dot(a.velocity - b.velocity)):near(rate, 1e-7)
    expect((a.position + b.position * 3) / 4):near(along * (0.5 + world.time), 1e-12)
    expect(world:stats().evaluations):is(1)
  end
end)

test.scenario("what goes across its line, meets the other end, or may break, is followed", function(s)
  local function evaluations(of, fields)
    local world = s:world {}
    local ball = world:ball { radius = 0.1, mass = 1, at = { 0, -1, 0 }, velocity = of.velocity }
    local joint = { a = ball, at_b = { 0, 0, 0 }, length = 1, stiffness = 100 }
    for key, value in pairs(fields or {}) do joint[key] = value end
    world:spring(joint)
    world:step()
    return world:stats().evaluations
  end
  expect(evaluations {}):is(1)
  expect(evaluations { velocity = { 1e-6, 0, 0 } }):above(1)
  expect(evaluations { velocity = { 0, 12, 0 } }):above(1)                       -- its swing is as wide as the spring is long
  expect(evaluations({}, { breaks_at = 5 })):above(1)
  expect(evaluations({}, { length = 0 })):above(1)                               -- without a line
end)

-- ---- springs so taut that what they hold sways across them faster than a substep of the default follows ----

-- m  How far four springs of that stiffness, 0.92 m long and 0.5 m at rest, let a plate sink that they pull at level, under a weight
local function sinks(stiffness, weight)
  local low, high = 0, 0.5
  for _ = 1, 60 do
    local far = (low + high) / 2
    local length = math.sqrt(2 * 0.65 ^ 2 + far ^ 2)
    local lifts = 4 * stiffness * (length - 0.5) * far / length
    if lifts < weight then low = far else high = far end
  end
  return low
end

-- Sweeps are explicit across a spring: four of 1e5 N/m on a plate of 10 kg made 2e4 J in a frame of 1/30 s, of 1e6 N/m 6e5 J in one of
-- 1/60 s.
for _, case in ipairs { { 4e4, 30, 1 }, { 1e5, 30, 1 }, { 1e6, 60, 1 }, { 1e7, 30, 1 }, { 4e4, 30, 2 } } do
  local stiffness, rate, strands = table.unpack(case)
  local title = "a plate on four taut springs of %g N/m, of %d strands, catches boxes at 1/%d s, and all rest"
  test.scenario(title:format(stiffness, strands, rate), function(s)
    local world = s:world { step = 1 / rate }
    local plate = world:box { size = { 2, 0.05, 2 }, at = { 0, 1, 0 }, mass = 10 }
    for x = -1, 1, 2 do
      for z = -1, 1, 2 do
        for _ = 1, strands do
          world:spring { a = plate, at_a = { x * 0.95, 1, z * 0.95 }, at_b = { x * 1.6, 1, z * 1.6 }, length = 0.5,
            stiffness = stiffness / strands }
        end
      end
    end
    local boxes = {}
    for i = 1, 4 do boxes[i] = world:box { size = 0.3, mass = 5, at = { 0.35 * (i - 2.5), 1.2 + 0.4 * i, 0 } } end
    local made, most = 0, world.energy.total
    for _ = 1, 4 * rate do
      world:step()
      made, most = math.max(made, world.energy.total - most), math.min(most, world.energy.total)
    end
    expect(made):below(0.5)                               -- J, of 250 that the boxes bring
    expect(plate.speed):below "5 cm/s"
    for _, box in ipairs(boxes) do expect(box.speed):below "5 cm/s" end
    expect(plate.position.y):near(1 - sinks(stiffness, 30 * 9.81), 1e-3)
    expect(world.energy.numerical):near(0, 40)            -- J: 25 at most, of blows that bodies on springs take in what is solved at once
    s:expect_reliable()
  end)
end
