-- digbox/repl.lua - what `digbox repl` adds: the globals to begin with, and the names that Tab completes.

local core = ...
local type, next = type, next

local globals = core.globals
globals.digbox = core.digbox

-- After the script, if there is one: `world` is the world it made last, or a new one.
function core.begin_repl()
  if globals.world == nil then globals.world = core.last_world or core.digbox.world {} end
  globals.test = core.use "test"
  core.use "api"
  core.clear_progress()
end

-- help "world:lamp": what digbox api says
function globals.help(name)
  core.print((core.api_text("text", name):gsub("\n$", "")))
end

-- ---- completion ----

-- The value that a chain such as world.energy or a.b stands for; nothing is called but properties.
local function value_of(chain)
  local value = globals
  for name in chain:gmatch "[%w_]+" do
    local ok, inner = pcall(function() return value[name] end)
    if not ok then return nil end
    value = inner
  end
  return value
end

local function add(list, prefix, name, begin)
  if type(name) == "string" and name:sub(1, #begin) == begin and name:match "^[%a_][%w_]*$" then list[#list + 1] = prefix .. name end
end

local function owner_names(list, value, prefix, mark, begin)
  local owner = core.type(value)
  if owner == "table" or owner == "userdata" then
    local meta = getmetatable(value)
    owner = type(meta) == "table" and meta.__name or owner
  end
  local t = core.declared.types[owner]
  if not t then return false end
  if mark == "." then
    for name in next, t.properties do add(list, prefix, name, begin) end
  end
  for _, e in ipairs(core.api.entries) do
    if e.owner == owner and mark == ":" then add(list, prefix, e.short, begin) end
  end
  return true
end

-- core.complete(text, n) -> the n-th name that begins so, or nil
function core.complete(text, n)
  local list = {}
  local chain, mark, begin = text:match "^([%w_.]*)([.:])([%w_]*)$"
  if not chain then chain, mark, begin = "", "", text:match "^[%w_]*$" end
  if not begin then return nil end
  local value = value_of(chain)
  local prefix = chain .. mark
  local known = value ~= nil and mark ~= "" and owner_names(list, value, prefix, mark, begin)
  if not known and type(value) == "table" and mark ~= ":" then
    for name in next, value do add(list, prefix, name, begin) end
  end
  table.sort(list)
  return list[n]
end

return true
