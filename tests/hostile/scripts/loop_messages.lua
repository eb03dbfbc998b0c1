-- threat: messages that answer themselves, at once, a moment later, and to all
-- expect: stop
local world = require("digbox").world {}
local bodies = {}
for i = 1, 50 do bodies[i] = world:box { size = 0.1, at = { i * 0.1, 0, 0 } } end
world:step(2)
for _, body in ipairs(bodies) do
  body:on("message", function(e)
    pcall(e.to.send, e.to, e.from, "again")
    pcall(e.to.send_neighbours, e.to, "again", 1, { after = 1e-300 })
    pcall(e.to.flood, e.to, "again", 1)
    pcall(e.to.dig.broadcast, e.to.dig, "again", 1, { after = 0.01 })
  end)
end
bodies[1]:send(bodies[2], "first")
while true do world:step() end
