-- thesis_digs.lua: rows 74, 77, 78, 86, 88 and 93 of the behaviours: who is in which graph, who is told, and what is stored.
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local g = 9.81

local function messages_of(world, kind)
  local list = {}
  for _, m in ipairs(world:messages()) do
    if m.kind == kind then list[#list + 1] = m end
  end
  return list
end

-- How many messages each body got, by name
local function told(list)
  local count = {}
  for _, m in ipairs(list) do count[m.to.name] = (count[m.to.name] or 0) + 1 end
  return count
end

scenario("row 74: a disturbed DIG costs its members, whatever else is in the world", function(s)
  local function cost(others)
    local world = s:world {}
    world:floor {}
    for i = 1, others do world:box { size = 0.2, at = { i % 20, 0.1, 3 + i // 20 } } end
    local a = world:ball { name = "a", radius = 0.1, at = { -2, 0.1, 0 } }
    world:run "1 s"
    expect(world:stats().awake):is(0)
    a:hit { impulse = { 0, a.mass, 0 } }
    world:step()
    local stats = world:stats()
    return stats.awake, stats.groups, stats.iterations, stats.contacts
  end
  local awake, groups, iterations = cost(0)
  expect(awake):is(1)
  expect(groups):is(1)
  local awake2, groups2, iterations2, contacts2 = cost(200)
  expect(awake2):is(1)
  expect(groups2):is(1)
  expect(iterations2):is(iterations)                    -- of the solver: the same work with 200 sleepers about
  expect(contacts2):at_least(200)                       -- which are there
end)

scenario("row 77: beside a table leg is not on the table, and on top is", function(s)
  local world = s.world
  world:floor {}
  local top = world:box { name = "top", size = { 1, 0.05, 0.6 }, at = { 0, 0.725, 0 }, mass = 10 }
  for i = 0, 3 do
    local leg = world:box { name = "leg " .. i, size = { 0.05, 0.7, 0.05 }, mass = 1,
                            at = { (i % 2 - 0.5) * 0.9, 0.35, (i // 2 - 0.5) * 0.5 } }
    world:weld { a = leg, b = top }
  end
  local beside = world:ball { name = "beside", radius = 0.05, at = { 0.45 + 0.025 + 0.05 + 0.002, 0.05, 0.25 } }
  local on = world:ball { name = "on", radius = 0.05, at = { 0, 0.8, 0 } }
  s:settle "1 s"
  expect(on.dig == top.dig):is(true)
  expect(beside.dig == top.dig):is(false)
  expect(top.dig.size):is(6)
  expect(beside.dig.size):is(1)
  -- "supports" is not stored: it follows from the normal of the link, which points up from what bears
  local link = on:links()[1]
  local up = link.a == top and link.normal.y or -link.normal.y
  expect(#on:links()):is(1)
  expect(up):near(1, 1e-6)
  expect(link.effort.y * up):near(link.a == top and on.mass * g or -on.mass * g, 0.01 * on.mass * g)

  beside:push { force = { -2, 0, 0 }, lasts = "5 s" }   -- pressed against the leg: a link, and a level normal
  s:eventually("it touches the leg", "1 s", function() return beside.dig == top.dig end)
  s:settle "0.5 s"
  local level
  for _, l in ipairs(beside:links()) do
    if l.a.kind == "dynamic" and l.b.kind == "dynamic" then level = math.abs(l.normal.y) end
  end
  expect(level):near(0, 1e-3)
end)

scenario("row 78: no field of a link says that one is on the other", function(s)
  local world = s.world
  world:floor {}
  local low = world:box { name = "low", size = 0.2, at = { 0, 0.1, 0 } }
  local high = world:box { name = "high", size = 0.2, at = { 0, 0.3, 0 } }
  s:settle "1 s"
  local known = { a = "peer", b = "peer", kind = "contact or joint", joint = "its joint", effort = "N", flow = "m/s", power = "W",
    began = "s", point = "m", normal = "1", bound = "to a static body" }
  for _, body in ipairs { low, high } do
    expect(#body:links()):at_least(1)
    for _, link in ipairs(body:links()) do
      for field in pairs(link) do expect(known[field]):is_not(nil) end
      expect(link.a):is_not(nil)
      expect(link.b):is_not(nil)
    end
  end
  expect(high.dig:members()):is { low, high }           -- by slot, not by height
  for _, field in ipairs { "parent", "on", "above", "root" } do
    expect(function() return high.dig[field] end):fails()
  end
  for _, field in ipairs { "parent", "above", "supports", "rests_on" } do   -- `on` is the method that subscribes to events
    expect(function() return high[field] end):fails()
  end
end)

-- n balls in a row, touching each other, at rest on the floor
local function row_of(world, n, r)
  local list = {}
  for i = 1, n do
    list[i] = world:ball { name = "member " .. i, radius = r, mass = 1, at = { 2 * r * (i - 1), r, 0 }, restitution = 0.5, friction = 0 }
  end
  return list
end

local function striker_at(world, at)        -- without friction a hit from the side does not press anybody into the floor
  return world:ball { name = "striker", radius = 0.1, mass = 1, at = at, restitution = 0.5, friction = 0 }
end

scenario("row 88: two at rest that touch share a DIG", function(s)
  local world = s.world
  world:floor {}
  local pair = row_of(world, 2, 0.1)
  s:settle "0.5 s"
  expect(pair[1].dig == pair[2].dig):is(true)
  expect(pair[1].dig.size):is(2)
  expect(pair[1].mode):is "resting"
  expect(pair[1]:neighbours()):contains(pair[2])
  expect(messages_of(world, "collision")):is_empty()
end)

scenario("row 88: a third that hits one of two disturbs both: each is told, then each has a DIG of its own", function(s)
  local world = s.world
  world:floor {}
  local pair = row_of(world, 2, 0.1)
  local striker = striker_at(world, { -0.06, 0.1, 1 })
  s:eventually("all asleep", "2 s", function() return pair[1].asleep and pair[2].asleep and striker.asleep end)
  local shared = pair[1].dig.id
  striker:hit { impulse = { 0, 0, -2 } }                -- towards the far side of member 1; it never meets member 2
  s:eventually("it hits", "1 s", function() return striker.debug.collided end)
  local list = messages_of(world, "collision")
  local count = told(list)
  expect(count["member 1"]):is(1)                       -- hit
  expect(count["member 2"]):is(1)                       -- not hit, and told all the same, once
  expect(count.striker):is(1)
  local time = list[1].time
  for _, m in ipairs(list) do
    expect(m.time):near(time, 1e-9)                     -- one moment, stamped
    if m.to ~= striker then
      expect(m.from):is(striker)
      expect(m.direction:dot { 0, 0, -1 }):above(0)     -- away from the striker
    end
  end
  expect(pair[1].awake):is(true)
  expect(pair[2].awake):is(true)                        -- in the same step
  expect(pair[2].debug.mess_type):is "collision"
  expect(pair[2].debug.origin):is(striker)
  s:eventually("own DIGs", "1 s", function()
    return pair[1].dig ~= pair[2].dig and pair[1].dig ~= striker.dig and pair[2].dig ~= striker.dig
  end)
  expect(pair[1].dig.id == shared or pair[2].dig.id == shared):is(true)     -- one of them keeps the graph, as the larger part or the first
  expect(pair[1].velocity.z):below(-0.5)
  s:settle "6 s"
  for _, b in ipairs { pair[1], pair[2], striker } do expect(b.position.y):near(0.1, "1 mm") end
end)

scenario("row 88, row 86: the same with 3, 10 and 40 members, each told once, within the frame", function(s)
  for _, n in ipairs { 3, 10, 40 } do
    local world = s:world {}
    world:floor {}
    local row = row_of(world, n, 0.1)
    local striker = striker_at(world, { -1, 0.1, 0 })
    s:eventually("all asleep", "2 s", function() return row[1].asleep and striker.asleep end)
    expect(row[1].dig.size):is(n)
    striker:hit { impulse = { 3, 0, 0 } }
    s:eventually("it hits", "1 s", function() return striker.debug.collided end)
    local list = messages_of(world, "collision")
    local count = told(list)
    for i = 1, n do
      expect(count["member " .. i]):is(1)
      expect(row[i].awake):is(true)
    end
    expect(#list):is(n + 1)                             -- the members and the striker, nobody else
    s:settle "4 s"
    expect(row[n].position.x):above(0.2 * (n - 1) + 0.05)                   -- the last one went off
    for i = 1, n do expect(row[i].position.y):near(0.1, "1 mm") end
  end
end)

scenario("row 86: boxes too: a wall of twelve is hit from the side, and each is told once by the one that hits", function(s)
  local world = s.world
  world:floor { friction = 0.6 }
  local wall = {}
  for i = 0, 11 do
    wall[#wall + 1] = world:box { name = "member " .. i + 1, size = { 0.4, 0.2, 0.2 }, friction = 0.6,
                                  at = { 0.4 * (i % 3) + 0.2 * (i // 3 % 2), 0.1 + 0.2 * (i // 3), 0 } }
  end
  local striker = world:ball { name = "striker", radius = 0.15, material = "steel", at = { 0.5, 0.5, 2 } }
  striker.gravity_scale = 0
  s:eventually("the wall sleeps", "3 s", function() return wall[1].asleep end)
  expect(wall[1].dig.size):is(12)
  striker:hit { impulse = { 0, 0, -6 * striker.mass } }
  s:eventually("it hits", "1 s", function() return striker.debug.collided end)
  local count, time = {}, nil
  for _, m in ipairs(messages_of(world, "collision")) do
    if m.from == striker then
      time = time or m.time
      if m.time == time then count[m.to.name] = (count[m.to.name] or 0) + 1 end
    end
  end
  for _, b in ipairs(wall) do
    expect(count[b.name]):is(1)
    expect(b.awake):is(true)
  end
  world:run "3 s"
  local moved = 0
  for _, b in ipairs(wall) do
    expect(b.position.y):above(0.09)                    -- none fell through
    if math.abs(b.position.z) > 0.2 then moved = moved + 1 end
  end
  expect(moved):at_least(2)
end)

scenario("row 93: a bounce on a moving table uses its speed and leaves a link for one step", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local e, u, v, m, M = 0.6, 0.7, -2, 1, 50
  local deck = world:box { name = "table", size = { 1, 0.1, 1 }, at = { 0, 0, 0 }, mass = M, velocity = { 0, u, 0 }, restitution = e }
  local ball = world:ball { name = "ball", radius = 0.1, mass = m, at = { 0, 0.6, 0 }, velocity = { 0, v, 0 }, restitution = e }
  local links, unlinks, linked_steps = 0, 0, 0
  world:on("link", function() links = links + 1 end)
  world:on("unlink", function() unlinks = unlinks + 1 end)
  for _ = 1, 30 do
    world:step()
    if ball.dig == deck.dig then linked_steps = linked_steps + 1 end
  end
  expect(links):is(1)
  expect(unlinks):is(1)
  expect(linked_steps):is(1)
  local p = m * v + M * u
  expect(ball.velocity.y):near((p - M * e * (v - u)) / (m + M), 1e-9)       -- restitution of the relative speed v - u
  expect(deck.velocity.y):near((p + m * e * (v - u)) / (m + M), 1e-9)
  expect(ball.dig == deck.dig):is(false)
end)

scenario("row 93: on a table at rest a bounce makes no link; coming to rest makes one", function(s)
  local world = s.world
  world:floor {}
  local deck = world:box { name = "table", size = { 1, 0.4, 1 }, at = { 0, 0.2, 0 }, mass = 200 }
  s:eventually("the table sleeps", "2 s", function() return deck.asleep end)
  local ball = world:ball { name = "ball", radius = 0.1, mass = 0.5, at = { 0, 1, 0 }, restitution = 0.5 }
  local merged, links, bounces = 0, 0, 0
  world:on("merged", function() merged = merged + 1 end)
  world:on("link", function(e) if e.a == ball or e.b == ball then links = links + 1 end end)
  ball:on("impact", function() bounces = bounces + 1 end)
  s:eventually("it rests", "4 s", function() return ball.mode == "resting" end)
  expect(bounces):at_least(4)
  expect(merged):is(1)                                  -- one update for all the bounces
  expect(links):is(1)
  expect(ball.dig == deck.dig):is(true)
end)

scenario("merge and split keep the larger graph, and say which", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local a = world:box { name = "a", size = 0.2, at = { 0, 0, 0 } }
  local b = world:box { name = "b", size = 0.2, at = { 0.5, 0, 0 } }
  local c = world:box { name = "c", size = 0.2, at = { 1, 0, 0 } }
  local merged, split = {}, {}
  world:on("merged", function(e) merged[#merged + 1] = e end)
  world:on("split", function(e) split[#split + 1] = e end)
  local ab = world:weld { a = a, b = b }
  world:step()
  expect(#merged):is(1)
  local pair = a.dig
  expect(pair.size):is(2)
  expect(c.dig == pair):is(false)
  local gone = c.dig.id
  local bc = world:weld { a = b, b = c }
  world:step()
  expect(#merged):is(2)
  expect(merged[2].dig):is(pair)
  expect(merged[2].other_dig.id):is(gone)
  expect(a.dig.size):is(3)
  expect(#world:digs()):is(1)
  ab:remove()
  world:step()
  expect(#split):is(1)
  expect(a.dig.size):is(1)
  expect(b.dig == c.dig):is(true)
  expect(b.dig.size):is(2)
  bc:remove()
  world:step()
  expect(#split):is(2)
  expect(#world:digs()):is(3)
end)
