-- threat: handles as keys and values of weak tables, while their worlds come, go and are collected
-- expect: ok
local digbox = require "digbox"
local keys, values, both = setmetatable({}, { __mode = "k" }), setmetatable({}, { __mode = "v" }), setmetatable({}, { __mode = "kv" })
local names, held = {}, {}       -- held: what a script still has is still there
for i = 1, 60 do
  local w = digbox.world {}
  local a, b = w:ball { radius = 0.1 }, w:ball { radius = 0.1, at = { 1, 0, 0 } }
  names[i] = {}
  local j = w:spring { a = a, b = b, stiffness = 1 }
  for _, h in ipairs { a, b, j, a.dig, w, w:snapshot(), w:region { sphere = { radius = 1 } }, a.position } do
    names[i][tostring(h)] = true
    keys[h], values[i .. tostring(h)], both[h] = { h, w }, h, h
  end
  held[i .. tostring(a)] = a
  w:step()
  keys[a], keys[w] = { keys }, { a, keys[b] }
  if i % 3 == 0 then w:close() elseif i % 3 == 1 then b:remove() end
  local junk = {}
  for k = 1, 2000 do junk[k] = { k } end
end
for _ = 1, 20 do local junk = {} for k = 1, 5000 do junk[k] = { k } end end
-- What is left hangs on the collector: looked up it may be nil, gone through it may not be.
for at, a in pairs(held) do assert(values[at] == a and keys[a] and both[a] == a) end
for i = 1, 60 do
  for name in pairs(names[i]) do
    local h = values[i .. name]
    if h then
      pcall(function() return h.position end) pcall(function() h:step() end) pcall(function() h:remove() end)
      keys[h], both[h] = nil, { keys[h], both[h] }
    end
  end
end
for _, t in ipairs { keys, values, both } do
  for _, walk in ipairs { pairs, next } do
    local ok, why = pcall(walk, t)
    assert(not ok and tostring(why):find("weak table", 1, true), why)
  end
end
print "fine"
