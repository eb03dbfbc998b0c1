-- threat: handles as keys and values of weak tables, while their worlds come, go and are collected
-- expect: ok
local digbox = require "digbox"
local keys, values, both = setmetatable({}, { __mode = "k" }), setmetatable({}, { __mode = "v" }), setmetatable({}, { __mode = "kv" })
for i = 1, 60 do
  local w = digbox.world {}
  local a, b = w:ball { radius = 0.1 }, w:ball { radius = 0.1, at = { 1, 0, 0 } }
  local j = w:spring { a = a, b = b, stiffness = 1 }
  for _, h in ipairs { a, b, j, a.dig, w, w:snapshot(), w:region { sphere = { radius = 1 } }, a.position } do
    keys[h], values[i .. tostring(h)], both[h] = { h, w }, h, h
  end
  w:step()
  keys[a], keys[w] = { keys }, { a, keys[b] }
  if i % 3 == 0 then w:close() elseif i % 3 == 1 then b:remove() end
  local junk = {}
  for k = 1, 2000 do junk[k] = { k } end
end
for _ = 1, 20 do local junk = {} for k = 1, 5000 do junk[k] = { k } end end
local left = 0
for _, t in ipairs { keys, values, both } do
  local k, v = next(t)
  while k ~= nil do
    for _, h in ipairs { k, v } do pcall(function() return h.position end) pcall(function() h:step() end) pcall(function() h:remove() end) end
    left, k = left + 1, nil
  end
end
print "fine"
