-- A17 what is at rest after settling: forces in a stack (a), a catenary (b), a cantilever of hinged links (c), von Mises' truss (d).
local exact = require "exact"

local g = exact.g

-- ---- (a) ten unit boxes: between box i and box i + 1 there are (10 - i) g N ----

local stack = {
  id = "A17a", title = "stack of ten boxes: contact forces", metric = "relative", scale = 1, seconds = 2,
  build = function(world)
    local s = { floor = world:plane { normal = { 0, 0, 1 }, friction = 0.6 }, boxes = {} }
    for i = 1, 10 do s.boxes[i] = world:box { size = 1, mass = 1, at = { 0, 0, i - 0.5 }, friction = 0.6 } end
    return s
  end,
  finish = function(s)
    local worst, sag, below = 0, 0, s.floor
    for i, box in ipairs(s.boxes) do
      local force = 0
      for _, link in ipairs(box:links()) do
        if link.kind == "contact" and (link.a == below or link.b == below) then force = force + #link.effort end
      end
      worst = math.max(worst, math.abs(force / ((11 - i) * g) - 1))
      sag = math.max(sag, #(box.position - { 0, 0, i - 0.5 }))
      below = box
    end
    return { error = worst, sag = sag }
  end,
}

-- ---- (b) twenty links of 0.1 m over a span of 1.2 m; they start as a V with sides of 1 m ----

-- Bodies in a straight row from one point to another, hinged to what comes before
local function row_of(world, digbox, s, from, to, count, thickness, mass, fields)
  from, to = digbox.vec(from), digbox.vec(to)
  local step = (to - from) / count
  local turn = digbox.quat { from = { 1, 0, 0 }, to = step }
  for i = 1, count do
    local link = world:box { size = { #step, thickness, thickness }, mass = mass, at = from + step * (i - 0.5), rotation = turn,
                             collides = false }
    local hinge = { a = link, b = s.links[#s.links], at = from + step * (i - 1), axis = { 0, 1, 0 } }
    for k, v in pairs(fields or {}) do hinge[k] = v end
    s.links[#s.links + 1] = link
    s.hinges[#s.hinges + 1] = world:hinge(hinge)
  end
end

local function end_of(body, x) return body.position + body.rotation:rotate { x, 0, 0 } end

local catenary = {
  id = "A17b", title = "catenary of twenty links", metric = "relative", scale = 1, seconds = 15,
  build = function(world, digbox)
    local s = { links = {}, hinges = {} }
    world:region { digbox.box { size = 10 }, laws = { drag = 6 } }
    row_of(world, digbox, s, { -0.6, 0, 0 }, { 0, 0, -0.8 }, 10, 0.01, 1)
    row_of(world, digbox, s, { 0, 0, -0.8 }, { 0.6, 0, 0 }, 10, 0.01, 1)
    s.last = world:hinge { a = s.links[20], at = { 0.6, 0, 0 }, axis = { 0, 1, 0 } }
    return s
  end,
  finish = function(s)
    local depth = -end_of(s.links[10], 0.05).z / 0.72690523213089818 - 1
    local force = #s.hinges[1].force / g / 10.518601777050987 - 1
    local pull = math.abs(s.hinges[1].force.x) / g / 3.2620520143278183 - 1
    local speed = 0
    for _, link in ipairs(s.links) do speed = math.max(speed, link.speed) end
    return { error = math.max(math.abs(depth), math.abs(force), math.abs(pull)), depth = depth, force = force, pull = pull, speed = speed }
  end,
}

-- ---- (c) ten links of 0.1 m and 0.1 kg with torsion springs, held level at the root ----

local cantilever = {
  id = "A17c", title = "cantilever of ten links on torsion springs", metric = "relative", scale = 1, seconds = 16,
  build = function(world, digbox)
    local s = { links = {}, hinges = {} }
    row_of(world, digbox, s, { 0, 0, 0 }, { 1, 0, 0 }, 10, 0.01, 0.1, { spring = { stiffness = 20, damping = 4 } })
    return s
  end,
  finish = function(s)
    local tip = end_of(s.links[10], 0.05)
    local down, along = -tip.z / 0.56042174887491605 - 1, tip.x / 0.80901936081257371 - 1
    local root = math.abs(exact.turn_about_y(s.links[1].rotation)) / 0.21001581548285385 - 1
    local speed = 0
    for _, link in ipairs(s.links) do speed = math.max(speed, link.speed) end
    return { error = math.max(math.abs(down), math.abs(along), math.abs(root)), down = down, along = along, root = root, speed = speed }
  end,
}

-- ---- (d) 10 kg on two springs of 1e4 N/m from (-1, 0) and (1, 0), whose ends meet at height 0.5 when unloaded ----

local truss = {
  id = "A17d", title = "von Mises truss", metric = "relative", scale = 1, seconds = 5,
  build = function(world)
    local ball = world:ball { radius = 0.1, mass = 10, at = { 0, 0, 0.5 }, collides = false }
    world:slider { a = ball, axis = { 0, 0, 1 } }
    for _, x in ipairs { -1, 1 } do
      world:spring { a = ball, at_b = { x, 0, 0 }, length = math.sqrt(1.25), stiffness = 1e4, damping = 300 }
    end
    return { ball = ball }
  end,
  finish = function(s)
    return { error = math.abs(s.ball.position.z / 0.47383220276216135 - 1), speed = s.ball.speed }
  end,
}

return { stack, catenary, cantilever, truss }
