-- digbox/trace.lua - `digbox run --trace FILE`: every frame step, and what it spent its time on, into a file for a trace viewer.

local core = ...
local step, count_warnings = core.step, core.warning_count
local trace

local function cannot_write(why)
  core.raise(9, ("%s: %s"):format(core.options.trace, why or "cannot be written"))
end

function core.step(world)
  if not core.options.trace then return step(world) end
  if not trace then
    local why
    trace, why = core.trace_open(core.options.trace)
    if not trace then cannot_write(why) end
  end
  if not core.trace_step(trace, world) then cannot_write() end
  return count_warnings(world)
end

-- At the end of a run
function core.finish_trace()
  local open = trace
  trace = nil
  if open and not core.trace_close(open) then cannot_write() end
end

return true
