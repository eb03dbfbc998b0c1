-- threat: comparisons that make no sense
-- expect: ok
local function list() local t = {} for i = 1, 500 do t[i] = (i * 7717) % 503 end return t end
local r = 1
for _, less in ipairs { function() return true end, function(a, b) return a <= b end, function() r = r * 48271 % 2147483647 return r % 2 == 0 end,
  function() error "no" end, function(a, b) return (a ~= b) and nil end } do pcall(table.sort, list(), less) end
local t = list() pcall(table.sort, t, function(a, b) t[#t] = nil return a < b end)
print(pcall(table.sort, { 1, "x", {} })) pcall(table.sort, { 0 / 0, 2, 0 / 0, 1 })
print "fine"
