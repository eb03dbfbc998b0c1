-- threat: world functions with tables that lie
-- expect: any
local world = require("digbox").world {}
local liar = setmetatable({}, { __index = function() error "asked" end, __len = function() return 1 << 60 end, __pairs = function() while true do end end })
local round = {} round[1], round.at = round, round
for _, v in ipairs { liar, round, { {} }, { 1 }, { 1, 2, 3, 4 }, { 0 / 0, 0, 0 }, { 1 / 0, 0, 0 }, ("9"):rep(1000), "1e999 m", -1, 0, 1e300, print } do
  for _, field in ipairs { "radius", "at", "mass", "velocity", "rotation", "name", "material", "spin", "group" } do
    pcall(world.ball, world, { [field] = v })
  end
  pcall(world.box, world, { size = v }) pcall(world.hull, world, { points = v }) pcall(world.run, world, { steps = v }) pcall(world.on, world, v, v)
  pcall(world.mesh, world, { vertices = v, triangles = v }) pcall(world.ray, world, { from = v, to = v }) pcall(world.region, world, v)
end
world:step(3)
print "fine"
