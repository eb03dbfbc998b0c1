-- soft_bodies.lua: cloth, ropes and lattices made of particles; a table with a sawn leg; the graph inside a body.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local g = 9.81

for _, pins in ipairs { "top", "two corners" } do
  scenario(("row 70: a cloth hangs by its %s: its pins bear its weight, and it stretches by less than 2 %%"):format(pins), function(s)
    local world = s.world
    local c = world:cloth { at = { 0, 2, 0 }, across = { 1, 0, 0 }, down = { 0, -1, 0 }, columns = 8, rows = 8, mass = 0.4, stiffness = 400,
      relaxation = 0.1, pins = pins == "top" and "top" or { { 1, 1 }, { 8, 1 } } }
    world:run(5)
    local w = 0.4 * g                                   -- of all of it: its pins bear themselves, too
    expect(c.mass):near(0.4 * (64 - (pins == "top" and 8 or 2)) / 64, 1e-9)         -- of all that moves
    expect(c.support):near({ 0, w, 0 }, 0.001 * w)
    expect(c.stretch):between(1e-6, 0.02)
    expect(c:node(4, 8).position.y):near(1, 0.03)
  end)
end

scenario("the sheets of cloths are no sheets of the script", function(s)
  local world = s.world
  local fields = { at = { 0, 2, 0 }, across = { 1, 0, 0 }, down = { 0, -1, 0 }, columns = 2, rows = 2, mass = 0.4, stiffness = 400 }
  local one, two = world:cloth(fields), world:cloth(fields)
  expect(one:node(2, 1).sheet.x):above(1e6)
  expect(one:node(2, 1).sheet.y):is(2)
  expect(two:node(1, 1).sheet.x):is_not(one:node(1, 1).sheet.x)
  world:save "sheets.dig"
  local again = digbox.load "sheets.dig"
  local three = again:cloth(fields)
  expect(three:node(1, 1).sheet.x):is_not(one:node(1, 1).sheet.x)
  expect(three:node(1, 1).sheet.x):is_not(two:node(1, 1).sheet.x)
end)

