-- threat: memory that is the engine's: snapshots, events, cameras, materials, notes
-- expect: limit
local digbox = require "digbox"
local w = digbox.world {} w:floor {}
for i = 1, 200 do w:box { size = 0.1, at = { i * 0.3, 1, 0 } } end
local keep = {}
while true do keep[#keep + 1] = w:snapshot() w:step() end
