-- tests/accuracy/judge.lua - runs scenes at the plans and the ladder, and prints the four verdicts of each.
--
--   digbox run tests/accuracy/judge.lua -- --scenes A07,A09 --finest 1e-9
local digbox = require "digbox"
local test = require "digbox.test"
local suite = require "suite"
local verdicts = require "verdicts"

local options = digbox.args {
  scenes = { default = "all", help = "ids or beginnings of ids, with commas" },
  finest = { default = 1e-12, help = "where the ladder ends" },
  order = { default = 4, help = "nominal order of the integrator" },
  skip_slow = { default = true, help = "leave out scenes that take long" },
}

test.scenario("verdicts", function(s)
  local wanted = {}
  for id in options.scenes:gmatch "[^,]+" do wanted[#wanted + 1] = id end
  local judged, failed = 0, 0
  for _, scene in ipairs(suite.scenes(options.scenes ~= "all" and wanted or nil)) do
    local rows = {}
    for _, setting in ipairs { "play", "reference", table.unpack(suite.ladder) } do
      local run = not (options.skip_slow and scene.slow) and not (type(setting) == "number" and setting < options.finest * 0.99)
      local ok, row = false, nil
      if run then ok, row = pcall(suite.run, scene, setting, s.cpu_seconds) end
      if ok then rows[#rows + 1] = row elseif run then print(("FAIL  %s at %s: %s"):format(scene.id, setting, row)) end
    end
    local list = verdicts.judge(scene, rows, options.order)
    if #list > 0 then print(verdicts.report(scene, list)) end
    for _, v in ipairs(list) do
      if v.pass ~= nil then judged = judged + 1 end
      if v.pass == false then failed = failed + 1 end
    end
  end
  print(("%d verdicts, %d failed"):format(judged, failed))
  test.expect(judged):above(0)
end)
