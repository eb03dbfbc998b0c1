-- mesh_edges.lua: what lies across an edge of an open mesh may have its middle below the plane of a triangle that it touches, beside it. On
-- which side of the mesh it is does not follow from that plane: before the triangle that the middle is over was asked, rods at rest on
-- a plateau were 0.5 to 0.8 m deep behind its slope, and were moved by as much.
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- A roof of triangles, 8 m along z: level from x = -4 m to 0, falling off by 45 degrees to x = 6 m. up = false: wound the other way round.
local function roof(world, up)
  local vertices, triangles = {}, {}
  for k, x in ipairs { -4, 0, 6 } do
    for row = 0, 8 do vertices[#vertices + 1] = { x, k == 3 and -6 or 0, row - 4 } end
  end
  for k = 0, 1 do
    for row = 1, 8 do
      local c = 9 * k + row
      local corners = { c, c + 1, c + 9, c + 9, c + 1, c + 10 }
      for i = 1, 6 do triangles[#triangles + 1] = corners[up and i or 7 - i] end
    end
  end
  world:mesh { vertices = vertices, triangles = triangles, fixed = true, friction = 0.3 }
end

for _, up in ipairs { true, false } do
  local name = "rods across an edge of a mesh lie still or slide off it, on its %s"
  scenario(name:format(up and "front" or "back"), function(s)
    for i = 0, 11 do
      local world = s:world {}
      roof(world, up)
      local shape, along = ({ "capsule", "box", "cylinder" })[i % 3 + 1], 0.1 * i - 0.35
      local fields = { friction = 0.3, mass = 1, at = { along, 0.1, 0.3 }, rotation = { axis = { 0, 0, 1 }, angle = "90 deg" } }
      if shape == "capsule" then fields.radius, fields.length = 0.1, 1.6
      elseif shape == "box" then fields.size = { 0.2, 2, 0.2 }
      else fields.radius, fields.height = 0.1, 2 end
      local rod = world[shape](world, fields)
      world:run "1 s"
      local at = rod.position
      expect(world:stats().worst_penetration):below(1e-6)           -- m
      expect(world.energy.numerical):near(0, 1e-6)                  -- J of 10 to 60
      if along < 0 then expect(at):near({ along, 0.1, 0.3 }, 1e-6)
      else expect(at.y):above(0.1 - math.max(0, at.x)) expect(at.x):above(0.15) end
    end
  end)
end

-- Beyond a rim there is no triangle that the middle is over: what hangs over it is where it is nearest.
scenario("rods tip over the rim of a mesh and fall off it", function(s)
  for i = 0, 8 do
    local world, vertices, triangles = s:world {}, {}, {}
    for row = 0, 8 do
      for column = 0, 8 do vertices[#vertices + 1] = { column - 8, 0, row - 4 } end
    end
    for c = 1, 71 do
      for _, corner in ipairs(c % 9 > 0 and { c, c + 9, c + 1, c + 1, c + 9, c + 10 } or {}) do triangles[#triangles + 1] = corner end
    end
    world:mesh { vertices = vertices, triangles = triangles, fixed = true, friction = 0.3 }
    local shape = ({ "capsule", "box", "cylinder" })[i % 3 + 1]
    local fields = { friction = 0.3, mass = 1, at = { 0.04 + 0.03 * i, 0.1, 0.3 }, rotation = { axis = { 0, 0, 1 }, angle = "90 deg" } }
    if shape == "capsule" then fields.radius, fields.length = 0.1, 1.6
    elseif shape == "box" then fields.size = { 0.2, 2, 0.2 }
    else fields.radius, fields.height = 0.1, 2 end
    local rod = world[shape](world, fields)
    world:run "1.6 s"
    expect(rod.position.y):below(-2)
    expect(world:stats().worst_penetration):below(1e-5)           -- m; 0.3 to 0.7 when the rim's plane was asked
    expect(world.energy.numerical):near(0, 1e-3)                  -- J; -0.3 to -3
  end
end)
