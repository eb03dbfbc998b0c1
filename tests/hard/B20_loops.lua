-- B20 more joints than needed: four-bar linkage, Bricard's mechanism, doors on 3 and 8 hinges, a table on 8 legs.
local hard = require "hard"

local function watch_joints(s)
  for _, j in ipairs(s.joints) do
    s.gap, s.force = math.max(s.gap, j.error), math.max(s.force, #j.force)
  end
  local e = s.world.energy
  s.drift = math.max(s.drift, math.abs(e.kinetic + e.potential - s.start))
  s.kinetic = math.max(s.kinetic, e.kinetic)
end

local function begin(place, s)
  local e = place.world.energy
  s.start, s.kinetic, s.gap, s.force, s.drift = e.kinetic + e.potential, e.kinetic, 0, 0, 0
  return s
end

local function judge(s)
  return { hard.most("joint gap, m", s.gap, 1e-6), hard.most("energy drift, relative", s.drift / s.kinetic, 1e-4) }
end

local function bar(place, from, to, spin)
  local size = { 0.04, 0.04, 0.04 }
  for k = 1, 3 do
    local d = math.abs(to[k] - from[k])
    if d > 0.5 then size[k] = d end
  end
  return place:box { size = size, mass = 1, collides = false, spin = spin,
                     at = { (from[1] + to[1]) / 2, (from[2] + to[2]) / 2, (from[3] + to[3]) / 2 } }
end

local four_bar = {
  id = "B20a", title = "four-bar linkage", seconds = 20, fast = 3,
  build = function(place)
    local a = bar(place, { 0, 0, 0 }, { 0, 1, 0 })
    local b = bar(place, { 0, 1, 0 }, { 2, 1, 0 })
    local c = bar(place, { 2, 1, 0 }, { 2, 0, 0 })
    local axis = { 0, 0, 1 }
    local s = { bars = { a, b, c }, out = 0, joints = {
      place:hinge { a = a, at = { 0, 0, 0 }, axis = axis }, place:hinge { a = b, b = a, at = { 0, 1, 0 }, axis = axis },
      place:hinge { a = c, b = b, at = { 2, 1, 0 }, axis = axis }, place:hinge { a = c, at = { 2, 0, 0 }, axis = axis } } }
    a:hit { impulse = { 2, 0, 0 } }
    return begin(place, s)
  end,
  frame = function(s, _, k)
    if k == 1 then begin(s.place, s) end
    watch_joints(s)
    for _, b in ipairs(s.bars) do s.out = math.max(s.out, math.abs(s.place:where(b).z)) end
  end,
  finish = function(s)
    local list = judge(s)
    list[3] = hard.most("out of plane, m", s.out, 1e-9)
    return list
  end,
}

local corners = { { 0, 0, 0 }, { 1, 0, 0 }, { 1, -1, 0 }, { 1, -1, 1 }, { 0, -1, 1 }, { 0, 0, 1 } }
local axes = { { 0, 1, 0 }, { 0, 0, 1 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 1, 0, 0 } }

local bricard = {
  id = "B20b", title = "Bricard's mechanism", seconds = 20, frame = watch_joints, finish = judge,
  build = function(place)
    local s, last = { joints = {} }, nil
    for i = 1, 5 do
      local rod = bar(place, corners[i], corners[i + 1])
      s.joints[i] = place:hinge { a = rod, b = last, at = corners[i], axis = axes[i] }
      last = rod
    end
    s.joints[6] = place:hinge { a = last, at = corners[6], axis = axes[6] }
    return begin(place, s)
  end,
}

local function door(letter, count)
  return {
    id = "B20" .. letter, title = ("door on %d hinges"):format(count), seconds = 20, fast = letter == "c" and 2 or nil,
    frame = watch_joints,
    build = function(place)
      local s = { joints = {} }
      local leaf = place:box { name = "door", size = { 1, 2, 0.04 }, mass = 20, collides = false, at = { 0.5, 1, 0 },
                               spin = { 0, 1, 0 }, velocity = { 0, 0, -0.5 } }
      for i = 1, count do s.joints[i] = place:hinge { a = leaf, at = { 0, 2 * (i - 0.5) / count, 0 }, axis = { 0, 1, 0 } } end
      return begin(place, s)
    end,
    finish = function(s)
      local list = judge(s)
      list[3] = hard.most("force of a hinge / weight", s.force / (20 * 9.81), 10)
      return list
    end,
  }
end

local legs = {
  id = "B20e", title = "table on eight legs", seconds = 10, fast = 2,
  build = function(place)
    local s = { sum = 0, least = math.huge, most = 0 }
    place:floor { friction = 0.6 }
    s.top = place:box { name = "top", size = { 2, 0.1, 1 }, mass = 20, friction = 0.6, at = { 0, 1.05, 0 } }
    for i = 0, 7 do
      place:box { name = "leg " .. i + 1, size = { 0.1, 1, 0.1 }, mass = 1, friction = 0.6,
                  at = { 0.6 * (i % 4) - 0.9, 0.5, i < 4 and -0.4 or 0.4 } }
    end
    return s
  end,
  finish = function(s)
    for _, link in ipairs(s.top:links()) do
      local up = link.effort.y * (link.b == s.top and 1 or -1)
      s.sum, s.least, s.most = s.sum + up, math.min(s.least, up), math.max(s.most, up)
    end
    local weight = 20 * 9.81
    return { hard.most("sum of the legs' forces off the weight, relative", math.abs(s.sum / weight - 1), 1e-6),
             hard.most("greatest force / weight", s.most / weight, 1), hard.least("least force, N", s.least, 0),
             hard.most("speed of the top, m/s", s.top.speed, 1e-3) }
  end,
}

return { four_bar, bricard, door("c", 3), door("d", 8), legs }
