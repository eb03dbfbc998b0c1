-- tests/accuracy/report.lua - writes the work-precision report from build/accuracy/results.csv.
--
--   BUILD=build lua5.4 tests/accuracy/report.lua docs             docs/accuracy.md (between its two marks) and docs/accuracy/*.svg
--   BUILD=build lua5.4 tests/accuracy/report.lua build/accuracy   build/accuracy/report.md and the plots, for a look at a part
local build = os.getenv "BUILD" or "build"
local target = arg[1] or "docs"
local work = build .. "/accuracy"

package.path = "tests/accuracy/?.lua;" .. package.path
package.preload.digbox = function() return {} end       -- only the scenes' titles and goals are wanted here, not their worlds
local suite = require "suite"
local verdicts = require "verdicts"
local plot = require "report_plot"

local engines = {
  { id = "bullet", name = "Bullet", package = "libbullet-dev" },
  { id = "bullet64", name = "Bullet in double", package = "libbullet-dev" },
  { id = "ode", name = "ODE", package = "libode-dev" },
  { id = "mujoco", name = "MuJoCo", package = "libmujoco-dev" },
}

-- ---- reading ----
local function fail(...)
  io.stderr:write("accuracy: ", string.format(...), "\n")
  os.exit(1)
end

local function split(line)
  local fields = {}
  for field in (line .. ","):gmatch "([^,]*)," do fields[#fields + 1] = field end
  return fields
end

-- by[scene][engine] is a list of rows in the order of the run: an engine's default comes first
local function read_results(path)
  local file = io.open(path) or fail("there is no %s yet: run make accuracy", path)
  local header, by = split(file:read "l"), {}
  for line in file:lines() do
    local row = {}
    for i, field in ipairs(split(line)) do row[header[i]] = tonumber(field) or field end
    row.setting = split(line)[3]
    row.error = tonumber(row.error) or math.huge
    row.ms = tonumber(row.cpu_ms_per_s)
    if row.ms and row.ms > 0 then
      by[row.scene] = by[row.scene] or {}
      by[row.scene][row.engine] = by[row.scene][row.engine] or {}
      table.insert(by[row.scene][row.engine], row)
    end
  end
  file:close()
  return by
end

-- What the plots and tables need of each scene that was run, in the order of the suite
local function gather(by)
  local list = {}
  for _, scene in ipairs(suite.scenes()) do
    local rows = by[scene.id]
    if rows then
      local item = { scene = scene, id = scene.id, title = scene.title, metric = scene.metric, goal = scene.goal,
                     rows = rows, plans = {}, ladder = {}, peers = {} }
      for _, row in ipairs(rows.digbox or {}) do
        if tonumber(row.setting) then
          row.tolerance = tonumber(row.setting)
          table.insert(item.ladder, row)
        else
          item.plans[row.setting] = row
        end
      end
      table.sort(item.ladder, function(a, b) return a.tolerance > b.tolerance end)
      for _, engine in ipairs(engines) do
        if rows[engine.id] then table.insert(item.peers, { engine = engine, rows = rows[engine.id] }) end
      end
      list[#list + 1] = item
    end
  end
  return list
end

-- ---- judging ----
local function least(rows)
  local best
  for _, row in ipairs(rows) do
    if not best or row.error < best.error then best = row end
  end
  return best
end

local function digbox_rows(item)
  local rows = {}
  for _, name in ipairs(suite.plans) do rows[#rows + 1] = item.plans[name] end
  return table.move(item.ladder, 1, #item.ladder, #rows + 1, rows)
end

-- The cheapest row that has the wanted error, or the row that comes nearest to it
local function serves(rows, error)
  local best
  for _, row in ipairs(rows) do
    if row.error <= error and not (best and best.ms <= row.ms) then best = row end
  end
  return best or least(rows)
end

local function peer_best(item, default_only)
  local best, name
  for _, peer in ipairs(item.peers) do
    local row = default_only and peer.rows[1] or least(peer.rows)
    if not best or row.error < best.error then best, name = row, peer.engine.name end
  end
  return best, name
end

local function judge_goal(row, goal)
  if not row then return "not run" end
  if row.error > goal[1] then return ("no: error %.0e"):format(row.error) end
  if row.ms > goal[2] then return ("error yes, time %.1f times"):format(row.ms / goal[2]) end
  return "**met**"
end

-- ---- writing ----
local out = {}
local function say(...) out[#out + 1] = string.format(...) end

local function number(x)
  if x == math.huge then return "lost" end
  if x == 0 then return "0" end
  return (("%.1e"):format(x):gsub("e([-+])0*(%d)", function(sign, digit) return "e" .. (sign == "-" and "-" or "") .. digit end))
end

local function cost(x) return x < 0.095 and ("%.3f"):format(x) or x < 9.5 and ("%.2f"):format(x) or ("%.0f"):format(x) end

local function cell(row, name, verdict)
  if not row then return "" end
  if verdict then return ("%s @ %s"):format(row.error == 0 and "right" or "wrong", cost(row.ms)) end
  local gave_up = row.engine == "digbox" and (tonumber(row.gave_up) or 0) > 0 and " †" or ""
  return ("%s @ %s%s%s"):format(number(row.error), cost(row.ms), gave_up, name and (" (%s, %s)"):format(name, row.setting) or "")
end

local function write_summary(list)
  local with, better, anywhere, goals, fast, accurate = 0, 0, 0, 0, 0, 0
  for _, item in ipairs(list) do
    local play, best, best_anywhere = item.plans.play, peer_best(item, true), peer_best(item)
    if play and best then
      with = with + 1
      if play.error <= best.error then better = better + 1 end
      if play.error <= best_anywhere.error then anywhere = anywhere + 1 end
    end
    if item.goal and play then
      goals = goals + 1
      if judge_goal(play, item.goal.fast) == "**met**" then fast = fast + 1 end
      if judge_goal(serves(digbox_rows(item), item.goal.accurate[1]), item.goal.accurate) == "**met**" then accurate = accurate + 1 end
    end
  end
  say("At its default plan, `play`, the error of digbox is not above that of any other engine at its default in %d of %d scenes,",
    better, with)
  say("and not above that of any of their settings in %d. Of %d goals it meets %d at the default; of as many for accuracy, %d.",
    anywhere, goals, fast, accurate)
  say ""
end

-- Which scenes have no figures of digbox at some plan: they took longer than an engine may take for a scene
local function write_missing(list)
  local present, missing = {}, {}
  for _, item in ipairs(list) do present[item.id] = item end
  for _, scene in ipairs(suite.scenes()) do
    local names = {}
    for _, name in ipairs(suite.plans) do
      if not (present[scene.id] and present[scene.id].plans[name]) then names[#names + 1] = name end
    end
    if #names == #suite.plans then
      missing[#missing + 1] = scene.id
    elseif #names > 0 then
      missing[#missing + 1] = ("%s (%s)"):format(scene.id, table.concat(names, ", "))
    end
  end
  if #missing == 0 then return end
  say("Without figures of digbox at some or all plans, because they take longer than is allowed here: %s.", table.concat(missing, "; "))
  say ""
end

local function write_errors(list)
  say "### Error @ CPU"
  say ""
  say "Error, in the unit of the second column, @ CPU milliseconds per simulated second; † a group of bodies gave up its tolerance."
  say ""
  say "| scene | error in | sketch | **play** | study | reference | best default of the others | best of the others at any setting |"
  say "|---|---|---|---|---|---|---|---|"
  for _, item in ipairs(list) do
    local default, default_name = peer_best(item, true)
    local best, best_name = peer_best(item)
    local cells, is_verdict = {}, item.metric == "verdict"
    for i, name in ipairs(suite.plans) do cells[i] = cell(item.plans[name], nil, is_verdict) end
    say("| %s %s | %s | %s | %s | %s |", item.id, item.title, item.metric or "", table.concat(cells, " | "),
      default and cell(default, default_name) or "not run", best and cell(best, best_name) or "not run")
  end
  say ""
end

local function write_goals(list)
  say "### Goals"
  say ""
  say "The first must hold at the default plan; the second at any plan or tolerance, of which the cheapest that serves is shown."
  say ""
  say "| scene | goal at `play` | reached | | goal for accuracy | reached, by setting | |"
  say "|---|---|---|---|---|---|---|"
  for _, item in ipairs(list) do
    if item.goal and next(item.plans) then
      local fast, accurate = item.goal.fast, item.goal.accurate
      local row = serves(digbox_rows(item), accurate[1])
      say("| %s | %s @ %s | %s | %s | %s @ %s | %s, %s | %s |", item.id, number(fast[1]), cost(fast[2]), cell(item.plans.play),
        judge_goal(item.plans.play, fast), number(accurate[1]), cost(accurate[2]), cell(row), row.setting, judge_goal(row, accurate))
    end
  end
  say ""
end

local order_of_verdicts = { "order", "floor", "proportionality", "bound" }

-- Why some are no, where a scene says so; those with one reason together
local function write_limits(reasons)
  if #reasons == 0 then return end
  say "What is behind a no:"
  say ""
  for _, r in ipairs(reasons) do say("* %s, %s: %s", r.id, table.concat(r.names, " and "), r.text) end
  say ""
end

local function add_limits(reasons, item, failed)
  local own = {}
  for _, name in ipairs(order_of_verdicts) do
    local text = failed[name] and (item.scene.limits and item.scene.limits[name] or "not explained.")
    if text and not own[text] then
      own[text] = { id = item.id, names = {}, text = text }
      reasons[#reasons + 1] = own[text]
    end
    if text then table.insert(own[text].names, name) end
  end
end

local function write_verdicts(list)
  say "### Verdicts on the tolerances"
  say ""
  say "By `tests/accuracy/verdicts.lua`, over the ladder of tolerances from 1e-2 to 1e-12. Order: slope of log error against log"
  say "evaluations (steps, where none are counted) over the three finest tolerances above the floor. Floor: the least error, relative to"
  say "the size of the scene. Proportionality: the worst error(tol / 10) / error(tol) until the floor, from the tolerance that it names on:"
  say "with coarser ones most steps are as long as a frame already, or the run is the same to the last digit. Two tolerances of one and the"
  say "same run are not compared with each other. Bound: the worst error / (10 tol), of all."
  say ""
  say "| scene | order ≥ 3.8 | floor ≤ 1e-11 | proportionality ≤ 0.2 | bound ≤ 1 |"
  say "|---|---|---|---|---|"
  local reasons = {}
  for _, item in ipairs(list) do
    local cells, failed, any = {}, {}, false
    for _, v in ipairs(verdicts.judge(item.scene, item.rows.digbox or {})) do
      local shown = v.value and (v.name == "order" and ("%.1f"):format(v.value) or number(v.value)) or ""
      local from = v.from and (" from %g"):format(v.from) or ""
      cells[v.name] = v.pass == nil and "" or (v.pass and "**yes** " or "no: ") .. shown .. from
      any = any or v.pass ~= nil
      failed[v.name] = v.pass == false
    end
    if any and cells.floor then
      add_limits(reasons, item, failed)
      say("| %s | %s | %s | %s | %s |", item.id, cells.order, cells.floor, cells.proportionality, cells.bound)
    end
  end
  say ""
  write_limits(reasons)
end

local function write_peers(list)
  local columns, head = {}, {}
  for _, engine in ipairs(engines) do
    for _, item in ipairs(list) do
      if item.rows[engine.id] then
        columns[#columns + 1], head[#head + 1] = engine, engine.name
        break
      end
    end
  end
  if #columns == 0 then return end
  say "### The other engines"
  say ""
  say "Error @ CPU at the default, then at the setting with the least error."
  say ""
  say("| scene | %s |", table.concat(head, " | "))
  say("|---|%s", ("---|"):rep(#head))
  for _, item in ipairs(list) do
    local cells = {}
    for i, engine in ipairs(columns) do
      local rows = item.rows[engine.id]
      cells[i] = rows and ("%s; %s (%s)"):format(cell(rows[1]), cell(least(rows)), least(rows).setting) or ""
    end
    if #item.peers > 0 then say("| %s | %s |", item.id, table.concat(cells, " | ")) end
  end
  say ""
end

local function output_of(command)
  local pipe = io.popen(command .. " 2>/dev/null")
  local text = pipe and pipe:read "a" or ""
  if pipe then pipe:close() end
  return (text:gsub("%s+$", ""))
end

local function write_machine()
  local versions = {}
  for _, name in ipairs { "libbullet-dev", "libode-dev", "libmujoco-dev", "gcc" } do
    local version = output_of(("dpkg-query -W -f '${Version}' %s"):format(name))
    versions[#versions + 1] = version ~= "" and ("%s %s"):format(name, version) or name .. " not installed: left out"
  end
  local processor = output_of "sed -n 's/^model name[^:]*: *//p' /proc/cpuinfo | head -n 1"
  local system = output_of "sed -n 's/^PRETTY_NAME=\"\\(.*\\)\"/\\1/p' /etc/os-release"
  say("Measured on %s, %s cores, %s; %s.", processor ~= "" and processor or output_of "uname -m", output_of "nproc", system,
    table.concat(versions, ", "))
  local load = output_of "cut -d' ' -f3 /proc/loadavg"
  say("One thread. Load average of the last quarter of an hour when this was written: %s.", load ~= "" and load or "unknown")
  say ""
