-- tests/accuracy/suite_spec.lua - the fast part of the accuracy suite: every scene at the default plan stays within its bound.
--
-- Bounds are errors in the unit of the scene (its metric). They are never about time. The whole suite: run.lua and judge.lua.
-- Only in the plain build: errors against bounds; the unit tests run the same code under sanitizers.
-- Not in RENDER=0: physics alone.
local test = require "digbox.test"
local suite = require "suite"
local verdicts = require "verdicts"

-- Error at "play". Where the scene has a goal, that is its bound; these are the others.
local bounds = {
  A02z = 1e-9, A03h = 1e-8, A05b = 1e-8, A07p = 1e-6, A08l = 1e-2, A08p = 1e-5, A09n = 1e-6, A10c = 1e-9,
  A15a = 1e-5, A15b = 1e-4, A15c = 1e-5, A16a = 1e-6, A16b = 1e-6, A16c = 1e-7, A16d = 3e-7,
  A17a = 1e-9, A17b = 1e-9, A17c = 1e-8, A17d = 1e-9, A18 = 1e-6, A18p = 1e-9, A19a = 1e-5, A19b = 1e-5, A20 = 1e-5,
}

for _, scene in ipairs(suite.scenes()) do
  local bound = bounds[scene.id] or scene.goal and scene.goal.fast[1] or scene.metric == "verdict" and 0
  if bound and not scene.slow then
    test.scenario(("%s %s: within %g %s"):format(scene.id, scene.title, bound, scene.metric), function(s)
      local row = suite.run(scene, "play", s.cpu_seconds)
      test.expect(row.error):at_most(bound)
      test.expect(row.rejected):is(0)
    end)
  end
end

-- Its first turn is 1.2 ms after the end of a frame. Scaled to its energy there by its velocity alone, it lost its time: 2.9e-9, 6.9e-10.
test.scenario("a swing that turns back near the end of a frame keeps its time", function(s)
  for id, bound in pairs { A07 = 1e-10, A07p = 5e-11 } do
    local row
    for _, scene in ipairs(suite.scenes { id }) do
      if scene.id == id then row = suite.run(scene, 1e-7, s.cpu_seconds) end
    end
    test.expect(row.error):below(bound)
  end
end)

-- Ten links on torsion springs with strong dampers: the stages of a step that is refused go anywhere, by whole turns, too.
local function cantilever(s, accuracy)
  local world, links = s:world { accuracy = accuracy, sleeping = false, gravity = { 0, 0, -9.81 } }, {}
  for i = 1, 10 do
    links[i] = world:box { size = { 0.1, 0.01, 0.01 }, mass = 0.1, at = { 0.1 * (i - 0.5), 0, 0 }, collides = false }
    world:hinge { a = links[i], b = links[i - 1], at = { 0.1 * (i - 1), 0, 0 }, axis = { 0, 1, 0 },
                  spring = { stiffness = 20, damping = 4 } }
  end
  return world, links
end

test.scenario("steps that are refused leave no turns in the angles of joints", function(s)
  local world = cantilever(s, 1e-8)
  world:step()                                          -- it had wound a spring by one turn: 395 J
  test.expect(world:stats().traced):is(1)
  test.expect(world:stats().refused):above(0)
  test.expect(math.abs(world.energy.numerical)):below(1e-12)
end)

