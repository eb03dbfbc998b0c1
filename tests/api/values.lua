-- tests/api/values.lua - bad values for every parameter of every function: each is one error, at the script's line, that names the
-- parameter; and the world is as it was (run by tests/unit/test_api.c). Cases A1-A4, A7-A9, A15, A16, A18, A19 of the acceptance list.
--
-- Gets the core table; gives a list of what does not hold, and how many calls were made. What is called and with what fields comes from
-- the declarations, so a new function or field is tested as soon as it is declared; here stands only a call of each that works.

local core = ...
local problems, calls = {}, 0
local digbox = core.digbox
core.commands, core.exit_codes = {}, ""
local api = core.use "api"
local FILE = "tests/api/values.lua"

-- ---- a world to call them in ----

local world, body, other, mover, hinge, second, slider, region, link, truss, plank, cloth, lattice, room, heater, effect
local door, drawer, lift, clock, lamp, doll, truck, rope

local function build()
  world = digbox.world {}
  world:box { name = "ground", fixed = true, size = 1, at = { 0, -5, 0 } }
  body = world:box { name = "crate", size = 1, at = { 0, 2, 0 }, temperature = 300 }
  other = world:ball { name = "ball", radius = 0.5, at = { 3, 2, 0 } }
  mover = world:box { name = "mover", kinematic = true, size = 1, at = { 9, 2, 0 } }
  hinge = world:hinge { name = "pivot", a = body, at = { 0, 2, 0 }, axis = { 0, 0, 1 } }
  second = world:hinge { a = other, at = { 3, 2, 0 }, axis = { 0, 0, 1 } }
  slider = world:slider { a = other, axis = { 1, 0, 0 } }
  region = world:region { sphere = { radius = 1 }, at = { 50, 0, 0 }, laws = { drag = 1 } }
  link = world:link { a = body, b = other, layer = "electrical" }
  world:camera { at = { 5, 5, 5 }, look_at = body }
  truss = world:truss { nodes = { A = { at = { 20, 1, 0 } }, B = { at = { 21, 1, 0 } } }, struts = { { "A", "B" } }, stiffness = 1e4 }
  plank = world:plank { from = { 30, 1, 0 }, to = { 31, 1, 0 }, width = 0.1, height = 0.02, material = "oak", segments = 2 }
  cloth = world:cloth { at = { 40, 3, 0 }, across = { 1, 0, 0 }, down = { 0, -1, 0 }, columns = 2, rows = 2, mass = 1, stiffness = 1e3 }
  lattice = world:lattice { at = { 45, 3, 0 }, size = 1, cells = 1, mass = 1, stiffness = 1e3 }
  rope = world:rope { a = other, at = { 3, 4, 0 }, segments = 2 }
  room = world:room { size = 1000, at = { 0, -500, 0 } }
  heater = world:heater { on = body, power = 0 }
  effect = world:add_effect { name = "nothing", step = function() end, bodies = { other } }
  door, drawer = digbox.parts.door(world, { at = { 80, 0, 0 } }), digbox.parts.drawer(world, { at = { 82, 0, 0 } })
  lift, clock = digbox.parts.lift(world, { at = { 84, 0, 0 }, height = 2 }), digbox.parts.clock(world, { at = { 86, 0, 0 } })
  doll, truck = digbox.parts.ragdoll(world, { at = { 88, 0, 0 } }), digbox.parts.truck(world, { at = { 94, 0, 0 } })
  lamp = digbox.parts.lava_lamp(world, { at = { 99, 0, 0 } })
  world:step()
end
build()

