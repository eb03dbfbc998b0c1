-- threat: recursion without end, caught, with a handler that does the same
-- expect: ok
local function down(n) return n + down(n + 1) end
print(pcall(down, 1)) print(xpcall(down, function() return down(1) end, 1))
print "fine"
