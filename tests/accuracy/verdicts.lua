-- tests/accuracy/verdicts.lua - judges the rows of one scene over a ladder of settings: order, floor, proportionality, goal.
--
--   local verdicts = require "verdicts"
--   local list = verdicts.judge(scene, rows)     -- rows as suite.run gives them, or as verdicts.read makes them from CSV
--   print(verdicts.report(scene, list))
--
-- A verdict is { name =, pass = true | false | nil (nothing to judge), text = }.
local verdicts = {}

-- Rows of a CSV text with a header; numbers become numbers
function verdicts.read(text)
  local rows, names
  rows = {}
  for line in text:gmatch "[^\n]+" do
    if line:sub(1, 1) ~= "#" then
      local cells = {}
      for cell in (line .. ","):gmatch "([^,]*)," do cells[#cells + 1] = cell end
      if not names then
        names = cells
      else
        local row = {}
        for i, name in ipairs(names) do row[name] = tonumber(cells[i]) or cells[i] end
        row.setting = cells[3]
        rows[#rows + 1] = row
      end
    end
  end
  return rows
end

-- The tolerance ladder of one engine, coarse to fine: rows whose setting is a number
local function ladder_of(rows)
  local list = {}
  for _, row in ipairs(rows) do
    local tolerance = tonumber(row.setting)
    if tolerance and row.engine == "digbox" then
      local work = (row.evaluations or 0) > 0 and row.evaluations or row.steps or row.substeps
      local steps = row.steps or math.max(row.substeps or 0, row.frames or 0)
      local counted = (row.evaluations or 0) > steps
      list[#list + 1] = { tolerance = tolerance, error = row.error, work = work, steps = steps, counted = counted }
    end
  end
  table.sort(list, function(a, b) return a.tolerance > b.tolerance end)
  return list
end

-- What double precision leaves of a relative error; a scene that amplifies rounding says so itself (scene.rounding).
local precision = 1e-11

-- Least relative error of the ladder: from there on nothing can fall any more
local function floor_of(list, scale)
  local least = math.huge
  for _, row in ipairs(list) do least = math.min(least, row.error / scale) end
  return least
end

-- 1. Order: error against work (evaluations, or steps where none are counted) over the three finest rungs above the floor that differ in
-- work by a half or more: p = log(err_a / err_b) / log(work_b / work_a).
local function order(list, scale, rounding, nominal)
  local floor, used = math.max(10 * floor_of(list, scale), rounding), {}
  for _, row in ipairs(list) do
    local last = used[#used]
    if row.error / scale > floor and (row.work or 0) > 0 and (not last or row.work >= 1.5 * last.work) then used[#used + 1] = row end
  end
  if #used < 3 then return { name = "order", text = "fewer than three rungs above the floor with different work" } end
  local a, b = used[#used - 2], used[#used]
  local p = math.log(a.error / b.error) / math.log(b.work / a.work)
  return { name = "order", pass = p >= nominal - 0.2, value = p, text = ("%.2f (wanted %.1f)"):format(p, nominal - 0.2) }
end

-- 2. Floor: the error keeps falling to 1e-11 of the scene's scale
local function floor(list, scale, rounding)
  local least = floor_of(list, scale)
  return { name = "floor", pass = least <= rounding, value = least, text = ("%.1e of the scale (wanted %.0e)"):format(least, rounding) }
end

-- A step cannot be longer than a frame: while most are as long as that, a coarser tolerance can be no coarser. Nor are two rungs with the
-- same error at the same work, to the last digit, two runs: the engine does not tell these tolerances apart. A step
-- composed of five counts as one, as one with stages does.
local function at_longest_step(row, frames) return row.counted and row.steps < 1.5 * frames end
local function same_run(a, b) return a.error == b.error and a.work == b.work end

-- 3a. Ten times less tolerance, a fifth of the error at least, from where the engine tells tolerances apart until the floor
local function proportionality(list, scale, rounding, frames)
  local limit = math.max(10 * floor_of(list, scale), rounding)
  local worst, where, from = 0, nil, nil
  for i = 2, #list do
    local a, b = list[i - 1], list[i]
    local decade = math.abs(a.tolerance / b.tolerance - 10) < 1e-6
    if decade and a.error / scale > limit and not at_longest_step(a, frames) and not same_run(a, b) then
      from = from or a.tolerance
      local ratio = b.error / a.error
      if b.error / scale > limit and ratio > worst then worst, where = ratio, b.tolerance end
    end
  end
  if not from then return { name = "proportionality", text = "at the floor with the longest steps there are" } end
  local text = where and ("err(tol/10) / err(tol) up to %.2g at %g (wanted 0.2)"):format(worst, where) or "falls to the floor at once"
  return { name = "proportionality", pass = worst <= 1 / 5, value = worst, from = from, text = text .. (", judged from %g"):format(from) }
end

-- 3b. The error stays below ten times the tolerance, on the scene's scale
local function bounded(list, scale, rounding)
  local worst, where = 0, nil
  for _, row in ipairs(list) do
    local ratio = row.error / math.max(10 * row.tolerance * scale, rounding * scale)
    if ratio > worst then worst, where = ratio, row.tolerance end
  end
  return { name = "bound", pass = worst <= 1, value = worst,
           text = where and ("error up to %.2g of 10 tol * scale, at %g"):format(worst, where) or "no error at all" }
end

-- 4. Goals: error at the default plan, and at the finest plan. CPU time is reported, never judged: it depends on the machine.
local function goals(scene, rows)
  local list = {}
  for _, goal in ipairs { { "goal at play", "play", "fast" }, { "goal at reference", "reference", "accurate" } } do
    for _, row in ipairs(rows) do
      local want = scene.goal and scene.goal[goal[3]]
      if want and row.setting == goal[2] and row.engine == "digbox" then
        list[#list + 1] = { name = goal[1], pass = row.error <= want[1], value = row.error,
          text = ("%.1e (wanted %.0e), %.3g ms/s (goal %.2g)"):format(row.error, want[1], row.ms_per_s or row.cpu_ms_per_s, want[2]) }
      end
    end
  end
  return list
end

-- nominal: order of the integrator, default 4
function verdicts.judge(scene, rows, nominal)
  local scale, rounding, list = scene.scale or 1, scene.rounding or precision, ladder_of(rows)
  local out = {}
  if scene.metric == "verdict" then                     -- stays or goes: there is nothing between
    for _, row in ipairs(rows) do
      local right = row.error == 0
      out[#out + 1] = { name = "at " .. row.setting, pass = right, value = row.error, text = right and "right" or "wrong" }
    end
  elseif #list >= 3 then
    out = {
      order(list, scale, rounding, nominal or 4), floor(list, scale, rounding),
      proportionality(list, scale, rounding, (scene.seconds or 0) / (scene.world and scene.world.step or 1 / 60)),
      bounded(list, scale, rounding),
    }
  end
  return table.move(goals(scene, rows), 1, 2, #out + 1, out)
end

function verdicts.report(scene, list)
  local lines = {}
  for _, v in ipairs(list) do
    lines[#lines + 1] = ("%-5s %-6s %-18s %s"):format(v.pass == nil and "-" or v.pass and "ok" or "FAIL", scene.id, v.name, v.text)
  end
  return table.concat(lines, "\n")
end

return verdicts
