-- threat: memory that is the engine's: worlds without number, each with a little in it
-- expect: limit
local digbox = require "digbox"
local keep = {}
while true do
  local w = digbox.world {}
  for i = 1, 20 do w:ball { radius = 0.1, at = { i, 0, 0 } } end
  w:step()
  keep[#keep + 1] = w
end
