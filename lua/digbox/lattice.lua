-- digbox/lattice.lua - cloth and lattices: particles in rows, held to their neighbours by struts.

local core = ...
local next, ipairs = next, ipairs

local soft = core.soft
local methods = core.types.world.methods

local common_fields = core.join_fields(soft.strut_fields, {
  shear = { "real 1", "stiffness of its diagonals, as a share" }, radius = { "real m >0",
    "of its particles; default a quarter of their distance" },
  mass = { "real kg >0", "of all of it", need = true } })
common_fields.stiffness = { "real N >0", "E A of a thread: force for doubling its length", need = true }
local taken = { fixed = "give a cloth pins, or fix bodies", rotation = "its own fields say how it lies", density = "give mass",
  sheet = "a cloth has a number of its own" }
local RELAXES = 0.02               -- s  of which nothing is said

-- N by which what is fixed holds it: the pull of its struts, and the weight of the pinned particles themselves
local function support(self)
  local sum, g = core.vec(0, 0, 0), self.world.gravity
  for _, b in ipairs(self.bodies) do
    if b.valid and b.fixed then sum = sum - g * (b.mass * b.gravity_scale) end
  end
  for _, j in ipairs(self.joints) do
    if j.valid and j.a.fixed ~= j.b.fixed then sum = sum + (j.b.fixed and j.force or -j.force) end
  end
  return sum
end

-- The longest of its struts over its length at rest, less 1
local function stretch(self)
  local most = 0
  for _, j in ipairs(self.joints) do
    if j.valid then most = math.max(most, j.distance / j.length - 1) end
  end
  return most
end

local cloth_methods, lattice_methods = { sig = soft.sig, saw = soft.saw }, { sig = soft.sig, saw = soft.saw }
local getters = { stress = soft.stress, mass = soft.mass, position = soft.position, broken = soft.broken, support = support,
  stretch = stretch }
local readable = { name = true, breaks_at = true, bodies = true, joints = true, columns = true, rows = true, layers = true }
local properties = core.join_fields(soft.properties, {
  stress = { "number", "largest load over limit; 1 breaks" },
  support = { "vector", "by which what is fixed holds it, the weight of pinned particles included", unit = "N" },
  stretch = { "number", "the longest strut over its length at rest, less 1" }, breaks_at = { "number|nil", "as given", unit = "N" },
  columns = { "integer", "particles one way" }, rows = { "integer", "particles the other way" },
  layers = { "integer|nil", "particles the third way" } })
local kept = { node = "body map", columns = "whole", rows = "whole", layers = "whole?", radius = "number", sheet = "whole?" }
local new_cloth = soft.class("cloth", "Particles in rows, held to their neighbours.", cloth_methods, getters, readable, properties,
  kept)
local new_lattice = soft.class("lattice", "Particles in rows and layers: a body that springs back.", lattice_methods, getters, readable,
  properties, kept)
for _, name in ipairs { "cloth", "lattice" } do
  core.declare(name .. ":node", { "The particle of that column, row and layer, from 1.", takes = { { "column", "int 1 >0", "column" },
    { "row", "int 1 >0", "row", optional = true }, { "layer", "int 1 >0", "layer", optional = true } }, gives = "body" })
  core.declare(name .. ":saw", { "Saws into the strut nearest to a point; through, it is gone.", fields = soft.saw_fields, gives = name })
end

local function key(i, j, k) return ("%d %d %d"):format(i, j or 1, k or 1) end

-- thing:node(i, j, k) -> the particle of that column, row and layer, from 1
local function node(thing, i, j, k)
  local what = thing[1].kind .. ":node"
  for name, n in next, { column = i or false, row = j or 1, layer = k or 1 } do
    if not core.whole(n) then core.fail("%s: %s wants a whole number; got %s", what, name, core.type(n)) end
  end
  local b = thing[1].node[key(i, j, k)]
  if not b then
    local self = thing[1]
    core.fail("%s(%s): there is none, of %d columns, %d rows%s", what, (key(i, j, k):gsub(" ", ", ")), self.columns, self.rows,
      self.layers and (", %d layers"):format(self.layers) or "")
  end
  return b
end

cloth_methods.node, lattice_methods.node = node, node

