-- threat: names that move the cursor, end a file, name another, or hold no characters at all, wherever a name can be given
-- expect: ok
local digbox = require "digbox"
local bad = { "\27[2J", "a\nb", "a\rb", "\0", "a\0b", "\7", "\127", "\u{9b}31m", "\u{85}", ("x"):rep(1e6), ("\u{10ffff}"):rep(100) }
local odd = { "", " ", "..", "/", "../../etc/passwd", "%s%n%99999d", "'; DROP", "<b>&amp;</b>", "\"", "\\", "\xff\xfe", "\xc0\x80", "\u{202e}abc",
  "nil", "__index", "__gc", "position", "CON", "a b" }
local world = digbox.world {}
local ball = world:ball { radius = 0.1, at = { 0, 9, 0 } }
local function give(name)
  local ways = {
    function() world:ball { name = name, radius = 0.1 } end, function() world:find(name) end, function() world:hinge { name = name, a = ball } end,
    function() digbox.material(name, { like = "oak" }) end, function() world:ball { radius = 0.1, material = name } end,
    function() world:camera { name = name } end, function() world:add_effect { name = name, law = name, step = function() end } end,
    function() world:effect(name, true) end, function() ball:send(ball, name) end, function() ball:on(name, print) end,
    function() world:on("message", { kind = name }, print) end, function() digbox.args { [name] = { default = 1, help = name, unit = name } } end,
    function() world:render { to = name, size = { 8, 8 } } end, function() world:record { to = name, fps = 1 } end,
    function() world:save(name) end, function() digbox.load(name) end, function() require(name) end, function() ball[name] = name end,
    function() return ball[name] end, function() world:digs(name) end, function() world:sky(name) end,
    function() world:truss { name = name, nodes = { [name] = { at = { 0, 0, 0 } }, B = { at = { 1, 0, 0 } } }, struts = { { name, "B" } }, stiffness = 1 } end,
    function() digbox.quantity("1 " .. name) end, function() digbox.parts[name](world, {}) end, function() world[name](world) end,
    function() world:room { size = 99 }:open(name) end, function() error(name) end, function() load(name, name)() end,
    function() ball.data = name tostring(ball) end,
  }
  local taken = 0
  for i, f in ipairs(ways) do
    local fine, message = pcall(f)
    if fine then taken = taken + 1 end
    if not fine and i < #ways - 3 and (#message > 4000 or message:find "[%z\1-\31\127]") then error("way " .. i .. ": " .. #message) end
  end
  return taken
end
for _, name in ipairs(bad) do give(name) local there, it = pcall(world.find, world, name) assert(not there or not it, #name) end
for _, name in ipairs(odd) do give(name) end
world:step()
world:check()
print "fine"
