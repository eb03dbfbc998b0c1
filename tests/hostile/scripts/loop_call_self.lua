-- threat: a value that is called through itself
-- expect: limit
local meta = {}
local value = setmetatable({}, meta)
meta.__call = value
value()
error "not reached, or caught by the depth of calls"
