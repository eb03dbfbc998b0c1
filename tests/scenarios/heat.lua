-- heat.lua: bodies warm and cool, conduct where they touch, and take up what friction and blows lose. T1, T2, ... are the cases of
-- the acceptance tables; T3 and T7 are in tests/unit/test_network.c.
-- Not in RENDER=0: physics alone.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local zero = 273.15                     -- K at 0 C

-- One thing alone in the air, with so much heat capacity (J/K) and h A (W/K).
local function thing(world, fields)
  local t = { radius = 0.1, mass = 1, heat_capacity = fields.capacity, surface = 1, convection = fields.hA, emissivity = fields.epsA,
              temperature = fields.celsius and fields.celsius + zero or fields.temperature, at = fields.at }
  return world:ball(t)
end

local function drift(world) return math.abs(world.energy.numerical) end

local function failure(fn)
  local ok, message = pcall(fn)
  expect(ok):is(false)
  return tostring(message)
end

scenario("T1 a mug of water cools", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local mug = thing(world, { capacity = 0.3 * 4186, hA = 1.5, celsius = 90 })
  world:ambient { temperature = "20 degC" }
  world:run(600)
  expect(mug.temperature - zero):near(54.18615, 0.02)
  expect(drift(world)):near(0, 1e-9 * 0.3 * 4186 * 70)
end)

-- The upper box lies on the lower one, which lies on a floor that takes no part.
local function pile(world, lower, upper)
  world:floor {}
  lower.size, lower.at, lower.mass = 0.2, { 0, 0.1, 0 }, 1
  upper.size, upper.at, upper.mass = 0.1, { 0, 0.25, 0 }, 1
  return world:box(lower), world:box(upper)
end

local function touch(s, accuracy)
  local world = s:world { accuracy = accuracy }
  local cold, hot = pile(world, { heat_capacity = 4186, temperature = 20 + zero, contact_conductance = 12 },
                         { heat_capacity = 450, temperature = 200 + zero })
  world:run(60)
  local at60 = { hot.temperature - zero, cold.temperature - zero }
  world:run(600)
  expect(drift(world)):near(0, 1e-9 * 450 * 180)
  expect(hot.temperature - zero):near(37.47196, 1e-3)
  expect(cold.temperature - zero):near(37.47196, 1e-3)
  expect(hot.asleep):is(true)           -- heat goes on while bodies sleep
  return at60
end

scenario("T2 two that touch meet, at play", function(s)
  local at60 = touch(s, "play")
  expect(at60[1]):near(65.10048, 0.1)
  expect(at60[2]):near(34.50186, 0.1)
end)

scenario("T2 two that touch meet, in a study", function(s)
  local at60 = touch(s, "study")
  expect(at60[1]):near(65.10048, 1e-3)
  expect(at60[2]):near(34.50186, 1e-3)
end)

local function cooker(s, on_it)
  local world = s.world
  world:ambient { temperature = "20 degC" }
  local ring, pan = pile(world, { heat_capacity = 600, surface = 1, convection = 1.2, temperature = 20 + zero, contact_conductance = 30 },
                         { heat_capacity = 6679, surface = 1, convection = 2, temperature = 20 + zero })
  if not on_it then pan:teleport { at = { 3, 0.05, 0 } } end
  world:heater { on = ring, power = "1.5 kW" }
  world:run(300)
  return world, ring, pan
end

scenario("T4 a ring heats the pan that stands on it", function(s)
  local world, ring, pan = cooker(s, true)
  expect(ring.temperature - zero):near(115.6647, 0.2)
  expect(pan.temperature - zero):near(72.9085, 0.2)
  local e = world.energy
  expect(e.work_in):near(450000, 450000 * 1e-9)
  expect(e.heat + e.lost):near(450000, 450000 * 1e-9)
  expect(e.heat):near(410774.6, 6679 * 0.2)
  expect(drift(world)):near(0, 450000 * 1e-9)
  while pan.temperature < 100 + zero do world:step() end
  expect(world.time):near(459.1425, 0.2)
  expect(ring.temperature - zero):near(141.9344, 0.2)
end)

