-- A01 projectile with spin: x = v t + g t^2 / 2, and a turn by |spin| t about the spin.
local exact = require "exact"

local v, spin = { 10, 0, 10 }, { 1, 2, 3 }

return {
  id = "A01", title = "projectile with spin", metric = "m", scale = 20, seconds = 2,
  goal = { fast = { 1e-12, 0.06 }, accurate = { 1e-12, 0.06 } },
  conserves = { energy = true },
  build = function(world, digbox)
    local ball = world:ball { radius = 0.1, mass = 1, at = { 0, 0, 0 }, velocity = v, spin = spin }
    return { digbox = digbox, worst = 0, turn = 0, ball = ball }
  end,
  frame = function(s, t)
    local want = s.digbox.vec(v[1] * t, v[2] * t, v[3] * t - exact.g * t * t / 2)
    s.worst = math.max(s.worst, #(s.ball.position - want))
    local turned = s.digbox.quat { axis = spin, angle = math.sqrt(14) * t }
    s.turn = math.max(s.turn, exact.angle_between(s.ball.rotation, turned))
  end,
  finish = function(s) return { error = math.max(s.worst, s.turn), metres = s.worst, radians = s.turn } end,
}
