-- plank_falls.lua: planks that fall on each other, flush or not, gain no energy and do not sink into each other.
-- Only in the plain build: figures of long runs; soft_planks.lua runs the same code under sanitizers.
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- n planks of 2 m one above the other, 25 mm between them, each `shift` farther along than the one below, or across it
local function pile(world, n, shift, crossed)
  for i = 1, n do
    local y = 1 + 0.05 * i
    local from, to = { shift * i, y, 3 }, { 2 + shift * i, y, 3 }
    if crossed and i % 2 == 0 then from, to = { 1, y, 2 }, { 1, y, 4 } end
    world:plank { from = from, to = to, width = 0.2, height = 0.025, material = "oak" }
  end
end

-- Lets it fall: the most that energy rises above the least before, J, over what there was; the deepest overlap, m; what the integration
-- makes up, of the whole
local function fall(world, seconds)
  local least, rise, made, first = math.huge, 0, 0, nil
  for _ = 1, math.floor(seconds / world.frame + 0.5) do
    local e = world.energy
    local now = e.kinetic + e.potential + e.elastic
    first = first or now
    least = math.min(least, now)
    rise, made = math.max(rise, now - least), math.max(made, math.abs(e.numerical))
    world:step()
  end
  return rise / first, world:stats().worst_penetration, made / first
end

-- An end face that the next piece covers is no surface: pieces of two flush planks that lie askew by one made contacts along the planks,
-- against the stiffness of their axis, and 233 J became 1e11.
local falls = { sketch = { { 30, 3 }, { 30, 6 }, { 60, 4 }, { 120, 3 } }, play = { { 30, 3 }, { 30, 5 }, { 60, 6 }, { 120, 3 } },
  study = { { 30, 4 }, { 60, 3 } } }
for _, plan in ipairs { "sketch", "play", "study" } do
  scenario(("planks that fall on each other gain nothing, flush or not, at %s"):format(plan), function(s)
    for _, case in ipairs(falls[plan]) do
      for _, shift in ipairs { 0, 1e-6, 1e-3, 0.03 } do
        local world = s:world { accuracy = plan, step = 1 / case[1] }
        world:floor {}
        pile(world, case[2], shift)
        local rise, deep, made = fall(world, 0.65)
        expect(rise):below(1e-5)
        expect(deep):below(0.02 * 0.025)
        expect(made):below(0.01)
      end
    end
  end)
end

scenario("planks that fall across each other gain nothing", function(s)
  for _, frame in ipairs { 1 / 30, 1 / 60 } do
    for _, n in ipairs { 3, 4 } do
      local world = s:world { step = frame }
      world:floor {}
      pile(world, n, 0, true)
      local rise, deep = fall(world, 0.65)
      expect(rise):below(1e-5)
      expect(deep):below(0.02 * 0.025)
    end
  end
end)

-- What is left of a plank that breaks is short. Its joints were swept then, and what lay in something was moved out of it as if nothing
-- were bent by that: up to 42 kJ came into its joints so, where 8 kJ moved, and one broke at that.
scenario("planks that break under what falls on them gain nothing", function(s)
  for _, frame in ipairs { 1 / 30, 1 / 60 } do
    for i = 4, 16, 4 do
      local world = s:world { step = frame }
      world:floor {}
      local plank = world:plank { from = { -1, 1.03, 0 }, to = { 1, 1.03, 0 }, width = 0.3, height = 0.01 + 0.0025 * i, material = "steel",
        segments = 6 + i % 7, from_end = "pinned", to_end = "pinned", strength = 5e7 }
      for k = 1, 3 do
        world:box { size = 0.3, mass = plank.mass * (0.5 + k), at = { -0.7 + 0.37 * k, 1.2 + 0.5 * k, 0 },
          rotation = { axis = { 0.3, 0.2, 1 }, angle = 0.4 * k * i } }
      end
      local least, rise, most = math.huge, 0, 0
      for _ = 1, math.floor(2 / frame + 0.5) do
        world:step()
        local e = world.energy
        local now = e.kinetic + e.potential + e.elastic
        least, rise, most = math.min(least, now), math.max(rise, now - least), math.max(most, e.kinetic)
      end
      expect(plank.broken):at_least(2)
      expect(rise / most):below(1e-3)                       -- 0.007 to 0.107 in seven of these eight before
      expect(world.energy.numerical / most):below(0.06)     -- 0.09 to 2.4 in seven of these eight before
      expect(world:stats().worst_residual):below(1e-3)      -- m/s
    end
  end
end)
