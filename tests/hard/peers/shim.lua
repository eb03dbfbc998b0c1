-- tests/hard/peers/shim.lua - as much of digbox's Lua interface as the hard cases use, on a world of another engine.
--
--   package.preload["digbox"] = function() return require("shim")(core_module) end
--
-- A case cannot tell: it builds, watches and judges as it does with digbox. What an engine does not tell (work of motors, its own
-- verdict) is 0 here, and run.lua leaves the criteria out that need it.

-- ---- vectors and quaternions ----

local Vec, Quat = {}, {}
local function vec(x, y, z)
  if type(x) == "table" then
    if getmetatable(x) == Vec then return x end
    x, y, z = x[1], x[2], x[3]
  end
  return setmetatable({ x = x or 0, y = y or 0, z = z or 0 }, Vec)
end
Vec.__add = function(a, b) a, b = vec(a), vec(b) return vec(a.x + b.x, a.y + b.y, a.z + b.z) end
Vec.__sub = function(a, b) a, b = vec(a), vec(b) return vec(a.x - b.x, a.y - b.y, a.z - b.z) end
Vec.__unm = function(a) return vec(-a.x, -a.y, -a.z) end
Vec.__len = function(a) return math.sqrt(a.x * a.x + a.y * a.y + a.z * a.z) end
Vec.__div = function(a, s) return vec(a.x / s, a.y / s, a.z / s) end
Vec.__mul = function(a, b)
  if type(a) == "number" then a, b = b, a end
  return vec(a.x * b, a.y * b, a.z * b)
end
local vec_methods = {}
function vec_methods.dot(a, b) b = vec(b) return a.x * b.x + a.y * b.y + a.z * b.z end
function vec_methods.cross(a, b)
  b = vec(b)
  return vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
end
function vec_methods.normalized(a) return a / #a end
Vec.__index = function(a, key)
  if type(key) == "number" then return rawget(a, ("xyz"):sub(key, key)) end
  return vec_methods[key]
end

-- rad  of a number, or of text: "20 deg", "0.3 rad"
local function radians(angle)
  if type(angle) == "number" then return angle end
  local number, unit = angle:match "^%s*([-+%w.]+)%s+(%a+)%s*$"
  local each = unit == "rad" and 1 or unit == "deg" and math.pi / 180
  return assert(tonumber(number) and each and tonumber(number) * each, "no angle: " .. angle)
end

local function quat(w, x, y, z)
  if type(w) == "table" then
    if getmetatable(w) == Quat then return w end
    local axis, half = vec(w.axis):normalized(), radians(w.angle) / 2
    local s = math.sin(half)
    w, x, y, z = math.cos(half), axis.x * s, axis.y * s, axis.z * s
  end
  return setmetatable({ w = w or 1, x = x or 0, y = y or 0, z = z or 0 }, Quat)
end
Quat.__mul = function(p, q)
  return quat(p.w * q.w - p.x * q.x - p.y * q.y - p.z * q.z, p.w * q.x + p.x * q.w + p.y * q.z - p.z * q.y,
    p.w * q.y - p.x * q.z + p.y * q.w + p.z * q.x, p.w * q.z + p.x * q.y - p.y * q.x + p.z * q.w)
end
Quat.__index = {
  rotate = function(q, v)
    v = vec(v)
    local u = vec(q.x, q.y, q.z)
    local t = u:cross(v) * 2
    return v + t * q.w + u:cross(t)
  end,
}

local function list(v)
  v = vec(v)
  return { v.x, v.y, v.z }
end

-- ---- bodies ----

local Body = {}
local kinds = { sphere = 0, box = 1, cylinder = 2, hull = 3, plane = 4 }

local function body_state(b) return b.world.core:state(b.index) end
local fields = {
  position = function(b)
    local x, y, z = body_state(b)
    return vec(x, y, z)
  end,
  rotation = function(b) return quat(select(4, body_state(b))) end,
  velocity = function(b) return vec(select(8, body_state(b))) end,
  spin = function(b) return vec(select(11, body_state(b))) end,
  speed = function(b)
    local x, y, z = select(8, body_state(b))
    return math.sqrt(x * x + y * y + z * z)
  end,
}
local body_methods = {}
function body_methods.drive(b, how)
  local v, w = vec(how.velocity), vec(how.spin)
  b.world.core:drive(b.index, v.x, v.y, v.z, w.x, w.y, w.z)
end
function body_methods.remove(b)
  b.world.core:remove(b.index)
  for i, other in ipairs(b.world.all) do
    if other == b then table.remove(b.world.all, i) end
  end
