-- threat: traversals inside traversals inside traversals
-- expect: limit
local t = {} for i = 1, 3000 do t["k" .. i] = i end
for a in pairs(t) do for b in next, t do for c in pairs(t) do if a == b .. c then print(a) end end end end
