-- digbox/rope.lua - world:rope: without segments a joint of the engine, with segments a chain of rods that has mass.

local core = ...
local next, type, ipairs, math = next, type, ipairs, math

local soft = core.soft
local methods = core.types.world.methods
local engine_rope = methods.rope

local rope_fields = {
  a = { "any", "the body it begins at; with segments, none: it begins at a point of the world", type = "body" },
  b = { "any", "the body it ends at; none: a point of the world", type = "body" },
  at = { "vec m", "where it begins; default the place of a. Without b and to: where it ends" },
  to = { "vec m", "where it ends; default the place of b" },
  at_a = { "vec m", "where it begins, as at" }, at_b = { "vec m", "where it ends, as to" },
  length = { "real m >0", "its length; default the distance of its ends" },
  segments = { "int 1", "with segments it is a chain of so many rods, or one more: it has mass", min = 1, max = 10000 },
  mass = { "real kg >0", "of the whole rope, with segments; default from the density of its rods" },
  radius = { "real m >0", "of its rods; default a tenth of their length" }, breaks_at = { "real N >0", "breaks when a joint bears more" } }
local taken = { fixed = "its ends are held by a and b", kinematic = "its ends are held by a and b", rotation = "its ends say which way" }
local shown = core.join_fields(rope_fields)
shown.breaks_at, shown.at_a, shown.at_b = nil, nil, nil              -- as of the joint
core.declare("world:rope", { "Ends never farther apart than its length: a joint, or with segments a chain of rods that has mass.",
  fields = shown, with = { "joint rope", "body" }, gives = "joint|rope" })

-- Where a rope bends that is longer than the distance of its ends: downwards, or aside where its ends lie one above the other.
local function across(span, down)
  if #span == 0 then return down end
  local along = span / #span
  local best
  for _, way in ipairs { down, core.vec(1, 0, 0), core.vec(0, 0, 1) } do
    best = way - along * way:dot(along)
    if #best > 1e-3 then break end
  end
  return best:normalized()
end

