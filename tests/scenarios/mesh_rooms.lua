-- mesh_rooms.lua: in a crowd, nothing passes through a mesh, however fast it comes.
--
-- What passed through a wall in a piece of a step was put back to where they met if the wall was solid. A mesh has no inside to be deep in,
-- and was left out: of 1100 things at up to 260 m/s in rooms of triangles four got out.
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- Numbers in [low, high) (Park, Miller 1988)
local function dice(seed)
  local state = (seed * 7919 + 17) % 2147483647
  local function throw(low, high)
    state = state * 48271 % 2147483647
    return low + (high - low) * state / 2147483647
  end
  for _ = 1, 5 do throw(0, 1) end
  return throw
end

local HALF = 1.5                  -- m  of the room, which is a cube

-- Walls and floor, each of n x n squares, and a solid lid: a mesh that is closed all round is solid.
local function room(world, n, restitution)
  local vertices, triangles, number = {}, {}, {}
  local function corner(x, y, z)
    local key = ("%d,%d,%d"):format(x, y, z)
    if not number[key] then
      vertices[#vertices + 1] = { (2 * x / n - 1) * HALF, 2 * y / n * HALF, (2 * z / n - 1) * HALF }
      number[key] = #vertices
    end
    return number[key]
  end
  local function square(a, b, c, d)
    for _, v in ipairs { a, b, c, a, c, d } do triangles[#triangles + 1] = v end
  end
  for i = 0, n - 1 do
    for j = 0, n - 1 do
      square(corner(i, j, 0), corner(i + 1, j, 0), corner(i + 1, j + 1, 0), corner(i, j + 1, 0))
      square(corner(i, j, n), corner(i, j + 1, n), corner(i + 1, j + 1, n), corner(i + 1, j, n))
      square(corner(0, i, j), corner(0, i + 1, j), corner(0, i + 1, j + 1), corner(0, i, j + 1))
      square(corner(n, i, j), corner(n, i, j + 1), corner(n, i + 1, j + 1), corner(n, i + 1, j))
      square(corner(i, 0, j), corner(i, 0, j + 1), corner(i + 1, 0, j + 1), corner(i + 1, 0, j))
    end
  end
  world:mesh { vertices = vertices, triangles = triangles, fixed = true, friction = 0.4, restitution = restitution }
  world:box { fixed = true, size = { 3, 0.5, 3 }, at = { 0, 3.25, 0 }, friction = 0.4, restitution = restitution }
end

local shapes = {
  function(s, d) return "ball", { radius = s * d(0.3, 0.5) } end,
  function(s, d) return "box", { size = { s * d(0.5, 1), s * d(0.5, 1), s * d(0.5, 1) } } end,
  function(s, d) return "capsule", { radius = s * d(0.15, 0.25), length = s * d(0.3, 0.8) } end,
  function(s, d) return "cylinder", { radius = s * d(0.25, 0.5), height = s * d(0.3, 1) } end,
  function(s)
    local r = s / 2
    return "hull", { points = { { r, 0, 0 }, { -r, 0, 0 }, { 0, r, 0 }, { 0, -r, 0 }, { 0, 0, r }, { 0, 0, -r } } }
  end,
}

local function inside(p) return math.abs(p.x) < HALF and math.abs(p.z) < HALF and p.y > 0 and p.y < 2 * HALF end

for _, case in ipairs { 11, 22, 24, 54, 63, 84 } do
  local seed = case
  scenario(("fast things stay in a room of triangles: start %d"):format(seed), function(s)
    local world, d, bodies = s:world {}, dice(seed), {}
    local count, speed = math.floor(d(70, 130)), ({ 3, 10, 40, 150 })[math.floor(d(1, 4.99))]
    local restitution, squares = d(0, 1) < 0.5 and 0 or 0.5, math.floor(d(1, 4.99))
    room(world, squares, restitution)
    local size = d(0, 1) < 0.5 and 0.3 or 0.12
    for i = 0, count - 1 do
      local velocity = { d(-speed, speed), d(-speed, speed), d(-speed, speed) }
      local spin = { d(-9, 9), d(-9, 9), d(-9, 9) }
      local kind, fields = shapes[1 + math.floor(d(0, 5))](size, d)
      fields.at = { (i % 5 - 2) * 0.5, 0.4 + 0.45 * (i // 25), (i // 5 % 5 - 2) * 0.5 }
      fields.friction, fields.restitution, fields.velocity, fields.spin = 0.4, restitution, velocity, spin
      bodies[#bodies + 1] = world[kind](world, fields)
    end
    for frame = 1, 30 do
      world:step()
      for i, b in ipairs(bodies) do
        expect(inside(b.position), ("thing %d is inside in frame %d, at %s"):format(i, frame, b.position)):is(true)
      end
    end
  end)
end
