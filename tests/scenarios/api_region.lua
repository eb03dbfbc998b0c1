-- api_region.lua: regions with laws of their own, and the ways in which regions, overlaps and sweeps are told a shape.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local g = 9.81

local function expect_failure(fn, text) expect(expect(fn):fails()):contains(text) end

scenario("in a region without gravity the velocity stays, outside bodies fall", function(s)
  local world = s.world
  world:region { box = { size = { 4, 4, 4 } }, at = { 0, 10, 0 }, laws = { gravity = { 0, 0, 0 } } }
  local inside = world:ball { radius = 0.1, at = { -1, 10, 0 }, velocity = { 1, 0.5, 0 } }
  local outside = world:ball { radius = 0.1, at = { 9, 10, 0 } }
  world:run(1)
  expect(inside.velocity):near({ 1, 0.5, 0 }, 1e-12)
  expect(inside.position):near({ 0, 10.5, 0 }, 1e-9)
  expect(outside.velocity.y):near(-g, 1e-9)
end)

scenario("gravity of a region is its own, and ends with it", function(s)
  local world = s.world
  local region = world:region { sphere = { radius = 50 }, laws = { gravity = { "2 m/s^2", 0, 0 } } }
  local ball = world:ball { radius = 0.1 }
  world:run(1)
  expect(ball.velocity):near({ 2, 0, 0 }, 1e-9)
  expect(region:bodies()):is { ball }
  expect(region.valid):is(true)
  region:remove()
  expect(region.valid):is(false)
  world:run(1)
  expect(ball.velocity):near({ 2, -g, 0 }, 1e-9)
  expect(region:bodies()):is_empty()
  expect(function() region:remove() end):fails()
end)

scenario("drag lets speed and spin decay: v = v0 exp(-c t)", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  world:region { digbox.sphere { radius = 100 }, laws = { drag = "1.5 1/s" } }
  local ball = world:ball { radius = 0.1, velocity = { 3, 0, 0 }, spin = { 0, 4, 0 } }
  world:run(1)
  expect(ball.velocity.x):near(3 * math.exp(-1.5), 1e-6)
  expect(ball.spin.y):near(4 * math.exp(-1.5), 1e-6)
end)

scenario("friction_scale = 0 lets a box slide on for ever", function(s)
  local world = s.world
  world:floor {}
  world:region { shape = digbox.box { size = { 100, 4, 4 } }, laws = { friction_scale = 0 } }
  local free = world:box { size = 0.2, at = { 0, 0.1, 0 }, velocity = { 2, 0, 0 }, friction = 0.5 }
  local braked = world:box { size = 0.2, at = { 0, 0.1, 8 }, velocity = { 2, 0, 0 }, friction = 0.5 }
  world:run(1)
  expect(free.velocity.x):near(2, 1e-6)
  expect(braked.velocity.x):near(0, 1e-3)         -- friction on the floor stops it well within a second
end)

scenario("restitution_scale = 0 takes the bounce away", function(s)
  local world = s.world
  world:floor { restitution = 1 }
  world:region { sphere = { radius = 2 }, laws = { restitution_scale = 0 } }
  local dull = world:ball { radius = 0.1, at = { 0, 1, 0 }, restitution = 1 }
  local lively = world:ball { radius = 0.1, at = { 9, 1, 0 }, restitution = 1 }
  local fall = math.sqrt(2 * 0.9 / g)
  world:run(1.5 * fall)
  expect(dull.position.y):near(0.1, 1e-2)
  expect(lively.velocity.y):above(1)
end)

scenario("laws.force is asked before each step for each body inside", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local calls = 0
  local region = world:region { box = { size = 20 }, laws = { force = function(body)
    calls = calls + 1
    if body.name == "pushed" then return { 6, 0, 0 } end
  end } }
  local pushed = world:box { name = "pushed", size = 1, mass = 3 }
  local other = world:box { name = "other", size = 1, mass = 3, at = { 0, 5, 0 } }
  local outside = world:box { name = "pushed", size = 1, mass = 3, at = { 0, 15, 0 } }
  world:step(60)
  local t = world.time
  expect(pushed.velocity):near({ 2 * t, 0, 0 }, 1e-9)
  expect(other.velocity):is(digbox.vec(0, 0, 0))
  expect(outside.velocity):is(digbox.vec(0, 0, 0))
  expect(calls):is(120)
  region:remove()
  world:step(60)
  expect(calls):is(120)
  expect(pushed.velocity):near({ 2 * t, 0, 0 }, 1e-9)
end)

scenario("a force may remove bodies, but not step; its errors are the script's", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local b
  local law = function(body) if body == b then return nil end b:remove() return { 1, 0, 0 } end
  world:region { sphere = { radius = 9 }, laws = { force = function(body) return law(body) end } }
  local a = world:ball { radius = 0.1 }
  b = world:ball { radius = 0.1, at = { 1, 0, 0 } }
  world:step()
  expect(world:bodies()):is { a }
  expect(a.speed):above(0)
  law = function() world:step() end
  expect_failure(function() world:step() end, "world:step() cannot be called inside a handler of 'laws.force'")
  law = function() return "up" end
  expect_failure(function() world:step() end, "world:region.laws.force")
  law = function() end
  world:step()
end)

