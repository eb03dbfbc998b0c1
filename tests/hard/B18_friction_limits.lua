-- B18 no friction: a box slides on for 20 s; friction 10: a flat box stays on a plane of 80 degrees.
local hard = require "hard"

return {
  {
    id = "B18a", title = "no friction, 3 m/s", seconds = 20, fast = 5, top_speed = 3,
    build = function(place)
      place:floor { friction = 0 }
      return { off = 0, box = place:box { size = 1, friction = 0, at = { 0, 0.5, 0 }, velocity = { 3, 0, 0 } } }
    end,
    frame = function(s) s.off = math.max(s.off, math.abs(s.box.velocity.x / 3 - 1)) end,
    finish = function(s) return { hard.most("speed off 3 m/s, relative", s.off, 1e-9) } end,
  },
  {
    id = "B18b", title = "friction 10 on 80 degrees", seconds = 10, fast = 2, top_speed = 0.01,
    build = function(place, digbox)
      local a = math.rad(80)
      local turn = digbox.quat { axis = { 0, 0, 1 }, angle = a }
      place:plane { normal = turn:rotate { 0, 1, 0 }, friction = 10 }
      local s = { box = place:box { size = { 1, 0.1, 1 }, friction = 10, at = turn:rotate { 0, 0.05, 0 }, rotation = turn } }
      s.at = place:where(s.box)
      return s
    end,
    finish = function(s) return { hard.most("moved, m", #(s.place:where(s.box) - s.at), 1e-3) } end,
  },
}
