-- 16_integrators.lua: the same throw by Euler, by Verlet, by switching between them, and as digbox does it by itself.
--   Look at:   four balls, their trails and the black marks of the exact parabola: the red one falls behind. On the board the error
--              after 1 s against the step, both logarithmic: red has slope 1, orange slope 2, blue and green lie on rounding.
--   Law:       a frame step has n substeps of h = step / n. Semi-implicit Euler (v' = v + a h, x' = x + v' h) lags by g h^2 / 2 in
--              each, so by g h t / 2 after t. Verlet (x' = 2 x - x'' + a h^2, here with the velocity: x' = x + v h + a h^2 / 2)
--              is exact when a is constant. Switching uses Euler in the first step alone: n g h^2 / 2 for ever after.
--   Expected:  slopes 1 and 2, and the errors themselves; see the tables it prints.
--   digbox run worlds/16_integrators.lua -- --film
local digbox = require "digbox"
local opt = digbox.args { film = { default = false, help = "record a film" } }
local g, v, t_end = 9.81, digbox.vec(4, 5, 0), 1
local ways = { "euler", "switch", "verlet", "auto" }
local colours = { euler = { 0.8, 0.03, 0.02 }, switch = { 0.9, 0.35, 0.02 }, verlet = { 0.03, 0.12, 0.8 }, auto = { 0.05, 0.5, 0.06 } }

local function exact(from, t) return from + v * t + digbox.vec(0, -g / 2, 0) * (t * t) end

-- how far from the parabola after t_end, and the number of substeps in a step
local function measure(way, step)
  local world = digbox.world { step = step }
  local from = digbox.vec(0, 0, 0)
  local ball = world:ball { radius = 0.1, at = from, velocity = v, integrator = way }
  world:step()
  local parts = world:stats().substeps
  world:run { steps = math.floor(t_end / step + 0.5) - 1 }
  return #(ball.position - exact(from, world.time)), parts
end

local steps, errors, n = { 1 / 15, 1 / 30, 1 / 60, 1 / 120, 1 / 240 }, {}, nil
print(("%-10s %12s %12s %12s %12s   m off after %g s"):format("step", ways[1], ways[2], ways[3], ways[4], t_end))
for i, step in ipairs(steps) do
  errors[i] = {}
  for _, way in ipairs(ways) do
    local parts
    errors[i][way], parts = measure(way, step)
    if way == "euler" then n = parts end
  end
  print(("1/%-8.0f %12.3e %12.3e %12.3e %12.3e"):format(1 / step, errors[i].euler, errors[i].switch, errors[i].verlet, errors[i].auto))
end

-- The throw, in steps so coarse that the difference is seen.
local world = digbox.world { step = 0.1, accuracy = "sketch" }
world:floor { material = "oak" }
local function mark(at, radius, colour) return world:ball { fixed = true, collides = false, radius = radius, at = at, colour = colour } end
local lanes = {}
for i, way in ipairs(ways) do
  local from = digbox.vec(-2.6, 0.8, 2.2 - 0.9 * i)
  for k = 0, 20 do mark(exact(from, k / 20 * t_end), 0.025, { 0.01, 0.01, 0.01 }) end
  local ball = world:ball { name = way, radius = 0.1, at = from, velocity = v, integrator = way, colour = colours[way] }
  lanes[way] = { from = from, ball = ball }
end

-- The board: x = log2 of the step, y = log10 of the error, a line for each decade and each step.
local function place(step, error)
  return digbox.vec(3.3 + 0.42 * math.log(step * 60, 2), 3.3 + 0.17 * math.log(math.max(error, 1e-17), 10), -0.5)
end
local function line(a, b, thick, colour)
  local d = b - a
  world:box { fixed = true, collides = false, size = { #d, thick, thick }, at = a + d / 2, colour = colour,
              rotation = digbox.quat { axis = { 0, 0, 1 }, angle = math.atan(d.y, d.x) } }
end
local left, right, grid = 1 / 300, 1 / 12, { 0.25, 0.25, 0.25 }
local back = digbox.vec(0, 0, -0.03)
for decade = -17, -1 do
  line(place(left, 10.0 ^ decade) + back, place(right, 10.0 ^ decade) + back, decade % 5 == 0 and 0.014 or 0.005, grid)
end
for _, step in ipairs(steps) do line(place(step, 1e-17) + back, place(step, 0.1) + back, 0.005, grid) end
for _, way in ipairs(ways) do
  local size, front = way == "auto" and 0.6 or 1, digbox.vec(0, 0, way == "auto" and 0.05 or 0)     -- green before blue
  for i, step in ipairs(steps) do
    local p = place(step, errors[i][way]) + front
    mark(p, 0.05 * size, colours[way])
    if i > 1 then line(p, place(steps[i - 1], errors[i - 1][way]) + front, 0.024 * size, colours[way]) end
  end
end

local eye = world:camera { at = { 0.9, 5.4, 10.5 }, look_at = { 0.9, 1.4, 0 }, fov = "26 deg" }
if opt.film then world:record { camera = eye, to = "16_integrators-%05d.png", fps = 30 } end
for _ = 1, math.floor(t_end / world.frame + 0.5) do
  for _, way in ipairs(ways) do mark(lanes[way].ball.position, 0.045, colours[way]) end     -- its trail
  world:step()
end

local function slope(way) return math.log(errors[1][way] / errors[5][way], 16) end       -- of the logarithms, over 4 octaves
local function largest(way)
  local most = 0
  for i = 1, #steps do most = math.max(most, errors[i][way]) end
  return most
end
local function behind(way) return exact(lanes[way].from, t_end).y - lanes[way].ball.position.y end
local h, shown = steps[3] / n, world.frame / 3                                -- "sketch" has three substeps
local law = {
  { "euler: slope", slope "euler", 1, 1e-6 },
  { "switch: slope", slope "switch", 2, 1e-6 },
  { "euler at 1/60: off, m", errors[3].euler, g * h * t_end / 2, 1e-9 },
  { "switch at 1/60: off, m", errors[3].switch, n * g * h * h / 2, 1e-9 },
  { "verlet: most off, m", largest "verlet", 0, 1e-9 },
  { "auto: most off, m", largest "auto", 0, 1e-9 },
  { "red ball behind, m", behind "euler", g * shown * t_end / 2, 1e-9 },
  { "orange ball behind, m", behind "switch", 3 * g * shown * shown / 2, 1e-9 },
  { "green ball behind, m", behind "auto", 0, 1e-9 },
}
for _, row in ipairs(law) do print(("%-24s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
