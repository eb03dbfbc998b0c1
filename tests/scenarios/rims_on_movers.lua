-- rims_on_movers.lua: a cylinder that tips until it stands on its base meets what moves as what is fixed: it makes no energy.
--
-- A traced step in which the base comes flat is cut at that instant, and tried again as far as there. At its end the rim presses at another
-- point than it was tried with, and what came of that, 5e8 N and up to 385 m/s, was believed, though its own error said that it was worth
-- nothing.
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- Numbers in [low, high) (Park, Miller 1988)
local function dice(seed)
  local state = (seed * 7919 + 17) % 2147483647
  local function throw(low, high)
    state = state * 48271 % 2147483647
    return low + (high - low) * state / 2147483647
  end
  for _ = 1, 5 do throw(0, 1) end
  return throw
end

-- On a plate, beside another one; both go to and fro, or stand still.
local function tip(s, seed, moving)
  local world, d = s:world {}, dice(seed)
  local friction = d(0.3, 0.9)
  local under = world:box { kinematic = true, size = { 0.8, 0.1, 2 }, at = { 0, -0.05, 0 }, friction = friction }
  local side = world:box { kinematic = true, size = { 0.8, 0.3, 2 }, at = { 0.7, 0.3, 0 }, friction = friction }
  local radius, height, tilt = d(0.08, 0.15), d(0.15, 0.35), d(0.02, 0.4)
  local at = { d(0.05, 0.15), 0.02 + radius * math.sin(tilt) + 0.5 * height * math.cos(tilt), d(-0.3, 0.3) }
  local turn, spin = { axis = { 0, 0, 1 }, angle = tilt }, { 0, 0, d(-1, 1) }
  local can = world:cylinder { radius = radius, height = height, at = at, rotation = turn, friction = friction, spin = spin }
  local way, rate, phases = d(0.05, 0.2), d(2, 8), { d(0, 6), d(0, 6) }
  local fastest, made, before = 0, 0, 0
  for step = 1, 150 do
    for i, plate in ipairs(moving and { under, side } or {}) do
      local v = way * rate * math.cos(rate * step / 60 + phases[i])
      plate:drive { velocity = { v, 0.3 * v, 0 } }
    end
    world:step()
    local now = world.energy.numerical
    fastest = math.max(fastest, can.position.y > 0 and can.speed or 0)           -- else it has fallen off
    made, before = math.max(made, now - before), now
  end
  return fastest, made, way * rate
end

for _, seed in ipairs { 98, 191, 256, 471, 536, 600 } do
  scenario(("a cylinder comes to stand on a plate that could move: start %d"):format(seed), function(s)
    local fastest, made = tip(s, seed, false)
    expect(fastest):below(1.5)        -- m/s; it falls by some centimetres
    expect(made):below "1 mJ"         -- of 1 to 5 J
  end)
end

for _, seed in ipairs { 2, 78, 130, 182, 230, 234, 320, 448 } do
  scenario(("a cylinder is carried and pushed by two plates: start %d"):format(seed), function(s)
    local fastest, made, plates = tip(s, seed, true)
    expect(fastest):below(2 * plates + 1.5)
    expect(made):below "0.1 J"
  end)
end
