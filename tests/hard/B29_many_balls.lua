-- B29 many balls: 216 that fall together, plastic and elastic; 1000 poured; 10 000 poured.
local hard = require "hard"

-- Positions off by up to 1 mm, from a generator of its own (minimal standard, Park and Miller 1988)
local function noise(seed)
  return function()
    seed = seed * 48271 % 2147483647
    return (2 * seed / 2147483647 - 1) * 1e-3
  end
end

local function cube_of_balls(letter, e)
  return {
    id = "B29" .. letter, title = ("216 balls, restitution %g"):format(e), seconds = e == 1 and 5 or 10, slow = true,
    chaotic = true, size = 0.2, fast = e == 0 and 0.7 or nil,          -- they land at 0.55 s
    build = function(place)
      local s, off = { deep = 0, drift = 0 }, noise(42)
      place:floor { friction = 0, restitution = e }
      for i = 0, 215 do
        place:ball { radius = 0.1, mass = 10, friction = 0, restitution = e,
                     at = { 0.21 * (i % 6) + off(), 0.2 + e + 0.21 * (i // 36) + off(), 0.21 * (i // 6 % 6) + off() } }
      end
      local energy = place.world.energy
      s.start = energy.kinetic + energy.potential
      return s
    end,
    frame = function(s)
      s.deep = math.max(s.deep, s.world:stats().penetration)
      local energy = s.world.energy
      s.drift = math.max(s.drift, math.abs((energy.kinetic + energy.potential) / s.start - 1))
    end,
    finish = function(s)
      local list = { hard.most("penetration / diameter", s.deep / 0.2, 1e-3) }
      if e == 1 then list[2] = hard.most("energy drift", s.drift, 1e-6) end
      return list
    end,
  }
end

local function poured(letter, count, radius, wide)
  local half = wide / 2
  return {
    id = "B29" .. letter, title = count .. " balls poured", seconds = 10, slow = true, chaotic = true, size = 2 * radius,
    build = function(place)
      local s, off = { balls = {}, deep = 0 }, noise(7)
      place:floor { friction = 0.3 }
      for _, w in ipairs { { 1, 0 }, { -1, 0 }, { 0, 1 }, { 0, -1 } } do
        place:plane { normal = { -w[1], 0, -w[2] }, offset = -half, friction = 0.3 }
      end
      local side = math.floor(wide / (2.2 * radius))
      for i = 0, count - 1 do
        s.balls[i + 1] = place:ball { radius = radius, friction = 0.3, at = {
          (i % side + 0.5) * 2.2 * radius - half + off(), radius * (1.2 + 2.2 * (i // (side * side))),
          (i // side % side + 0.5) * 2.2 * radius - half + off() } }
      end
      return s
    end,
    frame = function(s, t)
      if t > 5 then s.deep = math.max(s.deep, s.world:stats().penetration) end
    end,
    finish = function(s)
      local out, speed = 0, 0
      for _, b in ipairs(s.balls) do
        local p = s.place:where(b)
        if not (math.abs(p.x) <= half and math.abs(p.z) <= half and p.y >= 0) then out = out + 1 end
        speed = math.max(speed, b.speed)
      end
      return { hard.most("penetration after 5 s / diameter", s.deep / (2 * radius), 1e-3), hard.most("balls outside", out, 0),
               hard.most("speed at the end, m/s", speed, 0.5) }
    end,
  }
end

return { cube_of_balls("a", 0), cube_of_balls("b", 1), poured("c", 1000, 0.1, 1.8), poured("d", 10000, 0.1, 4.5) }
