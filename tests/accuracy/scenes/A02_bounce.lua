-- A02 a ball dropped from a gap of 1 m bounces with e = 0.8: flight n lasts 2 t0 e^n; at rest after t0 (1 + e) / (1 - e).
local exact = require "exact"

local radius, h, e, g = 0.1, 1, 0.8, exact.g

local function build(world)
  world:plane { normal = { 0, 0, 1 }, restitution = e, friction = 0 }
  local ball = world:ball { radius = radius, mass = 1, at = { 0, 0, radius + h }, restitution = e, friction = 0 }
  return { ball = ball, sum = 0, count = 0, impacts = {}, apexes = {} }
end

-- Every flight shows where it will end and how high it goes, so nothing depends on when it is looked at.
local function frame(s, t)
  local z, vz = s.ball.position.z - radius, s.ball.velocity.z
  local off = z - exact.bounce(t, h, e, g)
  s.sum, s.count = s.sum + off * off, s.count + 1
  local flight = 0
  local edge, first = 0, math.sqrt(2 * h / g)
  repeat
    edge = edge + (flight == 0 and first or 2 * first * e ^ flight)
    flight = flight + 1
  until t < edge or flight > 12
  if flight <= 6 and z > 1e-6 then
    local lands = t + (vz + math.sqrt(vz * vz + 2 * g * z)) / g
    s.impacts[flight] = math.abs(lands - edge)
    s.apexes[flight] = math.abs((z + vz * vz / (2 * g)) / (h * e ^ (2 * (flight - 1))) - 1)
  end
  s.last_speed = math.abs(vz)
end

local function finish(s)
  local times = 0
  for _, off in pairs(s.impacts) do times = math.max(times, off) end
  return { error = math.sqrt(s.sum / s.count), apex3 = s.apexes[4], impact_times = times, last_speed = s.last_speed }
end

return {
  {
    id = "A02", title = "bouncing ball, 3 s", metric = "m", scale = 1, seconds = 3, build = build, frame = frame, finish = finish,
    goal = { fast = { 1e-9, 0.12 }, accurate = { 1e-12, 0.2 } },
  },
  {
    id = "A02z", title = "bouncing ball through the Zeno point, 5 s", metric = "m", scale = 1, seconds = 5, build = build, frame = frame,
    finish = finish, goal = { fast = { 1e-9, 0.12 }, accurate = { 1e-12, 0.2 } },
  },
}
