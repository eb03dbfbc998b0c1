-- A11 a table moves at 2 m/s and stops dead after 1 s; the ball that lay on it comes to rest at 2/7 of the table's way, without spin.
local radius = 0.1

return {
  id = "A11", title = "table that starts and stops, ball on it", metric = "relative", scale = 1, seconds = 3,
  goal = { fast = { 1e-10, 0.18 }, accurate = { 1e-12, 0.3 } },
  build = function(world)
    local top = world:box { kinematic = true, size = { 20, 4, 0.2 }, at = { 0, 0, -0.1 }, friction = 0.5 }
    local ball = world:ball { radius = radius, mass = 1, at = { 0, 0, radius }, friction = 0.5 }
    top:drive { velocity = { 2, 0, 0 } }
    return { top = top, ball = ball, stop = math.floor(1 / world.frame + 0.5) }
  end,
  act = function(s, k)
    if k == s.stop then s.top:drive { velocity = { 0, 0, 0 } } end
  end,
  finish = function(s)
    return { error = #(s.ball.position - { 4 / 7, 0, radius }) / (4 / 7), speed = s.ball.speed, spin = #s.ball.spin }
  end,
}
