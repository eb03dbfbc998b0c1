-- tests/hard/random_machines.lua - random worlds of what people build: some of bridges, carts, cranes, figures, heaps, ..., from a seed.
--
-- Each is drawn with its own sizes, masses, speeds and torques, in a place of its own; now and then a ball of up to three tons is shot
-- through all of them. Motors and movers drive some, so energy may rise, but never but by what they give.
local digbox = require "digbox"

local SIDEWAYS = { axis = { 0, 0, 1 }, angle = "90 deg" }
local ACROSS = { axis = { 1, 0, 0 }, angle = "90 deg" }

local parts = {}

function parts.chain(p, world, x, z)
  local links, mass, length, before = p.int(3, 20), p.decades(-1, 0.5), p.of { 0.1, 0.2, 0.3 }, nil
  local y, along = links * length + p.between(0.5, 2), p.of { true, false }
  local function at(far) return along and { x + far, y, z } or { x, y - far, z } end
  for i = 1, links do
    local link = world:capsule { radius = 0.03, length = length - 0.06, mass = mass, at = at((i - 0.5) * length),
      rotation = along and SIDEWAYS or nil }
    world[p.of { "ball_joint", "hinge" }](world, { a = link, b = before, at = at((i - 1) * length) })
    before = link
  end
  local bob = world:ball { radius = 0.2, mass = mass * p.decades(0, 3), at = at(links * length + 0.2) }
  world:ball_joint { a = bob, b = before, at = at(links * length) }
end

function parts.rope(p, world, x, z)
  local crate = world:box { size = 0.5, mass = p.decades(0, 3), at = { x + p.between(0, 1), p.between(0.3, 2), z } }
  world:rope { a = crate, to = { x, 3.5, z }, length = p.between(3.5, 4.5), segments = p.int(6, 24) }
end

function parts.two_on_a_rope(p, world, x, z)
  local mass = p.decades(0, 2)
  local left = world:box { size = 0.3, mass = mass, at = { x, 2.4, z } }
  local right = world:box { size = 0.3, mass = mass * p.decades(-1, 1), at = { x + 1.2, 2.4, z } }
  world:rope { a = left, b = right, segments = 20, length = 3 }
end

function parts.bridge(p, world, x, z)
  local planks, mass, y = p.int(4, 14), p.decades(0, 1.5), p.between(0.6, 2)
  local before = world:box { fixed = true, size = { 0.4, y, 1 }, at = { x - 0.2, y / 2, z } }
  for i = 1, planks + 1 do
    local last = i > planks
    local next_ = last and world:box { fixed = true, size = { 0.4, y, 1 }, at = { x + 0.3 * planks + 0.2, y / 2, z } } or
      world:box { size = { 0.28, 0.06, 0.9 }, mass = mass, at = { x + 0.3 * i - 0.15, y, z } }
    world:hinge { a = next_, b = before, at = { x + 0.3 * (i - 1), y, z }, axis = { 0, 0, 1 } }
    before = next_
  end
  for i = 1, p.int(1, 3) do
    world:box { size = p.between(0.2, 0.5), mass = mass * p.decades(0, 2), at = { x + p.between(0.3, 0.3 * planks - 0.3), y + 0.7 * i, z } }
  end
end

function parts.tower(p, world, x, z)
  local y, mass, grows = 0, p.decades(-0.5, 1), p.of { 1, 1, 1.3, 0.7 }
  for i = 1, p.int(4, 14) do
    local high, size = p.between(0.1, 0.35), p.between(0.2, 0.5)
    local fields = { at = { x + p.between(-0.02, 0.02), y + high / 2, z + p.between(-0.02, 0.02) }, mass = mass * grows ^ i,
      friction = p.between(0.2, 0.8) }
    if p.of { true, false } then
      fields.size = { size, high, p.between(0.2, 0.5) }
      world:box(fields)
    else
      fields.radius, fields.height = size / 2, high
      world:cylinder(fields)
    end
    y = y + high
  end
end

function parts.wall(p, world, x, z)
  local columns = p.int(3, 6)
  for row = 0, p.int(3, 6) - 1 do
    for column = 0, columns - 1 do
      local at = { x + column * 0.41 + (row % 2) * 0.2, 0.1 + row * 0.2, z }
      world:box { size = { 0.4, 0.2, 0.2 }, material = p.of { "brick", "oak" }, at = at }
    end
  end