scenario("T4, row 47: a pan beside the ring stays cold", function(s)
  local _, ring, pan = cooker(s, false)
  expect(ring.temperature - zero):near(583.985, 0.2)
  expect(pan.temperature - zero):near(20, 1e-9)
end)

scenario("T5 a body radiates", function(s)
  for ambient, want in pairs { [0] = 477.84145, [293.15] = 487.35305 } do
    local world = s:world { gravity = { 0, 0, 0 } }
    world:ambient { temperature = ambient }
    local body = thing(world, { capacity = 500, epsA = 0.04, temperature = 1000 })
    world:run(600)
    expect(body.temperature):near(want, 0.2)
    expect(drift(world)):near(0, 1e-9 * 500 * 1000)
  end
end)

-- Row 38: a bulb is hot in use, and after five minutes warm but not uncomfortable; taking it out of its socket changes nothing.
scenario("T6 a bulb cools down", function(s)
  for _, unscrewed in ipairs { false, true } do
    local world = s:world { gravity = { 0, 0, 0 } }
    world:ambient { temperature = "20 degC" }
    local bulb = world:ball { radius = "30 mm", material = "glass", mass = 0.03, heat_capacity = 840, convection = 8, emissivity = 0.9 }
    expect(bulb.surface):near(math.pi * 0.06 ^ 2, 1e-12)
    local lamp = world:heater { on = bulb, power = 45 }
    world:run(1200)
    expect(bulb.temperature - zero):near(211.762, 0.01)
    lamp:off()
    world:run(10)
    if unscrewed then bulb:teleport { at = { 1, 0, 0 } } end
    local now, curve = 10, { { 60, 136.124 }, { 120, 95.092 }, { 300, 43.405 } }
    for _, point in ipairs(curve) do
      world:run(point[1] - now)
      now = point[1]
      expect(bulb.temperature - zero):near(point[2], 0.5)
    end
  end
end)

