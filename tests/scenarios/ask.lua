-- ask.lua: exploratory questions. Could this move? What would it need, and what holds it? Asking changes nothing.

local test = require "digbox.test"
local digbox = require "digbox"
local scenario, expect = test.scenario, test.expect

-- ---- a door with a heavy box behind it, and a bolt ----

-- The box stands against the door with one edge, at 0.40 m from the hinge, so that where it is pushed is no question; the face of the
-- door is smooth, so that friction there neither lifts the box nor presses it down.
local function door(world, what)
  world:floor {}
  local frame = world:box { name = "frame", fixed = true, size = { 0.1, 2.2, 0.1 }, at = { -0.06, 1.1, 0 } }
  local leaf = world:box { name = "door", mass = "10 kg", size = { 0.8, 2, 0.04 }, at = { 0.4, 1.01, 0 }, friction = 0 }
  world:hinge { name = "hinge", a = leaf, b = frame, at = { 0, 1, 0 }, axis = { 0, 1, 0 } }
  local box, bolt
  if what.box then
    local half = 0.15 * math.sqrt(2)
    box = world:box { name = "box", mass = "20 kg", size = 0.3, friction = 0.5, at = { 0.4, 0.15, -0.02 - half },
      rotation = digbox.quat { axis = { 0, 1, 0 }, angle = "45 deg" } }
  end
  if what.bolt then bolt = world:bolt { name = "bolt", holds = leaf, into = frame } end
  return leaf, box, bolt, frame
end

local function pull(force) return { along = { 0, 0, -1 }, with = force, at = { 0.75, 1, 0 }, by = "20 cm" } end

local g = 9.80665
local needed = 0.5 * 20 * g * 0.40 / 0.75          -- 52.30 N: torques about the hinge

scenario("40 N do not open a door with a heavy box behind it, and the answer says how much it needs", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  local leaf, box = door(world, { box = true })
  world:run(0.2)
  local before, answer = world:checksum(), leaf:can_move(pull "40 N")
  expect(answer.verdict):is "needs"
  expect(answer.ok):is(false)
  expect(answer.needs):near(needed, 0.01 * needed)
  expect(answer.blocked_by):is(box)
  expect(answer.chain):is { leaf, box, world:find "floor" }
  expect(math.abs(answer.moved)):below "1 mm"
  expect(world:checksum()):is(before)
end)

scenario("60 N open it, and doing it moves it that far", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  local leaf = door(world, { box = true })
  world:run(0.2)
  local answer = leaf:can_move(pull "60 N")
  expect(answer.verdict):is "free"
  expect(answer.ok):is(true)
  expect(answer.moved):near(0.2, 1e-9)
  leaf:push { force = "60 N", along = { 0, 0, -1 }, at = { 0.75, 1, 0 }, lasts = 5 }
  s:eventually("the handle has moved 20 cm", answer.time + 0.02, function()
    local handle = leaf.position + leaf.rotation:rotate { 0.35, 0, 0 }
    return handle.z <= -0.2 * 0.95
  end)
end)

scenario("a shot bolt holds the door whatever the push", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  local leaf, _, bolt, frame = door(world, { bolt = true })
  world:run(0.2)
  local answer = leaf:can_move(pull "60 N")
  expect(answer.verdict):is "blocked"
  expect(answer.needs):is(math.huge)
  expect(answer.blocked_by):is(bolt)
  expect(answer.held_by):is(bolt)
  expect(answer.chain):is { leaf, bolt, frame }
  expect(answer.because):contains "bolt 'bolt' holds it"
end)

scenario("with the box gone and no bolt 1 N is enough", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  local leaf = door(world, {})
  local answer = leaf:can_move(pull "1 N")
  expect(answer.verdict):is "free"
  expect(answer.ok):is(true)
  local turn = leaf:can_move { turn = { 0, 1, 0 }, by = "30 deg", with = "1 N m" }
  expect(turn.verdict):is "free"
  expect(turn.moved):near(math.rad(30), 1e-9)
end)

-- ---- the founding document's drawer ----

