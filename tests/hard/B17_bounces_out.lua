-- B17 a ball of restitution 0.99 and a box of 0.9 that fall 10 cm: they come to rest in finite time, and then do not tremble.
local hard = require "hard"

local function bouncing(letter, title, make)
  return {
    id = "B17" .. letter, title = title, seconds = 60, top_speed = math.sqrt(2 * 9.81 * 0.1),
    build = function(place)
      place:floor { restitution = 0 }
      return { body = make(place), low = math.huge, high = -math.huge, speed = 0 }
    end,
    frame = function(s, t)
      if t > 50 then
        local y = s.place:where(s.body).y
        s.low, s.high, s.speed = math.min(s.low, y), math.max(s.high, y), math.max(s.speed, s.body.speed)
      end
    end,
    finish = function(s)
      return { hard.most("tremble after 50 s, m", s.high - s.low, 1e-6), hard.most("speed after 50 s, m/s", s.speed, 1e-6) }
    end,
  }
end

return {
  bouncing("a", "ball of restitution 0.99 comes to rest", function(place)
    return place:ball { radius = 0.5, restitution = 0.99, at = { 0, 0.6, 0 } }
  end),
  bouncing("b", "box of restitution 0.9 comes to rest", function(place)
    return place:box { size = 1, restitution = 0.9, at = { 0, 0.6, 0 } }
  end),
}
