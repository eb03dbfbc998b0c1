-- mirror_room.lua: through the mirror into a room with laws of its own, and out again.
--   Look at:   a crate slides up to the mirror, brakes as it goes; behind it there is no friction, and weight points up: it rises to
--              the ceiling, glides along it, is turned back by the red stone that repels, and comes out of the mirror to fall and
--              to stop like any crate. A ball thrown after it bends upwards. The apple lies on the ceiling until the stone has
--              driven it out, too.
--   Law:       F = -0.3 m g' inside; mu = 0; the stone: F = k / d^2 away from it, as its potential k / d. Energy that the laws
--              give is booked as theirs: m (g - g') times the height gained.
--   Expected:  both borders act within a step; the crate comes back as fast as it glided there; the law's work to 1 part in 100.
--   digbox run worlds/mirror_room.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local g, size, height, mu = 9.81, 0.3, 2.2, 0.3
local k, stone = 0.5, digbox.vec(2.9, height - size / 2, 0)                 -- N m^2 / kg, m

local world = digbox.world { accuracy = "study", step = 1 / 240 }
world:floor { material = "tile", friction = mu }
local function fixed(colour, at, extent, fields)
  local box = { fixed = true, at = at, size = extent, colour = colour }
  for key, value in pairs(fields or {}) do box[key] = value end
  return world:box(box)
end
local gold, violet, cream = { 0.83, 0.6, 0.15 }, { 0.22, 0.1, 0.36 }, { 0.75, 0.68, 0.55 }
for side = -1, 1, 2 do fixed(gold, { 0, height / 2, 0.62 * side }, { 0.08, height + 0.1, 0.08 }, { collides = false }) end
fixed(gold, { 0, height + 0.09, 0 }, { 0.08, 0.08, 1.32 }, { collides = false })
fixed(cream, { -1.5, 1.25, -0.95 }, { 2.9, 2.5, 0.05 }, { collides = false })
fixed(violet, { 1.75, 1.25, -0.95 }, { 3.4, 2.5, 0.05 })
fixed(violet, { 3.47, 1.25, -0.1 }, { 0.05, 2.5, 1.75 })
fixed(violet, { 1.75, height - 0.02, 0.77 }, { 3.4, 0.16, 0.05 })
fixed(violet, { 1.75, height + 0.03, -0.08 }, { 3.4, 0.06, 1.7 }, { restitution = 0 })                  -- the ceiling
world:ball { name = "stone", fixed = true, radius = 0.12, at = stone, colour = { 0.8, 0.05, 0.05 }, collides = false }

local magic = world:region { box = { size = { 4, 6, 4 } }, at = { 2, 1, 0 }, laws = {
  gravity = { 0, 0.3 * g, 0 }, friction_scale = 0, conduct = 100,
  force = function(body)                                                    -- the stone
    local away = body.position - stone
    return k * body.mass / away:length() ^ 3 * away
  end,
} }
local crate = world:box { name = "crate", material = "pine", mass = 2, size = size, friction = mu, restitution = 0,
                          at = { -1.5, size / 2, 0 }, velocity = { 3.5, 0, 0 } }
world:ball { name = "ball", material = "rubber", mass = 0.5, radius = 0.09, at = { -2.2, 0.3, -0.45 }, restitution = 0.4,
             velocity = { 2.2, 4.4, 0 } }
local apple = world:ball { name = "apple", mass = 0.2, radius = 0.08, at = { 1.2, height - 0.08, 0.4 }, colour = { 0.25, 0.55, 0.1 },
                           restitution = 0 }
world:sun { from = { -2, 5, 5 }, shadows = true }
local eye = world:camera { at = { -1.6, 1.5, 5.4 }, look_at = { 0.35, 1.0, 0 }, fov = "44 deg" }
if opt.film then world:record { camera = eye, to = "mirror_room-%05d.png", fps = 30, size = { 1280, 720 } } end

-- What a border does, in the step in which it is crossed and in the one after.
local passed, gained = {}, 0
local function pass(e)
  local b = e.self
  passed[#passed + 1] = { e.event, b, b.position, b.velocity, world.time }
  gained = gained + (e.event == "entered" and -1 or 1) * b.mass * 1.3 * g * b.position.y
end
world:on("entered", { region = magic }, pass)
world:on("left", { region = magic }, pass)
local inside = apple.mass * 1.3 * g * apple.position.y      -- J, of those who began there
local glide                                                                 -- m, m/s, when it has come to the ceiling
world:run { seconds = 8, stop_when = function()
  local last = passed[#passed]
  if last and last.after == nil and world.time > last[5] then last.after = (last[2].velocity - last[4]) / world.frame end
  if not glide and crate.position.y > height - size / 2 - 1e-6 and math.abs(crate.velocity.y) < 1e-6 then
    glide = { crate.position, crate.velocity.x }
  end
  return crate.position.x < 0 and #passed >= 3 and crate.mode == "resting"
end }
for _, b in ipairs(magic:bodies()) do gained = gained + b.mass * 1.3 * g * b.position.y end

local function of(body, event)
  for _, row in ipairs(passed) do if row[1] == event and row[2] == body then return row end end
end
local e, into, out = world.energy, of(crate, "entered"), of(crate, "left")
local pull = k / (stone - into[3]):length() ^ 3 * (stone - into[3])        -- m/s^2
local back = math.sqrt(glide[2] ^ 2 + 2 * k * (1 / (stone - glide[1]):length() - 1 / (stone - out[3]):length()))
local law = {
  { "crate enters with, m/s", into[4].x, math.sqrt(3.5 ^ 2 - 2 * mu * g * 1.5), 1e-3 },
  { "accelerates inside, m/s^2", into.after.y, 0.3 * g - pull.y, 1e-3 },
  { "brakes inside, m/s^2", into.after.x, -pull.x, 1e-3 },
  { "comes back with, m/s", -out[4].x, back, 0.02 },                       -- a force is held through each step
  { "falls outside, m/s^2", out.after.y, -g, 1e-3 },
  { "work of the laws, J", e.law, gained - inside, 0.01 * math.abs(e.law) },
  { "numerical, J", e.numerical, 0, 0.01 },
}
for _, row in ipairs(law) do print(("%-26s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