scenario("a bolted drawer says what holds it, and asking changes nothing", function(s)
  local world = s.world
  local cabinet = world:box { name = "cabinet", fixed = true, size = { 0.5, 0.5, 0.5 }, at = { 0, 0.25, -0.3 } }
  local drawer = world:box { name = "drawer", mass = "2 kg", size = { 0.4, 0.1, 0.4 }, at = { 0, 0.56, -0.2 } }
  local runner = world:slider { name = "runner", a = drawer, b = cabinet, along = { 0, 0, 1 }, limits = { 0, 0.35 } }
  local bolt = world:bolt { name = "bolt", holds = drawer, into = cabinet, strength = "500 N" }
  local tug = { along = { 0, 0, 1 }, by = "20 cm", with = "30 N" }
  local before, answer = world:checksum(), drawer:can_move(tug)
  expect(answer.ok):is(false)
  expect(answer.held_by):is(bolt)
  expect(answer.chain):is { drawer, bolt, cabinet }
  expect(world:checksum()):is(before)

  bolt:withdraw()
  expect(drawer:can_move(tug).ok):is(true)

  -- farther than its runner lets it: it says how far, and what stops it
  local far = drawer:can_move { along = { 0, 0, 1 }, by = "50 cm", with = "30 N" }
  expect(far.ok):is(false)
  expect(far.verdict):is "blocked"
  expect(far.moved):near(0.35, 1e-3)
  expect(far.held_by):is(runner)
end)

scenario("pulled harder than the bolt's strength, the answer says that it breaks", function(s)
  local world = s.world
  local wall = world:box { name = "wall", fixed = true, size = 0.5 }
  local plate = world:box { name = "plate", mass = 1, size = 0.2, at = { 0, 0, 0.36 } }
  local bolt = world:bolt { name = "bolt", holds = plate, into = wall, strength = "500 N" }
  local answer = plate:can_move { along = { 0, 0, 1 }, by = "1 m", with = "600 N" }
  expect(answer.verdict):is "free"
  expect(answer.because):contains ", and breaks bolt 'bolt'"
  expect(answer.consequences[1].what):is "broken"
  expect(answer.consequences[1].who):is(bolt)
  expect(bolt.valid):is(true)
end)

-- ---- the holder, not what guides ----

scenario("what stands against a door holds it, not its hinge, shut as it is", function(s)
  local world = s.world
  world:floor {}
  local leaf = world:box { name = "door", size = { 0.8, 2, 0.04 }, at = { 0.4, 1.005, 0 }, mass = 20, friction = 0 }
  world:hinge { name = "hinge", a = leaf, at = { 0, 1, 0 }, axis = { 0, 1, 0 }, limits = { "-110 deg", 0 } }
  local block = world:box { name = "block", fixed = true, size = 0.4, at = { 0.4, 0.2, 0.22 } }
  local outward = { along = { 0, 0, 1 }, at = { 0.75, 1, 0 }, by = "20 cm", with = "40 N" }
  local function holds(first, chain)
    local answer = leaf:can_move(outward)
    expect(answer.held_by):is(first)
    expect(answer.chain):is(chain)
    return answer
  end
  expect(holds(block, { leaf, block }).verdict):is "blocked"         -- before the first step, too
  world:run(0.2)
  expect(holds(block, { leaf, block }).because):is "body 'block' holds it, whatever the push"
  block:remove()
  local drum = world:cylinder { name = "drum", radius = 0.2, height = 0.4, mass = 20, friction = 0.5, at = { 0.4, 0.2, 0.22 } }
  world:run(0.2)
  local answer = holds(drum, { leaf, drum, world:find "floor" })
  expect(answer.needs):near(0.5 * 20 * 9.81 * 0.40 / 0.75, 0.1)
  expect(answer.because):contains "body 'drum', itself held by body 'floor', holds it; it needs"
  local inward = leaf:can_move { along = { 0, 0, -1 }, at = { 0.75, 1, 0 }, with = "40 N" }
  expect(inward.held_by.name):is "hinge"
end)

scenario("boxes in a row before a wall: the chain ends at the wall", function(s)
  local world, row = s.world, {}
  world:floor {}
  for i = 1, 3 do row[i] = world:box { name = "b" .. i, size = 0.5, mass = 10, at = { 0.5 * i, 0.25, 0 } } end
  local wall = world:box { name = "wall", fixed = true, size = { 0.5, 2, 2 }, at = { 2, 1, 0 } }
  local answer = row[1]:can_move { along = { 1, 0, 0 }, by = "5 cm", with = "100 N" }
  expect(answer.verdict):is "blocked"
  expect(answer.chain):is { row[1], row[2], row[3], wall }
  expect(answer.because):is "body 'b2', itself held by body 'wall', holds it, whatever the push"
end)

