-- digbox/parts_moving.lua - ready-made things with limbs and wheels: ragdoll, truck.

local core = ...
local ipairs = ipairs

local soft = core.soft
local part, add_body, add_joint = core.parts.part, core.parts.add_body, core.parts.add_joint
local UP, directed = core.parts.UP, core.parts.directed
local shapes = core.shapes

-- ---- ragdoll ----

-- Heights of joints and lengths of segments over the height of the body, masses of segments over its mass: winter2009, figures and
-- table 4.1. Hand counts with the forearm, foot with the shin. The radii are ours.
local KNEE, HIP, SHOULDER, CHIN = 0.285, 0.530, 0.818, 0.870
local BESIDE = { arm = 0.129, leg = 0.0955 }           -- of shoulder and hip, from the middle
local SHARE = { head = 0.081, trunk = 0.497, upper_arm = 0.028, forearm = 0.022, thigh = 0.100, shin = 0.061 }
local LIMBS = {             -- name, above which joint, its top, length, radius, all over the height; the joint's limits
  { "upper_arm", "shoulder", "arm", SHOULDER, 0.186, 0.026, swing = 2.6, twist = { -1.4, 1.4 }, on = "trunk" },
  { "forearm", "elbow", "arm", SHOULDER - 0.186, 0.254, 0.020, limits = { 0, 2.5 }, on = "upper_arm" },
  { "thigh", "hip", "leg", HIP, HIP - KNEE, 0.042, swing = 1.5, twist = { -0.7, 0.7 }, on = "trunk" },
  { "shin", "knee", "leg", KNEE, KNEE, 0.030, limits = { -2.4, 0 }, on = "thigh" } }

local function add_limb(self, own, side, limb, across)
  local h, key, joint = own.height, side .. "_" .. limb[1], side .. "_" .. limb[2]
  local top = own.at + UP * (limb[4] * h) + across * ((side == "right" and 1 or -1) * BESIDE[limb[3]] * h)
  local length, radius = limb[5] * h, limb[6] * h
  local body = add_body(self, key, "capsule", { radius = radius, length = length - 2 * radius, at = top - UP * (length / 2),
    mass = SHARE[limb[1]] * own.mass, rotation = soft.frame(own.along, UP), group = self.group, friction = own.rubs, restitution = 0 })
  local on = self.body[limb.on] or self.body[side .. "_" .. limb.on]
  if limb.limits then
    add_joint(self, joint, "hinge", { a = body, b = on, at = top, axis = across, limits = limb.limits, friction = own.friction })
  else
    add_joint(self, joint, "ball_joint", { a = body, b = on, at = top, axis = -UP, swing = limb.swing, twist = limb.twist,
      friction = own.friction })
  end
end

local ragdoll_properties = { trunk = { "body", "from hips to shoulders" }, head = { "body", "with the neck" },
  neck = { "joint", "of head and trunk" }, mass = { "number", "all of it", unit = "kg", get = soft.mass },
  position = { "vector", "its centre of mass", unit = "m", get = soft.position } }
for _, side in ipairs { "left", "right" } do
  for _, limb in ipairs(LIMBS) do
    ragdoll_properties[side .. "_" .. limb[1]] = { "body", "a limb" }
    ragdoll_properties[side .. "_" .. limb[2]] = { "joint", "above that limb" }
  end
end

-- parts.ragdoll(world, {at = the ground between its feet, along = which way it looks, height = 1.75, mass = 75}) -> ragdoll
part("ragdoll", "A limp figure of ten pieces that stands at first. Its pieces do not touch each other.", core.join_fields(directed, {
  height = { "real m >0", "of it", default = 1.75 }, mass = { "real kg >0", "of it", default = 75 },
  friction = { "real N*m >=0", "of each of its joints", default = 2 }, rubs = { "real 1 >=0", "friction of its skin", default = 0.6 } }),
  ragdoll_properties, {}, {}, function(self, own)
    local h, m, turn = own.height, own.mass, soft.frame(own.along, UP)
    local across = own.along:cross(UP)
    self.group = soft.group(self.world)
    add_body(self, "trunk", "box", { size = { 0.11 * h, (SHOULDER - HIP) * h, 0.17 * h }, at = own.at + UP * ((SHOULDER + HIP) / 2 * h),
      mass = SHARE.trunk * m, rotation = turn, group = self.group, friction = own.rubs, restitution = 0 })
    local r = (1 - CHIN) / 2 * h
    add_body(self, "head", "ball", { radius = r, at = own.at + UP * (h - r), mass = SHARE.head * m, rotation = turn, group = self.group,
      friction = own.rubs, restitution = 0 })
    add_joint(self, "neck", "ball_joint", { a = self.body.head, b = self.body.trunk, at = own.at + UP * (SHOULDER * h), axis = UP,
      swing = 0.8, twist = { -1.2, 1.2 }, friction = own.friction })
    for _, side in ipairs { "left", "right" } do
      for _, limb in ipairs(LIMBS) do add_limb(self, own, side, limb, across) end
    end
  end)

-- ---- truck ----

local WHEELS = { "front_left", "front_right", "rear_left", "rear_right" }
local SAG = 0.06                    -- m, by which its own weight presses its springs
local DAMPING = 0.35                -- of critical, of a quarter of it on one spring

local truck_methods = {}

