-- threat: questions that ask questions: effects, regions, handlers and transforms that ask while a question is tried
-- expect: any
local digbox = require "digbox"
local world = digbox.world {}
world:floor {}
local a, b = world:box { size = 0.2, at = { 0, 0.1, 0 } }, world:box { size = 0.2, at = { 0.25, 0.1, 0 } }
local function ask(body) return pcall(body.can_move, body, { along = { 1, 0, 0 }, by = 0.1, within = 100 }) end
world:add_effect { name = "asker", step = function(_, bodies) for _, c in ipairs(bodies) do ask(c) ask(a) end end }
world:region { sphere = { radius = 5 }, laws = { force = function(c) ask(c) return { 0, 0, 0 } end } }
for _, event in ipairs { "contact_begin", "impact", "moved", "message", "link" } do world:on(event, function() ask(b) a:send(b, "x") end) end
world:spawn(function(task) while true do ask(a) task:wait() end end)
for _ = 1, 3 do ask(a) pcall(a.flood, a, "x", 1, { transform = function() ask(b) return 1 end }) pcall(world.step, world) end
for _ = 1, 1e6 do ask(b) end
print "fine"
