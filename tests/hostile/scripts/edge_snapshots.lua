-- threat: snapshots of worlds that are closed, of others, of before and after, restored from everywhere
-- expect: ok
local digbox = require "digbox"
local function make(n)
  local w = digbox.world {} w:floor {}
  for i = 1, n do w:ball { name = "b" .. i, radius = 0.1, at = { i * 0.19, 0.15, 0 } } end
  return w
end
local w, other = make(5), make(3)
local empty, first = digbox.world {}:snapshot(), w:snapshot()
assert(not pcall(w.restore, w, empty) and not pcall(other.restore, other, first) and not pcall(w.restore, w, w))
local held = w:bodies()
for i = 1, 30 do
  w:step(2)
  local before = w:snapshot()
  local made = w:box { size = 0.1, at = { 0, 3, i } }
  w:add_effect { name = "e" .. i, step = function() pcall(w.restore, w, first) pcall(w.snapshot, w) end }
  w:on("moved", function(e) pcall(w.restore, w, before) pcall(e.self.remove, e.self) end)
  pcall(w.step, w)
  pcall(w.restore, w, i % 2 == 0 and before or first)
  pcall(function() return made.position end)
  for _, b in ipairs(held) do pcall(b.push, b, { force = { 0, 1, 0 } }) end
  w:check()
end
w:close()
assert(not pcall(w.restore, w, first) and not pcall(make(5).restore, make(5), first))
print "fine"
