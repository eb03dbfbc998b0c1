-- threat: films of 10^9 frames, a hundred at a time, each in a folder of its own
-- expect: limit
local world = require("digbox").world { step = 0.1 }
world:ball { radius = 0.1, velocity = { 1, 0, 0 } }
for i = 1, 100 do
  world:record { to = ("film%03d/deep/f-%%09d.png"):format(i), fps = 1e5, size = { 16, 16 }, samples = 0 }
end
world:run(1e4)
