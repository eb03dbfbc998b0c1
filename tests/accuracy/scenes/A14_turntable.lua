-- A14 a ball rolls on a turntable: on a circle, at 2/7 of the table's rate.
local rate, radius = 3.5, 0.1

return {
  id = "A14", title = "sphere on a turntable, 6 s", metric = "m", scale = 1, seconds = 6,
  goal = { fast = { 1e-5, 0.2 }, accurate = { 1e-9, 1 } },
  build = function(world)
    local top = world:box { kinematic = true, size = { 6, 6, 0.2 }, at = { 0, 0, -0.1 }, friction = 0.5 }
    top:drive { spin = { 0, 0, rate } }
    return { worst = 0, drift = 0, ball = world:ball { radius = radius, mass = 1, at = { 1, 0, radius }, velocity = { 0, 0.5, 0 },
                                                       spin = { (rate - 0.5) / radius, 0, 0 }, friction = 0.5 } }
  end,
  frame = function(s, t)
    local want = { 1 + 0.5 * (math.cos(t) - 1), 0.5 * math.sin(t), radius }
    s.worst = math.max(s.worst, #(s.ball.position - want))
    s.drift = math.max(s.drift, math.abs(s.ball.speed - 0.5))
  end,
  finish = function(s) return { error = s.worst, speed = s.drift } end,
}
