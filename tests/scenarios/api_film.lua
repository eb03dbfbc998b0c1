-- api_film.lua: pictures and films: when frames are taken, where they go, and that they leave the physics alone.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local tiny = { 64, 36 }

local function falling(world)
  world:floor {}
  return world:ball { name = "ball", radius = 0.2, at = { 0, 1, 0 }, material = "rubber" }
end

scenario("a frame at every multiple of 1/fps, both ends included", function(s)
  for fps, frames in pairs { [30] = 16, [60] = 31, [20] = 11, [24] = 13, [100] = 51, [7] = 4 } do
    local world = digbox.world {}
    falling(world)
    local film = world:record { to = ("out/count-%d-%%05d.png"):format(fps), fps = fps, size = tiny, samples = 0 }
    world:run "0.5 s"
    film:close()
    expect(film.frames):is(frames)
    expect(film.closed):is(true)
    world:close()
  end
  expect(s.world.steps):is(0)
end)

scenario("fps never changes the physics", function()
  local function run(fps)
    local world = digbox.world {}
    falling(world)
    local film = fps and world:record { to = "out/physics-%05d.png", fps = fps, size = tiny, samples = 0 }
    world:run "0.3 s"
    if film then film:close() end
    return world:checksum()
  end
  local sum = run(nil)
  expect(run(30)):is(sum)
  expect(run(47)):is(sum)
end)

scenario("cameras look at bodies and points, and can be moved", function(s)
  local world = s.world
  local ball = falling(world)
  local cam = world:camera { at = { 3, 2, 3 }, look_at = ball, fov = "40 deg", name = "eye" }
  expect(cam.fov):near("40 deg", 1e-12)
  expect(cam.look_at):is(ball)
  cam.at = { 1, 1, 1 }
  expect(cam.at):is(digbox.vec(1, 1, 1))
  local follower = world:camera { follow = ball, at = { 2, 1, 2 } }
  local path = world:render { camera = cam, to = "out/film-a.png", size = tiny }
  expect(path):contains "film-a.png"
  world:step(5)
  world:render { camera = follower, to = "out/film-b.png", size = tiny, overlay = { "dig", "contacts", "forces", "names" } }
  for _, layer in ipairs { "colour", "depth", "id", "normal" } do
    world:render { to = ("out/film-%s.png"):format(layer), size = tiny, layer = layer }
  end
  world:sun { from = { 3, 6, 2 }, shadows = false }
  world:lamp { at = { 1, 2, 1 }, power = "60 W", colour = "#ffe0c0" }
  world:sky "overcast"
  world:render { to = "out/film-lit.png", size = tiny }
  expect(s.world:checksum()):is(world:checksum())
end)

scenario("what cannot be drawn is refused", function(s)
  local world = s.world
  local function says(fn, wanted) expect((expect(fn):fails():gsub("^.-:%d+: ", ""))):contains(wanted) end
  says(function() world:render { to = "a.jpg" } end, "must end in .png")
  says(function() world:render {} end, "world:render: to is missing")
  says(function() world:render { to = "a.png", size = { 0, 5 } } end, "width = 0, must be a whole number from 1 to 16384")
  says(function() world:render { to = "a.png", size = { 5, 16385 } } end, "height = 16385, must be")
  says(function() world:render { to = "a.png", samples = 3 } end, "samples = 3, must be 0, 2 or 4")
  says(function() world:render { to = "a.png", layer = "color" } end, "unknown layer 'color' (did you mean 'colour'?)")
  says(function() world:render { to = "a.png", overlay = { "digs" } } end, "unknown overlay 'digs' (did you mean 'dig'?)")
  says(function() world:render { to = "a.png", camera = 3 } end, "world:render.camera wants a camera; got number")
  says(function() world:render { to = "../a.png" } end, "'../a.png' lies outside the output folder")
  says(function() world:render { to = "/a.png" } end, "lies outside the output folder")
  says(function() world:record { to = "a.png" } end, "needs a place for the number")
  says(function() world:record { to = "a-%s.png" } end, "is no pattern for frames")
  says(function() world:record { to = "a-%n-%d.png" } end, "is no pattern for frames")
  says(function() world:record { to = "a-%999999d.png" } end, "is no pattern for frames")
  says(function() world:record { to = "a-%05d.png", fps = 0 } end, "fps = 0 Hz, must be > 0")
  says(function() world:record { to = "a.avi" } end, "must end in .png, .mp4 or .webm")
  says(function() world:camera { fov = "4 m" } end, "world:camera.fov wants an angle; '4 m' is a length")
  says(function() world:sky "clera" end, "unknown sky 'clera' (did you mean 'clear'?)")
  for _ = 1, 4 do world:lamp { at = { 0, 1, 0 } } end
  says(function() world:lamp { at = { 0, 1, 0 } } end, "there are 4 lamps already")
end)