local subjects = {
  world = function() return world end, body = function() return body end, joint = function() return hinge end,
  DIG = function() return other.dig end, region = function() return region end, link = function() return link end,
  truss = function() return truss end, plank = function() return plank end, cloth = function() return cloth end,
  lattice = function() return lattice end, rope = function() return rope end,
  room = function() return room end, heater = function() return heater end,
  door = function() return door end, drawer = function() return drawer end, lift = function() return lift end,
  clock = function() return clock end, lava_lamp = function() return lamp end, ragdoll = function() return doll end,
  truck = function() return truck end, effect = function() return effect end, vector = function() return digbox.vec(1, 2, 3) end,
  rotation = function() return digbox.quat { axis = { 0, 1, 0 }, angle = 1 } end,
}

-- ---- calls that work: the table of fields ----

local at = { 0, 0, 0 }
local good = {
  ["world:box"] = { size = { 1, 1, 1 } }, ["world:sphere"] = { radius = 1 }, ["world:ball"] = { radius = 1 },
  ["world:capsule"] = { radius = 1, length = 1 }, ["world:cylinder"] = { radius = 1, height = 1 }, ["world:cone"] = { radius = 1,
    height = 1 },
  ["world:plane"] = { normal = { 0, 1, 0 } }, ["world:hull"] = { points = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } },
  ["world:mesh"] = { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 0, 1 } }, triangles = { { 1, 3, 2 } }, fixed = true },
  ["world:heightfield"] = { size = { 2, 1, 2 }, heights = { { 0, 0 }, { 0, 0 } } }, ["world:floor"] = {},
  ["world:rod"] = { length = 1, radius = 0.1 }, ["world:bucket"] = { height = 1, top_radius = 1 },
  ["world:plank"] = { from = { 60, 0, 0 }, to = { 61, 0, 0 }, width = 0.1, height = 0.02, segments = 2 },
  ["world:cloth"] = { at = { 60, 3, 0 }, across = { 1, 0, 0 }, down = { 0, -1, 0 }, mass = 1, stiffness = 1e3, columns = 2, rows = 2 },
  ["world:lattice"] = { at = { 60, 3, 0 }, size = 1, cells = 1, mass = 1, stiffness = 1e3 },
  ["world:room"] = { size = 1000 }, ["world:lamp"] = { at = { 0, 3, 0 } }, ["world:sun"] = {}, ["world:camera"] = {},
  ["world:ambient"] = { temperature = 293 }, ["world:air"] = {}, ["world:water"] = {}, ["world:ray"] = { from = at, to = { 1, 0, 0 } },
  ["world:overlap"] = { shape = digbox.sphere { radius = 1 } },
  ["world:sweep"] = { shape = digbox.sphere { radius = 1 }, from = { 0, 0, 0 }, to = { 1, 0, 0 } },
  ["world:region"] = { shape = digbox.sphere { radius = 1 } }, ["digbox.world"] = {}, ["digbox.material_pair"] = { a = "oak", b = "steel" },
  ["digbox.quat"] = { axis = { 0, 1, 0 }, angle = 1 }, ["body:push"] = { force = { 0, 0, 0 } }, ["body:twist"] = { torque = { 0, 0, 0 } },
  ["body:hit"] = { impulse = { 0, 0, 0 } }, ["body:teleport"] = {}, ["body:warm"] = { energy = 0 }, ["world:run"] = { seconds = 0 },
  ["body:can_move"] = { along = { 1, 0, 0 }, within = 0.1 }, ["body:neighbours"] = {}, ["body:links"] = {},
  ["plank:push"] = { at = 0.5, force = { 0, 0, 0 } }, ["plank:saw"] = { at = 0.5, depth = 1e-6 }, ["truss:saw"] = { at = at, depth = 1e-9 },
  ["cloth:saw"] = { at = at, depth = 1e-9 }, ["lattice:saw"] = { at = at, depth = 1e-9 },
  ["digbox.box"] = { size = { 1, 1, 1 } }, ["digbox.sphere"] = { radius = 1 }, ["digbox.capsule"] = { radius = 1, length = 1 },
  ["digbox.cylinder"] = { radius = 1, height = 1 }, ["digbox.cone"] = { radius = 1, height = 1 }, ["digbox.plane"] = { normal = { 0, 1,
    0 } },
}
for _, name in ipairs { "door", "drawer", "clock", "lava_lamp", "ragdoll", "truck" } do good["parts." .. name] = { at = { 60, 0, 0 } } end
good["parts.lift"] = { at = { 60, 0, 0 }, height = 3 }
local function with_bodies()
  good["world:truss"] = { nodes = { A = { at = { 70, 1, 0 } }, B = { at = { 71, 1, 0 } } }, struts = { { "A", "B" } }, stiffness = 1e4 }
  good["world:heater"] = { on = body, power = 0 }
  good["world:ask"] = { body = body, along = { 1, 0, 0 }, within = 0.1 }
  good["world:link"] = { a = body, b = other, layer = "thermal" }
  good["world:body"] = { parts = { digbox.box { size = 1 } } }
  good["world:add_effect"] = { name = "again", step = function() end, bodies = {} }
  good["body:send"] = { route = "to", to = other, name = "hello" }
  for _, s in ipairs(core.schemas "joint") do
    local name = api.by_name["world:" .. s.name .. "_joint"] and s.name .. "_joint" or s.name
    local two_at, spec = { a = body, b = other }, s.fields
    if spec.stiffness and spec.stiffness.need then two_at.stiffness = 1 end
    if s.name == "gear" then two_at = { a = hinge, b = second } end
    if s.name == "beam" then two_at = { a = body, b = other, axis = { 1, 0, 0 }, length = 1, width = 1, height = 1, modulus = 1e9 } end
    if s.name == "motor" then two_at.speed = 1 end
    if s.name == "rack" then two_at = { a = hinge, b = slider, ratio = 1 } end
    good["world:" .. name] = two_at
  end
