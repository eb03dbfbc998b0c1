-- A15a, A15b a disc on a stick of 1 m precesses steadily at 60 degrees, slowly or fast; A15c the heavy top of the Lie-group literature.
local exact = require "exact"

local g = exact.g

-- Steady precession W with the angular velocity s about the axis of the disc: A cos W^2 - C s W + m g l = 0, where A, C: moments about
-- the pivot, across and along the axis.
local thick, disc, spin, tilt = 0.01, 0.5, 60, math.rad(60)
local C = disc ^ 2 / 2
local A = disc ^ 2 / 4 + thick ^ 2 / 12 + 1

local function steady(sign)
  local a, b = A * math.cos(tilt), C * spin
  local root = math.sqrt(b * b - 4 * a * g)
  return sign < 0 and 2 * g / (b + root) or (b + root) / (2 * a)
end

local function precession(letter, name, sign)
  local rate = steady(sign)
  return {
    id = "A15" .. letter, title = "steady precession, " .. name, metric = "rad", scale = 1, seconds = 10, conserves = { energy = true },
    build = function(world, digbox)
      local axis = digbox.vec(math.sin(tilt), 0, math.cos(tilt))
      local turn = digbox.vec(0, 0, rate) + axis * (spin - rate * math.cos(tilt))
      local body = world:cylinder { radius = disc, height = thick, mass = 1, at = axis, collides = false,
                                    rotation = digbox.quat { from = { 0, 1, 0 }, to = axis }, spin = turn, velocity = turn:cross(axis) }
      world:ball_joint { a = body, at = { 0, 0, 0 } }
      return { body = body, worst = 0, phase = 0 }
    end,
    frame = function(s, t)
      local p, angle = s.body.position, rate * t
      s.worst = math.max(s.worst, math.abs(math.atan(math.sqrt(p.x * p.x + p.y * p.y), p.z) - tilt))
      local off = p - { math.sin(tilt) * math.cos(angle), math.sin(tilt) * math.sin(angle), math.cos(tilt) }
      s.phase = math.max(s.phase, #off)
    end,
    finish = function(s) return { error = math.max(s.worst, s.phase), tilt = s.worst, metres = s.phase } end,
  }
end

-- m 15 kg, a disc of radius 0.25 m on a stick of 1 m along the body's y axis, spin (0, 150, -4.61538). The disc is as thin as a
-- body may be; the reference has the same thickness (0 for the check against the published motion).
local top_mass, top_spin, top_thick = 15, { 0, 150, -4.61538 }, 1e-4

local function top_motion(thickness, frames, dt)
  local across = top_mass * (0.25 ^ 2 / 4 + thickness ^ 2 / 12 + 1)
  local along = top_mass * 0.25 ^ 2 / 2
  local weight = top_mass * g
  local function torque(x, y, z, w)                     -- r x F, r = (0, 1, 0), F = -weight z in body axes
    local fx, fz = -weight * 2 * (x * z - w * y), -weight * (1 - 2 * (x * x + y * y))
    return fz, 0, -fx
  end
  return exact.trajectory(exact.rotor({ across, along, across }, torque), { 0, 0, 0, 1, table.unpack(top_spin) }, dt, frames, 6)
end

local function top_centre(y)
  return { 2 * (y[1] * y[2] - y[4] * y[3]), 1 - 2 * (y[1] * y[1] + y[3] * y[3]), 2 * (y[2] * y[3] + y[4] * y[1]) }
end

local top_want = exact.once(function(frames, dt) return top_motion(top_thick, frames, dt) end)

local heavy = {
  id = "A15c", title = "heavy top, 2 s", metric = "m", scale = 1, seconds = 2, conserves = { energy = true },
  check = function(dt)
    local n, worst = math.floor(1 / dt + 0.5), 0
    local list = top_motion(0, 2 * n, dt)
    local one, two = top_centre(list[n]), top_centre(list[2 * n])
    for i, x in ipairs { 0.17334396409838604, 0.64008859207056879, -0.74849079113358131 } do
      worst = math.max(worst, math.abs(one[i] - x))
    end
    for i, x in ipairs { -0.15041682274564176, -0.72416559163689564, -0.67302226956044410 } do
      worst = math.max(worst, math.abs(two[i] - x))
    end
    return worst
  end,
  build = function(world)
    local body = world:cylinder { radius = 0.25, height = top_thick, mass = top_mass, at = { 0, 1, 0 }, spin = top_spin,
                                  velocity = { 4.61538, 0, 0 }, collides = false }
    return { body = body, joint = world:ball_joint { a = body, at = { 0, 0, 0 } }, worst = 0, gap = 0, want = top_want(120, world.frame) }
  end,
  frame = function(s, _, k)
    s.worst = math.max(s.worst, #(s.body.position - top_centre(s.want[k])))
    s.gap = math.max(s.gap, s.joint.error)
  end,
  finish = function(s) return { error = s.worst, gap = s.gap } end,
}

local slow, fast = precession("a", "slow", -1), precession("b", "fast", 1)
-- The published rates are those of a disc without thickness.
slow.check = function()
  local keep = A
  A = disc ^ 2 / 4 + 1
  local worst = math.max(math.abs(steady(-1) - 1.458724667209778), math.abs(steady(1) - 12.658922391613751))
  A = keep
  return worst
end

return { slow, fast, heavy }