end

local function write_file(path, text)
  local file = io.open(path, "w") or fail("cannot write %s", path)
  file:write(text)
  file:close()
end

-- Between the two marks of docs/accuracy.md; what stands around them is written by hand
local function into_document(path, text)
  local file = io.open(path) or fail("there is no %s to write into", path)
  local old = file:read "a"
  file:close()
  local _, from = old:find("<!-- begin: written by make accuracy -->\n", 1, true)
  local to = old:find("<!-- end: written by make accuracy -->", 1, true)
  if not from or not to then fail("%s has lost the marks between which the report is written", path) end
  write_file(path, old:sub(1, from) .. text .. old:sub(to))
end

local list = gather(read_results(work .. "/results.csv"))
if #list == 0 then fail("no rows in %s/results.csv", work) end
local compared, alone = {}, {}
for _, item in ipairs(list) do
  if item.metric ~= "verdict" then table.insert(#item.peers > 0 and compared or alone, item) end
end

local in_docs = target == "docs"
local folder = in_docs and "docs/accuracy" or target
os.execute(("mkdir -p '%s'"):format(folder))
local function draw(name, items, columns)
  if #items == 0 then return end
  plot.draw(items, { svg = ("%s/%s.svg"):format(folder, name), png = ("%s/%s.png"):format(work, name),
    script = ("%s/%s.gp"):format(work, name), columns = columns, plans = suite.plans, engines = engines })
  say("![Error against CPU time, both logarithmic, one panel per scene](%s%s.svg)", in_docs and "accuracy/" or "", name)
  say ""
end

write_summary(list)
draw("compared", compared, 4)
draw("alone", alone, 5)
if in_docs then write_missing(list) end
write_errors(list)
write_goals(list)
write_verdicts(list)
write_peers(list)
write_machine()
local text = table.concat(out, "\n") .. "\n"
write_file(work .. "/report.md", text)
if in_docs then into_document("docs/accuracy.md", text) end
io.stderr:write(("accuracy: %d scenes; see %s\n"):format(#list, in_docs and "docs/accuracy.md" or work .. "/report.md"))
