-- threat: weak metatables while there is no room (Lua 5.4.4 uses freed memory there)
-- expect: any
local kept = {}
pcall(function() for i = 1, math.huge do kept[i] = ("k"):rep(900) .. i end end)
for _ = 1, 40 do kept[#kept] = nil end
for _ = 1, 300 do
  local meta = setmetatable({ __newindex = {} }, { __mode = "kv" })
  pcall(function(t) for i = 1, 3000 do t[i] = i end end, setmetatable({}, meta))
end
print "fine"
