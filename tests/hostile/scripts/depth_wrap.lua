-- threat: the same, by wrap
-- expect: error
local function inner() return coroutine.wrap(inner)() end
inner()
