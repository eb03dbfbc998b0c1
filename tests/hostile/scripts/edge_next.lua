-- threat: traversals that are disturbed
-- expect: ok
print(pcall(next, {}, "none")) print(pcall(next, { 1 }, 2)) print(pcall(next)) print(pcall(pairs)) print(next {})
local t = {} for i = 1, 200 do t["k" .. i] = i end
for k in pairs(t) do t[k] = nil end assert(next(t) == nil)
for i = 1, 200 do t["k" .. i] = i end
pcall(function() for k in next, t do t[k] = nil t[k .. "!"] = 1 if #k > 30 then break end end end)
print(pcall(pairs, { [{}] = 1, [{}] = 2 })) for k in pairs { [print] = 1 } do print(k == print) end
print "fine"
