-- digbox/run.lua - world:step, world:run and tasks: the order of things around one frame step.

local core = ...
local type, pcall, error = type, pcall, error
local create, resume, status, yield, running = coroutine.create, coroutine.resume, coroutine.status, coroutine.yield, coroutine.running

local methods, getters = core.types.world.methods, core.types.world.getters

-- ---- tasks ----

local Task = {}
Task.__index = function(_, key)
  local method = Task[key]
  if not method then core.unknown("task", "has no field or method", tostring(key), { wait = true, wait_until = true }) end
  return method
end
Task.__metatable = false
Task.__name = "task"
local make_task, open_task = core.opaque(Task)

local function check_inside(handle, what)
  local task = open_task(handle)
  if running() ~= task.thread then core.fail("%s can only be called inside the task itself", what) end
  return task
end

core.declare_type("task", "A function that runs beside the world and can wait.", Task)
core.declare("task:wait", { "Goes on after that time.", takes = { { "time", "real s >=0", "how long; not given: until after the next step",
  optional = true } } })
core.declare("task:wait_until", { "Goes on when the condition holds: true; or when the limit passed first: false.", takes = {
  { "condition", "function", "asked after each step" }, { "limit", "real s >=0", "how long at most", optional = true } },
    gives = "boolean" })

-- task:wait "0.5 s"
function Task.wait(handle, time)
  local task = check_inside(handle, "task:wait")
  task.wake, task.condition = task.world.time + (time == nil and 0 or core.seconds(time, "task:wait")), nil
  yield()
end

-- task:wait_until(condition [, limit]) -> true, or false when the limit passed first
function Task.wait_until(handle, condition, limit)
  local task = check_inside(handle, "task:wait_until")
  if type(condition) ~= "function" then core.fail("task:wait_until wants a function; got %s", core.type(condition)) end
  task.wake = limit ~= nil and task.world.time + core.seconds(limit, "task:wait_until") or math.huge
  task.condition = condition
  return yield()
end

local function go_on(state, task, ...)
  state.in_task = true
  local ok, message = resume(task.thread, ...)
  state.in_task = nil
  if not ok then
    task.done = true
    error(message, 0)
  end
  task.done = status(task.thread) == "dead"
end

local function is_due(task, now)
  if task.condition then
    if task.condition() then return true, true end
    return now >= task.wake - 1e-9, false
  end
  return now >= task.wake - 1e-9, true
end

