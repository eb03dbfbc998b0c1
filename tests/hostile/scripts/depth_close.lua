-- threat: coroutines that close each other in a long chain (Lua 5.4.4 runs off its stack)
-- expect: any
local last
for _ = 1, 25000 do
  local before = last
  last = coroutine.create(function()
    local _ <close> = setmetatable({}, { __close = function() if before then coroutine.close(before) end end })
    coroutine.yield()
  end)
  coroutine.resume(last)
end
print(coroutine.close(last))
