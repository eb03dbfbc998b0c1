-- threat: variables to be closed that cannot be, or fail
-- expect: ok
print(pcall(function() local _ <close> = 4 end))
local function failing() return setmetatable({}, { __close = function(_, e) error("closing " .. tostring(e), 0) end }) end
print(pcall(function() local _ <close> = failing() local _ <close> = failing() error("body", 0) end))
local meta = { __close = function() end }
print(pcall(function() local _ <close> = setmetatable({}, meta) meta.__close = nil end))
print "fine"
