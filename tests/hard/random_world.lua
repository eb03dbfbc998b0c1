-- tests/hard/random_world.lua - a random world from a seed (shapes, joints, mass ratios, speeds, materials) as data, case and script.
local hard = require "hard"

local random = {}

-- Numbers in [0, 1) from a generator of its own (SplitMix64; Steele, Lea, Flood 2014), so that a seed means the same everywhere
local function generator(seed)
  local state = seed
  return function()
    state = state + 0x9e3779b97f4a7c15
    local z = (state ~ (state >> 30)) * 0xbf58476d1ce4e5b9
    z = (z ~ (z >> 27)) * 0x94d049bb133111eb
    return ((z ~ (z >> 31)) >> 11) * 2.0 ^ -53
  end
end

local function round(x) return tonumber(("%.4g"):format(x)) end

local function choices(uniform)
  local pick = {}
  function pick.of(list) return list[1 + math.floor(uniform() * #list)] end
  function pick.int(a, b) return a + math.floor((b - a + 1) * uniform()) end
  function pick.between(a, b) return round(a + (b - a) * uniform()) end
  function pick.decades(a, b) return round(10 ^ (a + (b - a) * uniform())) end
  function pick.vector(size) return { pick.between(-size, size), pick.between(-size, size), pick.between(-size, size) } end
  return pick
end

function random.dice(seed) return choices(generator(seed)) end

local makers = {
  ball = function(p) return { radius = p.decades(-1.3, -0.35) } end,
  box = function(p) return { size = { p.decades(-1.3, -0.25), p.decades(-1.3, -0.25), p.decades(-1.3, -0.25) } } end,
  capsule = function(p) return { radius = p.decades(-1.3, -0.9), length = p.decades(-1, -0.2) } end,
  cylinder = function(p) return { radius = p.decades(-1.3, -0.5), height = p.decades(-1.3, -0.25) } end,
}
local shapes = { "ball", "ball", "box", "box", "capsule", "cylinder" }
local joints = { "hinge", "ball_joint", "weld", "distance", "spring", "slider" }

-- One world as data: { gravity, walls, bodies = { { shape, fields } }, joints = { { type, i, j, fields } } }; bodies stand apart
function random.world(seed)
  local p = random.dice(seed)
  local w = { seed = seed, bodies = {}, joints = {}, gravity = p.of { 9.81, 9.81, 9.81, 0 }, mu = p.of { 0, 0.3, 0.6, 1 } }
  w.free = w.gravity == 0 and p.of { true, false }          -- nothing but bodies: momentum must stay
  local heavy, count, e = p.of { 0, 1, 3 }, math.floor(p.between(2, 13)), p.of { 0, 0, 0.5, 0.9, 1 }
  for i = 1, count do
    local shape = p.of(shapes)
    local fields = makers[shape](p)
    fields.mass, fields.friction, fields.restitution = p.decades(-heavy / 2, heavy / 2), p.of { 0, w.mu, w.mu }, p.of { 0, e }
    fields.at = { 1.3 * ((i - 1) % 3), 1 + 1.3 * ((i - 1) // 3), p.between(-0.1, 0.1) }
    fields.velocity, fields.spin = p.vector(p.of { 0, 1, 10 }), p.vector(p.of { 0, 3, 30 })
    w.bodies[i] = { shape = shape, fields = fields }
  end
  local chance = p.of { 0, 0, 0.4, 0.8 }
  for i = 2, count do
    if p.between(0, 1) < chance then
      local a, b = w.bodies[i - 1].fields.at, w.bodies[i].fields.at
      local joint = { type = p.of(joints), a = i - 1, b = i, fields = { at = { (a[1] + b[1]) / 2, (a[2] + b[2]) / 2, (a[3] + b[3]) / 2 } } }
      if joint.type == "hinge" or joint.type == "slider" then joint.fields.axis = p.of { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } end
      if joint.type == "distance" then joint.fields.at = nil end
      if joint.type == "spring" then joint.fields = { stiffness = p.decades(1, 5), damping = p.of { 0, 1 } } end
      w.joints[#w.joints + 1] = joint
    end
  end
  return w
end

local walls = { { 1, 0 }, { -1, 0 }, { 0, 1 }, { 0, -1 } }

function random.build(w, place)
  local made = {}
  if not w.free then
    place:floor { friction = w.mu }
    for _, n in ipairs(walls) do place:plane { normal = { n[1], 0, n[2] }, offset = -6, friction = w.mu } end
  end
  for i, body in ipairs(w.bodies) do made[i] = place[body.shape](place, body.fields) end
  for _, joint in ipairs(w.joints) do
    local fields = { a = made[joint.a], b = made[joint.b] }
    for k, v in pairs(joint.fields) do fields[k] = v end
    place[joint.type](place, fields)
  end
  return { bodies = made }
end

-- What left the room, by how much
local function outside(s, free)
  local off = 0
  for _, b in ipairs(free and {} or s.bodies) do
    local p = s.place:where(b)
    off = math.max(off, -p.y, math.abs(p.x) - 6, math.abs(p.z) - 6)
  end
  return off
end

function random.case(w, seconds)
  return {
    id = "seed " .. w.seed, title = ("%d bodies, %d joints"):format(#w.bodies, #w.joints), seconds = seconds, chaotic = true,
    isolated = w.free, world = { gravity = { 0, -w.gravity, 0 } },
    build = function(place) return random.build(w, place) end,
    finish = function(s) return { hard.most("out of the room, m", outside(s, w.free), 1e-2) } end,
  }
end

-- ---- shrinking: the fewest bodies and joints that still fail in the same way ----

local function without_body(w, gone)
  local less = { joints = {}, bodies = {} }
  for k, v in pairs(w) do less[k] = less[k] or v end
  for i, b in ipairs(w.bodies) do
    if i ~= gone then less.bodies[#less.bodies + 1] = b end
  end
  for _, j in ipairs(w.joints) do
    if j.a ~= gone and j.b ~= gone then
      local function moved(i) return i > gone and i - 1 or i end
      less.joints[#less.joints + 1] = { type = j.type, fields = j.fields, a = moved(j.a), b = moved(j.b) }
    end
  end
  return less
end

local function without_joint(w, gone)
  local less = { joints = {} }
  for k, v in pairs(w) do less[k] = less[k] or v end
  for i, j in ipairs(w.joints) do
    if i ~= gone then less.joints[#less.joints + 1] = j end
  end
  return less
end

-- fails(world) says whether a world still fails as the first one did
function random.shrink(w, fails)
  local again = true
  while again do
    again = false
    for i = #w.bodies, 1, -1 do
      local less = #w.bodies > 1 and without_body(w, i)
      if less and fails(less) then w, again = less, true end
    end
    for i = #w.joints, 1, -1 do
      local less = without_joint(w, i)
      if fails(less) then w, again = less, true end
    end
  end
  return w
end

-- ---- as a script ----

local function literal(value)
  if type(value) ~= "table" then
    local text = ("%.15g"):format(value)
    return tonumber(text) == value and text or ("%.17g"):format(value)
  end
  local list = {}
  for i, v in ipairs(value) do list[i] = literal(v) end
  return "{ " .. table.concat(list, ", ") .. " }"
end

local function fields_text(fields, first)
  local list = { first }
  for key, value in pairs(fields) do list[#list + 1] = key .. " = " .. literal(value) end
  return table.concat(list, ", ")
end

function random.script(w, seconds, why)
  local out = {}
  local function add(...) out[#out + 1] = string.format(...) end
  add("-- seed %d, shrunk: %s", w.seed, why)
  add('local digbox = require "digbox"')
  add("local world = digbox.world { gravity = { 0, %s, 0 } }", literal(-w.gravity))
  if not w.free then
    add("world:floor { friction = %s }", literal(w.mu))
    for _, n in ipairs(walls) do add("world:plane { normal = { %d, 0, %d }, offset = -6, friction = %s }", n[1], n[2], literal(w.mu)) end
  end
  for i, body in ipairs(w.bodies) do add("local b%d = world:%s { %s }", i, body.shape, fields_text(body.fields)) end
  for _, joint in ipairs(w.joints) do
    add("world:%s { %s }", joint.type, fields_text(joint.fields, ("a = b%d, b = b%d"):format(joint.a, joint.b)))
  end
  add("world:run(%s)", literal(seconds))
  return table.concat(out, "\n")
end

return random
