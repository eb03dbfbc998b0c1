-- tests/hard/random_rooms.lua - random rooms of what stands about in them, from a seed: tables and what lies on them, stools in a stack,
-- shelves of books, bottles, bowls of stones, ladders, seesaws, a ramp, a lift, a drum, ... on a floor, a slab, triangles or hills.
--
-- Shapes that random_world.lua and random_machines.lua have not: cones, hulls, bodies of several shapes, meshes, height fields, and bodies
-- that move as told. Each part is drawn with its own sizes, densities, frictions and bounces; its sizes go with a scale of its own.
local digbox = require "digbox"

local HALF = 7                                         -- m, from the middle of a room to its walls
local SIDEWAYS = { axis = { 0, 0, 1 }, angle = "90 deg" }
local ACROSS = { axis = { 1, 0, 0 }, angle = "90 deg" }
local vec, quat = digbox.vec, digbox.quat

-- What a part is made of: fields that all its bodies share
local function stuff(p)
  return { density = p.decades(2.3, 4), friction = p.of { 0.2, 0.4, 0.6, 1 }, restitution = p.of { 0, 0, 0.3, 0.7 } }
end

local function with(fields, more)
  local all = {}
  for k, v in pairs(fields) do all[k] = v end
  for k, v in pairs(more) do all[k] = v end
  return all
end

local function any_turn(p) return quat { axis = { p.between(-1, 1), 1.01, p.between(-1, 1) }, angle = p.between(-3, 3) } end

-- A stone: the hull of points about an ellipsoid
local function stone(p, size)
  local points = {}
  for i = 1, p.int(6, 20) do
    local v = vec(p.between(-1, 1), p.between(-1, 1), p.between(-1, 1.01)):normalized()
    points[i] = { v.x * size, v.y * size * 0.7, v.z * size * 0.8 }
  end
  return points
end

