-- threat: coroutine.close runs __close, which never ends
-- expect: limit
local co = coroutine.create(function()
  local _ <close> = setmetatable({}, { __close = function() repeat until false end })
  coroutine.yield()
end)
coroutine.resume(co)
coroutine.close(co)
