-- digbox/sweep.lua - `digbox sweep`, `task` and `merge`: the plan of many runs, what a task needs, and what came of all.
--
-- The plan is a file with a line for each task, so that anything that starts commands can work it off (docs/sweep.md). The processes
-- are started by lua/sweep.c. A task is done when its folder holds a result.json with exit code 0.

local core = ...
local ipairs, type, next = ipairs, type, next
local MOST = 1000000            -- tasks of a plan

local plan                      -- {folder =, path =, tasks = list of {index, script, hash, set, seed, options, arguments, output}}

-- A line that core.json wrote
local function decode(text, path)
  local value = core.from_json(text)
  if type(value) ~= "table" then core.raise(8, path .. ": is no JSON of digbox sweep") end
  return value
end

-- ---- what is varied ----

-- "10 cm" -> 10, "cm"
local function split(text, name)
  local number, unit = text:match "^%s*([%+%-]?[%d%.]+[eE]?[%+%-]?%d*)%s*(.-)%s*$"
  if not tonumber(number) then core.usage("sweep: --set %s: '%s' is not a number with a unit", name, text) end
  return tonumber(number), unit
end

local function plain(x)
  local text = ("%.15g"):format(x)
  return tonumber(text) == x and text or ("%.17g"):format(x)
end

-- "0.2..1 m/5" -> five texts from 0.2 m to 1 m; "a,b" -> two; anything else -> one
local function values_of(name, text)
  local low, high, count = text:match "^(.-)%.%.(.+)/%s*(%d+)%s*$"
  if not low then
    if text:find("..", 1, true) then core.usage("sweep: --set %s: '%s' wants a number of values: A..B/N", name, text) end
    local list = {}
    for item in (text .. ","):gmatch "([^,]*)," do list[#list + 1] = item end
    return list
  end
  local n, a, unit_a = tonumber(count), split(low, name)
  local b, unit = split(high, name)
  if unit_a ~= "" and unit_a ~= unit then
    core.usage("sweep: --set %s: '%s' and '%s' are in different units", name, low, high)
  end
  if not (n >= 1 and n <= MOST) then core.usage("sweep: --set %s: %s values, must be 1 to %d", name, count, MOST) end
  local list = {}
  for i = 1, n do
    local x = n == 1 and a or a + (b - a) * (i - 1) / (n - 1)
    list[i] = plain(i == n and n > 1 and b or x) .. (unit ~= "" and " " .. unit or "")
  end
  return list
end

-- Every combination; the last one given varies fastest.
local function combinations(given)
  local all, seen = { {} }, {}
  for _, pair in ipairs(given) do
    local name, text = pair:match "^(.-)=(.*)$"
    if seen[name] then core.usage("sweep: --set %s is given twice", name) end
    seen[name] = true
    local values, more = values_of(name, text), {}
    if #all * #values > MOST then core.usage("sweep: more than %d tasks", MOST) end
    for _, set in ipairs(all) do
      for _, value in ipairs(values) do
        local copy = { [name] = value }
        for k, v in next, set do copy[k] = v end
        more[#more + 1] = copy
      end
    end
    all = more
  end
  return all
end

-- ---- the plan ----

-- The last line that the run said, without the name of the program
local function last_line(path)
  local text = core.exists(path) and core.read(path) or ""
  local last = ""
  for line in text:gmatch "[^\n]+" do last = line end
  return (last:gsub("^digbox: ", ""))
end

local function read_script(path)
  local text, why = core.read(path)
  if not text then core.raise(1, why) end
  return core.hash(text)
end

local function same_file(path, text)
  local there = core.exists(path) and core.read(path)
  if there and there ~= text then core.usage("sweep: %s is of another sweep: give another folder with -o", path) end
  return there ~= nil and there ~= false
end

-- core.sweep_plan{script =, shown =, out =, set = {"NAME=A..B/N"}, seeds =, options = {}, arguments = {}} -> number of tasks, and
-- whether the plan is new
function core.sweep_plan(o)
  local hash, lines = read_script(o.script), {}
  local sets = combinations(o.set)
  if #sets * math.max(1, o.seeds) > MOST then core.usage("sweep: more than %d tasks", MOST) end
  for _, set in ipairs(sets) do
    for seed = 1, math.max(1, o.seeds) do
      local index = #lines
      lines[index + 1] = core.json { index = index, script = o.script, script_hash = hash, set = next(set) and set or nil,
        seed = o.seeds > 0 and seed or nil, options = o.options, arguments = o.arguments, output = ("%d"):format(index) }
    end
  end
  local text, path = table.concat(lines, "\n") .. "\n", o.out .. "/plan.jsonl"
  local new = not same_file(path, text)
  if new then
    core.make_folders(path)
    core.write(path, text)
  end
  return core.sweep_open(path), new
end

-- core.sweep_said(log) -> the last line in it
function core.sweep_said(path) return last_line(path) end

-- core.sweep_open(plan.jsonl, or its folder) -> number of tasks
function core.sweep_open(path)
  if core.exists(path .. "/plan.jsonl") then path = path:gsub("/+$", "") .. "/plan.jsonl" end
  local text, why = core.read(path)
  if not text then core.raise(8, why) end
  plan = { path = path, folder = path:match "^(.*)/[^/]*$" or ".", tasks = {} }
  for line in text:gmatch "[^\n]+" do
    local task = decode(line, path)
    local sound = type(task.script) == "string" and type(task.output) == "string" and task.output:match "^%d+$"
      and type(task.options) == "table" and type(task.arguments) == "table" and task.index == #plan.tasks
    if not sound then core.raise(8, ("%s:%d: is no task of digbox sweep"):format(path, #plan.tasks + 1)) end
    plan.tasks[#plan.tasks + 1] = task
  end
  if #plan.tasks == 0 then core.raise(8, path .. ": holds no task") end
  return #plan.tasks
end

local function folder_of(task) return plan.folder .. "/" .. task.output end

-- What a task left, or nil
local function result_of(task)
  local path = folder_of(task) .. "/result.json"
  if not core.exists(path) then return nil end
  local result = decode(core.read(path) or "", path)
  return result.script_hash == task.script_hash and result or nil
end

-- core.sweep_task(index) -> nil when it is done; else its folder and the words of `digbox run`
function core.sweep_task(index)
  local task = plan.tasks[index + 1]
  if not task then core.usage("task: --index %d: the plan has tasks 0 to %d", index, #plan.tasks - 1) end
  local done = result_of(task)
  if done and done.exit == 0 then return nil end
  if read_script(task.script) ~= task.script_hash then
    core.usage("task: %s has changed since %s was made", task.script, plan.path)
  end
  local folder = folder_of(task)
  local words = { task.script, "-o", folder .. ".tmp", "--result", folder .. ".tmp/run.json", "--quiet" }
  local function add(...)
    for _, word in ipairs { ... } do words[#words + 1] = word end
  end
  local names = {}
  for name in next, task.set or {} do names[#names + 1] = name end
  table.sort(names)
  for _, name in ipairs(names) do add("--set", name .. "=" .. task.set[name]) end
  if task.seed then add("--seed", ("%d"):format(task.seed)) end
  add(table.unpack(task.options))
  if #task.arguments > 0 then add("--", table.unpack(task.arguments)) end
  return folder, words
end

-- core.sweep_result(index, exit code, s): writes what came of it into the folder where it worked.
function core.sweep_result(index, code, seconds)
  local task = plan.tasks[index + 1]
  local folder = folder_of(task) .. ".tmp"
  local path = folder .. "/run.json"
  local run = code == 0 and core.exists(path) and decode(core.read(path) or "", path) or nil
  core.write(folder .. "/result.json", core.json { index = index, script_hash = task.script_hash, set = task.set, seed = task.seed,
    exit = code, seconds = seconds, run = run, message = code ~= 0 and last_line(folder .. "/log.txt") or nil } .. "\n")
end

-- ---- the summary ----

local function cell(value)
  if value == nil then return "" end
  local text = type(value) == "number" and (math.type(value) == "integer" and ("%d"):format(value) or plain(value)) or tostring(value)
  return text:find '[,"\n\r]' and '"' .. text:gsub('"', '""') .. '"' or text
end

local function names_in(tables)
  local seen, list = {}, {}
  for _, t in next, tables do
    for name, value in next, t do
      if not seen[name] and type(value) ~= "table" then
        seen[name] = true
        list[#list + 1] = name
      end
    end
  end
  table.sort(list)
  return list
end

local FIXED = { "steps", "time", "checksum" }

local function summary_of(results)
  local sets, returned = {}, {}
  for i, task in ipairs(plan.tasks) do
    sets[i] = task.set or {}
    returned[i] = results[i] and results[i].run and type(results[i].run.values) == "table" and results[i].run.values or {}
  end
  local set_names, value_names = names_in(sets), names_in(returned)
  local head, lines = { "index", "seed" }, {}
  for _, list in ipairs { set_names, { "exit" }, FIXED, { "energy_total", "energy_lost", "energy_numerical" }, value_names } do
    for _, name in ipairs(list) do head[#head + 1] = cell(name) end
  end
  lines[1] = table.concat(head, ",")
  for i, task in ipairs(plan.tasks) do
    local result = results[i] or {}
    local run = result.run or {}
    local energy, row = run.energy or {}, { cell(i - 1), cell(task.seed) }
    local function add(value) row[#row + 1] = cell(value) end
    for _, name in ipairs(set_names) do add(sets[i][name]) end
    add(result.exit)
    for _, name in ipairs(FIXED) do add(run[name]) end
    add(energy.total) add(energy.lost) add(energy.numerical)
    for _, name in ipairs(value_names) do add(returned[i][name]) end
    lines[i + 1] = table.concat(row, ",")
  end
  return table.concat(lines, "\n") .. "\n"
end

-- core.sweep_merge() -> exit code, what is to be said, and what of it are complaints
function core.sweep_merge()
  local results, complaints, done = {}, {}, 0
  for i, task in ipairs(plan.tasks) do
    results[i] = result_of(task)
    if not results[i] then
      complaints[#complaints + 1] = ("task %d is missing"):format(i - 1)
    elseif results[i].exit ~= 0 then
      complaints[#complaints + 1] = ("task %d failed with exit code %d: %s"):format(i - 1, results[i].exit, results[i].message or "")
    else
      done = done + 1
    end
  end
  local path = plan.folder .. "/summary.csv"
  core.write(path, summary_of(results))
  return #complaints > 0 and 1 or 0, ("%s: %d of %d tasks are done\n"):format(path, done, #plan.tasks), complaints
end

-- ---- engines ----

local function shell(text)
  return text:find "^[%w%./_%-]+$" and text or "'" .. text:gsub("'", "'\\''") .. "'"
end

-- core.sweep_print(program): how others may work it off
function core.sweep_print(program, jobs)
  local n, task = #plan.tasks, ("%s task %s --index"):format(shell(program), shell(plan.path))
  return table.concat({
    ("# %d tasks; any of these lines, then the last one"):format(n),
    ("seq 0 %d | parallel -j %d %s {}"):format(n - 1, jobs, task),
    ("seq 0 %d | xargs -P %d -n 1 %s"):format(n - 1, jobs, task),
    ("mpirun -n %d sh -c %s"):format(jobs, shell(("%s $OMPI_COMM_WORLD_RANK --stride %d"):format(task, jobs))),
    ("%s merge %s"):format(shell(program), shell(plan.path)), "" }, "\n")
end

-- core.sweep_slurm(program, tasks at a time): writes the scripts -> the one that submits them
function core.sweep_slurm(program, jobs)
  local head = ("#!/bin/sh\n#SBATCH --cpus-per-task=1\n#SBATCH --requeue\n#SBATCH --output=%s/slurm-%%j.txt\n"):format(
    (plan.folder:gsub("%%", "%%%%")))
  core.write(plan.folder .. "/job.sh", ("%s#SBATCH --array=0-%d%%%d\n%s task %s --index \"$SLURM_ARRAY_TASK_ID\"\n"):format(head,
    #plan.tasks - 1, jobs, shell(program), shell(plan.path)))
  core.write(plan.folder .. "/merge.sh", ("%s%s merge %s\n"):format(head, shell(program), shell(plan.path)))
  local submit = plan.folder .. "/submit.sh"
  core.write(submit, ([[#!/bin/sh
command -v sbatch >/dev/null || { echo 'digbox: sweep: sbatch is not here; where it is, run sh %s' >&2; exit 11; }
job=$(sbatch --parsable %s) && sbatch --parsable --dependency="afterany:${job%%%%;*}" %s && echo "digbox: array job ${job%%%%;*}" >&2
]]):format(submit, shell(plan.folder .. "/job.sh"), shell(plan.folder .. "/merge.sh")))
  return submit
end

return true
