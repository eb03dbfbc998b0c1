-- B07 card house of 3, 2 and 1 leaning pairs; and two planks that lean on each other, just above and just below their friction limit.
--
-- A card that leans by a touches its neighbour along its upper inner edge and the floor along its lower inner edge. A thin one
-- pushes outwards with W tan a / 2: the least friction at the floor. With height h and thickness t it is W (tan a - t / h) / 2, by
-- 4 % less here.
local hard = require "hard"

local h, t, width, lean = 1, 0.02, 0.7, math.rad(25)
local rise = h * math.cos(lean) + t * math.sin(lean)            -- height of a leaning pair
local foot = h * math.sin(lean)                                 -- from the middle to an inner lower edge
local limit = math.tan(lean) / 2

-- A leaning pair about x, its lowest edges at height y; gap: between the upper edges
local function pair(place, digbox, cards, x, y, mu)
  for side = -1, 1, 2 do
    local centre = digbox.vec(foot / 2 + t / 2 * math.cos(lean), rise / 2, 0)
    cards[#cards + 1] = place:box {
      name = "card " .. #cards + 1, size = { t, h, width }, mass = 0.1, friction = mu, at = { x + side * centre.x, y + centre.y, 0 },
      rotation = digbox.quat { axis = { 0, 0, 1 }, angle = side * lean } }
  end
end

local function flat(place, cards, x, y, length)
  cards[#cards + 1] = place:box { name = "card " .. #cards + 1, size = { length, t, width }, mass = 0.1, friction = 0.7,
                                  at = { x, y + t / 2, 0 } }
end

local function remember(place, cards)
  local s = { cards = cards, at = {}, moved = 0 }
  for i, c in ipairs(cards) do s.at[i] = place:where(c) end
  return s
end

local function frame(s)
  for i, c in ipairs(s.cards) do s.moved = math.max(s.moved, #(s.place:where(c) - s.at[i])) end
end

local span = 2 * foot + 2 * t * math.cos(lean) + 0.02           -- between the tops of neighbours

local house = {
  id = "B07a", title = "card house 3-2-1", seconds = 20, frame = frame,
  build = function(place, digbox)
    local cards = {}
    place:floor { friction = 0.7 }
    for level = 0, 2 do
      local y = level * (rise + t)
      for i = 0, 2 - level do pair(place, digbox, cards, (i - (2 - level) / 2) * span, y, 0.7) end
      for i = 0, 1 - level do flat(place, cards, (i - (1 - level) / 2) * span, y + rise, span - 1e-3) end
    end
    return remember(place, cards)
  end,
  finish = function(s) return { hard.most("furthest move, m", s.moved, 5e-3) } end,
}

local function planks(letter, share, stands)
  return {
    id = "B07" .. letter, title = ("leaning planks, %g of the least friction"):format(share), seconds = stands and 10 or 3, frame = frame,
    fast = stands and 2 or nil, chaotic = not stands,
    build = function(place, digbox)
      local mu, cards = share * limit, {}
      place:floor { friction = mu * mu / 2 }                    -- mu with the planks; 2 between them, whose edges must not pass each other
      pair(place, digbox, cards, 0, 0, 2)
      return remember(place, cards)
    end,
    finish = function(s)
      return { stands and hard.most("furthest move, m", s.moved, 5e-3) or hard.least("furthest move, m", s.moved, 0.05) }
    end,
  }
end

return { house, planks("b", 1.05, true), planks("c", 0.95, false) }
