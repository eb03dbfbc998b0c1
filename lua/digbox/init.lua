-- digbox/init.lua - the module `digbox`: worlds, vectors, shapes, materials, arguments, paths.
--
-- Runs once, with the table of C functions. Errors raised here point at the script's own line.

local core = ...
local next, type, tonumber, rawset, setmetatable = next, type, tonumber, rawset, setmetatable
local math_type, to_integer = math.type, math.tointeger

local digbox = {}
core.digbox = digbox
core.materials, core.pairs_of_materials = {}, {}
core.worlds = setmetatable({}, { __mode = "k" })

local methods = core.types.world.methods

-- ---- ways to end a script ----

core.print = print
core.finished = setmetatable({}, { __tostring = function() return "finished" end })

-- Ends the script as if it had run to its end.
function core.finish_early()
  error(core.finished, 0)
end

-- 5 of 5 and of 10 / 2, which Lua keeps as 5.0; else nil.
function core.whole(n)
  return math_type(n) and to_integer(n) or nil
end

-- A mistake on the command line: exit code 2, no script position.
function core.usage(format, ...)
  core.raise(2, format:format(...))
end

function core.usage_unknown(kind, name, known)
  local _, message = pcall(core.unknown, "", "unknown " .. kind, name, known)
  core.usage("%s", (message:gsub("^.-unknown", "unknown")))
end

core.use "declare"
core.use "interface"
core.use "events"
core.use "message"
core.use "trace"
core.use "watch"
core.use "effect"
core.use "run"
core.use "build"
core.use "fluid"
core.use "heat"
core.use "keep"
core.use "soft"
core.use "rope"
core.use "plank"
core.use "lattice"
core.use "parts"
core.use "frames"
core.use "film"
core.use "render"
core.use "replay"

-- ---- values ----

digbox.vec, digbox.quat = core.vec, core.quat
digbox.path = core.path
digbox.version = core.version
for name, make in next, core.shapes do digbox[name] = make end

core.declare("digbox.quantity", { "A number in SI of a text with a unit: digbox.quantity('4 cm', 'm') is 0.04.", takes = {
  { "value", "any", "a text with a unit, or a number", type = "string|number" },
  { "unit", "text", "the unit whose dimension it must have", optional = true } }, gives = "number" })
core.declare("digbox.version", { "The version of digbox, as text.", constant = "string" })

function digbox.quantity(value, unit)
  if unit ~= nil and type(unit) ~= "string" then core.fail("digbox.quantity: unit wants a text; got %s", core.type(unit)) end
  return core.quantity(value, unit, "digbox.quantity")
end

-- ---- worlds ----

local function furnish(world)
  for _, m in ipairs(core.materials) do core.material(world, m.name, m.fields) end
  for _, p in ipairs(core.pairs_of_materials) do core.material_pair(world, p) end
  core.worlds[world] = true
  core.last_world = world
  return world
end

core.declare("digbox.world", { "Makes a world.", with = { "world" }, optional = true, gives = "world" })

-- digbox.world{gravity=, step=, accuracy=, seed=, threads=, ...} -> world
function digbox.world(fields)
  if fields == digbox then core.fail "digbox.world is called with a point: digbox.world{...}" end
  if fields ~= nil and type(fields) ~= "table" then
    core.wants_fields(fields, "digbox.world")
  end
  local copy = {}
  for k, v in next, fields or {} do copy[k] = v end
  for _, key in ipairs { "accuracy", "seed", "threads" } do
    local given = core.options[key]
    if given ~= nil then copy[key] = given end
  end
  local world = core.world(copy)
  math.randomseed(core.state(world).seed)
  return furnish(world)
end

core.declare("digbox.load", { "Opens a world that world:save kept, in the output folder or beside the script.",
  takes = { { "path", "text", "the file" } }, gives = "world" })

function digbox.load(path)
  if type(path) ~= "string" then core.fail("digbox.load wants a file name; got %s", core.type(path)) end
  local place = core.out_path(path)
  if not core.exists(place) then
    local beside, why = core.beside(path)
    if not beside then core.fail("digbox.load: %s", why) end
    place = beside
  end
  local world = furnish(core.load(place))
  core.keep.take(world)
  return world
