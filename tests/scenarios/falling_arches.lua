-- Few bodies that fall over each other are a crowd while they do (engine/crowd/tumble.c): steps take little, nothing stays in anything
-- else, no energy is made, and they sleep. That what lands stands is held by the spiral in tall_stacks.lua.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local count = 15
local file = "falling_arch.dig"

-- A semicircular arch of radius 1 m on a floor of friction 1; below a thickness of 0.1075 it falls (Heyman 1966).
local function arch(world, thickness)
  local inner, outer = 1 - thickness / 2, 1 + thickness / 2
  world:floor { friction = 1 }
  for i = 1, count do
    local from, to, corners = math.pi * (i - 1) / count, math.pi * i / count, {}
    local mid = digbox.vec(math.cos((from + to) / 2), math.sin((from + to) / 2), 0)
    for _, angle in ipairs { from, to } do
      for _, r in ipairs { inner, outer } do
        for side = -1, 1, 2 do corners[#corners + 1] = digbox.vec(r * math.cos(angle), r * math.sin(angle), side * 0.2) - mid end
      end
    end
    world:hull { points = corners, at = mid, friction = 1 }
  end
end

-- A tower of twelve, about to be hit by a ball
local function tower(world, speed)
  world:floor { friction = 0.5 }
  for i = 1, 12 do world:box { size = { 0.4, 0.2, 0.3 }, at = { 0, 0.2 * (i - 0.5), 0 } } end
  world:ball { radius = 0.2, density = 3000, at = { -3, 1 + 0.2 * (speed - 6), 0.02 }, velocity = { speed, 2, 0 } }
end

local function energy(world) return world.energy.kinetic + world.energy.potential end

-- J  All that was won in single steps, while what was lost in others does not count.
local function run(world, frames)
  local before, made = energy(world), 0
  for _ = 1, frames do
    world:step()
    local now = energy(world)
    made = made + math.max(0, now - before)
    before = now
  end
  return made
end

-- Followed blow by blow, and solved to the last digit after each, four starts take 1.0e8 units of work; 1.5e7 as they are.
scenario("arches that fall take little work, make no energy and sleep", function(s)
  local work = 0
  for start = 0, 3 do
    local world = s:world {}
    arch(world, 0.09 + 1e-5 * start)
    expect(run(world, 240)):below(1e-5)                        -- J of 700
    local stats = world:stats()
    work = work + stats.work
    expect(stats.worst_penetration):below(3e-4)                -- m of 0.09
    expect(stats.penetration):below(1e-5)
    expect(stats.awake):is(0)
  end
  expect(work):below(2.5e7)
end)

-- What a crowd's step leaves deep, or makes energy in, is done again: not looked at, towers are left 0.8 mm deep; nor put apart, 2 mm, and
-- that is lifted (1.4 J).
scenario("towers that are hit are never deep and make no energy worth speaking of", function(s)
  local work = 0
  for speed = 7, 10 do
    local world = s:world {}
    tower(world, speed)
    expect(run(world, 300)):below(0.15)                        -- J of 6000 to 8000
    expect(world:stats().worst_penetration):below(6e-4)        -- 0.003 of the thickness, m
    work = work + world:stats().work
  end
  expect(work):below(1.5e8)                                    -- 3.0e8 blow by blow
end)

-- That steps were dear is part of the state.
scenario("an arch that falls is the same saved and loaded, put back, and on two threads", function()
  local function fall(threads, act)
    local world = digbox.world { threads = threads }
    arch(world, 0.09)
    for frame = 1, 120 do
      world:step()
      world = act and act(world, frame) or world
    end
    return world:checksum()
  end
  local plain = fall(1)
  expect(fall(2)):is(plain)
  expect(fall(1, function(world, frame)
    if frame % 5 ~= 0 then return end
    world:save(file)
    return digbox.load(file)
  end)):is(plain)
  expect(fall(1, function(world, frame)
    if frame % 10 ~= 0 then return end
    local moment = world:snapshot()
    for _ = 1, 3 do world:step() end
    world:restore(moment)
  end)):is(plain)
end)
