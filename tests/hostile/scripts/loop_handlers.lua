-- threat: handlers that add handlers, at the same event
-- expect: limit
local w = require("digbox").world {}
w:floor {} w:ball { radius = 0.1, at = { 0, 0.5, 0 }, restitution = 1 }
local function again() w:on("contact_begin", again) w:on("contact_begin", again) w:on("impact", again) end
again()
w:run(1e5)