scenario("what nothing holds is slow by its own inertia, and moves in time", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local safe = world:box { name = "safe", size = 1, mass = 1000 }
  local function push(force, within) return safe:can_move { along = { 1, 0, 0 }, by = 1, with = force, within = within } end
  local slow = push("1 N", 5)
  expect(slow.verdict):is "needs"
  expect(slow.moved):near(0.0125, 1e-4)                 -- F t^2 / 2 m
  expect(slow.needs):near(80, 0.1)
  expect(slow.held_by):is(nil)
  expect(slow.because):contains "nothing holds it but its own inertia"
  expect(push(slow.needs, 5).ok):is(true)
  local long = push("1 N", 60)
  expect(long.ok):is(true)
  expect(long.time):near(math.sqrt(2 * 1000), 0.05)
end)

scenario("asked before the first step, a box on a floor names the floor", function(s)
  local world = s.world
  local floor = world:floor {}
  local box = world:box { name = "box", size = 1, mass = 100, at = { 0, 0.5, 0 } }
  local answer = box:can_move { along = { 1, 0, 0 }, with = "400 N" }
  expect(answer.needs):near(490.5, 0.5)
  expect(answer.held_by):is(floor)
end)

scenario("free and ok agree: who is stopped on its way is blocked, or needs more", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local post = world:box { name = "post", fixed = true, size = 0.1 }
  local dog = world:box { name = "dog", size = 0.2, at = { 0.5, 0, 0 }, mass = 5 }
  local leash = world:distance { name = "leash", a = dog, b = post, max = 0.8 }
  local answer = dog:can_move { along = { 1, 0, 0 }, by = 1, with = "10 N" }
  expect(answer.verdict):is "blocked"
  expect(answer.moved):near(0.3, 1e-3)
  expect(answer.held_by):is(leash)
  leash:remove()
  world:spring { name = "spring", a = dog, at = { 0, 0, 0 }, stiffness = 100, length = 0.5, damping = 50 }
  answer = dog:can_move { along = { 1, 0, 0 }, by = 0.2, with = "10 N" }
  expect(answer.verdict):is "needs"
  expect(answer.moved):near(0.1, 1e-3)
  expect(answer.needs):near(10, 0.5)
  expect(answer.because):contains "to go on it needs"
end)

-- ---- wheels ----

local function wheels(world, at, gears)
  local base = world:box { name = "base", fixed = true, size = 0.1, at = { 0, -1, 0 } }
  local wheel, axle = {}, {}
  for i, p in ipairs(at) do
    wheel[i] = world:cylinder { name = "wheel " .. i, radius = 0.1, height = 0.02, mass = 1, at = { p[1], 0, p[2] }, group = -1 }
    axle[i] = world:hinge { name = "axle " .. i, a = wheel[i], b = base, at = { p[1], 0, p[2] }, axis = { 0, 1, 0 } }
  end
  for _, g2 in ipairs(gears) do world:gear { a = axle[g2[1]], b = axle[g2[2]], ratio = { 1, -1 } } end
  return wheel
end

