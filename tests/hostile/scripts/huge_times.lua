-- threat: runs of 10^300 seconds, steps of 10^15, and a task that waits for the end of the world
-- expect: limit
local world = require("digbox").world {}
world:ball { radius = 0.1 }
world:spawn(function(task) while true do pcall(task.wait, task, 1e300) pcall(task.wait_until, task, function() return false end, 1e300) end end)
pcall(world.step, world, 2 ^ 53)
pcall(world.run, world, 1e300)
pcall(world.run, world, { seconds = 1e15, stop_when = function() return false end })
while true do world:step(1 << 30) end
