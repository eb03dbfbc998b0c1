-- 13_room.lua: a gas of forty balls in a room without weight; then one wall is opened.
--   Look at:   all stay in until the wall at +x is opened; then those that get there leave.
--   Law:       p V = 2/3 E: the pressure on the walls, summed from the impacts, is that of an ideal gas (D. Bernoulli 1738).
--              Centres stay r away from the walls, so V is that of a room 2 r smaller; and balls keep each other out of half of
--              8 times their own volume (van der Waals).
--   Expected:  ratio 1, within 5 % for some 1500 impacts; none lost before, energy and count the same after.
--   digbox run worlds/13_room.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local n, side, r, speed = 40, 1, 0.03, 2

local world = digbox.world { gravity = { 0, 0, 0 }, seed = 4 }
local room = world:room { size = { side, side, side }, restitution = 1, friction = 0 }
local balls = {}
for i = 1, n do
  local cell = digbox.vec(i % 4, i // 4 % 4, i // 16) / 4 + digbox.vec(0.125, 0.125, 0.125)
  local way = digbox.vec(math.random() - 0.5, math.random() - 0.5, math.random() - 0.5):normalized()
  balls[i] = world:ball { material = "plastic", mass = 0.1, radius = r, at = (cell - digbox.vec(0.5, 0, 0.5)) * side,
                          velocity = way * speed, restitution = 1, friction = 0 }
end
local eye = world:camera { at = { 1.9, 1.3, 2.4 }, look_at = { 0.15, 0.5, 0 }, fov = "38 deg" }
if opt.film then world:record { camera = eye, to = "13_room-%05d.png", fps = 30, overlay = { "joints" } } end

local push, E = 0, world.energy.kinetic     -- N s on the walls, J
world:on("impact", function(e) if e.wall then push = push + e.impulse end end)
world:run "10 s"
local area, volume = 6 * side ^ 2, (side - 2 * r) ^ 3 - n / 2 * 8 * 4 / 3 * math.pi * r ^ 3
local pressure = push / (world.time * area) * (side / (side - 2 * r)) ^ 2
local kept, inside = world.energy.kinetic, 0
for _, b in ipairs(balls) do
  local p = b.position
  if math.max(math.abs(p.x), math.abs(p.y - side / 2), math.abs(p.z)) < side / 2 then inside = inside + 1 end
end
room:open "+x"
local left = 0
world:on("out_of_world", function() left = left + 1 end)
world:run { seconds = 5, stop_when = function() return left >= n / 2 end }

local law = {
  { "p V / (2/3 E)", pressure * volume / (2 / 3 * E), 1, 0.05 },
  { "energy after 10 s, J", kept, n * 0.1 * speed ^ 2 / 2, 1e-6 },
  { "balls inside after 10 s", inside, n, 0 },
  { "half out, wall open", left, n / 2, 1 },
}
for _, row in ipairs(law) do print(("%-24s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