scenario("three wheels in a triangle contradict each other; four in a ring turn", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local three = wheels(world, { { 0, 0 }, { 0.2, 0 }, { 0.1, 0.17 } }, { { 1, 2 }, { 2, 3 }, { 3, 1 } })
  local answer = three[1]:can_move { turn = { 0, 1, 0 }, by = "30 deg", with = "2 N m" }
  expect(answer.verdict):is "conflict"
  expect(#answer.chain):is(3)
  local ring = wheels(world, { { 2, 0 }, { 2.2, 0 }, { 2.2, 0.2 }, { 2, 0.2 } }, { { 1, 2 }, { 2, 3 }, { 3, 4 }, { 4, 1 } })
  expect(ring[1]:can_move { turn = { 0, 1, 0 }, by = "30 deg", with = "2 N m" }.verdict):is "free"
end)

-- ---- how much? ----

scenario("without a push the answer is how much it needs: a block on a floor and one against a wall", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  world:floor { friction = 0.4 }
  local block = world:box { name = "block", mass = 5, size = 0.2, at = { 0, 0.1, 0 }, friction = 0.4 }
  world:run(0.2)
  local answer = block:can_move { along = { 1, 0, 0 } }
  expect(answer.verdict):is "needs"
  expect(answer.needs):near(0.4 * 5 * g, 0.01 * 0.4 * 5 * g)
  expect(answer.held_by.name):is "floor"
  world:box { name = "wall", fixed = true, size = { 0.1, 1, 1 }, at = { 0.15, 0.5, 0 } }
  world:run(0.2)
  local wall = block:can_move { along = { 1, 0, 0 } }
  expect(wall.verdict):is "blocked"
  expect(wall.held_by.name):is "wall"
  expect(block:can_move { along = { 0, 1, 0 } }.needs):near(5 * g, 0.05 * g)
end)

scenario("what is to be lifted is held by its weight alone", function(s)
  local world = s.world
  world:floor {}
  local crate = world:box { name = "crate", mass = "10 kg", size = 0.5, at = { 0, 0.25, 0 } }
  world:run(0.5)
  local answer = crate:can_move { along = { 0, 1, 0 }, by = "20 cm" }
  expect(answer.verdict):is "needs"
  expect(answer.needs):between(98.1, 98.3)
  expect(answer.held_by):is(nil)
  expect(answer.because):contains "its weight holds it; it needs 98."
end)

scenario("what is fixed says so; a free body moves at once", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local rock = world:box { name = "rock", fixed = true, size = 1 }
  local answer = rock:can_move { along = { 1, 0, 0 }, with = 1e6 }
  expect(answer.verdict):is "blocked"
  expect(answer.because):contains "fixed"
  local ball = world:ball { name = "ball", radius = 0.1, at = { 5, 0, 0 } }
  expect(ball:can_move { along = { 1, 0, 0 } }.verdict):is "free"
  expect(world:ask { body = ball, along = { 1, 0, 0 }, with = 1 }.ok):is(true)
end)

-- ---- what the copy of a DIG must not miss ----

scenario("what is thrown out of its surroundings meets what is farther away", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local ball = world:ball { name = "ball", radius = 0.1, mass = 1, at = { 0, 0, 0 } }
  local free = ball:can_move { along = { 1, 0, 0 }, with = "10 N", by = 20 }
  expect(free.ok):is(true)
  local rock = world:box { name = "rock", fixed = true, size = 1, at = { 10, 0, 0 } }
  local answer = ball:can_move { along = { 1, 0, 0 }, with = "10 N", by = 20 }
  expect(answer.ok):is(false)
  expect(answer.moved):near(9.4, 0.05)
  expect(answer.held_by):is(rock)
end)

scenario("what is pushed into others is said to move them, and by that name", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  for i = 1, 5 do world:ball { name = "far " .. i, radius = 0.1, at = { 100 * i, 0, 0 } } end
  local ball = world:ball { name = "ball", radius = 0.1, mass = 1, at = { 0, 0, 0 } }
  local other = world:ball { name = "other", radius = 0.1, mass = 1, at = { 0.5, 0, 0 } }
  local answer = ball:can_move { along = { 1, 0, 0 }, with = "10 N", by = 0.6 }
  expect(answer.ok):is(true)
  expect(#answer.consequences):is(1)
  expect(answer.consequences[1].who):is(other)
end)

scenario("the walls of a room hold, and are named", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  world:room { size = { 4, 3, 4 } }
  local box = world:box { size = 0.5, at = { 1.75, 0.25, 0 }, mass = 2 }
  world:run(0.5)
  local held = box:can_move { along = { 1, 0, 0 }, with = "30 N" }
  expect(held.verdict):is "blocked"
  expect(held.held_by):is "+x"
  local far = box:can_move { along = { -1, 0, 0 }, with = "30 N", by = 5 }
  expect(far.ok):is(false)
  expect(far.moved):near(3.5, 1e-3)
  expect(far.held_by):is "-x"
  expect(box:can_move({ along = { -1, 0, 0 } }).needs):near(0.5 * 2 * g, 0.01 * g)
end)

scenario("an effect of the script's own is asked, too", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  world:ball { name = "elsewhere", radius = 0.1, at = { 50, 0, 0 } }
  local ball = world:ball { name = "ball", radius = 0.1, mass = 1, at = { 0, 0, 0 } }
  local slots = {}
  world:add_effect { name = "wind", step = function(_, bodies)
    for _, b in ipairs(bodies) do
      slots[b.body.name] = true
      if b.body == ball then b.force = { -20, 0, 0 } end
    end
  end }
  expect(ball:can_move({ along = { 1, 0, 0 }, with = "10 N" }).ok):is(false)
  expect(ball:can_move({ along = { 1, 0, 0 }, with = "30 N" }).ok):is(true)
  expect(slots.ball):is(true)
end)

scenario("what a hundred others do does not change the answer", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  local leaf, box = door(world, { box = true })
  world:run(0.2)
  local alone = leaf:can_move(pull "40 N")
  for i = 1, 100 do world:box { size = 0.3, mass = 1, at = { 3 + i % 10, 0.15, 3 + i // 10 } } end
  local among = leaf:can_move(pull "40 N")
  expect(among.needs):is(alone.needs)
  expect(among.steps):is(alone.steps)
  expect(among.held_by):is(box)
  expect(among.steps):below(13)
end)

scenario("how much it needs counts for all the way", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  world:floor { friction = 0.5 }
  for i, gap in ipairs { 0.001, 0.01, 0.0101, 0.05, 0.15 } do
    local box = world:box { mass = 10, size = 1, at = { 0, 0.5, 3 * i }, friction = 0.5 }
    local wall = world:box { fixed = true, size = 1, at = { 1 + gap, 0.5, 3 * i } }
    local short = box:can_move { along = { 1, 0, 0 }, by = 0.9 * gap }
    expect(short.verdict == "needs" and short.ok):is(true)
    expect(short.needs):near(5 * g, 0.01)
    local long = box:can_move { along = { 1, 0, 0 }, by = 0.2 }
    expect(long.verdict):is "blocked"
    expect(long.ok):is(false)
    expect(long.blocked_by):is(wall)
    expect(long.moved):near(gap, 1e-4)
    expect(long.because):contains "N start it"
  end
  local first = world:box { mass = 100, size = 1, at = { 0, 0.5, 20 }, friction = 0.5 }
  world:box { mass = 100, size = 1, at = { 1.05, 0.5, 20 }, friction = 0.5 }
  local both = first:can_move { along = { 1, 0, 0 }, by = 0.2 }
  expect(both.verdict == "needs" and not both.ok):is(true)
  expect(both.needs):near(100 * g, 0.5)
end)

scenario("a door with a wedge behind it opens as far as that", function(s)
  local world = s:world { gravity = { 0, -g, 0 } }
  local parts_door = digbox.parts.door(world, { at = { 0, 0, 0 } })
  local leaf = parts_door.leaf
  world:box { fixed = true, size = 0.1, at = leaf.position + digbox.vec(0.35, 0, 0.08) }
  local answer = leaf:can_move { along = { 0, 0, 1 }, at = leaf.position + digbox.vec(0.35, 0, 0), by = "20 cm" }
  expect(answer.verdict):is "blocked"
  expect(answer.moved):near(0.0094, 2e-4)
end)

scenario("bad questions are refused at their line", function(s)
  local world = s.world
  local ball = world:ball { name = "ball", radius = 0.1 }
  expect(expect(function() ball:can_move { along = { 0, 0, 0 } } end):fails()):contains "must not be zero"
  expect(expect(function() ball:can_move { with = 3 } end):fails()):contains "along is missing"
  expect(expect(function() ball:can_move { along = { 1, 0, 0 }, with = "3 kg" } end):fails()):contains "mass"
  local back = expect(function() ball:can_move { along = { 1, 0, 0 }, by = -1 } end):fails()
  expect(back):contains "must be > 0: for the other way reverse the direction"
  expect(expect(function() ball:can_move { turn = { 0, 1, 0 }, by = "-30 deg" } end):fails()):contains "reverse the axis"
  expect(expect(function() ball:can_move { along = { 1, 0, 0 }, force = 1 } end):fails()):contains "unknown field 'force'"
  expect(expect(function() world:ask { along = { 1, 0, 0 } } end):fails()):contains "body is missing"
end)
