-- B26 impacts at one instant: Newton's cradle, the break of 15 billiard balls, a ball into a V, a cube flat on its face.
local hard = require "hard"

local cradle = {
  id = "B26a", title = "five touching balls, one strikes", seconds = 1, fast = 1,
  world = { gravity = { 0, 0, 0 } }, isolated = true, top_speed = 1,
  build = function(place)
    local s = { balls = {} }
    for i = 1, 5 do
      s.balls[i] = place:ball { radius = 0.5, mass = 1, restitution = 1, friction = 0, at = { i == 1 and -0.5 or i - 1, 0, 0 },
                                velocity = { i == 1 and 1 or 0, 0, 0 } }
    end
    return s
  end,
  finish = function(s)
    local off = 0
    for i, b in ipairs(s.balls) do off = math.max(off, math.abs(b.velocity.x - (i == 5 and 1 or 0))) end
    return { hard.most("off one out at full speed, m/s", off, 1e-9),
             hard.most("momentum, relative", #(s.world.momentum - { 1, 0, 0 }), 1e-12) }
  end,
}

local rack = {
  id = "B26b", title = "break of 15 billiard balls", seconds = 2, fast = 2,
  world = { gravity = { 0, 0, 0 } }, isolated = true, chaotic = true, top_speed = 5,
  build = function(place)
    local s, r = { balls = {}, mirror = {} }, 0.02625
    for row = 0, 4 do
      for i = 0, row do
        local n = #s.balls + 1
        s.balls[n] = place:ball { radius = r, mass = 0.16, restitution = 0.95, friction = 0,
                                  at = { row * r * math.sqrt(3), 0, (2 * i - row) * r } }
        s.mirror[n] = n - i + (row - i)
      end
    end
    s.cue = place:ball { radius = r, mass = 0.16, restitution = 0.95, friction = 0, at = { -1, 0, 0 }, velocity = { 5, 0, 0 } }
    return s
  end,
  finish = function(s)
    local off, spread = 0, 0
    for n, b in ipairs(s.balls) do
      local p, q = s.place:where(b), s.place:where(s.balls[s.mirror[n]])
      off, spread = math.max(off, #(p - { q.x, q.y, -q.z })), math.max(spread, #p)
    end
    return { hard.most("off mirror symmetry, m", off, 1e-9),
             hard.most("momentum, relative", #(s.world.momentum / 0.8 - { 1, 0, 0 }), 1e-12),
             hard.least("they part, m", spread, 0.5) }
  end,
}

local groove = {
  id = "B26c", title = "ball into a V", seconds = 3, fast = 3, top_speed = math.sqrt(2 * 9.81 * 1.6), fixed_place = true,
  build = function(place)
    local s = { side = 0 }
    place:plane { normal = { 1, 1, 0 }, friction = 0, restitution = 0.5 }
    place:plane { normal = { -1, 1, 0 }, friction = 0, restitution = 0.5 }
    s.ball = place:ball { radius = 0.5, restitution = 0.5, friction = 0, at = { 0, 2, 0 } }
    return s
  end,
  frame = function(s) s.side = math.max(s.side, math.abs(s.place:where(s.ball).x)) end,
  finish = function(s)
    return { hard.most("off the middle, m", s.side, 1e-9),
             hard.most("height off rest, m", math.abs(s.place:where(s.ball).y - 0.5 * math.sqrt(2)), 1e-6) }
  end,
}

local cube = {
  id = "B26d", title = "cube flat on its face", seconds = 3, fast = 3, top_speed = math.sqrt(2 * 9.81 * 0.5),
  build = function(place)
    local s = { spin = 0 }
    place:floor { friction = 0.5, restitution = 0.5 }
    s.cube = place:box { size = 1, friction = 0.5, restitution = 0.5, at = { 0, 1, 0 } }
    return s
  end,
  frame = function(s) s.spin = math.max(s.spin, #s.cube.spin) end,
  finish = function(s)
    return { hard.most("spin, rad/s", s.spin, 1e-9), hard.most("height off rest, m", math.abs(s.place:where(s.cube).y - 0.5), 1e-6) }
  end,
}

return { cradle, rack, groove, cube }
