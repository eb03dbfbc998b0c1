-- threat: arithmetic that calls itself through metamethods
-- expect: limit
local t = setmetatable({}, { __add = function(a) for _ = 1, math.huge do local _ = a end end })
return t + t
