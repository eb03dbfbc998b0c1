-- tests/hard/peers/run.lua - runs hard cases on another engine and prints a line of tab-separated values for each.
--
--   lua5.4 tests/hard/peers/run.lua build/hard/peers ode B01a 1/60 [LIMIT [details]]
--
-- folder of the modules, engine, beginning of an id, frame step, CPU seconds of a run. The line: id, step, engine, verdict,
-- criterion nearest to failing, measured, limit, ms per simulated second, reason.
local folder, engine, wanted, step, limit, details = table.unpack(arg)
local here = arg[0]:match "^(.*)/" or "."
package.path = ("%s/?.lua;%s/../?.lua;%s"):format(here, here, package.path)
package.cpath = folder .. "/?.so;" .. package.cpath

local module = require("peer_" .. engine)
local shim = require "shim"
package.preload["digbox"] = function() return shim(module) end
local hard = require "hard"
local judge = require "judge"

local impossible = {
  B24 = "no calls that answer with an error",
}

local function number(x) return x and ("%.4g"):format(x) or "" end

local function line(case, row, verdict, why)
  local w = row and row.worst or {}
  print(table.concat({ case.id, step, engine, verdict, w.name or "", number(w.value), w.limit and (w.least and ">= " or "<= ") ..
    number(w.limit) or "", row and number(row.ms_per_s) or "", why or "" }, "\t"))
end

local function run(case)
  local cannot = impossible[case.id:sub(1, 3)]
  if cannot then return line(case, nil, "none", cannot) end
  local seconds, steps = step:match "^(%d+)/(%d+)$"
  local row = hard.run(case, { dt = seconds / steps, clock = module.cpu_seconds, limit = tonumber(limit) or 20, repeats = false,
                               timings = 3 })
  local why = row.error and row.error:match "cannot: (.*)"
  if why then return line(case, nil, "none", why) end
  if row.error then return line(case, row, "error", (row.error:gsub("%s+", " "))) end
  local verdict = judge(hard, row, engine)
  if verdict == "none" then return line(case, nil, verdict, "what this case asks for is not told") end
  line(case, row, verdict)
  for _, c in ipairs(details and row.criteria or {}) do
    local mark, sign = c.pass and "ok" or "FAIL", c.least and ">=" or "<="
    print(("#   %-4s %-44s %12s %s %s"):format(mark, c.name, number(c.value), sign, number(c.limit)))
  end
  if details then print(("#   top speed %.4g m/s, penetration now %s m"):format(row.speed, number(row.penetration))) end
end

for _, case in ipairs(hard.cases { wanted }) do run(case) end
