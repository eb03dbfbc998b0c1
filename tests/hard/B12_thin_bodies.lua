-- B12 twenty plates of 1 x 1 x 0.002 m in a stack; thirty rods of 2 x 0.01 x 0.01 m in a heap.
local hard = require "hard"

local function low(s, sizes)
  local least = 0
  for _, b in ipairs(s.bodies) do
    local q, p, reach = b.rotation, s.place:where(b), 0
    for k = 1, 3 do
      local axis = { 0, 0, 0 }
      axis[k] = 1
      reach = reach + math.abs(q:rotate(axis).y) * sizes[k] / 2
    end
    least = math.min(least, p.y - reach)
  end
  return -least
end

local function judge(sizes)
  return function(s)
    return { hard.most("speed after 10 s, m/s", s.late, 1e-3), hard.most("below the floor, m", low(s, sizes), 1e-3) }
  end
end

local function frame(s, t)
  if t > 10 then
    for _, b in ipairs(s.bodies) do s.late = math.max(s.late, b.speed) end
  end
end

local thin, rod = { 1, 0.002, 1 }, { 2, 0.01, 0.01 }

return {
  {
    id = "B12a", title = "stack of 20 thin plates", seconds = 12, frame = frame, finish = judge(thin),
    build = function(place)
      local s = { bodies = {}, late = 0 }
      place:floor { friction = 0.5 }
      for i = 1, 20 do s.bodies[i] = place:box { size = thin, friction = 0.5, at = { 0, 0.002 * (i - 0.5) + 1e-4 * i, 0 } } end
      return s
    end,
  },
  {
    id = "B12b", title = "heap of 30 rods", seconds = 12, frame = frame, finish = judge(rod), chaotic = true, slow = true,
    build = function(place, digbox)
      local s = { bodies = {}, late = 0 }
      place:floor { friction = 0.5 }
      for i = 1, 30 do
        s.bodies[i] = place:box { size = rod, density = 7800, friction = 0.5, at = { 0.03 * (i % 7), 0.03 * i, 0.04 * (i % 5) },
                                  rotation = digbox.quat { axis = { 0, 1, 0 }, angle = ("%.17g rad"):format(2.4 * i) } }
      end
      return s
    end,
  },
}
