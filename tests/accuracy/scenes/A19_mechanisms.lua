-- A19a Andrews' squeezing mechanism; A19b, A19c the N-four-bar that passes its straight (singular) position, N = 2 and 40.
local exact = require "exact"

local g = exact.g

-- ---- (a) seven bodies in the plane xy, no gravity; data: test set for initial value problem solvers, Andrews' squeezing mechanism,
-- after Hairer and Wanner, Solving Ordinary Differential Equations II, VI.9 ----

local rr, ra, d, da, e, ea, sa = 7e-3, 92e-5, 28e-3, 115e-4, 2e-2, 1421e-5, 1874e-5
local sb, sc, sd, ta, tb, u, ua, ub = 1043e-5, 18e-3, 2e-2, 2308e-5, 916e-5, 4e-2, 1228e-5, 449e-5
local zf, zt, fa = 2e-2, 4e-2, 1421e-5
local A, B, C = { -0.06934, -0.00227 }, { -0.03635, 0.03273 }, { 0.014, 0.072 }
local torque, stiffness, length = 0.033, 4530, 0.07785
local mass = { 0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498 }
local moment = { 2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5 }
local beta, theta, gamma, phi = -0.0617138900142764496358948458001, 0, 0.455279819163070380255912382449, 0.222668390165885884674473185609
local delta, omega, epsilon = 0.487364979543842550225598953530, -0.222668390165885884674473185609, 1.23054744454982119249735015568

-- p + along (cos a, sin a) + across (-sin a, cos a)
local function off(p, a, along, across)
  across = across or 0
  return { p[1] + along * math.cos(a) - across * math.sin(a), p[2] + along * math.sin(a) + across * math.cos(a) }
end

