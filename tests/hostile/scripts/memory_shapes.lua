-- threat: memory that is the engine's: bodies of ever larger meshes, hulls and parts
-- expect: limit
local digbox = require "digbox"
local world = digbox.world {}
local n = 60
local heights = {}
for i = 1, n do
  heights[i] = {}
  for k = 1, n do heights[i][k] = (i * k % 7) / 10 end
end
local at = 0
while true do
  at = at + 10
  world:heightfield { size = { 9, 1, 9 }, heights = heights, at = { at % 1e6, 0, 0 }, fixed = true }
  local parts = {}
  for i = 1, 200 do parts[i] = digbox.box { size = 0.1, at = { i * 0.1, 0, 0 } } end
  world:body { parts = parts, at = { at % 1e6, 5, 0 } }
end
