-- thin_rods.lua: trees of thin rods and balls on a hub that a motor turns about any axis: joints hold, and nothing comes from nowhere.
-- About its own axis such a rod has a thousandth or less of the inertia that it has across it: of what its joints give across it, turned a
-- little, a share is a whirl along it. Before substeps were cut by that, 13 of these 16 runs had joints 6 cm to 7e7 m apart.
local digbox = require "digbox"
local test = require "digbox.test"
local vec, quat = digbox.vec, digbox.quat

-- The same world for a seed on every machine: numbers from lowest to highest (Lehmer).
local function numbers(seed)
  local state = seed
  return function(lowest, highest)
    state = state * 16807 % 2147483647
    return lowest + state / 2147483647 * (highest - lowest)
  end
end

local function direction(number)
  local z, a = number(-1, 1), number(0, 2 * math.pi)
  local r = math.sqrt(1 - z * z)
  return vec(r * math.cos(a), z, r * math.sin(a))
end

-- Rods of 3 to 30 mm, 0.2 to 1 m and 1 g to 3 kg; no two touch each other.
local function tree(world, number)
  local middle = vec(0, 2, 0)
  local hub = world:box { size = 0.2, mass = number(0.5, 5), at = middle, group = -1 }
  world:hinge { a = hub, at = middle, axis = direction(number), motor = { speed = number(-15, 15) } }
  local ends = { { hub, middle } }
  for _ = 1, 6 do
    local from, way, length = ends[math.floor(number(1, #ends + 0.999))], direction(number), number(0.2, 1)
    local thick, mass = 10 ^ number(-2.5, -1.5), 10 ^ number(-3, 0.5)
    local rod = world:box { size = { thick, length, thick }, mass = mass, at = from[2] + way * (length / 2), group = -1,
                            rotation = quat { from = { 0, 1, 0 }, to = way } }
    local tip = from[2] + way * length
    if number(0, 1) < 0.7 then world:hinge { a = rod, b = from[1], at = from[2], axis = direction(number) }
    else world:ball_joint { a = rod, b = from[1], at = from[2] } end
    if number(0, 1) < 0.4 then
      local ball = world:ball { radius = 0.05, mass = 10 ^ number(-1, 1), at = tip, group = -1 }
      world:ball_joint { a = ball, b = rod, at = tip }
    end
    ends[#ends + 1] = { rod, tip }
  end
end

for _, rate in ipairs { 30, 60 } do
  for seed = 1, 8 do
    test.scenario(("tree %d of thin rods on a motor holds together, at 1/%d s"):format(seed, rate), function(s)
      local world = s:world { step = 1 / rate }
      tree(world, numbers(1000003 * seed))
      local apart, most = 0, 0
      for _ = 1, 3 * rate do
        world:step()
        for _, joint in ipairs(world:joints()) do apart = math.max(apart, joint.error) end
        most = math.max(most, world.energy.kinetic)
      end
      test.expect(apart):below(0.05)
      test.expect(world.energy.numerical):near(0, 0.05 * most)
    end)
  end
end
