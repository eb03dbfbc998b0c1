-- threat: a text that doubles
-- expect: limit
local s = "0123456789" while #s > 0 do s = s .. s end
