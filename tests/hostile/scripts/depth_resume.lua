-- threat: coroutines inside coroutines inside coroutines
-- expect: any
local function inner() return coroutine.resume(coroutine.create(inner)) end
print(inner())
