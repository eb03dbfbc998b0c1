-- S04 a row of 30 dominoes, 0.1 x 0.5 x 1 m, 0.5 m apart; the first is pushed at 1 rad/s about its front edge. When does the last one fall?
-- No closed form: the time is compared with the same scene at a much finer setting.
local count = 30

local passed = "one to nine times a run tracing gives up on a place where many press at once, and a third of the frames or more " ..
  "are swept: the last one passes 0.1 rad after 4.954 to 4.975 s, at any tolerance from 1e-2 to 1e-12, and which of these is " ..
  "nearest to the truth is not known."

return {
  id = "S04", title = "row of 30 dominoes", metric = "s", scale = 1, seconds = 6, slow = true, self_converged = true,
  limits = { order = passed, proportionality = passed, bound = passed },
  build = function(world)
    world:plane { normal = { 0, 0, 1 }, friction = 0.5 }
    local s = { row = {} }
    for i = 1, count do
      s.row[i] = world:box { size = { 0.1, 0.5, 1 }, mass = 30, at = { 0.5 * (i - 1), 0, 0.5 }, friction = 0.5,
                             velocity = i == 1 and { 0.5, 0, 0.05 } or nil, spin = i == 1 and { 0, 1, 0 } or nil }
    end
    return s
  end,
  -- When its tilt passes 0.1 rad, between frames by the cubic through tilt and spin
  frame = function(s, t)
    local last = s.row[count]
    local tilt, spin, dt = 2 * math.atan(last.rotation.y, last.rotation.w), last.spin.y, s.world.frame
    if not s.time and tilt > 0.1 then
      local function cubic(u)
        local v = 1 - u
        return v * v * ((1 + 2 * u) * s.tilt + u * dt * s.spin) + u * u * ((1 + 2 * v) * tilt - v * dt * spin) - 0.1
      end
      local a, b = 0, 1
      for _ = 1, 60 do
        local mid = (a + b) / 2
        if cubic(mid) > 0 then b = mid else a = mid end
      end
      s.time = t - dt + a * dt
    end
    s.tilt, s.spin = tilt, spin
  end,
  finish = function(s) return { value = s.time or math.huge, arrives = s.time or math.huge } end,
}
