-- B22 sixteen ragdolls of 19 bones with limits at their joints fall into a pit. Joints rub a little: on hinges without friction a limb
-- that is left dangling swings for ever, in exact mechanics too, and whether one is left is chance.
local hard = require "hard"

-- name, length, thickness, mass, parent, where on the parent (-1 lower to 1 upper end), side, direction of growth, limits in degrees
local bones = {
  { "pelvis", 0.16, 0.2, 10 }, { "belly", 0.14, 0.18, 8, "pelvis", 1, 0, 1 }, { "waist", 0.14, 0.18, 8, "belly", 1, 0, 1 },
  { "chest", 0.2, 0.22, 12, "waist", 1, 0, 1 }, { "neck", 0.08, 0.08, 1, "chest", 1, 0, 1 }, { "head", 0.22, 0.16, 4, "neck", 1, 0, 1 },
  { "hat", 0.1, 0.1, 0.5, "head", 1, 0, 1 },
}
for _, side in ipairs { -1, 1 } do
  local mark = side < 0 and "l" or "r"
  local function add(name, length, thickness, mass, parent, where, out)
    bones[#bones + 1] = { mark .. name, length, thickness, mass, parent, where, side * out, -1 }
  end
  add("upper arm", 0.28, 0.08, 2, "chest", 1, 0.17)
  add("forearm", 0.25, 0.07, 1.5, mark .. "upper arm", -1, 0)
  add("hand", 0.16, 0.06, 0.5, mark .. "forearm", -1, 0)
  add("thigh", 0.42, 0.13, 7, "pelvis", -1, 0.09)
  add("shin", 0.4, 0.1, 4, mark .. "thigh", -1, 0)
  add("foot", 0.14, 0.08, 1, mark .. "shin", -1, 0)
end
local limit, rub = math.rad(40), 0.3         -- rub: N m; a thigh's weight turns its hinge with 14

local function ragdoll(place, s, group, x, y, z)
  local made = {}
  for _, bone in ipairs(bones) do
    local name, length, thickness, mass, parent, where, out, grows = table.unpack(bone)
    local joint_y = parent and made[parent].y + where * made[parent].length / 2 or y
    local bx = parent and made[parent].x + (out or 0) or x
    local by = parent and joint_y + grows * length / 2 or y
    local body = place:box { name = name, size = { thickness, length, thickness }, mass = mass, friction = 0.5, group = -group,
                             at = { bx, by, z } }
    made[name] = { body = body, x = bx, y = by, length = length }
    s.bones[#s.bones + 1] = body
    if parent then
      s.joints[#s.joints + 1] = place:hinge { a = body, b = made[parent].body, at = { bx, joint_y, z }, limits = { -limit, limit },
                                              friction = rub, axis = #s.joints % 3 == 0 and { 0, 0, 1 } or { 1, 0, 0 } }
    end
  end
end

return {
  id = "B22", title = "16 ragdolls in a pit", seconds = 20, slow = true, chaotic = true,
  build = function(place)
    local s = { bones = {}, joints = {}, gap = 0, over = 0 }
    place:floor { friction = 0.5 }
    for i, wall in ipairs { { 1, 0 }, { -1, 0 }, { 0, 1 }, { 0, -1 } } do
      place:box { name = "wall " .. i, fixed = true, friction = 0.5, size = { wall[1] ~= 0 and 1 or 6, 3, wall[1] ~= 0 and 6 or 1 },
                  at = { 2.5 * wall[1], 1.5, 2.5 * wall[2] } }
    end
    for i = 0, 15 do ragdoll(place, s, i + 1, (i % 2) * 1.6 - 0.8 + 0.03 * i, 1.3 + 2.2 * (i // 4), (i // 2 % 2) * 1.4 - 0.7) end
    return s
  end,
  frame = function(s)
    for _, j in ipairs(s.joints) do s.gap, s.over = math.max(s.gap, j.error), math.max(s.over, math.abs(j.angle) - limit) end
  end,
  finish = function(s)
    local speed = 0
    for _, b in ipairs(s.bones) do speed = math.max(speed, b.speed) end
    return { hard.most("speed at the end, m/s", speed, 0.05), hard.most("worst gap, m", s.gap, 5e-3),
             hard.most("over a limit, degrees", math.deg(s.over), 2) }
  end,
}
