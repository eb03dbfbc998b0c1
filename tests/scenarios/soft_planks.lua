-- soft_planks.lua: beams of rigid pieces against Euler and Bernoulli: sag, first mode, elastica, sudden load, breaking, saw cuts.
-- Only in the plain build: figures of long runs; shorter scenes run the same code under sanitizers.
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local none = { gravity = { 0, 0, 0 } }

-- A cantilever of 1 m, 100 x 20 mm, E = 10 GPa, 500 kg/m^3
local function cantilever(world, more)
  local fields = { from = { 0, 0, 0 }, to = { 1, 0, 0 }, width = 0.1, height = 0.02, E = 10e9, strength = 40e6, density = 500,
                   from_end = "clamped" }
  for k, v in pairs(more or {}) do fields[k] = v end
  return world:plank(fields)
end

-- A plank of 2 m, 200 x 25 mm, on a hinge and a roller
local function bridge(world, more)
  local fields = { from = { -1, 0, 0 }, to = { 1, 0, 0 }, width = 0.2, height = 0.025, E = 10e9, strength = 40e6, density = 500,
                   from_end = "pinned", to_end = "roller", relaxation = 0.02 }
  for k, v in pairs(more or {}) do fields[k] = v end
  return world:plank(fields)
end

local function run(world, seconds, act)
  for _ = 1, math.floor(seconds / world.frame + 0.5) do
    act(world.time)
    world:step()
  end
end

scenario("S4: a cantilever sags by F L^3 / 3 E I, and by 5/16 of it in the middle", function(s)
  local world = s:world(none)
  local p = cantilever(world)
  run(world, 4, function() p:push { at = 1, force = { 0, -10, 0 } } end)
  expect(p:point(1).y):near(-5e-3, 5e-6)                -- the rule asks for 1 %; Simpson's weights leave 0.003 %
  expect(p:point(0.5).y):near(-1.5625e-3, 1.6e-6)
  expect(p.stress):near(10 * 6 / (0.1 * 0.02 ^ 2) / 40e6, 1e-4)         -- M / Z at the clamped end
end)

scenario("S4: its first mode swings at 14.4486 Hz", function(s)
  local world = s:world { gravity = { 0, 0, 0 }, step = 1e-3 }
  local p = cantilever(world, { relaxation = 0 })
  run(world, 0.017, function() p:push { at = 1, force = { 0, -10, 0 } } end)
  local first, last, count, before = nil, nil, 0, p:point(1).y
  while count < 10 do
    world:step()
    local now = p:point(1).y
    if before < 0 and now >= 0 then
      last, count = world.time - world.frame * now / (now - before), count + 1
      first = first or last
    end
    before = now
  end
  expect((count - 1) / (last - first)):near(14.4486, 0.03 * 14.4486)
end)

scenario("S5: the elastica under P L^2 / E I = 2", function(s)
  local world = s:world(none)
  local p = cantilever(world, { segments = 8, relaxation = 0.02, strength = 1e12 })
  local P = 2 * 10e9 * 0.1 * 0.02 ^ 3 / 12
  run(world, 6, function(t) p:push { at = 1, force = { 0, -P * math.min(1, t), 0 } } end)
  local tip, last = p:point(1), p.bodies[8]
  local x = last.rotation:rotate { 1, 0, 0 }
  expect(-tip.y):near(0.493457, 0.005 * 0.493457)
  expect(1 - tip.x):near(0.160642, 0.005 * 0.160642)
  expect(math.atan(-x.y, x.x)):near(0.781750, 0.005 * 0.781750)
end)

scenario("S6: a plank sags under 60 kg, and snaps in the middle at 1666.67 N", function(s)
  local world = s:world(none)
  local p = bridge(world)
  run(world, 4, function() p:push { at = 1, force = { 0, -588.6, 0 } } end)
  expect(p:point(1).y):near(-37.6704e-3, 0.03 * 37.6704e-3)
end)

