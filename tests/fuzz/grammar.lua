-- tests/fuzz/grammar.lua - bytes to a script: a sequence of calls of all that a script can name, with good, random and bad values.
--
-- What can be called, with what, comes from the declarations (lua/digbox/api.lua): nothing is listed here but what is left out.
-- Gets the core table and rooms to begin in (state.c); gives a function from a string of bytes to the text of a script, which catches
-- every error, gathers in
-- `said` what each call gave, and returns that. Equal bytes give equal texts.

local core, rooms = ...
core.commands, core.exit_codes = {}, ""
local api = core.use "api"

local STATEMENTS, STEPS, DEPTH = 24, 24, 2

-- ---- bytes ----

local data, at, steps

local function byte()
  at = at + 1
  return data:byte(at) or 0
end
local function below(n) return n > 256 and (byte() * 256 + byte()) % n or byte() % n end
local function pick(list) return list[below(#list) + 1] end
local function chance(n) return byte() < n end                 -- n of 256

-- ---- what can be called ----

local skipped_owners = { film = true, test = true, scenario = true, expect = true }
-- Draws and writes files; ends the script; is written in another way below.
local skipped = { ["world:render"] = true, ["world:record"] = true, ["digbox.args"] = true, ["world:save"] = true, ["digbox.load"] = true,
  ["world:run"] = true, ["world:step"] = true, ["world:cost"] = true, ["digbox.cost"] = true, ["world:replay"] = true }

local calls, makers, properties = {}, {}, {}
for _, e in ipairs(api.entries) do
  if not (skipped_owners[e.owner] or skipped[e.name] or e.constant) then
    calls[#calls + 1] = e
    if e.gives == "body" or e.gives == "joint" then makers[#makers + 1] = e end
  end
end
for _, t in ipairs(api.types) do
  if not skipped_owners[t.name] then
    for _, name in ipairs(api.sorted(t.properties)) do properties[#properties + 1] = { t.name, name, t.properties[name] } end
  end
end
local body_fields = api.sorted(api.sets.body.fields)
local event_names = api.sorted(core.declared.events)
local kinds = { "world", "body", "joint", "DIG", "region", "link", "vector", "rotation", "shape", "snapshot", "subscription", "task",
  "effect", "room", "heater", "truss", "plank", "cloth", "lattice", "door", "drawer", "lift", "clock", "lava_lamp", "ragdoll", "truck",
  "camera", "answer" }

-- ---- values, as text ----

local bad = { "0/0", "1/0", "-1/0", "-1", "0", "1e308", "-1e308", "5e-324", "2^53 + 1", "math.maxinteger", "math.mininteger", "1.5", "'x'",
  "'7'", "true", "false", "nil", "{}", "{ 1, 2 }", "{ 1, 2, 3, 4 }", "{ 0/0, 0, 0 }", "{ 1e200, 0, 0 }", "{ x = 1 }", "print", "''",
  "('x'):rep(70)", "'a\\0b'", "'\\27[31m'", "'a\\nb'", "'\\xff\\xfe'", "W", "digbox", "hostile", "cyclic", "{ {} }",
  "{ [1] = 1, [1e6] = 2 }",
  "coroutine.create(print)", "1e-30", "1e30", "'1 m'", "'4 furlongs'", "'30 deg'", "get('body', 1)", "get('joint', 0)", "get('vector', 0)" }
local reals = { 0, 0.5, 1, 2, 0.1, 0.01, 3, 5, 10, 0.25, 1e-3, 100, 1e3, -1, -0.5, 1e4, 1e6, 0.3 }
local materials = { "oak", "steel", "rubber", "ice", "tile", "glass", "unobtainium" }
local names = { "a", "b", "crate", "ball", "a b", "\\u{20ac}", "1", "__index" }
local value, statement

local function real(f)
  local low, high = f.min or -1e300, f.max or 1e300
  local _, _, bound = api.split(f)
  if bound == ">0" then low = math.max(low, 1e-9) elseif bound == ">=0" then low = math.max(low, 0) end
  local x = pick(reals)
  for _ = 1, #reals do
    if x >= low and x <= high then return ("%.17g"):format(x) end
    x = reals[(x == x and below(#reals) or 0) + 1]
  end
  return ("%.17g"):format(low > -1e299 and low < 1e299 and low or math.min(high, 1))
end

local function near() return ("%g"):format((byte() - 128) / 40) end
local function vec() return ("{ %s, %s, %s }"):format(near(), near(), near()) end
local function get(kind) return ("get(%q, %d)"):format(kind, below(6)) end

local function list_of(item, most)
  local list = {}
  for i = 1, below(most + 1) do list[i] = item() end
  return "{ " .. table.concat(list, ", ") .. " }"
end

local function shape()
  local shapes = { "digbox.box { size = %s }", "digbox.sphere { radius = %s }", "digbox.capsule { radius = 0.2, length = %s }",
    "digbox.cylinder { radius = 0.2, height = %s }", "digbox.cone { radius = 0.3, height = %s }", "digbox.plane { normal = { 0, 1, %s } }",
    "digbox.hull { points = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, %s } } }" }
  return pick(shapes):format(pick { "0.5", "1", "0.2", "2" })
end

local function handler(depth)
  if depth >= DEPTH then return "function() end" end
  return "function(e) hear(e) " .. statement(depth + 1) .. " end"
end

local function any_value(f, depth)
  local types = f.type or ""
  if types:find "function" and chance(128) then return handler(depth) end
  if types:find "shape%[%]" then return list_of(shape, 3) end
  if types:find "shape" then return shape() end
  if types:find "%[%]%[%]" then return list_of(function() return list_of(near, 4) end, 4) end
  if types:find "body%[%]" then return list_of(function() return get "body" end, 3) end
  for _, kind in ipairs(kinds) do
    if types:find(kind, 1, true) and chance(200) then return get(kind) end
  end
  if types:find "vector" then return vec() end
  if types:find "number" then return real(f) end
  return pick { "1", "'x'", vec(), "{}", "true", "nil" }
end

local makers_of = {
  real = function(f) return real(f) end, bool = function() return pick { "true", "false" } end, vec = vec, dir = vec,
  int = function(f) return ("%d"):format(math.max(f.min and f.min > -1e15 and f.min or 0, math.min(f.max or 4, below(5)))) end,
  quat = function() return ("{ axis = %s, angle = %s }"):format(pick { "{ 0, 1, 0 }", "{ 1, 0, 0 }", vec() }, near()) end,
  size = function() return pick { "1", "0.5", "{ 1, 0.2, 0.5 }", "0.1", "2" } end,
  range = function() return pick { "{ -1, 1 }", "{ 0, 0.5 }", "{ -0.1, 0 }" } end,
  pair = function() return pick { "{ 1, 2 }", "{ 1, -1 }" } end,
  colour = function() return pick { "'red'", "'#ff8800'", "{ 1, 0.5, 0 }" } end,
  material = function() return ("%q"):format(pick(materials)) end,
  text = function() return "'" .. pick(names) .. "'" end, body = function() return get "body" end,
  joint = function() return get "joint" end,
  points = function() return list_of(vec, 8) end, indices = function() return list_of(function() return tostring(below(5)) end, 9) end,
  amount = function() return chance(128) and vec() or near() end,
  ["function"] = function(_, depth) return handler(depth) end,
}

local function table_of(fields, depth)
  local parts = {}
  for _, name in ipairs(api.sorted(fields)) do
    local f = fields[name]
    if f.need or chance(#parts < 6 and 40 or 6) then parts[#parts + 1] = ("%s = %s"):format(name, value(f, depth)) end
  end
  if chance(3) then parts[#parts + 1] = "radus = 1" end
  return "{ " .. table.concat(parts, ", ") .. " }"
end

function value(f, depth)
  if chance(24) then return pick(bad) end
  local kind = api.split(f)
  if type(f.of) == "table" and kind ~= "table" then return ("%q"):format(pick(#f.of > 0 and f.of or api.sorted(f.of))) end
  if f.fields then return table_of(f.fields, depth) end
  local make = makers_of[kind]
  return make and make(f, depth) or any_value(f, depth)
end

-- ---- statements ----

-- What makes a thing stand apart or together: without a place all would be at the origin.
local function place(e, text)
  if e.gives ~= "body" or text:find "at = " or chance(36) then return text end
  return ("{ at = %s, %s"):format(vec(), text:sub(3))
end

local function arguments(e, depth)
  local list = {}
  for _, a in ipairs(e.takes or {}) do
    if a.optional and chance(100) then break end
    list[#list + 1] = value(setmetatable({ a[2], a[3] }, { __index = a }), depth)
  end
  local fields = api.fields_of(e)
  if next(fields) and not (e.optional and chance(60)) then list[#list + 1] = place(e, table_of(fields, depth)) end
  if e.filter then list[#list + 1] = handler(depth) end
  if chance(4) then list[#list + 1] = pick(bad) end
  return table.concat(list, ", ")
end

local function subject(owner)
  if chance(4) then return pick(bad) end
  return owner == "world" and (chance(240) and "W" or get "world") or get(owner)
end

local function call(e, depth)
  local rest = arguments(e, depth)
  rest = rest ~= "" and ", " .. rest or ""
  if e.owner == "digbox" then return ("run(%q, digbox.%s%s)"):format(e.gives or "", e.short, rest) end
  if e.owner == "parts" then return ("run(%q, digbox.parts.%s, W%s)"):format(e.gives or "", e.short, rest) end
  return ("send(%q, %q, %s%s)"):format(e.gives or "", e.short, subject(e.owner), rest)
end

local statements = {
  function(depth) return call(pick(makers), depth) end,
  function(depth) return call(pick(makers), depth) end,
  function(depth) return call(pick(calls), depth) end,
  function(depth) return call(pick(calls), depth) end,
  function(depth) return call(pick(calls), depth) end,
  function()
    local n = math.min(1 + below(4), STEPS - steps)
    steps = steps + n
    return ("send('', 'step', W, %d)"):format(n)
  end,
  function(depth)
    local name = pick(body_fields)
    return ("set(%s, %q, %s)"):format(get "body", name, value(api.sets.body.fields[name], depth))
  end,
  function(depth)
    local p = pick(properties)
    if p[3].set then return ("set(%s, %q, %s)"):format(subject(p[1]), p[2], value({ "real 1", "" }, depth)) end
    return ("read(%s, %q)"):format(subject(p[1]), p[2])
  end,
  function(depth) return ("send('subscription', 'on', %s, %q, %s)"):format(subject(pick { "world", "body" }), pick(event_names),
    handler(depth)) end,
  function() return ("send('', 'remove', %s)"):format(get(pick { "body", "joint", "region", "link", "effect", "truss", "plank" })) end,
  function()
    return pick { "if open() then W:check() end", "collect()", "bystander()", "send('', 'run', W, 0.05)", "run('world', digbox.world, {})" }
  end,
}

function statement(depth) return pick(statements)(depth) end

-- ---- the script ----

local head = [[
local digbox = require "digbox"
local made, said, hostile, cyclic = {}, {}, setmetatable({}, { __index = function() error "index" end,
    __len = function() return 2 ^ 60 end }), {}
cyclic[1], cyclic.a = cyclic, cyclic
local function say(...) said[#said + 1] = table.concat({ ... }, " ") end
local function show(v) return type(v) == "table" and "table" or tostring(v) end
local function keep(kind, v)
  for k in kind:gmatch "[%w_]+" do
    if v ~= nil and type(v) ~= "number" and type(v) ~= "boolean" then
      made[k] = made[k] or {}
      table.insert(made[k], v)
    end
  end
end
local function get(kind, n)
  local list = made[kind]
  return list and #list > 0 and list[n % #list + 1] or nil
end
local function judge(ok, v, kind)
  if ok then keep(kind, v) say(kind, show(v)) return end
  if type(v) ~= "string" then error("FAULT: an error without a text: " .. type(v), 0) end
  if #v > 4000 or v:find "[%c]" then error("FAULT: a message of " .. #v .. " bytes or with control bytes: " .. ("%q"):format(v), 0) end
  if not v:find "^fuzz%.lua:%d+: " then error("FAULT: a message that is not at the script's line: " .. v, 0) end
  say(v)
end
local function run(kind, f, ...)
  local ok, v = pcall(f, ...)
  judge(ok, v, kind)
end
local function send(kind, name, it, ...)
  if it == nil or type(it) == "string" then return end    -- the methods of a string are Lua's own, and so are their messages
  local n, list = select("#", ...), { ... }
  local ok, v = pcall(function() return it[name](it, table.unpack(list, 1, n)) end)
  judge(ok, v, kind)
end
local function set(it, name, v)
  if it == nil then return end
  local ok, e = pcall(function() it[name] = v end)
  judge(ok, e, "")
end
local function read(it, name)
  if it == nil then return end
  local ok, v = pcall(function() return it[name] end)
  judge(ok, v, "")
end
local function hear(e) say(type(e) == "table" and tostring(e.kind or e.name) or tostring(e)) end
local function K(kind, v) keep(kind, v) return v end
local W
local function collect() for i = 1, 200 do local t = { i, tostring(i) } end end
local function open() return (pcall(function() return W.time end)) end
local function bystander() if open() then say(W:checksum()) end end
]]

local tail = [[
bystander()
return table.concat(said, "\n")
]]

return function(bytes)
  data, at, steps = bytes, 0, 0
  local room = rooms[below(#rooms + 1)]
  local lines = { room and ("do\n%sW = w\nend"):format(room) or "W = digbox.world {}",
    "made.world, made.body, made.joint = { W }, W:bodies(), W:joints()" }
  while at < #data and #lines < STATEMENTS do lines[#lines + 1] = statement(0) end
  return head .. table.concat(lines, "\n") .. "\n" .. tail
end
