-- A06 a box on a slope whose tangent is 0.95, 0.9999, 1.0001 and 1.05 times the friction: it must stay, or slide with g (sin - mu cos).
local exact = require "exact"

local mu = 0.5

local function variant(letter, ratio, goal)
  local slope = math.atan(ratio * mu)
  local a = ratio > 1 and exact.g * (math.sin(slope) - mu * math.cos(slope)) or 0
  return {
    id = "A06" .. letter, title = ("box on a slope of %g times the friction"):format(ratio), metric = ratio > 1 and "relative" or "m",
    scale = 1, seconds = 5, goal = goal,
    build = function(world, digbox)
      local n = digbox.vec(math.sin(slope), 0, math.cos(slope))
      world:plane { normal = n, friction = mu }
      local turn = digbox.quat { axis = { 0, 1, 0 }, angle = slope }
      return { start = n * 0.25, along = digbox.vec(math.cos(slope), 0, -math.sin(slope)),
               box = world:box { size = { 1, 1, 0.5 }, mass = 1, at = n * 0.25, rotation = turn, friction = mu } }
    end,
    finish = function(s, t)
      local x = a * t * t / 2
      local off = #(s.box.position - s.start - s.along * x)
      return { error = a > 0 and off / x or off, moved = #(s.box.position - s.start) }
    end,
  }
end

return {
  variant("a", 0.95, { fast = { 1e-12, 0.18 }, accurate = { 1e-12, 0.2 } }),
  variant("b", 0.9999, { fast = { 1e-12, 0.18 }, accurate = { 1e-12, 0.2 } }),
  variant("c", 1.0001, { fast = { 1e-8, 0.18 }, accurate = { 1e-11, 0.25 } }),
  variant("d", 1.05, { fast = { 1e-8, 0.18 }, accurate = { 1e-11, 0.25 } }),
}