-- Presses harder and harder until something gives: the load, N, the sag, m, and which joint.
local function press(world, p, at, from)
  local load, sag, event = from, 0, nil
  world:on("broken", function(e) event = event or e end)
  while not event and load < 3000 do
    load = load + 1
    sag = -p:point(at).y
    for _ = 1, 2 do
      if not event then
        p:push { at = at, force = { 0, -load, 0 } }
        world:step()
      end
    end
  end
  return load, sag, event
end

local function breaking(name, at, saw, load, joint, sag)
  scenario(name, function(s)
    local world = s:world(none)
    local p = bridge(world, { name = "plank" })
    if saw then p:saw { at = saw, depth = "10 mm" } end
    run(world, 3, function(t) p:push { at = at, force = { 0, -0.8 * load * math.min(1, t), 0 } } end)
    expect(p.broken):is(0)
    local before = world.momentum
    local digs = #world:digs()
    local got, sank, e = press(world, p, at, 0.8 * load)
    expect(got):near(load, 0.03 * load)
    expect(e.joint.name):is(joint)
    expect(e.stress):between(1, 1.01)
    if sag then expect(sank):near(sag, 0.03 * sag) end
    expect(p.broken):is(1)
    expect(#world:digs()):is(digs + 1)                  -- in the same step
    expect(#before):below(100)
  end)
end

breaking("S6: it snaps in the middle under 1666.67 N there, sunk by 106.67 mm", 1, nil, 1666.67, "plank joint 8", 0.10667)
breaking("S6: at the quarter point it bears 2222.2 N", 0.5, nil, 2222.2, "plank joint 4")
breaking("S6: sawn 10 mm in the middle it bears 600 N", 1, 1, 600, "plank joint 8")
breaking("S6: sawn 10 mm at the quarter it breaks at the cut, under 1200 N in the middle", 1, 0.5, 1200, "plank joint 4")

scenario("S7: a load that comes at once bends twice as far as at rest", function(s)
  local world = s:world { gravity = { 0, 0, 0 }, step = 1e-3 }
  local p = cantilever(world, { relaxation = 0 })
  local peak = 0
  run(world, 0.08, function()
    p:push { at = 1, force = { 0, -10, 0 } }
    peak = math.max(peak, -p:point(1).y)
  end)
  expect(peak):near(2 * 5e-3, 0.02 * 2 * 5e-3)
end)

scenario("row 71: held at both ends, a plank breaks the sooner the nearer the load is to its middle", function(s)
  local bears = {}
  for _, at in ipairs { 0.25, 0.5, 1 } do
    local world = s:world(none)
    local p = bridge(world)
    local load = 0
    while p.broken == 0 and load < 6e3 do
      load = load + 5
      p:push { at = at, force = { 0, -load, 0 } }
      world:step()
    end
    bears[#bears + 1] = load
    local theory = 40e6 * (0.2 * 0.025 ^ 2 / 6) * 2 / (at * (2 - at))             -- strength Z L / (a (L - a))
    expect(load):near(theory, 0.03 * theory)
  end
  expect(bears[1]):above(bears[2])
  expect(bears[2]):above(bears[3])
end)

scenario("a row of bricks bolted end to end lies on another such row, and they slide along each other without a bump", function(s)
  local world = s:world { accuracy = "play" }
  world:floor { friction = 0 }
  local rows = {}
  for row = 1, 2 do
    rows[row] = {}
    for i = 1, 8 do
      local brick = world:box { size = { 0.25, 0.1, 0.1 }, at = { 0.25 * i, 0.1 * row - 0.05, 0 }, density = 2000, friction = 0,
        velocity = { row == 2 and 0.3 or 0, 0, 0 } }
      if i > 1 then world:weld { a = rows[row][i - 1], b = brick, at = { 0.25 * i - 0.125, 0.1 * row - 0.05, 0 } } end
      rows[row][i] = brick
    end
  end
  run(world, 2, function() end)
  expect(rows[2][1].position.x - rows[1][1].position.x):near(0.6, 1e-4)
  expect(rows[2][8].velocity.x):near(0.3, 1e-5)
end)
