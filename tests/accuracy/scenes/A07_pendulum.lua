-- A07 a rod of 1 m on a hinge, released level: theta'' = -(g/2) sin theta / I. A07p is a point on a massless rod.
local exact = require "exact"

local g = exact.g
local inertia = 1.01 / 12 + 1 / 4               -- of the rod 1 x 0.1 x 0.1 about its end

local function swing(factor)
  return exact.once(function(frames, dt)
    return exact.trajectory(function(_, y) return { y[2], -factor * math.sin(y[1]) } end, { math.pi / 2, 0 }, dt, frames)
  end)
end

local rod, point = swing(g / 2 / inertia), swing(g)

return {
  {
    id = "A07", title = "rod pendulum, 10 s", metric = "m", scale = 1, seconds = 10, conserves = { energy = true },
    goal = { fast = { 1e-6, 0.25 }, accurate = { 1e-10, 0.8 } },
    -- theta(10) and omega(10) of the elliptic closed form
    check = function(dt)
      local last = rod(math.floor(10 / dt + 0.5), dt)[math.floor(10 / dt + 0.5)]
      return math.max(math.abs(last[1] - 0.82746667874679126), math.abs(last[2] + 4.4572277905732990))
    end,
    build = function(world)
      local body = world:box { size = { 1, 0.1, 0.1 }, mass = 1, at = { 0.5, 0, 0 }, collides = false }
      return { body = body, hinge = world:hinge { a = body, at = { 0, 0, 0 }, axis = { 0, 1, 0 } }, worst = 0, gap = 0,
               want = rod(600, world.frame) }
    end,
    frame = function(s, _, k)
      local a = s.want[k][1]
      s.worst = math.max(s.worst, #(s.body.position - { 0.5 * math.sin(a), 0, -0.5 * math.cos(a) }))
      s.gap = math.max(s.gap, #(s.body.position - s.body.rotation:rotate { 0.5, 0, 0 }))
    end,
    finish = function(s) return { error = s.worst, gap = s.gap } end,
  },
  {
    id = "A07p", title = "point pendulum, 10 s", metric = "m", scale = 1, seconds = 10, conserves = { energy = true },
    limits = { proportionality = "5.6e-11 m at 1e-6, a hundred-thousandth of the bound, is less than that tolerance would need: 143 of " ..
      "its 600 frames are one step, and errors of either sign cancel. From 1e-5 to 1e-9 it is 4.2e-9, 5.6e-11, 2.6e-11, 9.7e-13 " ..
      "and 1.8e-13 m." },
    check = function(dt)
      return math.abs(point(math.floor(10 / dt + 0.5), dt)[math.floor(10 / dt + 0.5)][1] - 0.27868067356998295)
    end,
    build = function(world)
      local body = world:ball { radius = 0.05, mass = 1, at = { 1, 0, 0 }, collides = false }
      world:distance { a = body, at_b = { 0, 0, 0 }, length = 1 }
      return { body = body, worst = 0, want = point(600, world.frame) }
    end,
    frame = function(s, _, k)
      local a = s.want[k][1]
      s.worst = math.max(s.worst, #(s.body.position - { math.sin(a), 0, -math.cos(a) }))
    end,
    finish = function(s) return { error = s.worst, gap = math.abs(#s.body.position - 1) } end,
  },
}