end
function body_methods.hit(b, how) b.world.pushes[#b.world.pushes + 1] = { b.index, vec(how.impulse) } end
function body_methods.links(b)
  local found = {}
  for _, touch in ipairs(b.world.core:touches()) do
    local first, second = b.world.by_index[touch[1]], b.world.by_index[touch[2]]
    if first == b or second == b then
      found[#found + 1] = { a = first, b = second, effort = vec(touch[3], touch[4], touch[5]) }
    end
  end
  return found
end
Body.__index = function(b, key)
  local field = fields[key]
  if field then return field(b) end
  return body_methods[key]
end

local function volume(shape, size)
  if shape == "sphere" then return 4 / 3 * math.pi * size[1] ^ 3 end
  if shape == "box" then return 8 * size[1] * size[2] * size[3] end
  return 2 * math.pi * size[1] ^ 2 * size[2]
end

local function add_body(world, shape, size, f)
  local moves = not f.fixed and not f.kinematic and shape ~= "plane"
  local q = quat(f.rotation or 1)
  local points
  if f.points then
    points = {}
    for _, p in ipairs(f.points) do for _, x in ipairs(list(p)) do points[#points + 1] = x end end
  end
  local mass = moves and shape ~= "hull" and (f.mass or (f.density or 1000) * volume(shape, size)) or 0
  local index, got = world.core:body {
    kind = kinds[shape], size = size, offset = f.offset, mass = mass, density = f.density or 1000, points = points,
    at = list(f.at), turn = { q.w, q.x, q.y, q.z }, v = list(f.velocity), spin = list(f.spin), friction = f.friction or 0.5,
    rolling = (f.rolling_friction or 0) * (size[1] or 0), restitution = f.restitution, group = f.group and -f.group or 0,
    ghost = f.collides == false, driven = f.kinematic,
  }
  local body = setmetatable({ world = world, index = index, name = f.name, mass = got,
                              kind = moves and "dynamic" or f.kinematic and "kinematic" or "static" }, Body)
  world.by_index[index] = body
  if shape ~= "plane" then world.all[#world.all + 1] = body end
  return body
end

-- ---- joints ----

local Joint = {}
Joint.__index = function(j, key)
  if key == "error" then return (j.world.core:joint_state(j.index)) end
  if key == "angle" then return (select(2, j.world.core:joint_state(j.index))) end
  if key == "force" then return vec(j.world.core:joint_force(j.index)) end
end

local function add_joint(world, kind, f)
  local limits, motor = f.limits, f.motor or { speed = 0, max_torque = f.friction }     -- a motor that holds still rubs
  local at = f.at or (f.a and kind ~= "slider" and f.a.position) or f.a.position
  local index = world.core:joint {
    kind = kind, a = f.a.index, b = f.b and f.b.index or -1, at = list(at), at_b = f.at_b and list(f.at_b) or nil,
    axis = list(vec(f.axis or f.along or { 0, 0, 1 }):normalized()), length = f.length, stiffness = f.stiffness, damping = f.damping,
    limited = limits ~= nil, lower = limits and limits[1], upper = limits and limits[2], motor_speed = motor.speed,
    motor_torque = motor.max_torque,
  }
  return setmetatable({ world = world, index = index }, Joint)
end

-- ---- the world ----

local World = {}
local makes = {
  floor = function(w, f) return add_body(w, "plane", { 0, 1, 0 }, f or {}) end,
  plane = function(w, f) return add_body(w, "plane", list(vec(f.normal):normalized()), f) end,
  ball = function(w, f) return add_body(w, "sphere", { f.radius }, f) end,
  box = function(w, f)
    local s = type(f.size) == "number" and vec(f.size, f.size, f.size) or vec(f.size)
    return add_body(w, "box", { s.x / 2, s.y / 2, s.z / 2 }, f)
  end,
  cylinder = function(w, f) return add_body(w, "cylinder", { f.radius, f.height / 2 }, f) end,
  hull = function(w, f) return add_body(w, "hull", {}, f) end,
  ball_joint = function(w, f) return add_joint(w, 0, f) end,
  hinge = function(w, f) return add_joint(w, 1, f) end,
  slider = function(w, f) return add_joint(w, 2, f) end,
  spring = function(w, f)
    f = setmetatable({ at = f.at_a or f.a.position, at_b = f.at_b or f.b.position }, { __index = f })
    if f.b then f.at_b = f.b.position end
    return add_joint(w, 3, f)
  end,
}
makes.sphere = makes.ball

function makes.step(w)
  local core = w.core
  if w.steps == 0 then core:open() end
  for _, push in ipairs(w.pushes) do core:push(push[1], push[2].x, push[2].y, push[2].z) end
  w.pushes = {}
  core:step()
  w.steps = w.steps + 1
  w.time = w.steps * w.frame
end
function makes.bodies(w) return w.all end
function makes.stats(w) return w.figures end
function makes.checksum() return 0 end
function makes.render() end
function makes.close(w) w.core:close() end

local world_fields = {
  energy = function(w)
    local kinetic, potential, elastic = w.core:totals()
    local total = kinetic + potential + elastic
    return { kinetic = kinetic, potential = potential, elastic = elastic, total = total, work_in = 0, numerical = 0 }
  end,
  momentum = function(w) return vec(select(4, w.core:totals())) end,
  angular_momentum = function(w) return vec(select(7, w.core:totals())) end,
}
World.__index = function(w, key)
  local field = world_fields[key]
  if field then return field(w) end
  return makes[key]
end

-- What digbox says of itself; of these only the penetration is measured, when it is asked for
local figure_mt = {
  __index = function(figures, key)
    if key == "penetration" or key == "worst_penetration" then return figures.world.core:penetration() end
    return 0
  end,
}

return function(module)
  local digbox = { vec = vec, quat = quat }
  function digbox.world(f)
    local g = vec(f.gravity or { 0, -9.81, 0 })
    local world = { core = module.world(f.step or 1 / 60, g.x, g.y, g.z), frame = f.step or 1 / 60, gravity = g, time = 0, steps = 0,
                    all = {}, by_index = {}, pushes = {} }
    world.figures = setmetatable({ world = world, gave_up_why = "" }, figure_mt)
    return setmetatable(world, World)
  end
  return digbox
end
