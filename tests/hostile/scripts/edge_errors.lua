-- threat: errors that are worlds, bodies, vectors, coroutines, functions and nothing, out of every callback
-- expect: ok
local digbox = require "digbox"
local function make()
  local w = digbox.world {} w:floor {}
  w:ball { name = "a", radius = 0.1, at = { 0, 0.15, 0 } }
  return w
end
local w = make()
local values = { w, w:find "a", digbox.vec(1, 2, 3), digbox.quat {}, coroutine.create(print), print, 5, true, {}, w:snapshot(), digbox,
  setmetatable({}, { __tostring = function() error "again" end }), setmetatable({}, { __tostring = function() return 5 end }),
  setmetatable({}, { __name = ("x"):rep(1e5) .. "\27[2J" }), ("y"):rep(1e6), "\27]0;title\7", "a\0b" }
for i = 0, #values do
  for _, way in ipairs {
    function(v, f) v:on("contact_begin", f) v:step(60) end, function(v, f) v:add_effect { name = "e", step = f } v:step() end,
    function(v, f) v:spawn(f) end, function(v, f) v:run { seconds = 1, stop_when = f } end,
    function(v, f) v:region { sphere = { radius = 9 }, laws = { force = f } } v:step() end,
    function(v, f) v:find "a":flood("x", 1, { transform = f }) v:step() end } do
    local v = make()
    pcall(way, v, function() error(values[i], 0) end)
    pcall(v.step, v) v:check() v:close()
  end
end
print "fine"
