-- parts.lua: small scenes that call for some effects each, alone or far apart in one world. What they call for is asked of
-- world:effects(); what takes part in none of the world's gravity has gravity_scale = 0.
local digbox = require "digbox"

local function ball(world, at, fields)
  local all = { radius = 0.1, at = at, gravity_scale = 0, friction = 0 }
  for k, v in pairs(fields or {}) do all[k] = v end
  return world:ball(all)
end

local function plate(world, at, fields)
  local all = { size = { 4, 0.2, 4 }, at = at, fixed = true, friction = 0 }
  for k, v in pairs(fields or {}) do all[k] = v end
  return world:box(all)
end

local parts = {}

function parts.flight(world, o)                -- nothing at all
  return { world:box { size = { 0.1, 0.2, 0.3 }, at = o, gravity_scale = 0, velocity = { 0.1, 0, 0 }, spin = { 1, 2, 3 } } }
end

function parts.fall(world, o)                  -- gravity
  return { ball(world, o, { gravity_scale = 1, velocity = { 0.3, 2, 0 } }) }
end

function parts.cradle(world, o)                -- contact without friction or gravity
  local list = {}
  for i = 1, 4 do
    list[i] = ball(world, o + digbox.vec(0.25 * i, 0, 0), { restitution = 1, velocity = { i == 1 and 1 or 0, 0, 0 } })
  end
  return list
end

function parts.bounce(world, o)                -- gravity, contact
  plate(world, o)
  return { ball(world, o + digbox.vec(0, 1, 0), { gravity_scale = 1, restitution = 0.7 }) }
end

function parts.slide(world, o)                 -- gravity, contact, friction
  plate(world, o, { friction = 0.3 })
  return { world:box { size = 0.2, at = o + digbox.vec(0, 0.2, 0), friction = 0.3, velocity = { 1, 0, 0.2 } } }
end

function parts.stack(world, o)
  local list = {}
  plate(world, o, { friction = 0.5 })
  for i = 1, 5 do
    list[i] = world:box { size = 0.2, at = o + digbox.vec(0.01 * (i % 2), 0.2 * i, 0), friction = 0.5,
      rotation = digbox.quat { axis = { 0, 1, 0 }, angle = 0.2 * i } }
  end
  return list
end

function parts.roll(world, o)                  -- and rolling
  plate(world, o, { friction = 0.5, rolling_friction = 0.01 })
  return { ball(world, o + digbox.vec(-1, 0.2, 0), { gravity_scale = 1, friction = 0.5, rolling_friction = 0.01, velocity = { 1, 0, 0 } }) }
end

function parts.pendulum(world, o)              -- gravity, joints
  local bob = ball(world, o + digbox.vec(0.5, 0, 0), { gravity_scale = 1 })
  world:hinge { a = bob, at = o, axis = { 0, 0, 1 } }
  return { bob }
end

function parts.spring(world, o)                -- joints
  local a, b = ball(world, o), ball(world, o + digbox.vec(1, 0, 0))
  world:spring { a = a, b = b, at = o, at_b = o + digbox.vec(1, 0, 0), stiffness = 30, length = 0.8 }
  return { a, b }
end

function parts.push(world, o)                  -- push
  local b = ball(world, o)
  b:push { force = { 0.5, 0.1, 0 }, lasts = 1 }
  return { b }
end

function parts.region(world, o)                -- region
  world:region { sphere = { radius = 3 }, at = o, laws = { drag = 0.5 } }
  return { ball(world, o, { velocity = { 0.5, 0, 0 } }) }
end

function parts.drag(world, o)                  -- drag
  return { ball(world, o, { drag_coefficient = 0.5, velocity = { 5, 0, 0 } }) }
end

function parts.float(world, o)                 -- buoyancy, gravity; the water ends 3 m away
  world:water { level = 0, at = o, size = { 6, 6, 6 } }
  return { ball(world, o, { gravity_scale = 1, density = 600 }) }
end

function parts.warm(world, o)                  -- heat, contact
  plate(world, o, { temperature = 290 })
  return { world:box { size = 0.2, at = o + digbox.vec(0, 0.2, 0), temperature = 400, convection = 10, friction = 0 } }
end

function parts.own(world, o)                   -- an effect of the script
  local b = ball(world, o)
  world:add_effect { name = "own " .. tostring(o.x), bodies = { b }, step = function(_, bodies)
    bodies[1].force = o + digbox.vec(0.1, 0, 0) - bodies[1].position
  end }
  return { b }
end

local names = {}
for name in pairs(parts) do names[#names + 1] = name end
table.sort(names)

local function temperature_of(body)
  local there, value = pcall(function() return body.temperature end)     -- not in a build without heat
  return there and value or 0
end

-- All digits of the motion and temperature of bodies.
local function state_of(bodies)
  local text = {}
  for i, b in ipairs(bodies) do
    local x, q, v, w = b.position, b.rotation, b.velocity, b.spin
    text[i] = ("%a %a %a %a %a %a %a %a %a %a %a %a %a %a %s"):format(x.x, x.y, x.z, q.x, q.y, q.z, q.w, v.x, v.y, v.z, w.x, w.y, w.z,
      temperature_of(b), tostring(b.asleep))
  end
  return table.concat(text, "\n")
end

return { build = parts, names = names, state_of = state_of }
