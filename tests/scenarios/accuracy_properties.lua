-- accuracy_properties.lua: what holds for every exact motion: it runs backwards, keeps momentum and energy, and does not depend on
-- where the world stands, how it is turned, or how long a frame is.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local g = 9.81
local fine = 1e-9               -- m, accuracy of these worlds

local function world_of(fields)
  fields = fields or {}
  fields.accuracy, fields.sleeping = fields.accuracy or fine, false
  return digbox.world(fields)
end

local function dynamic(world)
  local list = {}
  for _, b in ipairs(world:bodies()) do
    if b.kind == "dynamic" then list[#list + 1] = b end
  end
  return list
end

-- ---- time reversal ----

-- Runs, turns all velocities round, runs as long again: where is everything against the start?
local function there_and_back(world, seconds)
  local start = {}
  for i, b in ipairs(dynamic(world)) do start[i] = { b.position, b.rotation } end
  world:run(seconds)
  local moved = 0
  for i, b in ipairs(dynamic(world)) do
    moved = math.max(moved, #(b.position - start[i][1]))
    b:teleport { velocity = -b.velocity, spin = -b.spin }
  end
  world:run(seconds)
  local off = 0
  for i, b in ipairs(dynamic(world)) do
    local turn = (b.rotation * start[i][2]:inverse()).angle
    off = math.max(off, #(b.position - start[i][1]), turn)
  end
  world:close()
  return off, moved
end

local function rod(world, at, turn)
  return world:box { size = { 1, 0.1, 0.1 }, mass = 1, at = at, rotation = turn, collides = false }
end

scenario("time reversal: a pendulum swings back to where it was let go", function()
  local world = world_of()
  world:hinge { a = rod(world, { 0.5, 0, 0 }), at = { 0, 0, 0 }, axis = { 0, 0, 1 } }
  local off, moved = there_and_back(world, 1.5)
  expect(moved):above(0.3)
  expect(off):below(1e-7)
end)

scenario("time reversal: a double pendulum too", function()
  local world = world_of()
  local a, b = rod(world, { 0.5, 0, 0 }), rod(world, { 1.5, 0, 0 })
  world:hinge { a = a, at = { 0, 0, 0 }, axis = { 0, 0, 1 } }
  world:hinge { a = b, b = a, at = { 1, 0, 0 }, axis = { 0, 0, 1 } }
  local off, moved = there_and_back(world, 1.5)
  expect(moved):above(1)
  expect(off):below(1e-6)
end)

scenario("time reversal: a free body that flips over and over", function()
  local world = world_of { gravity = { 0, 0, 0 } }
  world:box { size = { 1, 0.6, 0.2 }, mass = 1, spin = { 0.1, 5, 0.1 }, velocity = { 1, 2, 3 } }
  local off, moved = there_and_back(world, 3)
  expect(moved):above(1)
  expect(off):below(1e-7)
end)

scenario("time reversal: balls that bounce off the floor and each other without loss", function()
  local world = world_of()
  world:floor { restitution = 1, friction = 0 }
  world:ball { radius = 0.1, mass = 1, at = { 0, 0.5, 0 }, velocity = { 1, 0, 0 }, restitution = 1, friction = 0 }
  world:ball { radius = 0.2, mass = 2, at = { 1, 0.9, 0.1 }, velocity = { -0.5, 0, 0 }, restitution = 1, friction = 0 }
  local off, moved = there_and_back(world, 1.25)
  expect(moved):above(0.5)
  expect(off):below(1e-7)
end)

-- ---- conservation ----

scenario("momentum and angular momentum of bodies left alone stay, joints, springs and impacts or not", function()
  local world = world_of { gravity = { 0, 0, 0 } }
  local a = world:box { size = { 1, 0.2, 0.3 }, mass = 2, at = { 0, 0, 0 }, velocity = { 1, 0.5, 0 }, spin = { 1, 2, 3 } }
  local b = world:box { size = { 1, 0.3, 0.2 }, mass = 1, at = { 1, 0, 0 }, velocity = { 1, 0.5, 2 } }
  local c = world:ball { radius = 0.2, mass = 3, at = { 1, 2, 0 } }
  world:ball { radius = 0.3, mass = 1, at = { 3, 2.1, 0.1 }, velocity = { -2, 0, 0 }, spin = { 0, 0, 5 }, restitution = 0.5 }
  world:ball_joint { a = a, b = b, at = { 0.5, 0, 0 } }
  world:spring { a = b, b = c, stiffness = 50, damping = 1, length = 1.5 }
  local p, l = world.momentum, world.angular_momentum
  local scale = 2 * 1.2 + 2.3 + 2
  for _ = 1, 120 do
    world:step()
    expect(#(world.momentum - p)):below(1e-10 * scale)
    expect(#(world.angular_momentum - l)):below(1e-8 * scale)
  end
end)

scenario("energy of a swinging chain stays, and the books balance where it is lost", function()
  local world = world_of()
  local before
  for i = 1, 3 do
    local link = rod(world, { i - 0.5, 0, 0 })
    world:hinge { a = link, b = before, at = { i - 1, 0, 0 }, axis = { 0, 0, 1 } }
    before = link
  end
  local start = world.energy.kinetic + world.energy.potential
  for _ = 1, 60 do
    world:step()
    expect(world.energy.kinetic + world.energy.potential):near(start, 1e-7 * 3 * g)
  end
  world:close()

  world = world_of()
  world:floor { friction = 0.3, restitution = 0.5 }
  world:box { size = { 0.4, 0.2, 0.6 }, mass = 5, at = { 0, 1, 0 }, velocity = { 3, 0, 1 }, spin = { 1, 2, 3 }, friction = 0.3,
              restitution = 0.5 }
  local most = world.energy.kinetic + world.energy.potential
  for _ = 1, 120 do
    world:step()
    local e = world.energy
    expect(e.kinetic + e.potential):at_most(most + 1e-7 * 5 * g)
    expect(math.abs(e.numerical)):below(1e-6 * 5 * g)
    most = math.min(most, e.kinetic + e.potential)
  end
end)

scenario("the work of a push is the energy it gives", function()
  local world = world_of { gravity = { 0, 0, 0 } }
  local body = world:box { size = { 1, 0.5, 0.3 }, mass = 2, spin = { 0, 1, 0.5 } }
  local start = world.energy.kinetic
  body:push { force = { 3, 1, -2 }, at = { 0.3, 0.1, 0 }, lasts = 1 }
  world:run(2)
  expect(world.energy.work_in):near(world.energy.kinetic - start, 1e-7)
  expect(#(body.velocity * 2 - { 3, 1, -2 })):below(1e-10)
end)

-- ---- where the world stands, and how it is turned ----

-- Scenes placed by p (points), d (directions) and q (a rotation)
local scenes = {}

function scenes.tumble(world, p, d, q)
  world:plane { normal = d { 0, 1, 0 }, offset = p { 0, 0, 0 }:dot(d { 0, 1, 0 }), friction = 0.5, restitution = 0.3 }
  world:box { size = { 0.5, 0.3, 0.2 }, mass = 1, at = p { 0, 0.6, 0 }, rotation = q, velocity = d { 1, 0, 0.5 }, spin = d { 1, 3, 2 },
              friction = 0.5, restitution = 0.3 }
end

function scenes.chain(world, p, d, q)
  local before
  for i = 1, 4 do
    local link = world:box { size = { 0.5, 0.1, 0.1 }, mass = 1, at = p { i / 2 - 0.25, 0, 0 }, rotation = q, collides = false }
    world:ball_joint { a = link, b = before, at = p { i / 2 - 0.5, 0, 0 } }
    before = link
  end
  before:hit { impulse = d { 0, 0, 1 } }
end

function scenes.slide(world, p, d, q)
  world:plane { normal = d { 0, 1, 0 }, offset = p { 0, 0, 0 }:dot(d { 0, 1, 0 }), friction = 0.4 }
  world:box { size = { 0.6, 0.2, 0.4 }, mass = 1, at = p { 0, 0.1, 0 }, rotation = q, velocity = d { 2, 0, 0 }, spin = d { 0, 4, 0 },
              friction = 0.4 }
  world:ball { radius = 0.1, mass = 1, at = p { 0, 0.1, 2 }, rotation = q, velocity = d { 2, 0, 1 }, friction = 0.4 }
end

-- Positions after 1 s, brought back to where the scene would be unmoved
local function result(name, turn, shift, step)
  local function d(v) return turn:rotate(v) end
  local function p(v) return turn:rotate(v) + shift end
  local world = world_of { gravity = d { 0, -g, 0 }, accuracy = "study", step = step }
  scenes[name](world, p, d, turn)
  world:run(1)
  local list = {}
  for i, b in ipairs(dynamic(world)) do
    list[i] = { turn:inverse():rotate(b.position - shift), turn:inverse() * b.rotation }
  end
  world:close()
  return list
end

local function difference(a, b)
  local worst = 0
  for i = 1, #a do worst = math.max(worst, #(a[i][1] - b[i][1]), (a[i][2]:inverse() * b[i][2]).angle) end
  return worst
end

local nowhere, unturned = digbox.vec(0, 0, 0), digbox.quat { axis = { 0, 1, 0 }, angle = 0 }

for _, name in ipairs { "tumble", "chain", "slide" } do
  scenario(("moving the world by 1024 m changes nothing: %s"):format(name), function()
    local here = result(name, unturned, nowhere)
    expect(difference(here, result(name, unturned, digbox.vec(1024, 0, 0)))):below(1e-9)
    -- moved along its normal, a floor's gaps are rounded to 2e-13 m, more than the lowest bounces that are followed (1e-13 of a size)
    expect(difference(here, result(name, unturned, digbox.vec(-1024, 1024, 1024)))):below(name == "tumble" and 1e-6 or 1e-9)
  end)

  scenario(("turning the world changes nothing: %s"):format(name), function()
    local here = result(name, unturned, nowhere)
    expect(difference(here, result(name, digbox.quat { axis = { 1, 0, 0 }, angle = math.pi / 2 }, nowhere))):below(1e-9)
    expect(difference(here, result(name, digbox.quat { axis = { 0.3, -0.5, 0.8 }, angle = 2.1 }, nowhere))):below(1e-9)
  end)
end

-- ---- the frame step ----

-- Smooth scenes at t = 1 s, whatever the frame step: as alike as the tolerance asks
local function at_one_second(build, step)
  local world = world_of { step = step }
  local body = build(world)
  world:run { steps = math.floor(1 / step + 0.5) }
  local position, rotation = body.position, body.rotation
  world:close()
  return { { position, rotation } }
end

local smooth = {
  { "a pendulum", 1e-8, function(world)
    local body = rod(world, { 0.5, 0, 0 })
    world:hinge { a = body, at = { 0, 0, 0 }, axis = { 0, 0, 1 } }
    return body
  end },
  { "a tumbling free body", 1e-8, function(world)
    return world:box { size = { 1, 0.6, 0.2 }, mass = 1, spin = { 0.1, 5, 0.1 }, velocity = { 1, 2, 3 } }
  end },
  { "a mass on a spring", 1e-8, function(world)
    local body = world:ball { radius = 0.1, mass = 1, at = { 1, 0, 0 } }
    world:spring { a = body, at_b = { 0, 0, 0 }, stiffness = 40, length = 0.8 }
    return body
  end },
  { "a bouncing ball", 1e-8, function(world)
    world:floor { restitution = 0.8, friction = 0.3 }
    return world:ball { radius = 0.1, mass = 1, at = { 0, 1, 0 }, velocity = { 1, 0, 0 }, restitution = 0.8, friction = 0.3 }
  end },
}

for _, case in ipairs(smooth) do
  local name, bound, build = table.unpack(case)
  scenario(("the frame step does not matter: %s"):format(name), function()
    local reference = at_one_second(build, 1 / 60)
    expect(difference(reference, at_one_second(build, 1 / 120))):below(bound)
    expect(difference(reference, at_one_second(build, 1 / 37))):below(bound)
  end)
end
