-- digbox/declare.lua - the register of all that a script can name: what it takes, what it gives, and one sentence of help.
--
-- A declaration stands beside the code it is of; those of functions written in C are in interface.lua. core.check and, for C,
-- bind_arguments read the same tables, so a field that is not declared is refused and one that is declared has its type, unit,
-- bounds and help here and nowhere else. Fields of bodies, shapes, joints, materials and effects are rows of the engine
-- (engine/digbox.h, dig_param). lua/digbox/api.lua puts both together for `digbox api`, docs/lua.md and the editor.
--
-- A field is { "vec m", "what it is for", ... }: kind, unit and bound, then the help, then, where it applies,
--   default =   taken by core.check when the field is not given; of functions in C, what they take then
--   min = max = of a number; need = true when it must be given; of = the table (or list) of names it can be
--   type =      for "any": what it can be, as LuaCATS writes it ("body|vector")

local core = ...
local type = type

local declared = { list = {}, by_name = {}, types = {}, type_list = {}, events = {} }
core.declared = declared

-- core.declare("world:lamp", { "What it does.", fields = {...} | takes = {{name, spec, help}, ...}, gives = "camera" }) -> its fields
-- fields are those of the table it is called with; `with` names further sets of fields ("body", "shape cylinder")
function core.declare(name, entry)
  local owner, mark, short = name:match "^([%w_]+)([:.])([%w_]+)$"
  entry.name, entry.owner, entry.short, entry.mark = name, owner, short, mark
  declared.list[#declared.list + 1], declared.by_name[name] = entry, entry
  core.fields[name] = entry.fields
  return entry.fields
end

-- core.declare_type("film", "What it is.", methods, {frames = {"int 1", "frames so far"}, ...}) -> the table of properties
-- methods: the table of functions that such a value has; properties with set = true can be assigned
function core.declare_type(name, help, methods, properties)
  local t = { name = name, help = help, methods = methods or {}, properties = properties or {} }
  declared.types[name] = t
  declared.type_list[#declared.type_list + 1] = t
  return t.properties
end

-- core.declare_event("contact_begin", "When.", "self other point ...")
function core.declare_event(name, help, fields)
  local list = {}
  for field in fields:gmatch "%S+" do list[#list + 1] = field end
  declared.events[name] = { name = name, help = help, fields = list }
end

-- Methods written in Lua check what they are called on: `body.on("impact", f)` is one clear error. Of all types declared so far.
function core.guard_methods()
  for _, t in ipairs(declared.type_list) do
    for name, method in next, t.methods do
      local full = t.name .. ":" .. name
      if declared.by_name[full] and type(method) == "function" and core.is_lua(method) then
        t.methods[name] = core.guard(method, full, t.name)
      end
    end
  end
  for prefix, functions in next, { ["digbox."] = core.digbox, ["digbox.parts."] = core.digbox.parts } do
    for name, value in next, functions do
      if type(value) == "function" and core.is_lua(value) then functions[name] = core.guard(value, prefix .. name) end
    end
  end
end

-- Joins sets of fields into one table.
function core.join_fields(...)
  local all = {}
  for _, set in ipairs { ... } do
    for name, field in next, set do
      if type(field) ~= "table" then error("field " .. name .. " has no help") end
      all[name] = field
    end
  end
  return all
end

-- core.opaque(meta) -> make, open, is: make(data) gives a handle with that metatable, open(handle) its data, which no script can
-- reach: rawget and rawset see an empty table. is(value): it is such a handle.
function core.opaque(meta)
  local inside = setmetatable({}, { __mode = "k" })
  local function make(data)
    local handle = setmetatable({}, meta)
    inside[handle] = data
    return handle
  end
  return make, function(handle)
    return inside[handle] or core.fail("expected a %s, got %s", meta.__name, core.type(handle))
  end, function(value) return inside[value] ~= nil end
end

return true
