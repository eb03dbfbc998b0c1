-- threat: yields out of every function of digbox that calls back, then resumed from elsewhere, or never
-- expect: ok
local digbox = require "digbox"
local yield = coroutine.yield
local ways = {
  function(w) w:add_effect { name = "e", step = yield } w:step() end,
  function(w) w:add_effect { name = "e", step = print, bodies = yield } w:step() end,
  function(w) w:add_effect { name = "e", step = function() end, energy = yield } return w.energy end,
  function(w) w:region { sphere = { radius = 9 }, laws = { force = yield } } w:step() end,
  function(w) w:on("moved", yield) w:step() end,
  function(w) w:on("contact_begin", yield) w:step(60) end,
  function(w) w:run { seconds = 1, stop_when = yield } end,
  function(w) w:spawn(yield) w:step() end,
  function(w) w:spawn(function(task) task:wait_until(yield) end) w:step(3) end,
  function(w) w:spawn(function(task) yield(task) task:wait() end) w:step(3) end,
  function(w) w:find "a":flood("x", 1, { transform = yield }) w:step() end,
  function(w) w:find "a":send { route = "flood", name = "x", value = 1, transform = yield } w:step() end,
  function(w) table.sort({ 3, 2, 1 }, yield) end,
  function(w) ("abc"):gsub("b", yield) end,
  function(w) load(yield) end,
  function(w) setmetatable({}, { __index = yield, __close = yield, __gc = yield }).x = 1 end,
  function(w) local t <close> = setmetatable({}, { __close = yield }) w:step() end,
  function(w) w:on("removed", yield) w:find "a":remove() w:step() end,
}
for i, way in ipairs(ways) do
  local w = digbox.world {}
  w:floor {}
  local a, b = w:ball { name = "a", radius = 0.1, at = { 0, 0.3, 0 } }, w:ball { name = "b", radius = 0.1, at = { 0.2, 0.3, 0 } }
  w:weld { a = a, b = b }
  local co = coroutine.create(function() return pcall(way, w) end)
  for _ = 1, 5 do coroutine.resume(co, true) end
  coroutine.close(coroutine.create(function() pcall(way, w) end))
  coroutine.wrap(function() pcall(w.step, w) end)()
  pcall(w.check, w)
  if i % 2 == 0 then pcall(w.close, w) end
end
print "fine"
