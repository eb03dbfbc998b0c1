-- bolted_door.lua: a door, a bolt and a heavy box behind it: what does it take to open it? Asked first, done afterwards.
--   Look at:   the answers that are printed, then the film: the door stays shut while it is bolted, and at 40 N; at 60 N it opens.
--   Law:       torques about the hinge: the handle's force at 0.75 m moves a box of 20 kg that rubs at 0.40 m: F = mu m g 0.40 / 0.75.
--   Expected:  needs 52.30 N; asking leaves the world as it was, bit for bit.
--   digbox run worlds/bolted_door.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local g = 9.80665

local world = digbox.world { gravity = { 0, -g, 0 } }
world:floor { material = "tile", friction = 0.5 }
local frame = world:box { name = "frame", fixed = true, material = "oak", size = { 0.1, 2.2, 0.1 }, at = { -0.06, 1.1, 0 } }
local post = world:box { name = "post", fixed = true, material = "oak", size = { 0.1, 2.2, 0.1 }, at = { 0.87, 1.1, 0.05 } }
local door = world:box { name = "door", material = "oak", mass = "10 kg", size = { 0.8, 2, 0.04 }, at = { 0.4, 1.01, 0 }, friction = 0 }
local hinge = world:hinge { name = "hinge", a = door, b = frame, at = { 0, 1, 0 }, axis = { 0, 1, 0 } }
local bolt = world:bolt { name = "bolt", holds = door, into = post, at = { 0.79, 1, 0.02 } }
local half = 0.15 * math.sqrt(2)        -- the box stands with one edge against the door, so that where it is pushed is no question
local box = world:box { name = "box", material = "brick", mass = "20 kg", size = 0.3, friction = 0.5, at = { 0.4, 0.15, -0.02 - half },
                        rotation = digbox.quat { axis = { 0, 1, 0 }, angle = "45 deg" } }

local function pull(force) return { along = { 0, 0, -1 }, with = force, at = { 0.75, 1, 0 }, by = "20 cm" } end
local function ask(what, force)
  local answer = door:can_move(pull(force))
  print(("%-28s %3g N  %-8s %s"):format(what, force, answer.verdict, answer.because))
  return answer
end

local eye = world:camera { at = { 1.9, 1.8, -3.4 }, look_at = digbox.vec(0.4, 1, 0), fov = "44 deg" }
if opt.film then
  world:record { camera = eye, to = "bolted_door-%05d.png", fps = 30, overlay = { "dig", "time" } }
end
world:run(0.2)
local before = world:checksum()
local bolted = ask("bolted, box behind it", 60)
local unchanged = world:checksum() == before and 1 or 0
door:push { force = "60 N", along = { 0, 0, -1 }, at = { 0.75, 1, 0 }, lasts = 0.5 }
world:run(0.8)
local shut = math.abs(hinge.angle)
bolt:withdraw()
world:run(0.2)
local weak, strong = ask("bolt drawn, box behind it", 40), ask("bolt drawn, box behind it", 60)
door:push { force = "40 N", along = { 0, 0, -1 }, at = { 0.75, 1, 0 }, lasts = 0.5 }
world:run(0.8)
local still = math.abs(hinge.angle)
door:push { force = "60 N", along = { 0, 0, -1 }, at = { 0.75, 1, 0 }, lasts = 1.5 }
world:run(2)
local open = math.abs(hinge.angle)

local law = {
  { "asking changed nothing", unchanged, 1, 0 },
  { "bolted: held by the bolt", bolted.held_by == bolt and 1 or 0, 1, 0 },
  { "bolted: opened, rad", shut, 0, 1e-3 },
  { "40 N: needs, N", weak.needs, 0.5 * 20 * g * 0.40 / 0.75, 0.523 },
  { "40 N: blocked by the box", weak.blocked_by == box and 1 or 0, 1, 0 },
  { "40 N: opened, rad", still, 0, 1e-3 },
  { "60 N: free", strong.ok and 1 or 0, 1, 0 },
  { "60 N: opened, rad", math.min(open, 0.3), 0.3, 0 },     -- at least
}
for _, row in ipairs(law) do print(("%-26s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
