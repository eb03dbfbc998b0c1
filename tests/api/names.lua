-- tests/api/names.lua - what is declared, what is there and what every document names are the same (run by tests/unit/test_api.c).
--
-- Gets the core table; gives a list of what does not agree, and how many things were compared.

local core = ...
local problems, checked = {}, 0

local function check(holds, format, ...)
  checked = checked + 1
  if not holds then problems[#problems + 1] = format:format(...) end
end

core.commands = { { name = "run", use = "  digbox run WORLD.lua   runs\n",
  options = "  -o, --output DIR   where\n      --seed N   seed\n" } }
core.exit_codes = "0 ok"
local api = core.use "api"
local test = core.use "test"

-- ---- what is there is declared, and the reverse ----

local inner = { view = true, renderer = true, pipe = true }         -- types that no script gets to see

for name, t in next, core.types do
  local declared = core.declared.types[name]
  if not inner[name] then
    check(declared, "type %s is not declared", name)
    for method in next, declared and t.methods or {} do check(api.by_name[name .. ":" .. method], "%s:%s is there, not declared", name,
      method) end
    for key in next, declared and t.getters or {} do check(declared.properties[key], "%s.%s is there, not declared", name, key) end
    for key in next, declared and declared.properties or {} do
      check(t.getters[key] or name == "room", "%s.%s is declared, not there", name, key)
    end
  end
end
for _, t in ipairs(core.declared.type_list) do
  for method in next, t.methods do
    if type(method) == "string" and not method:find "^__" then
      check(api.by_name[t.name .. ":" .. method], "%s:%s is there, not declared", t.name, method)
    end
  end
end
for name in next, core.digbox do check(api.by_name["digbox." .. name], "digbox.%s is there, not declared", name) end
for name in next, core.digbox.parts do check(api.by_name["parts." .. name], "parts.%s is there, not declared", name) end
for name in next, test do check(api.by_name["test." .. name], "test.%s is there, not declared", name) end
for kind in next, core.event_kinds do check(core.declared.events[kind], "event %s is there, not declared", kind) end
for name in next, core.declared.events do check(core.event_kinds[name], "event %s is declared, not there", name) end
for _, e in ipairs(api.entries) do
  local t = core.declared.types[e.owner]
  local there = e.owner == "digbox" and core.digbox[e.short] or e.owner == "test" and test[e.short] or
    e.owner == "parts" and core.digbox.parts[e.short] or t and t.methods[e.short]
  check(there, "%s is declared, not there", e.name)
end

-- ---- each has its help ----

local function check_fields(where, fields)
  for name, f in next, fields do
    check(type(f) == "table" and type(f[2]) == "string" and #f[2] > 1, "%s: field %s has no help", where, name)
    check(pcall(api.type_text, f), "%s: field %s has no type that can be read: %s", where, name, tostring(f[1]))
    local kind = api.split(f)
    check(api.kind(f) ~= kind or kind == "body" or kind == "joint" or kind == "text" or kind == "material" or kind == "table" or
      kind == "colour" or kind == "function" or f.type, "%s: field %s is of an unknown kind '%s'", where, name, kind)
    if f.fields then check_fields(where .. "." .. name, f.fields) end
  end
end
for _, e in ipairs(api.entries) do
  check(type(e[1]) == "string" and e[1]:find "[.)]$", "%s has no sentence of help", e.name)
  check_fields(e.name, api.fields_of(e))
  for _, a in ipairs(e.takes or {}) do check(#a[3] > 1, "%s: (%s) has no help", e.name, a[1]) end
end
for _, t in ipairs(api.types) do
  check(#t.help > 3, "type %s has no help", t.name)
  for name, p in next, t.properties do check(#p[1] > 0 and #p[2] > 1, "%s.%s has no help", t.name, name) end
  local listed = false
  for _, owner in ipairs(api.owners) do listed = listed or owner == t.name end
  check(listed, "type %s is not in the documents' list", t.name)
end
for _, e in ipairs(api.events) do
  for _, name in ipairs(e.fields) do check(core.declared.types.event.properties[name], "event %s: no field '%s'", e.name, name) end
end

-- ---- all documents name them ----

local forms = {}
for _, form in ipairs { "json", "luacats", "markdown", "completion", "man", "names", "text" } do forms[form] = core.api_text(form) end

local function has(form, text) return forms[form]:find(text, 1, true) ~= nil end

for _, name in ipairs(api.names()) do
  local short = name:match "[.:]?([%w_]+)$"
  check(api.explain(name), "digbox api %s says nothing", name)
  check(forms.names:find(name .. "\n", 1, true), "--names lacks %s", name)
  check(has("completion", " " .. name) or has("completion", "'" .. name), "completion lacks %s", name)
  check(has("man", ".B " .. name .. "\n"), "the manual page lacks %s", name)
  local entry = api.by_name[name]
  if entry then
    check(has("json", '"' .. name .. '":{'), "JSON lacks %s", name)
    check(has("luacats", "function " .. name .. "(") or entry.constant and has("luacats", "---@field " .. short .. " "),
      "LuaCATS lacks %s", name)
    check(has("markdown", "`" .. name), "docs/lua.md lacks %s", name)
    check(has("text", name .. " "), "digbox api lacks %s", name)
    for field in next, api.fields_of(entry) do check(has("markdown", "`" .. field .. "`"), "docs/lua.md lacks field %s of %s", field,
      name) end
  else
    check(has("json", '"' .. short .. '":{'), "JSON lacks %s", name)
    check(has("luacats", "---@field " .. short) or has("luacats", '"' .. name .. '"'), "LuaCATS lacks %s", name)
    check(has("markdown", "`" .. name .. "`") or has("markdown", "`" .. short .. "`"), "docs/lua.md lacks %s", name)
  end
end
for _, set in next, api.sets do
  for field in next, set.fields do check(has("luacats", "---@field " .. field), "LuaCATS lacks field %s of %s", field, set.name) end
end
local readable, why = load(forms.luacats, "=digbox.d.lua", "t")
check(readable, "digbox.d.lua is no Lua: %s", why)

-- ---- Tab completes them ----

core.globals = setmetatable({}, { __index = core.globals })
core.use "repl"
core.globals.world, core.globals.box = core.digbox.world {}, { lid = { open = true } }
for text, wanted in next, { ["wor"] = "world", ["digbox.wor"] = "digbox.world", ["world:lam"] = "world:lamp", ["world.tim"] = "world.time",
  ["box.lid.o"] = "box.lid.open", ["world.tune"] = false, ["nothing.at"] = false, ["(x"] = false } do
  check(core.complete(text, 1) == (wanted or nil), "Tab makes %s of %s", tostring(core.complete(text, 1)), text)
end
check(core.complete("world:", 40), "Tab after world: offers fewer than 40 methods")

-- ---- what other people's worlds rely on ----

local promised = {
  digbox = "world vec quat material load path args box sphere capsule cylinder cone hull mesh heightfield plane parts",
  parts = "clock door drawer lift lava_lamp ragdoll truck",
  world = [[step run bodies joints find digs snapshot restore checksum save effects effect stats on spawn ray overlap sweep region
    floor plane room box sphere ball capsule cylinder cone hull mesh heightfield body bucket rod
    hinge slider ball_joint weld distance rope spring gear rack wheel bolt motor messages heater ambient truss plank cloth lattice
    add_effect sun lamp sky camera render record]],
  ["world."] = "time steps energy momentum angular_momentum tasks",
  body = [[push twist hit move_to teleport remove contains touches neighbours links can_move dig_of send flood on]],
  ["body."] = [[position rotation velocity speed spin mass inertia awake asleep valid dig energy force torque bounds mode debug
    work_received
    name at density material friction friction_dynamic rolling_friction restitution fixed kinematic gravity_scale collides group colour
    temperature data heat_capacity conductivity emissivity convection surface contact_conductance]],
  ["joint."] = "angle distance speed force torque error valid",
  joint = "withdraw remove", DIG = "members links broadcast accuracy", ["DIG."] = "id size awake energy plan",
  ["answer."] = "verdict ok needs moved blocked_by held_by chain because consequences",
  vector = "dot cross length normalized", ["vector."] = "x y z", room = "open", film = "close", subscription = "off",
  task = "wait wait_until", truss = "push force stress node saw", plank = "saw", cloth = "saw", lattice = "saw",
  ["plank."] = "stress", ["cloth."] = "stress", ["lattice."] = "stress", heater = "on",
  test = "scenario expect each_accuracy", scenario = "settle eventually always golden perturb", ["scenario."] = "world",
  expect = "is near between below above at_least at_most is_empty contains fails",
  ["event."] = "time self other speed impulse point normal from to kind value",
}
local promised_fields = {
  ["digbox.world"] = "gravity step accuracy seed threads", ["world:run"] = "seconds stop_when", ["world:ray"] = "from to along length",
  ["body:push"] = "force at lasts along", ["body:twist"] = "torque lasts", ["body:hit"] = "impulse at", ["body:move_to"] = "at over",
  ["body:teleport"] = "at rotation velocity spin", ["body:neighbours"] = "kind", ["body:can_move"] = "along by with at turn",
  ["body:flood"] = "layer hops transform", ["world:hinge"] = "a b at axis limits motor spring friction breaks_at",
  ["world:distance"] = "length min max", ["world:rope"] = "length segments", ["world:spring"] = "stiffness damping length",
  ["world:gear"] = "a b ratio", ["world:bolt"] = "holds into strength", ["world:slider"] = "a b along limits",
  ["world:bucket"] = "height top_radius bottom_radius wall", ["world:rod"] = "length radius from along",
    ["world:mesh"] = "file vertices triangles",
  ["world:capsule"] = "radius length", ["world:cylinder"] = "radius height", ["world:plane"] = "normal offset", ["world:hull"] = "points",
  ["world:truss"] = "nodes struts stiffness damping breaks_at price budget", ["plank:saw"] = "at depth", ["world:heater"] = "on power",
  ["world:ambient"] = "temperature", ["world:add_effect"] = "name stage step", ["world:sun"] = "from shadows", ["world:lamp"] = "at power",
  ["world:camera"] = "at look_at fov follow", ["world:render"] = "camera to size samples layer", ["world:record"] = "camera to fps overlay",
  ["world:region"] = "laws", ["scenario:golden"] = "camera", ["scenario:perturb"] = "seeds position", ["body:on"] = "with faster_than",
}
local names = {}
for _, name in ipairs(api.names()) do names[name] = true end
for owner, list in next, promised do
  local mark = owner:find "%.$" and "" or (owner == "digbox" or owner == "test" or owner == "parts") and "." or ":"
  for name in list:gmatch "%S+" do check(names[owner .. mark .. name], "promised %s%s%s is missing", owner, mark, name) end
end
for call, list in next, promised_fields do
  local fields = api.by_name[call] and api.fields_of(api.by_name[call]) or {}
  for name in list:gmatch "%S+" do check(fields[name], "promised field %s of %s is missing", name, call) end
end
for name in ("contact_begin contact_end impact broken moved slept woke removed merged split link unlink message limit_reached out_of_world")
  :gmatch "%S+" do check(core.declared.events[name], "promised event %s is missing", name) end
for name in ("sketch play study reference"):gmatch "%S+" do check(pcall(core.digbox.world, { accuracy = name }),
  "promised accuracy %s is missing", name) end

-- Names of the electrical and hydraulic layers, of crowds and of the parts that need them belong here as soon as they are there.
local later = {
  world = "battery mains wire switch fuse bulb resistor capacitor inductor diode generator plug socket pipe tap valve basin tank " ..
    "drain pump plug_hole flock crowd traffic network", parts = "sink cooker_ring traffic_light" }
for owner, list in next, later do
  for name in list:gmatch "%S+" do
    local full = owner .. (owner == "parts" and "." or ":") .. name
    check(not names[full], "%s is there: move it to the promised names", full)
  end
end

return problems, checked
