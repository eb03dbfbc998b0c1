-- tests/scenarios/moved_stops.lua - a script sets limits of a joint far inside of where the joint is.
--
-- What is behind its stop is brought back by 3 m/s or 20 rad/s at most. Where joints and contacts are solved at once velocities do that,
-- and what was so moved kept them: 90 kg between jaws came back at 3 m/s against 20 kN, which made 1 kJ of nothing and gave it to what is
-- near. Now it goes where it is brought, with the velocity that it would have without that (keep_speed in engine/solve/sweep.c).
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- 90 kg between a jaw of 80 kg and one of 0.1 kg, that go along at 1.3 m/s
local function jaws(world)
  world:floor {}
  local load = world:box { size = 0.3, mass = 90, at = { 0, 1, 0 } }
  local joint
  for _, side in ipairs { -1, 1 } do
    local jaw = world:box { size = { 0.1, 0.4, 0.4 }, mass = side < 0 and 80 or 0.1, at = { 0.2 * side, 1, 0 } }
    local slider = world:slider { a = jaw, along = { 1, 0, 0 }, limits = { -0.5, 0.5 },
                                  motor = { speed = -1.3 * side, max_force = side < 0 and 2e4 or 1e3 } }
    joint = joint or slider
  end
  return joint, load
end

for _, step in ipairs { 30, 60, 240 } do
  scenario(("a stop set 0.32 m behind a driven jaw brings it back and leaves it no speed, 1/%d s"):format(step), function(s)
    local world = s:world { step = 1 / step }
    local joint, load = jaws(world)
    world:run "0.1 s"
    local before = world.energy
    joint.limits = { -0.3, -0.2 }
    local behind, fastest = joint.distance, 0
    expect(behind):above "0.1 m"
    for _ = 1, math.ceil(0.2 * step) do
      world:step()
      fastest = math.max(fastest, joint.speed, -joint.speed)
    end
    expect(joint.distance):near("-0.2 m", "0.1 mm")
    expect(fastest):below "0.1 m/s"                                -- 3 m/s
    expect(load.speed):below "1.4 m/s"                             -- friction of the jaw that goes back slows it
    local after = world.energy
    expect(after.lost - before.lost):at_least "0 J"                -- -1.1 kJ
    expect(after.work_in - before.work_in):above "-100 J"          -- -1.2 kJ of the motor that it was brought back against
    expect(math.abs(after.numerical)):below "3 J"
    s:expect_reliable()
  end)
end
