-- tests/hard/hard.lua - the hard cases: loads them, runs one at one frame step, watches what must always hold (G1 to G8), and judges.
--
-- A case file returns one case or a list of cases:
--   id, title, seconds            seconds of simulated time; or frames, as many at every frame step
--   fast                          seconds of it in the tests that always run; absent = not there
--   steps                         frame steps; default 1/30, 1/60 and 1/1000; slow = true: 1/60 alone
--   world                         fields of digbox.world
--   size                          length of a body (m), to which penetration and energy are compared; default 1
--   passive = false               something drives it: energy may rise (G3 is not judged)
--   isolated = true               nothing acts from outside: momentum and angular momentum stay (G4)
--   top_speed                     what no body may exceed by over 2 % (G5)
--   chaotic = true                translation changes the run for a good reason: G6 is not judged by place
--   watch_every                   frames between looks at all bodies; default every 1/60 s
--   build(place)                  makes the case, returns its state; place has the methods of a world, see below
--   act(state, t, k)              before frame k = 0, 1, ...
--   frame(state, t, k)            after frame k = 1, 2, ...
--   finish(state, t)              returns the list of criteria: hard.most(name, value, limit), hard.least(name, value, limit)
--
-- `place` passes calls on to the world, moved by a constant offset, so that a case need not know where it stands:
-- place:where(body) is its position as the case wrote it. place.world is the world, place.dt the frame step.
local hard = { digbox = require "digbox" }          -- or what stands for it: peers/shim.lua

hard.files = {
  "B01_heavy_on_light", "B02_tower", "B03_pyramid", "B04_chain", "B05_bridge", "B06_arch", "B07_card_house", "B08_overlap",
  "B09_bullets", "B10_rod_on_wall", "B11_disc", "B12_thin_bodies", "B13_fast_spin", "B14_million_steps", "B15_scale",
  "B16_far_away", "B17_bounces_out", "B18_friction_limits", "B19_crusher", "B20_loops", "B21_stiff_springs", "B22_ragdolls",
  "B23_step_sweep", "B24_invalid_input", "B25_three_spheres", "B26_simultaneous", "B27_painleve", "B28_machines", "B29_many_balls",
  "B30_predictable",
}
hard.steps = { { "1/30", 1 / 30 }, { "1/60", 1 / 60 }, { "1/1000", 1 / 1000 } }

