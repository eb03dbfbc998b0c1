-- 04_collision.lua: in free space a ball hits a bar near its end.
--   Look at:   the bar flies off spinning; nothing else is there to push against.
--   Law:       the impulse is J = (1 + e) v / (1/m + 1/M + s^2/I), with s the lever arm and I = M (l^2 + w^2) / 12. Then
--              the ball has v - J/m, the bar J/M and the spin J s / I. Momentum and angular momentum stay as they were.
--   Expected:  see the table it prints.
--   digbox run worlds/04_collision.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local v, e, m, M, s, l, w = 3, 0.8, 2, 3, 0.35, 1, 0.1

local world = digbox.world { gravity = { 0, 0, 0 } }
local bar = world:box { name = "bar", material = "oak", mass = M, size = { w, l, w }, at = { 0, 0, 0 }, restitution = e, friction = 0 }
local ball = world:ball {
  name = "ball", material = "rubber", mass = m, radius = 0.1, at = { -1.2, s, 0 }, velocity = { v, 0, 0 }, restitution = e, friction = 0,
}
local eye = world:camera { at = { 0.3, 0.5, 3.4 }, look_at = { 0.1, 0.05, 0 }, fov = "36 deg" }
if opt.film then world:record { camera = eye, to = "04_collision-%05d.png", fps = 30 } end

local before, turning = world.momentum, world.angular_momentum
world:run "0.6 s"                           -- the hit is at 0.35 s; later the other end comes round and hits the ball again

local I = M * (l * l + w * w) / 12
local J = (1 + e) * v / (1 / m + 1 / M + s * s / I)
local law = {
  { "ball afterwards, m/s", ball.velocity.x, v - J / m, 1e-6 },
  { "bar afterwards, m/s", bar.velocity.x, J / M, 1e-6 },
  { "its spin, rad/s", bar.spin.z, -J * s / I, 1e-6 },
  { "momentum lost, kg m/s", #(world.momentum - before), 0, 1e-12 },
  { "ang. momentum lost", #(world.angular_momentum - turning), 0, 1e-12 },
}
for _, row in ipairs(law) do print(("%-24s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
