-- digbox/build.lua - ready-made bodies out of the engine's shapes: floor, room, rod, bucket, meshes from files.

local core = ...
local next, type = next, type

local methods = core.types.world.methods

-- Splits a table of fields: those named in spec, checked; the others, which must be fields of a body, but none of those that the thing
-- gives its bodies itself. taken: field -> what to give instead, or nil
function core.split(what, fields, spec, taken)
  if type(fields) ~= "table" then core.wants_fields(fields, what) end
  local own, rest = {}, {}
  local strange
  for key, value in next, fields do
    if spec[key] then
      own[key] = value
    elseif taken and taken[key] then
      core.fail("%s: %s is no field of it: %s", what, key, taken[key])
    else
      rest[key] = value
      if not core.body_fields[key] and (not strange or tostring(key) < tostring(strange)) then strange = key end
    end
  end
  if strange ~= nil and type(strange) ~= "string" then core.check({ [strange] = true }, what, spec) end         -- it says so
  if strange ~= nil then core.unknown(what .. ":", "unknown field", tostring(strange), spec, core.body_fields) end
  return core.check(own, what, spec), rest
end

function core.need(what, own, ...)
  for _, key in ipairs { ... } do
    if own[key] == nil then core.fail("%s: %s is missing", what, key) end
  end
end

-- ---- landscapes ----

local GRID_LIMIT = 4096
local grid_fields = { size = { "vec m", "extents along x and z", need = true } }

-- The fields as the engine's shape takes them: size = {x, z} with a y between, height = function(x, z) as a list of rows of heights.
local function landscape(what, fields)
  if type(fields) ~= "table" then return fields end
  local own, height = {}, rawget(fields, "height")
  for key, value in next, fields do own[key] = value end
  if type(own.size) == "table" and rawlen(own.size) == 2 then own.size = { own.size[1], 0, own.size[2] } end
  if height == nil then return own end
  if type(height) ~= "function" then core.fail("%s.height wants a function of x and z; got %s", what, core.type(height)) end
  if own.heights ~= nil then core.fail("%s: give either height or heights", what) end
  core.need(what, own, "columns", "rows", "size")
  for _, key in ipairs { "columns", "rows" } do
    local n = core.whole(own[key])
    if not n or n < 2 or n > GRID_LIMIT then
      core.fail("%s: %s = %s, must be an integer of 2 to %d", what, key, tostring(own[key]), GRID_LIMIT)
    end
    own[key] = n
  end
  local size = core.check({ size = own.size }, what, grid_fields).size
  own.height, own.heights = nil, {}
  for j = 1, own.rows do
    local row, z = {}, size.z * ((j - 1) / (own.rows - 1) - 0.5)
    for i = 1, own.columns do
      local x = size.x * ((i - 1) / (own.columns - 1) - 0.5)
      row[i] = height(x, z)
      if type(row[i]) ~= "number" then core.fail("%s.height(%g, %g) gives %s, must be a number", what, x, z, core.type(row[i])) end
    end
    own.heights[j] = row
  end
  return own
end

local heightfield, heightfield_shape = methods.heightfield, core.shapes.heightfield

-- world:heightfield{size = {x, z}, heights = {{...}, ...}} or {size =, columns =, rows =, height = function(x, z)} -> body
function methods.heightfield(world, fields)
  return heightfield(world, landscape("world:heightfield", fields))
end

-- The same as a shape.
function core.shapes.heightfield(fields)
  return heightfield_shape(landscape("digbox.heightfield", fields))
end

-- ---- floor and room ----

local plane = core.constructor("plane", "world:floor")
core.declare("world:floor", { "The fixed plane y = 0.", with = { "body" }, optional = true, gives = "body" })

-- world:floor{...}: the fixed plane y = 0
function methods.floor(world, fields)
  local _, rest = core.split("world:floor", fields or {}, {})
  rest.normal, rest.offset = { 0, 1, 0 }, 0
  if rest.name == nil then rest.name = "floor" end
  return plane(world, rest)
end

local Room = {}
local walls = { ["+x"] = true, ["-x"] = true, ["+y"] = true, ["-y"] = true, ["+z"] = true, ["-z"] = true }
local room_properties = { world = { "world", "its world" }, name = { "string", "for messages; room if it was given none" },
  mode = { "string", "fixed" }, dig = { "nil", "it is in none" }, valid = { "boolean", "its world is open and has it" } }
local room_fields = { name = { "text", "for messages" } }
local room_has = { open = true, close = true }
for name in next, room_properties do room_has[name] = true end
local make_room, open_room, is_room = core.opaque(Room)
core.is_room = is_room
Room.__index = function(room, key)
  if not room_has[key] then core.unknown("room", "has no field or method", tostring(key), room_has) end
  local own = open_room(room)
  if key == "valid" then return core.is_open(own.world) and core.has_room(own.world) end
  return Room[key] or own[key]
end
Room.__newindex = function(_, key) core.fail("room.%s cannot be assigned", tostring(key)) end
Room.__metatable = false
Room.__name = "room"
Room.__tostring = function(room) return ("room '%s'"):format(open_room(room).name) end

