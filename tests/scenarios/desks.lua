-- desks.lua: rows 14, 34 and 35 of the behaviours: desks and what lies on them.
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local g = 9.81

-- ---- row 14: a desk that is moved ----

-- Twelve things of many kinds of weight on a desk of 20 kg that glides on the floor; friction 0.5 between them
local function laden(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  world:floor { friction = 0 }
  local desk = world:box { name = "desk", size = { 1.4, 0.7, 0.9 }, at = { 0, 0.35, 0 }, mass = 20, friction = 0.5 }
  local items, mass = {}, desk.mass
  for i = 0, 11 do
    local m = 0.2 + 0.1 * i
    items[i + 1] = world:box { name = "item " .. i + 1, size = { 0.16, 0.04 + 0.01 * (i % 3), 0.12 }, mass = m, friction = 0.5,
      at = { -0.5 + 0.3 * (i % 4), 0.7 + 0.02 + 0.005 * (i % 3), -0.25 + 0.25 * (i // 4) } }
    mass = mass + m
  end
  s:settle "0.5 s"
  expect(desk.dig.size):is(13)
  return world, desk, items, mass
end

-- Common centre of mass: pushed there, a desk that glides does not turn
local function middle(desk, items, mass)
  local sum = desk.centre * desk.mass
  for _, item in ipairs(items) do sum = sum + item.centre * item.mass end
  return sum / mass
end

-- Pushed with this acceleration for a metre, stopped within the next. Returns how far the items slipped at most, m.
local function move(world, desk, items, mass, acceleration)
  local start, place, worst = desk.position.x, {}, 0
  for i, item in ipairs(items) do place[i] = item.position - desk.position end
  local time = math.sqrt(2 / acceleration)
  local steps = math.ceil(time / world.frame)
  for half = 1, 2 do
    local force = (half == 1 and 1 or -1) * mass * 2 / (steps * world.frame) ^ 2
    desk:push { force = { force, 0, 0 }, at = middle(desk, items, mass), lasts = steps * world.frame }
    for _ = 1, steps do
      world:step()
      for i, item in ipairs(items) do worst = math.max(worst, #(item.position - desk.position - place[i])) end
    end
  end
  return worst, desk.position.x - start
end

scenario("row 14: a desk that is moved 2 m gently carries all twelve items along", function(s)
  local world, desk, items, mass = laden(s)
  local slip, way = move(world, desk, items, mass, 0.8 * 0.5 * g)
  expect(slip):below "1 mm"
  expect(way):near("2 m", "1 mm")
  expect(desk.dig.size):is(13)
end)

scenario("row 14: above the limit of friction they slide", function(s)
  local world, desk, items, mass = laden(s)
  expect(move(world, desk, items, mass, 1.2 * 0.5 * g)):above "20 mm"
end)

-- ---- row 34: a desk that is tilted ----

scenario("row 34: a book slides off a tilted desk at 26.565 degrees, leaves its DIG and joins another", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  world:floor { friction = 0.5 }
  local top = world:box { name = "desk", size = { 1, 0.04, 0.6 }, at = { 0.5, 1, 0 }, mass = 20, friction = 0.5 }
  local hinge = world:hinge { a = top, at = { 0, 1, 0 }, axis = { 0, 0, 1 }, motor = { speed = "2 deg/s", max_torque = "1000 N m" } }
  local book = world:box { name = "book", size = { 0.2, 0.03, 0.15 }, at = { 0.6, 1.035, 0 }, mass = 1, friction = 0.5 }
  local pen = world:box { name = "pen", size = { 0.1, 0.02, 0.02 }, at = { 0.8, 1.03, 0.2 }, mass = 0.05, friction = 1.5 }
  local crate = world:box { name = "crate", size = { 0.8, 0.5, 0.8 }, at = { -0.5, 0.25, 0 }, mass = 50, friction = 0.5 }
  world:run(0.3)
  expect(top.dig.size):is(3)
  local log = {}
  world:on("split", function() log[#log + 1] = "split" end)
  world:on("merged", function() log[#log + 1] = "merged" end)
  local function along() return top.rotation:inverse():rotate(book.position - top.position).x end
  world:run { seconds = 15, stop_when = function() return math.deg(hinge.angle) > 25 end }
  hinge.motor = { speed = "0.5 deg/s" }
  world:run(0.5)
  local start = along()
  log = {}
  s:eventually("the book slides", "6 s", function() return math.abs(along() - start) > 5e-4 end)
  expect(math.deg(hinge.angle)):near(26.565, 0.3)
  s:eventually("it lies on the crate", "8 s", function() return book.dig == crate.dig and book.speed < 0.01 end)
  expect(log[1]):is "split"
  expect(log[#log]):is "merged"
  expect(pen.dig == top.dig):is(true)                    -- what holds better stays
  expect(book.dig == top.dig):is(false)
end)

-- ---- row 35: two desks on one floor ----

local function two_desks(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  world:floor { at = { 0, -1, 0 } }
  local slab = world:box { name = "slab", fixed = true, size = { 6, 0.2, 3 }, at = { 0, -0.1, 0 } }
  local d = {}
  for i, name in ipairs { "A", "B" } do
    local x = 3 * i - 4.5
    d[name] = world:box { name = "desk " .. name, size = { 1, 0.7, 0.6 }, at = { x, 0.35, 0 }, mass = 20 }
    d["book " .. name] = world:box { name = "book " .. name, size = { 0.2, 0.04, 0.15 }, at = { x, 0.72, 0 }, mass = 1 }
  end
  s:eventually("all asleep", "3 s", function() return world:stats().awake == 0 end)
  return world, d, slab
end

scenario("row 35: what happens to desk A does not reach desk B on the same floor", function(s)
  local world, d, slab = two_desks(s)
  expect(d.A.dig == d["book A"].dig):is(true)
  expect(d.A.dig == d.B.dig):is(false)
  expect(slab.dig):is(nil)
  local id = d.B.dig.id
  expect(d.A:flood("shaken")):is(1)
  d.A:hit { impulse = { 0, 0, 30 } }
  for _ = 1, 60 do
    world:step()
    expect(d.B.asleep and d["book B"].asleep):is(true)
    expect(world:stats().awake):at_most(2)
  end
  expect(d.A.position.z):above(0.05)
  expect(d.B.dig.id):is(id)
  expect(d.B.debug.m_id):is(0)                          -- not a single message
  expect(d["book B"].debug.m_id):is(0)
end)

scenario("row 35: a floor that breaks loose is a body like others: all that stood on it falls, and is one DIG", function(s)
  local world, d, slab = two_desks(s)
  slab:remove()
  slab = world:box { name = "slab", size = { 6, 0.2, 3 }, at = { 0, -0.1, 0 }, mass = 500 }
  world:step(3)
  expect(d.A.awake and d.B.awake):is(true)
  expect(slab.dig.size):is(5)
  expect(d["book A"].dig == d["book B"].dig):is(true)
  s:settle "2 s"
  expect(d.A.position.y):near(-0.45, 0.01)
  expect(d.B.position.y):near(-0.45, 0.01)
  expect(slab.dig.size):is(5)
end)