scenario("a snapshot brings a removed region and its force back", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local calls = 0
  local region = world:region { sphere = { radius = 9 }, laws = { force = function() calls = calls + 1 end } }
  local ball = world:ball { radius = 0.1 }
  local snap = world:snapshot()
  region:remove()
  world:step()
  expect(calls):is(0)
  world:restore(snap)
  expect(region:bodies()):is { ball }
  world:step()
  expect(calls):is(1)
end)

scenario("after a restore a new region does not take over the force of a lost one", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  world:ball { radius = 0.1 }
  local snap, calls = world:snapshot(), 0
  world:region { sphere = { radius = 9 }, laws = { force = function() calls = calls + 1 end } }
  world:restore(snap)
  world:region { sphere = { radius = 9 } }
  world:step()
  expect(calls):is(0)
end)

scenario("what a region cannot mean is an error", function(s)
  local world = s.world
  local shape = digbox.sphere { radius = 1 }
  local function region(laws) return function() world:region { shape, laws = laws } end end
  expect_failure(region { time_rate = 0 }, "time_rate = 0, must be > 0")
  expect_failure(region { time_rate = "fast" }, "world:region.laws.time_rate")
  expect_failure(region { conduct = -1 }, "conduct = -1, must be >= 0")
  expect_failure(region { gravty = { 0, 0, 0 } }, "did you mean 'gravity'?")
  expect_failure(region { drag = -1 }, "drag = -1 1/s, must be >= 0")
  expect_failure(region { force = 3 }, "world:region.laws.force wants a function of a body; got number")
  expect_failure(region(7), "world:region.laws wants a table of laws; got number")
  expect_failure(function() world:region { laws = {} } end, "world:region wants a shape")
  expect_failure(function() world:region { shape, sphere = { radius = 1 } } end, "world:region: the shape is given twice")
  expect_failure(function() world:region(1) end, "world:region wants a table of fields; got number")
end)

scenario("shapes are given first, as shape, or by the name of their kind", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local ball = world:ball { radius = 0.5, at = { 3, 0, 0 } }
  local sphere = digbox.sphere { radius = 1 }
  for _, fields in ipairs { { sphere }, { shape = sphere }, { sphere = { radius = 1 } } } do
    fields.at = { 3, 1, 0 }
    expect(world:overlap(fields)):is { ball }
    fields.at = { 3, 2, 0 }
    expect(world:overlap(fields)):is_empty()
    expect(world:region(fields):bodies()):is_empty()
    fields.at = { 0, 0, 0 }
    fields.velocity, fields.time = { 1, 0, 0 }, 10
    local hit = world:sweep(fields)
    expect(hit.body):is(ball)
    expect(hit.distance):near(1.5, 1e-6)
  end
  expect(world:overlap { box = { size = { 4.9, 1, 1 } } }):is_empty()
  expect(world:overlap { box = { size = { 5.1, 1, 1 } } }):is { ball }
  expect_failure(function() world:overlap { sphere = {} } end, "radius is missing")
  expect_failure(function() world:overlap { at = { 0, 0, 0 } } end, "world:overlap wants a shape")
end)

scenario("the place of the shape itself counts", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local ball = world:ball { radius = 0.5, at = { 0, 3, 0 } }
  local shape = digbox.sphere { radius = 0.1, at = { 2, 0, 0 } }
  local quarter = digbox.quat { axis = { 0, 0, 1 }, angle = "90 deg" }
  expect(world:overlap { shape, at = { 0, 1, 0 }, rotation = quarter }):is { ball }
  expect(world:overlap { shape, at = { 0, 1, 0 } }):is_empty()
  expect(world:region { shape, at = { 0, 1, 0 }, rotation = quarter }:bodies()):is { ball }
end)

scenario("a method that is not called says so", function(s)
  local world = s.world
  expect_failure(function() return world.stats.bodies end, "stats is a method: world:stats()")
  expect_failure(function() return (function() end).x end, "attempt to index a function value (field 'x')")
end)

scenario("a shape can stand alone for an overlap and a region, and lies where it is", function(s)
  local world = s.world
  local near, far = world:ball { radius = 1 }, world:ball { radius = 1, at = { 9, 0, 0 } }
  expect(world:overlap(digbox.sphere { radius = 2 })):is { near }
  expect(world:overlap(digbox.sphere { radius = 2, at = { 9, 0, 0 } })):is { far }
  expect(world:region(digbox.sphere { radius = 2, at = { 9, 0, 0 } }):bodies()):is { far }
end)

