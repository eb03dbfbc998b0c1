-- tests/hard/stress.lua - random worlds from seeds against what must always hold; a seed that fails is shrunk and printed as a script.
--
--   digbox run tests/hard/stress.lua -- --seed 1 --count 20 --seconds 20 [--step 1/30] [--accuracy study]
--   digbox run tests/hard/stress.lua -- --kind machines --seed 1 --count 20 --seconds 6      (or rooms)
local digbox = require "digbox"
local test = require "digbox.test"
local hard = require "hard"

local options = digbox.args {
  seed = { default = 1, help = "the first seed" },
  count = { default = 1, help = "so many seeds from there" },
  seconds = { default = 20, help = "simulated time" },
  step = { default = "1/60", help = "frame step, s" },
  accuracy = { default = "play", help = "plan" },
  limit = { default = 20, help = "CPU seconds of one run; beyond it a seed counts as over time" },
  shrink = { default = true, help = "look for the fewest bodies that still fail" },
  kind = { default = "world", help = "world, machines (bridges, carts) or rooms (laid tables)" },
  dearest = { default = false, help = "a frame of over 20 times the median cost (G7) is a failure, too" },
}

-- What fails first, by its letter; nil when all is well
local function failure(row)
  if row.error then return "error", row.error end
  for _, list in ipairs { row.always, row.criteria } do
    for _, c in ipairs(list) do
      local counts = (options.dearest or c.name:sub(1, 2) ~= "G7") and c.name ~= "simulated time, s"
      if not c.pass and counts then return c.name:match "^G%d" or c.name, ("%s = %.4g"):format(c.name, c.value) end
    end
  end
end

local files = { world = "random_world", machines = "random_machines", rooms = "random_rooms" }
local kinds = require(assert(files[options.kind], "--kind: world, machines or rooms"))

local above, below = options.step:match "^([%d.]+)/?([%d.]*)$"
local dt = assert(tonumber(above), "--step: a number of seconds, or 1/60") / (tonumber(below) or 1)

test.scenario("random worlds", function(s)
  local function run(w)
    return hard.run(kinds.case(w, options.seconds), { dt = dt, accuracy = options.accuracy, clock = s.cpu_seconds, limit = options.limit })
  end
  local counts = { pass = 0, fail = 0, ["over time"] = 0 }
  for seed = options.seed, options.seed + options.count - 1 do
    local w = kinds.world(seed)
    local row = run(w)
    local kind, why = failure(row)
    local verdict = kind and "fail" or row.over_time and "over time" or "pass"
    counts[verdict] = counts[verdict] + 1
    print(("seed %d\t%s\t%s\t%.3g ms/s\t%s\t%s\t%s"):format(seed, row.case.title, verdict, row.ms_per_s, row.shares, row.why, why or ""))
    if kind and options.shrink then
      local least = kinds.shrink(w, function(less)
        local ok, again = pcall(run, less)
        local same, reason = failure(ok and again or { always = {}, criteria = {} })
        if same == kind then why = reason end
        return same == kind
      end)
      print(kinds.script(least, options.seconds, why))
    end
  end
  print(("%d seeds: %d passed, %d failed, %d over time"):format(options.count, counts.pass, counts.fail, counts["over time"]))
  test.expect(counts.fail):is(0)
end)
