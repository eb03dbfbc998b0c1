-- threat: counts, lengths and times beyond all measure, to every call that makes something of them
-- expect: ok
local digbox = require "digbox"
local world = digbox.world {}
local ball = world:ball { radius = 0.1, at = { 0, 5, 0 } }
local across, down = { 1, 0, 0 }, { 0, -1, 0 }
local huge = { 1e9, 2 ^ 31, 2 ^ 32, 2 ^ 53 + 1, math.maxinteger, math.mininteger, -1, 1e300, 1 / 0, -1 / 0, 0 / 0 }
for _, n in ipairs(huge) do
  local refused = {
    cloth = function() world:cloth { at = { 0, 9, 0 }, across = across, down = down, mass = 1, stiffness = 1, columns = n, rows = n } end,
    lattice = function() world:lattice { at = { 0, 9, 0 }, size = 1, cells = n, mass = 1, stiffness = 1 } end,
    plank = function() world:plank { from = { 0, 9, 0 }, to = { 1, 9, 0 }, width = 0.1, height = 0.1, segments = n } end,
    rope = function() world:rope { a = ball, at = { 0, 9, 0 }, segments = n } end,
    bucket = function() world:bucket { height = 1, top_radius = 1, segments = n } end,
    field = function() world:heightfield { size = { 1, 1, 1 }, columns = n, rows = n, heights = { 0 } } end,
    list = function() world:heightfield { size = { 1, 1, 1 }, heights = { [n == n and n or 1] = { 0 } } } end,
    world = function() digbox.world { threads = n } end,
    size = function() world:render { to = "x.png", size = { n, n } } end,
    samples = function() world:render { to = "x.png", samples = n } end,
    hops = function() ball:send { route = "flood", name = "x", hops = n, value = { n, n, n, n, n } } end,
    index = function() world:mesh { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 0, 1 } }, triangles = { { n, n, n } }, fixed = true } end,
  }
  for what, f in pairs(refused) do assert(not pcall(f), what .. " " .. n) end
end
assert(#world:bodies() == 1)
world:step(3)
world:check()
print "fine"