scenario("a ray gives all that it meets, by distance", function(s)
  local world = s.world
  for i = 300, 1, -1 do world:ball { radius = 0.1, at = { i, 0, 0 }, fixed = true } end
  local hits = world:ray { from = { 0, 0, 0 }, along = { 1, 0, 0 } }
  expect(#hits):is(300)
  for i, hit in ipairs(hits) do expect(hit.distance):near(i - 0.1, 1e-9) end
  expect(#world:ray { from = { 0, 0, 0 }, to = { 64.5, 0, 0 } }):is(64)
  expect(#world:ray { from = { 0, 0, 0 }, to = { 65.5, 0, 0 } }):is(65)
end)

scenario("the heights of a landscape can be a function of x and z, and its size two numbers", function(s)
  local world = s.world
  local function height(x, z) return 0.5 * x - 0.25 * z end
  local at = { { -3, -1 }, { 0, 0 }, { 2.5, 1.5 } }
  world:heightfield { size = { 8, 4 }, columns = 9, rows = 5, height = height }
  for _, p in ipairs(at) do
    local hits = world:ray { from = { p[1], 10, p[2] }, along = { 0, -1, 0 } }
    expect(hits[1].point.y):near(height(p[1], p[2]), 1e-12)
  end
  expect(#world:ray { from = { 3.9, 10, 1.9 }, along = { 0, -1, 0 } }):is(1)
  expect(world:ray { from = { 4.1, 10, 0 }, along = { 0, -1, 0 } }):is_empty()
  expect(world:ray { from = { 0, 10, 2.1 }, along = { 0, -1, 0 } }):is_empty()
  local part = digbox.heightfield { size = { "800 cm", "4 m" }, columns = 2, rows = 2, height = function() return 7 end, at = { 0, 1, 0 } }
  world:body { parts = { part }, fixed = true }
  expect(world:ray { from = { 0, 10, 0 }, along = { 0, -1, 0 } }[1].point.y):near(8, 1e-12)
  expect_failure(function() world:heightfield { size = { 8, 4 }, height = height } end, "world:heightfield: columns is missing")
  expect_failure(function() world:heightfield { size = { 8, 4 }, columns = 1, rows = 3, height = height } end,
    "world:heightfield: columns = 1, must be an integer of 2 to 4096")
  expect_failure(function() world:heightfield { size = 3, columns = 2, rows = 2, height = height } end, "world:heightfield.size wants")
  expect_failure(function() world:heightfield { size = { 8, 4 }, columns = 2, rows = 2, height = 3 } end,
    "world:heightfield.height wants a function of x and z; got number")
  expect_failure(function() world:heightfield { size = { 8, 4 }, columns = 2, rows = 2, height = print, heights = {} } end,
    "world:heightfield: give either height or heights")
  expect_failure(function() world:heightfield { size = { 8, 4 }, columns = 2, rows = 2, height = function() end } end,
    "world:heightfield.height(-4, -2) gives nil, must be a number")
end)

scenario("the numbers of a body's debug record are whole", function(s)
  local world = s.world
  world:floor {}
  local ball = world:ball { radius = 0.1, at = { 0, 0.3, 0 } }
  world:run(0.5)
  local debug = ball.debug
  for _, key in ipairs { "m_id", "db_id", "dig_id" } do expect(math.type(debug[key])):is "integer" end
  expect(debug.m_id):above(0)
end)

scenario("the debug record has the founding document's names, as it spells them, and its packet", function(s)
  local world = s.world
  local a = world:ball { radius = 0.1, name = "a", gravity_scale = 0 }
  local b = world:ball { radius = 0.1, name = "b", gravity_scale = 0, at = { 0, 2, 0 }, velocity = { 1, 0, 0 } }
  expect(b.debug.me):is(nil)
  expect(b.debug.origin):is(nil)
  expect(b:debug().mass):is(b.mass)
  a:send(b, "hello", 1)
  world:step()
  local debug = b.debug
  for _, key in ipairs { "m_id", "db_id", "mess_type", "dig_id", "mess_time", "floor", "collided", "euler", "currPos", "prevPos", "nextPos",
    "currRot", "prevRot", "nextRot", "iTensor", "iti", "itiws", "moInertia", "resForce", "torque", "cMass", "angMom", "velocity",
    "omega", "mass", "rest", "origin", "sp", "matrix", "objectType", "me", "you", "direction" } do
    expect(debug[key] ~= nil):is(true)
  end
  expect(debug.currPos):is(debug.curr_pos)
  expect(debug.me):is(a)
  expect(debug.you):is(b)
  expect(debug.direction):near(digbox.vec(1 / 60, 2, 0), 1e-12)
  expect(expect(function() return debug.velocty end):fails()):contains "body.debug has no field 'velocty' (did you mean 'velocity'?)"
end)

scenario("the books have no other names", function(s)
  local energy = s.world.energy
  expect(expect(function() return energy.kinetik end):fails()):contains "world.energy has no field 'kinetik' (did you mean 'kinetic'?)"
  local count = 0
  for _, joules in pairs(energy) do count = count + (joules == 0 and 1 or 0) end
  expect(count):is(11)
end)