-- Traced at 1e-9, by 55,000 evaluations a frame: 0.94808124859407, -0.05886856154686.
test.scenario("what strong dampers hold back is extrapolated from few steps", function(s)
  for accuracy, bound in pairs { play = 1e-9, [1e-5] = 1e-10, study = 1e-10 } do
    local world, links = cantilever(s, accuracy)
    world:run "0.1 s"
    test.expect(#(links[10].position - { 0.94808124859407, 0, -0.05886856154686 })):below(bound)
    test.expect(world:stats().all_conserved):is(6)
    test.expect(world:stats().gave_up):is(0)
    test.expect(math.abs(world.energy.numerical)):below(100 * bound)
    test.expect(links[10].speed):between(1, 1.2)
  end
end)

test.scenario("what creeps at a fine accuracy is not held before its end", function(s)
  local world = cantilever(s, "study")
  world:run "9 s"
  local before = world.energy.elastic                   -- it stood still from 6.5 s on, 4e-7 m off
  world:run "2 s"
  test.expect(math.abs(world.energy.elastic - before)):between(1e-13, 1e-8)
end)

-- 1 kg on 1e8 N/m swings 1592 times a second, by 1e-7 m: no plan coarser than that has to see where, and each finer one follows it.
test.scenario("a spring too stiff for the frame swings in closed form, whatever the tolerance", function(s)
  for _, accuracy in ipairs { "sketch", "play", "study", "reference", 1e-8, 1e-10 } do
    local row = suite.run(suite.scenes { "A16d" }[1], accuracy, s.cpu_seconds, 0)
    test.expect(row.gave_up):is(0)
    test.expect(row.traced):is(120)
    test.expect(row.substeps):is(120)
    test.expect(row.error):below(1e-12)
  end
end)

test.scenario("slow loops are traced where the budget lasts, with one error at all such tolerances", function(s)
  for _, scene in ipairs(suite.scenes { "A19a", "A19b", "A20" }) do
    for _, accuracy in ipairs { 1e-5, "study" } do
      local row = suite.run(scene, accuracy, s.cpu_seconds, 0)
      test.expect(row.error):below(2e-10)
      test.expect(row.gave_up):is(0)
    end
  end
end)

test.scenario("a mechanism of 81 bars in 40 loops is traced at the finest plan", function(s)
  local scene = setmetatable({ seconds = 1 }, { __index = suite.scenes { "A19c" }[1] })
  local row = suite.run(scene, "reference", s.cpu_seconds, 0)
  test.expect(row.traced):is(60)
  test.expect(row.error):below(1e-10)
end)

-- Blows at a row of leaning dominoes: one corner taken after the other, the sweeps of the fourth found, in 4294 of them, an outcome in
-- which they turn aside; then contacts chattered, and the rest was swept. All that happens is alike on both sides of the row's plane.
test.scenario("a row of dominoes falls in its plane, followed from blow to blow", function(s)
  local function last_falls(accuracy)
    local world, row = s:world { accuracy = accuracy, sleeping = false, gravity = { 0, 0, -9.81 } }, {}
    world:plane { normal = { 0, 0, 1 }, friction = 0.5 }
    for i = 1, 6 do
      row[i] = world:box { size = { 0.1, 0.5, 1 }, mass = 30, at = { 0.5 * (i - 1), 0, 0.5 }, friction = 0.5,
                           velocity = i == 1 and { 0.5, 0, 0.05 } or nil, spin = i == 1 and { 0, 1, 0 } or nil }
    end
    world:run "1.6 s"
    for _, domino in ipairs(row) do test.expect(math.abs(domino.position.y)):below(1e-12) end
    test.expect(world:stats().gave_up):is(0)
    test.expect(world:stats().all_swept):is(0)
    return 2 * math.atan(row[6].rotation.y, row[6].rotation.w)
  end
  local tilt = last_falls "reference"
  test.expect(tilt):above(0.1)
  test.expect(math.abs(last_falls "study" - tilt)):below(1e-8)
end)

test.scenario("the references of the scenes agree with the published digits", function()
  for _, scene in ipairs(suite.scenes()) do
    if scene.check then test.expect(scene.check(scene.world and scene.world.step or 1 / 60)):below(2e-12) end
  end
end)

-- ---- the judge itself ----

-- Rows of an imaginary integrator: error = factor tol^power, never below floor; work as order p needs it
local function rungs(power, floor, p, factor)
  local rows = {}
  for _, tolerance in ipairs(suite.ladder) do
    local error = math.max((factor or 1) * tolerance ^ power, floor)
    rows[#rows + 1] = { engine = "digbox", setting = tostring(tolerance), error = error, evaluations = 100 * tolerance ^ (-power / p) }
  end
  return rows
end

local function passes(rows, scene)
  local text = {}
  for i, v in ipairs(verdicts.judge(scene or { id = "X" }, rows)) do text[i] = v.name .. "=" .. tostring(v.pass) end
  return table.concat(text, " ")
end

test.scenario("verdicts tell a good integrator from bad ones", function()
  test.expect(passes(rungs(1, 1e-14, 5))):is "order=true floor=true proportionality=true bound=true"
  test.expect(passes(rungs(1, 1e-14, 2))):is "order=false floor=true proportionality=true bound=true"
  test.expect(passes(rungs(1, 1e-7, 5))):is "order=true floor=false proportionality=true bound=false"
  test.expect(passes(rungs(0.5, 1e-14, 5))):is "order=true floor=false proportionality=false bound=false"
  test.expect(passes(rungs(1, 1e-14, 5, 50))):is "order=true floor=false proportionality=true bound=false"
end)

-- One second of frames; below 1e-6 as good as a fifth order is, above it at one step a frame, with the error of that
local function frame_long(error_of)
  local rows = rungs(1, 1e-14, 5)
  for _, row in ipairs(rows) do
    local tolerance = tonumber(row.setting)
    row.steps = math.max(60, math.floor(60 * (tolerance / 1e-6) ^ -0.2))
    row.evaluations = 7 * row.steps
    row.error = error_of(tolerance)
  end
  return rows
end

test.scenario("verdicts judge proportionality where steps are shorter than a frame, and say from where on", function()
  local scene = { id = "X", seconds = 1 }
  local function verdict(rows) return verdicts.judge(scene, rows)[3] end
  local v = verdict(frame_long(function(tolerance) return math.min(tolerance, 1e-6) end))
  test.expect(v.pass):is(true)
  test.expect(v.from):near(1e-7, 1e-12)
  -- a plateau at shorter steps is one still, and so is a slow fall
  test.expect(verdict(frame_long(function(tolerance) return tolerance > 1e-9 and 1e-6 or tolerance end)).pass):is(false)
  test.expect(verdict(frame_long(function(tolerance) return math.sqrt(tolerance) end)).pass):is(false)
end)

test.scenario("verdicts read CSV, and judge the goal without looking at the time", function()
  local rows = verdicts.read(suite.header .. "\nX,digbox,play,1e-7,1000,1,1,0,0,0,,0\nX,digbox,reference,1e-9,1,1,1,0,0,0,,0\n")
  test.expect(#rows):is(2)
  local goal = { fast = { 1e-6, 0.1 }, accurate = { 1e-10, 0.1 } }
  test.expect(passes(rows, { id = "X", goal = goal })):is "goal at play=true goal at reference=false"
end)
