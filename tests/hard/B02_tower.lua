-- B02 towers of 20 and 40 unit boxes for 60 s, with sleeping and without.
local hard = require "hard"

local function tower(letter, count, sleeping)
  return {
    id = "B02" .. letter, title = ("tower of %d%s"):format(count, sleeping and "" or ", never asleep"), seconds = 60,
    fast = letter == "a" and 3 or nil, world = { sleeping = sleeping }, slow = not sleeping,
    build = function(place)
      local s = { late = 0, drift = 0, sag = 0, count = count }
      place:floor { friction = 0.6 }
      for i = 1, count do s.top = place:box { name = "box " .. i, size = 1, mass = 1, friction = 0.6, at = { 0, i - 0.5, 0 } } end
      return s
    end,
    frame = function(s, t)
      local p = s.place:where(s.top)
      s.drift = math.max(s.drift, math.sqrt(p.x * p.x + p.z * p.z))
      s.sag = math.max(s.sag, math.abs(count - 0.5 - p.y))
      if t > 1 then s.late = math.max(s.late, s.top.speed) end
    end,
    finish = function(s)
      return { hard.most("drift of the top, m", s.drift, 0.01), hard.most("sag / height", s.sag / count, 1e-3),
               hard.most("speed of the top after 1 s, m/s", s.late, 1e-3) }
    end,
  }
end

return { tower("a", 20, true), tower("b", 40, true), tower("c", 20, false), tower("d", 40, false) }
