-- laws_surfaces.lua: row 67 of the behaviours and materials: friction static, dynamic and rolling, the decay law, restitution by pair.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local g = 9.81

local function block_on(world, fields)
  local f = { size = { 0.3, 0.2, 0.3 }, at = { 0, 0.1, 0 }, mass = 2 }
  for k, v in pairs(fields) do f[k] = v end
  return world:box(f)
end

scenario("row 67: static friction holds up to mu m g, then dynamic friction is what slows", function(s)
  local world = s.world
  world:floor { friction = 0.6, friction_dynamic = 0.4 }
  local held = block_on(world, { friction = 0.6, friction_dynamic = 0.4 })
  local moved = block_on(world, { friction = 0.6, friction_dynamic = 0.4, at = { 0, 0.1, 2 } })
  held:push { force = { 0.99 * 0.6 * 2 * g, 0, 0 }, lasts = "1 s" }
  moved:push { force = { 1.01 * 0.6 * 2 * g, 0, 0 }, lasts = "1 s" }
  world:run "1 s"
  expect(held.position.x):near(0, 1e-6)
  expect(moved.speed):near((1.01 * 0.6 - 0.4) * g, 0.05)            -- 2 frames may pass before it slips
  local v = moved.speed
  world:run "0.3 s"
  expect(moved.speed):near(v - 0.4 * g * 0.3, 1e-2)
  world:run "1 s"
  expect(moved.speed):is(0.0)
end)

scenario("row 67: friction has the same bound in every direction", function(s)
  for _, angle in ipairs { 0, 20, 45, 73, 90 } do
    local world = s:world {}
    world:floor { friction = 0.3 }
    local way = digbox.vec(math.cos(math.rad(angle)), 0, math.sin(math.rad(angle)))
    local box = block_on(world, { friction = 0.3, velocity = way * 3 })
    world:run "0.5 s"
    expect(box.velocity):near(way * (3 - 0.3 * g * 0.5), 5e-3)      -- a pyramid would be off by 0.6 m/s at 45 degrees
  end
end)

scenario("row 67: rolling friction slows a ball by 5/7 of mu g", function(s)
  local world = s.world
  world:floor { rolling_friction = 0.05, friction = 0.9 }
  local r, v = 0.1, 2
  local ball = world:ball { radius = r, at = { 0, r, 0 }, velocity = { v, 0, 0 }, spin = { 0, 0, -v / r },
                            rolling_friction = 0.05, friction = 0.9 }
  world:run "1 s"
  -- The couple mu m g r against it: a (m + I / r^2) = mu m g
  expect(ball.speed):near(v - 0.05 * g * 5 / 7, 2e-3)
  expect(ball.spin.z):near(-ball.speed / r, 1e-2)
  s:eventually("it stops", "8 s", function() return ball.mode == "resting" end)
  expect(ball.position.x):near(v * v / (2 * 0.05 * g * 5 / 7), 0.02)
end)

scenario("row 67: with the decay law sliding speed dies away in proportion, not evenly", function(s)
  local function speeds(law)
    local world = s:world { friction_law = law }
    world:floor { friction = 0.3 }
    local box = block_on(world, { friction = 0.3, velocity = { 3, 0, 0 } })
    local list = { 3 }
    for i = 2, 5 do
      world:run "0.2 s"
      list[i] = box.speed
    end
    return list
  end
  local coulomb, decay = speeds "coulomb", speeds "decay"
  for i = 2, 5 do
    expect(coulomb[i]):near(3 - 0.3 * g * 0.2 * (i - 1), 5e-3)
  end
  local ratio = decay[3] / decay[2]
  expect(ratio):between(0.05, 0.99)
  expect(decay[4] / decay[3]):near(ratio, 0.02)
  expect(decay[5] / decay[4]):near(ratio, 0.02)
  expect(function() digbox.world { friction_law = "column" } end):fails()
end)

scenario("a pair takes the geometric mean of the frictions and the larger restitution", function(s)
  local world = s.world
  world:floor { friction = 0.9, restitution = 0.2 }
  local box = block_on(world, { friction = 0.1, velocity = { 3, 0, 0 } })
  local ball = world:ball { radius = 0.1, at = { 3, 1.1, 0 }, restitution = 0.6 }
  local up
  world:run { seconds = 0.5, stop_when = function() up = ball.velocity.y; return up > 0 end }
  world:run { steps = math.max(0, 30 - world.steps) }
  expect(box.speed):near(3 - math.sqrt(0.09) * g * 0.5, 5e-3)
  local v = math.sqrt(2 * g)
  expect(up):between(0.6 * v - 0.2, 0.6 * v + 1e-6)     -- within a frame of the bounce
end)

