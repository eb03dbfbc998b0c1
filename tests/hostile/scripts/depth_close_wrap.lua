-- threat: the same, where each is closed by its own failure
-- expect: any
local function fall(n)
  local _ <close> = setmetatable({}, { __close = function() if n > 0 then pcall(coroutine.wrap(fall), n - 1) end end })
  error "falls"
end
print(pcall(coroutine.wrap(fall), 20000))
