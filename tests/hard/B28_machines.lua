-- B28 barrels held by a plank that is taken away; a wrench that falls into a running crank and piston.
local hard = require "hard"

local barrels = {
  id = "B28a", title = "barrels behind a plank", seconds = 6, chaotic = true, passive = false, fixed_place = true,
  build = function(place, digbox)
    local a, s = math.rad(20), { bodies = {}, low = 0 }
    local turn = digbox.quat { axis = { 0, 0, 1 }, angle = -a }
    s.normal = turn:rotate { 0, 1, 0 }
    place:plane { normal = s.normal, friction = 0.5 }
    s.plank = place:box { name = "plank", fixed = true, size = { 0.1, 1, 4 }, rotation = turn, friction = 0.5,
                          at = turn:rotate { 2, 0.5, 0 } }
    for row = 0, 2 do
      for i = 0, 3 - row do
        s.bodies[#s.bodies + 1] = place:cylinder {
          name = "barrel", radius = 0.3, height = 1, friction = 0.5, density = 500,
          at = turn:rotate { 1.65 - 0.6 * i - 0.3 * row, 0.3 + row * 0.3 * math.sqrt(3), 0 },
          rotation = turn * digbox.quat { axis = { 1, 0, 0 }, angle = math.pi / 2 } }
      end
    end
    return s
  end,
  act = function(s, t)
    if s.plank and t >= 1 then
      s.still = 0
      for _, b in ipairs(s.bodies) do s.still = math.max(s.still, b.speed) end
      s.plank:remove()
      s.plank = nil
      local e = s.world.energy
      s.start, s.most = e.kinetic + e.potential, 0
    end
  end,
  frame = function(s)
    for _, b in ipairs(s.bodies) do s.low = math.max(s.low, 0.3 - s.place:where(b):dot(s.normal)) end
    if not s.start then return end
    local e = s.world.energy
    s.most = math.max(s.most, (e.kinetic + e.potential - s.start) / math.max(e.kinetic, 1))
  end,
  finish = function(s)
    local roll = 0
    for _, b in ipairs(s.bodies) do roll = math.max(roll, b.speed) end
    return { hard.most("speed before release, m/s", s.still, 0.05), hard.least("speed after, m/s", roll, 1),
             hard.most("energy rise, relative", s.most, 1e-6), hard.most("in the slope, m", s.low, 3e-3) }
  end,
}

local engine = {
  id = "B28b", title = "wrench in a crank and piston", seconds = 8, chaotic = true, passive = false, slow = true,
  build = function(place)
    local s = { joints = {}, gap = 0, off = 0, kinetic = 1 }
    local axis = { 0, 0, 1 }
    place:floor { friction = 0.4 }
    local crank = place:box { name = "crank", size = { 0.3, 0.06, 0.06 }, mass = 3, at = { 0.15, 1, 0 }, group = -1 }
    local rod = place:box { name = "rod", size = { 0.7, 0.05, 0.05 }, mass = 1.5, at = { 0.65, 1, 0 }, group = -1 }
    local piston = place:box { name = "piston", size = { 0.2, 0.2, 0.2 }, mass = 2, at = { 1, 1, 0 }, group = -1 }
    s.joints[1] = place:hinge { a = crank, at = { 0, 1, 0 }, axis = axis, motor = { speed = 10, max_torque = 50 } }
    s.joints[2] = place:hinge { a = rod, b = crank, at = { 0.3, 1, 0 }, axis = axis }
    s.joints[3] = place:hinge { a = piston, b = rod, at = { 1, 1, 0 }, axis = axis }
    s.joints[4] = place:slider { a = piston, along = { 1, 0, 0 } }
    place:box { name = "block", fixed = true, size = { 0.1, 1, 1 }, at = { 1.25, 1, 0 }, friction = 0.4 }
    place:box { name = "bed", fixed = true, size = { 0.5, 0.1, 1 }, at = { 0.95, 0.8, 0 }, friction = 0.4 }
    s.piston = piston
    return s
  end,
  act = function(s, t)
    if t >= 2 and not s.wrench then
      s.wrench = s.place:box { name = "wrench", size = { 0.05, 0.25, 0.05 }, mass = 0.5, friction = 0.4, at = { 1.15, 2, 0 } }
      s.added = s.world.energy.total
    end
  end,
  frame = function(s)
    for _, j in ipairs(s.joints) do s.gap = math.max(s.gap, j.error) end
    local e = s.world.energy
    s.off, s.kinetic = math.abs(e.numerical), math.max(s.kinetic, e.kinetic, math.abs(e.work_in))
  end,
  finish = function(s)
    return { hard.most("energy not accounted for / work", s.off / s.kinetic, 1e-3), hard.most("worst gap, m", s.gap, 1e-3),
             hard.most("wrench speed at the end, m/s", s.wrench and s.wrench.speed or 0, 20) }
  end,
}

return { barrels, engine }
