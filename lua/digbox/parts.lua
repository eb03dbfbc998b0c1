-- digbox/parts.lua - ready-made things, written over what a script can call itself: digbox.parts.door(world, {...}) and its like.
--
-- A part is bodies and joints with names of their own ("door leaf", "door hinge"), and a handle that knows them; files keep the handle
-- (keep.lua). Up is y in all of them. What a part holds on to is the world unless it is given a body, `into`.

local core = ...
local next, setmetatable = next, setmetatable

local digbox, soft = core.digbox, core.soft
local parts = {}
local UP = core.vec(0, 1, 0)

-- ---- what all parts have in common ----

local shared = {
  at = { "vec m", "where it stands", need = true }, name = { "text", "its bodies and joints begin with it; default the part's" } }
local held = { into = { "any", "the body that holds it; default the world", type = "body" } }
local directed = { along = { "dir 1", "which way, level; default x" } }
local common = { name = { "string", "its name" }, bodies = { "body[]", "what it is made of" },
  joints = { "joint[]", "what holds it together" } }
local OF = { { "world", "any", "where it is made", type = "world", need = true } }

core.declare("digbox.parts", { "Ready-made parts: digbox.parts.door(world, { at = { 0, 0, 0 } }) and its like.",
  constant = "digbox.parts" })

