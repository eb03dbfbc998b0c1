-- digbox/effect.lua - world:add_effect, and what is on and why, in words.

local core = ...
local next, type, pcall, error = next, type, pcall, error

local methods = core.types.world.methods

-- ---- effects of the script ----

local Effect = {}
Effect.__index = Effect
Effect.__name = "effect"
Effect.__metatable = false
Effect.__tostring = function(effect) return ("effect '%s'"):format(effect.name) end

-- effect:join(body): the body takes part from now on; effect:leave(body): no more
function Effect.join(effect, body)
  core.own_join(effect.world, effect.name, body, true)
  return effect
end

function Effect.leave(effect, body)
  core.own_join(effect.world, effect.name, body, false)
  return effect
end

-- effect:remove(): takes it away; world:effect(name, false) only switches it off
function Effect.remove(effect)
  core.own_drop(effect.world, effect.name)
end

local function start(world, effect, list, energy)
  for _, body in ipairs(list) do effect:join(body) end
  if energy then return world.energy.elastic end         -- what fails does so here
end

core.declare_type("effect", "An effect that the script made.", Effect, {
  name = { "string", "its name" }, world = { "world", "its world" }, data = { "any", "what was given as data" },
  time = { "number", "of the present evaluation", unit = "s" } })
core.declare("effect:join", { "The body takes part from now on.", takes = { { "body", "body", "who" } }, gives = "effect" })
core.declare("effect:leave", { "The body takes part no more.", takes = { { "body", "body", "who" } }, gives = "effect" })
core.declare("effect:remove", { "Takes the effect away." })

core.declare("world:add_effect", { "Adds an effect of the script's own: a function is asked for forces.", fields = {
  name = { "text", "its name", need = true },
  stage = { "text", "when it is asked", of = { "force", "settle" }, default = "force" },
  law = { "text", "its equation, for world:effects()" },
  bodies = { "any", "who takes part: a list, or a function of a body; default all that move", type = "body|body[]|function" },
  step = { "any", "function(effect, bodies, dt): sets bodies[i].force, N, and .torque, N m, or pushes", type = "function", need = true },
  energy = { "any", "function(effect, bodies): J that the forces store", type = "function" },
  data = { "any", "kept as effect.data" } }, gives = "effect" })

local function check_function(value, field, required)
  if value == nil and not required then return end
  if value == nil then core.fail("world:add_effect: %s is missing", field) end
  if type(value) ~= "function" then core.fail("world:add_effect.%s wants a function; got %s", field, core.type(value)) end
end

-- true: takes part. A filter is asked once about each body.
local function passes(filter, body)
  if body.kind ~= "dynamic" then return false end
  local ok, takes = core.call(filter, body)
  if not ok then error(takes, 0) end
  return takes
end

local function check_list(list)
  if core.type(list) == "body" then return { list } end
  if type(list) ~= "table" then
    core.fail("world:add_effect.bodies wants a list of bodies or a function of a body; got %s", core.type(list))
  end
  for i, body in ipairs(list) do
    if core.type(body) ~= "body" then core.fail("world:add_effect.bodies[%d] wants a body; got %s", i, core.type(body)) end
  end
  return list
end

-- world:add_effect{name=, stage="force"|"settle", bodies=list or function(body), step=function(effect, bodies, dt), energy=, law=, data=}
-- bodies: default all that move. step sets bodies[i].force, N, and .torque, N m; bodies[i]:push and :twist add to them.
-- energy(effect, bodies) -> J that the forces store.
function methods.add_effect(world, fields)
  core.forbid_in_handler(world, "world:add_effect")
  local f = core.check(fields, "world:add_effect")
  if f.name == nil then core.fail "world:add_effect: name is missing" end
  check_function(f.step, "step", true)
  check_function(f.energy, "energy", false)
  local filter = type(f.bodies) == "function" and f.bodies or nil
  local list = f.bodies ~= nil and not filter and check_list(f.bodies) or nil
  if filter then
    list = {}
    for _, body in ipairs(world:bodies()) do
      if passes(filter, body) then list[#list + 1] = body end
    end
  end
  local effect = setmetatable({ name = f.name, world = world, data = f.data, time = world.time }, Effect)
  core.quiet(world)
  core.own_add(world, effect, f.name, f.stage, f.step, f.energy, list == nil, f.law)
  local fine, message = pcall(start, world, effect, list or {}, f.energy)
  if not fine then
    core.own_drop(world, f.name)
    error(message, 0)
  end
  if filter then
    local state = core.state(world)
    state.newborn = state.newborn or {}         -- from now on, constructors add to it
    state.filters = state.filters or {}
    state.filters[#state.filters + 1] = { effect = effect, filter = filter }
  end
  return effect
end

-- Bodies made since the last step are shown to the filters. An effect that world:restore took away is passed over.
function core.ask_filters(world, state)
  local born = state.newborn
  if not born or #born == 0 then return end
  state.newborn = {}
  local known = world:effects()
  for _, f in ipairs(state.filters) do
    for _, body in ipairs(born) do
      if known[f.effect.name] and body.valid and passes(f.filter, body) then f.effect:join(body) end
    end
  end
end

-- ---- the summary ----

local function bytes_text(n)
  return n < 10000 and ("%d bytes"):format(n) or ("%.3g kB"):format(n / 1000)
end

-- Lines for the end of a run: what was on, why, how many take part, what it costs.
function core.effect_lines(world)
  local open, effects = pcall(function() return world:effects() end)
  local names, lines = {}, {}
  if not open then return lines end
  for name, e in next, effects do
    if e.on then names[#names + 1] = name end
  end
  table.sort(names, function(a, b) return effects[a].order < effects[b].order end)
  for _, name in ipairs(names) do
    local e = effects[name]
    lines[#lines + 1] = ("effect %-10s %s; %d taking part, %.3g us a step, %s"):format(name, e.why, e.bodies, e.us_mean,
      bytes_text(e.bytes))
  end
  local s = world:stats()
  if s.unturned + s.smooth + s.fast > 0 then
    local text = "not solved in the last step: rotation of %d of %d awake bodies, friction of %d of %d pairs; %d bodies look ahead"
    lines[#lines + 1] = text:format(s.unturned, s.awake, s.smooth, s.pairs, s.fast)
  end
  return lines
end

return true
