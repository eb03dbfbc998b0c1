-- threat: effects that add effects, regions that make regions, and an energy that never comes
-- expect: limit
local world = require("digbox").world {}
world:ball { radius = 0.1 }
local n = 0
local function add()
  n = n + 1
  pcall(world.add_effect, world, { name = "e" .. n, step = add, energy = function() while n > 50 do add() end return 0 end,
    bodies = function() return true end })
  pcall(world.region, world, { sphere = { radius = 1 }, laws = { force = function() add() return { 0, 0, 0 } end } })
end
add()
while true do pcall(world.step, world) add() local _ = pcall(function() return world.energy end) end
