-- ball_table_bucket.lua: a ball, a table, a bucket and a rod - the example scenario of the founding document, steps i to xii.
--   digbox run worlds/ball_table_bucket.lua -o out
--
-- Nothing is scripted but the forces that the document names, at fixed times:
--   a gentle pull on the table, a sudden stop, a constant pull upwards on the handle of the bucket.
-- All the rest - bounces, rolling, who belongs to which DIG - is physics.
local digbox = require "digbox"

local scene = {}

-- The forces and their times: N, s.
local pull = { at = 2.0, force = 32, lasts = 2.3 }      -- table: a = 32/20.1 - 0.1 g = 0.61 m/s^2, below what rolling friction holds
local stop = { at = 4.3, force = 260, lasts = 0.1 }     -- table: 1.4 m/s to nothing within 7 cm
local lift = { at = 7.0, force = 32.5 }                 -- handle: 1.11 times the weight of bucket, handle and ball
scene.pull, scene.stop, scene.lift = pull, stop, lift

scene.rolling = 0.12        -- rolling friction of the ball on the table: holds it up to 0.12 g = 1.18 m/s^2
scene.edge = -0.28          -- m, where the table's right edge comes to a stop; the bucket stands at x = 0

-- The table has a cloth on it and felt under its feet; the ball is hollow rubber; the rod has a rubber sleeve.
digbox.material("cloth", { like = "oak", pattern = "wood" })
digbox.material("glide", { like = "felt", friction = 0.1, friction_dynamic = 0.1, restitution = 0 })
digbox.material("sleeve", { like = "rubber", restitution = 0 })
digbox.material_pair { a = "glide", b = "tile", friction = 0.1, friction_dynamic = 0.1, restitution = 0 }
digbox.material_pair { a = "rubber", b = "cloth", friction = 0.7, friction_dynamic = 0.6, rolling_friction = scene.rolling,
  restitution = 0.45 }
digbox.material_pair { a = "rubber", b = "aluminium", friction = 0.4, friction_dynamic = 0.35, rolling_friction = 0.015, restitution = 0.2 }
digbox.material_pair { a = "sleeve", b = "aluminium", friction = 0.75, friction_dynamic = 0.64, restitution = 0 }

local across = digbox.quat { axis = { 1, 0, 0 }, angle = "90 deg" }     -- a capsule or rod along z

