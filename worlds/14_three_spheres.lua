-- 14_three_spheres.lua: three spheres on one axis, where the first engine of this kind failed.
--   Look at:   on the left three balls dropped on each other stand as a pillar; on the right two balls run into a third from both
--              sides at the same instant.
--   Law:       the pillar is one graph of three, its links carry 3, 2 and 1 times m g. By symmetry the ball in the middle of the
--              hit does not move at all; the others go back at e times their speed.
--   Expected:  29.43, 19.62, 9.81 N; speeds -1.6, 0, 1.6 m/s from 2, 0, -2 m/s with e = 0.8.
--   digbox run worlds/14_three_spheres.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local v, e, r, g = 2, 0.8, 0.1, 9.81

local world = digbox.world {}
local floor = world:floor { material = "tile" }
local pillar, row = {}, {}
for i = 1, 3 do
  pillar[i] = world:ball { name = "pillar " .. i, material = "ivory", mass = 1, radius = r, restitution = 0,
                           at = { -0.8, (2 * i - 1) * r + 0.02 * i, 0 } }
  row[i] = world:ball { name = "ball " .. i, material = i == 2 and "ivory" or "rubber", mass = 1, radius = r,
                        restitution = e, friction = 0, at = { (i - 2) * 1 + 0.4, r, 0 }, velocity = { (2 - i) * v, 0, 0 } }
end
local eye = world:camera { at = { 0.5, 1, 2.6 }, look_at = { -0.1, 0.2, 0 }, fov = "42 deg" }
if opt.film then world:record { camera = eye, to = "14_three_spheres-%05d.png", fps = 30 } end
world:run "0.7 s"

local function carried(body, below)         -- N, up, by the link from what lies below
  for _, link in ipairs(body:links()) do
    if link.a == below then return link.effort.y elseif link.b == below then return -link.effort.y end
  end
end
local law = {
  { "pillar, members of graph", pillar[1].dig.size, 3, 0 },
  { "under ball 1, N", carried(pillar[1], floor), 3 * g, 0.05 },
  { "under ball 2, N", carried(pillar[2], pillar[1]), 2 * g, 0.05 },
  { "under ball 3, N", carried(pillar[3], pillar[2]), g, 0.05 },
  { "row: ball 1, m/s", row[1].velocity.x, -e * v, 1e-9 },
  { "row: ball 2, m/s", row[2].velocity.x, 0, 1e-12 },
  { "row: ball 2 has moved, m", math.abs(row[2].position.x - 0.4), 0, 1e-12 },
  { "row: ball 3, m/s", row[3].velocity.x, e * v, 1e-9 },
  { "row, members of graph", row[2].dig.size, 1, 0 },
}
for _, line in ipairs(law) do print(("%-24s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(line))) end
return law
