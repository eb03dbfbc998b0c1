-- B30 predictable: scenes that are not chaotic, begun 1e-9 m (or rad) otherwise, end within 1e-6 and have as many events.
local hard = require "hard"

local function slope(place, digbox, angle, mu)
  local turn = digbox.quat { axis = { 0, 0, 1 }, angle = angle }
  place:plane { normal = turn:rotate { 0, 1, 0 }, friction = mu }
  return turn
end

local scenes = {
  { "a ball that bounces out", 6, function(place, _, off)
    place:floor { restitution = 0.5 }
    return place:ball { radius = 0.1, restitution = 0.5, at = { 0, 1 + off, 0 } }
  end },
  { "a box that slides to rest", 3, function(place, _, off)
    place:floor { friction = 0.4 }
    return place:box { size = { 0.4, 0.1, 0.4 }, friction = 0.4, at = { 0, 0.05, 0 }, velocity = { 3 + off, 0, 0 } }
  end },
  { "a ball that rolls down 20 degrees", 2, function(place, digbox, off)
    local turn = slope(place, digbox, math.rad(-20), 0.5)
    return place:ball { radius = 0.1, friction = 0.5, at = turn:rotate { off, 0.1, 0 } }
  end },
  { "a bowling ball", 3, function(place, _, off)
    place:floor { friction = 0.2 }
    return place:ball { radius = 0.1, friction = 0.2, at = { 0, 0.1, 0 }, velocity = { 3 + off, 0, 0 } }
  end },
  { "a rod pendulum", 10, function(place, digbox, off)
    local turn = digbox.quat { axis = { 0, 0, 1 }, angle = off }
    local rod = place:box { size = { 1, 0.1, 0.1 }, at = turn:rotate { 0.5, 0, 0 }, rotation = turn, collides = false }
    place:hinge { a = rod, at = { 0, 0, 0 }, axis = { 0, 0, 1 } }
    return rod
  end },
  { "a block that rocks", 3, function(place, digbox, off)
    place:floor { friction = 2 }
    local a = 0.1 + off
    local turn = digbox.quat { axis = { 0, 0, 1 }, angle = a }
    local corner = turn:rotate { -0.25, -0.5, 0 }
    return place:box { size = { 0.5, 1, 0.5 }, friction = 2, rotation = turn, at = { -corner.x, -corner.y, 0 } }
  end },
  { "three boxes that drop on each other", 3, function(place, _, off)
    place:floor { friction = 0.5 }
    local top
    for i = 1, 3 do top = place:box { size = 1, friction = 0.5, at = { 0, 1.1 * i - 0.5 + off, 0 } } end
    return top
  end },
  { "a ball on a turning table", 2, function(place, _, off)
    local disc = place:cylinder { radius = 2, height = 0.1, kinematic = true, friction = 1, at = { 0, -0.05, 0 }, spin = { 0, 1, 0 } }
    disc:drive { spin = { 0, 1, 0 } }
    return place:ball { radius = 0.1, friction = 1, at = { 0.5 + off, 0.1, 0 } }
  end },
}

local list = {}
for i, scene in ipairs(scenes) do
  local title, seconds, make = table.unpack(scene)
  list[i] = {
    id = "B30" .. string.char(96 + i), title = "1e-9 off: " .. title, seconds = seconds, fast = seconds, fixed_place = true,
    build = function(place, digbox)
      local near = hard.open({}, place.dt)
      return { body = make(place, digbox, 0), twin = make(hard.place(near), digbox, 1e-9), others = { { world = near } }, off = 0 }
    end,
    act = function(s) s.others[1].world:step() end,
    frame = function(s) s.off = math.max(s.off, #(s.body.position - s.twin.position)) end,
    finish = function(s)
      return { hard.most("off the run beside it, m", s.off, 1e-6),
               hard.most("events more or less", math.abs(s.world:stats().events - s.others[1].world:stats().events), 0) }
    end,
  }
end
return list
