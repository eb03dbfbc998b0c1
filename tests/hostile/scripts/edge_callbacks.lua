-- threat: a world that is stepped, closed and restored from its own callbacks
-- expect: ok
local world = require("digbox").world {}
world:floor {}
local snapshot, said = world:snapshot(), 0
world:ball { radius = 0.1, at = { 0, 0.09, 0 } }:on("contact_begin", function(e)
  for _, f in ipairs { function() world:step() end, function() world:close() end, function() world:restore(snapshot) end, function() world:run(1) end } do
    if not pcall(f) then said = said + 1 end
  end
  e.self:remove() pcall(e.self.remove, e.self) world:ball { radius = 0.1 }
end)
world:step(5)
assert(said == 0 or said == 4, said)
print "fine"