core.declare_type("room", "Six walls without a body of their own; a wall is named '+x', '-x', '+y', '-y', '+z' or '-z'.",
  Room, room_properties)
core.declare("room:open", { "That wall lets bodies out.", takes = { { "wall", "text", "which wall", of = walls } }, gives = "room" })
core.declare("room:close", { "That wall holds again.", takes = { { "wall", "text", "which wall", of = walls } }, gives = "room" })
core.declare("world:room", { "Six walls without a body of their own. In events they are `other`.", fields = room_fields, with = { "room" },
  gives = "room" })

local function check_wall(what, wall)
  if type(wall) ~= "string" or not walls[wall] then core.unknown(what .. ":", "unknown wall", tostring(wall), walls) end
  return wall
end

-- room:open "+x": that wall lets bodies out
function Room.open(room, wall)
  core.room_open(open_room(room).world, check_wall("room:open", wall), true)
  return room
end

function Room.close(room, wall)
  core.room_open(open_room(room).world, check_wall("room:close", wall), false)
  return room
end

-- The room of a world: one, as its walls are. That of a world from a file has no other maker than who asks.
function core.room_of(world)
  local state = core.lua_state(world)
  state.room = state.room or make_room { world = world, name = "room", mode = "fixed" }
  return state.room
end

-- world:room{size=, at=, material=, friction=, restitution=, name=} -> room: six walls without a body
function methods.room(world, fields)
  if type(fields) ~= "table" then core.wants_fields(fields, "world:room") end
  if rawget(fields, "size") == nil and rawget(fields, 1) == nil then core.fail "world:room: size is missing (from wall to wall)" end
  local name = core.check({ name = rawget(fields, "name") }, "world:room", room_fields).name
  core.room(world, fields)
  local room = core.room_of(world)
  open_room(room).name = name or "room"
  return room
end

-- ---- rod ----

local cylinder = core.constructor("cylinder", "world:rod")
local rod_fields = core.declare("world:rod", { "A round bar.", fields = {
  length = { "real m >0", "its length" }, radius = { "real m >0", "its radius", need = true }, from = { "vec m", "where it begins" },
  to = { "vec m", "where it ends" }, along = { "dir 1", "which way it goes from `from`" } }, with = { "body" }, gives = "body" })

-- world:rod{length=, radius=, from=, along=} or {from=, to=, radius=} or {at=, rotation=, length=, radius=}: a round bar
function methods.rod(world, fields)
  local own, rest = core.split("world:rod", fields, rod_fields)
  if own.to then
    core.need("world:rod", own, "from")
    if own.along or own.length then core.fail "world:rod: to already says along and length" end
    own.along, own.length = own.to - own.from, #(own.to - own.from)
    if own.length <= 0 then core.fail "world:rod: from and to are the same point" end
    own.along = own.along:normalized()
  end
  core.need("world:rod", own, "length", "radius")
  if own.from and rest.at ~= nil then core.fail "world:rod: from and at both say where" end
  if own.along and rest.rotation ~= nil then core.fail "world:rod: along and rotation both say which way" end
  if own.along then rest.rotation = core.quat { from = { 0, 1, 0 }, to = own.along } end
  if own.from then
    local along = own.along or core.vec(0, 1, 0)
    if rest.rotation ~= nil and not own.along then along = core.quat(rest.rotation):rotate { 0, 1, 0 } end
    rest.at = own.from + along * (own.length / 2)
  end
  rest.radius, rest.height = own.radius, own.length
  return cylinder(world, rest)
end

-- ---- bucket ----

local compound = core.constructor("body", "world:bucket")
local bucket_fields = core.declare("world:bucket", { "Open at the top; `at` is the middle of its underside.", fields = {
  height = { "real m >0", "outer height", need = true }, top_radius = { "real m >0", "inner radius at the top", need = true },
  bottom_radius = { "real m >0", "inner radius at the bottom; default as at the top" },
  wall = { "real m >0", "thickness; default 5 % of the smaller of height and bottom_radius" },
  segments = { "int 1", "boxes around the wall", default = 24, min = 3, max = 256 },
  parts = { "any", "further shapes that belong to it, such as a rim", type = "shape[]" } }, with = { "body" }, gives = "body" })

