-- tests/hard/run.lua - runs hard cases and prints one line of tab-separated values for each case and frame step.
--
--   digbox run tests/hard/run.lua -- --cases B01,B06 --steps 1/60 --limit 60
--
-- cases: beginnings of ids, "all", or "list" to name them; steps: 1/30, 1/60, 1/1000, "own" = those of the case.
local digbox = require "digbox"
local test = require "digbox.test"
local hard = require "hard"

local options = digbox.args {
  cases = { default = "all", help = "beginnings of ids with commas, all, or list" },
  steps = { default = "own", help = "frame steps with commas, or own" },
  limit = { default = 60, help = "CPU seconds of one run" },
  seconds = { default = 0, help = "simulated time, instead of the case's own" },
  accuracy = { default = "play", help = "plan or tolerance" },
  details = { default = false, help = "print every criterion, too" },
  pictures = { default = false, help = "a picture of the end of each run, in the folder of -o" },
}

local function split(text)
  local list = {}
  for word in text:gmatch "[^,]+" do list[#list + 1] = word end
  return list
end

local function steps_of(case)
  local list = {}
  for _, step in ipairs(hard.steps) do
    local own = not case.slow or step[1] == "1/60"
    for _, word in ipairs(split(options.steps)) do
      if word == step[1] or word == "own" and own and (not case.steps or case.steps[step[1]]) then list[#list + 1] = step end
    end
  end
  return list
end

local function number(x) return x and ("%.4g"):format(x) or "" end

local function line(row, step)
  local w = row.worst
  local verdict = row.error and "error" or row.pass and "pass" or row.over_time and not row.broke and "over time" or "fail"
  return table.concat({
    row.case.id, row.case.title, step, verdict, w.name, number(w.value), (w.least and ">= " or "<= ") .. number(w.limit),
    number(hard.margin(w)), row.fine and "ok" or row.broken, number(row.dearest), number(row.place), number(row.ms_per_s), row.shares,
    tostring(row.gave_up), row.why, tostring(row.rejected), number(row.residual), number(row.penetration), number(row.joint_error),
    number(row.time),
  }, "\t")
end

local function details(row)
  for _, list in ipairs { row.criteria, row.always } do
    for _, c in ipairs(list) do
      local verdict = c.pass and "ok" or "FAIL"
      print(("#   %-4s %-34s %12s %s %s"):format(verdict, c.name, number(c.value), c.least and ">=" or "<=", number(c.limit)))
    end
  end
  if row.error then print("#   " .. row.error) end
  print(("#   top speed %.4g, penetration %.3g, joint error %.3g, residual %.3g, rejected %d, gave up %d %s"):format(row.speed,
    row.penetration, row.joint_error, row.residual, row.rejected, row.gave_up, row.why))
end

test.scenario("hard cases", function(s)
  local cases = hard.cases(options.cases ~= "all" and options.cases ~= "list" and split(options.cases) or nil)
  for _, case in ipairs(cases) do
    for _, step in ipairs(steps_of(case)) do
      if options.cases == "list" then
        print(case.id .. "\t" .. step[1])
      else
        local name = ("%s_%s"):format(case.id, step[1]:gsub("/", "_"))
        local row = hard.run(case, { dt = step[2], clock = s.cpu_seconds, limit = options.limit, accuracy = options.accuracy, timings = 3,
                                     seconds = options.seconds > 0 and options.seconds or nil,
                                     picture = options.pictures and name .. ".png" or nil })
        print(line(row, step[1]))
        if options.details then details(row) end
      end
    end
  end
  test.expect(#cases):above(0)
end)