end
with_bodies()

-- ---- calling ----

local line
local function call(name, ...)
  local owner, mark, short = name:match "^(%w+)([.:])([%w_]+)$"
  local packed = table.pack(...)
  local function run()
    local subject = owner == "parts" and digbox.parts or mark == "." and digbox or
      owner == "body" and (short == "move_to" or short == "drive") and mover or subjects[owner]()
    local f = subject[short]
    local first = mark == ":" and subject or owner == "parts" and world or nil
    if first then table.insert(packed, 1, first) end
    line = debug.getinfo(1, "l").currentline + 1
    local result = f(table.unpack(packed, 1, packed.n + (first and 1 or 0)))
    return result
  end
  calls = calls + 1
  return pcall(run)
end

local function problem(format, ...) problems[#problems + 1] = format:format(...) end

local function show(v)
  if type(v) == "string" then return #v > 30 and ("%q..."):format(v:sub(1, 20)) or ("%q"):format(v) end
  if type(v) ~= "table" then return tostring(v) end
  local parts = {}
  for k, x in next, v do parts[#parts + 1] = (type(k) == "string" and k .. "=" or "") .. tostring(x) end
  return "{" .. table.concat(parts, ",") .. "}"
end

-- One error at the line of the call, of one line without control bytes, and nothing changed. word: what it must name, or nil
local function refused(what, word, before, ok, message)
  if ok then return problem("%s is accepted", what) end
  if type(message) ~= "string" then return problem("%s: the error is a %s", what, type(message)) end
  if message:sub(1, #FILE + 1) ~= FILE .. ":" or tonumber(message:match ":(%d+): ") ~= line then
    problem("%s: not at the script's line (%d): %s", what, line, message:sub(1, 200))
  end
  if message:find "[%c]" or #message > 1500 then problem("%s: a message of %d bytes with control bytes, or too long", what, #message) end
  if word == "accuracy" and message:find "tolerance" then word = nil end           -- as a number it is one
  if word and not message:find(word, 1, true) then problem("%s: the message does not name %s: %s", what, word, message:sub(1, 200)) end
  if world:checksum() ~= before then
    problem("%s: refused, but the world changed", what)
    build()
    with_bodies()
  end
end

local nan, inf = 0 / 0, math.huge
local quat_values = { { 0, 0, 0, 0 }, { 1, 1, 1, 1 }, { nan, 0, 0, 1 }, { 0, 0, 1 }, { axis = { 0, 0, 0 } }, { axis = { 0, 1, 0 },
  angle = nan },
  { axle = { 0, 1, 0 } }, "north", true, 5 }
local not_numbers = { true, {}, print, "seven" }

-- Values that a field of such a kind must refuse
local function bad_values(f)
  local kind, unit, bound = api.split(f)
  local list = {}
  local function add(...)
    for _, v in ipairs { ... } do list[#list + 1] = v end
  end
  local low, high = f.min, f.max
  local over = high and high < 1e300 and (high > 0 and high * 2 or high + 1)
  local under = low and low > -1e300 and (low > 0 and (low > 1e-200 and low / 2 or 0) or low < 0 and low * 2 or -1)
  local outside = {}
  if over and over <= 1e300 then outside[1] = over end
  if under then outside[#outside + 1] = under end
  if bound == ">0" then outside[#outside + 1] = 0; outside[#outside + 1] = -1 end
  if bound == ">=0" then outside[#outside + 1] = -1 end
  local dimension = unit ~= "" and (unit:find "K" and "1 m" or "1 K") or nil
  if kind == "real" then
    add(nan, -inf, table.unpack(not_numbers))
    if high ~= inf then add(inf) end
    add(table.unpack(outside))
    if dimension then add(dimension, "1 frob", "m", "") end
  elseif kind == "int" then
    add(nan, inf, 1.5, "7", true, {}, print, 2.0 ^ 80)
    add(table.unpack(outside))
    if over or bound ~= "" or under then add(math.mininteger) end
  elseif kind == "bool" then add(1, 0, "true", {})
  elseif kind == "vec" or kind == "dir" or kind == "amount" then
    add({ 1, 2 }, { 1, 2, 3, 4 }, { nan, 0, 0 }, { 0, inf, 0 }, { x = 1, y = 2 }, {}, { "a", "b", "c" }, { [1] = 1, [1e6] = 2 }, true,
      print)
    if kind ~= "amount" then add(7, "up") end
    if kind == "dir" then add({ 0, 0, 0 }) end
    if kind ~= "amount" and kind ~= "dir" then
      for _, v in ipairs(outside) do add({ v, 0, 0 }) end
      if dimension then add({ dimension, 0, 0 }) end
    end
  elseif kind == "size" then add(nan, inf, 0, -1, 1e-30, 1e30, { 1, 1 }, { 1, 1, 0 }, { nan, 1, 1 }, "5 kg", true, print)
  elseif kind == "quat" then add(table.unpack(quat_values))
  elseif kind == "range" then add({ 1 }, { 2, 1 }, { nan, 1 }, { 0, nan }, 5, "wide", true, { "1 kg", "2 kg" })
  elseif kind == "pair" then add({ 1 }, { nan, 1 }, { 1, 2, 3 }, 5, true)
  elseif kind == "colour" then add("blurple", "#12345", "#gggggg", { nan, 0, 0 }, { 1, 1 }, 5, true)
  elseif kind == "text" or kind == "material" then
    add(5, true, {}, ("x"):rep(64), ("x"):rep(1000000), "a\0b", "a\nb", "a\27[31mb")
    if kind == "material" then add("unobtainium") end
  elseif kind == "choice" then add("frob", 5, true, {})
  elseif kind == "body" or kind == "joint" then add(5, "crate", {}, world, kind == "body" and hinge or body, region)
  elseif kind == "table" then add(5, "x", true, { frobnicate = 1 })
  elseif kind == "points" then add(5, "x", { 1, 2, 3 }, { { nan, 0, 0 } }, { { 0, 0 } })
  elseif kind == "indices" then add(5, "x", { 1.5 }, { "a" })
  elseif kind == "any" then
    local types = f.type or ""
    if types:find "^body" then add(5, "crate", world, hinge) end
    if types == "function" then add(5, "x", {}) end
    if types == "camera" then add(5, "x", {}, body) end
    if types == "region" or types == "shape" then add(5, "x", body) end
    if types:find "^string" and not types:find "number" then add(5, true) end
  end
  return list
end

local function copy(t)
  local c = {}
  for k, v in next, t do c[k] = v end
  return c
end

-- Fields that say the same in another way, or mean something only beside others: the good call without them, or with them
local instead = {
  ["body:can_move"] = { turn = { along = false } }, ["world:ask"] = { turn = { along = false } },
  ["world:sweep"] = { along = { to = false }, length = { to = false, along = { 1, 0, 0 } } },
  ["world:ray"] = { along = { to = false }, length = { to = false, along = { 1, 0, 0 } } },
  ["body:push"] = { along = { force = 1 } }, ["body:twist"] = { along = { torque = 1 } }, ["body:hit"] = { along = { impulse = 1 } },
  ["digbox.quat"] = { from = { axis = false, angle = false }, to = { axis = false, angle = false } },
  ["world:rod"] = { to = { from = { 0, 0, 0 }, length = false }, along = { from = { 0, 0, 0 } } },
}

local function try_fields(name)
  local entry, base = api.by_name[name], good[name]
  local fields = api.fields_of(entry)
  local ok, message = call(name, copy(base))
  if not ok then return problem("%s: the good call fails: %s", name, message) end
  build()
  with_bodies()
  base = good[name]
  local before = world:checksum()
  for _, field in ipairs(api.sorted(fields)) do
    for _, bad in ipairs(bad_values(fields[field])) do
      local t = copy(good[name])
      before = world:checksum()
      for k, v in next, instead[name] and instead[name][field] or {} do t[k] = v or nil end
      t[field] = bad
      local later = bad == "unobtainium" and entry.owner == "digbox" and entry.gives == "shape"     -- known when a body is made of it
      local fixed = bad == world and (field == "b" or field == "into") and entry.gives:find "^joint" and name ~= "world:gear"
        and name ~= "world:rack"                                           -- a joint to the world
      if not later and not fixed then refused(("%s{ %s = %s }"):format(name, field, show(bad)), field, before, call(name, t)) end
    end
  end
  local t = copy(base)
  t.radus = 1
  refused(name .. "{ radus = 1 }", "radus", before, call(name, t))
  t = copy(base)
  t[1] = digbox.vec(1, 2, 3)
  refused(name .. "{ vector }", nil, before, call(name, t))
  for _, bad in ipairs { 5, "x", true, print } do
    if not (name == "world:run" and type(bad) ~= "boolean" and type(bad) ~= "function") and
      not ((name == "world:air" or name == "world:water") and bad == true) then
      refused(("%s(%s)"):format(name, show(bad)), nil, before, call(name, bad))
    end
  end
  if not entry.optional and next(base) then refused(name .. "()", nil, before, call(name)) end
end

for _, name in ipairs(api.sorted(good)) do
  if api.by_name[name] then try_fields(name) else problem("%s is no function", name) end
end

-- ---- positional arguments ----

local positional = {
  ["world:step"] = { 1 }, ["world:find"] = { "crate" }, ["world:digs"] = { "mechanical" }, ["world:sky"] = { "clear" },
  ["world:spawn"] = { function() end }, ["world:effect"] = { "heat", true }, ["world:restore"] = {}, ["world:on"] = { "impact", print },
  ["body:on"] = { "impact", print }, ["body:touches"] = { "other" }, ["body:contains"] = { "other" }, ["body:velocity_at"] = { at },
  ["body:dig_of"] = { "thermal" }, ["joint:set"] = { { friction = 0 } }, ["DIG:accuracy"] = { "study" }, ["link:set"] = { 1, 1 },
  ["room:open"] = { "+x" }, ["room:close"] = { "+x" }, ["truss:node"] = { "A" }, ["truss:strut"] = { "AB" }, ["truss:force"] = { "AB" },
  ["truss:push"] = { "A", { 0, 0, 0 } }, ["plank:point"] = { 0.5 }, ["cloth:node"] = { 1, 1 }, ["lattice:node"] = { 1, 1, 1 },
  ["lift:go"] = { 1 }, ["clock:set_rate"] = { 1 }, ["truck:drive"] = { 1 },
  ["effect:join"] = { "other" }, ["effect:leave"] = { "other" }, ["vector:dot"] = { at }, ["vector:cross"] = { at },
    ["rotation:rotate"] = { at },
  ["digbox.vec"] = { 1, 2, 3 }, ["digbox.load"] = { "nowhere.dig" }, ["world:save"] = { "x.dig" }, ["digbox.quantity"] = { "1 m" },
}

local function arguments(name)
  local list = copy(positional[name])
  for i, v in ipairs(list) do
    if v == "other" then list[i] = other end
  end
  return list
end

for _, name in ipairs(api.sorted(positional)) do
  local entry = api.by_name[name]
  build()
  local before = world:checksum()
  for i, a in ipairs(entry and entry.takes or {}) do
    for _, bad in ipairs(bad_values { a[2], a[3], type = a.type, of = a.of }) do
      local list = arguments(name)
      list[i] = bad
      local same_by_number = a[2] == "text" and type(bad) == "string"      -- a text of any length may be a name that is not there
      local vector_first = name == "digbox.vec" and i == 1 and type(bad) == "table"
      local ok, message = call(name, table.unpack(list, 1, math.max(#list, i)))
      local endless = name == "digbox.vec" and (bad == inf or bad == -inf)
      if not (same_by_number and ok or vector_first or endless) then refused(("%s(%s)"):format(name, show(bad)), nil, before, ok,
        message) end
    end
    if not a.optional then refused(("%s without (%s)"):format(name, a[1]), nil, before, call(name, table.unpack(arguments(name), 1,
      i - 1))) end
  end
end

-- ---- called with a point, on the wrong thing, and assigned ----

build()
local before = world:checksum()
for _, e in ipairs(api.entries) do
  local subject = subjects[e.owner]
  if e.mark == ":" and subject then
    for _, wrong in ipairs { 5, "x", {}, true } do
      calls = calls + 1
      local method = subject()[e.short]
      line = debug.getinfo(1, "l").currentline + 1
      local ok, message = pcall(function() method(wrong, {}) return true end)
      local takes_tables = (e.owner == "vector" or e.owner == "rotation") and type(wrong) == "table"
      if not takes_tables then refused(("%s called with '.'"):format(e.name), nil, before, ok, message) end
    end
  end
end
for owner, subject in next, subjects do
  local t = core.declared.types[owner]
  for name, p in next, t.properties do
    if not p.set and owner ~= "effect" and owner ~= "room" then
      calls = calls + 1
      line = debug.getinfo(1, "l").currentline + 1
      local ok, message = pcall(function() subject()[name] = 1 end)
      refused(("%s.%s = 1"):format(owner, name), name, before, ok, message)
    end
  end
  calls = calls + 1
  line = debug.getinfo(1, "l").currentline + 1
  local ok, message = pcall(function() return subject().frobnicate end)
  if owner ~= "effect" then refused(owner .. ".frobnicate", "frobnicate", before, ok, message) end
end
for name, f in next, api.sets.body.fields do
  local kind = api.split(f)
  for _, bad in ipairs(kind ~= "any" and bad_values(f) or {}) do
    calls = calls + 1
    line = debug.getinfo(1, "l").currentline + 1
    local ok, message = pcall(function() other[name] = bad end)
    refused(("body.%s = %s"):format(name, show(bad)), name, before, ok, message)
  end
end

return problems, calls
