-- B04 chains of 50 and 100 links of 0.2 m and 1 kg with 100 or 1000 kg at the end, let go from level.
local hard = require "hard"

local function chain(letter, count, mass)
  local length = 0.2 * count
  local fall = math.sqrt(2 * 9.81 * length)
  return {
    id = "B04" .. letter, title = ("chain of %d links, end %d:1"):format(count, mass), seconds = 15, slow = letter ~= "a",
    fast = letter == "a" and 1 or nil, size = length,
    build = function(place)
      local s = { joints = {}, gap = 0, reach = 0, speed = 0, drift = 0 }
      local last
      for i = 1, count do
        local link = place:box { name = "link " .. i, size = { 0.2, 0.04, 0.04 }, mass = 1, collides = false,
                                 at = { 0.2 * (i - 0.5), 0, 0 } }
        s.joints[i] = place:ball_joint { a = link, b = last, at = { 0.2 * (i - 1), 0, 0 } }
        last = link
      end
      s.weight = place:ball { name = "weight", radius = 0.1, mass = mass, at = { length, 0, 0 }, collides = false }
      s.joints[count + 1] = place:ball_joint { a = s.weight, b = last, at = { length, 0, 0 } }
      local e = place.world.energy
      s.start = e.kinetic + e.potential
      s.scale = (mass + count / 2) * 9.81 * length
      return s
    end,
    frame = function(s)
      for _, j in ipairs(s.joints) do s.gap = math.max(s.gap, j.error) end
      s.reach = math.max(s.reach, #s.place:where(s.weight))
      s.speed = math.max(s.speed, s.weight.speed)
      local e = s.world.energy
      s.drift = math.max(s.drift, math.abs(e.kinetic + e.potential - s.start) / s.scale)
    end,
    finish = function(s, t)
      local list = { hard.most("joint gap / link", s.gap / 0.2, 0.01), hard.most("reach / length - 1", s.reach / length - 1, 5e-3),
                     hard.most("energy drift", s.drift, 0.01) }
      if t > 2.5 then
        local ratio = s.speed / fall          -- converged at 1000:1; else at most what all the energy in the weight would give
        list[#list + 1] = mass == 1000 and hard.most("end speed off 1.0068 free fall", math.abs(ratio / 1.0068 - 1), 0.02) or
          hard.most("end speed over all energy's", ratio / math.sqrt(1 + count / 2 / mass) - 1, 1e-3)
      end
      return list
    end,
  }
end

return { chain("a", 50, 100), chain("b", 50, 1000), chain("c", 100, 100), chain("d", 100, 1000) }
