-- threat: names, units and keys that C would read only up to a NUL, or that act on a terminal
-- expect: ok
local digbox = require "digbox"
local world = digbox.world {}
local a = world:ball { radius = 1, name = "a", at = { 0, 5, 0 } }
local b = world:ball { radius = 1, name = "b", at = { 0, 9, 0 } }
local function refused(what, f, ...)
  local ok, m = pcall(f, ...)
  assert(not ok, what) assert(not m:find "[%z\1-\8\11-\31\127]", what) assert(#m < 5000, what)
end
local function of(name, fields) return function() world[name](world, fields) end end
for _, z in ipairs { "\0", "\0x", "\0\27[2J" } do
  for what, f in pairs {
    key = of("ball", { radius = 1, ["mass" .. z] = 2 }), unit = of("ball", { radius = "1 m" .. z }), number = of("ball", { radius = "1" .. z }),
    material = of("ball", { radius = 1, material = "oak" .. z }), colour = of("ball", { radius = 1, colour = "red" .. z }),
    name = of("ball", { radius = 1, name = "c" .. z }),
    choice = of("ball", { radius = 1, integrator = "verlet" .. z }), accuracy = function() digbox.world { accuracy = "play" .. z } end,
    get = function() return a["mass" .. z] end, set = function() a["mass" .. z] = 5 end, method = function() return a["push" .. z] end,
    property = function() return world["time" .. z] end, find = function() assert(world:find("a" .. z)) end,
    event = function() world:on("moved" .. z, print) end,
    effect = function() world:effect("drag" .. z, true) end, option = function() world:effect("drag", { ["density" .. z] = 1 }) end,
    sky = function() world:sky("clear" .. z) end,
    link = of("link", { a = a, b = b, layer = "electrical" .. z }), kind = function() a:neighbours { kind = "contact" .. z } end,
    layer = function() a:dig_of("electrical" .. z) end,
    path = function() digbox.path(a, b, { kind = "contact" .. z }) end, plan = function() a.dig:accuracy("study" .. z) end,
    camera = of("camera", { at = { 1, 1, 1 }, name = "eye" .. z }),
    mesh = of("mesh", { file = "a.obj" .. z }), save = function() world:save("a.dig" .. z) end,
    load = function() digbox.load("a.dig" .. z) end, picture = of("render", { to = "a.png" .. z, size = { 4, 4 } }),
    own = of("add_effect", { name = "own" .. z, step = print }),
    stage = of("add_effect", { name = "own", stage = "settle" .. z, step = print }), message = function() a:send(b, "hello" .. z) end,
    define = function() digbox.material("mine" .. z, { density = 5 }) end,
    of_material = function() digbox.material("mine2", { ["density" .. z] = 5 }) end, run = function() world:run("0.1 s" .. z) end,
    arguments = function() digbox.args { ["x" .. z] = 1 } end, module = function() require("digbox" .. z) end,
    motor = of("hinge", { a = a, at = { 0, 5, 0 }, axis = { 0, 1, 0 }, motor = { ["speed" .. z] = 1 } }) } do
    refused(what, f)
  end
end
world:close()
print "fine"
