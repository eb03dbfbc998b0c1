-- A06 limits of standing: each scene just on this side of the limit, where all must stay, and just on the other, where it must go.
-- The error is 0 when it does what it must, else 1.

local function judged(stays, moved)
  if stays then return moved < 1e-3 and 0 or 1 end
  return moved > 1e-2 and 0 or 1
end

local function farthest(s)
  local moved = 0
  for i, body in ipairs(s.bodies) do moved = math.max(moved, #(body.position - s.start[i])) end
  return moved
end

-- make(world, digbox) returns the bodies that stay or go
local function limit(id, title, stays, make)
  return {
    id = id, title = title .. (stays and " stays" or " goes"), metric = "verdict", scale = 1, seconds = 3,
    build = function(world, digbox)
      local s = { bodies = make(world, digbox), start = {} }
      for i, body in ipairs(s.bodies) do s.start[i] = body.position end
      return s
    end,
    finish = function(s)
      local moved = farthest(s)
      return { error = judged(stays, moved), moved = moved }
    end,
  }
end

local l, t = 2, 0.02            -- length and thickness of boards

-- Ladder on a floor of friction mu against a smooth wall: tan(angle) = 1 / (2 mu + t / l); 51.34 degrees for a thin one
local function ladder(id, stays)
  local mu = 0.4
  local angle = math.atan(1 / (2 * mu + t / l)) + math.rad(stays and 0.1 or -0.1)
  return limit(id, "ladder", stays, function(world, digbox)
    world:plane { normal = { 0, 0, 1 }, friction = mu }
    world:plane { normal = { -1, 0, 0 }, offset = 0, friction = 0 }
    local cos, sin = math.cos(angle), math.sin(angle)
    return { world:box { size = { l, 0.5, t }, mass = 1, friction = mu, rotation = digbox.quat { axis = { 0, 1, 0 }, angle = -angle },
                         at = { -l / 2 * cos - t / 2 * sin, 0, l / 2 * sin + t / 2 * cos } } }
  end)
end

-- Half an A-frame: the profile of a board 25 degrees from upright whose foot is at (0, 0) and whose top is cut upright, so that two of them
-- meet face to face. Returns the corners and the centroid.
local function half_frame(a)
  local u, n = { math.sin(a), math.cos(a) }, { -math.cos(a), math.sin(a) }
  local long = l - t * n[1] / u[1]
  local p = { { 0, 0 }, { l * u[1], l * u[2] }, { long * u[1] + t * n[1], long * u[2] + t * n[2] }, { t * n[1], t * n[2] } }
  local area, x = 0, 0
  for i = 1, 4 do
    local c, d = p[i], p[i % 4 + 1]
    local cross = c[1] * d[2] - d[1] * c[2]
    area, x = area + cross / 2, x + cross * (c[1] + d[1]) / 6
  end
  return p, x / area
end

-- Two boards lean on each other. The faces can press at their top edge at most, so the feet need mu = x / h: x of the centroid, h of
-- that edge (tan(a) / 2 = 0.23315 for thin ones).
local function frame(id, stays)
  local profile, x = half_frame(math.rad(25))
  local mu = x / profile[3][2] * (stays and 1.01 or 0.99)
  return limit(id, "A-frame", stays, function(world)
    world:plane { normal = { 0, 0, 1 }, friction = mu }
    local bodies = {}
    for i, sign in ipairs { 1, -1 } do
      local points = {}
      for _, p in ipairs(profile) do
        for _, y in ipairs { -0.25, 0.25 } do points[#points + 1] = { sign * p[1], y, p[2] } end
      end
      bodies[i] = world:hull { points = points, mass = 1, at = { -sign * profile[2][1], 0, 0 }, friction = mu }
    end
    return bodies
  end)
end

-- A block four times as high as wide on a rough slope tips beyond atan(1/4) = 14.036 degrees.
local function block(id, stays)
  local slope = math.atan(1 / 4) + math.rad(stays and -0.05 or 0.05)
  return limit(id, "upright block on a slope", stays, function(world, digbox)
    local n = digbox.vec(math.sin(slope), 0, math.cos(slope))
    world:plane { normal = n, friction = 1 }
    local turn = digbox.quat { axis = { 0, 1, 0 }, angle = slope }
    return { world:box { size = { 0.5, 0.5, 2 }, mass = 1, at = n, rotation = turn, friction = 1 } }
  end)
end

-- Ten bricks, each a little farther out: from the top down 1/2, 1/4, 1/6 ... of a length; together 1.4645 lengths over the ground brick
local function overhang(id, stays)
  local share = stays and 0.99 or 1.01
  return limit(id, "overhang of ten bricks", stays, function(world)
    world:box { fixed = true, size = { 1, 0.5, 0.2 }, at = { 0, 0, -0.1 }, friction = 0.6 }
    local bodies, x = {}, 0
    for i = 1, 10 do
      x = x + share / (2 * (11 - i))
      bodies[i] = world:box { size = { 1, 0.5, 0.2 }, mass = 1, at = { x, 0, 0.2 * i - 0.1 }, friction = 0.6 }
    end
    return bodies
  end)
end

return {
  ladder("A06e", true), ladder("A06f", false), frame("A06g", true), frame("A06h", false), block("A06i", true), block("A06j", false),
  overhang("A06k", true), overhang("A06l", false),
}
