-- digbox/api_editor.lua - the interface for programs: JSON, and the LuaCATS file that editors read (digbox.d.lua).

local core = ...
local type, next, ipairs = type, next, ipairs

local api = core.api
local sorted = api.sorted
local writers = {}

-- ---- JSON ----

local escapes = { ['"'] = '\\"', ["\\"] = "\\\\", ["\n"] = "\\n", ["\t"] = "\\t" }

local function encode(value)
  local kind = type(value)
  if kind == "string" then return '"' .. value:gsub('[%c"\\]', function(c) return escapes[c] or ("\\u%04x"):format(c:byte()) end) .. '"' end
  if kind == "number" then
    if value ~= value or value == math.huge or value == -math.huge then return "null" end
    return math.type(value) == "integer" and ("%d"):format(value) or ("%.17g"):format(value)
  end
  if kind ~= "table" then return tostring(value) end
  local parts = {}
  if #value > 0 or next(value) == nil and value.list then
    for i, v in ipairs(value) do parts[i] = encode(v) end
    return "[" .. table.concat(parts, ",") .. "]"
  end
  for _, k in ipairs(sorted(value)) do parts[#parts + 1] = encode(k) .. ":" .. encode(value[k]) end
  return "{" .. table.concat(parts, ",") .. "}"
end

local function field_record(f)
  local kind, unit, bound = api.split(f)
  local default = f.default
  if type(default) == "number" and default ~= default then default = nil end
  local low, high = f.min, f.max
  if low and low <= -1e300 then low = nil end
  if high and high >= 1e300 then high = nil end
  local record = { kind = kind, unit = unit ~= "" and unit or nil, min = low, max = high, default = default, help = f[2], type = f.type,
    required = f.need or nil, effect = f.effect }
  if bound == ">0" then record.above = 0 elseif bound == ">=0" and not low then record.min = 0 end
  if type(f.of) == "table" then record.choices = f.of[1] and f.of or sorted(f.of) end
  if f.fields then
    record.fields = {}
    for name, inner in next, f.fields do record.fields[name] = field_record(inner) end
  end
  return record
end

local function call_record(e)
  local record = { name = e.name, owner = e.owner, help = e[1], gives = e.gives, call = api.call(e) }
  local fields = api.fields_of(e)
  if next(fields) then
    record.fields = {}
    for name, f in next, fields do record.fields[name] = field_record(f) end
  end
  for i, a in ipairs(e.takes or {}) do
    record.takes = record.takes or {}
    record.takes[i] = field_record { a[2], a[3], type = a.type, of = a.of, default = a.default, need = not a.optional }
    record.takes[i].name = a[1]
  end
  return record
end

-- Everything, or what has that name.
function writers.json(name)
  local all = { version = core.version, functions = {}, types = {}, events = {} }
  for _, e in ipairs(api.entries) do
    if not name or e.name == name or e.short == name then all.functions[e.name] = call_record(e) end
  end
  for _, t in ipairs(api.types) do
    local record = { help = t.help, properties = {} }
    for key, p in next, t.properties do
      record.properties[key] = { type = p[1], unit = p.unit, help = p[2], assignable = p.set or nil }
    end
    if t.name == "body" then
      record.fields = {}
      for key, f in next, api.sets.body.fields do record.fields[key] = field_record(f) end
    end
    if not name or t.name == name then all.types[t.name] = record end
  end
  for _, e in ipairs(api.events) do
    if not name or e.name == name then all.events[e.name] = { help = e.help, fields = e.fields } end
  end
  if name and not (next(all.functions) or next(all.types) or next(all.events)) then core.usage_unknown("name", name, api.by_name) end
  return encode(all) .. "\n"
end

-- ---- LuaCATS ----

local classes = {}
for _, t in ipairs(api.types) do classes[t.name] = "digbox." .. t.name end

local luacats = { real = "number|string", int = "integer", bool = "boolean", vec = "digbox.vectorlike", dir = "digbox.vectorlike",
  quat = "digbox.rotationlike", size = "number|string|digbox.vectorlike", range = "(number|string)[]", pair = "(number|string)[]",
  colour = "string|digbox.vectorlike", text = "string", material = "string", points = "digbox.vectorlike[]",
  indices = "integer[]|integer[][]", table = "table", ["function"] = "function", choice = "string",
    amount = "number|string|digbox.vectorlike" }

-- "body|vector" with the names of classes; "body[]?"
local function class_names(text)
  return (text:gsub("%a[%w_]*", function(word) return classes[word] end))
end

local function cats(f)
  local kind, unit = api.split(f)
  if type(f.of) == "table" and not f.type then
    local quoted = {}
    for i, name in ipairs(f.of[1] and f.of or sorted(f.of)) do quoted[i] = '"' .. name .. '"' end
    return table.concat(quoted, "|")
  end
  if f.type then return (class_names(f.type):gsub("digbox%.vector%f[^%w]", "digbox.vectorlike")) end
  if kind == "real" and unit == "" then return "number" end
  return luacats[kind] or classes[kind] or "any"
end

local function field_line(name, f, optional)
  local notes = { api.help(f) }
  local _, unit = api.split(f)
  if unit ~= "" then notes[#notes + 1] = unit end
  if api.range(f) ~= "" then notes[#notes + 1] = api.range(f) end
  if f.default ~= nil then notes[#notes + 1] = "default " .. api.default(f) end
  return ("---@field %s%s %s %s"):format(name, optional and "?" or "", cats(f), table.concat(notes, "; "))
end

local function class_of_fields(lines, class, fields, parents)
  lines[#lines + 1] = ("---@class %s%s"):format(class, #parents > 0 and ": " .. table.concat(parents, ", ") or "")
  for _, name in ipairs(sorted(fields)) do lines[#lines + 1] = field_line(name, fields[name], not fields[name].need) end
  lines[#lines + 1] = ""
end

local function set_class(name) return "digbox.fields." .. name:gsub(" ", "_") end

local function call_lines(lines, e, owner)
  if e.constant then return end
  local parameters = {}
  local fields = e.fields and next(e.fields) or e.with
  local class
  if fields then
    local parents = {}
    for i, name in ipairs(e.with or {}) do parents[i] = set_class(name) end
    class = e.fields and next(e.fields) and "digbox.fields." .. owner .. "." .. e.short or #parents == 1 and parents[1]
      or "digbox.fields." .. owner .. "." .. e.short
    if class ~= parents[1] then class_of_fields(lines, class, e.fields or {}, parents) end
  end
  lines[#lines + 1] = "---" .. (e[1] or "")
  for _, a in ipairs(e.takes or {}) do
    local f = { a[2], a[3], type = a.type, of = a.of }
    local optional = a.optional or e.also ~= nil
    lines[#lines + 1] = ("---@param %s%s %s %s"):format(a[1], optional and "?" or "", cats(f), a[3])
    parameters[#parameters + 1] = a[1]
  end
  if class then
    local name = e.filter and "filter" or "fields"
    local kind = e.filter and class .. "|function" or e.also and class .. "|number|string|digbox.body" or class
    local at = e.filter and 2 or #parameters + 1
    table.insert(parameters, at, name)
    lines[#lines + 1] = ("---@param %s%s %s"):format(name, (e.optional or e.filter) and "?" or "", kind)
  end
  if e.also then parameters[#parameters + 1] = "..." end
  if e.gives then lines[#lines + 1] = "---@return " .. class_names(e.gives) end
  lines[#lines + 1] = ("function %s%s%s(%s) end"):format(owner, e.mark, e.short, table.concat(parameters, ", "))
  lines[#lines + 1] = ""
end

local operators = {
  vector = { "add(digbox.vector): digbox.vector", "sub(digbox.vector): digbox.vector", "mul(number): digbox.vector",
    "div(number): digbox.vector",
    "unm: digbox.vector", "len: number" },
  rotation = { "mul(digbox.rotation): digbox.rotation", "mul(digbox.vector): digbox.vector" } }

-- The functions of a table or type.
local function owned_lines(lines, owner)
  lines[#lines + 1] = ("local %s = {}"):format(owner)
  lines[#lines + 1] = ""
  for _, e in ipairs(api.entries) do
    if e.owner == owner then call_lines(lines, e, owner) end
  end
end

local function type_lines(lines, t)
  local parents = t.name == "body" and ": " .. set_class "body" or ""
  lines[#lines + 1] = "---" .. t.help
  lines[#lines + 1] = ("---@class %s%s"):format(classes[t.name], parents)
  for _, name in ipairs(sorted(t.properties)) do
    local p = t.properties[name]
    local word = name:match "^[%a_][%w_]*$" and name or ('["%s"]'):format(name)
    lines[#lines + 1] = ("---@field %s %s %s%s"):format(word, class_names(p[1]), p[2], p.unit and "; " .. p.unit or "")
  end
  for _, operator in ipairs(operators[t.name] or {}) do lines[#lines + 1] = "---@operator " .. operator end
  owned_lines(lines, t.name)
end

-- A table of functions: digbox itself, or one below it.
local function table_lines(lines, owner, fields)
  lines[#lines + 1] = "---@class " .. (owner == "digbox" and "digbox" or "digbox." .. owner)
  for _, field in ipairs(fields) do lines[#lines + 1] = field end
  owned_lines(lines, owner)
end

function writers.luacats()
  local lines = { "---@meta digbox", "-- luacheck: ignore",
    "-- Written by `digbox api --luacats` (digbox " .. core.version .. ").", "",
    "---@alias digbox.vectorlike digbox.vector|number[]|{x: number, y: number, z: number}",
    "---@alias digbox.rotationlike digbox.rotation|number[]|table", "" }
  local event_names = {}
  for i, e in ipairs(api.events) do event_names[i] = '"' .. e.name .. '"' end
  lines[#lines + 1] = "---@alias digbox.event_name " .. table.concat(event_names, "|")
  lines[#lines + 1] = ""
  for _, name in ipairs(sorted(api.sets)) do class_of_fields(lines, set_class(name), api.sets[name].fields, {}) end
  for _, t in ipairs(api.types) do type_lines(lines, t) end
  table_lines(lines, "digbox", { "---@field version string", "---@field parts digbox.parts" })
  table_lines(lines, "parts", {})
  table_lines(lines, "test", {})
  lines[#lines + 1] = "return digbox"
  return table.concat(lines, "\n") .. "\n"
end

return writers