-- Declares parts.kind(world, fields): help, its fields, properties name -> {type, help, get or nil: a body or joint of that name},
-- methods, and what files keep: names of numbers, or name = kind (keep.lua). make(self, own) makes it, go_on(self) when it was loaded.
local function part(kind, help, fields, properties, methods, numbers, make, go_on)
  local what = "parts." .. kind
  local kept = { name = "text", bodies = "body list", joints = "joint list", body = "body map", joint = "joint map" }
  for name, of in next, numbers do
    if type(name) == "number" then name, of = of, "number" end
    kept[name] = of
  end
  core.declare(what, { help, takes = OF, fields = core.join_fields(shared, fields), gives = kind })
  core.declare_type(kind, help, methods, core.join_fields(common, properties))
  local class = { __name = kind, __metatable = false }
  class.__index = function(thing, key)
    local self, p = thing[1], properties[key]
    if methods[key] then return methods[key] end
    if common[key] then return self[key] end
    if not p then core.unknown(kind, "has no field or method", tostring(key), methods, properties, common) end
    if p.get then return p.get(self) end
    return self.body[key] or self.joint[key]
  end
  class.__newindex = function(_, key) core.fail("%s.%s cannot be assigned", kind, tostring(key)) end
  class.__tostring = function(thing) return ("%s '%s'"):format(kind, thing[1].name) end
  local function handle(self)
    local thing = setmetatable({ self }, class)
    core.keep.add(self.world, thing)
    return thing
  end
  core.keep.class(kind, kept, function(self)
    if go_on then go_on(self) end
    return handle(self)
  end)
  parts[kind] = function(world, given)
    if core.type(world) ~= "world" then core.fail("%s wants a world and a table of fields; got %s", what, core.type(world)) end
    local own = core.check(given, what, nil, world)
    for name, field in next, core.fields[what] do
      if field.need and own[name] == nil then core.fail("%s: %s is missing", what, name) end
    end
    if own.into ~= nil and core.type(own.into) ~= "body" then core.fail("%s.into wants a body; got %s", what, core.type(own.into)) end
    if own.along then
      own.along = own.along - UP * own.along.y
      if #own.along < 1e-6 then core.fail("%s.along points straight up or down, must be level", what) end
      own.along = own.along:normalized()
    end
    own.along = own.along or core.vec(1, 0, 0)
    if own.name and #own.name > 40 then
      core.fail("%s.name has %d bytes, must have at most 40: its parts are named by it", what, #own.name)
    end
    local self = { kind = kind, name = own.name or kind, world = world, bodies = {}, joints = {}, body = {}, joint = {} }
    soft.build(self, function() make(self, own) end)
    self.bodies, self.joints = core.list(self.bodies), core.list(self.joints)
    return handle(self)
  end
end

local function add_body(self, key, type_of, fields)
  fields.name = self.name .. " " .. key:gsub("_", " ")
  local body = self.world[type_of](self.world, fields)
  self.bodies[#self.bodies + 1], self.body[key] = body, body
  return body
end

local function add_joint(self, key, type_of, fields)
  fields.name = self.name .. " " .. key:gsub("_", " ")
  local joint = self.world[type_of](self.world, fields)
  self.joints[#self.joints + 1], self.joint[key] = joint, joint
  return joint
end

-- The rotation that turns x to along and leaves y up
local function facing(along) return soft.frame(along, UP) end

local function value_of(key, what)
  return function(self) return self.joint[key].valid and self.joint[key][what] or 0 end
end

local function bolt_holds(self) return self.joint.bolt ~= nil and self.joint.bolt.valid end

-- Of what can be bolted when it is shut. shut(self) -> how far it is from that; far: how much of it a bolt takes
local bolt_fields = { bolted = { "bool", "a bolt holds it shut", default = false },
  strength = { "real N >0", "at which its bolt breaks", default = 5000 } }
local bolt_property = { bolted = { "boolean", "its bolt holds", get = bolt_holds } }

local function bolting(kind, body, shut, far)
  local methods = {}
  local function shoot(self)
    local gap = math.abs(shut(self))
    if gap > far then core.fail("%s:bolt: %s is open by %.3g, a bolt takes it at most %g", kind, self.name, gap, far) end
    local holder = self.joint.hinge or self.joint.runner
    add_joint(self, "bolt", "bolt", { a = self.body[body], b = holder.b, at = self.body[body].position, strength = self.strength })
  end
  function methods.bolt(thing)
    if not bolt_holds(thing[1]) then shoot(thing[1]) end
    return thing
  end
  function methods.unbolt(thing)
    if bolt_holds(thing[1]) then thing[1].joint.bolt:withdraw() end
    return thing
  end
  core.declare(kind .. ":bolt", { "Bolts it; it must be shut.", gives = kind })
  core.declare(kind .. ":unbolt", { "Draws the bolt.", gives = kind })
  return methods, shoot
end

-- ---- door ----

local door_methods, shoot_door = bolting("door", "leaf", function(self) return self.joint.hinge.angle end, 0.02)

-- parts.door(world, {at = the foot of its hinge, along = from there to the handle, ...}) -> door
part("door", "A leaf on a hinge that stops at its limits and can be bolted.", core.join_fields(held, directed, bolt_fields, {
  width = { "real m >0", "of its leaf", default = 0.8 }, height = { "real m >0", "of its leaf", default = 2 },
  thickness = { "real m >0", "of its leaf", default = 0.04 }, mass = { "real kg >0", "of its leaf; default the material's" },
  material = { "text", "of its leaf", default = "oak" }, opens = { "range rad", "how far, each way; default a quarter turn" },
  gap = { "real m >0", "below it", default = 0.01 }, friction = { "real N*m >=0", "of its hinge", default = 0.2 } }),
  core.join_fields(bolt_property, { leaf = { "body", "what opens" }, hinge = { "joint", "what it turns on" },
    angle = { "number", "how far it is open", unit = "rad", get = value_of("hinge", "angle") } }),
  door_methods, { "strength" }, function(self, own)
    local foot = own.at + UP * own.gap
    local leaf = add_body(self, "leaf", "box", { size = { own.width, own.height, own.thickness }, mass = own.mass, material = own.material,
      at = foot + UP * (own.height / 2) + own.along * (own.width / 2), rotation = facing(own.along) })
    add_joint(self, "hinge", "hinge", { a = leaf, b = own.into, at = foot + UP * (own.height / 2), axis = UP,
      limits = own.opens or { -math.pi / 2, math.pi / 2 }, friction = own.friction })
    self.strength = own.strength
    if own.bolted then shoot_door(self) end
  end)

-- ---- drawer ----

local drawer_methods, shoot_drawer = bolting("drawer", "box", function(self) return self.joint.runner.distance end, 0.005)

-- A box without a lid, of five boards
local function tray(w, h, d, wall)
  local box = core.shapes.box
  return { box { size = { w, wall, d }, at = { 0, (wall - h) / 2, 0 } },
    box { size = { wall, h - wall, d }, at = { (w - wall) / 2, wall / 2, 0 } },
    box { size = { wall, h - wall, d }, at = { (wall - w) / 2, wall / 2, 0 } },
    box { size = { w - 2 * wall, h - wall, wall }, at = { 0, wall / 2, (d - wall) / 2 } },
    box { size = { w - 2 * wall, h - wall, wall }, at = { 0, wall / 2, (wall - d) / 2 } } }
end

-- parts.drawer(world, {at = its middle when it is shut, along = which way it is pulled, ...}) -> drawer
local DRAWER = "A box without a lid on runners that stop it at both ends; it can be bolted."
part("drawer", DRAWER, core.join_fields(held, directed, bolt_fields, {
  width = { "real m >0", "across the way it is pulled", default = 0.4 }, height = { "real m >0", "of it", default = 0.12 },
  depth = { "real m >0", "the way it is pulled", default = 0.45 }, wall = { "real m >0", "thickness of its boards", default = 0.012 },
  travel = { "real m >0", "how far it comes out; default 0.8 depth" }, mass = { "real kg >0", "default the material's" },
  material = { "text", "of its boards", default = "pine" }, friction = { "real N >=0", "of its runners", default = 3 } }),
  core.join_fields(bolt_property, { box = { "body", "what is pulled" }, runner = { "joint", "what it slides on" },
    distance = { "number", "how far it is out", unit = "m", get = value_of("runner", "distance") } }),
  drawer_methods, { "strength" }, function(self, own)
    if 2 * own.wall >= math.min(own.width, own.height, own.depth) then
      core.fail("parts.drawer: wall = %g m, must be less than half of its width, height and depth", own.wall)
    end
    local box = add_body(self, "box", "body", { parts = tray(own.depth, own.height, own.width, own.wall), mass = own.mass,
      material = own.material, at = own.at, rotation = facing(own.along) })
    add_joint(self, "runner", "slider", { a = box, b = own.into, along = own.along, limits = { 0, own.travel or 0.8 * own.depth },
      friction = own.friction })
    self.strength = own.strength
    if own.bolted then shoot_drawer(self) end
  end)

-- ---- lift ----

local lift_methods = {}

local GENTLE = 1                    -- m/s^2  more, and what stands on it would slide or hop

local function drive_lift(self, speed)
  self.joint.guide:set { motor = { speed = speed, max_force = self.force } }
end

-- A task gets it going to self.target and stops it there; a later order ends it. A file keeps where it is going and how fast.
local function travel(self)
  local order, guide, dt = self.order, self.joint.guide, self.world.frame
  self.world:spawn(function(task)
    while order == self.order and guide.valid do
      local left = self.target - guide.distance
      local far = math.abs(left)
      self.pace = math.min(self.pace + GENTLE * dt, self.speed, math.sqrt(2 * GENTLE * far), far / dt)
      if far < 1e-4 then
        drive_lift(self, 0)
        self.target = nil
        break
      end
      drive_lift(self, left < 0 and -self.pace or self.pace)
      task:wait(dt / 2)             -- until the next frame
    end
  end)
end

-- lift:go(height)
function lift_methods.go(thing, height)
  local self = thing[1]
  height = core.quantity(height, "m", "lift:go")
  if height < 0 or height > self.height then core.fail("lift:go: height = %g m, must be 0 to %g m", height, self.height) end
  self.order, self.target, self.pace = self.order + 1, height, 0
  travel(self)
  return thing
end

function lift_methods.stop(thing)
  thing[1].order, thing[1].target = thing[1].order + 1, nil
  drive_lift(thing[1], 0)
  return thing
end

core.declare("lift:go", { "Drives to that height above where it began and stops there.", takes = { { "height", "real m", "where to" } },
  gives = "lift" })
core.declare("lift:stop", { "Stops, and holds what it carries.", gives = "lift" })

-- parts.lift(world, {at = the middle of its floor's top, height = travel, ...}) -> lift
part("lift", "A platform that a motor drives up and down a shaft; `at` is the middle of its top, at least its thickness above a floor.",
  core.join_fields(held, {
  height = { "real m >0", "how far it goes up", need = true }, width = { "real m >0", "of its platform, both ways", default = 1.2 },
  thickness = { "real m >0", "of its platform", default = 0.1 }, mass = { "real kg >0", "of its platform", default = 200 },
  speed = { "real m/s >0", "of its drive", default = 0.5 }, force = { "real N >0", "the most its motor gives", default = 5000 },
  material = { "text", "of its platform", default = "steel" } }), {
    platform = { "body", "what goes up and down" }, guide = { "joint", "the shaft and its motor" },
    distance = { "number", "how high it is", unit = "m", get = value_of("guide", "distance") } },
  lift_methods, { "height", "speed", "force", "order", "pace", target = "number?" }, function(self, own)
    local platform = add_body(self, "platform", "box", { size = { own.width, own.thickness, own.width }, mass = own.mass,
      material = own.material, at = own.at - UP * (own.thickness / 2), restitution = 0 })
    add_joint(self, "guide", "slider", { a = platform, b = own.into, along = UP, limits = { 0, own.height },
      motor = { speed = 0, max_force = own.force } })
    self.height, self.speed, self.force, self.order = own.height, own.speed, own.force, 0
    self.pace = 0
  end, function(self)
    if self.target and self.joint.guide.valid then travel(self) end
  end)

-- ---- clock ----

local TURN, DAY_HALF = 2 * math.pi, 43200       -- rad, s
local clock_methods = {}

-- clock:set_rate(60): an hour in a minute
function clock_methods.set_rate(thing, rate)
  rate = core.quantity(rate, "1", "clock:set_rate")
  thing[1].joint.minute:set { motor = { speed = rate * TURN / 3600, max_torque = thing[1].torque } }
  return thing
end

core.declare("clock:set_rate", { "Drives it that much faster than time; 0 holds it.", takes = { { "rate", "real 1", "s a second" } },
  gives = "clock" })

-- parts.clock(world, {at = the middle of its face, along = which way it looks, ...}) -> clock
part("clock", "Two hands, a motor on the minute hand and a gear of 12 to 1 down to the hour hand.", core.join_fields(directed, {
  radius = { "real m >0", "of its face", default = 0.3 }, shows = { "real s >=0", "at the beginning, since twelve", default = 0 },
  rate = { "real 1", "seconds of its time in one of the world's", default = 1 },
  torque = { "real N*m >0", "the most its motor gives; default four times what lifts its hands" } }), {
    face = { "body", "fixed" }, minute_hand = { "body", "the long one" }, hour_hand = { "body", "the short one" },
    minute = { "joint", "the hinge of the minute hand" }, hour = { "joint", "the hinge of the hour hand" },
    gear = { "joint", "between them" },
    time = { "number", "what the hour hand shows, since twelve", unit = "s", get = function(self)
      return (self.shows + self.joint.hour.angle / TURN * DAY_HALF) % DAY_HALF
    end } },
  clock_methods, { "shows", "torque" }, function(self, own)
    local r, out = own.radius, facing(own.along)
    local face = add_body(self, "face", "cylinder", { fixed = true, radius = r, height = 0.06 * r, at = own.at,
      colour = { 0.85, 0.83, 0.76 }, rotation = out * core.quat { axis = { 0, 0, 1 }, angle = math.pi / 2 }, collides = false })
    local function hand(key, hinge, length, depth, angle)
      local turn = core.quat { axis = own.along, angle = -angle } * out           -- clockwise for who looks at it
      local axle = own.at + own.along * (depth * r)
      local body = add_body(self, key, "box", { size = { 0.04 * r, length * r, 0.03 * r }, at = axle + turn:rotate(UP) * (0.4 * length * r),
        rotation = turn, material = "steel", collides = false, colour = { 0.03, 0.03, 0.03 } })
      return add_joint(self, hinge, "hinge", { a = body, b = face, at = axle, axis = -own.along }), body
    end
    local minute, long = hand("minute_hand", "minute", 0.9, 0.09, own.shows / 3600 * TURN)
    local hour, short = hand("hour_hand", "hour", 0.6, 0.05, own.shows / DAY_HALF * TURN)
    local g = #self.world.gravity
    self.shows = own.shows
    self.torque = own.torque or 4 * math.max(1e-3, (long.mass * 0.36 + short.mass * 0.24 / 12) * r * g)
    minute:set { motor = { speed = own.rate * TURN / 3600, max_torque = self.torque } }
    add_joint(self, "gear", "gear", { a = minute, b = hour, ratio = { 1, 12 } })
  end)

-- ---- lava lamp ----

-- parts.lava_lamp(world, {at = the middle of its foot's top, ...}) -> lava_lamp; the numbers are those of worlds/lava_lamp.lua
part("lava_lamp", "A blob of wax in water that is warm below and cool above. The world's water and air become the lamp's: one a world.", {
  height = { "real m >0", "of its water", default = 0.3 }, radius = { "real m >0", "of the blob", default = 0.02 },
  warm = { "real K >=0", "below", default = 323.15 }, cool = { "real K >=0", "above", default = 303.15 },
  convection = { "real W/(m^2*K) >0", "between wax and water", default = 900 } }, {
    foot = { "body", "fixed, below" }, lid = { "body", "fixed, above" }, wax = { "body", "the blob" } },
  {}, {}, function(self, own)
    local world, what = self.world, "parts.lava_lamp"
    if own.warm <= own.cool then core.fail("%s: warm = %g K, must be more than cool = %g K", what, own.warm, own.cool) end
    if own.height < 4 * own.radius then core.fail("%s: height = %g m, must be at least four radii of the blob", what, own.height) end
    local gradient, from = (own.cool - own.warm) / own.height, 298.15       -- K/m, K at which wax and water have their densities
    local wide = 4 * own.radius
    add_body(self, "foot", "cylinder", { fixed = true, radius = wide, height = 0.05, at = own.at - UP * 0.025, material = "steel",
      restitution = 0 })
    add_body(self, "lid", "cylinder", { fixed = true, radius = wide, height = 0.03, at = own.at + UP * (own.height + 0.015),
      material = "steel", restitution = 0 })
    add_body(self, "wax", "ball", { at = own.at + UP * (1.5 * own.radius), radius = own.radius, density = 1008.7, drag_coefficient = 0,
      restitution = 0, friction = 0, temperature = own.warm, expansion = 0.8e-3, expansion_from = from, heat_capacity = 2000,
      convection = own.convection, colour = { 0.9, 0.25, 0.05 } })
    world:ambient { temperature = math.max(0, own.warm - gradient * own.at.y), gradient = gradient }
    world:water { level = own.at.y + own.height + 0.1, density = 1000, expansion = 0.21e-3, expansion_from = from, viscosity = 0.01 }
  end)

core.parts = { part = part, add_body = add_body, add_joint = add_joint, directed = directed, UP = UP }
core.use "parts_moving"

setmetatable(parts, {
  __index = function(_, key) core.unknown("digbox.parts", "has no part", tostring(key), parts) end,
  __newindex = function(_, key) core.fail("digbox.parts.%s cannot be assigned", tostring(key)) end,
  __metatable = false,
})
digbox.parts = parts

return true
