-- B08 eight unit boxes nearly in one place: they must come apart without an explosion, at any frame step.
local hard = require "hard"

return {
  id = "B08", title = "eight boxes in one place", seconds = 10, fast = 10, passive = false, chaotic = true,
  build = function(place)
    local s = { boxes = {}, speed = 0, low = 0 }
    place:floor { friction = 0.6 }
    for i = 1, 8 do
      local d = 0.05 * (i - 1)
      s.boxes[i] = place:box { name = "box " .. i, size = 1, mass = 1, friction = 0.6, at = { d, 0.5 + d, d } }
    end
    return s
  end,
  frame = function(s)
    for _, b in ipairs(s.boxes) do
      s.speed, s.low = math.max(s.speed, b.speed), math.min(s.low, s.place:where(b).y - 0.5)
    end
  end,
  finish = function(s)
    return { hard.most("greatest speed, m/s", s.speed, 3), hard.most("overlap at the end, m", s.world:stats().penetration, 1e-3),
             hard.most("centre below half a box, m", -s.low, 1e-2) }
  end,
}