scenario("a thread that bears too much tears where it was cut, and the cloth is two DIGs", function(s)
  local world = s.world
  local c = world:cloth { at = { 0, 2, 0 }, across = { 0.1, 0, 0 }, down = { 0, -1, 0 }, columns = 2, rows = 6, mass = 0.6,
    stiffness = 2000, shear = 0, relaxation = 0.05, breaks_at = 4, pins = { { 1, 1 }, { 2, 1 } } }
  world:run(2)
  expect(c.broken):is(0)
  expect(c.stress):near(c.mass * g / 2 / 4, 0.01)
  local weight = c.mass * g
  for x = 0, 0.1, 0.1 do c:saw { at = { x, 1.5, 0 }, depth = 0.7 * 0.3 * 0.25 * 0.1 } end       -- of their thickness
  s:eventually("torn", "2 s", function() return c.broken == 2 end)
  expect(c:node(1, 3).dig ~= c:node(1, 4).dig):is(true)
  expect(c:node(1, 2).dig == c:node(2, 3).dig):is(true)
  expect(#c:sig()):is(#c.joints - 2)
  world:run(3)
  expect(c.support.y):below(0.5 * weight + 2 * 0.05 * g)                          -- and the two pins of 0.05 kg
end)

local function sinh(x) return (math.exp(x) - math.exp(-x)) / 2 end
local function cosh(x) return (math.exp(x) + math.exp(-x)) / 2 end

-- Catenary of 2 m between two posts 1.6 m apart: s = 2 a sinh(d / 2 a)
local function catenary()
  local lo, hi = 0.1, 10
  for _ = 1, 100 do
    local a = (lo + hi) / 2
    if 2 * a * sinh(0.8 / a) > 2 then lo = a else hi = a end
  end
  return lo
end

-- A rope of 2 m and 10 kg there, in twenty pieces
local function rope(world)
  local nodes, struts, n, a = {}, {}, 20, catenary()
  for i = 0, n do
    local x = a * math.log((2 * i / n - 1) / a + math.sqrt(((2 * i / n - 1) / a) ^ 2 + 1))      -- arc from the middle: a sinh(x / a)
    nodes[("%02d"):format(i)] = { at = { 0.8 + x, a * (cosh(x / a) - cosh(0.8 / a)), 0 }, mass = 10 / n, fixed = (i == 0 or i == n) or nil }
    if i > 0 then struts[i] = { ("%02d"):format(i - 1), ("%02d"):format(i), length = 2 / n } end
  end
  return world:truss { name = "rope", nodes = nodes, struts = struts, stiffness = 1e5, relaxation = 0.1, radius = 0.01 }
end

scenario("S8: a rope hangs as a catenary, and its posts bear its weight", function(s)
  local world = s.world
  local t = rope(world)
  world:run(4)
  local w, sum, count, a = 9.5 * g, 0, 240, catenary()  -- nineteen of the particles hang
  for _ = 1, count do
    world:step()
    sum = sum + t:strut "0001".force:dot { 0, 1, 0 } * (t:strut "0001".a.fixed and -1 or 1)
    sum = sum + t:strut "1920".force:dot { 0, 1, 0 } * (t:strut "1920".a.fixed and -1 or 1)
  end
  expect(sum / count):near(w, 1e-3 * w)
  expect(-t:node("10").position.y):near(a * (cosh(0.8 / a) - 1), 0.005)
end)

scenario("S8: cut, it is two DIGs, and no momentum is made", function(s)
  local world = s.world
  local t = rope(world)
  world:run(1)
  local before, digs = world.momentum, #world:digs()
  t:cut("10", "11")
  expect(#(world.momentum - before)):below(1e-12)
  expect(#world:digs()):is(digs + 1)
  expect(t:node("05").dig ~= t:node("15").dig):is(true)
  world:step()
  expect(#(world.momentum - before)):below(1)           -- gravity and the posts go on
end)

scenario("what snaps in free flight keeps its momentum, and its elastic energy is lost as heat and sound", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local p = world:plank { from = { 0, 0, 0 }, to = { 1, 0, 0 }, width = 0.1, height = 0.02, E = 10e9, strength = 40e6, density = 500,
    segments = 8, relaxation = 0 }
  p.bodies[1]:hit { impulse = { 0, 20, 0 } }
  p.bodies[8]:hit { impulse = { 0, 20, 0 } }
  p.bodies[4]:hit { impulse = { 0, -40, 0 } }
  local before, turning = world.momentum, world.angular_momentum
  s:eventually("snapped", "0.2 s", function() return p.broken > 0 end)
  expect(#(world.momentum - before)):below(1e-12)
  expect(#(world.angular_momentum - turning)):below(1e-9)
  expect(world.energy.lost):above(0)
  expect(math.abs(world.energy.numerical)):below(1e-6 * world.energy.initial)
end)

-- A table of 1 x 1 m on four legs of 40 x 40 mm that stand a little apart, clamped to the top. On ice, the floor's friction does not hold
-- their feet: on concrete it would, and a leg broken across its whole face goes on bearing, half upon half, as a column does.
local function table_on_legs(world)
  world:floor { material = "ice" }
  local top = world:box { name = "top", size = { 1, 0.04, 1 }, mass = 10, at = { 0, 0.72, 0 }, material = "wood" }
  local legs = {}
  for i, at in ipairs { { -0.45, -0.45 }, { 0.45, -0.45 }, { -0.45, 0.45 }, { 0.45, 0.45 } } do
    legs[i] = world:plank { name = "leg " .. i, material = "wood", from = { 1.25 * at[1], 0, 1.25 * at[2] }, to = { at[1], 0.7, at[2] },
      width = 0.04, height = 0.04, up = { 1, 0, 0 }, segments = 2, to_end = "clamped", to_body = top, strength = 20e6, relaxation = 0.005 }
  end
  local cup = world:cylinder { name = "cup", radius = 0.03, height = 0.1, mass = 0.2, at = { 0.3, 0.79, 0.3 }, material = "glass" }
  world:box { name = "load", size = { 0.2, 0.2, 0.2 }, mass = 80, at = { -0.38, 0.84, -0.38 }, material = "stone" }
  return legs, cup
end

scenario("S9: a leg under 80 kg is sawn until N / A (1 - cut) + M / Z exceeds its strength; the table tips, and the cup falls", function(s)
  local world = s.world
  local legs, cup = table_on_legs(world)
  local joint = legs[1].joints[1]
  local event, more
  world:on("broken", function(e) event = event or e end)
  local function run(frames)
    for _ = 1, frames do
      local digs = #world:digs()
      world:step()
      if event and not more then more = #world:digs() - digs end
    end
  end
  run(60)
  expect(legs[1].broken):is(0)
  expect(cup.position.y):above(0.75)
  while not event and joint.cut < 0.99 do
    local cut = joint.cut
    -- what the joint bears, from its force and torque
    local axis = joint.b.rotation:rotate { 1, 0, 0 }
    local up, side = joint.b.rotation:rotate { 0, 1, 0 }, joint.b.rotation:rotate { 0, 0, 1 }
    local left = 0.04 * (1 - cut)
    local stress = math.abs(joint.force:dot(axis)) / (0.04 * left) + math.abs(joint.torque:dot(side)) / (0.04 * left ^ 2 / 6) +
      math.abs(joint.torque:dot(up)) / (left * 0.04 ^ 2 / 6)
    expect(joint.stress):near(stress / 20e6, 1e-9)
    expect(stress):below(20e6)
    legs[1]:saw { at = legs[1].length / 2, depth = 0.001 }
    run(20)
  end
  expect(event.joint.name):is "leg 1 joint 1"
  expect(event.stress):above(1)
  expect(more):is(1)
  run(180)
  expect(cup.position.y):below(0.7)
end)

scenario("row 69: a lattice that was stretched comes back to its shape", function(s)
  local world = s:world { gravity = { 0, 0, 0 }, sleeping = false }      -- what creeps by less than 2 mm/s would fall asleep
  local l = world:lattice { at = { 0, 0, 0 }, size = 0.6, cells = 2, mass = 2, stiffness = 500, relaxation = 0.3 }
  local function width() return l:node(3, 2, 2).position.x - l:node(1, 2, 2).position.x end
  for j = 1, 3 do
    for k = 1, 3 do
      l:node(1, j, k):push { force = { -8, 0, 0 }, lasts = 3 }
      l:node(3, j, k):push { force = { 8, 0, 0 }, lasts = 3 }
    end
  end
  world:run(3)
  local stretched = width() - 0.6
  expect(stretched):above(0.005)
  world:run(0.3)
  expect(width() - 0.6):near(stretched * math.exp(-1), 0.05 * stretched)
  world:run(3)
  expect(width()):near(0.6, 0.001 * stretched)
  expect(#(l.position)):below(1e-9)
end)

scenario("row 73: the graph inside a body is that of its joints, not of what it touches", function(s)
  local world = s:world {}
  world:floor {}
  local p = world:plank { name = "plank", material = "oak", from = { 0, 0.5, 0 }, to = { 1, 0.5, 0 }, width = 0.1,
    height = 0.02, segments = 4 }
  local box = world:box { size = 0.1, at = { 0.5, 0.56, 0 } }
  world:run(1)
  local sig = p.bodies[1]:sig()
  expect(#sig):is(3)
  expect(#p:sig()):is(3)
  expect(#box:sig()):is(0)
  expect(sig[1].strength):is(50e6)
  expect(sig[1].rest_length):near(1 / 4 * 4 / 3, 1e-12)
  expect(sig[1].cut):is(0)
  expect(p.bodies[1].dig == p.bodies[4].dig):is(true)
  p:saw { at = 0.5, depth = "5 mm" }
  expect(p:sig()[2].cut):near(0.25, 1e-12)
  expect(#p:sig()):is(3)                                -- weaker, but whole
  p:saw { at = 0.5, depth = "20 mm" }
  expect(#p:sig()):is(2)
  expect(#p.bodies[1]:sig()):is(1)
  expect(#p.bodies[4]:sig()):is(1)
  expect(p.broken):is(1)
end)

scenario("what is wrong with a soft thing is said in its words, and nothing is left of it", function(s)
  local world = s.world
  local post = world:box { size = 0.1, fixed = true }
  local before = #world:bodies()
  local function refused(make, fields, change, message)
    for k, v in pairs(change) do fields[k] = v end
    local fine, why = pcall(world[make], world, fields)
    expect(fine):is(false)
    expect(tostring(why)):contains(message)
    expect(#world:bodies()):is(before)
  end
  local function plank(change, message)
    refused("plank", { from = { 0, 1, 0 }, to = { 1, 1, 0 }, width = 0.1, height = 0.02, material = "oak" }, change, message)
  end
  plank({ mass = "-2 kg" }, "world:plank: mass = -2 kg, must be > 0")
  plank({ relaxation = -1 }, "relaxation = -1 s, must be >= 0")
  plank({ material = "cheese" }, "unknown material 'cheese' (known: ")
  plank({ at = { 0, 1, 0 } }, "world:plank: at is no field of it: give from and to")
  plank({ from_end = "pinned", from_body = 5 }, "world:plank.from_body wants a body; got number")
  plank({ to_body = post }, "world:plank: to_body holds no free end: give to_end")
  local function cloth(change, message)
    refused("cloth", { at = { 0, 2, 0 }, across = { 1, 0, 0 }, down = { 0, -1, 0 }, columns = 3, rows = 3, mass = 1,
      stiffness = 100 }, change, message)
  end
  cloth({ down = { 1, 0, 0 } }, "which is no length for a strut")
  cloth({ fixed = true }, "world:cloth: fixed is no field of it")
  local function lattice(change, message)
    refused("lattice", { at = { 0, 2, 0 }, size = 0.5, mass = 1, stiffness = 100 }, change, message)
  end
  lattice({ relaxation = -1 }, "relaxation = -1 s, must be >= 0")
  lattice({ cells = 0 }, "world:lattice.cells = 0, must be at least 1")
  lattice({ size = "5 kg" }, "world:lattice.size wants a length; '5 kg' is a mass")
  local function truss(struts, change, message)
    refused("truss", { nodes = { A = { at = { 0, 0, 0 } }, AB = { at = { 1, 0, 0 } }, B = { at = { 0, 1, 0 } }, BB = { at = { 1, 1, 0 } } },
      struts = struts, stiffness = 1e4 }, change, message)
  end
  truss({ { "A", "BB" }, { "AB", "B" } }, {}, "world:truss.struts[2]: there is a strut 'ABB' already")
  truss({ { "A", "A" } }, {}, "world:truss.struts[1]: a strut from node 'A' to itself")
  truss({ { "A", "B" } }, { price = -1 }, "price = -1, must be >= 0")
  truss({ { "A", "B" } }, { mass = 5 }, "world:truss: mass is no field of it: give it to nodes")
  local p = world:plank { from = { 0, 1, 0 }, to = { 1, 1, 0 }, width = 0.1, height = 0.02, mass = "2 kg",
    material = "oak", breaks_at = "5 kN" }
  expect(p.mass):near(2, 1e-12)
  expect(p.breaks_at):is(5000)
  for _, at in ipairs { -0.1, 1.1, "5 m" } do
    for _, act in ipairs { function() p:push { at = at, force = { 0, 1, 0 } } end, function() p:point(at) end,
                           function() p:saw { at = at, depth = 1e-3 } end } do
      expect(pcall(act)):is(false)
    end
  end
end)

-- Their particles are balls to what they touch, and would carry them as the balls of a bearing do.
for _, what in ipairs { "lattice", "cloth" } do
  scenario(("a %s that slides on a floor stops after v^2 / 2 mu g and falls asleep"):format(what), function(s)
    local world = s:world { gravity = { 0, -g, 0 } }
    world:floor { friction = 0.5 }
    local thing = what == "lattice" and world:lattice { size = 0.4, mass = 4, friction = 0.5, at = { 0, 0.25, 0 }, stiffness = 20000 }
      or world:cloth { at = { 0, 0.03, 0 }, across = { 0.6, 0, 0 }, down = { 0, 0, 0.6 }, columns = 6, rows = 6, mass = 1, friction = 0.5,
        stiffness = 2000, pins = "none" }
    world:run(0.5)
    local from = thing.position.x
    for _, b in ipairs(thing.bodies) do b:teleport { velocity = { 2, 0, 0 } } end
    world:run(2)
    expect(thing.position.x - from):near(2 ^ 2 / (2 * 0.5 * g), 0.02)
    for _, b in ipairs(thing.bodies) do
      expect(b.asleep):is(true)
      expect(b.spin):is(digbox.vec(0, 0, 0))
    end
  end)
end

scenario("a ball that does not turn slides as a box does, pushes beside its centre or not, and is kept in a file", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  world:floor { friction = 0.5 }
  local ball = world:ball { name = "ball", radius = 0.1, mass = 1, friction = 0.5, at = { 0, 0.1, 0 }, velocity = { 2, 0, 0 },
    turns = false }
  local free = world:ball { radius = 0.1, mass = 1, friction = 0.5, at = { 0, 0.1, 1 }, velocity = { 2, 0, 0 } }
  expect(ball.turns):is(false)
  expect(free.turns):is(true)
  expect(expect(function() ball:teleport { spin = { 0, 1, 0 } } end):fails()):contains "turns = false"
  expect(expect(function() world:ball { radius = 1, spin = { 0, 1, 0 }, turns = false } end):fails()):contains "turns = false"
  world:save "still.save"
  world:run(2)
  expect(ball.at.x):near(2 ^ 2 / (2 * 0.5 * g), 1e-6)
  expect(free.speed):near(2 * 5 / 7, 1e-6)
  ball:hit { impulse = { 0, 0, 1 }, at = ball.at + digbox.vec(0.1, 0, 0) }
  world:run(0.1)
  expect(ball.velocity.z):near(1 - 0.5 * g * 0.1, 1e-6)
  expect(ball.rotation.angle):below(1e-6)
  local again = digbox.load "still.save"
  again:run(2)
  expect(again:find "ball".turns):is(false)
  expect(again:find "ball".at.x):near(2 ^ 2 / (2 * 0.5 * g), 1e-6)
end)
