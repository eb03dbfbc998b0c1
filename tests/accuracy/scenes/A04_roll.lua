-- A04 a sphere rolls down 20 degrees: a = 5/7 g sin.
local exact = require "exact"

local radius, slope = 0.5, math.rad(20)
local a = 5 / 7 * exact.g * math.sin(slope)             -- 2.3965840043034359 m/s^2

return {
  id = "A04", title = "sphere rolling down 20 degrees", metric = "relative", scale = 1, seconds = 2,
  goal = { fast = { 1e-8, 0.18 }, accurate = { 1e-11, 0.5 } },
  conserves = { energy = true },
  build = function(world, digbox)
    local n = digbox.vec(math.sin(slope), 0, math.cos(slope))
    world:plane { normal = n, friction = 0.5 }
    return { ball = world:ball { radius = radius, mass = 1, at = n * radius, friction = 0.5 }, start = n * radius,
             along = digbox.vec(math.cos(slope), 0, -math.sin(slope)) }
  end,
  finish = function(s, t)
    local v, x = s.ball.velocity:dot(s.along), a * t * t / 2
    return { error = #(s.ball.position - s.start - s.along * x) / x, slip = math.abs(v - s.ball.spin.y * radius) / v }
  end,
}
