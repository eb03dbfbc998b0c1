-- B23 the same at any frame step: tower of 20, card house, double rod pendulum at seven steps from 1/30 to 1/1000 s.
--
-- The step of a world is fixed, so a step that changes at random cannot be asked for; steps that share no frame times stand for it.
local hard = require "hard"
local tower = require "B02_tower"[1]
local house = require "B07_card_house"[1]

local steps = { 1 / 30, 1 / 47, 1 / 60, 1 / 120, 1 / 211, 1 / 240, 1 / 1000 }       -- all of them have a frame at each whole second

local function sweep(letter, title, seconds, build, value, limit, what)
  return {
    id = "B23" .. letter, title = title .. " at seven frame steps", seconds = seconds, slow = true, fixed_place = true, passive = false,
    build = function(place, digbox)
      local s = { others = {}, least = math.huge, most = -math.huge }
      for i, dt in ipairs(steps) do
        local world = hard.open({}, dt)
        local there = hard.place(world)
        local inner = build(there, digbox)
        inner.place, inner.world = there, world
        s.others[i] = { world = world, state = inner, dt = dt }
      end
      place:floor {}
      place:ball { radius = 0.1, at = { 0, 0.1, 0 } }
      return s
    end,
    frame = function(s, t)
      for _, o in ipairs(s.others) do
        while o.world.steps < math.floor(t / o.dt + 1e-6) do o.world:step() end
      end
    end,
    finish = function(s)
      for _, o in ipairs(s.others) do
        local v = value(o.state)
        s.least, s.most = math.min(s.least, v), math.max(s.most, v)
        if v ~= v then s.most = v end
      end
      return { hard.most(what, s.most - s.least, limit) }
    end,
  }
end

local function pendulum(place)
  local a = place:box { size = { 1, 0.1, 0.1 }, mass = 1, at = { 0.5, 0, 0 }, collides = false }
  local b = place:box { size = { 1, 0.1, 0.1 }, mass = 1, at = { 1.5, 0, 0 }, collides = false }
  place:hinge { a = a, at = { 0, 0, 0 }, axis = { 0, 0, 1 } }
  place:hinge { a = b, b = a, at = { 1, 0, 0 }, axis = { 0, 0, 1 } }
  return { b = b }
end

return {
  sweep("a", "tower of 20", 5, tower.build, function(s) return #(s.top.position - { 0, 19.5, 0 }) end, 0.01, "spread of the top, m"),
  sweep("b", "card house", 5, house.build, function(s)
    local moved = 0
    for i, c in ipairs(s.cards) do moved = math.max(moved, #(c.position - s.at[i])) end
    return moved
  end, 5e-3, "spread of the furthest move, m"),
  sweep("c", "double rod pendulum", 2, pendulum, function(s) return s.b.position.x end, 1e-4, "spread of its end, m"),
}
