-- tests/scenarios/materials.lua - the materials library: a name gives all figures, and another name changes all of them.
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

scenario("steel instead of wood changes weight, friction, bounce, heat and colour", function(s)
  local world = s.world
  local box = world:box { size = 0.1, at = { 0, 1, 0 }, material = "wood", temperature = 300 }
  local wooden = { mass = box.mass, colour = box.colour }
  expect(wooden.mass):near("0.65 kg", "1 mg")
  local function slide(material)
    local w = digbox.world {}
    w:plane { normal = { 0, 1, 0 }, material = "ice" }
    local b = w:box { size = 0.1, at = { 0, 0.05, 0 }, material = "wood" }
    b.material = material
    b:teleport { velocity = { 1, 0, 0 } }
    w:run "0.1 s"
    local v = b.velocity.x
    w:close()
    return v
  end
  local function bounce(material)
    local w = digbox.world {}
    w:plane { normal = { 0, 1, 0 }, material = "lead" }
    local b = w:ball { radius = 0.05, at = { 0, 0.5, 0 }, material = "wood" }
    b.material = material
    local hit, up = false, 0
    b:on("impact", function() hit = true end)
    for _ = 1, 60 do
      w:step()
      if hit then up = math.max(up, b.velocity.y) end
    end
    w:close()
    return up
  end
  box.material = "steel"
  expect(box.mass):near("7.85 kg", "1 mg")
  expect(box.colour):is_not(wooden.colour)
  local before = box.temperature
  box:warm { energy = 1000 }                    -- 7.85 kg of 490 J/(kg K)
  expect(box.temperature - before):near(1000 / (7.85 * 490), 1e-6)
  expect(slide "steel"):above(slide "wood" + 0.01)      -- steel on ice: 0.02
  expect(bounce "rubber"):above(bounce "foam" + 0.5)
end)

scenario("surface and heat that a body was given itself stay; its mass follows the density", function(s)
  local box = s.world:box { size = 0.1, at = { 0, 1, 0 }, material = "wood", mass = "2 kg", friction = 0.9, heat_capacity = 1000 }
  box.material = "steel"
  expect(box.mass):near("7.85 kg", "1 mg")
  expect(box.friction):is(0.9)
  expect(box.heat_capacity):is(1000.0)
end)

scenario("a material that is replaced is another one for what touches already, too", function(s)
  digbox.material("wax of the test", { density = 900, friction = 1 })
  local world = s.world
  world:plane { normal = { 0, 1, 0 }, material = "wax of the test" }
  local box = world:box { size = 0.1, at = { 0, 0.05, 0 }, material = "wax of the test" }
  local function slide()
    world:run "0.1 s"
    box:teleport { velocity = { 2, 0, 0 } }
    world:run "0.1 s"
    return box.velocity.x
  end
  expect(slide()):near(2 - 0.981, 1e-2)
  expect(world:stats().smooth):is(0)
  digbox.material("wax of the test", { density = 900, friction = 0 })
  expect(slide()):near(2, 1e-6)
  expect(world:stats().smooth):is(1)
end)

scenario("strength of a plank comes from its material", function(s)
  local function limit(material)
    local plank = s.world:plank { from = { 0, 1, 0 }, to = { 1, 1, 0 }, width = 0.1, height = 0.02, material = material, segments = 4 }
    local strength = plank.joints[1].strength
    for _, b in ipairs(plank.bodies) do b:remove() end
    return strength
  end
  expect(limit "steel"):near(400e6, 1)
  expect(limit "oak"):near(50e6, 1)
end)

scenario("unknown materials are refused with the name that was meant", function(s)
  expect(expect(function() s.world:box { size = 1, material = "stel" } end):fails()):contains "did you mean 'steel'"
end)
