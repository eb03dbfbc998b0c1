-- threat: every error is caught, and the loop begins anew
-- expect: limit
local function spin() while true do local _ = {} end end
for _ = 1, math.huge do pcall(pcall, spin) end
