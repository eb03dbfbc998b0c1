-- digbox/cost.lua - what differs in a run of `digbox cost`: no pictures, and each frame step is timed and its state kept.
--
-- Measured is the first world that takes a step. core.cost_sample is there only in such runs (lua/cost_run.c).

local core = ...
local methods = core.types.world.methods
local step = core.step
local measured, over

core.steps = nil                -- each one is timed

local DEFAULT_SECONDS = 10      -- s, of a script that builds a world and never steps it

function core.step(world)
  if over then core.finish_early() end
  if measured and measured ~= world then
    core.cost_several()
    return step(world)
  end
  if not measured then
    measured = world
    core.cost_sample(world, 0)
  end
  local before = core.cpu_seconds()
  local warnings = step(world)
  over = core.cost_sample(world, core.cpu_seconds() - before)
  if over then core.finish_early() end
  return warnings
end

-- A film that takes no frames.
local Film = { frames = 0, closed = false }
Film.__index = Film

function Film.close(film) film.closed = true end

function methods.record(_, fields)
  return setmetatable({ fps = fields.fps or 30, path = fields.to }, Film)
end

function methods.render(_, fields)
  return fields.to
end

-- After the script: the rest of --seconds, and the last frame.
function core.cost_finish()
  if over then return end
  if not core.last_world then core.raise(1, core.options.script .. ": the script makes no world: there is nothing to measure") end
  if not measured and not core.options.seconds then core.options.seconds = DEFAULT_SECONDS end
  core.finish_run()
  if not measured then core.raise(1, core.options.script .. ": the world never takes a step: there is nothing to measure") end
  if core.is_open(measured) then core.cost_last(measured) end
end

return true
