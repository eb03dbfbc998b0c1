-- thesis_rooms.lua: rows 4, 5 and 94 of the behaviours: a room in which everything moves, barrels in a rack, a toss over a fence, a
-- plank that is carried to a door, and what is taken from under a pile.
-- Only in the plain build: thousands of shots over seconds; mesh_rooms.lua and test_crowd.c run the same code under sanitizers.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- Numbers in [0, 1) that are the same on every machine (Park & Miller 1988, Comm. ACM 31, 1192)
local function dice(seed)
  return function(low, high)
    seed = seed * 48271 % 2147483647
    return low + (high - low) * (seed / 2147483647)
  end
end

local half, wall = 4, 0.01

local function closed_room(world)
  for axis = 1, 3 do
    for side = -1, 1, 2 do
      local size, at = { 2 * half + 2 * wall, 2 * half + 2 * wall, 2 * half + 2 * wall }, { 0, 0, 0 }
      size[axis], at[axis] = wall, side * (half + wall / 2)
      world:box { fixed = true, size = size, at = at, friction = 0.5 }
    end
  end
end

local makes = {
  function(w, f, s) f.radius = s / 2 return w:ball(f) end,
  function(w, f, s) f.size = { s, 0.7 * s, 0.5 * s } return w:box(f) end,
  function(w, f, s) f.radius, f.length = s / 4, s / 2 return w:capsule(f) end,
  function(w, f, s) f.radius, f.height = s / 3, s / 2 return w:cylinder(f) end,
}

local function outside(bodies)
  local n = 0
  for _, b in ipairs(bodies) do
    local p = b.position
    if math.max(math.abs(p.x), math.abs(p.y), math.abs(p.z)) > half then n = n + 1 end
  end
  return n
end