local function run_tasks(world, state)
  local list, kept = state.tasks, {}
  state.tasks = {}
  for _, task in ipairs(list) do
    if not task.done then
      state.in_task = true
      local ok, due, result = pcall(is_due, task, world.time)
      state.in_task = nil
      if not ok then error(due, 0) end
      if due then go_on(state, task, result) end
    end
    if not task.done then kept[#kept + 1] = task end
  end
  for _, task in ipairs(state.tasks) do kept[#kept + 1] = task end     -- spawned meanwhile
  state.tasks = kept
end

core.declare("world:spawn", { "Starts a task: runs at once up to its first wait, then after steps.",
  takes = { { "run", "function", "called with the task" } }, gives = "task" })

-- world:spawn(function(task) ... end) -> task: runs at once up to its first wait, then after steps
function methods.spawn(world, fn)
  if type(fn) ~= "function" then core.fail("world:spawn wants a function; got %s", core.type(fn)) end
  local state = core.lua_state(world)
  local outer = state.in_task
  core.quiet(world)
  local task = { world = world, done = false, wake = world.time }
  local handle = make_task(task)
  task.thread = create(function() fn(handle) end)
  go_on(state, task)
  state.in_task = outer
  if not task.done then state.tasks[#state.tasks + 1] = task end
  return handle
end

-- world.tasks: how many are still at work
function getters.tasks(world)
  return #core.lua_state(world).tasks
end

function getters.seed(world)
  return core.state(world).seed
end

-- ---- regions ----

core.declare("world:region", { "Makes a part of space with laws of its own.", fields = {
  shape = { "any", "its shape, also as the first item or as sphere = {...}, box = {...}", type = "shape" },
  at = { "vec m", "where it is", default = "{0, 0, 0}" }, rotation = { "quat 1", "how it is turned" },
  laws = { "any", "laws inside; force = function(body) gives N before each step, held through it (springs gain energy: add_effect)",
    with = { "region" }, type = "table" } },
  gives = "region" })

-- world:region{shape, at=, rotation=, laws={gravity=, drag=, friction_scale=, restitution_scale=, conduct=, time_rate=,
--              force=function(body) end}} -> region
-- force is asked before each step for each body inside: a force in N for that step, or nil. It is not part of saved worlds.
function methods.region(world, fields)
  if core.type(fields) == "shape" then fields = { fields } end
  local region = core.region(world, fields)
  local state, kept = core.lua_state(world), {}
  -- After world:restore, a new region can have the number of one that was made after the snapshot.
  for _, law in ipairs(state.forces) do
    if law.region ~= region then kept[#kept + 1] = law end
  end
  local laws = rawget(fields, "laws")
  local force = laws and rawget(laws, "force")
  if force then kept[#kept + 1] = { region = region, force = force } end
  state.forces = kept
  core.quiet(world)
  return region
end

-- Laws of removed regions stay in the list, since world:restore can bring the region back; they have no bodies.
function core.push_regions(state)
  for _, law in ipairs(state.forces) do
    state.in_handler = "laws.force"
    local ok, message = pcall(core.region_force, law.region, law.force)
    state.in_handler = nil
    if not ok then
      if type(message) == "string" then message = ("%s (in laws.force of %s)"):format(message, tostring(law.region)) end
      error(message, 0)
    end
  end
end

-- ---- stepping ----

-- One frame step, and what follows from it. What a world does not have is not called: in a small one that would cost as much as the step.
local function advance(world, state)
  core.poll()
  local options, films = core.options, #state.films > 0 or state.past
  if options.sim_limit and world.time >= options.sim_limit - 1e-9 then core.over_sim_limit(options.sim_limit) end
  if state.before_first_step and world.steps == 0 then state.before_first_step(world) end
  if #state.forces > 0 then core.push_regions(state) end
  if state.newborn then core.ask_filters(world, state) end
  if films then core.film_before_step(world, state) end
  if options.replay then core.record_before_step(world) end
  if options.inject then core.inject_before_step(world, options.inject) end
  local warnings = core.step(world)
  if options.replay then core.record_step(world) end
  if warnings ~= state.warnings then core.watch(world, state, warnings) end
  if films then core.film_after_step(world, state) end
  core.deliver(world, state)
  if #state.tasks > 0 then run_tasks(world, state) end
end

local function past_end(world)
  local limit = core.options.seconds
  return limit and world.time >= limit - 1e-9
end

-- Is nothing to be done or looked at around the next step? A step of a small world costs less than a turn of advance(), and no more than
-- to ask all this: core.quiet keeps a yes, until what would change it takes it away.
local function alone(world, state)
  local options = core.options
  return core.steps and state.mask == 0 and #state.films == 0 and #state.forces == 0 and #state.tasks == 0
    and not (state.past or state.newborn or state.own or (state.log_mask or 0) ~= 0 or options.replay or options.trace or options.sim_limit
      or options.progress or options.inject or options.dry or (state.before_first_step and world.steps == 0))
end

-- How many of the next `count` steps may be taken in one go.
local function together(world, state, count)
  if not alone(world, state) then return 0 end
  local seconds = core.options.seconds
  if not seconds then return count end
  return math.min(count, math.max(0, (seconds - world.time) // world.frame - 1))        -- the last ones are counted exactly
end

-- Up to `count` steps with nothing around them -> how many
local function step_alone(world, state, count)
  local done, warnings = core.steps(world, count, state.warnings)
  if warnings ~= state.warnings then core.watch(world, state, warnings) end
  return done
end

-- Up to `count` steps, at least one -> how many
local function advance_some(world, state, count)
  local many = together(world, state, count)
  if many >= 1 then return step_alone(world, state, math.tointeger(math.min(many, 1 << 30))) end
  advance(world, state)
  return 1
end

core.declare("world:step", { "Takes frame steps.", takes = { { "n", "int 1 >=0", "how many", optional = true, default = 1 } } })

-- world:step([n]). One step of a world that is quiet is taken without asking here: core.quiet_step.
local function step(world, n)
  local state = core.forbid_in_handler(world, "world:step()")
  local given = n
  n = given == nil and 1 or core.whole(given)
  if not n or n < 0 then
    core.fail("world:step wants a whole number of steps >= 0; got %s (world:run goes by time)", tostring(given))
  end
  while n > 0 do
    if core.options.dry or past_end(world) then core.finish_early() end
    n = n - advance_some(world, state, n)
  end
  core.quiet(world, not core.options.seconds and alone(world, state) and state.warnings or nil)
end
methods.step = core.quiet_step(core.guard(step, "world:step", "world"), core)

core.declare("world:run", { "Runs for a time; true when stop_when ended it.", fields = {
  seconds = { "real s >=0", "how long" }, steps = { "int 1 >=0", "how many frame steps" },
  stop_when = { "any", "function, asked before each step: true ends the run", type = "function" } }, gives = "boolean",
  also = { { takes = { { "time", "real s >=0", "how long" } } } } })

local function read_run(what)
  local fields = core.type(what) == "table" and what or { seconds = core.seconds(what, "world:run") }
  local f = core.check(fields, "world:run")
  if f.stop_when ~= nil and type(f.stop_when) ~= "function" then
    core.fail("world:run.stop_when wants a function; got %s", core.type(f.stop_when))
  end
  if not f.seconds and not f.steps and not f.stop_when then core.fail("world:run: seconds is missing") end
  if f.seconds == math.huge then core.fail("world:run: seconds = inf s, must be a finite number") end
  return f
end

-- world:run(3)   world:run "3 s"   world:run{seconds=, steps=, stop_when=} -> true when stop_when ended it
function methods.run(world, what)
  local state = core.forbid_in_handler(world, "world:run()")
  local f = read_run(what)
  if core.options.dry then core.finish_early() end
  local count = f.steps or math.huge
  if f.seconds then count = math.min(count, math.ceil(f.seconds / world.frame - 1e-6)) end
  local finish = count < math.huge and world.time + count * world.frame or nil
  if core.options.seconds then finish = math.min(finish or math.huge, core.options.seconds) end
  local done, stopped = 0, false
  while done < count and not past_end(world) do
    if f.stop_when and f.stop_when() then
      stopped = true
      break
    end
    done = done + advance_some(world, state, f.stop_when and 1 or count - done)
    core.progress(world, finish)
  end
  core.clear_progress()
  return stopped or (f.stop_when ~= nil and f.stop_when() and true or false)
end

-- ---- the progress line ----

local progress = { shown = false, start = nil, next = 0 }

-- One line on a terminal: simulated time, times real time, frames, time left.
function core.progress(world, finish)
  if not core.options.progress then return end
  local now = core.clock()
  if not progress.start then progress.start, progress.from = now, world.time - world.frame end
  if now < progress.next or now - progress.start < 0.3 then return end
  progress.next = now + 0.2
  local simulated, wall = world.time - progress.from, now - progress.start
  local left = finish and simulated > 0 and ("  %.0f s left"):format((finish - world.time) * wall / simulated) or ""
  core.tell(("\rt = %.2f s  %.2fx real time  %d frames%s \27[K"):format(world.time, simulated / wall, core.frames or 0, left))
  progress.shown = true
end

function core.clear_progress()
  if progress.shown then core.tell "\r\27[K" end
  progress.shown = false
end

-- ---- the end of a run ----

-- Goes on to --seconds, and closes what is open.
-- "; energy: 49.7 J at the start + 2 J put in = 5 J stored + 46.7 J lost - numerical -7.1e-15 J"
local function books(e)
  local came = { ("%.4g J at the start"):format(e.initial) }
  if e.work_in ~= 0 then came[#came + 1] = ("%.4g J put in"):format(e.work_in) end
  if e.law ~= 0 then came[#came + 1] = ("%.4g J by laws"):format(e.law) end
  return ("; energy: %s = %.4g J stored + %.4g J lost - numerical %.1e J"):format(table.concat(came, " + "), e.total, e.lost, e.numerical)
end

-- One line on what the run reached: by which ways its groups went, and how far off it may be. "" when nothing moved.
function core.summary()
  local world = core.last_world
  local open, s = pcall(function() return world:stats() end)          -- the script may have closed it
  if not open then return "" end
  local all = s.all_traced + s.all_conserved + s.all_swept
  if all == 0 then return "" end
  local ways = {}
  for _, way in ipairs { "traced", "conserved", "swept" } do
    local n = s["all_" .. way]
    if n > 0 then ways[#ways + 1] = ("%s %.3g %%"):format(way, 100 * n / all) end
  end
  local line = ("%.4g s, %d steps: %s; worst residual %.1e, penetration %.1e m, joint error %.1e%s"):format(
    world.time, s.steps, table.concat(ways, ", "), s.worst_residual, s.worst_penetration, s.worst_joint_error, books(world.energy))
  if s.all_refused > 0 then line = ("%s; %d steps refused by their error"):format(line, s.all_refused) end
  if s.gave_up > 0 then line = ("%s; gave up %d times (last: %s)"):format(line, s.gave_up, s.gave_up_why) end
  line = line .. core.count_warnings(world)
  return table.concat({ line, table.unpack(core.effect_lines(world)) }, "\ndigbox: ")
end

-- What was given for arguments of a world that has none has no meaning.
function core.judge_arguments()
  if core.options.set and next(core.options.set) and not core.args_declared then
    core.usage("this world declares no arguments (digbox.args); --set %s has no meaning", (next(core.options.set)))
  end
  if core.options.args and core.options.args[1] and not core.args_declared then
    core.usage("this world declares no arguments (digbox.args); '%s' has no meaning", core.options.args[1])
  end
end

function core.finish_run()
  if core.options.inject then core.usage("--inject: no world took the step after step %d", core.options.inject.step) end
  core.judge_arguments()
  local world = core.last_world
  if core.options.seconds and world and core.is_open(world) then methods.run(world, { seconds = core.options.seconds }) end
  core.close_films()
end

-- What a script returned, as far as it has a name and is a number, a text or a truth.
local function named_values(returned)
  local values = {}
  for name, value in next, type(returned) == "table" and returned or {} do
    if type(name) == "string" and name ~= "" and #name < 64 then
      local kind = type(value)
      values[name] = (kind == "number" or kind == "string" or kind == "boolean") and value or nil
    end
  end
  return next(values) and values or nil
end

-- --result FILE: where the run came to, and what the script returned.
function core.finish_result(path)
  local world, facts = core.last_world, {}
  if world and core.is_open(world) then
    local e = world.energy
    facts = { steps = world.steps, time = world.time, checksum = world:checksum(), energy = { initial = e.initial, total = e.total,
      work_in = e.work_in, lost = e.lost, law = e.law, numerical = e.numerical } }
  end
  facts.values = named_values(core.options.returned)
  core.make_folders(path)
  core.write(path, core.json(facts) .. "\n")
end

-- After an error or Ctrl-C: films end with the frames they have.
function core.report_stop()
  core.stopping = true
  local world, frames = core.last_world, core.frames or 0
  if world and core.is_free(world) then
    core.lua_state(world).in_handler, core.lua_state(world).in_task = nil, nil
    if world.steps > 0 then
      core.tell(("digbox: stopped at t = %.6g s, step %d; %d frames are complete\n"):format(world.time, world.steps, frames))
    end
  end
  local ok, message = pcall(core.finish_replay)
  core.close_films()
  if not ok then core.tell(("digbox: %s\n"):format(tostring(message))) end
end

return true
