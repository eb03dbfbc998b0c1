-- digbox/keep.lua - trusses, planks, cloth and lattices in a world's file: which bodies and joints each is made of, so that
-- digbox.load can make their handles again. Bodies and joints themselves are the engine's.
--
-- What a class keeps is a table field -> kind (soft.class): "number", "whole", "text", "vector", each with a "?" when it need not be there;
-- "body list", "joint list"; "body map", "joint map", by text. In the file, bodies and joints stand as places in world:bodies() and
-- world:joints(), whose order a file keeps; 0 is one that is gone.

local core = ...
local ipairs, pairs, pcall = ipairs, pairs, pcall

local methods = core.types.world.methods
local classes = {}                  -- kind of thing -> {fields =, sorted names =, make =}
local keep = {}
core.keep = keep

-- A class of things that files keep: fields as above; make(self) -> handle
function keep.class(kind, fields, make)
  local names = {}
  for name in pairs(fields) do names[#names + 1] = name end
  table.sort(names)
  classes[kind] = { fields = fields, names = names, make = make }
end

local function things_of(world)
  local state = core.lua_state(world)
  state.things = state.things or {}
  return state.things
end

-- Those of which nothing is left stay in the list, since world:restore can bring their bodies back.
function keep.add(world, thing)
  local list = things_of(world)
  list[#list + 1] = thing
end

local function stands(thing)
  for _, body in ipairs(thing[1].bodies) do
    if body.valid then return true end
  end
  return false
end

-- ---- writing ----

local write = {}
function write.number(out, v) out[#out + 1] = ("<d"):pack(v) end
function write.whole(out, v) out[#out + 1] = ("<i8"):pack(v) end
function write.text(out, v) out[#out + 1] = ("<s4"):pack(v) end
function write.vector(out, v) out[#out + 1] = ("<ddd"):pack(v.x, v.y, v.z) end

local function write_list(out, list, place)
  out[#out + 1] = ("<I4"):pack(#list)
  for _, item in ipairs(list) do out[#out + 1] = ("<I4"):pack(place[item] or 0) end
end

local function write_map(out, map, place)
  local names = {}
  for name in pairs(map) do names[#names + 1] = name end
  table.sort(names)
  out[#out + 1] = ("<I4"):pack(#names)
  for _, name in ipairs(names) do out[#out + 1] = ("<s4I4"):pack(name, place[map[name]] or 0) end
end

local function write_thing(out, self, places)
  local class = classes[self.kind]
  write.text(out, self.kind)
  for _, name in ipairs(class.names) do
    local kind, v = class.fields[name], self[name]
    local of, what = kind:match "^(%a+) (%a+)$"
    if of then
      (what == "list" and write_list or write_map)(out, v, places[of])
    elseif kind:find "%?$" then
      out[#out + 1] = ("B"):pack(v == nil and 0 or 1)
      if v ~= nil then write[kind:sub(1, -2)](out, v) end
    else
      write[kind](out, v)
    end
  end
end

local function places_of(list)
  local place = {}
  for i, item in ipairs(list) do place[item] = i end
  return place
end

-- The note that goes into the world's file; nil when there is nothing to note
function keep.note(world)
  local standing = {}
  for _, thing in ipairs(things_of(world)) do
    if stands(thing) then standing[#standing + 1] = thing[1] end
  end
  if #standing == 0 then return nil end
  local out, places = {}, { body = places_of(world:bodies()), joint = places_of(world:joints()) }
  out[1] = ("<I4"):pack(#standing)
  for _, self in ipairs(standing) do write_thing(out, self, places) end
  return table.concat(out)
end

-- ---- reading ----

local read = {}
function read.number(note, at) return ("<d"):unpack(note, at) end
function read.whole(note, at) return ("<i8"):unpack(note, at) end
function read.text(note, at) return ("<s4"):unpack(note, at) end
function read.vector(note, at)
  local x, y, z, next_at = ("<ddd"):unpack(note, at)
  return core.vec(x, y, z), next_at
end

local function item_of(world, things, place, of)
  if place > #things then error("there is no such " .. of) end
  return things[place] or core.gone(world, of)
end

local function read_list(world, note, at, things, of)
  local list, count, next_at = {}, ("<I4"):unpack(note, at)
  for i = 1, count do
    list[i] = item_of(world, things, (("<I4"):unpack(note, next_at)), of)
    next_at = next_at + 4
  end
  return core.list(list), next_at
end

local function read_map(world, note, at, things, of)
  local map, count, next_at = {}, ("<I4"):unpack(note, at)
  for _ = 1, count do
    local name, place, after = ("<s4I4"):unpack(note, next_at)
    map[name], next_at = item_of(world, things, place, of), after
  end
  return map, next_at
end

local function read_thing(world, note, at, there)
  local self = { world = world }
  self.kind, at = read.text(note, at)
  local class = classes[self.kind] or error "it is of no known kind"
  for _, name in ipairs(class.names) do
    local kind, given = class.fields[name], 1
    local of, what = kind:match "^(%a+) (%a+)$"
    if of then
      self[name], at = (what == "list" and read_list or read_map)(world, note, at, there[of], of)
    else
      if kind:find "%?$" then given, at = ("B"):unpack(note, at) end
      if given == 1 then self[name], at = read[kind:match "%a+"](note, at) end
    end
  end
  return self, at
end

-- Makes the handles of a world that was loaded; all or none of them.
function keep.take(world)
  local note = core.noted(world)
  if not note then return end
  local fine, why = pcall(function()
    local there, list = { body = world:bodies(), joint = world:joints() }, {}
    local count, at = ("<I4"):unpack(note)
    for i = 1, count do list[i], at = read_thing(world, note, at, there) end
    if at ~= #note + 1 then error "something follows them" end
    for _, self in ipairs(list) do classes[self.kind].make(self) end
  end)
  if fine then return end
  why = why:find "too short" and "they end too soon" or why:gsub("^.-:%d+: ", "")
  core.fail("digbox.load: its trusses, planks, cloth and lattices cannot be read: %s", why)
end

-- ---- asking ----

local find = methods.find

-- world:find "bridge" -> the body or joint of that name, or else the truss, plank, cloth or lattice
function methods.find(world, name)
  local found = find(world, name)
  if found then return found end
  for _, thing in ipairs(things_of(world)) do
    if thing[1].name == name and stands(thing) then return thing end
  end
  return nil
end

return true
