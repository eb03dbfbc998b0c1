-- soft_trusses.lua: bars under load against statics: the Warren truss, the redundant hanger, relaxation, rigid triangles, stiffness 1e12.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local none = { gravity = { 0, 0, 0 } }

-- A Warren truss of 4 m bays, 3 m high, on a pin and a roller, EA = 2e8 N
local function warren(world, more)
  local nodes = { ["0"] = { at = { 0, 0, 0 }, fixed = true }, ["4"] = { at = { 16, 0, 0 }, fixed = "y", mass = 200 } }
  for i, x in ipairs { 4, 8, 12 } do nodes[tostring(i)] = { at = { x, 0, 0 }, mass = 200 } end
  for i, x in ipairs { 2, 6, 10, 14 } do nodes[tostring(i + 4)] = { at = { x, 3, 0 }, mass = 200 } end
  local struts = {}
  for k in ("01 12 23 34 56 67 78 05 51 16 62 27 73 38 84"):gmatch "%d+" do struts[#struts + 1] = { k:sub(1, 1), k:sub(2, 2) } end
  local fields = { name = "bridge", nodes = nodes, struts = struts, stiffness = 2e8, plane = "xy" }
  for k, v in pairs(more or {}) do fields[k] = v end
  return world:truss(fields)
end

-- The load grows from `from` within a second.
local function loaded(world, t, nodes, load, seconds, from)
  from = from or 0
  for i = 1, math.floor(seconds / world.frame) do
    local now = from + (load - from) * math.min(1, i * world.frame)
    for name in nodes:gmatch "%S+" do t:push(name, { 0, -now, 0 }) end
    world:step()
  end
end

local function check_forces(t, wanted, share)
  for key, force in pairs(wanted) do expect(t:force(key)):near(force * 1e3, share * math.abs(force) * 1e3) end
end

scenario("S1: 100 kN in the middle of a Warren truss", function(s)
  local world = s:world(none)
  local t = warren(world)
  loaded(world, t, "2", 100e3, 4)
  check_forces(t, { ["01"] = 33.333, ["34"] = 33.333, ["12"] = 100, ["23"] = 100, ["56"] = -66.667, ["78"] = -66.667, ["67"] = -133.333,
    ["05"] = -60.093, ["16"] = -60.093, ["73"] = -60.093, ["84"] = -60.093, ["51"] = 60.093, ["62"] = 60.093, ["27"] = 60.093,
    ["38"] = 60.093 }, 0.005)
  expect(t:node("2").position.y):near(-14.98580e-3, 0.005 * 14.98580e-3)
  expect(t:force "10"):is(t:force "01")
end)

scenario("S2: 100 kN at each of three nodes; rated 250 kN the top chord 6-7 goes first, past 93.75 kN", function(s)
  local world = s:world(none)
  local t = warren(world, { breaks_at = 250e3 })
  loaded(world, t, "1 2 3", 92.8e3, 4)                  -- 1 % below
  expect(t.broken):is(0)
  expect(t:stress "67"):near(0.99, 0.01)
  check_forces(t, { ["67"] = -266.667 * 0.928, ["12"] = 233.333 * 0.928, ["23"] = 233.333 * 0.928, ["05"] = -180.278 * 0.928,
    ["51"] = 180.278 * 0.928, ["16"] = -60.093 * 0.928 }, 0.01)
  local first
  world:on("broken", function(e) first = first or e end)
  loaded(world, t, "1 2 3", 94.7e3, 2, 92.8e3)          -- 1 % above
  expect(first.joint.name):is "67"
  expect(first.stress):between(1, 1.05)
end)

scenario("S3: a hanger of three bars shares its load by their stiffness", function(s)
  local world = s:world(none)
  local h, P = 3, 50e3
  local w = h * math.tan(math.rad(30))
  local t = world:truss { plane = "xy", stiffness = 2e8, struts = { { "A", "D" }, { "B", "D" }, { "C", "D" } },
    nodes = { A = { at = { -w, h, 0 }, fixed = true }, B = { at = { 0, h, 0 }, fixed = true }, C = { at = { w, h, 0 }, fixed = true },
              D = { at = { 0, 0, 0 }, mass = 200 } } }
  loaded(world, t, "D", P, 3)
  expect(t:force "BD"):near(0.4349645 * P, 1e-3 * 0.4349645 * P)
  expect(t:force "AD"):near(0.3262234 * P, 1e-3 * 0.3262234 * P)
  expect(t:force "CD"):near(0.3262234 * P, 1e-3 * 0.3262234 * P)
end)

scenario("a budget is kept, and errors say what is wrong", function(s)
  local world = s.world
  expect(warren(world, { price = 12, budget = 180 }).cost):is(180)
  local function fails(more, text) expect(expect(function() warren(s:world(none), more) end):fails()):contains(text) end
  fails({ price = 12, budget = 179 }, "15 struts cost 180, the budget is 179")
  fails({ struts = { { "0", "9" } } }, "unknown node '9'")
  fails({ nodes = { A = { mass = 1 } } }, "nodes.A: at is missing")
  local t = warren(s:world(none))
  expect(expect(function() return t:force "09" end):fails()):contains "unknown strut '09'"
end)

-- A strut without mass to speak of goes back as e^(-t / tau): 63 % after tau
for _, tau in ipairs { 0.1, 0.5, 2 } do
  scenario(("row 69: a strain goes back by 63 %% in the relaxation time, %g s"):format(tau), function(s)
    local world = s:world { gravity = { 0, 0, 0 }, sleeping = false }
    local wall = world:box { fixed = true, size = 0.1 }
    local bob = world:ball { radius = 0.05, mass = 0.01, at = { 1.1, 0, 0 } }
    world:strut { a = bob, b = wall, stiffness = 1e4, relaxation = tau, length = 1 }
    local gone
    while not gone and world.time < 3 * tau do
      local before = bob.position.x
      world:step()
      if bob.position.x <= 1 + 0.1 * math.exp(-1) then
        gone = world.time - world.frame * (1 + 0.1 * math.exp(-1) - bob.position.x) / (before - bob.position.x)
      end
    end
    expect(gone):near(tau, 0.05 * tau)
  end)
end

-- Four particles at the corners of a square, all six distances held by struts as stiff as they get
local function square(world, stiffness)
  local n = {}
  for i, p in ipairs { { 0, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 } } do n[("ABCD"):sub(i, i)] = { at = p, mass = 0.25 } end
  return world:truss { nodes = n, stiffness = stiffness,
    struts = { { "A", "B" }, { "B", "C" }, { "C", "D" }, { "D", "A" }, { "A", "C" }, { "B", "D" } } }
end

scenario("row 72: a force on one of four particles moves them like a rigid body", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local t = square(world, 1e9)
  local corners = {}
  for i, at in ipairs { { 0, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 } } do corners[i] = digbox.sphere { radius = 1e-3, at = at } end
  local rigid = world:body { parts = corners, mass = 1, at = { 0, 0, 5 } }
  for _ = 1, 60 do
    t:push("A", { 0, -2, 0 })
    rigid:push { force = { 0, -2, 0 }, at = rigid.position + rigid.rotation:rotate { 0, 0, 0 } }
    world:step()
  end
  local a, c = t:node("A").position, t:node("C").position
  local middle = rigid.position + rigid.rotation:rotate { 0.5, 0.5, 0 } - digbox.vec(0, 0, 5)
  expect(#(t.position - middle)):below(1e-3 * #(middle - digbox.vec(0.5, 0.5, 0)))
  local turned, angle = math.atan(c.y - a.y, c.x - a.x) - math.pi / 4, rigid.rotation.angle
  expect(turned):near(angle, 1e-3 * angle)
  expect(#(c - a)):near(math.sqrt(2), 1e-6)
end)

scenario("row 8: two opposite forces turn a body of particles with torque over inertia", function(s)
  local world = s:world { gravity = { 0, 0, 0 }, step = 1 / 240 }
  local t = square(world, 1e9)
  for _ = 1, 24 do
    t:push("A", { 0, -2, 0 })
    t:push("B", { 0, 2, 0 })
    world:step()
  end
  local d = t:node("C").position - t:node("A").position
  local turned = math.atan(d.y, d.x) - math.pi / 4
  expect(turned):near(2 * 1 / 0.5 * 0.1 ^ 2 / 2, 0.01 * 0.02)         -- tau / I t^2 / 2
  expect(t.position):near({ 0.5, 0.5, 0 }, 1e-6)
end)

scenario("stiffness 1e12 on masses from 1 g to 100 t, at 1/30 s and without damping, gains no energy in 10 000 steps", function(s)
  local world = s:world { gravity = { 0, 0, 0 }, step = 1 / 30, sleeping = false }
  local t = world:truss { stiffness = 1e12, damping = 0,
    struts = { { "A", "B" }, { "B", "C" }, { "C", "A" }, { "A", "D" }, { "B", "D" }, { "C", "D" } },
    nodes = { A = { at = { 0, 0, 0 }, mass = 1e-3 }, B = { at = { 1, 0, 0 }, mass = 1 }, C = { at = { 0, 1, 0 }, mass = 1e3 },
              D = { at = { 0, 0, 1 }, mass = 1e5 } } }
  t:node("A"):hit { impulse = { 1e-3, 2e-3, 0 } }
  t:node("B"):hit { impulse = { 0, 0, 5 } }
  world:step()
  local before, most = world.energy.total, 0
  for _ = 1, 10000 do
    world:step()
    most = math.max(most, world.energy.total)
  end
  expect(most):at_most(before * (1 + 1e-6))
  expect(#t:sig()):is(6)
end)

-- A mass on five struts of its line, pulled all at once: between two breaks m x'' = P - n k x, in closed form, and the next goes
-- when k x reaches its strength. All five go within one frame.
local zip = { mass = 100, k = 1e6, pull = 2000, strength = { 300, 330, 390, 400, 500 } }

local function zip_times()
  local times, t, x, v = {}, 0, 0, 0
  for i, strength in ipairs(zip.strength) do
    local n = #zip.strength - i + 1
    local w, rest = math.sqrt(n * zip.k / zip.mass), zip.pull / (n * zip.k)
    local a, b = x - rest, v / w
    local r, phase = math.sqrt(a * a + b * b), math.atan(b, a)
    local s = (phase - math.acos((strength / zip.k - rest) / r)) % (2 * math.pi) / w
    t, x, v = t + s, strength / zip.k, w * (b * math.cos(w * s) - a * math.sin(w * s))
    times[i] = t
  end
  return times
end

local function zip_broken(world, way)
  local ball = world:ball { radius = 0.1, mass = zip.mass, at = { 0, 0, 0 }, integrator = way }
  for i, strength in ipairs(zip.strength) do
    world:strut { name = tostring(i), a = ball, at_b = { 0, 1, 0 }, stiffness = zip.k, breaks_at = strength }
  end
  ball:push { force = { 0, -zip.pull, 0 }, lasts = 1 }
  local broken = {}
  world:on("broken", function(e) broken[#broken + 1] = { name = e.joint.name, time = e.time } end)
  world:run(0.1)
  return broken, world.energy
end

test.each_accuracy("struts that go one after the other do so within one frame, each at its time", function(s)
  local broken, e = zip_broken(s:world { gravity = { 0, 0, 0 }, accuracy = s.accuracy })
  local times, fine = zip_times(), s.accuracy == "study" or s.accuracy == "reference"      -- below, the swing is too fast to be followed
  expect(#broken):is(#times)
  expect(times[5]):below(1 / 60)
  for i, t in ipairs(times) do
    expect(broken[i].name):is(tostring(i))
    expect(broken[i].time):near(t, fine and 1e-7 or 2 / 60)
  end
  if fine then expect(e.numerical):near(0, 1e-6 * e.work_in) end
end)

test.each_accuracy("struts that go one after the other, swept: in order, at different times, within a frame of them", function(s)
  local broken = zip_broken(s:world { gravity = { 0, 0, 0 }, accuracy = s.accuracy }, "verlet")
  expect(#broken):is(#zip.strength)
  for i, t in ipairs(zip_times()) do
    expect(broken[i].name):is(tostring(i))
    expect(broken[i].time):near(t, 2 / 60)
    if i > 1 then expect(broken[i].time):above(broken[i - 1].time) end
  end
end)

-- What is pushed that hard flies metres in a step but for its struts: a solve that began there found the truss upside down, where it is in
-- balance, too, and struts that bear 500 N had broken at 2 kN.
scenario("light nodes under strong pushes stay on their side of the truss", function(s)
  for _, mass in ipairs { 1e-6, 1e-4, 1e-3, 1e-2 } do
    for _, push in ipairs { 10, 1000, 10000 } do
      for _, plan in ipairs { "sketch", "play", "study" } do
        local world = s:world { accuracy = plan }
        local truss = world:truss {
          nodes = { A = { at = { 0, 0, 0 }, fixed = "xyz" }, B = { at = { 2, 0, 0 }, fixed = "yz" },
                    C = { at = { 1, 1, 0 }, mass = mass, fixed = "z" } },
          struts = { { "A", "B" }, { "A", "C" }, { "B", "C" } }, stiffness = 1e6, breaks_at = 2.5 * push,
        }
        for _ = 1, 30 do
          truss:push("C", { 0, -push, 0 })
          world:step()
        end
        expect(truss.broken):is(0)
        expect(truss:node "C".position.y):near(1, 0.03)
        expect(truss:force "AC"):near(-push / math.sqrt(2), 0.02 * push)
        expect(truss:force "AB"):near(push / 2, 0.02 * push)
      end
    end
  end
end)

-- A blow that a frame's mean finds too strong in every link of a rope: all nine let go one after the other, by what each bore beside
-- the first, and at "sketch" two links threw the load back up at 6 m/s, with 84 times what they bear. Now a part of the step in which a
-- joint is found overloaded is done again without it, before the next is judged. What is left of a rope whips: some snap once more at
-- "study", and up to twice where it is swept.
scenario("a rope that is jerked does not shatter, and does not throw its load", function(s)
  for _, segments in ipairs { 2, 8, 16 } do
    for _, plan in ipairs { "sketch", "play", "study" } do
      local world, broken = s:world { accuracy = plan }, 0
      local hook = world:box { fixed = true, size = 0.1, at = { 0, 5, 0 } }
      local load = world:box { size = 0.2, mass = 10, at = { 0, 4, 0 } }
      world:rope { a = hook, b = load, length = 3.3, segments = segments, mass = 0.1, breaks_at = "90 N" }
      world:on("broken", function() broken = broken + 1 end)
      world:run "2 s"
      expect(broken):at_least(1)
      expect(broken):at_most(plan == "study" and 2 or 3)
      expect(load.velocity.y):near(-2 * 9.81, 0.5)          -- each snap takes up to 1.5 N s
    end
  end
end)
