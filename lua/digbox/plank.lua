-- digbox/plank.lua - planks, legs, poles: beams of rigid pieces that bend in the elastic joints between them.

local core = ...
local next, type, ipairs = next, type, ipairs

local soft = core.soft
local methods = core.types.world.methods

local ends = { free = true, pinned = true, roller = true, clamped = true }
local plank_fields = core.declare("world:plank", { "A beam that bends and breaks: planks, legs, poles.", fields = {
  from = { "vec m", "middle of one end", need = true }, to = { "vec m", "middle of the other", need = true },
  up = { "dir 1", "which way its height points; default against gravity" }, width = { "real m >0", "of its section", need = true },
  height = { "real m >0", "of its section", need = true }, E = { "real Pa >0", "Young's modulus; default the material's" },
  shear_modulus = { "real Pa >0", "default from E" }, strength = { "real Pa >0", "stress at which it breaks; default the material's" },
  yield = { "real Pa >0", "stress beyond which it stays bent" }, segments = { "int 1", "pieces it is made of", default = 16, min = 2,
    max = 512 },
  breaks_at = { "real N >0", "pulled by more it breaks" }, relaxation = { "real s", "damping over stiffness", default = 1 / 1000 },
  mass = { "real kg >0", "default from density and volume" },
  from_end = { "text", "how that end is held", of = ends, default = "free" }, to_end = { "text", "how that end is held", of = ends,
    default = "free" },
  from_body = { "any", "by which body; default the world", type = "body" }, to_body = { "any", "by which body; default the world",
    type = "body" } },
  with = { "body" }, gives = "plank" })
local taken = { at = "give from and to", rotation = "give from, to and up" }

-- Everything about the beam but where it lies
local function complete(world, own, rest)
  local what = "world:plank"
  core.need(what, own, "from", "to", "width", "height")
  for _, key in ipairs { "from", "to" } do
    local how, body = own[key .. "_end"], own[key .. "_body"]
    if not ends[how] then core.unknown(what .. ":", ("unknown %s_end"):format(key), how, ends) end
    if body ~= nil and core.type(body) ~= "body" then core.fail("%s.%s_body wants a body; got %s", what, key, core.type(body)) end
    if body and how == "free" then core.fail("%s: %s_body holds no free end: give %s_end", what, key, key) end
  end
  own.length = #(own.to - own.from)
  if own.length <= 0 then core.fail "world:plank: from and to are the same point" end
  local m = core.material_of(world, rest.material or "default") or {}           -- an unknown one is refused with the first piece
  own.E, own.strength = own.E or m.stiffness, own.strength or m.strength
  own.along = (own.to - own.from):normalized()
  local up = own.up or soft.up(world)
  up = up - own.along * up:dot(own.along)
  if #up < 1e-6 then up = core.vec(1, 0, 0) - own.along * own.along.x end
  if #up < 1e-6 then up = core.vec(0, 0, 1) - own.along * own.along.z end
  own.up = up:normalized()
end

local function make_pieces(world, self, own, rest)
  local n = own.segments
  local l = own.length / n
  local turn = soft.frame(own.along, own.up)
  local volume = own.length * own.width * own.height
  for i = 1, n do
    local fields = {}
    for k, v in next, rest do fields[k] = v end
    fields.name, fields.size = ("%s %d"):format(self.name, i), { l, own.height, own.width }
    fields.at, fields.rotation = own.from + own.along * ((i - 0.5) * l), turn
    if own.mass then fields.mass = own.mass / n end
    self.bodies[i] = world:box(fields)
  end
  self.piece, self.volume = l, volume
end

-- The length of beam that joint i of 0..n stands for, in pieces: the weights of Simpson's rule (of the trapezoidal rule when n is
-- odd). A deflection is the integral of two bending moments over E I; where both are straight between every second joint it is then exact,
-- and the moment at a joint is that of the beam in any case.
local function weight(i, n)
  local end_ = i == 0 or i == n
  if n % 2 == 1 then return end_ and 1 / 2 or 1 end
  return end_ and 1 / 3 or i % 2 == 1 and 4 / 3 or 2 / 3
end

local function join(world, own, a, b, at, length, name)
  return world:beam { a = a, b = b, at = at, axis = own.along, up = own.up, length = length, width = own.width, height = own.height,
    modulus = own.E, shear_modulus = own.shear_modulus, strength = own.strength, yield = own.yield, breaks_at = own.breaks_at,
    relaxation = own.relaxation, name = name }
end