end

core.declare("world:save", { "Keeps the whole world in a file in the output folder.", takes = { { "path", "text", "the file" } } })

function methods.save(world, path)
  if type(path) ~= "string" then core.fail("world:save wants a file name; got %s", core.type(path)) end
  core.save(world, core.out_path(path), core.keep.note(world))
end

core.declare("world:restore", { "Goes back to a snapshot of this world: bodies, joints, time. What is the script's goes on "
  .. "as it is: variables, handlers, and tasks, which cannot be put back; one that waits does so "
  .. "until the world is at the time it waited for.",
  takes = { { "snapshot", "snapshot", "what world:snapshot gave" } } })

function methods.restore(world, snapshot)
  core.forbid_in_handler(world, "world:restore")
  core.restore(world, snapshot)
  local state = core.lua_state(world)
  core.quiet(world)
  if state.handlers.moved then core.tell_moves(world) end         -- the handler may be younger than the snapshot
end

core.declare("world:close", { "Frees the world; its handles are dead from then on." })

function methods.close(world)
  core.forbid_in_handler(world, "world:close")
  core.finish_replay(world)
  core.close_films(world)
  core.close(world)
end

-- ---- materials ----

-- Tries a definition on a world made for it, so that an error appears at the script's own line.
local function try(apply, ...)
  local scratch = core.world {}
  for _, m in ipairs(core.materials) do core.material(scratch, m.name, m.fields) end
  apply(scratch, ...)
  core.close(scratch)
  for world in next, core.worlds do
    if core.is_open(world) then apply(world, ...) end
  end
end

core.declare("digbox.material", { "Adds a material, or replaces one, for all worlds of this script.", takes = {
  { "name", "text", "what bodies call it by" } }, with = { "material" },
  fields = { like = { "material", "takes what is not given from that material" } } })

