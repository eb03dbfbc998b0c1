-- soft_falls.lua: cloth and lattices that fall on what stands gain no energy, however stiff and fine they are.
-- Only in the plain build: figures of long runs; soft_bodies.lua runs the same code under sanitizers.
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- Lets it fall: the most that energy rises above that of the start, and what the integration makes up, both over that of the start
local function fall(world, seconds)
  local first, rise = world.energy.total, 0
  for _ = 1, math.floor(seconds / world.frame + 0.5) do
    world:step()
    rise = math.max(rise, world.energy.total - first)
  end
  return rise / first, math.abs(world.energy.numerical) / first
end

local function cloth(world, height, n, stiffness, pins)
  return world:cloth { at = { -0.5, height, -0.5 }, across = { 1, 0, 0 }, down = { 0, 0, 1 }, mass = 0.3, stiffness = stiffness,
    columns = n, rows = n, pins = pins or "none" }
end

local function ball(world) world:ball { radius = 0.3, at = { 0, 0.3, 0 }, fixed = true } end
local function shelf(world) world:box { size = { 1, 0.5, 2 }, at = { 0.5, 0.25, 0 }, fixed = true } end

-- Where a few sweeps were all that a cloth of more than 9 x 9 got, 2.35 J became 5.8 (16 x 16, 1000 N), 53 (10,000 N) and 170 J (24 x 24).
local falls = {
  { "on a ball", ball, 0.8, { { 10, 10000 }, { 16, 30 }, { 16, 1000 }, { 16, 10000 } } },
  { "on an edge", shelf, 0.7, { { 10, 1000 }, { 16, 30 }, { 16, 10000 } } },
  { "on the floor", function() end, 0.2, { { 16, 1000 } } },
}
for _, plan in ipairs { "sketch", "play" } do
  for _, on in ipairs(falls) do
    scenario(("a cloth that falls %s gains no energy, at %s"):format(on[1], plan), function(s)
      for _, case in ipairs(on[4]) do
        local world = s:world { accuracy = plan }
        world:floor {}
        on[2](world)
        cloth(world, on[3], case[1], case[2])
        local rise, made = fall(world, 1)
        expect(rise):below(1e-3)
        expect(made):below(0.1)
      end
    end)
  end
end

scenario("a cloth that hangs by two corners falls on a ball and gains no energy", function(s)
  local world = s.world
  world:floor {}
  ball(world)
  cloth(world, 1, 12, 1000, { { 1, 1 }, { 12, 1 } })
  local rise, made = fall(world, 1.5)
  expect(rise):below(1e-3)
  expect(made):below(0.1)
end)

scenario("a cloth of 24 x 24 gains no energy on a ball, and a lattice of 125 particles none on an edge", function(s)
  local world = s:world {}
  world:floor {}
  ball(world)
  cloth(world, 0.8, 24, 10000)
  expect((fall(world, 0.5))):below(1e-3)
  world = s:world {}
  world:floor {}
  world:box { size = { 0.2, 0.2, 2 }, at = { 0, 0.1, 0 }, fixed = true }
  world:lattice { at = { 0.05, 0.8, 0 }, size = 0.5, cells = 4, mass = 2, stiffness = 10000 }
  local rise, made = fall(world, 1)
  expect(rise):below(1e-3)
  expect(made):below(0.01)
end)
