-- threat: worlds read and write in their folders only
-- expect: ok
local digbox = require "digbox"
local world = digbox.world {}
for _, path in ipairs { "/etc/passwd", "../up.dig", "a/../../up.dig", "/dev/full", "x\0y", "", "out/../../up.dig" } do
  assert(not pcall(world.save, world, path), path)
  assert(not pcall(digbox.load, path), path)
  assert(not pcall(world.mesh, world, { file = path }), path)
  assert(not pcall(world.render, world, { to = path .. "/../../../up.png" }), path)
end
print "fine"
