-- B21 springs far too stiff for the frame step: 1 kg on 1e4 to 1e8 N/m, free and damped; a lattice of 10 x 10 of them.
local hard = require "hard"

local stiffness = { 1e4, 1e5, 1e6, 1e7, 1e8 }

local function springs(letter, damping)
  return {
    id = "B21" .. letter, title = damping > 0 and "damped springs, 1e4 to 1e8 N/m" or "free springs, 1e4 to 1e8 N/m", seconds = 10,
    fast = 1, size = 1e-3,
    build = function(place)
      local s = { balls = {}, worst = 0 }
      for i, k in ipairs(stiffness) do
        s.balls[i] = place:ball { radius = 0.1, mass = 1, at = { i, -1, 0 }, collides = false }
        place:spring { a = s.balls[i], at_b = { i, 0, 0 }, length = 1, stiffness = k, damping = damping * 2 * math.sqrt(k) }
      end
      return s
    end,
    frame = function(s)
      if damping > 0 then return end
      for i, b in ipairs(s.balls) do                            -- between 0 and twice the sag: in units of the sag
        local sag = 9.81 / stiffness[i]
        s.worst = math.max(s.worst, math.abs(-1 - s.place:where(b).y - sag) / sag)
      end
    end,
    finish = function(s)
      if damping == 0 then return { hard.most("greatest swing / sag", s.worst, 1.01) } end
      for i, b in ipairs(s.balls) do
        local sag = 9.81 / stiffness[i]
        s.worst = math.max(s.worst, math.abs((-1 - s.place:where(b).y) / sag - 1))
      end
      return { hard.most("off the static sag, relative", s.worst, 1e-3) }
    end,
  }
end

-- Columns of ten masses hang from the world; springs between neighbours, across and down.
local function lattice(letter, k)
  local damping = 4 * math.sqrt(k)           -- 0.3 of critical for the lowest mode, 0.149 sqrt(k) rad/s: at rest within 2 s at 1e4 N/m
  return {
    id = "B21" .. letter, title = ("lattice 10 x 10, %g N/m"):format(k), seconds = 10, slow = k ~= 1e6,
    fast = k == 1e8 and 1 or nil, size = 1e-2,
    build = function(place)
      local s = { balls = {} }
      for row = 1, 10 do
        s.balls[row] = {}
        for col = 1, 10 do
          local ball = place:ball { radius = 0.1, mass = 1, at = { col, -row, 0 }, collides = false }
          s.balls[row][col] = ball
          local above = row > 1 and s.balls[row - 1][col] or nil
          place:spring { a = ball, b = above, at_b = { col, 1 - row, 0 }, length = 1, stiffness = k, damping = damping }
          if col > 1 then
            place:spring { a = ball, b = s.balls[row][col - 1], length = 1, stiffness = k, damping = damping }
          end
        end
      end
      return s
    end,
    finish = function(s)
      local worst, sag = 0, 0
      for row = 1, 10 do
        sag = sag + (11 - row) * 9.81 / k
        for col = 1, 10 do worst = math.max(worst, #(s.place:where(s.balls[row][col]) - { col, -row - sag, 0 })) end
      end
      return { hard.most("off the static sag, relative", worst / sag, 1e-3) }
    end,
  }
end

return { springs("a", 0), springs("b", 0.5), lattice("c", 1e4), lattice("d", 1e6), lattice("e", 1e8) }
