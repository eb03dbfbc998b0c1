-- laws_spec.lua: every small world measures what its law expects. Each world is run as it stands and hands back a list of
-- { what, measured, expected, tolerance }; the tolerance is the world's own and stands there with its reason.
local test = require "digbox.test"

local worlds = {                            -- world, how many values it measures at least
  { "01_drop", 4 }, { "02_slope", 3 }, { "03_rolling", 4 }, { "04_collision", 5 }, { "05_cradle", 2 },
  { "06_pendulum", 3 }, { "07_spinning_box", 3 }, { "08_tipping", 3 }, { "09_stack", 6 }, { "10_arch", 3 },
  { "11_gears", 3 }, { "12_spring", 6 }, { "13_room", 4 }, { "14_three_spheres", 9 }, { "15_landscape", 3 },
  { "16_integrators", 9 }, { "floating_crate", 7 }, { "hot_iron", 6 }, { "mirror_room", 7 }, { "bridge", 8 }, { "sawn_plank", 6 },
  { "orbit", 5 }, { "everything", 8 },
  { "lava_lamp", 5 }, { "bolted_door", 8 }, { "cog_board", 8 },
}

for _, world in ipairs(worlds) do
  local name, count = table.unpack(world)
  test.scenario(name .. " shows its law", function()
    local law = require(name)
    test.expect(#law):at_least(count)
    for _, row in ipairs(law) do
      local what, measured, expected, tolerance = table.unpack(row)
      test.expect(what):is_not(nil)
      test.expect(measured):near(expected, tolerance)
    end
  end)
end
