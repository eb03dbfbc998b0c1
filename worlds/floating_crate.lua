-- floating_crate.lua: a crate, a ball, a plank on end and an iron ball are let go over a pond with a current.
--   Look at:   the crate bobs and comes to rest two fifths under; the ball lies deeper; the plank falls flat on the water, for its
--              metacentre is below its centre of mass; the iron ball goes down; all that floats drifts along at the current's speed.
--   Law:       a body in water is borne by the weight of what it displaces, and dragged by 1/2 rho c A |v - u| (v - u).
--   Expected:  the crate's depth is its density over that of water times its height; the ball's depth h solves
--              h^2 (3 r - h) = 4 r^3 rho / rho_water; the plank lies level; iron sinks at sqrt(2 (m - rho V) g / (rho c A)).
--   digbox run worlds/floating_crate.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local level, depth, g = 0, 8, 9.81

local world = digbox.world {}
world:air {}
world:water { level = level, current = { 0.05, 0, 0 }, damping = 1.5 }
world:box { name = "bed", fixed = true, material = "stone", size = { 12, 0.4, 8 }, at = { 0, level - depth - 0.2, 0 } }
-- What is seen of the water: a slab that nothing touches, through which one sees what lies in it.
world:box { name = "pond", fixed = true, collides = false, size = { 12, depth, 8 }, at = { 0, level - depth / 2, 0 },
            colour = { 0.05, 0.22, 0.33 }, opacity = 0.5 }

local crate = world:box { name = "crate", material = "pine", density = 400, size = { 0.8, 0.5, 0.8 }, at = { -1.1, 1.2, 0.3 },
                          rotation = digbox.quat { axis = { 1, 0, 0.4 }, angle = 0.25 } }
local ball = world:ball { name = "ball", density = 600, radius = 0.3, at = { 0.4, 0.9, 0.9 }, colour = { 0.8, 0.15, 0.1 } }
local plank = world:box { name = "plank", material = "oak", density = 700, size = { 0.4, 1.6, 0.12 }, at = { 1.1, 0.4, -0.7 },
                          rotation = digbox.quat { axis = { 1, 0, 0 }, angle = 0.03 } }
local iron = world:ball { name = "iron", material = "iron", density = 7870, radius = 0.05, at = { -0.1, 0.6, 1.6 } }
local eye = world:camera { at = { 1.2, 2.1, 5.2 }, look_at = { 0, 0.15, 0 }, fov = "38 deg" }
if opt.film then world:record { camera = eye, to = "floating_crate-%05d.png", fps = 30 } end
world:run "2 s"
local sinks = -iron.velocity.y
world:run "28 s"

local low, high = 0, 0.6
for _ = 1, 60 do
  local h = (low + high) / 2
  if h * h * (0.9 - h) < 4 * 0.3 ^ 3 * 0.6 then low = h else high = h end
end
local terminal = math.sqrt(2 * (7870 - 1000) * 4 / 3 * 0.05 * g / (1000 * 0.47))
-- 1.5 /s of damping act on the mass of the water displaced: c v + k v^2 = (m - rho V) g, each over the mass of the ball.
local k, c = (7870 - 1000) / 7870 * g / terminal ^ 2, 1.5 * 1000 / 7870
local fall = (-c + math.sqrt(c * c + 4 * k * (7870 - 1000) / 7870 * g)) / (2 * k)
local e = world.energy
local law = {
  { "crate under, m", level + 0.25 - crate.position.y, 0.4 * 0.5, 1e-5 },
  { "ball under, m", level + 0.3 - ball.position.y, low, 1e-5 },
  { "plank's end up, m", math.abs(plank.rotation:rotate({ 0, 1.6, 0 }).y), 0, 1e-4 },
  { "plank under, m", level + 0.06 - plank.position.y, 0.7 * 0.12, 1e-5 },
  { "iron sinks, m/s", sinks, fall, 1e-2 },
  { "crate drifts, m/s", crate.velocity.x, 0.05, 1e-4 },
  { "ledger, part open", e.numerical / e.lost, 0, 1e-6 },
}
for _, row in ipairs(law) do print(("%-24s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
