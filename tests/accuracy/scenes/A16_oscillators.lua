-- A16 a mass of 1 kg on a spring: damped and slow (a), stiff (b), and stiff without damping, where no energy may come from nowhere (c, d).
local exact = require "exact"

-- x'' = -k x - c x', x(0) = x0, at rest
local function damped(k, c, x0, t)
  local w = math.sqrt(k - c * c / 4)
  return x0 * math.exp(-c * t / 2) * (math.cos(w * t) + c / (2 * w) * math.sin(w * t))
end

local function oscillator(letter, k, c, seconds, reference_time, reference)
  return {
    id = "A16" .. letter, title = ("oscillator, k = %g, c = %g"):format(k, c), metric = "m", scale = 0.1, seconds = seconds,
    world = { gravity = { 0, 0, 0 } },
    check = function() return math.abs(damped(k, c, 0.1, reference_time) - reference) end,
    build = function(world)
      local ball = world:ball { radius = 0.05, mass = 1, at = { 1.1, 0, 0 }, collides = false }
      world:spring { a = ball, at_b = { 0, 0, 0 }, length = 1, stiffness = k, damping = c }
      return { ball = ball, worst = 0 }
    end,
    frame = function(s, t)
      s.worst = math.max(s.worst, #(s.ball.position - { 1 + damped(k, c, 0.1, t), 0, 0 }))
    end,
    finish = function(s) return { error = s.worst, last = s.ball.position.x - 1 } end,
  }
end

local sag, rate = exact.g / 1e8, 1e4            -- m, 1/s

-- It hangs from its unloaded length on: between 0 and twice the sag of 9.81e-8 m for ever, with 1592 turns a second. The error is the
-- amplitude gained (c), or the distance from where it should be (d): a tolerance above the sag is kept by any swing of that size, one
-- below it only by following each turn.
local function hanging(letter, title, metric, measure, limits)
  return {
    id = "A16" .. letter, title = "oscillator, k = 1e8, no damping, under gravity" .. title, metric = metric, scale = 1, seconds = 2,
    conserves = { energy = true }, limits = limits,
    build = function(world)
      local ball = world:ball { radius = 0.05, mass = 1, at = { 0, 0, -1 }, collides = false }
      world:spring { a = ball, at_b = { 0, 0, 0 }, length = 1, stiffness = 1e8 }
      return { ball = ball, gain = 0, off = 0 }
    end,
    frame = function(s, t)
      local z, v = s.ball.position.z + 1, s.ball.velocity.z
      s.kept = math.sqrt((z + sag) ^ 2 + (v / rate) ^ 2) / sag
      s.gain = math.max(s.gain, s.kept - 1)
      s.off = math.max(s.off, math.abs(z + sag * (1 - math.cos(rate * t))))
      s.low = math.min(s.low or 0, z)
    end,
    finish = function(s) return { error = s[measure], lowest = s.low, kept = s.kept } end,
  }
end

local unseen = "the whole swing is 2e-7 m long. Down to 1e-7 it is not followed: the error is its length, whatever the phase, and the " ..
  "order is that between such a run and two that follow it. From 1e-7 to 1e-11 the error falls to 0.04, 0.07, 0.06 and 0.09 of " ..
  "itself per decade."

return {
  oscillator("a", 100, 2, 5, 5, 0.00055261033069326944), oscillator("b", 1e6, 10, 1, 1, 0.000388624507131149),
  hanging("c", ": amplitude gained", "relative", "gain"),
  hanging("d", ": place", "m", "off", { order = unseen }),
}