local function squeezer(world)
  local O, quarter = { 0, 0 }, math.pi / 2
  local P = off(O, beta, rr)
  local E = off(P, beta + theta, -d)
  local H, G = off(A, delta, zt), off(A, epsilon - quarter, u)
  local centres = {
    off(O, beta, ra), off(P, beta + theta, -da), off(B, gamma - quarter, sa, sb), off(H, phi + delta - quarter, e - ea),
    off(A, delta, ta, tb), off(G, omega + epsilon, zf - fa), off(A, epsilon - quarter, ua, -ub),
  }
  local k = {}
  for i, c in ipairs(centres) do
    local side = math.sqrt(6 * moment[i] / mass[i])     -- a square prism of this moment about z
    k[i] = world:box { size = { side, side, 0.01 }, mass = mass[i], at = { c[1], c[2], 0 }, collides = false }
  end
  local s = { crank = k[1], hinges = {} }
  local function hinge(a, b, p)
    s.hinges[#s.hinges + 1] = world:hinge { a = k[a], b = k[b], at = { p[1], p[2], 0 }, axis = { 0, 0, 1 } }
  end
  hinge(1, nil, O); hinge(1, 2, P); hinge(2, 3, E); hinge(3, 4, E); hinge(3, 6, E)
  hinge(3, nil, B); hinge(4, 5, H); hinge(5, nil, A); hinge(6, 7, G); hinge(7, nil, A)
  local D = off(B, gamma - quarter, sc, sd)
  world:spring { a = k[3], at_a = { D[1], D[2], 0 }, at_b = { C[1], C[2], 0 }, stiffness = stiffness, length = length }
  k[1]:twist { torque = { 0, 0, torque }, lasts = 1 }
  s.errors, s.gap, s.turned, s.last = {}, 0, beta, beta
  return s
end

-- The point P of the crank, which the literature on these benchmarks calls F
local crank_points = {
  [10] = { -0.0038905523886494319, 0.0058192441185410154 }, [30] = { -0.0069630394270468515, -0.00071838843071910191 },
  [50] = { -0.0052085047222967200, 0.0046766952603107216 },
}

local andrews = {
  id = "A19a", title = "Andrews' squeezing mechanism, 0.05 s", metric = "m", scale = 0.007, seconds = 0.05,
  world = { gravity = { 0, 0, 0 }, step = 0.001 },
  build = squeezer,
  frame = function(s, _, k)
    local q = s.crank.rotation
    local now = 2 * math.atan(q.z, q.w) + beta
    s.turned = s.turned + (now - s.last + math.pi) % (2 * math.pi) - math.pi
    s.last = now
    for _, hinge in ipairs(s.hinges) do s.gap = math.max(s.gap, hinge.error) end
    if crank_points[k] then
      local p = off({ 0, 0 }, s.turned, rr)
      s.errors[#s.errors + 1] = math.sqrt((p[1] - crank_points[k][1]) ^ 2 + (p[2] - crank_points[k][2]) ^ 2)
    end
    if k == 30 then s.beta, s.rate = s.turned - 15.810771195153707, s.crank.spin.z - 1139.9203022591061 end
  end,
  finish = function(s)
    return { error = math.max(table.unpack(s.errors)), at_10 = s.errors[1], at_30 = s.errors[2], at_50 = s.errors[3], beta = s.beta,
             rate = s.rate, gap = s.gap }
  end,
}

-- ---- (b) N coupled parallelograms: N + 1 upright cranks and N level couplers of 1 m and 1 kg; it starts with 1 rad/s ----

local thin = 1e-4                               -- thickness in the plane of motion: the least a body may have

local function bars_motion(n, section, frames, dt)
  local inertia = (n + 1) * ((1 + section ^ 2) / 12 + 1 / 4) + n
  local factor = g * ((n + 1) / 2 + n) / inertia
  return exact.trajectory(function(_, y) return { y[2], factor * math.sin(y[1]) } end, { 0, 1 }, dt, frames)
end

-- In a straight position a second branch begins, on which cranks turn against each other. A place rounded by 1e-16 leaves it open by the
-- root of that, 1e-8 rad.
local straight = "in straight positions, five in 10 s, a second branch opens by the root of rounding, 1e-8 rad, and the way on is found " ..
  "to no better: the error at 1e-10 is 2.5e-13 m before the first, 1.6e-12 m after it and 3.3e-11 m in the end, no less " ..
  "than at 1e-9."
local straight_many = "as A19b, and where a frame ends in such a position, 8.58 s, the next begins off the joints: at 1e-9 the error is " ..
  "8.3e-12 m before that, 1.6e-10 m after it, and 3.6e-10 m in the end. At tolerances of the plan \"play\" it is not " ..
  "traced, for its cost."

local function bars(letter, n, x10, z10, limit)
  local want = exact.once(function(frames, dt) return bars_motion(n, thin, frames, dt) end)
  return {
    id = "A19" .. letter, title = ("%d-four-bar, 10 s"):format(n), metric = "m", scale = 1, seconds = 10, slow = n > 10,
    limits = { floor = limit, bound = limit },
    conserves = { energy = true },
    check = function(dt)                        -- of bars without thickness
      local frames = math.floor(10 / dt + 0.5)
      local a = bars_motion(n, 0, frames, dt)[frames][1]
      return math.max(math.abs(math.sin(a) - x10), math.abs(math.cos(a) - z10))
    end,
    build = function(world)
      local s = { worst = 0, gap = 0, hinges = {}, want = want(600, world.frame) }
      local function hinge(a, b, x, z)
        s.hinges[#s.hinges + 1] = world:hinge { a = a, b = b, at = { x, 0, z }, axis = { 0, 1, 0 } }
      end
      local before, coupler
      for i = 0, n do
        local crank = world:box { size = { thin, 0.1, 1 }, mass = 1, at = { i, 0, 0.5 }, velocity = { 0.5, 0, 0 }, spin = { 0, 1, 0 },
                                  collides = false }
        hinge(crank, nil, i, 0)
        if before then
          coupler = world:box { size = { 1, 0.1, thin }, mass = 1, at = { i - 0.5, 0, 1 }, velocity = { 1, 0, 0 }, collides = false }
          hinge(coupler, before, i - 1, 1)
          hinge(coupler, crank, i, 1)
        end
        s.first = s.first or crank
        before = crank
      end
      return s
    end,
    frame = function(s, _, k)
      local a = s.want[k][1]
      local tip = s.first.position + s.first.rotation:rotate { 0, 0, 0.5 }
      s.worst = math.max(s.worst, #(tip - { math.sin(a), 0, math.cos(a) }))
      for _, hinge in ipairs(s.hinges) do s.gap = math.max(s.gap, hinge.error) end
    end,
    finish = function(s) return { error = s.worst, gap = s.gap } end,
  }
end

return {
  andrews, bars("b", 2, 0.32845811154081538, 0.94451853817860096, straight),
  bars("c", 40, 0.18051222668672839, 0.98357274058231157, straight_many),
}
