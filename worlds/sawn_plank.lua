-- sawn_plank.lua: a man of 40 kg stands on a plank over a ditch, and it is sawn between his feet, half a millimetre at a time.
--   Look at:   the plank bends, turns from green to red in the middle, and snaps where it is sawn; the man falls.
--   Law:       stress = M / Z with M = F (L / 4 - foot / 2) + W L / 8 and Z = b (h - cut)^2 / 6, F his weight on two feet, W the plank's;
--              it sags by F L^3 / 48 E I + 5 W L^3 / 384 E I while it is whole.
--   Expected:  2 m by 200 x 25 mm, E = 10 GPa, 40 MPa: sag 27.08 mm, and 9.82 MPa; snaps when the cut is deeper than 12.61 mm.
--   digbox run worlds/sawn_plank.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local L, b, h, E, strength, m, foot, g = 2, 0.2, 0.025, 10e9, 40e6, 40, 0.02, 9.81   -- foot: from the middle

local world = digbox.world {}
world:floor { material = "stone" }
for x = -1, 1, 2 do
  world:box { name = "block", fixed = true, material = "brick", size = { 0.4, 0.6, 0.6 }, at = { x * 1.21, 0.3, 0 } }
end
local plank = world:plank { name = "plank", material = "pine", density = 500, E = E, strength = strength, from = { -L / 2, 0.6 + h / 2, 0 },
  to = { L / 2, 0.6 + h / 2, 0 }, width = b, height = h, from_end = "pinned", to_end = "roller", relaxation = 0.01 }
local man = world:box { name = "man", mass = m, size = { 2 * foot, 0.5, 0.15 }, at = { 0, 0.6 + h + 0.25, 0 }, material = "leather" }
world:guide { a = man, axis = { 1, 0, 0 }, keeps = "direction" }        -- he keeps his balance
world:guide { a = man, at = man.position, axis = { 0, 1, 0 }, keeps = "line" }
local eye = world:camera { at = { 1.1, 1.3, 2.6 }, look_at = { 0, 0.55, 0 }, fov = "40 deg" }
world:sun { from = { 2, 5, 3 }, shadows = true }
if opt.film then world:record { camera = eye, to = "sawn_plank-%05d.png", fps = 30, overlay = { "stress" } } end

world:run(2)
local sag, stress = 0.6 + h / 2 - plank:point(L / 2).y, plank.stress * strength
local cut, before, name = 0, 0, nil
world:on("broken", function(e) name = name or e.joint.name end)
while not name and cut < 0.02 do
  before = cut
  cut = cut + 0.0005
  plank:saw { at = L / 2, depth = 0.0005 }
  world:run(0.25)
end
local apart = plank.broken
world:run(1.5)

local own = 500 * L * b * h * g                                         -- N
local moment = m * g * (L / 4 - foot / 2) + own * L / 8
local I = b * h ^ 3 / 12
local law = {
  { "sag, mm", sag * 1e3, (m * g * L ^ 3 / 48 + 5 / 384 * own * L ^ 3) / (E * I) * 1e3, 0.8 },
  { "stress in the middle, MPa", stress / 1e6, moment / (b * h ^ 2 / 6) / 1e6, 0.29 },
  { "snaps with a cut of, mm", (before + cut) / 2 * 1e3, (h - math.sqrt(6 * moment / (b * strength))) * 1e3, 0.38 },     -- 3 %
  { "breaks at joint", tonumber(name and name:match "%d+"), 8, 0 },
  { "in parts", apart + 1, 2, 0 },
  { "the man is down, m", man.position.y < 0.6 and 1 or 0, 1, 0 },
}
for _, row in ipairs(law) do print(("%-28s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
