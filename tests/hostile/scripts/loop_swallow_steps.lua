-- threat: every error caught, in every callback at once, with xpcall handlers that go on
-- expect: limit
local world = require("digbox").world {}
world:floor {}
local ball = world:ball { radius = 0.1, at = { 0, 0.2, 0 } }
local function never() return xpcall(function() while true do error "x" end end, function() while true do end end) end
world:add_effect { name = "e", step = never }
world:on("moved", never) ball:on("contact_begin", never) world:spawn(never)
while true do pcall(world.step, world) pcall(world.run, world, { stop_when = never }) end