local function build_table(world)
  local length, height, depth = 1.6, 0.55, 0.6
  local parts = { digbox.box { size = { length, 0.03, depth }, at = { 0, height - 0.015, 0 } } }
  for _, x in ipairs { -length / 2 + 0.05, length / 2 - 0.05 } do
    for _, z in ipairs { -depth / 2 + 0.05, depth / 2 - 0.05 } do
      parts[#parts + 1] = digbox.box { size = { 0.05, height - 0.04, 0.05 }, at = { x, (height - 0.02) / 2, z } }
      parts[#parts + 1] = digbox.cylinder { radius = 0.03, height = 0.01, at = { x, 0.005, z }, material = "glide" }
    end
  end
  local centre = scene.edge - length / 2 - 1.69          -- it will slide 1.69 m
  local top = world:body { name = "table", material = "cloth", mass = "20 kg", parts = parts, at = { centre, 0, 0 } }
  local ball = world:ball { name = "ball", material = "rubber", mass = "100 g", radius = "4 cm",
    at = { centre + length / 2 - 0.12, height + 0.04 + 0.35, 0 } }
  return top, ball
end

-- A pail with a ledge on either side, turned up at its edge: there the rod will catch. Pins carry the handle.
local function build_bucket(world)
  local pin, reach, lean = 0.122, 0.32, math.rad(40)
  local parts = {}
  for _, side in ipairs { -1, 1 } do
    local slope = side * math.rad(75)
    local up = digbox.quat { axis = { 0, 0, 1 }, angle = slope }
    parts[#parts + 1] = digbox.box { size = { 0.055, 0.004, 0.18 }, at = { side * 0.1825, 0.197, 0 } }
    parts[#parts + 1] = digbox.box { size = { 0.027, 0.004, 0.18 }, rotation = up,
      at = { side * (0.21 + 0.0135 * math.cos(slope)), 0.197 + 0.0135 * math.sin(math.abs(slope)), 0 } }
    parts[#parts + 1] = digbox.capsule { radius = 0.008, length = 0.06, rotation = across, at = { 0, pin, side * 0.155 } }
  end
  local bucket = world:bucket { name = "bucket", material = "aluminium", mass = "2.5 kg", height = "20 cm", top_radius = "16 cm",
    bottom_radius = "5 cm", wall = "4 mm", segments = 16, parts = parts }
  local handle = world:body { name = "handle", material = "steel", mass = "400 g", at = { 0, pin, 0 },
    rotation = digbox.quat { axis = { 0, 0, 1 }, angle = -lean },
    parts = {
      digbox.capsule { radius = 0.007, length = reach, at = { 0, reach / 2, -0.18 } },
      digbox.capsule { radius = 0.007, length = reach, at = { 0, reach / 2, 0.18 } },
      digbox.capsule { radius = 0.012, length = 0.44, at = { 0, reach, 0 }, rotation = across },
    } }
  local hinge = world:hinge { name = "pins", a = handle, b = bucket, at = { 0, pin, 0 }, axis = { 0, 0, 1 },
    friction = "0.03 N m", spring = { damping = 0.16 } }     -- hangs within 5 degrees of upright
  local grip = digbox.vec(reach * math.sin(lean), pin + reach * math.cos(lean), 0)
  return bucket, handle, hinge, grip
end

-- What stands still: pegs that the handle leans on, the yoke that stops it at the top, the post behind the rod.
local function build_frame(world, grip)
  for _, z in ipairs { -0.21, 0.21 } do
    local height = grip.y - 0.012
    world:box { name = "peg", fixed = true, material = "oak", size = { 0.03, height, 0.03 }, at = { grip.x + 0.005, height / 2, z } }
  end
  for _, side in ipairs { -1, 1 } do
    world:box { name = "yoke", fixed = true, material = "oak", size = { 0.45, 0.03, 0.5 }, at = { side * 0.15, 1.4, 0 },
      rotation = digbox.quat { axis = { 0, 0, 1 }, angle = -side * math.pi / 4 } }
  end
end

-- Everything of the scene in a world: a table of the bodies and the hinge.
function scene.build(world)
  local s = { world = world }
  world:floor { material = "tile" }
  s.table, s.ball = build_table(world)
  s.bucket, s.handle, s.hinge, s.grip = build_bucket(world)
  s.rod = world:rod { name = "rod", material = "sleeve", radius = "12 mm", from = { -0.18, 0.69, -0.36 }, to = { -0.18, 0.69, 0.30 } }
  world:weld { name = "mount", a = s.rod }          -- a body held by the world, so that it has a DIG of its own
  build_frame(world, s.grip)
  return s
end

-- The forces of the document, at their times.
function scene.act(s)
  s.world:spawn(function(task)
    task:wait(pull.at)
    s.table:push { force = { pull.force, 0, 0 }, at = s.table.centre, lasts = pull.lasts }
    task:wait(stop.at - pull.at)
    -- vii: a large force against the motion, half of it where ball and table touch
    local contact = s.ball.centre - digbox.vec(0, 0.04, 0)
    s.table:push { force = { -stop.force / 2, 0, 0 }, at = s.table.centre, lasts = stop.lasts }
    s.table:push { force = { -stop.force / 2, 0, 0 }, at = contact, lasts = stop.lasts }
    task:wait(lift.at - stop.at)
    s.handle:push { force = { 0, lift.force, 0 }, at = s.grip, lasts = 1000 }
  end)
end

-- The DIGs as text, in the order of their ids: "{table,ball} {bucket,handle} {rod}".
function scene.sets(world)
  local sets = {}
  for _, dig in ipairs(world:digs()) do
    local names = {}
    for _, member in ipairs(dig:members()) do names[#names + 1] = member.name end
    sets[#sets + 1] = "{" .. table.concat(names, ",") .. "}"
  end
  return table.concat(sets, " ")
end

if ... == "ball_table_bucket" then return scene end       -- the spec builds its own world

local world = digbox.world {}
local s = scene.build(world)
scene.act(s)
world:sun { from = { 2, 5, 4 }, shadows = true }
local eye = world:camera { at = { -1.0, 1.35, 4.1 }, look_at = digbox.vec(-1.35, 0.62, 0), fov = "44 deg" }

local before = ""
local function tell(what)
  local now = scene.sets(world)
  if what or now ~= before then print(("%7.3f s  %-46s %s"):format(world.time, now, what or "")) end
  before = now
end

tell "the ball falls"
local film = world:record { camera = eye, to = "out/ball_table_bucket-%05d.png", fps = 30, size = { 1280, 720 } }
local notes = { [pull.at] = "the table is pulled gently", [stop.at] = "the table is stopped", [lift.at] = "the handle is pulled up" }
while world.time < 13 do
  local time = world.time + world.frame
  world:step()
  local note
  for at, text in pairs(notes) do if math.abs(time - at) < world.frame / 2 then note = text end end
  tell(note)
end
film:close()
print(("the ball lies on the table, %.2f m from its edge; the bucket hangs by its handle"):format(
  s.table.position.x + 0.8 - s.ball.position.x))