scenario("T8 a thermostat switches a heater", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  world:ambient { temperature = "5 degC" }
  local room = thing(world, { capacity = 50e3, hA = 20, celsius = 19 })
  local heater, switched = world:heater { on = room, power = "1 kW" }, {}
  while #switched < 4 do
    world:step()
    local celsius = room.temperature - zero
    if heater.running and celsius >= 21 or not heater.running and celsius <= 19 then
      if heater.running then heater:off() else heater:on() end
      switched[#switched + 1] = world.time
    end
  end
  local off, on = switched[2] - switched[1], switched[3] - switched[2]
  expect(switched[1]):near(142.896, 1)
  expect(on):near(142.896, 1)
  expect(off):near(333.828, 1)
  expect(on / (on + off)):near(0.299746, 1e-3)
end)

-- W that go from a hot box of steel into the plate under it, at rest.
local function flow_under(s, mass, size)
  local world = s:world {}
  local plate = world:box { fixed = true, size = { 1, 0.1, 1 }, at = { 0, -0.05, 0 }, material = "steel", temperature = 300 }
  local box = world:box { size = size, at = { 0, size[2] / 2, 0 }, mass = mass, material = "steel", temperature = 300, heat_capacity = 1e9 }
  world:run(1)
  box:warm { to = 400 }
  local before = 490 * 785 * plate.temperature
  world:run(1)
  return 490 * 785 * plate.temperature - before
end

scenario("T9 what presses more conducts better", function(s)
  local once = flow_under(s, 1, { 0.2, 0.1, 0.1 })
  expect(once):near(1.25 * 45 * 1e5 * 0.02 * (9.81 / 0.02 / 1e8) ^ 0.95 * 100, 1e-4 * once)
  expect(flow_under(s, 2, { 0.2, 0.1, 0.1 }) / once):near(1.931873, 1e-5)
  expect(flow_under(s, 1, { 0.1, 0.1, 0.1 }) / once):near(0.965936, 1e-5)
end)

scenario("T10 a kettle boils", function(s)
  for hA, want in pairs { [0] = 177.905, [1.5] = 183.1191 } do
    local world = s:world { gravity = { 0, 0, 0 } }
    world:ambient { temperature = "20 degC" }
    local kettle = thing(world, { capacity = 4186, hA = hA, celsius = 15 })
    world:heater { on = kettle, power = "2 kW" }
    while kettle.temperature < 100 + zero do world:step() end
    expect(world.time):near(want, 0.2)
  end
end)

scenario("T12 a cold scene has no heat", function(s)
  local world = s.world
  world:floor {}
  world:box { size = 1, at = { 0, 0.5, 0 }, velocity = { 1, 0, 0 } }
  world:run(1)
  local heat = world:effects().heat
  expect(heat.on):is(false)
  expect(heat.bytes):is(0)
  expect(heat.calls):is(0)
  expect(heat.bodies):is(0)
  expect(world.energy.heat):is(0)
end)

-- ---- friction and blows ----

-- A box of 2 kg slides from 3 m/s to rest on a plate: 9 J, into the two.
local function brake(s, fields, count)
  local world = s:world { accuracy = fields.accuracy }
  local plate = world:box { fixed = true, size = { 8, 0.1, 8 }, at = { 0, -0.05, 0 }, material = "steel", temperature = fields.plate }
  local boxes = {}
  for i = 1, count do
    boxes[i] = world:box { size = 0.1, at = { 0, 0.05, 0.2 * i - 3 }, mass = 2, material = "steel", velocity = { 3, 0, 0 },
                           temperature = fields.box }
  end
  world:run(2)
  expect(boxes[1].speed):is(0)
  return world, plate, boxes
end

scenario("C6 friction heats both: 9 J", function(s)
  for _, accuracy in ipairs { "sketch", "play", "study" } do
    local world = brake(s, { accuracy = accuracy, plate = 300, box = 300 }, 1)
    expect(world.energy.heat):near(9, 1e-6)
    expect(world.energy.lost):near(0, 1e-6)
    expect(drift(world)):near(0, 1e-6)
  end
end)

scenario("C6 in a row, and in a crowd: 9 J each", function(s)
  expect(brake(s, { plate = 300, box = 300 }, 24).energy.heat):near(24 * 9, 24 * 1e-4)
  local crowd = s:world {}
  local boxes, plate = {}, crowd:box { fixed = true, size = { 40, 0.1, 40 }, at = { 0, -0.05, 0 }, material = "steel", restitution = 0,
                                       temperature = 300 }
  for i = 1, 100 do
    boxes[i] = crowd:box { size = 0.1, at = { i % 10 * 0.1, 0.05, i // 10 * 0.1 }, mass = 2, material = "steel", restitution = 0,
                            velocity = { 3, 0, 0 } }
  end
  crowd:run(2)
  local e, share = crowd.energy, math.sqrt(7850) / (math.sqrt(7850) + math.sqrt(2000))
  expect(boxes[50].speed):near(0, 1e-6)
  expect((e.heat + e.lost) / 900):near(1, 1e-3)
  expect(e.heat / (e.heat + e.lost)):near(share, 1e-3)            -- but for what box loses to box
  expect(plate.temperature > 300):is(true)
end)

scenario("what takes no part takes no heat: its share stays lost", function(s)
  local world = brake(s, { box = 300 }, 1)
  local e = world.energy
  expect(e.heat + e.lost):near(9, 1e-6)
  -- by sqrt(density), conductivity and heat capacity being those of steel
  expect(e.heat / e.lost):near(math.sqrt(2000 / 7850), 1e-6)
end)

scenario("a ball that bounces to rest has warmed itself and the floor", function(s)
  for _, accuracy in ipairs { "sketch", "play", "study" } do
    local world = s:world { accuracy = accuracy }
    world:floor { material = "steel", restitution = 0.5 }
    local ball = world:ball { radius = 0.05, at = { 0, 1.05, 0 }, mass = 1, material = "steel", restitution = 0.5, temperature = 300 }
    world:run(5)
    local e, density = world.energy, 1 / (4 / 3 * math.pi * 0.05 ^ 3)
    expect(e.heat + e.lost):near(9.81, 0.02)                        -- it lies a little deeper than it touched
    expect(e.heat / e.lost):near(math.sqrt(density / 7850), 1e-6)
    expect(ball.temperature):near(300 + e.heat / 490, 1e-9)
  end
end)

-- ---- contacts come and go ----

scenario("heat goes over while two touch, and no longer", function(s)
  local world = s:world {}
  world:floor {}
  local plate = world:box { fixed = true, size = { 1, 0.2, 1 }, at = { 0, 0.1, 0 }, material = "steel", temperature = 400 }
  local box = world:box { size = 0.1, at = { 0, 0.7, 0 }, mass = 1, heat_capacity = 500, restitution = 0, temperature = 300,
                          contact_conductance = 5 }
  local falls, warm = math.sqrt(2 * 0.45 / 9.81), 9.81 * 0.45 / 500       -- warm: at most, by the blow
  world:run(falls - 0.02)
  expect(box.temperature):near(300, 1e-9)
  while not box:touches(plate) do world:step() end
  expect(box.temperature):near(300 + 100 * 5 * 0.2 / 500, 100 * 5 * 0.2 / 500 + warm)      -- it hops for 0.4 s at most
  world:run(30)
  local want = 400 - 100 * math.exp(-5 * 30 / 500)
  expect(box.temperature):near(want, 0.3 + warm)
  box:teleport { at = { 3, 0.05, 0 } }                  -- lifted off, onto a floor that takes no part
  world:step()
  local left = box.temperature
  world:run(30)
  expect(box.temperature):near(left, 1e-9)
  expect(drift(world)):near(0, 1e-6)
end)

scenario("a plane with a temperature keeps it, and takes what flows in", function(s)
  local world = s:world {}
  local floor = world:floor { temperature = 280 }
  local box = world:box { size = 0.1, at = { 0, 0.05, 0 }, mass = 1, heat_capacity = 500, temperature = 380, contact_conductance = 5 }
  world:run(60)
  expect(floor.temperature):is(280)
  expect(box.temperature):near(280 + 100 * math.exp(-5 * 60 / 500), 0.05)
  local e = world.energy
  expect(e.heat):near(500 * (box.temperature - 380), 1e-9 * 500 * 380)
  expect(e.heat + e.lost):near(0, 1e-6)
  expect(function() floor:warm { energy = 1 } end):fails()
  floor:warm { to = 300 }
  expect(floor.temperature):is(300)
end)

scenario("a moving belt heats what it rubs", function(s)
  local world = s:world {}
  local belt = world:box { kinematic = true, size = { 20, 0.1, 1 }, at = { 0, -0.05, 0 }, material = "steel", friction = 0.5,
                           temperature = 300 }
  local wall = world:box { fixed = true, size = { 0.1, 0.4, 1 }, at = { 0.101, 0.25, 0 }, friction = 0 }
  world:box { size = 0.1, at = { 0, 0.05, 0 }, mass = 2, material = "steel", friction = 0.5, temperature = 300 }
  belt:move_to { at = { 4, -0.05, 0 }, over = 4 }
  world:run(4)
  expect(wall.valid):is(true)
  local e = world.energy
  expect(e.work_in):near(0.5 * 2 * 9.81 * 4, 0.02)       -- but for the first 2 mm
  expect(e.heat + e.lost):near(e.work_in, 1e-6)
  expect(e.heat):near(e.work_in, 0.02)
end)

scenario("eighty that touch are iterated, and even out", function(s)
  local world = s:world {}
  world:floor {}
  local sum, boxes = 0, {}
  for i = 0, 79 do
    boxes[i + 1] = world:box { size = 0.1, at = { i % 10 * 0.1, 0.05, i // 10 * 0.1 }, mass = 1, heat_capacity = 10, restitution = 0,
                               temperature = 300 + i, contact_conductance = 50 }
    sum = sum + 300 + i
  end
  world:run(60)
  for _, box in ipairs(boxes) do expect(box.temperature):near(sum / 80, 0.1) end
  expect(drift(world)):near(0, 1e-6)
end)

-- ---- as part of a world ----

local function mixture(s, threads)
  local world = s:world { threads = threads, seed = 3 }
  world:ambient { temperature = 280 }
  world:box { fixed = true, size = { 4, 0.2, 4 }, at = { 0, -0.1, 0 }, material = "stone", temperature = 500, convection = 10,
              emissivity = 0.9 }
  for i = 1, 12 do
    world:box { size = 0.3, at = { i % 4 * 0.8 - 1.2, 0.4 + 0.5 * (i // 4), i % 3 * 0.8 - 0.8 }, material = "iron",
                temperature = 300 + i, convection = 5, emissivity = 0.5, velocity = { i % 3 - 1, 0, 0 } }
  end
  return world
end

scenario("bit by bit the same with any number of threads, after a snapshot, and from a file", function(s)
  local one, four = mixture(s, 1), mixture(s, 4)
  one:run(1)
  four:run(1)
  expect(four:checksum()):is(one:checksum())
  local snapshot = one:snapshot()
  one:run(1)
  local sum = one:checksum()
  one:restore(snapshot)
  one:run(1)
  expect(one:checksum()):is(sum)
  four:save("heat.dig")
  local loaded = digbox.load("heat.dig")
  loaded:run(1)
  expect(loaded:checksum()):is(sum)
end)

scenario("bodies may go, and the books stay closed", function(s)
  local world = mixture(s, 1)
  world:run(0.5)
  for i, body in ipairs(world:bodies()) do
    if i % 3 == 0 then body:remove() end
  end
  world:run(0.5)
  world:effect("heat", false)
  world:run(0.2)
  world:effect("heat", true)
  world:run(0.2)
  expect(drift(world)):near(0, 1e-6 * math.abs(world.energy.heat))
end)

scenario("a temperature is warmed, not assigned", function(s)
  local world = s.world
  local body = world:ball { radius = 0.1, mass = 2, heat_capacity = 500, temperature = 300 }
  expect(failure(function() body.temperature = 400 end):find("use body:warm{to = 400}", 1, true)):is_not(nil)
  expect(body.temperature):is(300)
  world:step()
  body:warm { energy = "5 kJ" }
  expect(body.temperature):near(305, 1e-12)
  expect(world.energy.work_in):near(5000, 1e-9)
  body:warm { to = 400 }
  expect(world.energy.work_in):near(1e5, 1e-9)
  expect(drift(world)):near(0, 1e-9)
  expect(function() body:warm { to = -1 } end):fails()
  expect(function() body:warm {} end):fails()
  expect(function() world:ball { radius = 0.1 }:warm { energy = 1 } end):fails()
  expect(function() world:heater { on = 3, power = 2 } end):fails()
  expect(function() body.emissivity = 1.5 end):fails()
  local heater = world:heater { on = body, power = 10 }
  local second = world:heater { on = body, power = 5 }
  heater.power = "2 kW"
  expect(body.heating):is(2005)
  heater:off()
  expect(body.heating):is(5)
  expect(second.running):is(true)
  expect(failure(function() heater:of() end):find("did you mean 'off'", 1, true)):is_not(nil)
end)

-- 450 J/K at 200 C on 4186 J/K at 20 C with 12 W/K: after 60 s 65.10048 C (T2); with a factor c on the conductance the same at 60 s / c.
scenario("where a region conducts better, touching bodies share their heat sooner", function(s)
  for _, conduct in ipairs { 1, 3, 0 } do
    local world = s:world { accuracy = "study" }
    world:floor {}
    local low = world:box { size = 0.2, at = { 0, 0.1, 0 }, mass = 4.186, heat_capacity = 1000, temperature = 293.15,
      contact_conductance = 12 }
    local high = world:box { size = 0.2, at = { 0, 0.3, 0 }, mass = 0.45, heat_capacity = 1000, temperature = 473.15 }
    world:region { box = { size = 2 }, laws = { conduct = conduct } }
    world:run(0.5)
    local start = conduct > 0 and 0.5 or 0
    world:run(60 / math.max(1, conduct) - start)
    if conduct == 0 then
      expect(high.temperature):near(473.15, 1e-9)
    else
      expect(high.temperature - 273.15):near(65.10048, 0.1)
      expect(low.temperature - 273.15):near(34.50186, 0.02)
    end
  end
end)

scenario("heaters go back with the world to a snapshot", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local plate = world:box { size = 0.1, temperature = 300 }
  local heater = world:heater { on = plate, power = 1000 }
  heater:off()
  local cold = world:snapshot()
  heater.power = 500
  heater:on()
  local warm = world:snapshot()
  local second = world:heater { on = plate, power = 70 }
  expect(plate.heating):is(570)
  world:restore(cold)
  expect(heater.running):is(false)
  expect(heater.power):is(1000)
  expect(second.running):is(false)
  heater:off()
  expect(plate.heating):is(0)
  second:on()
  expect(plate.heating):is(70)
  world:restore(warm)
  expect(heater.running):is(true)
  heater:off()
  expect(plate.heating):is(0)
  plate:remove()
  expect(heater.running):is(false)
end)

scenario("nothing gets colder than 0 K or hotter than can be, and the books stay closed", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local cold = world:box { size = 0.1, at = { 0, 0, 0 }, temperature = 300, heating = -1e6 }
  local hot = world:box { size = 0.1, at = { 1, 0, 0 }, temperature = 300, heating = 1e12 }
  world:run(1)
  expect(cold.temperature):between(0, 1e-6)
  expect(hot.temperature):between(1e7 - 1, 1e7)
  expect(drift(world)):near(0, 1e-9 * world.energy.heat)
  world:save("limits.dig")
  expect(digbox.load("limits.dig"):checksum()):is(world:checksum())
  cold.heating = 100
  world:run(1)
  expect(cold.temperature):above(0.01)
end)

scenario("a body whose mass changes has another heat capacity", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local b = world:box { size = 0.1, mass = 1, heat_capacity = 500, temperature = 300, heating = 100 }
  world:run(1)
  expect(b.temperature):near(300.2, 1e-9)
  b.mass = 10
  expect(b.temperature):near(300.2, 1e-9)
  world:run(1)
  expect(b.temperature):near(300.22, 1e-9)
  b.density = 100
  world:run(1)
  expect(b.temperature):near(302.22, 1e-9)         -- 0.1 kg
  expect(drift(world)):near(0, 1e-9)
end)

-- ---- what swells as it warms ----

-- A blob that is 0.4 % heavier than the water at 25 C, both at `celsius`, deep under the surface
local function blob(s, celsius)
  local world = s:world {}
  world:ambient { temperature = celsius + zero }
  world:water { level = 1, density = 1000, expansion = 0.21e-3, expansion_from = 25 + zero, viscosity = 0.01 }
  return world, world:ball { radius = 0.02, at = { 0, 0.5, 0 }, density = 1004, expansion = 0.8e-3, expansion_from = 25 + zero,
                             temperature = celsius + zero }
end

scenario("T11 a blob rises from 6.78 K above neutral on, and sinks below", function(s)
  for _, case in ipairs { { 6.70, -1 }, { 6.86, 1 } } do
    local world, ball = blob(s, 25 + case[1])
    world:run(2)
    expect(case[2] * ball.velocity.y):above(1e-5)
    expect(drift(world)):near(0, 1e-9)
  end
end)

scenario("T11 it rises at Stokes' speed: 19.61 mm/s", function(s)
  local world = s:world { gravity = { 0, -9.80665, 0 } }
  world:water { level = 1, density = 1000, viscosity = 0.01 }
  local ball = world:ball { radius = 0.003, at = { 0, 0.1, 0 }, density = 990, drag_coefficient = 0 }
  world:run(10)
  expect(ball.velocity.y):near(2 / 9 * 10 * 9.80665 * 0.003 ^ 2 / 0.01, 1e-6)
  expect(drift(world)):near(0, 1e-9)
end)

scenario("what is warmed under water swells, and lifts water: the books stay closed", function(s)
  local world, ball = blob(s, 20)
  world:floor { at = { 0, 0.4, 0 } }
  world:run(5)
  expect(ball.asleep):is(true)
  ball.heating = 100
  world:run(5)
  expect(ball.velocity.y):above(1e-3)                      -- it woke as it began to float
  expect(drift(world)):near(0, 1e-7)
  expect(world.energy.work_in):near(500, 1e-6)
end)

scenario("the air may be colder higher up", function(s)
  local world = s:world { gravity = { 0, -9.81, 0 } }
  world:ambient { temperature = 300, gradient = -0.5 }
  local low = world:box { size = 0.1, at = { 0, 0, 0 }, fixed = true, temperature = 280, convection = 1e4, material = "wood" }
  local high = world:box { size = 0.1, at = { 0, 40, 0 }, fixed = true, temperature = 280, convection = 1e4, material = "wood" }
  world:run(200)
  expect(low.temperature):near(300, 1e-3)
  expect(high.temperature):near(280, 1e-9)
  expect(drift(world)):near(0, 1e-6)
end)

scenario("a body that changes its material has the new one's heat capacity, unless it says its own", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local plain = world:box { size = 0.1, material = "steel", temperature = 300 }
  local own = world:box { size = 0.1, at = { 1, 0, 0 }, material = "steel", temperature = 300, heat_capacity = 123 }
  expect(plain.heat_capacity):near(490, 1e-9)
  plain.material, own.material = "wood", "wood"
  expect(plain.heat_capacity):above(1000)
  expect(plain.temperature):near(300, 1e-9)
  expect(own.heat_capacity):is(123)
  plain.heating = 100
  local mass = plain.mass
  world:run(1)
  expect(plain.temperature):near(300 + 100 / (mass * plain.heat_capacity), 1e-9)
  expect(drift(world)):near(0, 1e-9)
end)

-- A wheel that friction in its hinge stops, and a weight on a spring with a damper, each on a fixed post: what they lose
local function joints_lose(s, fields, add)
  local world = s:world(fields)
  local post = world:box { size = 0.1, fixed = true, at = { 0, 0, 0 }, temperature = 300, material = "steel" }
  local body, lost = add(world, post)
  world:run(4)
  local half = world.energy.heat / 2
  expect(world.energy.heat):near(lost, 1e-3 * lost)
  expect((body.temperature - 300) * body.mass * body.heat_capacity):near(half, 1e-6 * lost)
  expect(drift(world)):near(0, 1e-3 * lost)
end

for _, accuracy in ipairs { "sketch", "play", "study" } do
  scenario("what a hinge's friction takes warms both its bodies, at " .. accuracy, function(s)
    joints_lose(s, { gravity = { 0, 0, 0 }, accuracy = accuracy }, function(world, post)
      local wheel = world:cylinder { radius = 0.2, height = 0.05, mass = 2, at = { 0, 0, 0.2 }, spin = { 0, 10, 0 }, temperature = 300 }
      world:hinge { a = wheel, b = post, at = { 0, 0, 0.2 }, axis = { 0, 1, 0 }, friction = 0.2 }
      return wheel, 0.5 * (0.5 * 2 * 0.2 ^ 2) * 10 ^ 2
    end)
  end)

  scenario("what a strut damps warms both its bodies, at " .. accuracy, function(s)
    joints_lose(s, { gravity = { 0, 0, 0 }, accuracy = accuracy }, function(world, post)
      local weight = world:ball { radius = 0.05, mass = 1, at = { 1, 0, 0 }, velocity = { 2, 0, 0 }, temperature = 300 }
      world:strut { a = weight, b = post, at_b = { 0, 0, 0 }, stiffness = 100, damping = 10, length = 1 }
      return weight, 2
    end)
  end)
end