scenario("materials: a row of its own decides for a pair, and one line adds a material", function(s)
  digbox.material("sponge of the test", { density = 60, friction = 0.8, restitution = 0.05 })
  digbox.material("puck of the test", { like = "plastic", friction = 0.5, friction_dynamic = 0.5 })
  digbox.material_pair { a = "puck of the test", b = "ice", friction = 0.02, friction_dynamic = 0.02 }
  local world = s.world
  expect(world:box { size = 0.1, at = { 0, 5, 0 }, material = "sponge of the test" }.mass):near(0.06, 1e-9)
  world:floor { material = "ice" }
  local puck = world:cylinder { radius = 0.1, height = 0.04, at = { 0, 0.02, 0 }, material = "puck of the test", velocity = { 2, 0, 0 } }
  world:run "1 s"
  expect(puck.speed):near(2 - 0.02 * g, 5e-3)
  expect(function() world:box { size = 1, material = "spong of the test" } end):fails()
end)

scenario("materials: the standard pairs are in the table: steel on ice slides, steel on steel does not", function(s)
  local function slides(under)
    local world = s:world {}
    local turn = digbox.quat { axis = { 0, 0, 1 }, angle = "-20 deg" }      -- tan = 0.364
    world:box { fixed = true, material = under, size = { 4, 0.1, 1 }, rotation = turn }
    local box = world:box { material = "steel", size = 0.2, at = turn:rotate { 0, 0.15, 0 }, rotation = turn }
    world:run "1 s"
    return #(box.position - turn:rotate { 0, 0.15, 0 })
  end
  local a = g * (math.sin(math.rad(20)) - 0.02 * math.cos(math.rad(20)))    -- steel on ice: 0.03 static, 0.02 dynamic
  expect(slides "ice"):near(a / 2, 2e-2)
  expect(slides "steel"):near(0, 1e-6)                  -- 0.74 static
end)

-- A disc of triangles: 24 sides, its faces fans about their middles.
local function disc(radius, height)
  local vertices, triangles, n = {}, {}, 24
  for side = 0, 1 do
    for i = 1, n do
      local turn = 2 * math.pi * i / n
      vertices[side * n + i] = { radius * math.cos(turn), (side - 0.5) * height, radius * math.sin(turn) }
    end
  end
  vertices[2 * n + 1], vertices[2 * n + 2] = { 0, -height / 2, 0 }, { 0, height / 2, 0 }
  for i = 1, n do
    local j = i % n + 1
    for _, corners in ipairs { { 2 * n + 1, i, j }, { 2 * n + 2, n + j, n + i }, { i, n + i, j }, { j, n + i, n + j } } do
      triangles[#triangles + 1] = corners
    end
  end
  return { vertices = vertices, triangles = triangles, mass = 2 }
end

scenario("a mesh that moves stands, slides and lands on planes as a solid does", function(s)
  local world = s:world {}
  world:floor { friction = 0.5 }
  local function add(fields)
    for k, v in pairs(disc(0.3, 0.2)) do fields[k] = v end
    return world:mesh(fields)
  end
  local stands, slides = add { at = { 0, 0.1, 0 } }, add { at = { 2, 0.1, 0 }, velocity = { 1, 0, 0 } }
  local falls = add { at = { 4, 0.6, 0 }, rotation = { axis = { 1, 0, 0 }, angle = 1 } }
  local fast = add { at = { 6, 20, 0 }, velocity = { 0, -300, 0 } }
  local box = world:box { size = 0.1, at = { 0, 0.25, 0 } }
  world:run(4)
  expect(stands.position.y):near(0.1, 1e-9)
  expect(box.position.y):near(0.25, 1e-9)
  expect(slides.position.x - 2):near(1 / (2 * 0.5 * 9.81), 1e-5)         -- v^2 / (2 mu g), swept
  for _, body in ipairs { slides, falls, fast } do
    expect(body.position.y):near(0.1, 1e-6)
    expect(body.speed):at_most(1e-6)
  end
  expect(world:stats().worst_penetration):at_most(1e-4)
end)
