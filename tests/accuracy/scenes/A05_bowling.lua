-- A05a a bowling ball slides, then rolls; A05b rolling resistance stops a rolling ball.
local exact = require "exact"

local radius, g = 0.1, exact.g

local function bowling_x(t)
  local mu, v = 0.2, 5
  local rolls = 2 * v / (7 * mu * g)                    -- 0.72811999417504005 s
  if t <= rolls then return v * t - mu * g * t * t / 2 end
  return 12 * v * v / (49 * mu * g) + 5 / 7 * v * (t - rolls)
end

local function stopping_x(t)
  local a = 5 / 7 * 0.01 * g
  t = math.min(t, 1 / a)                                -- 14.271151885830785 s
  return t - a * t * t / 2                              -- 7.1355758429153925 m
end

local function watch(x_of)
  return function(s, t) s.worst = math.max(s.worst, #(s.ball.position - { x_of(t), 0, radius })) end
end

return {
  {
    id = "A05a", title = "bowling ball", metric = "relative", scale = 1, seconds = 2,
    goal = { fast = { 1e-8, 0.15 }, accurate = { 1e-11, 0.5 } },
    build = function(world)
      world:plane { normal = { 0, 0, 1 }, friction = 0.2 }
      return { worst = 0, ball = world:ball { radius = radius, mass = 1, at = { 0, 0, radius }, velocity = { 5, 0, 0 }, friction = 0.2 } }
    end,
    frame = watch(bowling_x),
    finish = function(s, t)
      return { error = s.worst / bowling_x(t), x = s.ball.position.x / bowling_x(t) - 1, v = s.ball.velocity.x / (25 / 7) - 1 }
    end,
  },
  {
    id = "A05b", title = "rolling resistance", metric = "relative", scale = 1, seconds = 15,
    build = function(world)
      world:plane { normal = { 0, 0, 1 }, friction = 0.2, rolling_friction = 0.01 }
      return { worst = 0, ball = world:ball { radius = radius, mass = 1, at = { 0, 0, radius }, velocity = { 1, 0, 0 },
                                              spin = { 0, 1 / radius, 0 }, friction = 0.2, rolling_friction = 0.01 } }
    end,
    frame = watch(stopping_x),
    finish = function(s, t) return { error = s.worst / stopping_x(t), v = s.ball.speed, spin = #s.ball.spin } end,
  },
}
