-- tests/accuracy/exact.lua - reference solutions: a high-order integrator for smooth problems, and closed forms that scenes share.
local exact = {}

exact.g = 9.81

-- One step of length h of y' = f(t, y): Gragg's midpoint rule with 2, 4, ... 16 parts, extrapolated (Hairer, Norsett, Wanner,
-- Solving Ordinary Differential Equations I, II.9). It works with increments, so that rounding is relative to the change of y.
local columns = 8

local function extrapolated_step(f, t, y, h)
  local n, table_ = #y, {}
  local f0 = f(t, y)
  for j = 1, columns do
    local parts = 2 * j
    local s = h / parts
    local before, now, at = {}, {}, {}
    for i = 1, n do
      before[i], now[i] = 0, s * f0[i]
    end
    for k = 1, parts - 1 do
      for i = 1, n do at[i] = y[i] + now[i] end
      local d = f(t + k * s, at)
      for i = 1, n do
        local ahead = before[i] + 2 * s * d[i]
        before[i], now[i] = now[i], ahead
      end
    end
    local row = { now }
    for k = 1, j - 1 do
      local ratio = (j / (j - k)) ^ 2 - 1
      local better, worse = row[k], table_[k]
      local mixed = {}
      for i = 1, n do mixed[i] = better[i] + (better[i] - worse[i]) / ratio end
      row[k + 1] = mixed
    end
    table_ = row
  end
  return table_[columns]
end

-- States of y' = f(t, y) at 0, dt, 2 dt, ... n dt, with `parts` steps for each; list[0] is y0. Sums are compensated (Kahan).
function exact.trajectory(f, y0, dt, n, parts)
  parts = parts or 1
  local y, carry, list = { table.unpack(y0) }, {}, { [0] = y0 }
  for i = 1, #y0 do carry[i] = 0 end
  for k = 1, n do
    for p = 1, parts do
      local change = extrapolated_step(f, (k - 1) * dt + (p - 1) * dt / parts, y, dt / parts)
      for i = 1, #y do
        local add = change[i] - carry[i]
        local sum = y[i] + add
        carry[i] = (sum - y[i]) - add
        y[i] = sum
      end
    end
    list[k] = { table.unpack(y) }
  end
  return list
end

-- Computes a reference once, however many runs ask for it
function exact.once(make)
  local value
  return function(...)
    if value == nil then value = make(...) end
    return value
  end
end

-- Derivative of {q (x, y, z, w), L, ...}: a rigid body turning freely about its centre or a fixed point. inertia: principal moments about
-- that point in body axes; torque(q) in body axes or nil. State: q, body angular velocity.
function exact.rotor(inertia, torque)
  local a, b, c = table.unpack(inertia)
  return function(_, y)
    local x, yy, z, w = y[1], y[2], y[3], y[4]
    local p, q, r = y[5], y[6], y[7]
    local tx, ty, tz = 0, 0, 0
    if torque then tx, ty, tz = torque(x, yy, z, w) end
    return {
      0.5 * (w * p + yy * r - z * q), 0.5 * (w * q + z * p - x * r), 0.5 * (w * r + x * q - yy * p), 0.5 * (-x * p - yy * q - z * r),
      ((b - c) * q * r + tx) / a, ((c - a) * r * p + ty) / b, ((a - b) * p * q + tz) / c,
    }
  end
end

-- Height above the floor of a ball that drops from h at rest, as a function of time; 0 from the end of the series on
function exact.bounce(t, h, e, g)
  local first = math.sqrt(2 * h / g)
  if t <= first then return h - g * t * t / 2 end
  if e < 1 and t >= first * (1 + e) / (1 - e) then return 0 end
  local start, speed = first, e * math.sqrt(2 * g * h)
  while t > start + 2 * speed / g do
    start, speed = start + 2 * speed / g, speed * e
  end
  local s = t - start
  return speed * s - g * s * s / 2
end

-- Angle between two rotations given as digbox quaternions or {x, y, z, w}, accurate near 0
function exact.angle_between(a, b)
  local ax, ay, az, aw = a.x or a[1], a.y or a[2], a.z or a[3], a.w or a[4]
  local bx, by, bz, bw = b.x or b[1], b.y or b[2], b.z or b[3], b.w or b[4]
  local x, y = aw * bx - ax * bw - ay * bz + az * by, aw * by + ax * bz - ay * bw - az * bx
  local z, w = aw * bz - ax * by + ay * bx - az * bw, aw * bw + ax * bx + ay * by + az * bz
  return 2 * math.atan(math.sqrt(x * x + y * y + z * z), math.abs(w))
end

-- Turn of a body about the axis y (world), when that is all it does: 0 at identity, counted in (-pi, pi]
function exact.turn_about_y(q)
  return 2 * math.atan(q.y, q.w)
end

return exact