end

function parts.arm(p, world, x, z)
  local mass, y = p.decades(0, 2), p.between(1.3, 2)
  local arm = world:box { size = { 2, 0.15, 0.15 }, mass = mass, at = { x + 1, y, z } }
  world:hinge { a = arm, at = { x, y, z }, axis = p.of { { 0, 1, 0 }, { 0, 0, 1 } },
    motor = { speed = p.between(-6, 6), max_torque = p.decades(1, 4) }, limits = p.of { { -1.5, 1.5 }, false } or nil }
  if p.of { true, false } then
    local tip = world:ball { radius = 0.2, mass = mass * p.decades(-1, 2), at = { x + 2.3, y, z } }
    world[p.of { "weld", "ball_joint", "rope" }](world, { a = tip, b = arm })
  end
end

function parts.cart(p, world, x, z)
  local mass, speed = p.decades(0.5, 2.5), p.between(-15, 15)
  local chassis, torque = world:box { size = { 1.4, 0.2, 0.7 }, mass = mass, at = { x + 0.7, 0.5, z } }, mass * p.decades(-0.5, 1)
  for _, corner in ipairs { { -0.5, -1 }, { -0.5, 1 }, { 0.5, -1 }, { 0.5, 1 } } do
    local wheel = world:cylinder { radius = 0.25, height = 0.12, mass = 0.05 * mass, friction = 1, rotation = ACROSS,
      at = { x + 0.7 + corner[1], 0.25, z + 0.45 * corner[2] } }
    world:hinge { a = wheel, b = chassis, at = wheel.position, axis = { 0, 0, 1 },
      motor = corner[1] < 0 and { speed = speed, max_torque = torque } or nil }
  end
  if p.of { true, false } then world:box { size = 0.4, mass = mass * p.decades(-1, 1), at = { x + 0.7, 0.85, z } } end
end

function parts.figures(p, world, x, z)
  for i = 1, p.int(1, 3) do digbox.parts.ragdoll(world, { at = { x, p.between(-1.4, 0) + 1.9 * i, z } }) end
end