-- Corners of a rope of the given length hung between two points: straight, or a V when it is longer than their distance.
local function corners_of(from, to, length, down, n)
  local span = to - from
  local sag = math.sqrt(math.max(0, (length / 2) ^ 2 - (#span / 2) ^ 2))
  local apex = (from + to) / 2 + across(span, down) * sag
  local corners = {}
  for i = 0, n do
    local s = i / n
    corners[i] = s <= 0.5 and from + (apex - from) * (2 * s) or apex + (to - apex) * (2 * s - 1)
  end
  return corners
end

local function check_body(body, field)
  if body ~= nil and core.type(body) ~= "body" then core.fail("world:rope.%s wants a body; got %s", field, core.type(body)) end
end

-- Where it begins and ends
local function ends_of(own)
  check_body(own.a, "a")
  check_body(own.b, "b")
  local from, to = own.at_a or own.at, own.at_b or own.to
  if own.a and not own.b and not to then from, to = own.at_a, own.at end
  from, to = from or own.a and own.a.position, to or own.b and own.b.position
  if not from then core.fail "world:rope: a rope of segments wants a, or at: the point of the world where it begins" end
  local last = own.a and "at" or "to"
  if not to then core.fail("world:rope: a rope of segments wants b, or %s: the point of the world where it ends", last) end
  return from, to
end

-- A rod that begins within a or b, which it is tied to farther along, touches nothing: it would be thrown out.
local function starts_inside(world, rod, a, b)
  local along, length = rod.to - rod.from, #(rod.to - rod.from)
  local shape = core.shapes.cylinder { radius = rod.radius, height = length }
  local inside = world:overlap { shape = shape, at = (rod.from + rod.to) / 2,
    rotation = core.quat { from = { 0, 1, 0 }, to = along / length } }
  for _, body in ipairs(inside) do
    if body == a or body == b then return true end
  end
  return false
end

local function make(world, self, own, rest, from, to)
  local g = world.gravity
  local n = own.segments + own.segments % 2
  local corners = corners_of(from, to, own.length, #g > 0 and g:normalized() or core.vec(0, -1, 0), n)
  local function tie(a, b, at, i)
    self.joints[i] = world:ball_joint { a = a or b, b = a and b, at = at, breaks_at = own.breaks_at }
  end
  local before = own.a
  for i = 1, n do
    local rod = { from = corners[i - 1], to = corners[i], radius = own.radius or own.length / n / 10, mass = own.mass and own.mass / n }
    if starts_inside(world, rod, i > 1 and own.a, i < n and own.b) then rod.collides = false end
    for k, v in pairs(rest) do rod[k] = v end
    rod.name = ("%s %d"):format(self.name, i)
    self.bodies[i] = world:rod(rod)
    tie(before, self.bodies[i], corners[i - 1], i)
    before = self.bodies[i]
  end
  tie(before, own.b, to, n + 1)
end

-- ---- the handle ----

local getters = { stress = soft.stress, mass = soft.mass, position = soft.position, broken = soft.broken }

function getters.valid(self)
  return soft.broken(self) == 0
end

-- N, by which it pulls at a, or at the world where it begins there; nothing once it is torn there
function getters.force(self)
  local first = self.joints[1]
  if not first.valid then return core.vec(0, 0, 0) end
  return first.b and first.force or -first.force
end

local function end_of(self, i, j)
  return j.valid and j.at or self.bodies[i].valid and self.bodies[i].position or nil
end

function getters.distance(self)
  local from, to = end_of(self, 1, self.joints[1]), end_of(self, #self.bodies, self.joints[#self.joints])
  return from and to and #(to - from)
end

function getters.error(self) return soft.largest(self, "error") end

local function equip(self) self.links = self.bodies end

local rope_methods = { sig = soft.sig }
local new_rope = soft.class("rope", "A rope of rods.", rope_methods, getters,
  { name = true, bodies = true, links = true, joints = true, length = true, breaks_at = true },
  core.join_fields(soft.properties, { links = { "body[]", "its rods, from a on" }, length = { "number", "as given", unit = "m" },
    stress = { "number", "largest load over limit of a joint; 1 breaks" }, valid = { "boolean", "no joint of it is broken" },
    force = { "vector", "by which it pulls at a", unit = "N" }, distance = { "number|nil", "of its ends", unit = "m" },
    error = { "number", "how far its joints are from where they should be", unit = "m" },
    breaks_at = { "number|nil", "as given", unit = "N" } }), { length = "number" }, equip)
core.declare("rope:remove", { "Takes it away." })

function rope_methods.remove(rope)
  for _, body in ipairs(rope[1].bodies) do
    if body.valid then body:remove() end
  end
end

-- The joint knows its ends by at_a and at_b; its own at is where it ends in the world.
local function plain(world, fields)
  if type(fields) ~= "table" or (rawget(fields, "to") == nil and rawget(fields, "b") == nil) then return engine_rope(world, fields) end
  local own = {}
  for k, v in next, fields do own[k] = v end
  if own.to ~= nil and own.at_b ~= nil then core.fail "world:rope: give either to or at_b" end
  local ends = core.check({ at = own.at, to = own.to }, "world:rope", rope_fields)         -- what is wrong has the name it was given
  own.at, own.to, own.at_a, own.at_b = nil, nil, own.at_a or ends.at, own.at_b or ends.to
  return engine_rope(world, own)
end

-- world:rope{a=, b= or to=, length=}: ends never farther apart than length, without mass.
-- world:rope{a= or at=, b= or to=, length=, segments=, radius=, mass=} -> rope: a chain of rods
function methods.rope(world, fields)
  if type(fields) == "table" and rawget(fields, "b") == world then         -- as if there were none
    local own = {}
    for k, v in next, fields do own[k] = k ~= "b" and v or nil end
    fields = own
  end
  if type(fields) ~= "table" then return plain(world, fields) end
  if rawget(fields, "segments") == nil then
    for _, name in ipairs { "mass", "radius" } do
      if rawget(fields, name) ~= nil then core.fail("world:rope: %s is that of a rope of segments: give segments, too", name) end
    end
    return plain(world, fields)
  end
  local own, rest = soft.split("world:rope", fields, rope_fields, taken)
  local from, to = ends_of(own)
  local apart = #(to - from)
  own.length = own.length or apart
  if own.length <= 0 then core.fail "world:rope: its ends are the same point: give length" end
  if own.length < apart * (1 - 1e-9) then
    core.fail("world:rope: length = %g m, must be at least the distance of its ends (%g m)", own.length, apart)
  end
  local self = { kind = "rope", name = rest.name or "rope", world = world, bodies = {}, joints = {}, length = own.length,
    thickness = 2 * (own.radius or own.length / own.segments / 10), breaks_at = own.breaks_at }
  soft.build(self, function() make(world, self, own, rest, from, to) end)
  self.bodies, self.joints = core.list(self.bodies), core.list(self.joints)
  equip(self)
  return new_rope(self)
end

return true
