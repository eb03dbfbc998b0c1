-- messages.lua: one queue, six routes, exactly once; layers; what a storm is.
local test = require "digbox.test"
local digbox = require "digbox"
local scenario, expect = test.scenario, test.expect

local function hang(s) return s:world { gravity = { 0, 0, 0 } } end

-- n balls in a row, each bolted to the one before
local function row(world, n, at)
  local list = {}
  for i = 1, n do
    list[i] = world:ball { name = "ball " .. i, radius = 0.1, mass = 1, at = { 0.5 * i, 0, at or 0 } }
    if i > 1 then world:weld { a = list[i], b = list[i - 1] } end
  end
  return list
end

local function got(world, name)
  local list = {}
  for _, m in ipairs(world:messages()) do
    if m.kind == name then list[#list + 1] = m.to.name end
  end
  return table.concat(list, " ")
end

scenario("six routes, each receiver once", function(s)
  local world = hang(s)
  local b = row(world, 4)
  local apart = world:ball { name = "apart", radius = 0.1, at = { 0, 5, 0 } }
  world:weld { a = b[4], b = b[1] }                     -- a ring
  world:distance { a = b[1], b = b[2] }                 -- and a second link between two of it
  b[1]:send(b[3], "to", 1)
  b[1]:send_neighbours("near")
  b[1].dig:broadcast("dig")
  expect(b[1]:flood("flood", 1)):is(3)
  b[1]:send { route = "path", to = b[3], name = "path" }
  local space = world:region { sphere = { radius = 1 }, at = { 0, 5, 0 } }
  b[1]:send { route = "region", region = space, name = "region" }
  expect(got(world, "to")):is "ball 3"
  expect(got(world, "near")):contains "ball 2"
  expect(got(world, "near")):contains "ball 4"
  expect(#got(world, "near")):is(#"ball 2 ball 4")
  expect(got(world, "dig")):is "ball 1 ball 2 ball 3 ball 4"
  expect(#got(world, "flood")):is(#"ball 2 ball 3 ball 4")
  expect(#got(world, "path")):is(#"ball 2 ball 3")
  expect(got(world, "path"):sub(-6)):is "ball 3"
  expect(got(world, "region")):is "apart"
  expect(apart.debug.mess_type):is "region"
  expect(apart.debug.origin):is(b[1])
  local stats = world:stats()
  expect(stats.posted):is(6)
  expect(stats.delivered):is(1 + 2 + 4 + 3 + 2 + 1)
  expect(stats.dropped):is(0)
end)

scenario("a delayed message reaches those who are members when it arrives", function(s)
  local world = hang(s)
  local b = row(world, 3)
  local joint = b[3]:links()[1].joint
  local heard = {}
  world:on("message", { kind = "late" }, function(e) heard[#heard + 1] = e.to.name .. " " .. tostring(e.time == world.time) end)
  b[1].dig:broadcast("late", 5, { after = "0.2 s" })
  b[2]:send(b[1], "never", 1, { after = 1 })
  expect(#world:messages()):is(0)
  joint:remove()
  world:run "0.15 s"
  expect(#heard):is(0)
  world:run "0.1 s"
  expect(heard):is { "ball 1 true", "ball 2 true" }
  local gone = b[1].dig
  gone:broadcast("gone", 1, { after = "0.1 s" })
  b[1]:remove()
  b[2]:remove()
  world:run "1 s"
  expect(world:stats().dropped):is(2)                   -- the DIG, and the body that was sent "never"
  expect(got(world, "gone")):is ""
  expect(world:stats().storms):is(0)
end)

scenario("handlers answer at the same instant, in order, and a circle ends", function(s)
  local world = hang(s)
  local b = row(world, 3)
  local log = {}
  for i = 1, 3 do
    b[i]:on("message", { kind = "pass" }, function(e)
      log[#log + 1] = ("%d %g %s"):format(i, e.value, e.from.name)
      b[i]:send(b[i % 3 + 1], "pass", e.value + 1)
    end)
  end
  b[3]:send(b[1], "pass", 1)
  world:step()
  expect(log):is { "1 1 ball 3", "2 2 ball 1", "3 3 ball 2", "1 4 ball 3" }     -- 2 has heard it at this instant
  expect(world:stats().repeated):is(1)
  local all = world:messages()
  for i = 2, #all do
    expect(all[i].time > all[i - 1].time or all[i].time == all[i - 1].time and all[i].id > all[i - 1].id):is(true)
    expect(all[i].root):is(all[1].id)
  end
end)

scenario("a storm is an error that names its root, and the world goes on", function(s)
  local world = hang(s)
  local b = row(world, 2)
  local n = 0
  local sub = world:on("message", function(e)
    n = n + 1
    e.to:send(e.to == b[1] and b[2] or b[1], "echo " .. n)      -- always another kind: no circle that would end
  end)
  local ball = world:ball { name = "falls", radius = 0.1, at = { 0, 9, 0 }, velocity = { 1, 0, 0 } }
  b[1]:send(b[2], "spark")
  local why = expect(function() world:step() end):fails()
  expect(why):contains "message storm: more than 10000 answers"
  expect(why):contains "'spark' from body 'ball 1' to body 'ball 2'"
  expect(why):contains "messages.lua:"
  expect(n):is(10001)
  expect(world:stats().storms):is(1)
  local x = ball.position.x
  world:step(10)                                        -- what was left of it is gone
  expect(n):is(10001)
  expect(ball.position.x):above(x)
  sub:off()
  b[1]:send(b[2], "calm")
  world:step()
  expect(world:stats().storms):is(1)
  expect(#world:messages()):is(4096)
end)

scenario("a receiver that an earlier handler removed hears nothing", function(s)
  local world = hang(s)
  local b = row(world, 2)
  local heard = 0
  world:on("message", function() heard = heard + 1; if b[2].valid then b[2]:remove() end end)
  b[1].dig:broadcast("bye")
  world:step()
  expect(heard):is(1)
  expect(world:stats().dropped):is(1)
end)

scenario("a flood takes the ratios of gears along, and finds wheels that contradict each other", function(s)
  local world = hang(s)
  local base = world:box { name = "base", fixed = true, size = 0.1, at = { 0, -1, 0 } }
  local function train(z, n, ratios)
    local wheel, axle = {}, {}
    for i = 1, n do
      wheel[i] = world:cylinder { name = ("wheel %d"):format(i), radius = 0.05, height = 0.02, at = { 0.3 * i, 0, z }, group = -1 }
      axle[i] = world:hinge { a = wheel[i], b = base, at = { 0.3 * i, 0, z }, axis = { 0, 1, 0 } }
    end
    for _, g in ipairs(ratios) do world:gear { a = axle[g[1]], b = axle[g[2]], ratio = { g[3], g[4] } } end
    return wheel
  end
  local clock = train(0, 3, { { 1, 2, 1, 12 }, { 2, 3, 20, -40 } })
  local reached, loop = clock[1]:flood("turn", 6, { transform = "ratio" })
  expect(reached):is(2)
  expect(loop):is(nil)
  local value = {}
  for _, m in ipairs(world:messages()) do value[m.to.name] = m.value end
  expect(value["wheel 2"]):near(0.5, 1e-12)
  expect(value["wheel 3"]):near(-0.25, 1e-12)
  expect(clock[3]:flood("turn", -0.25, { transform = "ratio" })):is(2)          -- and back
  expect(world:messages()[5] == nil):is(true)
  expect(world:messages()[4].value):near(6, 1e-12)
  local three = train(2, 3, { { 1, 2, 1, -1 }, { 2, 3, 1, -1 }, { 3, 1, 1, -1 } })
  local _, ring = three[1]:flood("turn", 1, { transform = "ratio" })
  expect(#ring):is(3)
  for i = 1, 3 do expect(ring):contains(three[i]) end
  local four = train(4, 4, { { 1, 2, 1, -1 }, { 2, 3, 1, -1 }, { 3, 4, 1, -1 }, { 4, 1, 1, -1 } })
  local n, none = four[1]:flood("turn", 1, { transform = "ratio" })
  expect(n):is(3)
  expect(none):is(nil)
end)

scenario("a flood with a function, or fading, or only so far", function(s)
  local world = hang(s)
  local b = row(world, 5)
  expect(b[1]:flood("faint", 8, { transform = 0.5, hops = 3 })):is(3)
  expect(b[4].debug.mess_type):is "faint"
  expect(b[5].debug.mess_type):is ""
  expect(world:messages()[3].value):is(1.0)
  local reached, loop = b[1]:flood("step", 0, { transform = function(value, hop, from, to)
    expect(from.valid and to.valid):is(true)
    return hop < 4 and value + 1 or nil
  end })
  expect(reached):is(3)
  expect(loop):is(nil)
  expect(world:messages()[6].value):is(3.0)
  world:weld { a = b[1], b = b[3] }
  local _, ring = b[1]:flood("sum", 0, { transform = function(value) return value + 1 end })
  expect(#ring):is(3)
end)

scenario("layers: a DIG of wires is not one of things that touch", function(s)
  local world = hang(s)
  local b = row(world, 2)
  local lamp = world:ball { name = "lamp", radius = 0.1, at = { 0, 3, 0 } }
  local wall = world:box { name = "wall", fixed = true, size = 0.1, at = { 0, 4, 0 } }
  local seen, mechanical = {}, 0
  world:on("merged", function() mechanical = mechanical + 1 end)
  for _, kind in ipairs { "merged", "split", "link", "unlink" } do
    world:on(kind, { layer = "electrical" }, function(e) seen[#seen + 1] = kind .. " " .. e.layer end)
  end
  expect(b[1]:dig_of "electrical"):is(nil)
  local wire = world:link { a = b[1], b = lamp, layer = "electrical" }
  local plug = world:link { a = lamp, b = wall, layer = "electrical" }
  world:link { a = b[2], b = wall, layer = "thermal", bound = true }
  world:step()
  expect(seen):is { "merged electrical", "merged electrical", "link electrical", "link electrical" }
  expect(mechanical):is(1)                               -- the weld
  expect(b[1]:dig_of "electrical" == wall:dig_of "electrical"):is(true)
  expect(b[1]:dig_of("electrical").size):is(3)
  expect(b[1]:dig_of("electrical").layer):is "electrical"
  expect(b[1]:dig_of "electrical" == b[1].dig):is(false)
  expect(wall:dig_of "thermal"):is(nil)
  expect(b[2]:dig_of("thermal").size):is(1)
  expect(lamp:neighbours { kind = "electrical" }):is { b[1], wall }
  expect(lamp:neighbours()):is_empty()
  expect(digbox.path(b[1], wall, { kind = "electrical" })):is { b[1], lamp, wall }
  expect(digbox.path(b[1], wall)):is_empty()
  wire:set(12, 0.5)
  local link = lamp:links { kind = "electrical" }[2]
  expect(link.kind):is "electrical"
  expect(link.effort):is(12.0)
  expect(link.power):is(6.0)
  expect(b[1]:flood("live", 12, { layer = "electrical" })):is(2)
  expect(wall.debug.mess_type):is "live"
  seen = {}
  plug:remove()
  world:step()
  expect(seen):is { "split electrical", "unlink electrical" }
  expect(wall:dig_of "electrical"):is(nil)
  lamp:remove()
  expect(b[1]:dig_of "electrical"):is(nil)
  expect(wire.valid):is(false)
  world:check()
end)

scenario("what is on its way is part of the state: snapshots and files", function(s)
  local world = hang(s)
  local b = row(world, 3)
  local wire = world:link { a = b[1], b = b[3], layer = "hydraulic", ratio = 2 }
  b[1]:flood("wave", 1, { layer = "hydraulic", transform = "ratio", after = 0.1 })
  b[1].dig:broadcast("late", { 1, 2, 3, 4 }, { after = 0.05 })
  local before, snap = world:checksum(), world:snapshot()
  world:run(0.2)
  local after = world:checksum()
  local first = got(world, "late") .. got(world, "wave")
  expect(first):is "ball 1 ball 2 ball 3ball 3"
  expect(world:messages()[4].value):is(2.0)
  world:restore(snap)
  expect(world:checksum()):is(before)
  expect(#world:messages()):is(0)
  world:run(0.2)
  expect(world:checksum()):is(after)
  world:restore(snap)
  world:save "waiting.world"
  local twin = digbox.load "waiting.world"
  expect(twin:checksum()):is(before)
  twin:check()
  twin:run(0.2)
  expect(twin:checksum()):is(after)
  expect(got(twin, "late") .. got(twin, "wave")):is(first)
  wire:remove()
end)

scenario("bad messages are refused at their line, and nothing is half done", function(s)
  local world = hang(s)
  local b = row(world, 2)
  local function refused(text, f) expect(expect(f):fails()):contains(text) end
  refused("unknown route 'dgi' (did you mean 'dig'?)", function() b[1]:send { route = "dgi", name = "x" } end)
  refused("route = 'path' needs to", function() b[1]:send { route = "path", name = "x" } end)
  refused("route = 'dig' has no hops", function() b[1]:send { route = "dig", name = "x", hops = 2 } end)
  refused("a message carries numbers without names; got 'heat'", function() b[1]:send(b[2], "x", { heat = 3 }) end)
  refused("wants a name", function() b[1]:send(b[2]) end)
  refused("after", function() b[1]:send(b[2], "x", 1, { after = -1 }) end)
  refused("unknown layer 'thermic'", function() b[1]:flood("x", 1, { layer = "thermic" }) end)
  refused("cannot be delayed", function() b[1]:flood("x", 1, { after = 1, transform = function() return 1 end }) end)
  refused("wants 'ratio', a number or a function", function() b[1]:flood("x", 1, { transform = true }) end)
  refused("same body", function() world:link { a = b[1], b = b[1], layer = "thermal" } end)
  refused("contacts and joints make the mechanical one", function() world:link { a = b[1], b = b[2], layer = "mechanical" } end)
  world:link { a = b[1], b = b[2], layer = "thermal", bound = true }
  refused("not both", function() world:link { a = b[2], b = b[1], layer = "thermal" } end)
  expect(world:stats().posted):is(0)
  expect(#world:messages()):is(0)
end)

scenario("what is warm and touches is a DIG of the thermal layer", function(s)
  local world = s.world
  world:floor { temperature = 290 }
  local low = world:box { name = "low", size = 0.2, at = { 0, 0.1, 0 }, mass = 1, temperature = 400 }
  local high = world:box { name = "high", size = 0.2, at = { 0, 0.3, 0 }, mass = 1, temperature = 300 }
  local cold = world:box { name = "no part", size = 0.2, at = { 0, 0.5, 0 }, mass = 1 }
  local parted = 0
  world:on("split", { layer = "thermal" }, function() parted = parted + 1 end)
  world:run(0.3)
  expect(low:dig_of "thermal" == high:dig_of "thermal"):is(true)
  expect(cold:dig_of "thermal"):is(nil)
  expect(world:find("floor"):dig_of "thermal"):is(nil)
  expect(low:neighbours { kind = "thermal" }):contains(high)
  local link
  for _, l in ipairs(low:links { kind = "thermal" }) do if l.b == high then link = l end end
  expect(link.effort):near(low.temperature - high.temperature, 1e-9)
  expect(link.power):near(link.effort * link.flow, 1e-12)
  expect(link.flow):above(0)
  world:check()
  local snap = world:snapshot()
  world:run(0.1)
  local before = world:checksum()
  world:restore(snap)
  world:run(0.1)
  expect(world:checksum()):is(before)
  high:teleport { at = { 3, 0.3, 0 } }
  world:run(0.1)
  expect(parted):is(1)
  expect(high:dig_of "thermal"):is(nil)
  world:effect("heat", false)
  world:run(0.1)
  expect(#world:digs "thermal"):is(0)
end)
