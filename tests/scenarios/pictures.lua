-- Pictures of today, kept in golden/pictures. `digbox test --update-goldens tests/scenarios/pictures.lua` takes those of now as right,
-- after a change of the looks that was looked at. Which body is where does not change with them.
local digbox, test = require "digbox", require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- One of each shape and of many materials, in the places where they are put: nothing moves.
local function yard(world, floor)
  digbox.material("polished", { like = "tile", roughness = 0.05 })
  world:floor { material = floor }
  for i, material in ipairs { "oak", "brick", "tile", "steel" } do
    world:box { name = material, material = material, size = { 0.3, 0.25, 0.3 }, at = { 0.45 * i - 1.2, 0.125, -0.5 },
      rotation = digbox.quat { axis = { 0, 1, 0 }, angle = 0.3 * i } }
  end
  world:ball { name = "ball", material = "rubber", radius = 0.18, at = { -0.7, 0.18, 0.2 } }
  world:capsule { material = "plastic", radius = 0.1, length = 0.3, at = { -0.1, 0.25, 0.3 } }
  world:cylinder { material = "brass", radius = 0.15, height = 0.3, at = { 0.35, 0.15, 0.2 } }
  world:box { name = "pane", material = "glass", opacity = 0.4, size = { 0.5, 0.5, 0.04 }, at = { 0.8, 0.25, 0.3 } }
  return world:camera { at = { 0.9, 1.1, 2.6 }, look_at = { 0, 0.15, 0 }, fov = "38 deg" }
end

scenario("a yard in the sun", function(s)
  local eye = yard(s.world, "concrete")
  s.world:sun { from = { -2, 3, 1.5 } }
  s:golden("colour", { camera = eye, size = { 240, 135 } })
  s:golden("bodies", { camera = eye, layer = "id" })
  s:golden("names", { camera = eye, size = { 240, 135 }, overlay = { "names", "time" } })
  expect(s.world.time):is(0)
end)

scenario("a hall with a polished floor, by lamps", function(s)
  local eye = yard(s.world, "polished")
  s.world:sky "night"
  s.world:lamp { at = { 0.5, 1.5, 1 }, power = "120 W" }
  s:golden("colour", { camera = eye, size = { 240, 135 } })
  s:golden("bodies", { camera = eye, layer = "id" })
  expect(s.world.time):is(0)
end)

-- Where bodies are, asked of the picture: a ball in free flight is at its closed form, a pixel is a hundredth of a metre.
scenario("a ball that flies past a post", function(s)
  local world = s.world
  world:floor {}
  world:box { fixed = true, size = { 0.1, 1, 0.1 }, at = { 0.5, 0.5, -0.3 } }
  local ball = world:ball { radius = 0.1, at = { -0.6, 0.4, 0 }, velocity = { 2, 3, 0 } }
  local eye = world:camera { at = { 0, 0.6, 4 }, look_at = { 0, 0.6, 0 }, fov = "30 deg" }
  world:run "0.5 s"
  expect((ball.position - digbox.vec(0.4, 0.4 + 1.5 - 0.5 * 9.81 * 0.25, 0)):length()):below("1 um")
  s:golden("in front of it", { camera = eye, layer = "id" })
end)
