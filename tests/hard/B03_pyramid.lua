-- B03 pyramids of 10, 9, ... 1 boxes with a top of 100, 200 and 300 times the mass of the others.
local hard = require "hard"

local function pyramid(letter, mass)
  return {
    id = "B03" .. letter, title = ("pyramid, top %d:1"):format(mass), seconds = 30, slow = true,
    build = function(place)
      local s = { boxes = {}, at = {}, deep = 0, moved = 0 }
      place:floor { friction = 0.6 }
      for row = 0, 9 do
        for i = 0, 9 - row do
          local at = { 1.05 * (i - (9 - row) / 2), row + 0.5, 0 }
          local n = #s.boxes + 1
          s.boxes[n], s.at[n] = place:box { size = 1, mass = row == 9 and mass or 1, friction = 0.6, at = at }, at
        end
      end
      return s
    end,
    frame = function(s, t)
      if t > 1 then s.deep = math.max(s.deep, s.world:stats().penetration) end
    end,
    finish = function(s)
      for i, b in ipairs(s.boxes) do s.moved = math.max(s.moved, #(s.place:where(b) - s.at[i])) end
      return { hard.most("furthest move, m", s.moved, 0.05), hard.most("penetration after 1 s, m", s.deep, 1e-3) }
    end,
  }
end

return { pyramid("a", 100), pyramid("b", 200), pyramid("c", 300) }
