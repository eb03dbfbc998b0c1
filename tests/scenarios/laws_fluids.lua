-- laws_fluids.lua: drag of air and wind, buoyancy and drag of water, against closed forms.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local g = 9.81

local function tanh(x)
  local e = math.exp(-2 * x)
  return (1 - e) / (1 + e)
end
local function log_cosh(x) return x + math.log((1 + math.exp(-2 * x)) / 2) end

-- Terminal speed sqrt(2 m g / (rho c A)); v = vt tanh(g t / vt), fallen vt^2 / g ln cosh(g t / vt).
test.each_accuracy("a football falls with drag as the closed form says", function(s, accuracy)
  local world = s.world
  world:air {}
  local r, m, t = 0.11, 0.43, 3
  local ball = world:ball { radius = r, mass = m, at = { 0, 100, 0 } }
  local vt = math.sqrt(2 * m * g / (1.204 * 0.47 * math.pi * r ^ 2))
  world:run(t)
  expect(ball.velocity.y):near(-vt * tanh(g * t / vt), accuracy == "sketch" and 1e-10 or 1e-11)
  expect(ball.position.y):near(100 - vt ^ 2 / g * log_cosh(g * t / vt), accuracy == "sketch" and 2e-3 or 1e-11)
  expect(world.energy.numerical):near(0, accuracy == "sketch" and 0.02 or 1e-10)
  expect(world.energy.lost):above(10)
  world:run(20)
  expect(ball.velocity.y):near(-vt * tanh(g * 23 / vt), 2e-9)
end)

