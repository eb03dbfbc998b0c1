-- B13 a box at 100 turns a second for 10 s; a gyroscope on a pivot. Energy, the size and the direction of the angular momentum stay.
local hard = require "hard"

local spinner = {
  id = "B13a", title = "free box at 100 turns/s", seconds = 10, fast = 2, world = { gravity = { 0, 0, 0 } }, isolated = true,
  build = function(place)
    local s = { energy = 0, size = 0, turn = 0 }
    s.box = place:box { size = { 1, 0.6, 0.2 }, spin = { 10, 200 * math.pi, 10 } }
    s.start, s.l = place.world.energy.kinetic, place.world.angular_momentum
    return s
  end,
  frame = function(s)
    local l = s.world.angular_momentum
    s.energy = math.max(s.energy, math.abs(s.world.energy.kinetic / s.start - 1))
    s.size = math.max(s.size, math.abs(#l / #s.l - 1))
    s.turn = math.max(s.turn, #(l:normalized() - s.l:normalized()))
  end,
  finish = function(s)
    return { hard.most("energy, relative", s.energy, 1e-6), hard.most("angular momentum, relative", s.size, 1e-6),
             hard.most("its direction, rad", s.turn, 1e-6) }
  end,
}

local gyroscope = {
  id = "B13b", title = "gyroscope on a pivot", seconds = 10, fast = 2, top_speed = 3,
  build = function(place, digbox)
    local s = { energy = 0, gap = 0, upright = 0 }
    s.disc = place:cylinder { radius = 0.1, height = 0.02, mass = 1, at = { 0.2, 0, 0 }, collides = false,
                              rotation = digbox.quat { axis = { 0, 0, 1 }, angle = math.pi / 2 }, spin = { 300, 0, 0 } }
    s.joint = place:ball_joint { a = s.disc, at = { 0, 0, 0 } }
    local e = place.world.energy
    s.start, s.kinetic, s.l = e.kinetic + e.potential, e.kinetic, place.world.angular_momentum.y
    return s
  end,
  frame = function(s)
    local e = s.world.energy
    s.energy = math.max(s.energy, math.abs(e.kinetic + e.potential - s.start) / s.kinetic)
    s.gap = math.max(s.gap, s.joint.error)
    s.upright = math.max(s.upright, math.abs(s.place:where(s.disc).y))
  end,
  finish = function(s)
    return { hard.most("energy, relative", s.energy, 1e-6), hard.most("gap of the pivot, m", s.gap, 1e-6),
             hard.most("nutation, m", s.upright, 0.02) }
  end,
}

return { spinner, gyroscope }