local function wants(wanted, id)
  if not wanted then return true end
  for _, begin in ipairs(wanted) do
    local n = math.min(#begin, #id)
    if id:sub(1, n) == begin:sub(1, n) then return true end
  end
  return false
end

-- All cases in order; wanted: beginnings of ids ("B06" takes B06a and B06b), or nil
function hard.cases(wanted)
  local list = {}
  for _, file in ipairs(hard.files) do
    local found = wants(wanted, file:sub(1, 3)) and require(file) or {}
    for _, case in ipairs(found.id and { found } or found) do
      if wants(wanted, case.id) then list[#list + 1] = case end
    end
  end
  return list
end

-- ---- criteria ----

-- value must be at most (at least) limit; not a number fails
function hard.most(name, value, limit) return { name = name, value = value, limit = limit, pass = value <= limit } end
function hard.least(name, value, limit) return { name = name, value = value, limit = limit, pass = value >= limit, least = true } end

-- How far a criterion is from failing: 1 = just passed, below 1 = failed
function hard.margin(c)
  if c.value ~= c.value then return 0 end
  if c.least then return c.limit == 0 and (c.pass and math.huge or 0) or c.value / c.limit end
  if c.value <= 0 then return math.huge end
  return c.limit / c.value
end

-- ---- a world that stands somewhere ----

local points = { at = true, at_a = true, at_b = true, from = true, to = true }
local movers = { box = true, sphere = true, ball = true, capsule = true, cylinder = true, cone = true, hull = true, body = true,
  rod = true, floor = true, plane = true, hinge = true, slider = true, ball_joint = true, weld = true, distance = true, rope = true,
  spring = true, motor = true, wheel = true, bolt = true }

local function moved(name, fields, offset)
  local copy = {}
  for key, value in pairs(fields or {}) do
    copy[key] = points[key] and hard.digbox.vec(value) + offset or value
  end
  if name == "plane" then
    local n = hard.digbox.vec(copy.normal):normalized()
    copy.offset = (copy.offset or 0) + n:dot(offset)
  elseif movers[name] and copy.at == nil and copy.from == nil and copy.a == nil and name ~= "floor" then
    copy.at = offset
  end
  return copy
end

function hard.place(world, offset)
  local place = { world = world, offset = hard.digbox.vec(offset or { 0, 0, 0 }), dt = world.frame }
  function place:where(body) return body.position - self.offset end
  function place:point(p) return hard.digbox.vec(p) + self.offset end
  return setmetatable(place, { __index = function(_, key)
    if movers[key] then return function(self, fields) return self.world[key](self.world, moved(key, fields, self.offset)) end end
    local value = world[key]
    if type(value) == "function" then return function(self, ...) return value(self.world, ...) end end
    return value
  end })
end

function hard.open(fields, dt, accuracy)
  local all = { accuracy = accuracy or "play", step = dt }
  for k, v in pairs(fields or {}) do all[k] = v end
  return hard.digbox.world(all)
end

-- ---- what always holds ----

local function finite(x) return x == x and x ~= math.huge and x ~= -math.huge end

-- Weight of all bodies, and the sizes of their momenta and angular momenta (about the origin) summed without regard to direction
local function scales(world)
  local weight, flow, spin, g = 0, 0, #world.angular_momentum, #world.gravity
  for _, b in ipairs(world:bodies()) do
    if b.kind == "dynamic" then
      weight, flow, spin = weight + b.mass * g, flow + b.mass * b.speed, spin + b.mass * b.speed * #b.position
    end
  end
  return weight, flow, spin
end

local function mechanical(world)
  local e = world.energy
  return e.kinetic + e.potential + e.elastic - e.work_in, e.kinetic
end

local Watch = {}
Watch.__index = Watch

local function watch(case, world)
  local w = setmetatable({ case = case, world = world, unit = 0, rise = 0, kinetic = 0, speed = 0, costs = {}, bad = nil }, Watch)
  w.energy, w.kinetic = mechanical(world)
  w.weight, w.flow, w.spin = scales(world)
  w.momentum, w.angular = world.momentum, world.angular_momentum
  w.momentum_drift, w.angular_drift = 0, 0
  w.every = case.watch_every or math.max(1, math.floor(1 / 60 / world.frame + 0.5))
  return w
end

function Watch.bodies(w)
  for _, b in ipairs(w.world:bodies()) do
    if b.kind == "dynamic" then
      local x, v, s, q = b.position, b.velocity, b.spin, b.rotation
      local speed = #v
      if not (finite(#x) and finite(speed) and finite(#s) and finite(q.w)) then w.bad = w.bad or (b.name or "a body") end
      w.unit = math.max(w.unit, math.abs(math.sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w) - 1))
      w.speed = math.max(w.speed, speed)
    end
  end
end

function Watch.frame(w, k, stats)
  w.costs[#w.costs + 1] = stats.evaluations + stats.iterations
  if k % w.every ~= 0 then return end
  w:bodies()
  local e, kinetic = mechanical(w.world)
  if not finite(e) then w.bad = w.bad or "the energy" end
  w.rise, w.kinetic = math.max(w.rise, e - w.energy), math.max(w.kinetic, kinetic)
  if w.case.isolated then
    w.momentum_drift = math.max(w.momentum_drift, #(w.world.momentum - w.momentum))
    w.angular_drift = math.max(w.angular_drift, #(w.world.angular_momentum - w.angular))
  end
end

-- The dearest frame over the median of those that cost anything
local function spread(costs)
  local list = {}
  for _, c in ipairs(costs) do
    if c > 0 then list[#list + 1] = c end
  end
  if #list < 10 then return 1 end
  table.sort(list)
  return list[#list] / list[(#list + 1) // 2]
end

function Watch.criteria(w, stats)
  local case, list = w.case, {}
  local scale = math.max(w.kinetic, w.weight * (case.size or 1), 1e-300)
  list[#list + 1] = hard.most("G1 " .. (w.bad or "finite"), w.bad and 1 or 0, 0)
  list[#list + 1] = hard.most("G2 | |q| - 1 |", w.unit, 1e-12)
  if case.passive ~= false then list[#list + 1] = hard.most("G3 energy rise", w.rise / scale, 1e-6) end
  if case.isolated then
    list[#list + 1] = hard.most("G4 momentum", w.flow > 0 and w.momentum_drift / w.flow or w.momentum_drift, 1e-11)
    list[#list + 1] = hard.most("G4 angular momentum", w.spin > 0 and w.angular_drift / w.spin or w.angular_drift, 1e-11)
  end
  if case.top_speed then list[#list + 1] = hard.most("G5 speed", w.speed, 1.02 * case.top_speed) end
  list[#list + 1] = hard.most("G7 dearest frame", spread(w.costs), 20)
  local broken = false
  for _, c in ipairs(list) do broken = broken or not c.pass and c.name:sub(1, 2) ~= "G7" end
  local said = stats.gave_up > 0 or stats.rejected > 0 or stats.worst_residual > 1e-3
  list[#list + 1] = hard.most("G8 says so", broken and not said and 1 or 0, 0)
  return list
end

-- ---- running ----

-- s  What reading the clock adds to what is measured between two readings: up to a third of the frame of a small case
local function clock_cost(clock)
  local least, readings = math.huge, 50
  for _ = 1, 20 do
    local begin = clock()
    for _ = 1, readings do clock() end
    least = math.min(least, (clock() - begin) / (readings + 1))
  end
  return least
end

-- Runs up to `seconds`, calling each(k, stats) after each frame; stops when `over()`. Returns the CPU seconds of the steps.
local function advance(case, state, world, seconds, clock, each, over)
  local cpu, frames, reading = 0, math.floor(seconds / world.frame + 0.5), clock_cost(clock)
  for k = 0, frames - 1 do
    if case.act then case.act(state, k * world.frame, k) end
    local begin = clock()
    world:step()
    cpu = cpu + math.max(0, clock() - begin - reading)
    each(k + 1, world:stats())
    if case.frame then case.frame(state, world.time, k + 1) end
    if over and over() then return cpu, true end
  end
  return cpu, false
end

local function open_case(case, dt, offset, accuracy)
  local world = hard.open(case.world, dt, accuracy)
  local place = hard.place(world, offset)
  local state = case.build(place, hard.digbox) or {}
  state.place, state.world = place, world
  return state, world
end

local function positions(state)
  local list = {}
  for _, b in ipairs(state.world:bodies()) do
    if b.kind == "dynamic" then list[#list + 1] = state.place:where(b) end
  end
  return list
end

-- The same case for `seconds` again, here and (when told) 1024 m away: its checksum, where its bodies are
local function again(case, dt, seconds, offset, accuracy)
  local state, world = open_case(case, dt, offset, accuracy)
  local ok, why = pcall(advance, case, state, world, seconds, function() return 0 end, function() end)
  local sum, where = world:checksum(), ok and positions(state)
  world:close()
  if not ok then error(why, 0) end
  return sum, where
end

local function compare_runs(case, row, dt, o, sum, where)
  local again_sum = again(case, dt, o.compare, nil, o.accuracy)
  row.always[#row.always + 1] = hard.most("G6 same bits again", again_sum == sum and 0 or 1, 0)
  if case.chaotic or case.fixed_place or not where then return end
  local _, there = again(case, dt, o.compare, { 1024, 0, 0 }, o.accuracy)
  local off = 0
  for i, p in ipairs(where) do
    local d = #(there[i] - p) / (case.size or 1)
    off = d == d and math.max(off, d) or math.huge
  end
  row.place = off
end

local function close_all(state)
  state.world:close()
  if state.others then for _, other in ipairs(state.others) do if other.world then other.world:close() end end end
end

local SHORT = 0.5         -- CPU s: what takes less is timed again, for the first steps of a process find no page and no branch known

-- CPU s of the steps: the least of `timings` runs, of which the first took `cpu`
local function quickest(case, dt, seconds, o, cpu)
  for _ = 2, cpu < SHORT and o.timings or 1 do
    local state, world = open_case(case, dt, nil, o.accuracy)
    cpu = math.min(cpu, (advance(case, state, world, seconds, o.clock, function() end)))
    close_all(state)
  end
  return cpu
end

-- o: dt, seconds, clock, limit (CPU s), accuracy, picture (path), timings (runs to take the least time of: 1). Returns a row.
function hard.run(case, o)
  local dt, clock = o.dt or 1 / 60, o.clock or function() return 0 end
  local seconds = o.seconds or case.frames and case.frames * dt or case.seconds
  o = { compare = math.min(1, seconds), limit = o.limit, accuracy = o.accuracy, picture = o.picture, settled = o.repeats ~= false,
        clock = clock, timings = o.timings or 1 }
  local state, world = open_case(case, dt, nil, o.accuracy)
  local row = { case = case, dt = dt, always = {}, traced = 0, conserved = 0, swept = 0, frames = 0 }
  local watched, sum, where = watch(case, world), nil, nil
  local begin = clock()
  local function each(k, stats)
    for _, way in ipairs { "traced", "conserved", "swept" } do row[way] = row[way] + stats[way] end
    row.frames = k
    watched:frame(k, stats)
    if not sum and k * dt >= o.compare - dt / 2 then sum, where = world:checksum(), positions(state) end
  end
  local function over() return o.limit and clock() - begin > o.limit end
  local ok, cpu, late = pcall(advance, case, state, world, seconds, clock, each, over)
  if not ok then
    row.error = tostring(cpu)
    row.over_time = row.error:find("stopped by a signal", 1, true) ~= nil            -- by the limit of the wall time
    row.criteria = { hard.least("simulated time, s", world.time, seconds) }
    if row.over_time then row.error = nil end
    cpu = clock() - begin
  else
    local judged, list = pcall(case.finish, state, world.time)
    row.over_time, row.criteria = late, judged and list or { hard.least("gets to where it can be judged", 0, 1) }
    local broke = false                                                           -- whatever the rest would bring
    for _, c in ipairs(row.criteria) do broke = broke or not c.pass and not c.least end
    if late and not broke then row.criteria[#row.criteria + 1] = hard.least("simulated time, s", world.time, seconds) end
  end
  local stats = world:stats()
  row.time, row.cpu, row.ms_per_s = world.time, cpu, 1000 * cpu / math.max(world.time, 1e-9)
  row.always = watched:criteria(stats)
  row.gave_up, row.why, row.rejected, row.residual = stats.gave_up, stats.gave_up_why or "", stats.rejected, stats.worst_residual
  row.penetration, row.joint_error, row.speed = stats.worst_penetration, stats.worst_joint_error, watched.speed
  if o.picture then world:render { to = o.picture } end
  close_all(state)
  if ok and not late then row.ms_per_s = 1000 * quickest(case, dt, seconds, o, cpu) / math.max(row.time, 1e-9) end
  if ok and not late and o.settled and cpu / seconds * 2 * o.compare < (o.limit or 60) then
    local fine, why = pcall(compare_runs, case, row, dt, o, sum, where)
    if not fine then row.always[#row.always + 1] = hard.most("G6 " .. tostring(why), 1, 0) end
  end
  hard.judge(row)
  return row
end

local function worst(list)
  local found
  for _, c in ipairs(list) do
    if not found or (not c.pass and found.pass) or (c.pass == found.pass and hard.margin(c) < hard.margin(found)) then found = c end
  end
  return found
end

function hard.judge(row)
  row.pass, row.fine = true, true
  for _, c in ipairs(row.criteria) do
    row.pass = row.pass and c.pass
    row.broke = row.broke or not c.pass and not c.least           -- even if the rest could not be run
  end
  local broken = {}
  for _, c in ipairs(row.always) do
    local dearest = c.name:sub(1, 2) == "G7"                     -- counts, of which one impact among quiet frames has many: shown apart
    if dearest then row.dearest = c.value end
    if not c.pass and not dearest then broken[#broken + 1] = ("%s %.3g"):format(c.name, c.value) end
  end
  row.fine, row.broken = #broken == 0, table.concat(broken, "; ")
  row.worst = worst(row.criteria)
  local n = math.max(1, row.traced + row.conserved + row.swept)
  row.shares = ("%.0f/%.0f/%.0f"):format(100 * row.traced / n, 100 * row.conserved / n, 100 * row.swept / n)
end

return hard
