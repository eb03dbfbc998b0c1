-- B09 balls of 5 cm at 100 to 2000 m/s against a wall of 2 cm, each at 20 distances, so that frames end anywhere around the wall.
local hard = require "hard"

local speeds = { 100, 200, 500, 1000, 2000 }

return {
  id = "B09", title = "100 bullets on a 2 cm wall", seconds = 0.2, fast = 0.2, world = { gravity = { 0, 0, 0 } }, top_speed = 2000,
  build = function(place)
    local s = { balls = {} }
    place:box { name = "wall", fixed = true, size = { 0.02, 60, 60 }, at = { 0.01, 0, 0 } }
    for i, v in ipairs(speeds) do
      for k = 1, 20 do
        local x = -1 - v * place.dt * (k - 0.5) / 20
        s.balls[#s.balls + 1] = place:ball { radius = 0.05, at = { x, 2 * (i - 3), 2 * (k - 10) }, velocity = { v, 0, 0 } }
      end
    end
    return s
  end,
  finish = function(s)
    local through, deep = 0, -1
    for _, b in ipairs(s.balls) do
      local x = s.place:where(b).x
      through = through + (x < 0 and 0 or 1)
      deep = math.max(deep, x + 0.05)
    end
    return { hard.most("balls through", through, 0), hard.most("deepest in the wall, m", deep, 1e-3) }
  end,
}
