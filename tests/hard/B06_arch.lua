-- B06 semicircular arch of 15 voussoirs, friction 1: of thickness 0.15 R it stands, of 0.09 R it must fall (limit 0.1075 R; Heyman).
local hard = require "hard"

local count = 15

local function stones(place, digbox, thickness)
  local list, inner, outer = {}, 1 - thickness / 2, 1 + thickness / 2
  for i = 1, count do
    local from, to, corners = math.pi * (i - 1) / count, math.pi * i / count, {}
    local mid = digbox.vec(math.cos((from + to) / 2), math.sin((from + to) / 2), 0)
    for _, angle in ipairs { from, to } do
      for _, r in ipairs { inner, outer } do
        for side = -1, 1, 2 do corners[#corners + 1] = digbox.vec(r * math.cos(angle), r * math.sin(angle), side * 0.2) - mid end
      end
    end
    list[i] = place:hull { name = "stone " .. i, points = corners, at = mid, friction = 1 }
  end
  return list
end

local function arch(letter, thickness, stands)
  return {
    id = "B06" .. letter, title = ("arch, thickness %g R, %s"):format(thickness, stands and "stands" or "falls"),
    seconds = stands and 30 or 4, size = 0.2, chaotic = not stands, fast = letter == "a" and 2 or nil,
    build = function(place, digbox)
      place:floor { friction = 1 }
      local s = { stones = stones(place, digbox, thickness), at = {}, moved = 0 }
      for i, stone in ipairs(s.stones) do s.at[i] = place:where(stone) end
      return s
    end,
    finish = function(s)
      for i, stone in ipairs(s.stones) do s.moved = math.max(s.moved, #(s.place:where(stone) - s.at[i])) end
      return { stands and hard.most("furthest move / R", s.moved, 1e-2) or hard.least("furthest move / R", s.moved, 0.1) }
    end,
  }
end

return { arch("a", 0.15, true), arch("b", 0.09, false), arch("c", 0.115, true), arch("d", 0.1, false) }
