-- digbox/watch.lua - runs that became unreliable say so: one line for each rule on stderr, and under --strict an exit code.

local core = ...

core.unreliable = 0             -- warnings of all worlds of this run
local told, first = {}, nil     -- rules that have had their line; the first line

-- world:warnings()[i] as a sentence without its end: "at t = 1.25 s energy rose without work, at 'plank 7' in DIG 3: 12 J, bound 0.4 J"
local function describe(warning)
  local who = warning.name ~= "" and ("'%s'"):format(warning.name) or ("body #%d"):format(warning.slot)
  local line = ("at t = %.6g s %s, at %s in DIG %d: %.3g %s, bound %.3g %s"):format(warning.time, warning.reason, who, warning.dig,
    warning.value, warning.unit, warning.bound, warning.unit)
  return warning.why and ("%s (%s)"):format(line, warning.why) or line
end
core.describe_warning = describe

-- After a step that ended with another number of warnings
function core.watch(world, state, count)
  local before, list = state.warnings, world:warnings()
  state.warnings = count
  for i = before + 1, count do
    local warning = list[i]
    core.unreliable = core.unreliable + 1
    first = first or describe(warning)
    if core.options.mode == "run" and not core.options.quiet and not told[warning.rule] then
      told[warning.rule] = true
      core.clear_progress()
      core.tell(("digbox: unreliable: %s; %s\n"):format(describe(warning), warning.advice))
    end
  end
end

-- For the closing line: "" or "; 3 warnings (energy, overlap)"
function core.count_warnings(world)
  local seen, rules = {}, {}
  local list = world:warnings()
  for _, warning in ipairs(list) do
    if not seen[warning.rule] then
      seen[warning.rule] = true
      rules[#rules + 1] = warning.rule
    end
  end
  if #list == 0 then return "" end
  return ("; %d warning%s (%s)"):format(#list, #list == 1 and "" or "s", table.concat(rules, ", "))
end

local remarked = {}

-- What is legal but hardly meant, once: "world.lua:12: world:box.rotation.angle = 90 rad: write '90 deg' if degrees are meant"
function core.remark(text)
  local mode = core.options.mode
  if remarked[text] or mode == "test" or (core.options.quiet and mode ~= "check") then return end
  remarked[text] = true
  core.clear_progress()
  core.tell("digbox: " .. text .. "\n")
end

-- ---- bodies whose numbers were not finite any more ----

local faults = {}               -- { body =, text = } of those that were set aside and nobody dealt with

-- The engine has refused a step for a body, which is disabled; the step is taken again without it.
function core.set_aside(world, body, why, place)
  local made = place and place ~= "" and (", made at %s,"):format(place) or ""
  faults[#faults + 1] = { body = body, text = ("%s%s was set aside at t = %.6g s, its numbers were not finite any more"):format(
    tostring(body), made, world.time) }
  core.clear_progress()
  if core.options.mode ~= "test" and not core.options.quiet then
    core.tell(("digbox: %s; %s%s is set aside\n"):format(why, tostring(body), made))
  end
end

-- A handler of "disabled" has dealt with it.
function core.forgive(body)
  for i = #faults, 1, -1 do
    if faults[i].body == body then table.remove(faults, i) end
  end
end

-- What nobody dealt with since it was last asked, as text; nil: nothing
function core.take_faults()
  local fault, count = faults[1], #faults
  faults = {}
  return fault and (count == 1 and fault.text or ("%s; and %d more"):format(fault.text, count - 1))
end

-- At the end of a run
function core.judge_finite()
  local text = core.take_faults()
  if text then core.raise(10, text) end
end

-- --inject nan:body=7,step=60: that body gets a number that is none in the first step after that one
function core.inject_before_step(world, inject)
  if world.steps ~= inject.step then return end
  core.options.inject = nil
  if not core.inject(world, inject.body) then core.usage("--inject: there is no body #%d at step %d", inject.body, inject.step) end
end

-- At the end of a run with --strict
function core.judge_reliable()
  if core.unreliable == 0 then return end
  core.raise(12, ("unreliable (%d warning%s): %s"):format(core.unreliable, core.unreliable == 1 and "" or "s", first))
end

return true
