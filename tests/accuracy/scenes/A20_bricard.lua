-- A20 Bricard's mechanism: five rods and six hinges, which by count should not move, and do.
local section = 0.1

local corners = { { 0, 0, 0 }, { 1, 0, 0 }, { 1, -1, 0 }, { 1, -1, 1 }, { 0, -1, 1 }, { 0, 0, 1 } }
local axes = { { 0, 1, 0 }, { 0, 0, 1 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 1, 0, 0 } }

-- The fourth corner at 1, 2, 5 and 10 s
local points = {
  [60] = { 0.510501461187219736, -1.64916759939480631, 0.140123114553185828 },
  [120] = { -0.969340344777651603, -1.22124689495631739, 0.754278010779776734 },
  [300] = { 0.999999997738048909, -1.00006725769788292, 0.999932740040318119 },
  [600] = { 0.999999963806349409, -1.00026901269616334, 0.999730951119921307 },
}

return {
  id = "A20", title = "Bricard's mechanism, 10 s", metric = "m", scale = 1, seconds = 10, conserves = { energy = true },
  world = { gravity = { 0, -9.81, 0 } },
  build = function(world, digbox)
    local s = { rods = {}, hinges = {}, worst = 0, gap = 0, errors = {} }
    for i = 1, 5 do
      local from, to = digbox.vec(corners[i]), digbox.vec(corners[i + 1])
      local along = to - from
      local size = { section, section, section }
      for k, x in ipairs { along.x, along.y, along.z } do
        if math.abs(x) > 0.5 then size[k] = 1 end
      end
      s.rods[i] = world:box { size = size, mass = 1, at = (from + to) / 2, collides = false }
      s.hinges[i] = world:hinge { a = s.rods[i], b = s.rods[i - 1], at = from, axis = axes[i] }
    end
    s.hinges[6] = world:hinge { a = s.rods[5], at = corners[6], axis = axes[6] }
    return s
  end,
  frame = function(s, _, k)
    for _, hinge in ipairs(s.hinges) do s.gap = math.max(s.gap, hinge.error) end
    if points[k] then
      local p = s.rods[3].position + s.rods[3].rotation:rotate { 0, 0, 0.5 }
      s.errors[#s.errors + 1] = #(p - points[k])
    end
  end,
  finish = function(s)
    return { error = math.max(table.unpack(s.errors)), at_1 = s.errors[1], at_2 = s.errors[2], at_5 = s.errors[3], gap = s.gap }
  end,
}
