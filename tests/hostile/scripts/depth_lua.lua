-- threat: recursion without end
-- expect: error
local function down(n) return n + down(n + 1) end
return down(1)
