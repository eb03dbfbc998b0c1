-- tests/accuracy/run.lua - runs scenes of the accuracy suite at settings, and prints one line of CSV for each.
--
--   digbox run tests/accuracy/run.lua -- --scenes A01,A07 --settings play,1e-6
--   digbox run tests/accuracy/run.lua -- --settings ladder --skip_slow true
--
-- scenes: ids or beginnings of ids, "all"; settings: plans, numbers, "plans", "ladder", "all".
local digbox = require "digbox"
local test = require "digbox.test"
local suite = require "suite"

local options = digbox.args {
  scenes = { default = "all", help = "ids or beginnings of ids, with commas" },
  settings = { default = "all", help = "plans and tolerances, with commas; plans, ladder or all" },
  repeats = { default = 25, help = "most timed runs of each setting; the least CPU time counts" },
  skip_slow = { default = false, help = "leave out scenes that take long" },
  details = { default = false, help = "also print what else each scene measures, as comments" },
}

local function split(text)
  local list = {}
  for word in text:gmatch "[^,]+" do list[#list + 1] = word end
  return list
end

local function settings()
  local list = {}
  for _, word in ipairs(split(options.settings)) do
    if word == "plans" or word == "all" then table.move(suite.plans, 1, #suite.plans, #list + 1, list) end
    if word == "ladder" or word == "all" then table.move(suite.ladder, 1, #suite.ladder, #list + 1, list) end
    if word ~= "plans" and word ~= "ladder" and word ~= "all" then list[#list + 1] = tonumber(word) or word end
  end
  return list
end

local function print_details(row)
  local words = {}
  for key, value in pairs(row.result) do
    local text = type(value) == "number" and ("%.3e"):format(value) or tostring(value)
    if key ~= "error" then words[#words + 1] = key .. "=" .. text end
  end
  print(("#   traced %d swept %d conserved %d of %d frames, rejected %d %s %s"):format(row.traced, row.swept, row.conserved, row.frames,
    row.rejected, row.gave_up > 0 and row.gave_up_why or "", table.concat(words, " ")))
end

local function run(scene, setting, clock)
  local ok, row = pcall(suite.run, scene, setting, clock, options.repeats)
  if not ok then return print(("# %s at %s: %s"):format(scene.id, setting, tostring(row))) end
  print(suite.csv(row))
  if options.details then print_details(row) end
end

test.scenario("accuracy suite", function(s)
  local scenes = suite.scenes(options.scenes ~= "all" and split(options.scenes) or nil)
  print(suite.header)
  -- All scenes at one setting before the next: what is cut short has the coarse ones of all
  for _, setting in ipairs(settings()) do
    for _, scene in ipairs(scenes) do
      if not (options.skip_slow and scene.slow) then run(scene, setting, s.cpu_seconds) end
    end
  end
  test.expect(#scenes):above(0)
end)
