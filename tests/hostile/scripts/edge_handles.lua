-- threat: bodies that are gone, and methods of others
-- expect: ok
local world = require("digbox").world {}
local ball, other = world:ball { radius = 0.1 }, require("digbox").world {}:ball { radius = 0.1 }
ball:remove()
assert(not pcall(ball.remove, ball) and not pcall(ball.push, ball, { force = { 0, 0, 1 } }) and not ball.valid)
assert(not pcall(ball.push, world, {}) and not pcall(world.step, ball) and not pcall(world.weld, world, { a = other }))
assert(getmetatable(ball) == false and not pcall(setmetatable, ball, {}) and not pcall(rawset, ball, 1, 1))
world:close()
assert(not pcall(world.step, world) and not pcall(function() return ball.mass end))
print "fine"
