-- A12 Housner's rocking block: each plastic impact of its base multiplies the spin by 1 - 3/2 sin^2(alpha).
local exact = require "exact"

local b, h, g = 0.25, 1, exact.g                        -- half width and half height
local radius, alpha = math.sqrt(b * b + h * h), math.atan(b / h)
local kept = 1 - 1.5 * math.sin(alpha) ^ 2              -- 0.91176470588235294
local start = alpha / 2

-- Peaks: the energy above rest is multiplied by kept^2 at each impact.
local function peak(n)
  local lost = (math.cos(alpha - start) - math.cos(alpha)) * kept ^ (2 * n)
  return alpha - math.acos(math.cos(alpha) + lost)
end

-- Tilt from the energy per mass above that of standing still: what the next peak will be, wherever it is on its way
local function peak_of(body)
  local v, w = body.velocity, body.spin
  local inertia = (4 * b * b + 4 * h * h) / 12
  local e = (v:dot(v) + inertia * w:dot(w)) / 2 + g * (body.position.z - h)
  return alpha - math.acos(math.min(1, math.cos(alpha) + e / (g * radius)))
end

-- Impacts at 0.493803, 1.297470, 1.979391, 2.570721 s; the peaks lie between them.
local looks = { 0.9, 1.65, 2.3 }

return {
  id = "A12", title = "rocking block", metric = "relative", scale = 1, seconds = 2.5,
  goal = { fast = { 1e-5, 0.3 }, accurate = { 1e-9, 1 } },
  build = function(world, digbox)
    world:plane { normal = { 0, 0, 1 }, friction = 2, restitution = 0 }
    local turn = digbox.quat { axis = { 0, 1, 0 }, angle = start }
    -- It stands on the edge x = b, y: the corner stays where it was when the block is tilted.
    local at = turn:rotate { -b, 0, h } + digbox.vec(b, 0, 0)
    return { peaks = {}, block = world:box { size = { 2 * b, 2 * b, 2 * h }, mass = 500, at = at, rotation = turn, friction = 2 } }
  end,
  frame = function(s, t)
    for i, look in ipairs(looks) do
      if not s.peaks[i] and t > look then s.peaks[i] = peak_of(s.block) / peak(i) - 1 end
    end
  end,
  finish = function(s)
    local error = math.max(math.abs(s.peaks[1]), math.abs(s.peaks[2]))
    return { error = error, peak1 = s.peaks[1], peak2 = s.peaks[2], peak3 = s.peaks[3], sideways = math.abs(s.block.position.y) }
  end,
}
