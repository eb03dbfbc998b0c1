-- api_samples.lua: the first two samples of the Lua API, as they stand there (smaller pictures).
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

scenario("a ball dropped on a table ends on it, filmed", function()
  local world = digbox.world { seed = 1 }    -- SI units, y up, gravity 9.81 m/s^2
  world:floor { material = "tile" }
  local top = world:box {
    name = "table", fixed = true, material = "oak",
    size = { 1.2, 0.04, 0.8 },               -- metres, full extents
    at = { 0, 0.74, 0 },                     -- centre
  }
  local ball = world:ball {
    name = "ball", material = "steel",       -- density, friction, bounce come from here
    radius = "4 cm",                         -- a number is SI; a string carries its unit
    at = { 0, 0.76 + 0.04 + 0.75, 0 },
  }
  world:sun { from = { 3, 6, 2 }, shadows = true }
  local eye = world:camera { at = { 1.8, 1.6, 1.8 }, look_at = top, fov = "40 deg" }
  local hits = {}
  ball:on("contact_begin", function(e) hits[#hits + 1] = e end)

  local film = world:record { camera = eye, to = "out/ball-%05d.png", fps = 30, size = { 64, 36 } }
  world:run "3 s"
  film:close()

  -- Fall of 0.75 m: t = sqrt(2 h / g), v = sqrt(2 g h)
  expect(hits[1].time):near(math.sqrt(2 * 0.75 / 9.81), "1 ms")
  expect(hits[1].speed):near(math.sqrt(2 * 9.81 * 0.75), "1 cm/s")
  expect(hits[1].self):is(ball)
  expect(hits[1].other.name):is "table"
  expect(film.frames):is(91)
  expect(ball.position):near({ 0, 0.8, 0 }, "1 mm")
  expect(ball:neighbours()):is { top }
  expect(tostring(ball:neighbours())):is "{body 'table'}"
end)

local function build(world)
  world:floor {}
  local top = world:box { name = "table", fixed = true, material = "oak",
                          size = { 1.0, 0.04, 0.6 }, at = { 0, 0.74, 0 } }
  local ball = world:ball { name = "ball", material = "rubber", radius = "3 cm",
                            at = { 0.20, 0.79, 0 } }
  local rod = world:rod { name = "rod", material = "steel", length = "40 cm", radius = "6 mm",
                          from = { -0.25, 0.79, 0 }, along = { 1, 0, 0 } }
  local bucket = world:bucket { name = "bucket", material = "tin", at = { 0.78, 0, 0 },
                                height = "30 cm", top_radius = "20 cm", bottom_radius = "16 cm" }
  world:slider { name = "guide", a = rod, along = { 1, 0, 0 }, limits = { 0, 0.35 } }
  return top, ball, rod, bucket
end

scenario("the rod pushes the ball off the table into the bucket", function(s)
  local world = s.world
  local top, ball, rod, bucket = build(world)

  s:settle "1 s"                                        -- let everything come to rest
  expect(ball:touches(top)):is(true)
  expect(ball:touches(rod)):is(false)
  expect(ball.speed):below("1 mm/s")

  rod:push { force = "0.8 N", along = { 1, 0, 0 }, lasts = "0.4 s" }
  s:eventually("the rod reaches the ball", "0.5 s", function() return rod:touches(ball) end)
  expect(digbox.path(rod, top)):is { rod, ball, top }      -- who acts on whom, through whom

  s:eventually("the ball leaves the table", "2 s", function() return not ball:touches(top) end)
  expect(ball:neighbours { kind = "contact" }):is_empty()
  expect(ball.velocity.x):between("0.3 m/s", "1.4 m/s")

  s:eventually("the ball is in the bucket", "2 s", function() return bucket:contains(ball) end)
  s:always("it stays there", "2 s", function() return bucket:contains(ball) end)
  expect(world.energy.total):at_most(world.energy.initial + rod.work_received)
  s:golden("after", { camera = world:camera { at = { 1.6, 1.3, 1.6 }, look_at = bucket } })
end)

scenario("misspelt fields are caught", function(s)
  local err = expect(function() s.world:ball { radus = 0.1 } end):fails()
  expect(err):contains "did you mean 'radius'"
end)
