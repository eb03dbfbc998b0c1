-- threat: memory that is nobody's: joints, regions, subscriptions, cameras, lamps, materials, links, messages to come, without end
-- expect: limit
local digbox = require "digbox"
local world = digbox.world { gravity = { 0, 0, 0 } }
local a, b = world:ball { radius = 0.1 }, world:ball { radius = 0.1, at = { 1, 0, 0 } }
local n = 0
while true do
  n = n + 1
  for _, f in ipairs {
    function() world:spring { a = a, b = b, stiffness = 1e-9 } end, function() world:region { sphere = { radius = 1 }, at = { n * 3, 50, 0 } } end,
    function() world:on("moved", function() end) end, function() world:camera { name = "c" .. n, at = { n, 0, 0 }, look_at = a } end,
    function() world:lamp { at = { n, 1, 1 } } end, function() digbox.material("m" .. n, { like = "oak" }) end,
    function() world:link { a = a, b = b, layer = "thermal" } end, function() a:send(b, "m" .. n, n, { after = 1e6 }) end,
    function() a:push { force = { 0, 0, 1e-9 }, lasts = 1e9 } end, function() digbox.vec(n, n, n) end,
    function() world:spawn(function(t) t:wait(1e9) end) end } do pcall(f) end
end
