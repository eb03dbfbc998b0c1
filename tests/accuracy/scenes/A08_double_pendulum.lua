-- A08 two rods of 1 m in a row, released level; A08p two points on massless rods.
local exact = require "exact"

local g = exact.g

-- Two links of unit length. j1, j2: moments of inertia about the upper end of each with what hangs there; c: coupling; w1, w2: weights.
local function links(j1, j2, c, w1, w2)
  return function(_, y)
    local a, b, p, q = y[1], y[2], y[3], y[4]
    local cos, sin = math.cos(a - b), math.sin(a - b)
    local r1 = -c * sin * q * q - w1 * g * math.sin(a)
    local r2 = c * sin * p * p - w2 * g * math.sin(b)
    local m = c * cos
    local det = j1 * j2 - m * m
    return { p, q, (j2 * r1 - m * r2) / det, (j1 * r2 - m * r1) / det }
  end
end

local i = 1.01 / 12
local start = { math.pi / 2, math.pi / 2, 0, 0 }
local function rods(frames, dt) return exact.trajectory(links(i + 5 / 4, i + 1 / 4, 1 / 2, 3 / 2, 1 / 2), start, dt, frames) end
local short, long = exact.once(rods), exact.once(rods)
local points = exact.once(function(frames, dt) return exact.trajectory(links(2, 1, 1, 2, 1), start, dt, frames) end)

local function tip(y) return math.sin(y[1]) + math.sin(y[2]), -math.cos(y[1]) - math.cos(y[2]) end

local function build_with(want, frames)
  return function(world)
    local a = world:box { size = { 1, 0.1, 0.1 }, mass = 1, at = { 0.5, 0, 0 }, collides = false }
    local b = world:box { size = { 1, 0.1, 0.1 }, mass = 1, at = { 1.5, 0, 0 }, collides = false }
    local first = world:hinge { a = a, at = { 0, 0, 0 }, axis = { 0, 1, 0 } }
    local second = world:hinge { a = b, b = a, at = { 1, 0, 0 }, axis = { 0, 1, 0 } }
    return { b = b, joints = { first, second }, worst = 0, gap = 0, want = want(frames, world.frame) }
  end
end

local function frame(s, _, k)
  local x, z = tip(s.want[k])
  s.worst = math.max(s.worst, #(s.b.position + s.b.rotation:rotate { 0.5, 0, 0 } - { x, 0, z }))
  for _, j in ipairs(s.joints) do s.gap = math.max(s.gap, j.error) end
end

local function finish(s) return { error = s.worst, gap = s.gap } end

return {
  {
    id = "A08", title = "double rod pendulum, 3 s", metric = "m", scale = 2, seconds = 3, conserves = { energy = true },
    goal = { fast = { 1e-5, 0.5 }, accurate = { 1e-9, 2 } }, build = build_with(short, 180), frame = frame, finish = finish,
    check = function(dt)
      local x, z = tip(short(180, dt)[180])
      return math.max(math.abs(x - 1.2936756729037632), math.abs(z + 1.4066160071847258))
    end,
  },
  {
    id = "A08l", title = "double rod pendulum, 10 s", metric = "m", scale = 2, seconds = 10, rounding = 1e-9,
    limits = { bound = "the motion amplifies: at 1e-10 the error is 5.2e-12 m after 3 s (A08), and 5.2e-9 m after 10 s." },
    conserves = { energy = true }, build = build_with(long, 600), frame = frame, finish = finish,
    check = function(dt)
      local x, z = tip(long(600, dt)[600])
      return 1e-2 * math.max(math.abs(x - 0.6368503186608076), math.abs(z + 1.7746374071528208))      -- rounding grows 1e3 times
    end,
  },
  {
    id = "A08p", title = "double point pendulum, 5 s", metric = "m", scale = 2, seconds = 5, conserves = { energy = true },
    check = function(dt)
      local y = points(300, dt)[math.floor(5 / dt + 0.5)]
      return math.max(math.abs(y[1] + 0.62718670506653073), math.abs(y[2] + 1.3013155502098117))
    end,
    build = function(world)
      local a = world:ball { radius = 0.05, mass = 1, at = { 1, 0, 0 }, collides = false }
      local b = world:ball { radius = 0.05, mass = 1, at = { 2, 0, 0 }, collides = false }
      world:distance { a = a, at_b = { 0, 0, 0 }, length = 1 }
      world:distance { a = b, b = a, length = 1 }
      return { b = b, worst = 0, want = points(300, world.frame) }
    end,
    frame = function(s, _, k)
      local x, z = tip(s.want[k])
      s.worst = math.max(s.worst, #(s.b.position - { x, 0, z }))
    end,
    finish = function(s) return { error = s.worst } end,
  },
}
