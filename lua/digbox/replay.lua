-- digbox/replay.lua - `digbox run --replay FILE`: the first world that takes a step is kept in a file, with what the script says
-- about cameras, light and films, so that it can be drawn without being simulated again (docs/replay.md).

local core = ...
local type, next = type, next

local recorder, recorded    -- recorded: the world
local light_seen, films_seen, cameras_seen     -- changes that were written

-- ---- JSON ----

local escapes = { ['"'] = '\\"', ["\\"] = "\\\\", ["\n"] = "\\n", ["\r"] = "\\r", ["\t"] = "\\t" }

local function quote(text)
  return '"' .. text:gsub('[%c"\\]', function(c) return escapes[c] or ("\\u%04x"):format(c:byte()) end) .. '"'
end

local function number(x)
  if x ~= x or x == math.huge or x == -math.huge then return "null" end
  return math.type(x) == "integer" and ("%d"):format(x) or ("%.17g"):format(x)
end

-- A value of the binding as JSON: lists, tables by sorted keys, vectors as [x, y, z].
local function json(value)
  local kind = core.type(value)
  if value == nil then return "null" end
  if type(value) == "number" then return number(value) end
  if type(value) == "boolean" then return value and "true" or "false" end
  if kind == "vector" then return ("[%s,%s,%s]"):format(number(value.x), number(value.y), number(value.z)) end
  if type(value) ~= "table" then return quote(tostring(value)) end
  local parts = {}
  if #value > 0 or next(value) == nil then
    for i, item in ipairs(value) do parts[i] = json(item) end
    return "[" .. table.concat(parts, ",") .. "]"
  end
  local keys = {}
  for key in next, value do keys[#keys + 1] = tostring(key) end
  table.sort(keys)
  for i, key in ipairs(keys) do parts[i] = quote(key) .. ":" .. json(value[key]) end
  return "{" .. table.concat(parts, ",") .. "}"
end
core.json = json

-- ---- notes ----

local function origin(world)
  local o = core.options
  local set = {}
  for name, value in next, o.set or {} do set[name] = value end
  return json { program = "digbox " .. core.version, script = o.script_name or "", script_hash = o.script_hash or "",
    arguments = o.args or {}, set = next(set) and set or nil, seed = core.state(world).seed, step = world.frame, accuracy = world.accuracy }
end

-- Cameras that nobody touched and that look at no body stand where they stood.
local function note_cameras(world)
  local list = core.lua_state(world).cameras
  if list and (list.moving or list.changes ~= cameras_seen) then
    core.replay_cameras(recorder, core.cameras_now(world))
    cameras_seen = list.changes
  end
end

-- What seldom changes is written when it did.
local function note_scene(world)
  local state = core.lua_state(world)
  local light, films = state.scene.changes or 0, state.all_films
  note_cameras(world)
  if light ~= light_seen then
    core.replay_note(recorder, "light", json(core.light_now(world)))
    light_seen = light
  end
  if not films then return end
  local seen = films.changes .. " " .. (state.cameras and #state.cameras or 0)    -- a film says which camera it has
  if seen ~= films_seen then
    core.replay_note(recorder, "films", json(core.films_now(world)))
    films_seen = seen
  end
end

-- ---- stepping ----

local function begin(world)
  core.sweep(core.options.replay)
  recorded = world          -- once: a file that cannot be written is said once
  recorder = core.replay_open(core.options.replay, world, origin(world))
  core.lua_state(world).recorded = true
  note_scene(world)
  core.replay_before_step(recorder)
end

-- Before a step, when the script and its laws have done what they do before it.
function core.record_before_step(world)
  if not core.options.replay then return end
  if not recorded then
    begin(world)
  elseif recorder and recorded == world then
    note_scene(world)
    core.replay_before_step(recorder)
  end
end

-- Right after a step.
function core.record_step(world)
  if not recorder or recorded ~= world then return end
  note_cameras(world)       -- where they stand before the script moves them again: films blend towards that
  core.replay_step(recorder)
end

-- At the end of a run, or before the world is closed. A world that never took a step is kept as it is.
function core.finish_replay(world)
  if not core.options.replay then return end
  if not recorded and not world then
    local last = core.last_world
    if not last or not core.is_free(last) then return end
    begin(last)
  end
  if not recorder or (world and world ~= recorded) then return end
  local open = recorder
  if core.is_free(recorded) then note_scene(recorded) end
  recorder = nil
  core.replay_close(open)
end

return true
