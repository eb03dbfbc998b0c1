-- B15 the same stack of ten cubes as 1 mm and 1 km cubes, gravity in proportion: the result must be the same in units of the cube.
local hard = require "hard"

local function stack(place, size)
  local boxes = {}
  place:floor { friction = 0.6 }
  for i = 1, 10 do
    boxes[i] = place:box { size = size, friction = 0.6, at = { 0.05 * size * (i % 2), (i - 0.5) * size + 0.01 * size * i, 0 } }
  end
  return boxes
end

local function scaled(letter, size, name)
  local fields = { gravity = { 0, -9.81 * size, 0 } }
  return {
    id = "B15" .. letter, title = "stack of ten cubes of " .. name, seconds = 10, fast = letter == "b" and 1 or nil,
    size = size, world = fields,
    fixed_place = true,
    build = function(place)
      local metre = hard.open({}, place.dt)
      return { boxes = stack(place, size), metre = stack(hard.place(metre), 1), others = { { world = metre } }, off = 0 }
    end,
    act = function(s) s.others[1].world:step() end,
    frame = function(s)
      for i, b in ipairs(s.boxes) do s.off = math.max(s.off, #(b.position / size - s.metre[i].position)) end
    end,
    finish = function(s)
      return { hard.most("off the 1 m stack, in cubes", s.off, 1e-6),
               hard.most("top moved, in cubes", #(s.boxes[10].position / size - { 0, 9.5, 0 }), 0.01) }
    end,
  }
end

return { scaled("a", 1e-3, "1 mm"), scaled("b", 1e3, "1 km") }