-- digbox.material("cork", {density=, friction=, ..., like = "oak"})
function digbox.material(name, fields)
  if type(name) ~= "string" or type(fields) ~= "table" then
    core.fail("digbox.material wants a name and a table of fields; got %s and %s", core.type(name), core.type(fields))
  end
  local copy = {}
  for k, v in next, fields do copy[k] = v end
  try(core.material, name, copy)
  core.materials[#core.materials + 1] = { name = name, fields = copy }
end

core.declare("digbox.material_pair", { "What two materials make of each other, where the rule for pairs does not do.", with = { "pair" } })

-- digbox.material_pair{a = "oak", b = "steel", friction=, ...}
function digbox.material_pair(fields)
  if type(fields) ~= "table" then core.fail("digbox.material_pair wants a table of fields; got %s", core.type(fields)) end
  local copy = {}
  for k, v in next, fields do copy[k] = v end
  try(core.material_pair, copy)
  core.pairs_of_materials[#core.pairs_of_materials + 1] = copy
end

-- ---- arguments of the world ----

local function show_arguments(names, declared)
  local lines = {}
  for _, name in ipairs(names) do
    local d = declared[name]
    lines[#lines + 1] = ("  --%s VALUE   %s (default %s%s)"):format(name, d.help or "", tostring(d.default),
      d.unit and type(d.default) == "number" and " " .. d.unit or "")
  end
  core.print("Arguments of this world, after --, or as --set NAME=VALUE:")
  core.print(table.concat(lines, "\n"))
  core.finish_early()
end

-- Options after `--`: --name value, --name=value, --flag
local function read_command_line(list, declared)
  local given, i = {}, 1
  while i <= #list do
    local name, value = list[i]:match "^%-%-([%w_%-]+)=?(.*)$"
    if not name then core.usage("'%s' after --: expected --NAME VALUE", list[i]) end
    if name == "help" then return nil end
    local d = declared[name]
    if value == "" and not list[i]:find("=", 1, true) then
      if d and type(d.default) == "boolean" and (not list[i + 1] or list[i + 1]:match "^%-%-") then
        value = "true"
      else
        i = i + 1
        value = list[i]
        if not value then core.usage("--%s after --: the value is missing", name) end
      end
    end
    given[name] = value
    i = i + 1
  end
  return given
end

-- A bare number is in the unit of its argument; that may be a word that is no unit, and then it stays as it is.
local function in_unit(value, unit)
  if not unit then return value end
  local known, one = pcall(core.quantity, "1 " .. unit, unit, "digbox.args")
  if not known or one == 1 then return value end
  local ok, result = pcall(core.quantity, ("%.17g %s"):format(value, unit), unit, "digbox.args")
  return ok and result or value
end

local function read_argument(name, d, text)
  local default = d.default
  if type(default) == "boolean" then
    if text == "true" or text == "yes" or text == "1" then return true end
    if text == "false" or text == "no" or text == "0" then return false end
    core.usage("argument '%s' wants true or false; got '%s'", name, text)
  elseif type(default) == "string" and not d.unit then
    return text
  end
  local value = tonumber(text)
  if value and value == value then
    value = in_unit(value, d.unit)
  else
    local ok, result = pcall(core.quantity, text, d.unit or "1", "argument", name)
    if not ok then core.usage("%s", (result:gsub("^.-:%d+: ", ""):gsub("^argument%.([%w_]+)", "argument '%1'"))) end
    value = result
  end
  return value
end

core.declare("digbox.args", {
  "Declares what `digbox run --set` may vary; gives the values, in SI; numbers without a unit are in that of their argument.",
  takes = { { "declared", "table", "by name: a default, or {default, unit, help}" } }, gives = "table" })
local argument_fields = { default = { "any", "the value when nothing is said" }, unit = { "text", "its unit" },
  help = { "text", "what it is" } }

-- digbox.args{height = {default = 0.75, unit = "m", help = "drop height"}} -> {height = 0.75}
-- A value comes from `--set height=0.6` or, after `--`, `--height 0.6`; units are allowed: "60 cm". 45 of an angle in "deg" is 45 degrees.
function digbox.args(declared)
  if type(declared) ~= "table" then core.fail("digbox.args wants a table; got %s", core.type(declared)) end
  local names, values = {}, {}
  for name, d in next, declared do
    if type(name) ~= "string" then core.fail("digbox.args: arguments have names; got %s", core.type(name)) end
    if name == "" or #name > 63 or name:find "[%c=]" then
      core.fail("digbox.args: '%s' is no name of an argument", (name:sub(1, 63):gsub("%c", "?")))
    end
    if type(d) ~= "table" then d = { default = d } end
    core.check(d, "digbox.args." .. name, argument_fields)
    if d.default == nil then core.fail("digbox.args.%s: default is missing", name) end
    names[#names + 1] = name
    rawset(declared, name, d)
    values[name] = d.default
    if type(d.default) == "string" and d.unit then values[name] = core.quantity(d.default, d.unit, "digbox.args", name) end
    if type(d.default) == "number" then values[name] = in_unit(d.default, d.unit) end
  end
  table.sort(names)
  core.args_declared = true
  local given = read_command_line(core.options.args or {}, declared)
  if not given then show_arguments(names, declared) end
  for name, text in next, core.options.set or {} do given[name] = text end
  local asked = {}
  for name in next, given do asked[#asked + 1] = name end
  table.sort(asked)
  for _, name in ipairs(asked) do
    if not declared[name] then core.usage_unknown("argument", name, declared) end
    values[name] = read_argument(name, declared[name], given[name])
  end
  local known = {}
  for _, name in ipairs(names) do known[name] = true end
  return setmetatable(values, { __metatable = false, __index = function(_, name)
    core.unknown("digbox.args", "has no argument", tostring(name), known)
  end })
end

core.guard_methods()
setmetatable(digbox, {
  __index = function(_, key)
    if methods[key] then
      local shape = key == "ball" and "; as a shape digbox.sphere" or ""
      core.fail("digbox has no function '%s': it is one of a world (world:%s)%s", key, key, shape)
    end
    core.unknown("digbox", "has no function", tostring(key), digbox)
  end,
  __newindex = function(_, key) core.fail("digbox.%s cannot be assigned", tostring(key)) end,
  __metatable = false,
})
return digbox
