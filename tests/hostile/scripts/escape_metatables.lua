-- threat: the tables that digbox itself lives by: its types, events, callbacks and answers, changed from outside
-- expect: ok
local digbox = require "digbox"
local world, next, ipairs, type = digbox.world {}, next, ipairs, type
world:floor {}
local ball = world:ball { name = "b", radius = 0.1, at = { 0, 0.15, 0 } }
local joint = world:hinge { a = ball }
for _, h in ipairs { world, ball, joint, ball.dig, ball.position, digbox.quat {}, world:snapshot(), world:region { sphere = { radius = 1 } },
  world:on("moved", print), world:spawn(function(t) t:wait(9) end), world:camera {}, digbox.box { size = 1 }, digbox.parts } do
  assert(getmetatable(h) == false or getmetatable(h) == nil or type(getmetatable(h)) == "string", tostring(h))
  assert(not pcall(setmetatable, h, {}), tostring(h))
  for _, k in ipairs { "__index", "__gc", "__name", "__metatable", "step", "remove", 1 } do
    pcall(rawset, h, k, function() error "mine" end) pcall(function() h[k] = function() error "mine" end end)
    pcall(rawget, h, k) pcall(next, h, k) pcall(rawlen, h) pcall(rawequal, h, k) pcall(function() return h .. h end)
    pcall(function() return h < h end) pcall(function() return #h end) pcall(function() return h() end) pcall(function() return h // 2 end)
  end
end
-- What events and answers hold belongs to the script: changing it changes nothing else.
world:on("contact_begin", function(e) for k in next, e do e[k] = world end e.self, e.event = nil, 5 end)
local seen = 0
world:on("contact_begin", function(e) assert(e.self.valid) seen = seen + 1 end)
for _, list in ipairs { world:bodies(), world:joints(), world:stats(), world.energy, world:effects(), world:messages(), world:warnings(), ball:links(),
  world:digs(), ball:can_move { along = { 0, 1, 0 } } } do
  if type(list) == "table" then for k in next, list do list[k] = nil end end
end
math.random, math.floor, table.insert, table.sort, string.format = nil
_G.ipairs, _G.pairs, _G.next, _G.type, _G.tostring, _G.select, _G.pcall, _G.error = nil
joint:remove()
world:run(0.5)
world:check()
print "fine"
