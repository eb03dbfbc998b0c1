-- tests/accuracy/suite.lua - the scenes of the accuracy suite: loads them, runs one at one setting, and measures what came out.
--
-- A scene file returns one scene or a list of scenes:
--   id, title, seconds            seconds of simulated time
--   metric, scale                 unit of the error; length (or angle, or 1 for relative errors) that a tolerance refers to
--   goal                          { fast = { error, ms/s }, accurate = { error, ms/s } }, or nil
--   world                         fields of digbox.world; accuracy and sleeping = false are added
--   conserves                     { energy = true, momentum = true, angular = true }: what stays constant in the exact motion
--   build(world, digbox)          makes the scene, returns its state (a table)
--   act(state, k)                 before frame k = 0, 1, ... (movers), if given
--   frame(state, t, k)            after every frame, if given
--   finish(state, t)              returns { error = number, ... } with whatever else is worth printing
--   self_converged                finish returns `value` instead of `error`; the error is against the same scene at a finer setting
--   rounding                      relative floor of the error where the motion amplifies rounding; default 1e-11
--   limits                        { order =, floor =, proportionality =, bound = }: why that verdict is no where it is, with a figure
--   check(dt)                     how far the scene's own reference is from the published digits, if there are any
--   slow                          not part of the fast subset
local digbox = require "digbox"

local suite = {}

suite.files = {
  "A01_projectile", "A02_bounce", "A03_slide", "A04_roll", "A05_bowling", "A06_threshold", "A06_limits", "A07_pendulum",
  "A08_double_pendulum", "A09_rotor", "A10_cradle", "A11_table", "A12_rocking", "A13_spin_collision", "A14_turntable", "A15_tops",
  "A16_oscillators", "A17_statics", "A18_shaken_table", "A19_mechanisms", "A20_bricard", "S01_rolling", "S02_bouncing", "S03_666",
  "S04_dominoes",
}

suite.plans = { "sketch", "play", "study", "reference" }
suite.ladder = { 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12 }
suite.finest = 1e-9             -- of scenes that are their own reference

