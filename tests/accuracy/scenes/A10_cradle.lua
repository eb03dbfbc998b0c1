-- A10 Newton's cradle in free space: five touching spheres, one (A10a) or two (A10b) arrive; as many leave.
-- A10c a sphere of 1 kg on one of 3 kg, dropped together: the upper one leaves with twice the speed.
local exact = require "exact"

local function cradle(letter, arriving)
  return {
    id = "A10" .. letter, title = ("Newton's cradle, %d in"):format(arriving), metric = "m/s", scale = 1, seconds = 2,
    world = { gravity = { 0, 0, 0 } }, conserves = { energy = true, momentum = true },
    goal = { fast = { 1e-9, 0.4 }, accurate = { 1e-9, 0.4 } },
    build = function(world)
      local s = { balls = {} }
      for i = 1, 5 + arriving do
        local comes = i <= arriving
        s.balls[i] = world:ball { radius = 0.5, mass = 1, friction = 0, restitution = 1, velocity = { comes and 1 or 0, 0, 0 },
                                  at = { i - arriving - (comes and 1 or 0.5), 0, 0 } }      -- half a diameter before the row
      end
      return s
    end,
    finish = function(s)
      local worst = 0
      for i, ball in ipairs(s.balls) do
        worst = math.max(worst, #(ball.velocity - { i > 5 and 1 or 0, 0, 0 }))
      end
      return { error = worst }
    end,
  }
end

-- The gap of 1e-6 m between the two makes the collision a little late: both are slower by d = g gap / (2 v).
local gap, h, g = 1e-6, 1, exact.g
local v = math.sqrt(2 * g * h)
local late = gap / (2 * v)
local upper_speed = 2 * v - g * late
local hit_at = math.sqrt(2 * h / g) + late
local upper_from = 1.5 + gap - (v * late + g * late * late / 2)         -- height of the upper centre when hit

return {
  cradle("a", 1), cradle("b", 2),
  {
    id = "A10c", title = "1 kg on 3 kg dropped together", metric = "m", scale = 4, seconds = 1.5,
    conserves = { energy = true },
    build = function(world)
      world:plane { normal = { 0, 0, 1 }, friction = 0, restitution = 1 }
      world:ball { radius = 0.5, mass = 3, at = { 0, 0, 0.5 + h }, friction = 0, restitution = 1 }
      return { worst = 0, upper = world:ball { radius = 0.5, mass = 1, at = { 0, 0, 1.5 + h + gap }, friction = 0, restitution = 1 } }
    end,
    frame = function(s, t)
      local since = t - hit_at
      local want = since < 0 and 1.5 + h + gap - g * t * t / 2 or upper_from + upper_speed * since - g * since * since / 2
      s.worst = math.max(s.worst, math.abs(s.upper.position.z - want))
    end,
    finish = function(s) return { error = s.worst } end,
  },
}
