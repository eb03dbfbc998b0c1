-- digbox/soft.lua - trusses, and what all soft things made of bodies and joints share: stress, saw cuts, the static interaction graph.
--
-- A soft thing is nothing but bodies and elastic joints (engine/joint/strut.c, engine/joint/beam.c): contacts, DIGs, sleep, files
-- and pictures treat it like all else. Its static interaction graph is the list of those joints.

local core = ...
local next, type, pairs, ipairs, setmetatable, pcall, error = next, type, pairs, ipairs, setmetatable, pcall, error

local soft = {}
core.soft = soft
local methods = core.types.world.methods
local LONGEST = 40                 -- bytes of the name of a thing
local FIRST_GROUP = -1000000       -- groups of their own have numbers below
local LAST_SHEET = 1000000000      -- as engine/api/schema.c has it
local STRUCTURAL = { strut = true, beam = true }

-- ---- fields ----

-- core.split; what goes to the bodies is checked, too, and the name must leave room for those of the parts.
function soft.split(what, fields, spec, taken)
  local own, rest = core.split(what, fields, spec, taken)
  core.check_body(rest, what)
  if rest.name and #rest.name > LONGEST then
    core.fail("%s.name has %d bytes, must have at most %d: its parts are named by it", what, #rest.name, LONGEST)
  end
  return own, rest
end

-- All of it or nothing: what fails half way takes back the bodies that are there, and with them their joints.
function soft.build(self, make)
  local fine, message = pcall(make)
  if fine then return end
  for _, body in ipairs(self.bodies) do body:remove() end
  error(message, 0)
end

-- A unit vector against gravity; y where there is none.
function soft.up(world)
  local g = world.gravity
  return #g > 0 and (-g):normalized() or core.vec(0, 1, 0)
end

-- The rotation that takes x to along and y as near to up as it gets
function soft.frame(along, up)
  local turn = core.quat { from = { 1, 0, 0 }, to = along }
  local y = turn:rotate { 0, 1, 0 }
  local angle = math.atan(along:dot(y:cross(up)), y:dot(up))
  return core.quat { axis = along, angle = angle } * turn
end

-- A group of bodies that never touch each other, for one thing's own
function soft.group(world)
  local state = core.lua_state(world)
  state.soft_group = (state.soft_group or FIRST_GROUP) - 1
  return state.soft_group
end

-- The number of a new sheet, down from the greatest, for scripts count their own up: of the same count as groups, so that no two have the
-- same after a file was read, either.
function soft.sheet(world) return LAST_SHEET - (FIRST_GROUP - soft.group(world)) end

-- ---- the static interaction graph ----

local function sig_of(joints)
  local list = {}
  for _, j in ipairs(joints) do
    if j.valid then
      local elastic = STRUCTURAL[j.type]
      list[#list + 1] = { a = j.a, b = j.b, joint = j, name = j.name, stress = j.stress,
        rest_length = elastic and j.length or nil, cut = elastic and j.cut or nil,
        strength = j.type == "beam" and j.strength or j.breaks_at }
    end
  end
  return core.list(list)
end

-- All joints that hold body a in one piece, however many bodies that is.
local function joints_of(world, body)
  local at = {}                    -- body -> its joints
  for _, j in ipairs(world:joints()) do
    if STRUCTURAL[j.type] then
      for _, end_ in ipairs { j.a, j.b or false } do
        if end_ and not end_.fixed then
          at[end_] = at[end_] or {}
          table.insert(at[end_], j)
        end
      end
    end
  end
  local found, seen, reached, queue = {}, {}, { [body] = true }, { body }
  for _, b in ipairs(queue) do
    for _, j in ipairs(at[b] or {}) do
      if not seen[j] then
        seen[j] = true
        found[#found + 1] = j
      end
      for _, other in ipairs { j.a, j.b or false } do
        if other and not reached[other] and not other.fixed then
          reached[other] = true
          queue[#queue + 1] = other
        end
      end
    end
  end
  return found
end

local SIG = { "What holds it together inside, not what it touches: list of {a, b, joint, name, strength, rest_length, cut, stress}.",
  gives = "table[]" }
core.declare("body:sig", { SIG[1], gives = SIG.gives })

-- body:sig() -> list of {a, b, joint, name, strength, rest_length, cut, stress}: what holds it together inside, not what it touches
function core.types.body.methods.sig(body)
  return sig_of(joints_of(body.world, body))
end

-- ---- what all soft things can do ----

-- What can be read of all of them
soft.properties = {
  name = { "string", "its name" }, mass = { "number", "of all that moves", unit = "kg" },
  position = { "vector", "its centre of mass", unit = "m" }, broken = { "integer", "joints that are no more" },
  bodies = { "body[]", "what it is made of" }, joints = { "joint[]", "what holds it together" } }

-- What files keep of all of them
soft.kept = { name = "text", bodies = "body list", joints = "joint list", thickness = "number", breaks_at = "number?", group = "whole?" }

local function join(a, b)
  local all = {}
  for _, set in ipairs { a, b } do
    for k, v in pairs(set) do all[k] = v end
  end
  return all
end

-- A class: methods, getters and what else can be read of the object's own table.
-- what: in words; properties: all that can be read, as core.declare_type takes it; kept: what files keep of it (keep.lua);
-- again(self): what else a handle needs that is made anew from a file
function soft.class(name, what, class_methods, getters, readable, properties, kept, again)
  core.declare_type(name, what, class_methods, properties)
  core.declare(name .. ":sig", { SIG[1], gives = SIG.gives })
  local class = { __name = name, __metatable = false }
  class.__index = function(thing, key)
    if class_methods[key] then return class_methods[key] end
    if getters[key] then return getters[key](thing[1]) end
    if readable[key] then return thing[1][key] end
    core.unknown(name, "has no field or method", tostring(key), class_methods, getters, readable)
  end
  class.__newindex = function(_, key) core.fail("%s.%s cannot be assigned", name, tostring(key)) end
  class.__tostring = function(thing) return ("%s '%s', %d bodies"):format(name, thing[1].name, #thing[1].bodies) end
  local function make(self)
    local thing = setmetatable({ self }, class)
    core.keep.add(self.world, thing)
    return thing
  end
  core.keep.class(name, join(kept, soft.kept), function(self)
    local state = core.lua_state(self.world)
    local sheet_group = self.sheet and FIRST_GROUP - (LAST_SHEET - self.sheet) or FIRST_GROUP
    state.soft_group = math.min(state.soft_group or FIRST_GROUP, self.group or FIRST_GROUP, sheet_group)
    if again then again(self) end
    return make(self)
  end)
  return make
end

-- The largest number of that name that any of its joints has
function soft.largest(self, key)
  local most = 0
  for _, j in ipairs(self.joints) do
    if j.valid then most = math.max(most, j[key]) end
  end
  return most
end

-- The largest share of its limit that any joint bears; 1 breaks.
function soft.stress(self) return soft.largest(self, "stress") end

-- Joints that are no more
function soft.broken(self)
  local n = 0
  for _, j in ipairs(self.joints) do n = n + (j.valid and 0 or 1) end
  return n
end

function soft.sig(thing) return sig_of(thing[1].joints) end

function soft.position(self)
  local sum, mass = core.vec(0, 0, 0), 0
  for _, b in ipairs(self.bodies) do
    if b.valid and not b.fixed then
      sum, mass = sum + b.position * b.mass, mass + b.mass
    end
  end
  return mass > 0 and sum / mass or sum
end

function soft.mass(self)
  local mass = 0
  for _, b in ipairs(self.bodies) do
    if b.valid and not b.fixed then mass = mass + b.mass end
  end
  return mass
end

-- The nearest joint to a point of the world
local function nearest(joints, at)
  local best, least
  for _, j in ipairs(joints) do
    if j.valid then
      local middle = j.b and j.type == "strut" and (j.a.position + j.b.position) / 2 or j.at
      local d = #(middle - at)
      if not best or d < least then best, least = j, d end
    end
  end
  return best
end
soft.nearest = nearest

-- Saws the joint: depth adds to what is sawn already; all of the thickness takes it off.
function soft.cut(j, depth, thickness)
  local cut = j.cut + depth / thickness
  if cut >= 0.999 then
    j:remove()
  else
    j:set { cut = cut }
  end
end

local DEPTH = { "real m >0", "how deep", need = true }
soft.saw_fields = { at = { "vec m", "the joint nearest to this point is sawn", need = true }, depth = DEPTH }
-- of what has a way to say where
soft.saw_along = { at = { "any", "metres from its start, or the nearest to this point", need = true, type = "number|string|vector" },
  depth = DEPTH }

-- thing:saw{at=, depth=}: the joint next to that point of the world loses that much of its thickness
function soft.saw(thing, fields)
  local self = thing[1]
  local f = core.check(fields, self.kind .. ":saw", self.where and soft.saw_along or soft.saw_fields)
  core.need(self.kind .. ":saw", f, "at", "depth")
  local at = self.where and self.where(self, f.at) or f.at
  local j = nearest(self.joints, at)
  if j then soft.cut(j, f.depth, self.thickness) end
  return thing
end

-- ---- trusses ----

-- Of a strut, and of all that do not say it themselves
soft.strut_fields = {
  stiffness = { "real N >0", "E A: force for doubling its length" }, damping = { "real N*s/m", "of its length; default by relaxation" },
  relaxation = { "real s", "damping over stiffness" }, breaks_at = { "real N >0", "pulled by more it breaks" },
  breaks_pressed = { "real N >0", "pressed by more it breaks; default breaks_at" },
  yield = { "real N >0", "beyond it the length changes for good" } }
local PRICE = { "real 1 >=0", "of a strut, against the budget" }
local node_fields = { at = { "vec m", "where", need = true }, mass = { "real kg >0", "of the node", default = 1 },
  fixed = { "any", "coordinates it keeps, such as 'xy'; true: all", type = "string|boolean" } }
local own_strut_fields = core.join_fields(soft.strut_fields, { length = { "real m >0", "at rest; default as it is" }, price = PRICE,
  deck = { "bool", "carries a panel to drive on" } })
local deck_fields = {
  gap = { "real m", "between panels; default 0.2 thickness" }, width = { "real m >0", "default 20 radius" },
  thickness = { "real m >0", "default radius" }, mass = { "real kg >0", "of a panel" }, material = { "text", "of a panel" },
  friction = { "real 1", "of a panel" }, restitution = { "real 1", "of a panel", default = 0 } }
local truss_fields = core.declare("world:truss", { "A framework of struts between nodes, each with a limit at which it breaks.",
  fields = core.join_fields(soft.strut_fields, {
    nodes = { "any", "by name", type = "table<string, table>", need = true, fields = node_fields },
    struts = { "any", "list of {'A', 'B', ...}", type = "table[]", need = true, fields = own_strut_fields }, price = PRICE,
    budget = { "real 1 >=0", "the struts may cost no more" },
    plane = { "text", "all nodes keep to that plane", of = { "xy", "yz", "xz" } },
    radius = { "real m >0", "of the nodes; default 0.005 of its size" },
    deck = { "any", "of struts with deck = true", type = "table", fields = deck_fields } }), with = { "body" }, gives = "truss" })
local passed_on = { "stiffness", "damping", "relaxation", "breaks_at", "breaks_pressed", "yield", "length" }
local DAMPED = 1 / 240             -- s  relaxation of a truss or lattice of which nothing is said: its shrill tones die within a frame
local taken = { at = "nodes say where", rotation = "nodes say where", mass = "give it to nodes", density = "give nodes a mass",
  fixed = "give it to nodes" }
local axes = { x = core.vec(1, 0, 0), y = core.vec(0, 1, 0), z = core.vec(0, 0, 1) }
local across = { xy = "z", yz = "x", xz = "y" }

-- "xz" or true -> {x = true, z = true}
local function held(what, fixed, plane)
  if fixed == true then fixed = "xyz" end
  if fixed == nil or fixed == false then fixed = "" end
  if type(fixed) ~= "string" or fixed:find "[^xyz]" then
    core.fail("%s.fixed = %s, must be letters of xyz, or true", what, tostring(fixed))
  end
  local set, n = {}, 0
  for axis in (fixed .. (plane and across[plane] or "")):gmatch "." do
    if not set[axis] then set[axis], n = true, n + 1 end
  end
  return set, n
end

-- A node that keeps one or two coordinates runs in a plane or on a line.
local function guide_node(world, body, set, n)
  if n == 0 or n == 3 then return end
  local line = n == 2
  for name, axis in pairs(axes) do
    if (set[name] or false) ~= line then
      world:guide { a = body, at = body.position, axis = axis, keeps = line and "line" or "plane", name = body.name .. " guide" }
    end
  end
end

local function make_nodes(world, self, own, rest)
  local names = {}
  for name in pairs(own.nodes) do names[#names + 1] = name end
  table.sort(names, function(a, b) return tostring(a) < tostring(b) end)
  for _, name in ipairs(names) do
    local what = ("world:truss.nodes.%s"):format(tostring(name))
    local node = core.check(own.nodes[name], what, node_fields)
    core.need(what, node, "at")
    local set, n = held(what, node.fixed, own.plane)
    local fields = {}
    for k, v in next, rest do fields[k] = v end
    fields.name, fields.at, fields.radius = ("%s %s"):format(self.name, tostring(name)), node.at, own.radius
    fields.mass, fields.fixed = node.mass, n == 3 or nil
    if fields.collides == nil then fields.collides = false end
    local body = world:ball(fields)
    guide_node(world, body, set, n)
    self.nodes[tostring(name)] = body
    self.bodies[#self.bodies + 1] = body
  end
end

-- Of two names, in the order in which a strut of that pair was made
local function key_of(self, what, a, b)
  if b == nil then
    if type(a) ~= "string" then core.fail("%s wants the name of a strut, such as 'AB'; got %s", what, core.type(a)) end
    if self.strut[a] then return a end
    if #a > 200 then core.fail("%s: the name of a strut of %d bytes", what, #a) end
    for i = 1, #a - 1 do
      if self.strut[a:sub(i + 1) .. a:sub(1, i)] then return a:sub(i + 1) .. a:sub(1, i) end
    end
    core.unknown(what .. ":", "unknown strut", a, self.strut)
  end
  local ab, ba = tostring(a) .. tostring(b), tostring(b) .. tostring(a)
  return self.strut[ab] and ab or self.strut[ba] and ba or core.unknown(what .. ":", "unknown strut", ab, self.strut)
end

local function node_of(self, what, name)
  return self.nodes[tostring(name)] or core.unknown(what .. ":", "unknown node", tostring(name), self.nodes)
end

-- A panel between two nodes: turns with them, gives way to their stretch, and hands its load to both by the lever rule.
local function lay_deck(world, self, own, a, b, key)
  local d = own.deck
  local pa, pb = a.position, b.position
  local along = (pb - pa):normalized()
  local up = self.up
  local side = along:cross(up):normalized()
  up = side:cross(along)
  local panel = world:box { name = ("%s deck %s"):format(self.name, key), at = (pa + pb) / 2,
    size = { #(pb - pa) - d.gap, d.thickness, d.width }, mass = d.mass, material = d.material, friction = d.friction,
    restitution = d.restitution,
    rotation = soft.frame(along, up), group = self.group }
  self.bodies[#self.bodies + 1] = panel
  self.panels[#self.panels + 1] = panel
  world:ball_joint { a = panel, b = a, at = pa }
  local slide = world:guide { a = b, b = panel, at = pb, axis = along, keeps = "line" }
  world:guide { a = panel, axis = side, keeps = "direction" }
  self.slides[key] = slide
end

local function make_strut(world, self, own, entry, index)
  local what = ("world:truss.struts[%d]"):format(index)
  if type(entry) ~= "table" then core.fail("%s wants a table such as {'A', 'B'}; got %s", what, core.type(entry)) end
  local fields = {}
  for k, v in next, entry do
    if k ~= 1 and k ~= 2 then fields[k] = v end
  end
  local f = core.check(fields, what, own_strut_fields)
  local a, b = node_of(self, what, entry[1]), node_of(self, what, entry[2])
  local key = tostring(entry[1]) .. tostring(entry[2])
  if self.strut[key] then core.fail("%s: there is a strut '%s' already", what, key) end
  if a == b then core.fail("%s: a strut from node '%s' to itself", what, tostring(entry[1])) end
  local given = { a = a, b = b, name = key, radius = 0.6 * own.radius }
  for _, name in ipairs(passed_on) do
    if f[name] ~= nil then given[name] = f[name] else given[name] = own[name] end
  end
  if given.stiffness == nil then core.fail("%s: stiffness is missing (EA, in N)", what) end
  if given.damping == nil and given.relaxation == nil then given.relaxation = DAMPED end
  local joint = world:strut(given)
  self.strut[key] = joint
  self.joints[#self.joints + 1] = joint
  if f.deck then lay_deck(world, self, own, a, b, key) end
end

-- Price of all struts; an error before anything is built when that is over the budget
local function cost_of(own)
  local cost = 0
  for _, entry in ipairs(own.struts) do
    local price = type(entry) == "table" and entry.price or own.price or 0
    cost = cost + core.quantity(price, "1", "world:truss.struts: price")
  end
  if own.budget and cost > own.budget then
    core.fail("world:truss: %d struts cost %g, the budget is %g", #own.struts, cost, own.budget)
  end
  return cost
end

local function size_of(nodes)
  local low, high = core.vec(math.huge, math.huge, math.huge), core.vec(-math.huge, -math.huge, -math.huge)
  for name, node in pairs(nodes) do
    if type(node) ~= "table" or node.at == nil then core.fail("world:truss.nodes.%s: at is missing", tostring(name)) end
    local p = core.check({ at = node.at }, ("world:truss.nodes.%s"):format(tostring(name)), { at = "vec m" }).at
    low = core.vec(math.min(low.x, p.x), math.min(low.y, p.y), math.min(low.z, p.z))
    high = core.vec(math.max(high.x, p.x), math.max(high.y, p.y), math.max(high.z, p.z))
  end
  return #(high - low)
end

-- Without its strut a panel slides off its far node.
local function let_slide(self)
  if not next(self.slides) then return end
  self.world:on("broken", function(e)
    for key, slide in next, self.slides do
      if e.joint == self.strut[key] and slide.valid then slide:remove() end
    end
  end)
end

local truss_methods = { sig = soft.sig }
local new_truss = soft.class("truss", "A framework of struts.", truss_methods,
  { mass = soft.mass, position = soft.position, broken = soft.broken },
  { cost = true, budget = true, name = true, bodies = true, panels = true, joints = true },
  core.join_fields(soft.properties, { cost = { "number", "price of all struts" }, budget = { "number|nil", "what they may cost" },
    panels = { "body[]", "of its deck" } }),
  { nodes = "body map", strut = "joint map", panels = "body list", slides = "joint map", cost = "number", budget = "number?",
    price = "number?", up = "vector" }, let_slide)

-- world:truss{nodes = {A = {at=, mass=, fixed = "xyz"}}, struts = {{"A", "B", deck = true}}, stiffness = (EA, N), damping=, relaxation=,
-- breaks_at=, price=, budget=, plane = "xy"} -> truss
function methods.truss(world, fields)
  local own, rest = soft.split("world:truss", fields, truss_fields, taken)
  core.need("world:truss", own, "nodes", "struts")
  for _, key in ipairs { "nodes", "struts" } do
    if type(own[key]) ~= "table" then core.fail("world:truss.%s wants a table; got %s", key, core.type(own[key])) end
  end
  if own.plane and not across[own.plane] then core.unknown("world:truss:", "unknown plane", own.plane, across) end
  local cost = cost_of(own)
  own.radius = own.radius or math.max(0.005 * size_of(own.nodes), 2e-4)
  own.deck = core.check(own.deck or {}, "world:truss.deck", deck_fields)
  own.deck.width, own.deck.thickness = own.deck.width or 20 * own.radius, own.deck.thickness or own.radius
  own.deck.gap = own.deck.gap or 0.2 * own.deck.thickness
  local self = { kind = "truss", name = rest.name or "truss", world = world, cost = cost, budget = own.budget,
    price = own.price, breaks_at = own.breaks_at, nodes = {}, strut = {},
    joints = {}, bodies = {}, panels = {}, slides = {}, thickness = 2 * own.radius, up = soft.up(world),
    group = rest.group or soft.group(world) }
  soft.build(self, function()
    make_nodes(world, self, own, rest)
    for i, entry in ipairs(own.struts) do make_strut(world, self, own, entry, i) end
  end)
  let_slide(self)
  self.bodies, self.joints, self.panels = core.list(self.bodies), core.list(self.joints), core.list(self.panels)
  return new_truss(self)
end

local PAIR = { { "name", "text", "of a strut, such as 'AB', or of its first node" },
  { "other", "text", "of its second node", optional = true } }
core.declare("truss:node", { "The body of a node.", takes = { { "name", "text", "of the node" } }, gives = "body" })
core.declare("truss:strut", { "The joint of a strut.", takes = PAIR, gives = "joint" })
core.declare("truss:push", { "Pushes a node, for the next step.", takes = { { "name", "text", "of the node" },
  { "force", "vec N", "the force" } }, gives = "truss" })
core.declare("truss:force", { "The force in a strut, N: tension positive, 0 when it is broken.", takes = PAIR, gives = "number" })
core.declare("truss:stress", { "Load over limit of a strut, or without a name the largest of all; 1 breaks.",
  takes = { { "name", "text", "of a strut", optional = true }, PAIR[2] }, gives = "number" })
core.declare("truss:cut", { "Takes a strut out.", takes = PAIR, gives = "truss" })
core.declare("truss:saw", { "Saws into the joint nearest to a point; through, it is gone.", fields = soft.saw_fields, gives = "truss" })

-- t:node "A" -> the body; t:strut "AB" -> the joint
function truss_methods.node(t, name) return node_of(t[1], "truss:node", name) end
function truss_methods.strut(t, a, b) return t[1].strut[key_of(t[1], "truss:strut", a, b)] end

-- t:push("A", force): for the next step
function truss_methods.push(t, name, force)
  node_of(t[1], "truss:push", name):push { force = force }
  return t
end

-- t:force "AB" -> N, tension positive; 0 when it is broken
function truss_methods.force(t, a, b)
  local j = t[1].strut[key_of(t[1], "truss:force", a, b)]
  if not j.valid then return 0 end
  return j.force:dot((j.b.position - j.a.position):normalized())
end

-- t:stress "AB" -> load over limit, 1 breaks; without a name the largest of all
function truss_methods.stress(t, a, b)
  if a == nil then return soft.stress(t[1]) end
  local j = t[1].strut[key_of(t[1], "truss:stress", a, b)]
  return j.valid and j.stress or 0
end

-- t:cut "AB": takes the strut out
function truss_methods.cut(t, a, b)
  local j = t[1].strut[key_of(t[1], "truss:cut", a, b)]
  if j.valid then j:remove() end
  return t
end

truss_methods.saw = soft.saw

return true
