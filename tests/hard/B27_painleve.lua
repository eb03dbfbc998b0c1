-- B27 Painleve's rod: slender rods that slide on one end with friction 1.5 to 3, where rigid bodies have no solution without an impulse.
local hard = require "hard"

local length, thick = 1, 0.02
local inertia = (length ^ 2 + thick ^ 2) / 12               -- over the mass, across the rod

return {
  id = "B27", title = "Painleve rods, 48 starts", seconds = 3, chaotic = true,
  build = function(place, digbox)
    local s = { rods = {}, start = {}, gain = 0, low = 0 }
    place:floor { friction = 10 }
    local z = 0
    for _, mu in ipairs { 1.5, 2, 2.5, 3 } do
      for angle = 30, 80, 10 do
        for way = -1, 1, 2 do
          local a, n = math.rad(angle), #s.rods + 1
          z = z + 0.5
          s.rods[n] = place:box { name = ("rod mu %g, %d degrees, %+d"):format(mu, angle, way), size = { length, thick, thick }, mass = 1,
            friction = mu * mu / 10, velocity = { 2 * way, 0, 0 }, rotation = digbox.quat { axis = { 0, 0, 1 }, angle = a },
            at = { 0, (length * math.sin(a) + thick * math.cos(a)) / 2 + 1e-6, z } }
          s.start[n] = 2 + 9.81 * place:where(s.rods[n]).y
        end
      end
    end
    return s
  end,
  frame = function(s)
    for n, b in ipairs(s.rods) do
      local along = b.rotation:rotate { 1, 0, 0 }
      local w = b.spin
      local across = w - along * along:dot(w)
      local energy = b.speed ^ 2 / 2 + inertia / 2 * across:dot(across) + 9.81 * s.place:where(b).y
      local gain = energy / s.start[n] - 1
      if gain > s.gain or gain ~= gain then s.gain, s.name = gain, b.name end
      s.low = math.max(s.low, length / 2 * math.abs(along.y) - s.place:where(b).y)
    end
  end,
  finish = function(s)
    return { hard.most("gain of energy" .. (s.name and ": " .. s.name or ""), s.gain, 1e-6),
             hard.most("axis below the floor, m", s.low, 1e-3) }
  end,
}