-- How an end is held: by the world, or by a body
local function hold(world, self, own, piece, at, how, by, name)
  local side = own.along:cross(own.up)
  local function add(type_of, fields)
    fields.a, fields.b, fields.at, fields.name = piece, by, at, name
    self.holds[#self.holds + 1] = world[type_of](world, fields)
  end
  if how == "clamped" then
    local j = join(world, own, piece, by, at, self.piece * weight(0, own.segments), name)
    self.joints[#self.joints + 1], self.holds[#self.holds + 1] = j, j
  elseif how == "pinned" then
    add("hinge", { axis = side })
  elseif how == "roller" then
    add("guide", { axis = own.along, keeps = "line" })
    add("guide", { axis = side, keeps = "direction" })
  end
end

local function make(world, self, own, rest)
  make_pieces(world, self, own, rest)
  hold(world, self, own, self.bodies[1], own.from, own.from_end, own.from_body, self.name .. " from")
  for i = 2, own.segments do
    local at = own.from + own.along * ((i - 1) * self.piece)
    self.joints[#self.joints + 1] = join(world, own, self.bodies[i], self.bodies[i - 1], at, self.piece * weight(i - 1, own.segments),
      ("%s joint %d"):format(self.name, i - 1))
  end
  hold(world, self, own, self.bodies[own.segments], own.to, own.to_end, own.to_body, self.name .. " to")
end

-- The piece at s metres from the start, and the point of its centre line there, in its own axes
local function piece_at(self, s, what)
  s = core.quantity(s, "m", what)
  if s < -1e-9 * self.length or s > (1 + 1e-9) * self.length then core.fail("%s = %g m, must be 0 to %g m", what, s, self.length) end
  local i = math.max(1, math.min(#self.bodies, math.floor(s / self.piece - 1e-9) + 1))
  return self.bodies[i], core.vec(s - (i - 0.5) * self.piece, 0, 0)
end

local function point(self, s, what)
  local body, at = piece_at(self, s, what)
  return body.position + body.rotation:rotate(at)
end

-- What is made anew of a plank: its pieces are all its bodies, and a place on it is a distance or a point.
local function equip(self)
  self.pieces = self.bodies
  self.where = function(_, at)
    if type(at) == "number" or type(at) == "string" then return point(self, at, "plank:saw.at") end
    return core.check({ at = at }, "plank:saw", soft.saw_fields).at
  end
end

local plank_methods = { sig = soft.sig, saw = soft.saw }
local new_plank = soft.class("plank", "A beam that bends and breaks.", plank_methods,
  { stress = soft.stress, mass = soft.mass, position = soft.position, broken = soft.broken },
  { name = true, bodies = true, pieces = true, joints = true, holds = true, length = true, breaks_at = true },
  core.join_fields(soft.properties, { stress = { "number", "largest load over limit; 1 breaks" }, pieces = { "body[]", "from end to end" },
    holds = { "joint[]", "what holds its ends" }, length = { "number", "between its ends", unit = "m" },
    breaks_at = { "number|nil", "as given", unit = "N" } }),
  { holds = "joint list", length = "number", from = "vector", along = "vector", piece = "number", volume = "number" }, equip)
core.declare("plank:point", { "Where the centre line is now, so far from its start.", takes = { { "s", "real m", "from its start" } },
  gives = "vector" })
core.declare("plank:push", { "Pushes a point of the centre line, for the next step.", fields = {
  at = { "real m", "from its start", need = true }, force = { "vec N", "the force", need = true } }, gives = "plank" })
core.declare("plank:saw", { "Saws into the nearest joint; through, it is gone.", fields = soft.saw_along, gives = "plank" })

-- world:plank{from=, to=, width=, height=, material= | E=, strength=, density=, segments = 16, breaks_at=, yield=, relaxation=,
-- from_end = "free" | "pinned" | "roller" | "clamped", from_body=, to_end=, to_body=, up=} -> plank
function methods.plank(world, fields)
  local own, rest = soft.split("world:plank", fields, plank_fields, taken)
  complete(world, own, rest)
  local self = { kind = "plank", name = rest.name or "plank", world = world, bodies = {}, joints = {}, holds = {}, length = own.length,
    thickness = own.height, from = own.from, along = own.along, breaks_at = own.breaks_at }
  soft.build(self, function() make(world, self, own, rest) end)
  self.bodies, self.joints, self.holds = core.list(self.bodies), core.list(self.joints), core.list(self.holds)
  equip(self)
  return new_plank(self)
end

-- p:point(s) -> where the centre line is now, s metres from `from`
function plank_methods.point(p, s) return point(p[1], s, "plank:point") end

-- p:push{at = s, force=}: on the centre line, for the next step
function plank_methods.push(p, fields)
  local f = core.check(fields, "plank:push")
  core.need("plank:push", f, "at", "force")
  local body, at = piece_at(p[1], f.at, "plank:push.at")
  body:push { force = f.force, at = body.position + body.rotation:rotate(at) }
  return p
end

return true
