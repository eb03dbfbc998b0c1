-- digbox/api.lua - all that a script can name, from the declarations (declare.lua) and the rows of the engine; `digbox api NAME`.
--
-- Loaded only when it is asked for. api_docs.lua and api_editor.lua write the same in other forms.

local core = ...
local type, next, ipairs, tostring = type, next, ipairs, tostring

core.use "test"                         -- it declares the scenario kit

local api = { entries = {}, by_name = {}, sets = {}, types = core.declared.type_list, events = {} }
core.api = api

function api.sorted(t)
  local keys = {}
  for k in next, t do keys[#keys + 1] = k end
  table.sort(keys)
  return keys
end
local sorted = api.sorted

-- ---- sets of fields: those that are rows of the engine ----

local function add_set(name, schema) api.sets[name] = { name = name, help = schema.help, fields = schema.fields } end

for _, kind in ipairs { "world", "body", "material", "room", "region", "pair", "part" } do add_set(kind, core.schemas(kind)[1]) end
for _, s in ipairs(core.schemas "shape") do add_set("shape " .. s.name, s) end
for _, s in ipairs(core.effect_schemas "world") do add_set("effect " .. s.name, s) end
for _, s in ipairs(core.effect_schemas "body") do
  for name, field in next, s.fields do
    field.effect = s.name
    api.sets.body.fields[name] = field
  end
end
api.sets.body.fields.data = { "any 1", "any value that the script wants to keep with it", type = "any" }

-- Other names of what all joints have, where the type has no field of that name.
local common = core.schemas "joint.common"[1]
for _, s in ipairs(core.schemas "joint") do
  local fields = {}
  for name, field in next, common.fields do fields[name] = field end
  for alias, name in next, core.joint_aliases do
    fields[alias] = {}
    for k, v in next, common.fields[name] do fields[alias][k] = v end
    fields[alias][2] = "the same as " .. name
  end
  for name, field in next, s.fields do fields[name] = field end
  add_set("joint " .. s.name, { help = s.help, fields = fields })
end

-- ---- functions ----

local function add(entry)
  api.entries[#api.entries + 1], api.by_name[entry.name] = entry, entry
end

local function constructor(owner, mark, short, help, set, also, gives)
  local name = owner .. mark .. short
  if core.declared.by_name[name] then return end
  add { help, name = name, owner = owner, mark = mark, short = short, with = { set, also }, gives = gives }
end

for _, entry in ipairs(core.declared.list) do add(entry) end
for _, s in ipairs(core.schemas "shape") do
  constructor("world", ":", s.name, "Makes a body: " .. s.help:gsub("%.$", "") .. ".", "shape " .. s.name, "body", "body")
  constructor("digbox", ".", s.name, "Makes a shape: " .. s.help:gsub("%.$", "") .. ".", "shape " .. s.name, "part", "shape")
end
constructor("world", ":", "ball", "The same as world:sphere.", "shape sphere", "body", "body")
for _, s in ipairs(core.schemas "joint") do
  local taken = api.by_name["world:" .. s.name]
  constructor("world", ":", s.name .. (taken and taken.gives == "body" and "_joint" or ""), "Makes a joint: " .. s.help .. ".",
    "joint " .. s.name, nil, "joint")
end

-- All fields of a call: its own and those of the sets it names.
function api.fields_of(entry)
  local all = {}
  for _, name in ipairs(entry.with or {}) do
    local set = api.sets[name]
    if not set then error("no set of fields '" .. name .. "'") end
    for k, v in next, set.fields do all[k] = v end
  end
  for k, v in next, entry.fields or {} do all[k] = v end
  return all
end

for _, name in ipairs(sorted(core.declared.events)) do api.events[#api.events + 1] = core.declared.events[name] end

api.owners = { "digbox", "world", "body", "joint", "DIG", "region", "link", "vector", "rotation", "shape", "snapshot", "subscription",
  "task",
  "effect", "room", "heater", "truss", "plank", "cloth", "lattice", "rope", "parts", "door", "drawer", "lift", "clock", "lava_lamp",
  "ragdoll", "truck", "camera", "film", "answer", "hit", "event", "test", "scenario",
    "expect" }

-- Names with "." and ":" of all there is, sorted: functions, methods, properties, events.
function api.names()
  local names = {}
  for _, e in ipairs(api.entries) do names[e.name] = true end
  for _, t in ipairs(api.types) do
    for name in next, t.properties do names[t.name .. "." .. name] = true end
  end
  for name in next, api.sets.body.fields do names["body." .. name] = true end
  for _, e in ipairs(api.events) do names[e.name] = true end
  return sorted(names)
end

-- ---- words ----

local kind_words = { real = "number", int = "whole number", bool = "true or false", vec = "vector", dir = "direction", quat = "rotation",
  size = "vector or number", range = "{lowest, highest}", pair = "{first, second}", colour = "colour", text = "text", body = "body",
  joint = "joint", material = "material", points = "list of points", indices = "list of whole numbers", table = "table", choice = "one of",
  amount = "vector or number", ["function"] = "function", any = "anything" }

-- "real m >0" -> "real", "m", ">0"
function api.split(field)
  local kind, unit, bound = field[1]:match "^(%S+)%s*(%S*)%s*(%S*)$"
  if not kind or bound ~= "" and not bound:find "^[<>]" then kind, unit, bound = field[1]:match "^(%S+)%s+(.-)%s*([<>]?=?0?)$" end
  if unit:find "^>" then unit, bound = "", unit end
  if unit == "1" then unit = "" end
  return kind, unit, bound
end

local function number(x)
  return math.type(x) == "integer" and ("%d"):format(x) or ("%.6g"):format(x)
end

function api.range(field)
  local _, _, bound = api.split(field)
  local low, high = field.min, field.max
  if low and low <= -1e300 then low = nil end
  if high and high >= 1e300 then high = nil end
  if bound == ">0" and not low and not high then return "> 0" end
  if bound == ">=0" and not low and not high then return ">= 0" end
  if bound == ">0" then return "> 0, at most " .. number(high) end
  if low and high then return number(low) .. " to " .. number(high) end
  if low then return ">= " .. number(low) end
  return high and "<= " .. number(high) or ""
end

function api.choices(field)
  if type(field.of) ~= "table" then return "" end
  local names = field.of[1] and field.of or sorted(field.of)
  return table.concat(names, ", ")
end

function api.default(field)
  if field.need then return "required" end
  local d = field.default
  if d == nil then return "" end
  if type(d) == "number" then return number(d) end
  return tostring(d)
end

function api.kind(field)
  local kind = api.split(field)
  if kind == "any" and field.type then return (field.type:gsub("|", " or ")) end
  return kind_words[kind] or kind
end

local function unit_text(unit) return (unit:gsub("%*", " ")) end

-- "number, m, > 0"
function api.type_text(field)
  local _, unit = api.split(field)
  if field.unit then unit = field.unit end
  local parts = { api.kind(field) }
  if unit ~= "" then parts[#parts + 1] = unit_text(unit) end
  local range = api.range(field)
  if range ~= "" then parts[#parts + 1] = range end
  return table.concat(parts, ", ")
end

function api.help(field)
  local text, of = field[2], api.choices(field)
  if of ~= "" then text = text .. ": " .. of end
  return text
end

-- world:lamp{ at =, power = }    world:save(path)
function api.call(entry)
  if entry.constant then return entry.name end
  local names = {}
  for _, a in ipairs(entry.takes or {}) do names[#names + 1] = a.optional and "[" .. a[1] .. "]" or a[1] end
  local table_too = entry.fields or entry.with
  if not table_too then return ("%s(%s)"):format(entry.name, table.concat(names, ", ")) end
  local all = api.fields_of(entry)
  local keys = {}
  for _, k in ipairs(sorted(all)) do
    if all[k].need then keys[#keys + 1] = k .. " =" end
  end
  for _, k in ipairs(sorted(entry.fields or {})) do
    if not all[k].need and #keys < 6 then keys[#keys + 1] = k .. " =" end
  end
  keys[#keys + 1] = "..."
  local fields = "{ " .. table.concat(keys, ", ") .. " }"
  if entry.optional and #names == 0 then return entry.name .. "[" .. fields .. "]" end
  if #names == 0 then return entry.name .. fields end
  if entry.filter then return ("%s(%s, [%s], %s)"):format(entry.name, names[1], fields, names[2]) end
  return ("%s(%s, %s)"):format(entry.name, table.concat(names, ", "), entry.optional and "[" .. fields .. "]" or fields)
end

-- ---- text ----

local function columns(rows)
  local width, lines = {}, {}
  for _, row in ipairs(rows) do
    for i = 1, #row - 1 do width[i] = math.min(38, math.max(width[i] or 0, #row[i])) end
  end
  for _, row in ipairs(rows) do
    local parts = {}
    for i, cell in ipairs(row) do parts[i] = i < #row and cell .. (" "):rep(width[i] - #cell) or cell end
    lines[#lines + 1] = "  " .. (table.concat(parts, "  "):gsub("%s+$", ""))
  end
  return lines
end

local function field_rows(fields, prefix)
  local rows = {}
  for _, name in ipairs(sorted(fields)) do
    local f = fields[name]
    rows[#rows + 1] = { prefix .. name, api.type_text(f), api.default(f), api.help(f) }
    if f.fields then
      for _, row in ipairs(field_rows(f.fields, prefix .. name .. ".")) do rows[#rows + 1] = row end
    end
  end
  return rows
end

local function append(lines, more)
  for _, line in ipairs(more) do lines[#lines + 1] = line end
end

local function show_call(lines, entry)
  lines[#lines + 1] = api.call(entry) .. (entry.gives and " -> " .. entry.gives or "")
  lines[#lines + 1] = "  " .. (entry[1] or "")
  local rows = {}
  for _, a in ipairs(entry.takes or {}) do
    local f = { a[2], a[3], optional = a.optional, default = a.default, of = a.of, type = a.type }
    rows[#rows + 1] = { "(" .. a[1] .. ")", api.type_text(f), a.optional and api.default(f) or "required", api.help(f) }
  end
  if entry.fields then append(rows, field_rows(entry.fields, "")) end
  for _, name in ipairs(entry.with or {}) do
    if name ~= "body" or #entry.with == 1 and not entry.fields then append(rows, field_rows(api.sets[name].fields, "")) end
  end
  append(lines, columns(rows))
  for _, name in ipairs(entry.with or {}) do
    if name == "body" and #lines > 2 then lines[#lines + 1] = "  and all fields of a body: digbox api body" end
  end
  for _, other in ipairs(entry.also or {}) do
    other.name, other.gives, other[1] = entry.name, entry.gives, "The same, called in another way."
    lines[#lines + 1] = ""
    show_call(lines, other)
  end
end

local function property_rows(t)
  local rows = {}
  for _, name in ipairs(sorted(t.properties)) do
    local p = t.properties[name]
    rows[#rows + 1] = { t.name .. "." .. name, p[1] .. (p.unit and ", " .. p.unit or ""), p.set and "assignable" or "", p[2] }
  end
  return rows
end

local function show_type(lines, t)
  lines[#lines + 1] = t.name .. ": " .. t.help
  append(lines, columns(property_rows(t)))
  local rows = {}
  for _, e in ipairs(api.entries) do
    if e.owner == t.name then rows[#rows + 1] = { e.name, e[1] } end
  end
  append(lines, columns(rows))
  if t.name == "body" then
    lines[#lines + 1] = "fields, when it is made and as body.NAME:"
    append(lines, columns(field_rows(api.sets.body.fields, "")))
  end
end

local function show_event(lines, e)
  lines[#lines + 1] = ("event %s: %s"):format(e.name, e.help)
  local rows, properties = {}, core.declared.types.event.properties
  for _, name in ipairs(e.fields) do
    local p = properties[name]
    rows[#rows + 1] = { "e." .. name, p[1] .. (p.unit and ", " .. p.unit or ""), p[2] }
  end
  append(lines, columns(rows))
end

local function show_property(lines, name)
  local owner, key = name:match "^([%w_]+)%.([%w_]+)$"
  local t = owner and core.declared.types[owner]
  local p = t and t.properties[key]
  if p then
    lines[#lines + 1] = ("%s: %s%s%s"):format(name, p[1], p.unit and ", " .. p.unit or "", p.set and ", assignable" or "")
    lines[#lines + 1] = "  " .. p[2]
  end
  local f = owner == "body" and api.sets.body.fields[key]
  if f then append(lines, columns { { name, api.type_text(f), api.default(f), api.help(f) } }) end
  return p or f
end

-- What a material gives its bodies, and their units.
api.material_columns = { { "density", "kg/m^3" }, { "friction", "1" }, { "friction_dynamic", "1" }, { "rolling_friction", "1" },
  { "restitution", "1" }, { "heat_capacity", "J/(kg K)" }, { "conductivity", "W/(m K)" }, { "resistivity", "ohm m" }, { "strength", "Pa" },
  { "stiffness", "Pa" } }

local function show_material(lines, name)
  local world, known = core.digbox.world {}, {}
  for _, other in ipairs(core.material_names(world)) do known[other] = true end
  if known[name] then
    local m, rows = core.material_of(world, name), {}
    for i, c in ipairs(api.material_columns) do
      rows[i] = { c[1], m[c[1]] and ("%.6g%s"):format(m[c[1]], c[2] ~= "1" and " " .. c[2] or "") or "" }
    end
    for _, p in ipairs(core.material_pairs(world)) do
      local other = p.a == name and p.b or p.b == name and p.a
      if other and p.friction then rows[#rows + 1] = { "friction on " .. other, ("%.6g"):format(p.friction) } end
    end
    lines[#lines + 1] = ('material = "%s" gives a body'):format(name)
    append(lines, columns(rows))
    lines[#lines + 1] = "All materials: digbox api --materials"
  end
  world:close()
end

-- The text for one name, or nil.
function api.explain(name)
  local lines = {}
  local function gap() if #lines > 0 then lines[#lines + 1] = "" end end
  local entry = api.by_name[name]
  if entry then show_call(lines, entry) return lines end
  if show_property(lines, name) then return lines end
  if core.declared.types[name] then show_type(lines, core.declared.types[name]) end
  if core.declared.events[name] then gap() show_event(lines, core.declared.events[name]) end
  for _, e in ipairs(api.entries) do
    if e.short == name then gap() show_call(lines, e) end
  end
  for _, t in ipairs(api.types) do
    if t.properties[name] then gap() show_property(lines, t.name .. "." .. name) end
  end
  local set = api.sets[name]
  if set and #lines == 0 then
    lines[#lines + 1] = ("%s: %s"):format(name, set.help)
    append(lines, columns(field_rows(set.fields, "")))
  elseif api.sets.body.fields[name] and not core.declared.types.body.properties[name] then
    gap()
    show_property(lines, "body." .. name)
  end
  if #lines == 0 then show_material(lines, name) end
  return #lines > 0 and lines or nil
end

function api.overview()
  local lines = { "digbox api NAME says more: a function, a method, a type, an event, a field of a body.", "" }
  for _, owner in ipairs(api.owners) do
    local t, rows = core.declared.types[owner], {}
    for _, e in ipairs(api.entries) do
      if e.owner == owner then rows[#rows + 1] = { e.name, e[1] } end
    end
    if t or #rows > 0 then
      lines[#lines + 1] = owner .. (t and ": " .. t.help or "")
      append(lines, columns(rows))
      if t then append(lines, columns(property_rows(t))) end
      lines[#lines + 1] = ""
    end
  end
  lines[#lines + 1] = "events"
  local rows = {}
  for _, e in ipairs(api.events) do rows[#rows + 1] = { e.name, e.help } end
  append(lines, columns(rows))
  return lines
end

-- Every word that can be asked for, as a set.
local function words()
  local known = {}
  for _, name in ipairs(api.names()) do known[name] = true end
  for _, e in ipairs(api.entries) do known[e.short] = true end
  for _, t in ipairs(api.types) do known[t.name] = true end
  for name in next, api.sets do known[name] = true end
  for name in next, api.sets.body.fields do known[name] = true end
  return known
end

-- core.api_text(form, name) -> what `digbox api` prints
function core.api_text(form, name)
  if form == "text" and name then
    local lines = api.explain(name)
    if not lines then core.usage_unknown("name", name, words()) end
    return table.concat(lines, "\n") .. "\n"
  elseif form == "text" then
    return table.concat(api.overview(), "\n") .. "\n"
  end
  local writers = core.use(({ json = "api_editor", luacats = "api_editor" })[form] or "api_docs")
  return writers[form](name)
end

return api