-- Boxes around a tapered wall. Their inner faces touch the cone from outside at mid-width, so the hollow is at least the one asked for.
local function bucket_wall(own, n)
  local parts = {}
  local slope = (own.top_radius - own.bottom_radius) / own.height
  local tilt = math.atan(slope)
  -- A wall that leans outwards would stick out below the floor by its outer edge: start it that much higher.
  local skip = math.max(0, own.wall * math.tan(tilt))
  local slant = own.height / math.cos(tilt) - skip
  local width = 2 * (math.max(own.top_radius, own.bottom_radius) + own.wall) * math.tan(math.pi / n)
  local middle = (own.top_radius + own.bottom_radius) / 2 + own.wall / 2 * math.cos(tilt)
  for i = 0, n - 1 do
    local turn = core.quat { axis = { 0, 1, 0 }, angle = 2 * math.pi * i / n }
    -- Leaning outwards (towards +x before the turn) is a negative rotation about z.
    local lean = core.quat { axis = { 0, 0, 1 }, angle = -tilt }
    local at = core.vec(middle + skip / 2 * math.sin(tilt), own.height / 2 - own.wall / 2 * math.sin(tilt) + skip / 2 * math.cos(tilt), 0)
    parts[#parts + 1] = core.shapes.box { size = { own.wall, slant, width }, at = turn:rotate(at), rotation = turn * lean }
  end
  return parts
end

-- world:bucket{height=, top_radius=, bottom_radius=, wall=, parts=, at=, ...}: open at the top; `at` is the middle of its underside;
-- parts: a list of further shapes that belong to it, such as a rim or pins for a handle
function methods.bucket(world, fields)
  local own, rest = core.split("world:bucket", fields, bucket_fields)
  core.need("world:bucket", own, "height", "top_radius")
  own.bottom_radius = own.bottom_radius or own.top_radius
  own.wall = own.wall or math.min(own.height, own.bottom_radius) * 0.05
  local n = own.segments
  if own.wall * 2 > own.height then core.fail("world:bucket: wall = %g m, must be at most half the height", own.wall) end
  rest.parts = bucket_wall(own, n)
  rest.parts[n + 1] = core.shapes.cylinder { radius = own.bottom_radius, height = own.wall, at = { 0, own.wall / 2, 0 } }
  if own.parts ~= nil and type(own.parts) ~= "table" then
    core.fail("world:bucket.parts wants a list of shapes; got %s", core.type(own.parts))
  end
  for _, part in ipairs(own.parts or {}) do rest.parts[#rest.parts + 1] = part end
  return compound(world, rest)
end

-- ---- meshes from files ----

-- Wavefront .obj: `v x y z` and `f a b c ...` (a/b/c: the first number counts; negative: from the end); polygons become fans.
local function read_obj(text, path)
  local vertices, triangles, line_number = {}, {}, 0
  for line in text:gmatch "[^\n]*" do
    line_number = line_number + 1
    local word, rest = line:match "^%s*(%a+)%s+(.-)%s*$"
    if word == "v" then
      local x, y, z = rest:match "^(%S+)%s+(%S+)%s+(%S+)"
      x, y, z = tonumber(x), tonumber(y), tonumber(z)
      if not (x and y and z) then core.fail("%s:%d: a vertex wants three numbers", path, line_number) end
      vertices[#vertices + 1] = { x, y, z }
    elseif word == "f" then
      local corners = {}
      for corner in rest:gmatch "%S+" do
        local index = math.tointeger(tonumber(corner:match "^%-?%d+"))
        if not index then core.fail("%s:%d: '%s' is no vertex number", path, line_number, corner) end
        corners[#corners + 1] = index < 0 and #vertices + 1 + index or index
      end
      if #corners < 3 then core.fail("%s:%d: a face wants three corners", path, line_number) end
      for i = 2, #corners - 1 do
        triangles[#triangles + 1] = { corners[1], corners[i], corners[i + 1] }
      end
    end
  end
  return vertices, triangles
end

local engine_mesh = methods.mesh

core.declare("world:mesh", { "A surface of triangles; static, or dynamic when it is closed. One that moves meets planes such as the floor, "
  .. "balls, boxes and other convex shapes; it passes through other meshes and height fields.", fields = {
  file = { "text", "a Wavefront .obj beside the script, instead of vertices and triangles" } }, with = { "shape mesh", "body" },
  gives = "body" })

-- Nothing would be seen of it but that one passes through the other.
local function tell_what_meets(world, body)
  local state = core.lua_state(world)
  state.surfaces, state.moving_mesh = (state.surfaces or 0) + 1, state.moving_mesh or body.kind == "dynamic"
  if state.moving_mesh and state.surfaces > 1 and not state.told_of_meshes and not core.options.quiet then
    state.told_of_meshes = true
    core.tell(("digbox: %sa mesh that moves passes through other meshes and height fields; a hull, or a body of parts, does not\n")
      :format(core.where()))
  end
  return body
end

local engine_heightfield = methods.heightfield
function methods.heightfield(world, fields) return tell_what_meets(world, engine_heightfield(world, fields)) end

-- world:mesh{file = "beside/the/script.obj"} or {vertices=, triangles=}
function methods.mesh(world, fields)
  if type(fields) ~= "table" or rawget(fields, "file") == nil then return tell_what_meets(world, engine_mesh(world, fields)) end
  if type(fields.file) ~= "string" then core.fail("world:mesh.file wants a file name; got %s", core.type(fields.file)) end
  local path, why = core.beside(fields.file)
  local text
  if path then text, why = core.read(path) end
  if not text then core.fail("world:mesh.file: %s", why) end
  local copy = {}
  for k, v in next, fields do copy[k] = v end
  copy.file = nil
  copy.vertices, copy.triangles = read_obj(text, fields.file)
  return tell_what_meets(world, engine_mesh(world, copy))
end

return true
