-- threat: cameras at absurd places, with absurd angles, looking at themselves, at nobody and at what is gone; lamps and skies to match
-- expect: ok
local digbox = require "digbox"
local world = digbox.world {}
local ball, gone = world:ball { radius = 0.1 }, world:ball { radius = 0.1, at = { 1, 0, 0 } }
local far = { 0, 1e-300, 5e-324, 1e6, 1e12, 1e154, 1e300, -1e300 }
local function try(fields)
  fields.name = nil
  local fine, camera = pcall(world.camera, world, fields)
  if fine then pcall(world.render, world, { to = "c.png", camera = camera, size = { 8, 8 }, samples = 0, layer = "depth" }) end
end
for _, x in ipairs(far) do
  try { at = { x, x, x }, look_at = { x, x, x } }
  try { at = { x, 0, 0 }, look_at = { -x, 0, 0 }, up = { 1, 0, 0 } }
  try { at = { x, x, 0 }, look_at = ball, follow = ball, fov = 3 }
  try { at = { 0, 0, 1 }, look_at = { 0, 0, 0 }, up = { x, x, x }, fov = math.max(x, 5e-324) }
  pcall(world.lamp, world, { at = { x, x, x }, power = x, colour = { x, x, x } })
  pcall(world.sun, world, { from = { x, x, x } })
  pcall(world.sky, world, ("%g"):format(x))
end
local follower = world:camera { follow = gone, look_at = gone }
gone:remove()
pcall(world.render, world, { to = "c.png", camera = follower, size = { 8, 8 }, samples = 0 })
local other = digbox.world {}
assert(not pcall(world.render, world, { to = "c.png", camera = other:camera { at = { 1, 1, 1 } }, size = { 8, 8 } }))
world:step(3)
print "fine"
