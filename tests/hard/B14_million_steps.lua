-- B14 a million frames: the free rotor near its middle axis, and a rod pendulum.
local hard = require "hard"

local frames = 1000000

return {
  {
    id = "B14a", title = "rotor, a million frames", frames = frames, slow = true, watch_every = 10000, isolated = true,
    world = { gravity = { 0, 0, 0 } },
    build = function(place)
      local s = { energy = 0, size = 0 }
      s.box = place:box { size = { 1, 0.6, 0.2 }, mass = 1, spin = { 0.1, 5, 0.1 } }
      s.start, s.l = place.world.energy.kinetic, #place.world.angular_momentum
      return s
    end,
    frame = function(s, _, k)
      if k % 100 ~= 0 then return end
      s.energy = math.max(s.energy, math.abs(s.world.energy.kinetic / s.start - 1))
      s.size = math.max(s.size, math.abs(#s.world.angular_momentum / s.l - 1))
    end,
    finish = function(s)
      return { hard.most("energy, relative", s.energy, 1e-6), hard.most("angular momentum, relative", s.size, 1e-10) }
    end,
  },
  {
    id = "B14b", title = "pendulum, a million frames", frames = frames, slow = true, watch_every = 10000,
    build = function(place)
      local s = { first = 0, last = 0 }
      s.rod = place:box { size = { 1, 0.1, 0.1 }, mass = 1, at = { 0.5, 0, 0 }, collides = false }
      place:hinge { a = s.rod, at = { 0, 0, 0 }, axis = { 0, 0, 1 } }
      local e = place.world.energy
      s.start = e.kinetic + e.potential
      return s
    end,
    frame = function(s, _, k)
      if k % 100 ~= 0 then return end
      local e = s.world.energy
      local off = math.abs(e.kinetic + e.potential - s.start) / (9.81 / 2)
      if k < frames / 10 then s.first = math.max(s.first, off) else s.last = math.max(s.last, off) end
    end,
    finish = function(s)
      return { hard.most("energy, relative", math.max(s.first, s.last), 1e-6),
               hard.most("drift after over drift in the first tenth", s.last / math.max(s.first, 1e-9), 2) }
    end,
  },
}
