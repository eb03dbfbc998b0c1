-- cog_board.lua: cogs on a board: three in a triangle jam, four in a ring turn, and a train of 12 to 1.
--   Look at:   the triangle on the left, which is turned as hard as the ring beside it and stays; the DIGs drawn over both.
--   Law:       teeth that mesh turn in opposite senses. Around a ring of n cogs the sense changes n times: with n odd the last asks
--              of the first what it cannot do.
--   Expected:  asked before anything moves, the triangle answers "conflict"; pushed with 2 N m it does not move; the ring turns.
--   digbox run worlds/cog_board.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local turn = 2 * math.pi

local world = digbox.world { gravity = { 0, 0, 0 } }
local board = world:box { name = "board", fixed = true, size = { 3, 1.4, 0.04 }, at = { 0, 0, -0.06 }, colour = { 0.16, 0.11, 0.07 } }

-- A cog of n teeth; its teeth are for show, the gear says what they do
local function cog(name, x, y, n, colour, phase, z)
  local radius = 0.012 * n
  local parts = { digbox.cylinder { radius = radius, height = 0.05, rotation = digbox.quat { axis = { 1, 0, 0 }, angle = "90 deg" } } }
  for i = 1, n do
    local a = turn * (i + (phase or 0)) / n
    parts[#parts + 1] = digbox.box { size = { 0.05, 0.036, 0.05 }, at = { radius * math.cos(a), radius * math.sin(a), 0 },
                                     rotation = digbox.quat { axis = { 0, 0, 1 }, angle = a } }
  end
  local body = world:body { name = name, parts = parts, mass = 0.05 * n, at = { x, y, z or 0 }, group = -1, colour = colour }
  return { body = body, teeth = n, hinge = world:hinge { a = body, b = board, at = { x, y, z or 0 }, axis = { 0, 0, 1 } } }
end

local function mesh(a, b) return world:gear { a = a.hinge, b = b.hinge, ratio = { a.teeth, -b.teeth } } end

local red, green, blue = { 0.7, 0.10, 0.06 }, { 0.10, 0.45, 0.12 }, { 0.10, 0.22, 0.60 }
local r = 0.31
local triangle = { cog("red 1", -1.1, -0.2, 12, red), cog("red 2", -1.1 + r, -0.2, 12, red, 0.5),
                   cog("red 3", -1.1 + r / 2, -0.2 + 0.87 * r, 12, red) }
local ring = { cog("green 1", -0.3, -0.2, 12, green), cog("green 2", -0.3 + r, -0.2, 12, green, 0.5),
               cog("green 3", -0.3 + r, -0.2 + r, 12, green), cog("green 4", -0.3, -0.2 + r, 12, green, 0.5) }
local train = { cog("blue 1", 0.55, 0, 8, blue), cog("blue 2", 0.55 + 0.4, 0, 24, blue, 0.5) }
for i = 1, 3 do mesh(triangle[i], triangle[i % 3 + 1]) end
for i = 1, 4 do mesh(ring[i], ring[i % 4 + 1]) end
mesh(train[1], train[2])
-- The second stage: a small cog on the axle of the large one, and another large one: 3 times 4 is 12
local small = cog("blue 3", 0.95, 0, 6, blue, 0, 0.06)
world:gear { a = train[2].hinge, b = small.hinge, ratio = { 1, 1 } }
local last = cog("blue 4", 0.95, 0.38, 24, blue, 0.5, 0.06)
mesh(small, last)

local about = { turn = { 0, 0, 1 }, by = "30 deg", with = "2 N m" }
local jam, free = triangle[1].body:can_move(about), ring[1].body:can_move(about)
print(("triangle: %-9s %s"):format(jam.verdict, jam.because))
print(("ring:     %-9s %s"):format(free.verdict, free.because))
local _, loop = triangle[1].body:flood("turn", 1, { transform = "ratio" })      -- the message that finds it out
local reached, none = ring[1].body:flood("turn", 1, { transform = "ratio" })
print(("the message went round: %s contradict each other; %d others of the ring agree"):format(tostring(loop), reached))

local eye = world:camera { at = { -0.05, 0.1, 2.6 }, look_at = digbox.vec(-0.05, 0.05, 0), fov = "50 deg" }
if opt.film then world:record { camera = eye, to = "cog_board-%05d.png", fps = 30, overlay = { "dig", "time" } } end
for _, first in ipairs { triangle[1], ring[1] } do first.body:twist { torque = { 0, 0, 2 }, lasts = 0.5 } end
train[1].hinge.motor = { speed = turn, max_torque = "20 N m" }
world:run "4 s"

local law = {
  { "triangle: conflict", jam.verdict == "conflict" and 1 or 0, 1, 0 },
  { "triangle: cogs in the ring", #loop, 3, 0 },
  { "triangle: turned, rad", math.abs(triangle[1].hinge.angle), 0, 1e-6 },
  { "ring: free", free.verdict == "free" and 1 or 0, 1, 0 },
  { "ring: agrees", none == nil and reached or -1, 3, 0 },
  { "ring: turned, rad", math.min(math.abs(ring[1].hinge.angle), 1), 1, 0 },                -- at least
  { "ring: second over first", ring[2].hinge.angle / ring[1].hinge.angle, -1, 1e-6 },
  { "train: first over last", train[1].hinge.angle / last.hinge.angle, 12, 1e-3 },
}
for _, row in ipairs(law) do print(("%-26s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