local function wants(wanted, id, length)
  if not wanted then return true end
  for _, begin in ipairs(wanted) do
    local n = math.min(#begin, length or #begin)
    if id:sub(1, n) == begin:sub(1, n) then return true end
  end
  return false
end

-- All scenes in order; wanted: list of ids, or beginnings of ids ("A06" takes A06a to A06d), or nil
function suite.scenes(wanted)
  local list = {}
  for _, file in ipairs(suite.files) do
    local found = wants(wanted, file, 3) and require("scenes." .. file) or {}
    for _, scene in ipairs(found.id and { found } or found) do
      if wants(wanted, scene.id) then list[#list + 1] = scene end
    end
  end
  return list
end

local function mechanical(world)
  local e = world.energy
  return e.kinetic + e.potential + e.elastic, e.kinetic + e.elastic, e.numerical
end

-- Scales: of momentum, the sum of all m |v|; of energy, for what comes to rest, the weight of all over one metre
local function scales(world)
  local flow, mass = 0, 0
  for _, b in ipairs(world:bodies()) do
    if b.kind == "dynamic" then flow, mass = flow + b.mass * b.speed, mass + b.mass end
  end
  return flow, mass * #world.gravity
end

-- Watches what is conserved; returns a function to call after each frame, and one that gives the drifts.
local function watch(scene, world)
  local keeps = scene.conserves or {}
  local energy, kinetic = mechanical(world)
  local momentum, angular = world.momentum, world.angular_momentum
  local flow, weight = scales(world)
  if not keeps.energy then kinetic = math.max(kinetic, weight) end
  local w = { energy = 0, momentum = 0, angular = 0, kinetic = kinetic, flow = flow, spin = #angular }
  function w.frame()
    local e, k = mechanical(world)
    w.kinetic = math.max(w.kinetic, k)
    w.energy = math.max(w.energy, math.abs(e - energy))
    if keeps.momentum then w.momentum = math.max(w.momentum, #(world.momentum - momentum)) end
    if keeps.angular then w.angular = math.max(w.angular, #(world.angular_momentum - angular)) end
  end
  function w.result()
    local _, _, numerical = mechanical(world)
    local scale = math.max(w.kinetic, 1e-300)
    local drift = (keeps.momentum or keeps.angular) and
      math.max(w.flow > 0 and w.momentum / w.flow or 0, w.spin > 0 and w.angular / w.spin or 0) or nil
    return (keeps.energy and w.energy or math.abs(numerical)) / scale, drift
  end
  return w
end

local counted = { "evaluations", "refused", "trace_events", "substeps" }       -- summed over frames
local ways = { "traced", "conserved", "swept" }                                -- frames in which a group went this way

local function open_world(scene, accuracy)
  local fields = { accuracy = accuracy, sleeping = false, gravity = { 0, 0, -9.81 } }
  for k, v in pairs(scene.world or {}) do fields[k] = v end
  return digbox.world(fields)
end

-- What two readings of the clock are apart with nothing between them, s
local function clock_seconds(clock)
  local least = math.huge
  for _ = 1, 3 do
    local sum = 0
    for _ = 1, 1000 do
      local begin = clock()
      sum = sum + clock() - begin
    end
    least = math.min(least, sum / 1000)
  end
  return least
end

local function run_in(world, scene, clock, accuracy)
  local state = scene.build(world, digbox)
  state.world = world
  local watched = watch(scene, world)
  local row = { scene = scene.id, engine = "digbox", setting = tostring(accuracy), cpu = 0 }
  for _, name in ipairs(counted) do row[name] = 0 end
  for _, way in ipairs(ways) do row[way] = 0 end
  local frames, idle = math.floor(scene.seconds / world.frame + 0.5), clock_seconds(clock)
  for k = 0, frames - 1 do
    if scene.act then scene.act(state, k) end
    local begin = clock()
    world:step()
    row.cpu = row.cpu + math.max(clock() - begin - idle, 0)
    local now = world:stats()
    for _, name in ipairs(counted) do row[name] = row[name] + (now[name] or 0) end
    for _, way in ipairs(ways) do row[way] = row[way] + ((now[way] or 0) > 0 and 1 or 0) end
    watched.frame()
    if scene.frame then scene.frame(state, world.time, k + 1) end
  end
  local result = scene.finish(state, world.time)
  local last = world:stats()
  row.result, row.error, row.value = result, result.error, result.value
  row.ms_per_s = 1000 * row.cpu / world.time
  row.events = row.trace_events > 0 and row.trace_events or last.events
  row.rejected, row.gave_up = last.rejected, last.gave_up or 0
  row.gave_up_why = last.gave_up_why
  row.frames = frames
  row.energy_drift, row.momentum_drift = watched.result()
  return row
end

-- The frames again with nothing between them but what moves movers: what a user pays who only runs the scene. -> ms a simulated second
local function time_bare(world, scene, clock)
  local state = scene.build(world, digbox)
  state.world = world
  local frames, begin = math.floor(scene.seconds / world.frame + 0.5), clock()
  if scene.act then
    for k = 0, frames - 1 do
      scene.act(state, k)
      world:step()
    end
  else
    world:step(frames)
  end
  return 1000 * (clock() - begin) / world.time
end

-- work(world, scene, clock) in a world of its own at one accuracy. clock: CPU seconds.
local function run_once(work, scene, accuracy, clock)
  local world = open_world(scene, accuracy)
  local ok, result = pcall(work, world, scene, clock, accuracy)
  world:close()
  if not ok then error(result, 0) end
  return result
end

-- The value that a scene of no closed form converges to
local function reference_value(scene, clock)
  if not scene.reference then scene.reference = run_once(run_in, scene, scene.finest or suite.finest, clock).value end
  return scene.reference
end

local LONG = 1                  -- s of CPU: what takes longer is not repeated
local ENOUGH = 0.05             -- s of CPU of the bare runs together. REPEATS, LONG and ENOUGH of tests/peers/suite.c are the same

-- Runs a scene once with all readings, which warms caches and memory up; then bare, up to `repeats` times, of which the least CPU time
-- counts. row: error in scene.metric, `relative` = error / scale.
function suite.run(scene, accuracy, clock, repeats)
  local row = run_once(run_in, scene, accuracy, clock)
  local left, together, least = row.cpu < LONG and repeats or 0, 0, math.huge
  while left > 0 and together < ENOUGH do
    local ms = run_once(time_bare, scene, accuracy, clock)
    left, together, least = left - 1, together + ms * scene.seconds / 1000, math.min(least, ms)
  end
  if least < math.huge then row.ms_per_s = least end
  if scene.self_converged then row.error = math.abs(row.value - reference_value(scene, clock)) end
  if row.error ~= row.error then row.error = math.huge end
  row.relative = row.error / (scene.scale or 1)
  return row
end

suite.header = "scene,engine,setting,error,cpu_ms_per_s,steps,evaluations,refused,events,energy_drift,momentum_drift,gave_up"

-- steps: parts of frames by any way, as counted by the engine; frames themselves where it counts none
function suite.csv(row)
  local drift = row.momentum_drift
  return ("%s,%s,%s,%.6e,%.5g,%d,%d,%d,%d,%.3e,%s,%d"):format(row.scene, row.engine, row.setting, row.error, row.ms_per_s,
    math.max(row.substeps, row.frames), row.evaluations, row.refused, row.events, row.energy_drift,
    drift and ("%.3e"):format(drift) or "", row.gave_up)
end

return suite
