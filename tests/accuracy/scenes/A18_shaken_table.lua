-- A18 a block on a table that moves by 0.1 (1 - cos 10 t), mu 0.3: it slips and sticks in turn. The table hangs on a crank that turns at
-- 10 rad/s (a Scotch yoke), so its motion is the cosine itself. A18p: a kinematic table that goes from frame to frame at constant speed.
local exact = require "exact"

local mu, g, turns, way = 0.3, exact.g, 10, 0.1

local function table_at(t) return way * (1 - math.cos(turns * t)) end

-- The block on the cosine, phase by phase: it slips until its speed is the table's, and sticks until the table is too quick for it.
-- list[k] = { x, v } at k dt.
local function root(f, a, b)
  local fa = f(a)
  for _ = 1, 200 do
    local mid = (a + b) / 2
    if mid == a or mid == b then break end
    if (f(mid) > 0) == (fa > 0) then a = mid else b = mid end
  end
  return b
end

local function table_speed(t) return way * turns * math.sin(turns * t) end
local function table_pull(t) return way * turns ^ 2 * math.cos(turns * t) end

local function slip_phase(t0, v0, sign)         -- the end of a slip: the speeds meet again
  local function lead(t) return sign * (table_speed(t) - v0 - sign * mu * g * (t - t0)) end
  local t = t0 + 1e-3
  while lead(t) > 0 do t = t + 1e-3 end
  return root(lead, t - 1e-3, t)
end

local cosine = exact.once(function(frames, dt)
  local list, k = { [0] = { 0, 0 } }, 0
  local t, x, v = 0, 0, 0
  local function fill(until_, at)
    while k < frames and (k + 1) * dt <= until_ + 1e-12 do
      k = k + 1
      list[k] = at(k * dt)
    end
  end
  while k < frames do
    local sign = table_pull(t) > 0 and 1 or -1
    if math.abs(table_pull(t)) > mu * g * (1 - 1e-12) then
      local t0, x0, v0 = t, x, v
      local function at(s) return { x0 + v0 * (s - t0) + sign * mu * g * (s - t0) ^ 2 / 2, v0 + sign * mu * g * (s - t0) } end
      t = slip_phase(t0, v0, sign)
      fill(t, at)
      x, v = table.unpack(at(t))
    else
      local x0, from = x, table_at(t)
      local function at(s) return { x0 + table_at(s) - from, table_speed(s) } end
      local function spare(s) return mu * g - math.abs(table_pull(s)) end
      local s = t + 1e-3
      while spare(s) > 0 do s = s + 1e-3 end
      t = root(spare, s - 1e-3, s)
      fill(t, at)
      x, v = table.unpack(at(t))
    end
  end
  return list
end)

-- The block on the polygon: it is pulled to the table's speed at mu g, and sticks when it has it.
local polygon = exact.once(function(frames, dt)
  local x, v, list = 0, 0, { [0] = 0 }
  for k = 1, frames do
    local target = (table_at(k * dt) - table_at((k - 1) * dt)) / dt
    local a = (target > v and 1 or -1) * mu * g
    local slips = math.min(dt, math.abs(target - v) / (mu * g))
    x = x + v * slips + a * slips * slips / 2 + target * (dt - slips)
    v = slips < dt and target or v + a * slips
    list[k] = x
  end
  return list
end)

return {
  {
    id = "A18", title = "block on a shaken table, 2 s", metric = "m", scale = 0.1, seconds = 2,
    check = function(dt)
      local list = cosine(math.floor(2 / dt + 0.5), dt)
      local last = list[math.floor(2 / dt + 0.5)]
      return math.max(math.abs(last[1] - 0.15850135648078918), math.abs(last[2] - 0.022526639666695015))
    end,
    build = function(world, digbox)
      local crank = world:cylinder { kinematic = true, radius = 0.05, height = 0.02, at = { 0, 0, -1 }, collides = false,
                                     rotation = digbox.quat { from = { 0, 1, 0 }, to = { 0, 1, 0 } } }
      crank:drive { spin = { 0, turns, 0 } }
      -- The pin stands at -way on x; turning about y takes it to -way cos, +way sin on x and z.
      local pin = world:ball { radius = 0.01, mass = 1, at = { -way, 0, -1 }, collides = false }
      local top = world:box { size = { 4, 2, 0.2 }, mass = 10, at = { 0, 0, -0.1 }, friction = mu }
      world:hinge { a = pin, b = crank, at = { -way, 0, -1 }, axis = { 0, 1, 0 } }
      world:slider { a = pin, b = top, at = { -way, 0, -1 }, axis = { 0, 0, 1 } }
      world:slider { a = top, at = { 0, 0, -0.1 }, axis = { 1, 0, 0 } }
      return { top = top, table = 0, worst = 0, want = cosine(math.floor(2 / world.frame + 0.5), world.frame),
               block = world:box { size = 0.2, mass = 1, at = { 0, 0, 0.1 }, friction = mu } }
    end,
    frame = function(s, t, k)
      s.table = math.max(s.table, math.abs(s.top.position.x - table_at(t)))
      s.worst = math.max(s.worst, #(s.block.position - { s.want[k][1], 0, 0.1 }))
      s.speed = math.abs(s.block.velocity.x - s.want[k][2])
    end,
    finish = function(s) return { error = s.worst, speed = s.speed, table = s.table } end,
  },
  {
    id = "A18p", title = "block on a table shaken along a polygon, 2 s", metric = "m", scale = 0.1, seconds = 2,
    build = function(world)
      local s = { worst = 0, want = polygon(math.floor(2 / world.frame + 0.5), world.frame), dt = world.frame }
      s.top = world:box { kinematic = true, size = { 4, 2, 0.2 }, at = { 0, 0, -0.1 }, friction = mu }
      s.block = world:box { size = 0.2, mass = 1, at = { 0, 0, 0.1 }, friction = mu }
      return s
    end,
    act = function(s, k)
      s.top:drive { velocity = { (table_at((k + 1) * s.dt) - table_at(k * s.dt)) / s.dt, 0, 0 } }
    end,
    frame = function(s, _, k) s.worst = math.max(s.worst, #(s.block.position - { s.want[k], 0, 0.1 })) end,
    finish = function(s) return { error = s.worst } end,
  },
}
