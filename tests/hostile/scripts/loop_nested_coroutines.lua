-- threat: the loop is in a coroutine of a coroutine
-- expect: limit
coroutine.wrap(function() coroutine.wrap(function() while true do end end)() end)()
