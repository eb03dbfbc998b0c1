-- threat: traversals that are disturbed
-- expect: ok
print(pcall(next, {}, "none")) print(pcall(next, { 1 }, 2)) print(pcall(next)) print(pcall(pairs)) print(next {})
local t = {} for i = 1, 200 do t["k" .. i] = i end
for k in pairs(t) do t[k] = nil end assert(next(t) == nil)
-- Clearing what comes is allowed, by next as by pairs: every key once, in order.
for _, way in ipairs { function(u) return next, u end, pairs } do
  local u, seen = { 1, 2, 3, [2.5] = 1, [-7] = 1, a = 1, b = 2, c = 3, [true] = 1, [print] = 1 }, {}
  for k in way(u) do u[k] = nil seen[#seen + 1] = tostring(k) end
  assert(next(u) == nil)
  assert(table.concat(seen, " ") == "-7 1 2 2.5 3 a b c true function", table.concat(seen, " "))
end
for i = 1, 200 do t["k" .. i] = i end
pcall(function() for k in next, t do t[k] = nil t[k .. "!"] = 1 if #k > 30 then break end end end)
print(pcall(pairs, { [{}] = 1, [{}] = 2 })) for k in pairs { [print] = 1 } do print(k == print) end
print "fine"