-- A table of width k whose origin is on the ground between its legs
local function table_parts(k, top, leg)
  local high = 0.5 * k - top / 2
  local parts = { digbox.box { size = { k, top, 0.7 * k }, at = { 0, 0.5 * k, 0 } } }
  for _, c in ipairs { { -1, -1 }, { -1, 1 }, { 1, -1 }, { 1, 1 } } do
    parts[#parts + 1] = digbox.box { size = { leg, high, leg }, at = { c[1] * (0.5 * k - leg), high / 2, c[2] * (0.35 * k - leg) } }
  end
  return parts
end

-- Some thing of about this size
local function thing(p, world, size, at, common)
  local fields = with(common, { at = at, rotation = p.of { any_turn(p), false } or nil })
  local shape = p.of { "box", "ball", "cylinder", "cone", "hull", "capsule", "dumbbell", "egg", "cross" }
  if shape == "box" then fields.size = { size * p.between(0.3, 1), size * p.between(0.3, 1), size * p.between(0.3, 1) }
  elseif shape == "ball" then fields.radius = size / 2
  elseif shape == "cylinder" then fields.radius, fields.height = size * p.between(0.1, 0.5), size * p.between(0.2, 1)
  elseif shape == "cone" then fields.radius, fields.height = size * p.between(0.2, 0.5), size * p.between(0.4, 1)
  elseif shape == "hull" then fields.points = stone(p, size / 2)
  elseif shape == "capsule" then fields.radius, fields.length = size * p.between(0.1, 0.3), size * p.between(0.2, 0.7)
  else
    local r = size * p.between(0.15, 0.25)
    shape, fields.parts = "body", shape == "dumbbell" and { digbox.sphere { radius = r, at = { 0, size / 2 - r, 0 } },
      digbox.sphere { radius = r, at = { 0, r - size / 2, 0 } }, digbox.cylinder { radius = r / 2, height = size - 2 * r } } or
      shape == "egg" and { digbox.sphere { radius = r }, digbox.sphere { radius = 0.7 * r, at = { 0, r, 0 } } } or
      { digbox.box { size = { size, r, r } }, digbox.box { size = { r, size, r } } }
  end
  return world[shape](world, fields)
end

local parts = {}

function parts.laid_table(p, world, at)
  local common, k = stuff(p), p.between(0.6, 1.4)
  world:body(with(common, { parts = table_parts(k, p.between(0.02, 0.06) * k, p.between(0.04, 0.08) * k), at = at }))
  local on = stuff(p)
  for i = 1, p.int(1, 7) do
    thing(p, world, k * p.between(0.08, 0.25), at + vec(p.between(-0.4, 0.4) * k, 0.53 * k + 0.18 * k * i, p.between(-0.25, 0.25) * k), on)
  end
end

function parts.tables_on_tables(p, world, at)
  local common, k = stuff(p), p.between(0.3, 0.9)
  for i = 0, p.int(1, 4) do
    world:body(with(common, { parts = table_parts(k, 0.05 * k, 0.06 * k), at = at + vec(p.between(-0.1, 0.1) * k, (0.53 * k + 0.01) * i, 0),
      rotation = { axis = { 0, 1, 0 }, angle = p.between(-0.3, 0.3) } }))
  end
end

function parts.books(p, world, at)
  local common, k, x = stuff(p), p.between(0.15, 0.5), 0
  world:box { fixed = true, size = { 0.1, k, k }, at = at + vec(-0.05, k / 2, 0) }
  for _ = 1, p.int(3, 12) do
    local thick, high = k * p.between(0.08, 0.3), k * p.between(0.6, 1.1)
    world:box(with(common, { size = { thick, high, 0.7 * k }, at = at + vec(x + thick / 2, high / 2, 0) }))
    x = x + thick + p.of { 0, 0, 0.02 * k }
  end
end

function parts.bottles(p, world, at)
  local common, k = stuff(p), p.between(0.1, 0.4)
  for i = 0, p.int(3, 9) - 1 do
    local r = k * p.between(0.2, 0.35)
    world:body(with(common, { at = at + vec(0.8 * k * (i % 3), k / 2, 0.8 * k * (i // 3)), parts = {
      digbox.cylinder { radius = r, height = k }, digbox.cone { radius = r, height = 0.5 * k, at = { 0, 0.625 * k, 0 } },
      digbox.cylinder { radius = 0.3 * r, height = 0.4 * k, at = { 0, 0.9 * k, 0 } } } }))
  end
  world:ball(with(common, { radius = k * p.between(0.3, 0.6), density = common.density * p.of { 1, 3, 8 },
    at = at + vec(-3 * k, k * p.between(0.6, 1), 0.8 * k * p.int(0, 2)), velocity = { p.between(1, 8), 0, 0 } }))
end

function parts.stones(p, world, at)
  local common, size = stuff(p), p.between(0.05, 0.4)
  for i = 0, p.int(5, 40) - 1 do
    world:hull(with(common, { points = stone(p, size * p.between(0.3, 0.6)), rotation = any_turn(p),
      at = at + vec(1.3 * size * (i % 3), size + 1.3 * size * (i // 9), 1.3 * size * ((i // 3) % 3)) }))
  end
end

function parts.bowl(p, world, at)
  local common, k = stuff(p), p.between(0.2, 0.8)
  world:bucket(with(stuff(p), { at = at, height = k * p.between(0.4, 1), top_radius = 0.6 * k, bottom_radius = k * p.between(0.3, 0.6),
    wall = 0.04 * k }))
  for i = 1, p.int(2, 16) do
    thing(p, world, k * p.between(0.1, 0.4), at + vec(p.between(-0.2, 0.2) * k, k * (0.6 + 0.42 * i), p.between(-0.2, 0.2) * k), common)
  end
end

function parts.plates(p, world, at)
  local common, k = stuff(p), p.between(0.05, 0.3)
  local flat, y = p.between(0.04, 0.3), 0
  for i = 1, p.int(3, 12) do
    local high = flat * k * p.between(0.5, 1)
    world:cylinder(with(common, { radius = k * p.between(0.7, 1), height = high, at = at + vec(p.between(-0.1, 0.1) * k, y + high / 2, 0),
      spin = i == 1 and { 0, p.of { 0, 0, 10 }, 0 } or nil }))
    y = y + high + p.of { 0, 0.1 * k }
  end
end

function parts.ladder(p, world, at)
  local common, k, turn = stuff(p), p.between(1, 3), p.between(0.15, 0.5)
  local leaning = with(common, { friction = 1, parts = { digbox.box { size = { 0.05, k, 0.04 }, at = { 0, 0, -0.2 } },
    digbox.box { size = { 0.05, k, 0.04 }, at = { 0, 0, 0.2 } } } })
  for i = 1, 6 do
    leaning.parts[2 + i] = digbox.cylinder { radius = 0.015, height = 0.4, at = { 0, k * (i - 3.5) / 7, 0 }, rotation = ACROSS }
  end
  local wall = at + vec(0.3, 0, 0)
  world:box { fixed = true, size = { 0.2, 1.2 * k, 1 }, at = wall + vec(-0.1, 0.6 * k, 0), friction = 0.5 }
  leaning.rotation = { axis = { 0, 0, 1 }, angle = turn }
  leaning.at = wall + vec(k / 2 * math.sin(turn) + 0.026, k / 2 * math.cos(turn) + 0.02, 0)
  world:body(leaning)
  if p.of { true, false } then thing(p, world, 0.3, leaning.at + vec(p.between(0, 0.3), 0.6, 0), stuff(p)) end
end

function parts.seesaw(p, world, at)
  local common, k = stuff(p), p.between(0.8, 2.5)
  if p.of { true, false } then
    world:cylinder(with(common, { radius = 0.15, height = 0.6, rotation = ACROSS, at = at + vec(k / 2, 0.15, 0) }))
    world:box(with(common, { size = { k, 0.05, 0.4 }, at = at + vec(k / 2, 0.325, 0) }))
  else
    local plank = world:box(with(common, { size = { k, 0.05, 0.4 }, at = at + vec(k / 2, 0.4, 0) }))
    world:hinge { a = plank, at = at + vec(k / 2, 0.4, 0), axis = { 0, 0, 1 } }
  end
  thing(p, world, 0.25, at + vec(0.1 * k, 0.6, 0), common)
  thing(p, world, 0.3, at + vec(0.9 * k, p.between(0.7, 2.5), 0), stuff(p))
end

function parts.ramp(p, world, at)
  local common, turn = stuff(p), p.between(0.1, 0.7)
  world:box { fixed = true, size = { 2.5, 0.1, 1.5 }, at = at + vec(1.2, 1.25 * math.sin(turn), 0), friction = common.friction,
    rotation = { axis = { 0, 0, 1 }, angle = -turn } }
  for i = 1, p.int(1, 6) do
    local size, y = p.between(0.1, 0.35), 2.5 * math.sin(turn) + 0.3 + 0.35 * (i // 3)
    thing(p, world, size, at + vec(0.35 * (i % 3), y, p.between(-0.4, 0.4)), common)
  end
end

function parts.lift(p, world, at, later)
  local common, k, high = stuff(p), p.between(0.5, 1.2), p.between(0.3, 1.5)
  -- so high that nothing gets under it
  local lift = world:box { kinematic = true, size = { k, 3, k }, at = at + vec(0, -1.4, 0), friction = common.friction }
  for i = 1, p.int(1, 6) do
    local size = k * p.between(0.15, 0.4)
    thing(p, world, size, at + vec(p.between(-0.2, 0.2) * k, 0.1 + 0.35 * k * i, p.between(-0.2, 0.2) * k), common)
  end
  local aside, takes = p.of { 0, 0, 0.5 }, p.between(0.5, 2)
  later[#later + 1] = { every = 2.2, act = function(n)
    lift:move_to { at = at + vec(n % 2 == 0 and aside or 0, n % 2 == 0 and high - 1.4 or -1.4, 0), over = takes }
  end }
end

function parts.drum(p, world, at)
  local common, k, walls = stuff(p), p.between(0.3, 0.7), p.int(5, 10)
  local wide, staves = 2 * k * math.tan(math.pi / walls) + 0.04, {}
  for i = 1, walls do
    local a = 2 * math.pi * i / walls
    staves[i] = digbox.box { size = { wide, 0.06, 0.8 }, at = { -k * math.sin(a), k * math.cos(a), 0 },
      rotation = { axis = { 0, 0, 1 }, angle = a } }
  end
  for _, z in ipairs { -0.43, 0.43 } do
    staves[#staves + 1] = digbox.cylinder { radius = 1.2 * k, height = 0.06, at = { 0, 0, z }, rotation = ACROSS }
  end
  local drum = world:body { kinematic = true, parts = staves, at = at + vec(k, 1.5 * k + 1, 0), friction = common.friction }
  drum:drive { spin = { 0, 0, p.between(-3, 3) } }
  for i = 0, p.int(2, 14) - 1 do
    local inside = vec(k * (0.7 + 0.3 * (i % 3)), 1.5 * k + 1 + k * (0.35 * (i // 6) - 0.4), 0.35 * ((i // 3) % 2) - 0.17)
    thing(p, world, k * p.between(0.15, 0.35), at + inside, common)
  end
end

function parts.coins(p, world, at)
  local common, k = stuff(p), p.between(0.03, 0.2)
  for i = 1, p.int(2, 8) do
    local spun = p.of { true, false }
    world:cylinder(with(common, { radius = k, height = k * p.between(0.06, 0.2), rotation = p.of { ACROSS, SIDEWAYS, any_turn(p) },
      at = at + vec(2.3 * k * (i % 3), k * p.between(1.1, 3), 2.3 * k * (i // 3)), spin = spun and { 0, p.between(5, 40), 0 } or nil,
      velocity = not spun and { p.between(-1, 1), 0, p.between(-1, 1) } or nil }))
  end
end

function parts.dominoes(p, world, at)
  local common, k = stuff(p), p.between(0.1, 0.5)
  for i = 0, p.int(4, 12) - 1 do
    world:box(with(common, { size = { 0.15 * k, k, 0.5 * k }, at = at + vec(0.5 * k * i, k / 2, 0),
      spin = i == 0 and { 0, 0, p.between(-6, -2) } or nil }))
  end
end

function parts.hanging(p, world, at)
  local common, y = stuff(p), p.between(1.5, 3)
  local bar = world:rod { length = 1, radius = 0.02, from = at + vec(0, y, 0), along = { 1, 0, 0 }, density = common.density }
  world:rope { a = bar, at = bar.position, to = bar.position + vec(0, 1, 0), length = 1 }
  for _, x in ipairs { 0.02, 0.98 } do
    local low = thing(p, world, p.between(0.1, 0.3), at + vec(x, y - 0.7, 0), common)
    world:rope { a = low, b = bar, at = low.position, to = at + vec(x, y, 0), length = 0.7 }
  end
end

function parts.thrown(p, world, at)
  local common = stuff(p)
  for i = 1, p.int(1, 6) do
    local body = thing(p, world, p.between(0.1, 0.5), at + vec(0, 0.5 * i, 0.3 * i), common)
    body:teleport { velocity = { p.between(-15, 15), p.between(0, 6), p.between(-15, 15) }, spin = p.vector(p.of { 0, 10, 40 }) }
  end
end

-- The ground: the floor, a slab, a mesh of triangles or hills, whose highest point is y = 0
local function ground(p, world)
  local kind, friction = p.of { "floor", "floor", "slab", "mesh", "hills" }, p.between(0.2, 1)
  if kind == "floor" then world:floor { friction = friction }
  elseif kind == "slab" then world:box { fixed = true, size = { 2 * HALF + 2, 1, 2 * HALF + 2 }, at = { 0, -0.5, 0 }, friction = friction }
  elseif kind == "hills" then
    local swell, long = p.between(0, 0.3), p.between(1, 4)          -- to 0.6 m below
    world:heightfield { columns = 25, rows = 25, size = { 2 * HALF + 2, 2 * HALF + 2 }, friction = friction,
      height = function(x, z) return swell * (math.sin(x / long) * math.cos(z / long) - 1) end }
  else
    local vertices, triangles, n = {}, {}, 8
    for i = 0, n do
      for j = 0, n do vertices[#vertices + 1] = { (2 * i / n - 1) * (HALF + 1), 0, (2 * j / n - 1) * (HALF + 1) } end
    end
    for i = 0, n - 1 do
      for j = 0, n - 1 do
        local a = i * (n + 1) + j + 1
        triangles[#triangles + 1], triangles[#triangles + 2] = { a, a + 1, a + n + 2 }, { a, a + n + 2, a + n + 1 }
      end
    end
    world:mesh { vertices = vertices, triangles = triangles, friction = friction }
  end
  for _, n in ipairs { { 1, 0 }, { -1, 0 }, { 0, 1 }, { 0, -1 } } do world:plane { normal = { n[1], 0, n[2] }, offset = -HALF } end
  return kind
end

local placed = {}
for name, make in pairs(parts) do
  placed[name] = function(p, world, x, z, later) make(p, world, vec(x, 0, z), later) end
end

return require "random_parts".kind {
  name = "rooms", parts = placed, ground = ground, fewest = 1, most = 4, half = HALF, depth = 0.6, potential = 0, made = 0.05, deep = 0.02,
  where = function(k) return -4.5 + ((k - 1) % 2) * 5.5, -3.5 + ((k - 1) // 2) * 5 end,
}
