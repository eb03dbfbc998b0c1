-- 03_rolling.lua: a bowling ball is thrown sliding, without spin, and ends up rolling.
--   Look at:   the stripes: at first they hardly turn, at the end they turn with the floor.
--   Law:       friction mu m g slows the ball and spins it up until v = spin r; for a solid ball that is at v = 5/7 v0,
--              whatever mu is, after t = 2 v0 / (7 mu g). After that friction does nothing at all.
--   Expected:  v = 2.857 m/s from v0 = 4 m/s, at t = 0.5825 s with mu = 0.2.
--   digbox run worlds/03_rolling.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local v0, mu, r, g = 4, 0.2, 0.11, 9.81

local world = digbox.world { accuracy = "study" }
world:floor { material = "oak", friction = mu, friction_dynamic = mu, rolling_friction = 0 }
local ball = world:ball {
  name = "ball", material = "rubber", radius = r, at = { -3, r, 0 }, velocity = { v0, 0, 0 },
  friction = mu, friction_dynamic = mu, rolling_friction = 0, restitution = 0,
}
local eye = world:camera { at = { 0, 0.7, 2.4 }, look_at = { -0.7, 0.2, 0 }, fov = "48 deg" }
if opt.film then world:record { camera = eye, to = "03_rolling-%05d.png", fps = 30 } end

local function slip() return ball.velocity.x + ball.spin.z * r end          -- speed of the point on the floor
world:run "0.3 s"
local sliding = slip()
world:run { seconds = 1, stop_when = function() return math.abs(slip()) < 1e-6 end }
local began = world.time
world:run "0.5 s"

local law = {
  { "slip after 0.3 s, m/s", sliding, v0 - 3.5 * mu * g * 0.3, 2e-3 },
  { "rolls from t =, s", began, 2 * v0 / (7 * mu * g), 1 / 60 },            -- seen at the next frame
  { "speed when rolling, m/s", ball.speed, 5 / 7 * v0, 1e-4 },
  { "speed of the spin, m/s", -ball.spin.z * r, 5 / 7 * v0, 1e-4 },
}
for _, row in ipairs(law) do print(("%-24s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
