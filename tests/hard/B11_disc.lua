-- B11 a coin spun on its edge: the steeper its end, the faster it turns. It must lose energy only, and lie flat at the end.
local hard = require "hard"

return {
  id = "B11", title = "spun disc", seconds = 20, size = 0.04, chaotic = true,
  build = function(place, digbox)
    local s = { rise = 0, deep = 0 }
    place:floor { friction = 0.3, rolling_friction = 0.004 }
    s.disc = place:cylinder { name = "disc", radius = 0.02, height = 0.002, friction = 0.3, rolling_friction = 0.004,
                              at = { 0, 0.02 * math.cos(0.1) + 0.001 * math.sin(0.1) + 1e-6, 0 },
                              rotation = digbox.quat { axis = { 1, 0, 0 }, angle = math.pi / 2 - 0.1 }, spin = { 0, 30, 0 } }
    local e = place.world.energy
    s.last = e.kinetic + e.potential
    s.scale = s.last
    return s
  end,
  frame = function(s, t)
    local e = s.world.energy
    local now = e.kinetic + e.potential
    s.rise, s.last = math.max(s.rise, now - s.last), now
    if t > 15 then s.deep = math.max(s.deep, s.world:stats().penetration) end
  end,
  finish = function(s)
    local axis = s.disc.rotation:rotate { 0, 1, 0 }
    return { hard.most("rise of energy in a frame, relative", s.rise / s.scale, 1e-6),
             hard.most("1 - cosine of its tilt", 1 - math.abs(axis.y), 1e-6),
             hard.most("penetration / size", s.deep / 0.04, 1e-5), hard.most("speed at the end, m/s", s.disc.speed, 1e-3) }
  end,
}
