-- B19 a piston that nothing stops presses a box to half its size, holds it for 2 s and goes back; a crusher does so at 50 m/s.
local hard = require "hard"

local function crusher(letter, speed)
  local release = 1 / speed + 2
  return {
    id = "B19" .. letter, title = ("squeezed to half at %g m/s"):format(speed), seconds = 6, fast = 6, passive = false,
    chaotic = true,
    build = function(place)
      local s = { speed = 0, far = 0, said = 0 }
      place:floor { friction = 0.6 }
      place:box { name = "wall", fixed = true, size = { 1, 4, 4 }, at = { 1, 2, 0 } }
      s.box = place:box { name = "box", size = 1, mass = 1, friction = 0.6, at = { 0, 0.5, 0 } }
      s.piston = place:box { name = "piston", kinematic = true, size = { 1, 4, 4 }, at = { -1.5, 2, 0 } }
      return s
    end,
    act = function(s, t)                                            -- in to x = -0.5, then held, then back to -1.5
      local x, dt = s.place:where(s.piston).x, s.place.dt
      local v = t < release and math.min(speed, (-0.5 - x) / dt) or -math.min(0.5, (x + 1.5) / dt)
      s.piston:drive { velocity = { v, 0, 0 } }
    end,
    frame = function(s, t)
      local stats = s.world:stats()
      s.said = math.max(s.said, stats.penetration, stats.residual, stats.rejected + stats.gave_up)
      if t > release + 0.1 then
        s.speed = math.max(s.speed, s.box.speed)
        local p = s.place:where(s.box)
        s.far = math.max(s.far, math.abs(p.x), math.abs(p.z), p.y - 0.5)
      end
    end,
    finish = function(s)
      return { hard.most("speed after release, m/s", s.speed, 1), hard.most("out of its place, in boxes", s.far, 1),
               hard.least("conflict shown in the figures", s.said, 0.1) }
    end,
  }
end

return { crusher("a", 0.5), crusher("b", 50) }
