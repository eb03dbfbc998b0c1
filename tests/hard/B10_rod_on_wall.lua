-- B10 spinning rods of 1 m x 4 cm at 60 m/s on a wall of 2 cm; a bullet against a free thin plate.
local hard = require "hard"

local function inside(x, wall) return x < wall end            -- false for what is not a number

local function rods(letter, spin)
  return {
    id = "B10" .. letter, title = ("rods at 60 m/s and %d rad/s on a wall"):format(spin), seconds = 0.5,
    fast = letter == "a" and 0.2 or nil,
    world = { gravity = { 0, 0, 0 } }, chaotic = true,
    build = function(place)
      local s = { rods = {} }
      place:box { name = "wall", fixed = true, size = { 0.02, 80, 80 }, at = { 0.01, 0, 0 } }
      for k = 1, 20 do
        s.rods[k] = place:box { size = { 0.04, 1, 0.04 }, mass = 1, at = { -1 - 60 * place.dt * (k - 0.5) / 20, 0, 3 * (k - 10) },
                                velocity = { 60, 0, 0 }, spin = { 0, 0, spin } }
      end
      return s
    end,
    finish = function(s)
      local through = 0
      for _, b in ipairs(s.rods) do
        if not inside(s.place:where(b).x, 0.01) then through = through + 1 end
      end
      return { hard.most("rods through", through, 0) }
    end,
  }
end

local plate = {
  id = "B10c", title = "bullet on a free thin plate", seconds = 0.2, fast = 0.2,
  world = { gravity = { 0, 0, 0 } }, isolated = true, top_speed = 500,
  build = function(place)
    local s = {}
    s.plate = place:box { name = "plate", size = { 0.01, 1, 1 }, mass = 10, at = { 0.005, 0, 0 } }
    s.bullet = place:ball { name = "bullet", radius = 0.05, mass = 1, at = { -1.3, 0, 0 }, velocity = { 500, 0, 0 } }
    return s
  end,
  finish = function(s)
    local want = 500 / 11                                       -- plastic and central: they go on together
    return { hard.most("speed of the plate, relative", math.abs(s.plate.velocity.x / want - 1), 1e-9),
             hard.least("plate ahead of bullet, m", s.place:where(s.plate).x - s.place:where(s.bullet).x, 0.054) }
  end,
}

return { rods("a", 60), rods("b", 600), plate }
