-- S02 bouncing, of SimBenchmark: 7 x 7 balls of 10 kg drop from 5 m and bounce without loss for 20 s. Error: root mean square of the energy
-- over the energy; also the height of every ball against its exact motion.
local exact = require "exact"

local radius, h, g = 0.1, 5, exact.g
local E0 = 49 * 10 * g * h                              -- 24034.5 J

return {
  id = "S02", title = "49 elastic balls, 20 s", metric = "relative", scale = 1, seconds = 20, slow = true, conserves = { energy = true },
  build = function(world)
    world:plane { normal = { 0, 0, 1 }, friction = 0, restitution = 1 }
    local s = { balls = {}, sum = 0, count = 0, height = 0 }
    for i = 0, 48 do
      s.balls[i + 1] = world:ball { radius = radius, mass = 10, at = { 2 * (i % 7), 2 * (i // 7), radius + h }, friction = 0,
                                    restitution = 1 }
    end
    return s
  end,
  frame = function(s, t)
    local energy, want = 0, radius + exact.bounce(t, h, 1, g)
    for _, ball in ipairs(s.balls) do
      energy = energy + 10 * (ball.speed ^ 2 / 2 + g * (ball.position.z - radius))
      s.height = math.max(s.height, math.abs(ball.position.z - want))
    end
    s.sum, s.count = s.sum + (energy / E0 - 1) ^ 2, s.count + 1
  end,
  finish = function(s) return { error = math.sqrt(s.sum / s.count), metres = s.height } end,
}
