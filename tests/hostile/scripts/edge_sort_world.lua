-- threat: comparators that yield, remove what is compared, step the world, sort again, or never agree
-- expect: ok
local digbox = require "digbox"
local world = digbox.world {}
for i = 1, 40 do world:ball { name = "b" .. i, radius = 0.1, at = { i * 7 % 41, i, 0 } } end
local function by(f)
  local list = world:bodies()
  return pcall(table.sort, list, f)
end
by(function(a, b) world:step() return a.position.x < b.position.x end)
by(function(a, b) return true end) by(function(a, b) return nil end) by(function(a, b) return math.random() < 0.5 end)
by(function(a, b) coroutine.yield() return a.position.y < b.position.y end)
local depth = 0
by(function(a, b)
  depth = depth + 1
  if depth < 150 then by(function(c, d) return c.position.x < d.position.x end) end
  depth = depth - 1
  return a.position.x < b.position.x
end)
by(function(a, b) if a.valid then a:remove() end return (b.valid and b.position.x or 0) < 0 end)
local t = {}
for i = 1, 100 do t[i] = i end
pcall(table.sort, t, function(a, b) for i = 1, 100 do t[i] = nil end return a > b end)
pcall(table.sort, t, function(a, b) t[#t + 1] = a return a < b end)
local lies = setmetatable({}, { __len = function() return 10 end, __index = function(_, i) return world:bodies()[i] end, __newindex = function() end })
pcall(table.sort, lies)
world:check()
print "fine"
