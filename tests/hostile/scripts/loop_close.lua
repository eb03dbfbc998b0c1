-- threat: a variable that is closed, without end, when its block is left by the limit
-- expect: limit
local function forever() while true do end end
local function hold() local _ <close> = setmetatable({}, { __close = forever }) while true do end end
pcall(hold)
print "alive"
