-- B25 three spheres on one axis fall on each other and on the floor, without bounce, with 0.8 and with 1.
local hard = require "hard"

local rests = { { 0.45152364, 0.5 }, { 0.55300126, 1.5 }, { 0.63855086, 2.5 } }

-- Plastic: free fall, then the middle of ball i rests at i - 0.5 from its time on
local function plastic(s, t)
  for i, ball in ipairs(s.balls) do
    local want = t < rests[i][1] and 1.5 * i - 9.81 * t * t / 2 or rests[i][2]
    s.off = math.max(s.off, math.abs(s.place:where(ball).y - want))
  end
end

local function drop(letter, e)
  return {
    id = "B25" .. letter, title = ("three spheres on one axis, restitution %g"):format(e), seconds = e == 0 and 2 or 10,
    fast = e == 0 and 2 or 3,
    top_speed = e == 0 and math.sqrt(2 * 9.81 * 2) or nil, chaotic = e > 0,
    build = function(place)
      local s = { balls = {}, off = 0, deep = 0, side = 0, rise = 0, drift = 0 }
      place:floor { restitution = e }
      for i = 1, 3 do s.balls[i] = place:ball { radius = 0.5, mass = 1, restitution = e, at = { 0, 1.5 * i, 0 } } end
      local energy = place.world.energy
      s.start = energy.kinetic + energy.potential
      s.last = s.start
      return s
    end,
    frame = function(s, t)
      local below = -0.5
      for _, ball in ipairs(s.balls) do
        local p = s.place:where(ball)
        s.deep, below = math.max(s.deep, below + 1 - p.y), p.y
        s.side = math.max(s.side, math.abs(p.x), math.abs(p.z))
      end
      local energy = s.world.energy
      local now = energy.kinetic + energy.potential
      s.rise, s.drift, s.last = math.max(s.rise, (now - s.last) / s.start), math.max(s.drift, math.abs(now / s.start - 1)), now
      if e == 0 then plastic(s, t) end
    end,
    finish = function(s)
      local list = { hard.most("penetration, m", s.deep, 1e-4), hard.most("off the axis, m", s.side, 1e-12) }
      list[3] = e < 1 and hard.most("rise of energy in a frame", s.rise, 1e-9) or hard.most("energy drift", s.drift, 1e-9)
      if e == 0 then list[4] = hard.most("off the exact motion, m", s.off, 1e-4) end
      return list
    end,
  }
end

return { drop("a", 0), drop("b", 0.8), drop("c", 1) }
