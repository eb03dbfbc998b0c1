-- tests/hard/random_parts.lua - random worlds put together of parts (a cart, a laid table, ...), from a seed: as data, case and script.
--
-- random_machines.lua and random_rooms.lua list the parts; here is what they share.
local hard = require "hard"
local random = require "random_world"

local random_parts = {}

-- ---- a world ----

-- Each part gets its dice, the world, where it may stand, and the list of what is done later: { every = s, act = f(k) }
local function build(kind, w, world)
  local p, later = random.dice(w.seed), {}
  local used = { kind.ground(p, world) }
  for k = 1, p.int(kind.fewest, kind.most) do
    local name, dice = p.of(kind.names), random.dice(w.seed * 8 + k)         -- its own, so that what is left stays what it was
    if not w.without[k] then
      used[#used + 1] = name
      local x, z = kind.where(k)
      kind.parts[name](dice, world, x, z, later)
    end
  end
  for _, l in ipairs(later) do l.done = -1 end
  return { later = later, used = used, scale = 1e-9, made = 0, low = 0, deep = 0 }
end

local function act(state, t)
  for _, l in ipairs(state.later) do
    local k = math.floor(t / l.every + 1e-9)
    if k > l.done then
      l.done = k
      l.act(k)
    end
  end
end

-- ---- what is watched ----

-- Energy made in this frame: what the books call numerical, and losses taken back
local function look_at_books(state, potential)
  local e = state.world.energy
  state.scale = math.max(state.scale, e.kinetic, potential * math.abs(e.potential), e.elastic)
  if state.books then
    state.made = math.max(state.made, e.numerical - state.books.numerical, state.books.lost - e.lost)
  end
  state.books = e
end

local function frame(kind, state)
  look_at_books(state, kind.potential)
  if kind.deep and state.world.time > 1 then state.deep = math.max(state.deep, state.world:stats().penetration) end
  for _, b in ipairs(state.world:bodies()) do
    local p = b.position
    if b.kind == "dynamic" then state.low = math.min(state.low, p.y + kind.depth, kind.half - math.abs(p.x), kind.half - math.abs(p.z)) end
  end
end

-- ---- as the soak wants them ----

-- kind: name, parts, ground(p, world) -> its name or nil, fewest, most (parts), where(k) -> x, z of part k, and what is asked of a world:
--   half, depth   m       its walls stand so far from the middle, and its ground lies nowhere deeper
--   made          1       energy made in a frame over all that moved, of which potential counts so much as well: potential
--   deep          m       overlaps after the first second; nil: not asked
function random_parts.kind(kind)
  kind.names = {}
  for name in pairs(kind.parts) do kind.names[#kind.names + 1] = name end
  table.sort(kind.names)

  -- One world as data: its seed, and which of its parts there are (all, until it is shrunk)
  function kind.world(seed) return { seed = seed, without = {} } end

  function kind.case(w, seconds)
    local case = { id = "seed " .. w.seed, title = kind.name, seconds = seconds, chaotic = true, passive = false, top_speed = 100 }
    function case.build(place)
      local state = build(kind, w, place.world)
      case.title = table.concat(state.used, " ")
      return state
    end
    case.act, case.frame = act, function(state) frame(kind, state) end
    function case.finish(state)
      local list = { hard.most("out of the room, m", -state.low, 0.1),
                     hard.most("energy made in a frame / energy", state.made / state.scale, kind.made) }
      if kind.deep then list[#list + 1] = hard.most("overlap after 1 s, m", state.deep, kind.deep) end
      return list
    end
    return case
  end

  -- The fewest parts that still fail in the same way; fails(world) says so
  function kind.shrink(w, fails)
    for k = 1, kind.most do
      local less = { seed = w.seed, without = { [k] = true } }
      for gone in pairs(w.without) do less.without[gone] = true end
      if fails(less) then w = less end
    end
    return w
  end

  function kind.script(w, _, why)
    local gone = {}
    for k in pairs(w.without) do gone[#gone + 1] = k end
    return ("-- %s, seed %d without its parts {%s}: %s"):format(kind.name, w.seed, table.concat(gone, ", "), why)
  end
  return kind
end

return random_parts
