-- threat: worlds, bodies, effects, regions, tasks and films that vanish while somebody walks over them
-- expect: ok
local digbox = require "digbox"
local function make()
  local w = digbox.world {} w:floor {}
  for i = 1, 3 do w:ball { name = "b" .. i, radius = 0.1, at = { i * 0.15, 0.1, 0 } } end
  return w
end
local function clear(w) for _, b in ipairs(w:bodies()) do pcall(b.remove, b) end end
local acts = {
  function(w) clear(w) end, function(w) w:close() end, function(w) w:restore(w:snapshot()) end, function(w) w:step() end, function(w) w:save "x.dig" end,
  function(w) for _, j in ipairs(w:joints()) do j:remove() end end, function(w) digbox.load "x.dig" end, function(w) w:effect("contact", false) end,
  function(w) w:on("contact_begin", function() clear(w) end) end,
  function(w) w:spawn(function() clear(w) w:close() end) end, function(w) w:checksum() w:check() end,
  function(w) w:region { sphere = { radius = 9 }, laws = { force = function() clear(w) w:close() return { 0, 0, 0 } end } } end,
}
for _, act in ipairs(acts) do
  for _, way in ipairs {
    function(w, f) w:on("contact_begin", f) w:step(3) end, function(w, f) w:spawn(f) w:step(3) end,
    function(w, f) w:add_effect { name = "own", step = f } w:step(3) end,
    function(w, f) w:add_effect { name = "own", stage = "settle", step = f } w:step(3) end,
    function(w, f) w:run { seconds = 0.05, stop_when = f } end,
    function(w, f) w:region { sphere = { radius = 9 }, laws = { force = f } } w:step(3) end,
    function(w, f) w:find "b1":flood("x", 1, { transform = f }) w:step(3) end,
    function(w, f) for _, b in ipairs(w:bodies()) do f() pcall(b.push, b, { force = { 1, 0, 0 } }) end w:step() end } do
    local w = make()
    pcall(way, w, function() act(w) end)
    pcall(w.step, w, 3) pcall(w.check, w) pcall(w.close, w)
  end
end
print "fine"
