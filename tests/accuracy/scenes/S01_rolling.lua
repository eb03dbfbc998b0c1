-- S01 rolling, of SimBenchmark: 25 balls of 1 kg on a box of 10 kg that a force of 150 N drags over the ground, along y (S01y) and along
-- the diagonal (S01d). Box: (F - mu g (M + n m)) / (M + 2/7 n m); balls: 2/7 of that. Error: root of the mean square of both speeds.
local exact = require "exact"

local M, m, n, F, mu = 10, 1, 25, 150, 0.4
local a_box = (F - mu * exact.g * (M + n * m)) / (M + 2 / 7 * n * m)     -- 0.7385 m/s^2

local function drag(letter, direction)
  return {
    id = "S01" .. letter, title = ("balls on a dragged box, force along %g degrees"):format(direction), metric = "m/s", scale = 1,
    seconds = 4, slow = true,
    build = function(world, digbox)
      local along = digbox.vec(math.cos(math.rad(direction)), math.sin(math.rad(direction)), 0)
      -- pairs take the geometric mean: ground and box 0.4, box and balls 0.8
      world:plane { normal = { 0, 0, 1 }, friction = mu }
      local s = { along = along, balls = {}, sum = 0, count = 0 }
      s.box = world:box { size = { 20, 20, 1 }, mass = M, at = { 0, 0, 0.5 }, friction = mu }
      for i = 0, n - 1 do
        s.balls[i + 1] = world:ball { radius = 0.5, mass = m, at = { 2 * (i % 5) - 4, 2 * (i // 5) - 4, 1.5 }, friction = 1.6 }
      end
      s.box:push { force = along * F, lasts = 4 }
      return s
    end,
    frame = function(s, t)
      local box, balls = #(s.box.velocity - s.along * (a_box * t)), 0
      for _, ball in ipairs(s.balls) do balls = math.max(balls, #(ball.velocity - s.along * (2 / 7 * a_box * t))) end
      s.sum, s.count = s.sum + box * box + balls * balls, s.count + 1
    end,
    finish = function(s) return { error = math.sqrt(s.sum / s.count) } end,
  }
end

return { drag("y", 90), drag("d", 45) }
