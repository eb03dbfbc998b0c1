-- scenes.lua: each part in a world of its own; prints the sum of its state after every tenth frame, and calls and bytes of all
-- effects. Run by zero.sh with the whole program and with programs that lack an effect.
local digbox = require "digbox"
local parts = require "parts"

for _, name in ipairs(parts.names) do
  local fine, message = pcall(function()
    local world = digbox.world {}
    local bodies = parts.build[name](world, digbox.vec(0, 0, 0))
    for _ = 1, 12 do
      world:step(10)
      print(name, "sum", world:checksum(), (parts.state_of(bodies):gsub("\n", " ")))
    end
    local effects, list = world:effects(), {}
    for effect, e in pairs(effects) do list[#list + 1] = ("%s effect %s calls %d bytes %d"):format(name, effect, e.calls, e.bytes) end
    table.sort(list)
    print(table.concat(list, "\n"))
    world:close()
  end)
  if not fine then print(name, "failed", message) end
end
