-- threat: coroutines that each run a little: each counts its instructions from zero
-- expect: limit
while true do
  local co = coroutine.wrap(function() for _ = 1, 50 do coroutine.yield() end end)
  co() co()
end
