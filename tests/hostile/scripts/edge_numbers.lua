-- threat: the ends of the integers, and no number
-- expect: ok
local I, N = math.maxinteger, math.mininteger
assert(I + 1 == N and N // -1 == N and N % -1 == 0 and not pcall(function() return 1 // 0 end) and not pcall(function() return 1 % 0 end))
local n = 0
for _ = I - 1, I do n = n + 1 end
for _ = N + 1, N, -1 do n = n + 1 end
for _ = 1, 0 / 0 do n = n + 100 end
assert(n == 4 and not pcall(function() for _ = 1, 2, 0 do n = 0 end end))
print "fine"
