-- Heaps of more thin things than the accurate ways take: they may not get through each other, gain energy, or stir for ever.
-- Only in the plain build: figures of large heaps; test_crowd.c runs the same code under sanitizers.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local function heap(s, shape, size, count, gap)
  local w = s:world {}
  local bodies = {}
  w:floor { friction = 0.5 }
  for i = 1, count do
    local turn = digbox.quat { axis = { 0, 1, 0 }, angle = 2.4 * i }
    local at = { size[1] * 0.015 * (i % 7), gap * i, size[1] * 0.02 * (i % 5) }
    if shape == "capsule" then
      bodies[i] = w:capsule { radius = size[2] / 2, length = size[1], friction = 0.5, at = at,
                              rotation = turn * digbox.quat { axis = { 0, 0, 1 }, angle = math.pi / 2 } }
    else
      bodies[i] = w:box { size = size, density = 1000, friction = 0.5, at = at, rotation = turn }
    end
  end
  return w, bodies
end

local function stored(w)
  local e = w.energy
  return e.kinetic + e.potential
end

-- Runs it; returns the greatest rise of its energy in a frame over what it began with, the deepest overlap in the last second (m), and
-- the fastest body at the end, m/s.
local function run(w, bodies, seconds)
  local first, rise, deepest, fastest = stored(w), 0, 0, 0
  local last = first
  for k = 1, seconds * 60 do
    w:step()
    local now = stored(w)
    rise, last = math.max(rise, now - last), now
    if k > (seconds - 1) * 60 then deepest = math.max(deepest, w:stats().penetration) end
  end
  for _, b in ipairs(bodies) do fastest = math.max(fastest, b.speed) end
  return rise / first, deepest, fastest
end

-- What healing pushes out of an overlap it lifts: up to 1.4 % of all energy in a frame (the plates); 2 % is asked. Capsules roll away.
-- shape, size (m), how many, m from one to the next, seconds, deepest overlap at the end over the thickness, fastest at the end (m/s)
local heaps = {
  { "box", { 2, 0.01, 0.01 }, 60, 0.03, 5, 0.2, 0.1 },
  { "box", { 2, 0.01, 0.01 }, 100, 0.03, 5, 0.3, 0.1 },
  { "box", { 0.2, 0.01, 0.01 }, 60, 0.03, 6, 0.2, 0.1 },        -- after 5 s one of six starts has a rod that just tips, at 0.07 or 0.13 m/s
  { "box", { 1, 0.02, 1 }, 60, 0.04, 4, 0.3, 0.1 },
  { "capsule", { 2, 0.01 }, 60, 0.03, 4, 0.3, 2 },
}

for _, h in ipairs(heaps) do
  local shape, size, count, gap, seconds, overlap, speed = table.unpack(h)
  scenario(("%d thin things (%s, %g m by %g mm) fall in a heap"):format(count, shape, size[1], 1000 * size[2]), function(s)
    local w, bodies = heap(s, shape, size, count, gap)
    local rise, deepest, fastest = run(w, bodies, seconds)
    expect(rise):below(0.02)
    expect(deepest):below(overlap * size[2])
    expect(fastest):below(speed)
    expect(#w:warnings()):is(0)
  end)
end

-- Steps of such heaps are in four or five pieces, now so, now so. Where each number of pieces made springs as stiff as fits it, the
-- heap was let down and lifted for ever: rods at 0.02 to 0.08 m/s after 8 s, 78 and 92 of 120 planks after 7.
scenario("rods of 2 m by 10 mm come to rest", function(s)
  for start = 1, 2 do
    local w, bodies = heap(s, "box", { 2, 0.01, 0.01 }, 60, 0.03 + 1e-9 * start)
    local _, _, fastest = run(w, bodies, 8)
    expect(fastest):below "1 cm/s"
  end
end)

for seed = 2, 3 do
  scenario(("120 planks that fall into a room come to rest (%d)"):format(seed), function(s)
    local w, bodies = s:world { seed = seed }, {}
    local function between(low, high) return low + (high - low) * math.random() end
    w:room { size = { 3, 60, 3 } }
    for i = 1, 120 do
      local at = { between(-1.2, 1.2), 0.4 + 0.045 * i, between(-1.2, 1.2) }
      local turn = { axis = { math.random(), math.random(), math.random() + 0.1 }, angle = math.random() * 3 }
      bodies[i] = w:box { size = { 0.8, 0.03, 0.15 }, friction = 0.5, at = at, rotation = turn }
    end
    run(w, bodies, 7)
    local moving = 0
    for _, b in ipairs(bodies) do moving = moving + (b.speed > 0.01 and 1 or 0) end
    expect(moving):at_most(4)
  end)
end

-- Rods, discs, capsules, cones and boxes of 1 cm to 0.3 m, much alike in mass, in a pit without a way out.
local function mixture(s, seed, count)
  local w, x = s:world {}, seed * 7919 + 13
  local function random()
    x = (x * 1103515245 + 12345) % 2147483648
    return x / 2147483648
  end
  local function length() return 0.01 * 100 ^ (0.7 * random()) end
  w:floor { friction = 0.5 }
  for k = 0, 3 do
    w:plane { normal = { math.cos(k * math.pi / 2), 0, math.sin(k * math.pi / 2) }, offset = -1.5, friction = 0.3 }
  end
  local made = {}
  for i = 1, count do
    local kind, a, b, c = math.floor(5 * random()), length(), length(), length()
    local f = { mass = 1 + 4 * random(), friction = 0.2 + 0.6 * random(),
                at = { 1.6 * random() - 0.8, 0.3 + 0.04 * i, 1.6 * random() - 0.8 },
                rotation = digbox.quat { axis = { random() - 0.5, random() - 0.5, random() - 0.5 }, angle = 6 * random() } }
    if kind == 1 then
      f.radius, f.length = b / 2, a
      made[i] = w:capsule(f)
    elseif kind == 2 or kind == 3 then
      f.radius, f.height = a / 2, b
      made[i] = kind == 2 and w:cylinder(f) or w:cone(f)
    else
      f.size = kind == 0 and { a, b, c } or { a, 0.01, 0.01 + b / 10 }
      made[i] = w:box(f)
    end
  end
  return w, made
end

for seed = 2, 3 do
  scenario(("250 things, many of them thin, fall into a pit (%d)"):format(seed), function(s)
    local w, bodies = mixture(s, seed, 250)
    local rise, deepest = run(w, bodies, 3)
    expect(rise):below(1e-4)
    expect(deepest):below(0.02)
    for _, b in ipairs(bodies) do
      expect(b.position.y):above(0)
      expect(math.max(math.abs(b.position.x), math.abs(b.position.z))):below(1.5)
    end
    expect(#w:warnings()):is(0)
  end)
end
