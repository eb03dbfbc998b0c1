-- threat: texts of texts
-- expect: error
local t = setmetatable({}, {}) getmetatable(t).__tostring = function() return tostring(t) end
return tostring(t)