local function turn_wheels(thing, speed, rear, front)
  for _, key in ipairs(WHEELS) do
    local joint = thing[1].joint[key]
    if joint.valid then
      joint:set { motor = { speed = speed / thing[1].radius, max_torque = key:find "rear" and rear or front } }
    end
  end
  return thing
end

function truck_methods.drive(thing, speed)
  return turn_wheels(thing, core.quantity(speed, "m/s", "truck:drive"), thing[1].torque, 0)
end

function truck_methods.brake(thing) return turn_wheels(thing, 0, thing[1].brake, thing[1].brake) end
function truck_methods.coast(thing) return turn_wheels(thing, 0, 0, 0) end

core.declare("truck:drive", { "Its rear wheels turn for that speed, as far as their torque goes.", takes = { { "speed", "real m/s",
  "forwards" } }, gives = "truck" })
core.declare("truck:brake", { "Stops all its wheels.", gives = "truck" })
core.declare("truck:coast", { "Lets its wheels roll.", gives = "truck" })

-- A floor with boards around it and a cabin in front; the cabin is a shell, so it is made of its walls.
local function chassis_parts(l, w, above)
  local box, board, cab = shapes.box, 0.05, 0.25 * l
  local bed, middle = l - cab, -cab / 2
  return { box { size = { l, 0.25, w }, at = { 0, 0, 0 } },
    box { size = { bed, 0.4, board }, at = { middle, 0.325, (w - board) / 2 } },
    box { size = { bed, 0.4, board }, at = { middle, 0.325, (board - w) / 2 } },
    box { size = { board, 0.4, w - 2 * board }, at = { (board - l) / 2, 0.325, 0 } },
    box { size = { board, above, w }, at = { l / 2 - cab + board / 2, 0.125 + above / 2, 0 } },
    box { size = { board, above, w }, at = { (l - board) / 2, 0.125 + above / 2, 0 } },
    box { size = { cab, board, w }, at = { (l - cab) / 2, 0.125 + above + board / 2, 0 } } }
end

local function add_wheel(self, own, key, at, chassis)
  local load = own.mass * #self.world.gravity / 4
  local k = math.max(load, own.mass) / SAG
  local wheel = add_body(self, key .. "_wheel", "cylinder", { radius = own.radius, height = 0.25, mass = own.wheel_mass, at = at,
    rotation = core.quat { from = { 0, 1, 0 }, to = UP:cross(own.along) }, friction = own.grip, restitution = 0,
    colour = { 0.03, 0.03, 0.03 } })
  add_joint(self, key, "wheel", { a = wheel, b = chassis, at = at, axis = UP, spin_axis = UP:cross(own.along), limits = { -0.15, 0.15 },
    spring = { stiffness = k, damping = 2 * DAMPING * math.sqrt(k * own.mass / 4), rest = -load / k },
    motor = { speed = 0, max_torque = 0 } })
end

local truck_properties = { chassis = { "body", "with the cabin and the bed" },
  bed = { "vector", "middle of the bed's floor, where a load goes", unit = "m", get = function(self)
    local c = self.body.chassis
    return c.position + c.rotation:rotate(core.vec(-self.length / 8, 0.125, 0))
  end },
  speed = { "number", "forwards", unit = "m/s", get = function(self)
    local c = self.body.chassis
    return c.velocity:dot(c.rotation:rotate { 1, 0, 0 })
  end } }
for _, key in ipairs(WHEELS) do
  truck_properties[key] = { "joint", "spring and axle of that wheel" }
  truck_properties[key .. "_wheel"] = { "body", "a wheel" }
end

-- parts.truck(world, {at = the ground below its middle, along = where it drives, ...}) -> truck
part("truck", "Four sprung wheels, the rear ones driven, a cabin and an open bed. It does not steer.", core.join_fields(directed, {
  length = { "real m >0", "of it", default = 4.8 }, width = { "real m >0", "of it", default = 2 },
  radius = { "real m >0", "of its wheels", default = 0.4 }, mass = { "real kg >0", "without wheels", default = 2400 },
  wheel_mass = { "real kg >0", "of one wheel", default = 60 }, torque = { "real N*m >0", "on each rear wheel, at most", default = 900 },
  brake = { "real N*m >0", "on each wheel, at most", default = 2000 }, grip = { "real 1 >=0", "friction of its tyres", default = 0.9 } }),
  truck_properties, truck_methods, { "length", "radius", "torque", "brake" }, function(self, own)
    local l, w, r = own.length, own.width, own.radius
    if l < 6 * r or w < 1 then core.fail("parts.truck: length = %g m, width = %g m, must be at least 6 wheel radii, and 1 m", l, w) end
    local side = own.along:cross(UP)
    self.length, self.radius, self.torque, self.brake = l, r, own.torque, own.brake
    local chassis = add_body(self, "chassis", "body", { parts = chassis_parts(l, w, 1.2), mass = own.mass,
      rotation = soft.frame(own.along, UP), at = own.at + UP * (2 * r + 0.05), restitution = 0,
      colour = { 0.5, 0.1, 0.05 } })
    for _, key in ipairs(WHEELS) do
      local fore, right = key:find "front" and 1 or -1, key:find "right" and 1 or -1
      add_wheel(self, own, key, own.at + UP * r + own.along * (fore * (l / 2 - 1.6 * r)) + side * (right * (w / 2 - 0.125)), chassis)
    end
  end)

return true
