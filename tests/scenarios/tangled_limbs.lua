-- tests/scenarios/tangled_limbs.lua - jointed figures made inside each other come apart without being thrown.
--
-- What overlaps is healed by speeds where joints are solved with contacts. A shin between a trunk and its upper arm lies so near the
-- shoulder that the arm would have to whirl at 65 rad/s for it: three figures made within 0.4 m flew off with 1e22 J of 4 kJ.
local test = require "digbox.test"
local digbox = require "digbox"
local expect = test.expect

for seed = 1, 4 do
  test.scenario(("three figures within 0.4 m, %d"):format(seed), function(s)
    local world = s.world
    world:floor { friction = 0.6 }
    math.randomseed(seed)
    for i = 1, 3 do
      local function aside() return 0.4 * (math.random() - 0.5) end
      digbox.parts.ragdoll(world, { name = "figure " .. i, at = { aside(), 0.7 + 2 * aside(), aside() },
        along = { aside(), 0, math.random() } })
    end
    local fastest, before, gained = 0, nil, 0
    for _ = 1, 240 do
      world:step()
      for _, body in ipairs(world:bodies()) do fastest = math.max(fastest, body.speed) end
      local total = world.energy.total
      if before then gained = math.max(gained, total - before) end
      before = total
    end
    expect(fastest):below(15)                           -- of what falls as deep: 7
    expect(gained):below(0.05 * world.energy.initial)   -- in a step
    expect(world.energy.total):below(0.3 * world.energy.initial)
    for _, joint in ipairs(world:joints()) do expect(joint.error):below(1e-3) end
  end)
end
