-- 02_slope.lua: two blocks on a slope of 30 degrees, one rougher than the other.
--   Look at:   the rough block (brown) stays for good, the smooth one (white) slides off.
--   Law:       a block slides when tan(angle) > mu, with a = g (sin - mu cos); else it does not move at all.
--   Expected:  tan 30 deg = 0.577. mu = 0.65: 0 m. mu = 0.3: a = 2.356 m/s^2, so 1.178 m after 1 s.
--   digbox run worlds/02_slope.lua -- --film
local digbox = require "digbox"
local opt = digbox.args {
  film = { default = false, help = "record a film" },
  angle = { default = "30 deg", unit = "rad", help = "of the slope" },
}
local g, mu = 9.81, { rough = 0.65, smooth = 0.3 }
local turn = digbox.quat { axis = { 0, 0, 1 }, angle = -opt.angle }         -- down towards +x
local down, up = turn:rotate { 1, 0, 0 }, turn:rotate { 0, 1, 0 }

local world = digbox.world {}
world:floor { material = "tile" }
local middle = digbox.vec(0, 1, 0)
world:box { name = "slope", fixed = true, material = "pine", friction = 1, size = { 3, 0.1, 1.2 }, at = middle, rotation = turn }
local function block(material, own_mu, z)   -- a pair takes the geometric mean of its frictions, and the slope's is 1
  local at = middle - down * 1.2 + up * 0.15 + digbox.vec(0, 0, z)
  return world:box { material = material, friction = own_mu ^ 2, size = { 0.3, 0.2, 0.3 }, at = at, rotation = turn }, at
end
local rough, rough_start = block("oak", mu.rough, -0.3)
local smooth, smooth_start = block("teflon", mu.smooth, 0.3)
local eye = world:camera { at = { 2.2, 2.6, 4.2 }, look_at = { 0.1, 0.9, 0 }, fov = "38 deg" }
if opt.film then world:record { camera = eye, to = "02_slope-%05d.png", fps = 30 } end

world:run "1 s"
local a = g * (math.sin(opt.angle) - mu.smooth * math.cos(opt.angle))
local law = {
  { "rough: has moved, m", #(rough.position - rough_start), 0, 1e-6 },
  { "smooth: has slid, m", (smooth.position - smooth_start):dot(down), a / 2, 1e-3 },
  { "smooth: its speed, m/s", smooth.speed, a, 1e-3 },
}
for _, row in ipairs(law) do print(("%-24s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
