-- threat: nor by a field that comes later, which Lua ignores
-- expect: ok
local meta = {}
local value = setmetatable({}, meta)
meta.__gc = function() print "not fine" end
value, meta = nil, nil
for _ = 1, 1e5 do local _ = {} end
print "fine"
