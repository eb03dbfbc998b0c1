-- 11_gears.lua: the works of a clock: a motor drives the minute hand, a gear takes it down to the hour hand.
--   Look at:   the hands: they start at twelve; the clock runs a minute in a tenth of a second.
--   Law:       a gear of the ratio 1:12 turns the hour hand by a twelfth of the minute hand's angle, with twelve times the torque.
--   Expected:  after 24 s of running it is four o'clock: minute hand 4 turns, hour hand a third of one.
--   digbox run worlds/11_gears.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local turn = 2 * math.pi

local world = digbox.world {}
world:floor { material = "oak" }
local face = world:cylinder { name = "face", fixed = true, radius = 0.5, height = 0.04, at = { 0, 0.7, 0 }, colour = { 0.85, 0.83, 0.76 },
                              rotation = digbox.quat { axis = { 1, 0, 0 }, angle = "90 deg" } }
for i = 1, 12 do
  local a = turn * i / 12
  world:box { fixed = true, size = { 0.02, 0.07, 0.01 }, at = { 0.44 * math.sin(a), 0.7 + 0.44 * math.cos(a), 0.022 },
              rotation = digbox.quat { axis = { 0, 0, 1 }, angle = -a }, colour = { 0.02, 0.02, 0.02 } }
end
local function hand(name, length, width, z) -- a hand points up and is hung at its lower end
  local body = world:box { name = name, material = "steel", size = { width, length, 0.01 }, at = { 0, 0.7 + length / 2, z },
                           colour = { 0.03, 0.03, 0.03 } }
  return body, world:hinge { name = name, a = body, b = face, at = { 0, 0.7, z }, axis = { 0, 0, -1 } }
end
local _, minutes = hand("minute hand", 0.4, 0.02, 0.07)
local _, hours = hand("hour hand", 0.26, 0.035, 0.045)
minutes.motor = { speed = turn / 6, max_torque = "50 N m" }                 -- 3600 s in 6 s
world:gear { a = minutes, b = hours, ratio = { 1, 12 } }
local eye = world:camera { at = { 0.35, 0.9, 2.4 }, look_at = face, fov = "32 deg" }
if opt.film then world:record { camera = eye, to = "11_gears-%05d.png", fps = 30 } end
world:run "24 s"

local law = {
  { "minute hand, turns", minutes.angle / turn, 4, 1e-3 },
  { "hour hand, turns", hours.angle / turn, 4 / 12, 1e-4 },
  { "speed ratio", minutes.speed / hours.speed, 12, 1e-3 },
}
for _, row in ipairs(law) do print(("%-24s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
