-- B05 bridge: 40 planks of 1 kg on hinges, fixed at both ends; ten boxes of 100 kg fall on it from 1 m.
local hard = require "hard"

return {
  id = "B05", title = "bridge of 40 planks, ten boxes 100:1", seconds = 10, chaotic = true, top_speed = 30,
  build = function(place)
    local s = { joints = {}, planks = {}, gap = 0, late = 0, tilt = 1 }
    for i = 1, 40 do
      s.planks[i] = place:box { name = "plank " .. i, size = { 0.5, 0.1, 1 }, mass = 1, friction = 0.6, group = -1,
                                at = { 0.5 * (i - 0.5), 0, 0 } }
      s.joints[i] = place:hinge { a = s.planks[i], b = s.planks[i - 1], at = { 0.5 * (i - 1), 0, 0 }, axis = { 0, 0, 1 } }
    end
    s.joints[41] = place:hinge { a = s.planks[40], at = { 20, 0, 0 }, axis = { 0, 0, 1 } }
    for i = 1, 10 do
      place:box { name = "box " .. i, size = 0.4, mass = 100, friction = 0.6, at = { 2 * i - 1, 0.05 + 0.2 + 1, 0 } }
    end
    return s
  end,
  frame = function(s, t)
    for _, j in ipairs(s.joints) do s.gap = math.max(s.gap, j.error) end
    if t > 5 then
      for _, j in ipairs(s.joints) do s.late = math.max(s.late, j.error) end
    end
    for _, p in ipairs(s.planks) do s.tilt = math.min(s.tilt, p.rotation:rotate({ 0, 1, 0 }).y) end
  end,
  finish = function(s)
    return { hard.most("gap after 5 s, m", s.late, 2e-3), hard.least("least cosine of a plank's tilt", s.tilt, 0.01),
             hard.most("worst gap, m", s.gap, 0.05) }
  end,
}