local function add_node(world, self, rest, at, mass, fixed, i, j, k)
  local fields = {}
  for name, v in next, rest do fields[name] = v end
  fields.name, fields.at, fields.mass, fields.radius = ("%s %s"):format(self.name, key(i, j, k)), at, mass, self.radius
  fields.fixed, fields.group = fixed or nil, self.group
  if self.sheet then fields.sheet = { self.sheet, i, j } end
  if fields.turns == nil then fields.turns = false end   -- its struts would not keep it from rolling as the ball of a bearing does
  local body = world:ball(fields)
  self.node[key(i, j, k)] = body
  self.bodies[#self.bodies + 1] = body
end

local function tie(world, self, own, a, b, share)
  a, b = self.node[a], self.node[b]
  if not a or not b or a.fixed and b.fixed then return end
  local j = world:strut { a = a, b = b, name = ("%s strut %d"):format(self.name, #self.joints + 1), stiffness = own.stiffness * share,
    damping = own.damping, relaxation = own.relaxation or not own.damping and RELAXES or nil, breaks_at = own.breaks_at,
    breaks_pressed = own.breaks_pressed, yield = own.yield, radius = self.thickness / 2 }
  self.joints[#self.joints + 1] = j
end

local function begin(world, what, own, rest)
  core.need("world:" .. what, own, "stiffness", "mass")
  return { kind = what, name = rest.name or what, world = world, bodies = {}, joints = {}, node = {}, breaks_at = own.breaks_at,
    group = rest.group or soft.group(world) }
end

local function finish(self)
  self.bodies, self.joints = core.list(self.bodies), core.list(self.joints)
end

-- ---- cloth ----

local cloth_fields = core.declare("world:cloth", { "Particles in rows, held to their neighbours by struts.",
  fields = core.join_fields(common_fields, {
    at = { "vec m", "its first corner", need = true }, across = { "vec m", "from there along the first row", need = true },
    down = { "vec m", "from there along the first column", need = true },
    columns = { "int 1", "particles across", default = 10, min = 1, max = 10000 },
    rows = { "int 1", "particles down", default = 10, min = 1, max = 10000 },
    pins = { "any", "what is fixed: 'top', 'corners', 'none' or a list of {column, row}; default 'top'", type = "string|integer[][]" } }),
  with = { "body" }, gives = "cloth" })

-- "top", "corners", or a list of {column, row}: a set of keys
local function pinned(own)
  local set, n, m = {}, own.columns, own.rows
  local pins = own.pins or "top"
  if pins == "top" then
    for i = 1, n do set[key(i, 1)] = true end
  elseif pins == "corners" then
    for _, i in ipairs { 1, n } do
      for _, j in ipairs { 1, m } do set[key(i, j)] = true end
    end
  elseif core.type(pins) == "table" then
    for _, p in ipairs(pins) do set[key(p[1], p[2])] = true end
  elseif pins ~= "none" then
    core.unknown("world:cloth:", "unknown pins", tostring(pins), { top = true, corners = true, none = true })
  end
  return set
end

local function make_cloth(world, self, own, rest, pins)
  local n, m, share = own.columns, own.rows, own.shear or 0.1
  local dx, dy = own.across / math.max(1, n - 1), own.down / math.max(1, m - 1)
  for j = 1, m do
    for i = 1, n do
      add_node(world, self, rest, own.at + dx * (i - 1) + dy * (j - 1), own.mass / (n * m), pins[key(i, j)], i, j)
    end
  end
  for j = 1, m do
    for i = 1, n do
      tie(world, self, own, key(i, j), key(i + 1, j), 1)
      tie(world, self, own, key(i, j), key(i, j + 1), 1)
      if share > 0 then
        tie(world, self, own, key(i, j), key(i + 1, j + 1), share)
        tie(world, self, own, key(i + 1, j), key(i, j + 1), share)
      end
    end
  end
end

-- world:cloth{at = its first corner, across = {x,y,z}, down = {x,y,z}, columns = 10, rows = 10, mass=, stiffness = (EA of a thread, N),
-- pins = "top" | "corners" | "none" | {{1, 1}, ...}, relaxation=, breaks_at=, shear = 0.1} -> cloth
function methods.cloth(world, fields)
  local own, rest = soft.split("world:cloth", fields, cloth_fields, taken)
  core.need("world:cloth", own, "at", "across", "down")
  if own.columns * own.rows > 10000 or own.columns * own.rows < 2 then
    core.fail("world:cloth: %d columns of %d rows, must be 2 to 10000 particles", own.columns, own.rows)
  end
  local self = begin(world, "cloth", own, rest)
  local n, m, pins = own.columns, own.rows, pinned(own)
  local dx, dy = own.across / math.max(1, n - 1), own.down / math.max(1, m - 1)
  self.columns, self.rows, self.sheet = n, m, soft.sheet(world)
  self.radius = own.radius or 0.25 * math.min(n > 1 and #dx or #dy, m > 1 and #dy or #dx)
  self.thickness = 0.3 * self.radius
  soft.build(self, function() make_cloth(world, self, own, rest, pins) end)
  finish(self)
  return new_cloth(self)
end

-- ---- lattices ----

local lattice_fields = core.declare("world:lattice", { "A body of particles that springs back.", fields = core.join_fields(common_fields, {
  at = { "vec m", "its centre", need = true }, size = { "any", "its edges, m: one number or three", need = true, type = "number|vector" },
  cells = { "any", "so many along each edge: one number or three; default 2", type = "number|vector" } }), with = { "body" },
    gives = "lattice" })

local function triple(what, value, least, unit)
  local kind = core.type(value)
  if kind == "number" or kind == "string" then value = { value, value, value } end
  if kind == "nil" or kind == "boolean" or kind == "function" then core.fail("%s wants a number or three; got %s", what, kind) end
  local t = { value[1] or value.x, value[2] or value.y, value[3] or value.z }
  for i = 1, 3 do
    t[i] = core.quantity(t[i], unit, what)
    if t[i] < least then core.fail("%s = %g, must be at least %g", what, t[i], least) end
  end
  return t
end

-- Of the faces of a cell, from corner to corner
local diagonals = { { { 0, 0, 0 }, { 1, 1, 0 } }, { { 1, 0, 0 }, { 0, 1, 0 } }, { { 0, 0, 0 }, { 1, 0, 1 } },
  { { 1, 0, 0 }, { 0, 0, 1 } }, { { 0, 0, 0 }, { 0, 1, 1 } }, { { 0, 1, 0 }, { 0, 0, 1 } } }

local function make_lattice(world, self, own, rest, corner, d)
  local n = { self.columns, self.rows, self.layers }
  local mass = own.mass / (n[1] * n[2] * n[3])
  for k = 1, n[3] do
    for j = 1, n[2] do
      for i = 1, n[1] do
        add_node(world, self, rest, corner + core.vec((i - 1) * d.x, (j - 1) * d.y, (k - 1) * d.z), mass, nil, i, j, k)
      end
    end
  end
  local share = own.shear or 0.5
  for k = 1, n[3] do
    for j = 1, n[2] do
      for i = 1, n[1] do
        local here = key(i, j, k)
        tie(world, self, own, here, key(i + 1, j, k), 1)
        tie(world, self, own, here, key(i, j + 1, k), 1)
        tie(world, self, own, here, key(i, j, k + 1), 1)
        for _, c in ipairs(diagonals) do
          local p, q = c[1], c[2]
          tie(world, self, own, key(i + p[1], j + p[2], k + p[3]), key(i + q[1], j + q[2], k + q[3]), share)
        end
      end
    end
  end
end

-- world:lattice{at = its centre, size = {x,y,z}, cells = {nx,ny,nz}, mass=, stiffness = (EA of a strut, N), relaxation=, breaks_at=,
-- shear = 0.5} -> lattice: a body of particles that springs back
function methods.lattice(world, fields)
  local own, rest = soft.split("world:lattice", fields, lattice_fields, taken)
  core.need("world:lattice", own, "at", "size")
  local size, cells = triple("world:lattice.size", own.size, 1e-6, "m"), triple("world:lattice.cells", own.cells or 2, 1, "1")
  local n = {}
  for i = 1, 3 do
    if cells[i] ~= math.floor(cells[i]) then core.fail("world:lattice.cells = %g, must be a whole number", cells[i]) end
    n[i] = math.floor(cells[i]) + 1
  end
  local particles = 1.0 * n[1] * n[2] * n[3]                -- as whole numbers they wrap around
  if particles > 10000 then core.fail("world:lattice: %g particles, must be at most 10000", particles) end
  local self = begin(world, "lattice", own, rest)
  local d = core.vec(size[1] / (n[1] - 1), size[2] / (n[2] - 1), size[3] / (n[3] - 1))
  local corner = own.at - core.vec(size[1], size[2], size[3]) / 2
  self.columns, self.rows, self.layers = n[1], n[2], n[3]
  self.radius = own.radius or 0.25 * math.min(d.x, d.y, d.z)
  self.thickness = 0.5 * self.radius
  soft.build(self, function() make_lattice(world, self, own, rest, corner, d) end)
  finish(self)
  return new_lattice(self)
end

return true
