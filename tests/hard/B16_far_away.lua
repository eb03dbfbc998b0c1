-- B16 a tower of five and a slowly rolling ball, 10, 100 and 1000 km from the origin: as at the origin.
local hard = require "hard"

local function build(place)
  local s = { tower = {} }
  place:floor { friction = 0.6 }
  for i = 1, 5 do s.tower[i] = place:box { size = 1, mass = 1, friction = 0.6, at = { 0, i - 0.5, 0 } } end
  s.ball = place:ball { radius = 0.5, friction = 0.6, at = { 3, 0.5, 0 }, velocity = { 0.1, 0, 0 }, spin = { 0, 0, -0.2 } }
  return s
end

local function far(letter, distance)
  return {
    id = "B16" .. letter, title = ("%g km from the origin"):format(distance / 1000), seconds = 10, fixed_place = true,
    fast = letter == "c" and 2 or nil,
    build = function(place)
      local there, here = hard.place(place.world, { distance, 0, distance }), hard.open({}, place.dt)
      local s = build(there)
      s.there, s.here, s.others, s.off, s.late = there, build(hard.place(here)), { { world = here } }, 0, 0
      return s
    end,
    act = function(s) s.others[1].world:step() end,
    frame = function(s)
      for i, b in ipairs(s.tower) do s.off = math.max(s.off, #(s.there:where(b) - s.here.tower[i].position)) end
      s.off = math.max(s.off, #(s.there:where(s.ball) - s.here.ball.position))
    end,
    finish = function(s, t)
      return { hard.most("off the run at the origin, m", s.off, 1e-6),
               hard.most("off 0.1 m/s, m", math.abs(s.there:where(s.ball).x - 3 - 0.1 * t), 1e-6) }
    end,
  }
end

return { far("a", 1e4), far("b", 1e5), far("c", 1e6) }
