-- extremes.lua: bodies where none can be; ratios, spins and heights beyond all use (A11, A12). Numbers stay finite, nothing explodes.
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local FASTEST = 50               -- m/s: of what nobody pushed, within metres of where it began

-- After each of so many steps every number is finite and nothing is faster than `most`, m/s.
local function stays_sane(world, steps, most)
  local worst = 0
  for _ = 1, steps do
    world:step()
    for _, b in ipairs(world:bodies()) do
      local sum = #b.position + #b.velocity + #b.spin
      if sum ~= sum or sum == math.huge then error(("%s is at %s, %s, %s"):format(b, b.position, b.velocity, b.spin)) end
      worst = math.max(worst, b.speed)
    end
  end
  expect(worst):below(most)
  expect(world:stats().rejected):is(0)
  world:check()
end

scenario("two bodies in one place", function(s)
  s.world:floor {}
  for _ = 1, 2 do s.world:box { size = 0.5, at = { 0, 0.25, 0 } } end
  for _ = 1, 2 do s.world:ball { radius = 0.2, at = { 3, 0.2, 0 } } end
  for _ = 1, 2 do s.world:capsule { radius = 0.1, length = 0.4, at = { 6, 0.3, 0 } } end
  stays_sane(s.world, 600, FASTEST)
end)

scenario("a hundred bodies in one point", function(s)
  s.world:floor {}
  for _ = 1, 100 do s.world:ball { radius = 0.1, at = { 0, 0.5, 0 } } end
  stays_sane(s.world, 600, 2 * FASTEST)                 -- they come apart at up to 53 m/s
end)

scenario("a body inside another", function(s)
  s.world:floor {}
  s.world:box { size = 1, at = { 0, 0.5, 0 } }
  s.world:box { size = 0.2, at = { 0.1, 0.4, 0.05 } }
  s.world:ball { radius = 0.6, at = { 4, 0.6, 0 } }
  s.world:ball { radius = 0.1, at = { 4.1, 0.7, 0 } }
  stays_sane(s.world, 600, FASTEST)
end)

-- They have no velocity while they are moved apart, and are not to fall asleep meanwhile. Placed under, over and beside what is heavy.
for _, mass in ipairs { 3, 100, 1000 } do
  for _, rate in ipairs { 30, 60, 120 } do
    scenario(("0.1 kg deep in %d kg comes free, and sleeps only then (1/%d s)"):format(mass, rate), function(s)
      for _, deep in ipairs { 0.2, 0.5 } do
        for _, heavy_at in ipairs { { 0, 1.5 - deep, 0 }, { 1 - deep, 0.5, 0 }, { 0, 0.5, 0 } } do
          local world = s:world { step = 1 / rate }
          world:floor {}
          local under = heavy_at[1] + heavy_at[2] > 0.5
          local light = world:box { size = 1, mass = 0.1, at = { 0, under and 0.5 or 1.5 - deep, 0 } }
          local heavy = world:box { size = 1, mass = mass, at = heavy_at }
          stays_sane(world, math.ceil(1.3 * rate), 3)
          expect(light.asleep and heavy.asleep):is(true)
          local apart = heavy.position - light.position
          expect(math.max(math.abs(apart.x), math.abs(apart.y), math.abs(apart.z))):near(1, 1e-3)
        end
      end
    end)
  end
end

scenario("what cannot come free sleeps nevertheless", function(s)
  s.world:floor {}
  s.world:box { size = { 1, 0.2, 1 }, at = { 0, 0.8, 0 }, fixed = true }
  local jammed = s.world:box { size = 0.9, mass = 1, at = { 0, 0.45, 0 } }       -- by 0.2 m too high for its place
  s:eventually("it sleeps", "1 s", function() return jammed.asleep end)
end)

scenario("a million to one", function(s)
  s.world:floor {}
  s.world:box { size = 1, mass = 1e-2, at = { 0, 0.5, 0 } }
  s.world:box { size = 1, mass = 1e4, at = { 0, 1.5, 0 } }
  stays_sane(s.world, 3600, FASTEST)
end)

scenario("ten thousand radians a second", function(s)
  s.world:floor {}
  s.world:box { size = { 0.5, 0.3, 0.1 }, at = { 0, 1e3, 0 }, spin = { 1e4, 10, 1 }, gravity_scale = 0 }
  s.world:ball { radius = 0.1, at = { 3, 0.1, 0 }, spin = { 0, 0, 1e4 } }
  stays_sane(s.world, 3600, 0.1 * 1e4)                  -- no faster than its own rim
end)

scenario("from a thousand kilometres", function(s)
  s.world:floor {}
  local ball = s.world:ball { radius = 0.1, at = { 0, 1e6, 0 }, restitution = 0.5 }
  stays_sane(s.world, 3600, 9.81 * 60 + 1)
  expect(ball.position.y):near(1e6 - 9.81 * 60 ^ 2 / 2, 9.81 * 60 / 60)
  local stone = s.world:ball { radius = 0.1, at = { 5, 1e6, 0 }, velocity = { 0, -5e4, 0 } }
  stays_sane(s.world, 1800, 6e4)                        -- it meets the floor at more than 50 km/s
  expect(stone.position.y):above(-0.05)
end)
