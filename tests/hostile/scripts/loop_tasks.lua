-- threat: tasks that start two tasks each, and wait for nothing
-- expect: limit
local world = require("digbox").world {}
local function breed(task)
  world:spawn(breed)
  world:spawn(breed)
  pcall(task.wait, task)
end
while true do pcall(world.spawn, world, breed) pcall(world.step, world) end