-- Thrown at a slant there is no closed form: the fine solution is the measure, and the swept way converges to the traced one.
scenario("a throw through air comes closer to the exact path with the square of the step when it is swept", function(s)
  local function throw(step, integrator)
    local world = s:world { step = step }
    world:air { wind = { -3, 0, 1 } }
    local ball = world:ball { radius = 0.02, mass = 0.0027, at = { 0, 0, 0 }, velocity = { 12, 9, 0 }, integrator = integrator }
    world:run(1)
    return ball.position, world.energy.numerical
  end
  local exact, closed = throw(1 / 60, "auto")
  local coarse, fine = throw(1 / 60, "verlet"), throw(1 / 120, "verlet")
  expect(closed):near(0, 1e-8)
  expect(#(fine - exact)):below(1e-4)
  expect(#(coarse - exact) / #(fine - exact)):near(4, 0.5)
end)

scenario("a light body takes the speed of the wind and never passes it, however light", function(s)
  for _, mass in ipairs { 1, 1e-2, 1e-4, 1e-6 } do
    for _, integrator in ipairs { "auto", "verlet" } do
      local world = s:world { gravity = { 0, 0, 0 } }
      world:air { wind = { 40, 0, 0 } }
      local ball = world:ball { radius = 0.1, mass = mass, integrator = integrator }
      local k, before = 0.5 * 1.204 * 0.47 * math.pi * 0.01 / mass, 0
      for i = 1, 60 do
        world:step()
        expect(ball.velocity.x):between(before, 40)
        expect(ball.velocity.x):near(40 - 40 / (1 + k * 40 * i / 60), 1e-5)
        before = ball.velocity.x
      end
      -- The wind has done work; what the ball has not got is heat.
      expect(world.energy.numerical / world.energy.work_in):near(0, 1e-6)
      expect(world.energy.lost):above(0)
    end
  end
end)

scenario("a body has its own coefficient and area, opts out with 0, and calls for air by itself", function(s)
  local world = s.world
  expect(world:effects().drag.on):is(false)
  local mine = world:ball { radius = 0.1, mass = 0.1, at = { 0, 500, 0 }, drag_coefficient = 1.2, drag_area = 0.05 }
  local without = world:ball { radius = 0.1, mass = 0.1, at = { 5, 500, 0 } }
  world:run(1)
  expect(world:effects().drag.bodies):is(1)
  expect(without.velocity.y):near(-g, 1e-12)
  world:air {}
  local never = world:ball { radius = 0.1, mass = 0.1, at = { 10, 500, 0 }, drag_coefficient = 0 }
  world:run(60)
  expect(mine.speed):near(math.sqrt(2 * 0.1 * g / (1.204 * 1.2 * 0.05)), 1e-9)
  expect(without.speed):near(math.sqrt(2 * 0.1 * g / (1.204 * 0.47 * math.pi * 0.01)), 1e-9)
  expect(never.speed):near(60 * g, 1e-6)
  expect(mine.drag_coefficient):is(1.2)
  world:air(false)
  local v = mine.speed
  world:run(1)
  expect(mine.speed):near(v + g, 1e-9)
end)

scenario("wind wakes what sleeps, pushes what friction does not hold, and leaves the rest", function(s)
  local world = s.world
  world:floor { friction = 0.5 }
  local light = world:box { size = { 0.5, 0.5, 0.5 }, mass = 0.5, at = { 0, 0.25, 0 }, friction = 0.5 }
  local heavy = world:box { size = { 0.5, 0.5, 0.5 }, mass = 50, at = { 0, 0.25, 3 }, friction = 0.5 }
  s:eventually("both sleep", "3 s", function() return light.asleep and heavy.asleep end)
  world:air { wind = { 6, 0, 0 } }                    -- 5.7 N against a friction of 2.45 N and of 245 N
  expect(light.asleep):is(false)
  world:run(0.5)
  expect(light.speed):above(1)
  expect(heavy.speed):is(0.0)
  s:eventually("the heavy one sleeps again", "3 s", function() return heavy.asleep end)
  expect(light.asleep):is(false)
end)

scenario("a crate and a ball float at the depth that Archimedes asks for", function(s)
  local world = s.world
  world:water { level = 1, damping = 3 }
  local crate = world:box { size = { 0.6, 0.4, 0.6 }, density = 300, at = { 0, 1.3, 0 } }
  local ball = world:ball { radius = 0.2, density = 600, at = { 3, 1.5, 0 } }
  local cylinder = world:cylinder { radius = 0.3, height = 0.3, density = 700, at = { -3, 1, 0 } }
  local cone = world:cone { radius = 0.2, height = 0.1, density = 216, at = { 6, 1, 0 } }     -- apex up: (1 - d/h)^3 = 1 - 0.216
  world:run(30)
  expect(crate.position.y):near(1 + 0.2 - 0.3 * 0.4, 1e-7)
  local low, high = 0, 0.4
  for _ = 1, 60 do                                    -- h^2 (3 r - h) / (4 r^3) = 0.6
    local h = (low + high) / 2
    if h * h * (0.6 - h) / (4 * 0.2 ^ 3) < 0.6 then low = h else high = h end
  end
  expect(ball.position.y):near(1 + 0.2 - low, 1e-7)
  expect(cylinder.position.y):near(1 + 0.15 - 0.7 * 0.3, 1e-7)
  expect(cone.position.y):near(1 + 0.025 - 0.1 * (1 - (1 - 0.216) ^ (1 / 3)), 1e-7)
  expect(crate.speed):below(1e-7)
  expect(world.energy.numerical / world.energy.lost):near(0, 1e-5)
end)

-- Period 2 pi sqrt(m / (rho g A)); nothing is lost without drag.
test.each_accuracy("a crate heaves with the period of its waterplane", function(s, accuracy)
  local world = s.world
  world:water { level = 1 }
  local crate = world:box { size = { 1, 0.5, 0.8 }, density = 400, at = { 0, 1.1, 0 }, drag_coefficient = 0 }
  local w, worst = math.sqrt(g / (0.4 * 0.5)), 0
  for _ = 1, 600 do
    world:step()
    worst = math.max(worst, math.abs(crate.position.y - 1.05 - 0.05 * math.cos(w * world.time)))
  end
  expect(worst):below(({ sketch = 5e-4, play = 5e-8, study = 2e-8, reference = 1e-10 })[accuracy])
  expect(world.energy.numerical):near(0, 2e-5)
  expect(world.energy.lost):near(0, 1e-12)
end)

-- Swept, it keeps its energy, too; and no step is too long for a cork that the water would throw out at 1000 g.
scenario("a swept crate heaves without loss, and a cork stays on the water at any step", function(s)
  local world = s.world
  world:water { level = 1 }
  local crate = world:box { size = { 1, 0.5, 0.8 }, density = 400, at = { 0, 1.1, 0 }, drag_coefficient = 0, integrator = "verlet" }
  world:run(60)
  expect(world.energy.numerical):near(0, 1e-8)
  expect(crate.velocity.x):is(0.0)
  for _, step in ipairs { 1 / 240, 1 / 60, 1 / 15 } do
    for _, integrator in ipairs { "auto", "verlet" } do
      local pool = s:world { step = step }
      pool:water {}
      local cork = pool:ball { radius = 0.2, density = 1, at = { 0, -2, 0 }, integrator = integrator }
      pool:run(30)
      expect(cork.speed):below(0.5)
      expect(cork.position.y):near(0.2, 0.02)
    end
  end
end)

-- Metacentric height of a box b wide and d deep in the water: b^2 / (12 d) - (h - d) / 2.
scenario("a box stays upright when its metacentric height is positive, and turns flat when it is not", function(s)
  local function float(width, height)
    local world = s:world {}
    world:water { damping = 2 }
    local box = world:box { size = { width, height, 3 }, density = 500, at = { 0, 0, 0 },
                            rotation = digbox.quat { axis = { 0, 0, 1 }, angle = 0.02 } }
    world:run(40)
    return math.abs(box.rotation:rotate({ 0, 1, 0 }).y), box
  end
  -- d = h / 2: upright when b^2 / 6 > h^2 / 4, so b > 1.2247 h
  expect(float(1.26, 1)):near(1, 1e-6)
  expect((float(1.19, 1))):below(0.98)
  local flat, box = float(0.3, 1)
  expect(flat):near(0, 1e-6)                          -- lies on its broad side
  expect(box.position.y):near(0, 1e-6)
end)

-- Roll: period 2 pi sqrt(I / (rho g V GM)), for small angles.
scenario("a small roll has the period of the metacentric height", function(s)
  local world = s.world
  world:water {}
  local box = world:box { size = { 2, 0.5, 3 }, density = 400, at = { 0, 0.05, 0 }, drag_coefficient = 0,
                          rotation = digbox.quat { axis = { 0, 0, 1 }, angle = 0.001 } }
  local gm = 2 ^ 2 / (12 * 0.2) - (0.5 - 0.2) / 2
  local w = math.sqrt(g * gm / ((2 ^ 2 + 0.5 ^ 2) / 12))
  for _ = 1, 120 do
    world:step()
    expect(box.rotation:rotate({ 1, 0, 0 }).y):near(0.001 * math.cos(w * world.time), 2e-8)
  end
end)

scenario("what is denser than water sinks at its terminal speed, and a current carries what floats", function(s)
  local world = s.world
  world:water { current = { 0.5, 0, 0 } }
  local r = 0.05
  local iron = world:ball { radius = r, density = 7800, at = { 0, -1, 0 } }
  local log = world:cylinder { radius = 0.1, height = 1, density = 600, at = { 0, 0, 5 },
                               rotation = digbox.quat { axis = { 1, 0, 0 }, angle = math.pi / 2 } }
  world:run(60)
  expect(iron.velocity.y):near(-math.sqrt(2 * 6800 * 4 / 3 * r * g / (1000 * 0.47)), 1e-9)
  expect(iron.velocity.x):near(0.5, 1e-6)
  expect(log.velocity.x):near(0.5, 0.02)
  expect(log.position.y):between(-0.1, 0.1)
  expect(world.energy.work_in):above(0)
  expect(world.energy.numerical / world.energy.lost):near(0, 1e-6)
end)

scenario("a change of level wakes what floats, lifts it, and is booked as no work of the steps", function(s)
  local world = s.world
  world:floor {}
  world:water { level = 0.1, damping = 4 }
  local crate = world:box { size = { 0.5, 0.5, 0.5 }, density = 500, at = { 0, 0.25, 0 } }
  s:eventually("it sleeps aground", "5 s", function() return crate.asleep end)
  world:water { level = 2 }
  expect(crate.asleep):is(false)
  world:run(20)
  expect(crate.position.y):near(2, 1e-6)
  expect(world.energy.numerical / world.energy.lost):near(0, 1e-5)
  world:water(false)
  expect(world.energy.potential):near(125 / 2 * g * 2, 1e-3)
  world:run(5)
  expect(crate.position.y):near(0.25, 1e-3)
end)

-- Many at once are swept or advanced as a crowd.
scenario("a crowd of crates floats too", function(s)
  local world = s.world
  world:water { level = 0, damping = 3 }
  local crates = {}
  for i = 0, 80 do
    crates[#crates + 1] = world:box { size = { 0.4, 0.4, 0.4 }, density = 500,
                                      at = { (i % 9) * 0.42, 0.3 + 0.05 * (i % 4), i // 9 * 0.42 } }
  end
  world:run(20)
  local sum = 0
  for _, c in ipairs(crates) do
    sum = sum + c.position.y
    expect(c.speed):below(0.05)
  end
  expect(sum / #crates):near(0, 0.01)
end)

scenario("water and wind are kept: from a snapshot a world goes on with the same bits, on any number of threads", function(s)
  local function pond(threads)
    local world = s:world { threads = threads }
    world:air { wind = { 5, 0, 1 } }
    world:water { level = 0.5, current = { 0.1, 0, 0 }, damping = 1 }
    for i = 1, 12 do
      world:box { size = { 0.5, 0.3, 0.4 }, density = 300, at = { i % 4, 0.8 + 0.1 * i, i // 4 }, drag_area = i == 3 and 0.2 or nil }
    end
    return world
  end
  local world, other = pond(1), pond(3)
  world:run(1)
  local kept = world:snapshot()
  world:run(1)
  other:run(2)
  local sum = world:checksum()
  expect(other:checksum()):is(sum)
  world:water { level = 3 }
  world:air { wind = { -9, 0, 0 } }
  world:run(1)
  world:restore(kept)
  expect(world:effects().buoyancy.options.level):is(0.5)
  world:run(1)
  expect(world:checksum()):is(sum)
end)

-- The basin ends where its size says: beside it, nothing floats.
scenario("a basin has an end", function(s)
  local world = s.world
  world:floor {}
  world:water { level = 2, at = { 0, 1, 0 }, size = { 4, 2, 0 }, damping = 3 }
  local inside = world:box { size = { 0.4, 0.4, 0.4 }, density = 500, at = { 1, 1, 40 } }
  local beside = world:box { size = { 0.4, 0.4, 0.4 }, density = 500, at = { 5, 1, 0 } }
  world:run(10)
  expect(inside.position.y):near(2, 1e-3)
  expect(beside.position.y):near(0.2, 1e-3)
end)

scenario("wrong options are refused in one sentence at the script's line", function(s)
  local world = s.world
  expect(expect(function() world:water { levle = 1 } end):fails()):contains("world:water: unknown field 'levle'")
  expect(expect(function() world:water { level = "3 kg" } end):fails()):contains("world:water.level wants a length")
  expect(expect(function() world:water { density = -3 } end):fails()):contains("density = -3 kg/m^3")
  expect(expect(function() world:air { density = 0 / 0 } end):fails()):contains("density")
  expect(expect(function() world:ball { radius = 0.1, drag_coefficient = -1 } end):fails()):contains("drag_coefficient = -1")
  expect(world:effects().buoyancy.on):is(false)
end)

scenario("without water and air nothing is called and nothing is kept", function(s)
  local world = s.world
  world:ball { radius = 0.1, at = { 0, 3, 0 } }
  world:run(1)
  for _, name in ipairs { "drag", "buoyancy" } do
    local e = world:effects()[name]
    expect(e.on):is(false)
    expect(e.calls):is(0)
    expect(e.bytes):is(0)
  end
end)

scenario("the rim of a basin changes nothing: a crate that falls in keeps its books", function(s)
  local world = s:world { accuracy = "study" }
  world:water { level = 0.5, at = { 0, 0.25, 0 }, size = { 2, 0.5, 2 } }
  local crate = world:box { density = 500, size = 0.3, at = { 0, 0.9, 0 } }
  world:run(2)
  expect(crate.position.y):below(0.7)
  expect(world.energy.numerical):near(0, 1e-6)
end)
