-- threat: every call that takes a path, with paths that lead out: films, pictures, saved worlds, models
-- expect: ok
local digbox = require "digbox"
local world = digbox.world {}
world:ball { radius = 0.1 }
local out = { "/etc/%s", "../up%s", "../../up%s", "a/../../../up%s", "./../up%s", "~/up%s", "//etc/%s", "a//../../../up%s", "/proc/self/mem%s",
  "/dev/stdout%s", "/proc/self/fd/1%s", "-o/../../up%s", ".%s", "..%s", "out/../../up%s", "\\..\\up%s", "%%2e%%2e/up%s", "|touch up%s", "$(touch up)%s",
  "; touch up%s", "concat:up|%s", "file:///up%s", "tcp://127.0.0.1/%s", "pipe:1%s", "x\n../up%s" }
for _, form in ipairs(out) do
  for _, how in ipairs {
    function() world:save(form:format "a.dig") end, function() world:render { to = form:format "a.png", size = { 8, 8 }, samples = 0 } end,
    function() world:record { to = form:format "-%d.png", fps = 60, size = { 8, 8 }, samples = 0 }:close() end,
    function() if form:find "[:|;]" then world:record { to = form:format ".mp4", fps = 60, size = { 8, 8 }, samples = 0 }:close() end end,
    function() digbox.load(form:format "a.dig") end, function() world:mesh { file = form:format "a.obj", fixed = true } end,
    function() world:mesh { file = form:format "passwd", fixed = true } end } do
    pcall(how)
  end
end
world:step(2)
print "fine"