-- With 5 as the seed two bodies got out in the first frame before what goes through a wall was put back to it. Of 16 rooms five had
-- 2.3 to 4.4 mm in two frames running before what has one point was put apart in place in every step; now they have 0.3 to 1.6.
local function room_of_shots(s, seed)
  local world, between, bodies = s:world {}, dice(seed), {}
  closed_room(world)
  for i = 0, 999 do
    local at = { -3.5 + 7 / 9 * (i % 10), -3.5 + 7 / 9 * (i // 10 % 10), -3.5 + 7 / 9 * (i // 100) }
    local v = digbox.vec(between(-1, 1), between(-1, 1), between(-1, 1)):normalized() * between(1, 200)
    bodies[i + 1] = makes[i % 4 + 1](world, { at = at, velocity = v, mass = 1, friction = 0.5 }, between(0.1, 0.3))
  end
  local before, lasts = 0, 0
  for frame = 1, 45 do
    world:step()
    expect(outside(bodies)):is(0)
    local deep = world:stats().penetration
    if frame > 30 then lasts = math.max(lasts, math.min(before, deep)) end        -- what is there in two frames running
    before = deep
  end
  expect(lasts):below "2 mm"
end

scenario("row 4: of 1000 bodies at 1 to 200 m/s none passes walls of 10 mm, and after half a second none stays 2 mm in another", function(s)
  room_of_shots(s, 5)
  room_of_shots(s, 4)
  room_of_shots(s, 2)        -- 2.9 mm before
end)

scenario("rows 4 and 94: whatever is no boundary moves when pushed by twice its friction", function(s)
  local world, between, bodies = s.world, dice(94), {}
  world:floor { friction = 0.5 }
  for i = 0, 39 do
    bodies[i + 1] = makes[i % 4 + 1](world, { at = { 2 * (i % 8), 0.2, 2 * (i // 8) }, mass = 10 ^ between(-2, 3), friction = 0.5 }, 0.4)
  end
  s:settle "3 s"
  local before = {}
  for i, b in ipairs(bodies) do
    before[i] = b.position
    b:push { force = 2 * 0.5 * b.mass * 9.81, along = { 1, 0, 0 }, lasts = "0.3 s" }
  end
  world:run "0.3 s"
  for i, b in ipairs(bodies) do expect(b.position.x - before[i].x):above "10 cm" end          -- 0.22 m of what slides
end)

scenario("row 5: nine barrels lie in a rack behind a plank, and roll out when it is gone", function(s)
  local world, barrels = s.world, {}
  local lean = math.rad(10)
  local turn = digbox.quat { axis = { 0, 0, 1 }, angle = ("%.17g rad"):format(-lean) }
  local function on(x, y) return { x * math.cos(lean) + y * math.sin(lean), 3 - x * math.sin(lean) + y * math.cos(lean), 0 } end
  world:floor { friction = 0.6 }
  world:box { fixed = true, size = { 6, 0.1, 2 }, at = on(3, -0.05), rotation = turn, friction = 0.6 }
  for i = 1, 9 do
    barrels[i] = world:cylinder { radius = 0.25, height = 0.8, mass = 20, friction = 0.6, at = on(6.6 - 0.62 * i, 0.25),
                                  rotation = digbox.quat { axis = { 1, 0, 0 }, angle = "90 deg" } }
  end
  local plank = world:box { name = "plank", fixed = true, size = { 0.05, 0.4, 2 }, at = on(6.27, 0.2), rotation = turn, friction = 0.1 }
  s:settle "2 s"
  expect(#barrels[1]:neighbours()):above(0)
  plank:remove()
  local worst, out = 0, 0
  for _ = 1, 240 do
    world:step()
    for _, b in ipairs(barrels) do
      local alone = #b:neighbours { kind = "contact" } == 0         -- in the rack, touching nothing that moves
      if b.position.y > 2 and b.position.x < 5.5 and b.speed > 1 and alone and b:touches(world:bodies()[2]) then
        worst = math.max(worst, math.abs(b.speed - 0.25 * #b.spin) / b.speed)
      end
    end
  end
  for _, b in ipairs(barrels) do out = out + (b.position.x > 6.2 and 1 or 0) end
  expect(out):at_least(6)
  expect(worst):below(0.05)
end)

-- How much it keeps is how deep it grazes: thrown up at 2.6 m/s instead of 2.65 it keeps 59 %.
scenario("row 5: a barrel that is thrown over a fence and grazes it keeps its way, and spins", function(s)
  local world = s.world
  world:floor { friction = 0.6 }
  world:box { fixed = true, size = { 0.1, 2, 4 }, at = { 3, 1, 0 }, friction = 0.6 }
  local barrel = world:cylinder { radius = 0.25, height = 0.8, mass = 20, friction = 0.6, at = { 0, 2, 0 }, velocity = { 7, 2.65, 0 },
                                  rotation = digbox.quat { axis = { 1, 0, 0 }, angle = "90 deg" } }
  s:eventually("it grazes the fence", "1 s", function() return #barrel.spin > 0.1 end)
  s:eventually("it is over the fence", "1 s", function() return barrel.position.x > 3.4 end)
  expect(barrel.velocity.x):above(0.6 * 7)
  expect(#barrel.spin):above "1 rad/s"
  expect(barrel.position.y):above "0.25 m"
end)

local function carrier(world, with)
  world:floor { friction = 0.5 }
  for side = -1, 1, 2 do world:box { fixed = true, size = { 0.2, 2.2, 2 }, at = { 2, 1.1, 1.5 * side } } end       -- a door of 1 m
  local man = world:box { name = "carrier", size = { 0.4, 1.7, 0.5 }, mass = 80, at = { 0, 0.86, 0 }, friction = 0.05 }
  local plank
  if with then
    plank = world:box { name = "plank", size = { 0.05, 0.2, 2.4 }, mass = 6, at = { 0.23, 1.2, 0 } }
    world:weld { a = plank, b = man, at = { 0.2, 1.2, 0 } }
  end
  return man, plank
end

scenario("row 5: who carries a plank across is stopped by the door that he passes without", function(s)
  local man = carrier(s.world, false)
  man:push { force = "200 N", along = { 1, 0, 0 }, lasts = "2 s", at = { 0, -0.4, 0 } }
  s.world:run "3 s"
  expect(man.position.x):above "2.5 m"
  local world = s:world {}
  local other, plank = carrier(world, true)
  other:push { force = "200 N", along = { 1, 0, 0 }, lasts = "2 s", at = { 0, -0.4, 0 } }
  world:run "3 s"
  expect(other.position.x):below "1.9 m"
  expect(plank.position.x):below "1.9 m"
end)

scenario("row 5: what is taken from under a pile wakes that pile in the same step, and no other", function(s)
  local world, piles = s.world, { {}, {} }
  world:floor {}
  for p = 1, 2 do
    for i = 1, 5 do piles[p][i] = world:box { size = 0.4, mass = 5, at = { 3 * p, 0.4 * i - 0.2, 0 } } end
  end
  s:eventually("both sleep", "5 s", function() return not (piles[1][5].awake or piles[2][5].awake) end)
  piles[1][1]:remove()
  world:step()
  for i = 2, 5 do
    expect(piles[1][i].awake):is(true)
    expect(piles[1][i].velocity.y):below "-0.1 m/s"                 -- it falls in that step
  end
  for i = 1, 5 do expect(piles[2][i].awake):is(false) end
end)
