-- B01 heavy on light: five boxes of 1 kg, and on them one of 10 to 10 000 kg. A stack must carry it without sinking, whatever the ratio.
local hard = require "hard"

local function heavy(letter, mass, sink)
  return {
    id = "B01" .. letter, title = ("%g:1 on five boxes"):format(mass), seconds = 20, fast = letter == "a" and 4 or nil,
    build = function(place)
      local s = { boxes = {}, late = 0 }
      place:floor { friction = 0.6 }
      for i = 1, 6 do
        s.boxes[i] = place:box { name = "box " .. i, size = 1, mass = i == 6 and mass or 1, friction = 0.6, at = { 0, i - 0.5, 0 } }
      end
      return s
    end,
    frame = function(s, t)
      local p = s.place:where(s.boxes[6])
      s.height = math.min(s.height or 5.5, p.y)
      s.drift = math.max(s.drift or 0, math.sqrt(p.x * p.x + p.z * p.z))
      if t > 10 then
        for _, b in ipairs(s.boxes) do s.late = math.max(s.late, b.speed) end
      end
    end,
    finish = function(s)
      return { hard.most("height lost / 5.5 m", (5.5 - s.height) / 5.5, sink), hard.most("drift, m", s.drift, 0.01),
               hard.most("speed after 10 s, m/s", s.late, 1e-3) }
    end,
  }
end

return { heavy("a", 10, 1e-3), heavy("b", 100, 1e-3), heavy("c", 1000, 1e-3), heavy("d", 10000, 1e-2) }
