-- soft_files.lua: trusses, planks, cloth and lattices that come out of a file can be asked, pushed and sawn as those that went in.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local none = { gravity = { 0, 0, 0 } }

-- A hanger on two fixed nodes, with a strut too weak for it and a deck on two others.
local function hanger(world, name, x)
  return world:truss { name = name, stiffness = 1e6, budget = 20, price = 2, breaks_at = 5e4, plane = "xy", radius = 0.05,
    nodes = { A = { at = { x - 1, 2, 0 }, fixed = true }, B = { at = { x + 1, 2, 0 }, fixed = true }, C = { at = { x, 1, 0 }, mass = 10 },
      D = { at = { x, 0, 0 }, mass = 1 }, E = { at = { x + 2, 1, 0 }, fixed = true } },
    struts = { { "A", "C" }, { "B", "C" }, { "C", "D", breaks_at = 5 }, { "C", "E", deck = true } }, deck = { mass = 1 } }
end

local function furnished(world)
  return {
    bridge = hanger(world, "bridge", 0),
    beam = world:plank { name = "beam", from = { 5, 1, 0 }, to = { 7, 1, 0 }, width = 0.2, height = 0.03, material = "oak",
      from_end = "clamped", segments = 6 },
    cloth = world:cloth { name = "cloth", at = { 10, 3, 0 }, across = { 1, 0, 0 }, down = { 0, -1, 0 }, columns = 4, rows = 4,
      mass = 0.3, stiffness = 500 },
    jelly = world:lattice { name = "jelly", at = { 14, 1, 0 }, size = 0.4, cells = 2, mass = 2, stiffness = 4000 },
  }
end

-- All that can be read of them, as text
local function told(things)
  local t, p, c, l = things.bridge, things.beam, things.cloth, things.jelly
  local lines = { tostring(t), tostring(p), tostring(c), tostring(l), t.cost, t.budget, t.broken, #t.panels, t:force "AC", t:force "CD",
    t:stress "BC", t:stress(), t:node("C").position, t:strut("AC").stress, t.mass, t.position, p.stress, p.length, p:point(1.7), #p.pieces,
    #p.holds, c.stress, c.support, c.stretch, c.columns, c.rows, c:node(2, 3).position, l.stretch, l.layers, l:node(3, 3, 3).position,
    #t:sig(), #p:sig(), #c:sig(), l.broken, l.breaks_at, t.joints[3].valid, c.layers }
  for i = 1, #lines do lines[i] = tostring(lines[i]) end
  return table.concat(lines, "\n")
end

local function found(world)
  local things = {}
  for _, name in ipairs { "bridge", "beam", "cloth", "jelly" } do things[name] = world:find(name) end
  return things
end

scenario("what was saved is found by name and says the same", function(s)
  local world = s:world {}
  local before = furnished(world)
  world:run(0.5)
  expect(before.bridge.broken):is(1)                    -- D hung on a thread
  before.cloth:node(2, 4):remove()
  world:save "soft.digbox"
  local there = digbox.load "soft.digbox"
  expect(world:find "bridge" == before.bridge):is(true)
  expect(told(found(there))):is(told(before))
  expect(there:find "nobody"):is(nil)
  expect(there:checksum()):is(world:checksum())
  expect(function() return there:find("cloth"):node(2, 4).position end):fails()

  -- Both go on alike, by the same acts on what was found and on what was made.
  for _, world_and_things in ipairs { { world, before }, { there, found(there) } } do
    local w, things = world_and_things[1], world_and_things[2]
    things.beam:saw { at = 0.7, depth = 0.01 }
    things.beam:push { at = 1.9, force = { 0, -20, 0 } }
    things.bridge:push("C", { 0, -300, 0 })
    things.cloth:saw { at = things.cloth:node(3, 2).position, depth = 1 }
    w:run(0.2)
    things.bridge:cut "CE"
    w:run(0.2)
  end
  expect(told(found(there))):is(told(before))
  expect(there:checksum()):is(world:checksum())
end)

scenario("a snapshot goes back over both, and what came after it is not found", function(s)
  local world = s:world {}
  furnished(world)
  world:save "again.digbox"
  local there = digbox.load "again.digbox"
  local was = told(found(there))
  local snap = there:snapshot()
  there:find("bridge"):cut "AC"
  hanger(there, "second", 20)
  there:run(0.3)
  expect(there:find("second").cost):is(8)
  expect(there:find("bridge").broken):is(2)
  there:restore(snap)
  expect(told(found(there))):is(was)
  expect(there:find "second"):is(nil)
  for _, body in ipairs(there:find("jelly").bodies) do body:remove() end
  expect(there:find "jelly"):is(nil)                    -- nothing is left of it
  there:save "again2.digbox"
  expect(digbox.load("again2.digbox"):find "jelly"):is(nil)
  there:restore(snap)
  expect(told(found(there))):is(was)
end)

scenario("what is made in a world that was loaded keeps out of the way of what was there", function(s)
  local world = s:world(none)
  local one = world:lattice { name = "one", at = { 0, 0, 0 }, size = 0.4, cells = 1, mass = 1, stiffness = 1e4, radius = 0.1 }
  world:save "group.digbox"
  local there = digbox.load "group.digbox"
  local two = there:lattice { name = "two", at = { 0, 0.65, 0 }, size = 0.4, cells = 1, mass = 1, stiffness = 1e4, radius = 0.1 }
  for _, body in ipairs(two.bodies) do body:hit { impulse = { 0, -0.1, 0 } } end
  there:run(0.5)
  expect(one.mass):is(1)
  expect(there:find("one").bodies[1].velocity.y):below "-0.05 m/s"      -- it was struck
end)
