-- threat: coroutines in every wrong state
-- expect: ok
local own own = coroutine.create(function() print(coroutine.resume(own)) print(pcall(coroutine.close, own)) print(coroutine.status(own)) end)
print(coroutine.resume(own)) print(coroutine.resume(own)) print(coroutine.close(own))
print(pcall(coroutine.wrap(function() error { "table" } end)))
print(coroutine.resume(coroutine.create(function() table.sort({ 2, 1 }, coroutine.yield) end)))
print(coroutine.resume(coroutine.create(function() return ("x"):gsub("x", coroutine.yield) end)))
print(coroutine.resume(coroutine.create(function() for _ in ("x"):gmatch(".") do coroutine.yield(1) end end)))
local w = coroutine.wrap(function() return 1 end) w() print(pcall(w))
print(select("#", coroutine.resume(coroutine.create(function(...) return ... end), table.unpack({}, 1, 240))))
print "fine"