function parts.heap(p, world, x, z)
  local size, bounce = p.between(0.08, 0.25), p.of { 0, 0, 0.5 }
  for i = 0, p.int(8, 60) - 1 do
    local step = 2.2 * size
    local fields = { at = { x + (i % 3) * step, 0.4 + (i // 9) * step, z + ((i // 3) % 3) * step }, density = p.decades(2, 4),
      restitution = bounce, friction = p.between(0, 1) }
    local shape = p.of { "ball", "box", "capsule", "cylinder" }
    if shape == "ball" then fields.radius = size * p.between(0.4, 1)
    elseif shape == "box" then fields.size = { size * p.between(0.3, 1.4), size * p.between(0.3, 1.4), size * p.between(0.3, 1.4) }
    elseif shape == "capsule" then fields.radius, fields.length = size * p.between(0.2, 0.5), size * p.between(0.3, 1)
    else fields.radius, fields.height = size * p.between(0.3, 0.9), size * p.between(0.2, 1.4) end
    world[shape](world, fields)
  end
end

function parts.springs(p, world, x, z)
  local before
  for i = 1, p.int(2, 6) do
    local ball = world:ball { radius = 0.12, mass = p.decades(-1, 1.5), at = { x + 0.1 * i, 3.5 - 0.5 * i, z } }
    world:spring { a = ball, b = before, at_b = not before and { x, 3.5, z } or nil, stiffness = p.decades(1.5, 5),
      damping = p.of { 0, p.decades(-1, 2) } }
    before = ball
  end
end

function parts.crank(p, world, x, z)
  local mass = p.decades(-0.5, 1)
  local crank = world:box { size = { 0.3, 0.06, 0.06 }, mass = mass, at = { x + 0.15, 1, z }, collides = false }
  local rod = world:box { size = { 1, 0.06, 0.06 }, mass = mass * p.decades(-1, 1), at = { x + 0.8, 1, z }, collides = false }
  local piston = world:box { size = 0.3, mass = mass * p.decades(-1, 2), at = { x + 1.3, 1, z } }
  world:hinge { a = crank, at = { x, 1, z }, axis = { 0, 0, 1 }, motor = { speed = p.between(1, 20), max_torque = p.decades(1, 3.5) } }
  world:hinge { a = crank, b = rod, at = { x + 0.3, 1, z }, axis = { 0, 0, 1 } }
  world:ball_joint { a = rod, b = piston, at = { x + 1.3, 1, z } }
  world:slider { a = piston, along = { 1, 0, 0 } }
end

function parts.door(p, world, x, z, later)
  local door = world:box { size = { 1, 2, 0.05 }, mass = p.decades(0.5, 2), at = { x + 0.5, 1.02, z } }
  world:hinge { a = door, at = { x, 1, z }, axis = { 0, 1, 0 }, limits = { 0, 1.6 }, friction = p.of { 0, p.decades(-1, 1) } }
  later[#later + 1] = { every = 2, act = function()
    door:hit { impulse = { 0, 0, p.between(-30, 30) }, at = door.position + digbox.vec(0.4, 0, 0) }
  end }
end

function parts.lift(p, world, x, z)
  local mass = p.decades(0.5, 2.5)
  local lift = world:box { size = { 1, 0.1, 1 }, mass = mass, at = { x, 0.5, z } }
  world:slider { a = lift, along = { 0, 1, 0 }, limits = { 0, 2 },
    motor = { speed = p.between(0.2, 2), max_force = mass * p.decades(0.9, 2) } }
  world:ball { radius = 0.2, mass = mass * p.decades(-2, 0.3), at = { x, 0.8, z } }
end

function parts.gears(p, world, x, z)
  local before, radius
  for i = 1, p.int(2, 4) do
    local own = p.between(0.15, 0.4)
    x = x + (radius and radius + own + 0.01 or 0)
    local wheel = world:cylinder { radius = own, height = 0.1, density = p.decades(2.5, 4), at = { x, 2, z }, rotation = ACROSS }
    local hinge = world:hinge { a = wheel, at = wheel.position, axis = { 0, 0, 1 },
      motor = i == 1 and { speed = p.between(-10, 10), max_torque = p.decades(0, 3) } or nil }
    if before then world:gear { a = before, b = hinge, ratio = { radius, own } } end
    before, radius = hinge, own
  end
end

function parts.beam_that_breaks(p, world, x, z)
  local before
  for i = 1, p.int(3, 8) do
    local piece = world:box { size = { 0.3, 0.1, 0.1 }, density = p.decades(2.5, 4), at = { x + 0.3 * i, 2, z } }
    world:weld { a = piece, b = before, at = { x + 0.3 * i - 0.15, 2, z }, breaks_at = p.decades(1.5, 4) }
    before = piece
  end
end

function parts.bucket(p, world, x, z)
  world:bucket { at = { x, 0, z }, height = 0.5, top_radius = 0.35, bottom_radius = 0.25, mass = p.decades(-0.5, 1) }
  for i = 1, p.int(3, 25) do
    world:ball { radius = p.between(0.03, 0.08), density = p.decades(2.5, 4), at = { x + p.between(-0.1, 0.1), 0.5 + 0.17 * i, z } }
  end
end

function parts.shot(p, world, _, _, later)
  local at, mass, radius, speed, turn = p.between(0.5, 3), p.decades(0, 3.5), p.between(0.1, 0.5), p.between(5, 40), p.between(0, 6.28)
  local along = digbox.vec(math.cos(turn), 0, math.sin(turn))
  later[#later + 1] = { every = at, act = function(k)
    if k == 1 then world:ball { radius = radius, mass = mass, at = digbox.vec(0, 1.2, 0) - along * 7, velocity = along * speed } end
  end }
end

local function ground(p, world)
  world:floor { friction = p.between(0.2, 1) }
  for _, n in ipairs { { 1, 0 }, { -1, 0 }, { 0, 1 }, { 0, -1 } } do world:plane { normal = { n[1], 0, n[2] }, offset = -8 } end
end

return require "random_parts".kind {
  name = "machines", parts = parts, ground = ground, fewest = 2, most = 5, half = 8, depth = 0, potential = 0.3, made = 0.5,
  where = function(k) return -6 + ((k - 1) % 2) * 7, -5.5 + ((k - 1) // 2) * 3.5 end,
}
