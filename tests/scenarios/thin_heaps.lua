-- Heaps of more thin things than the accurate ways take: they may not get through each other, gain energy, or stir for ever.
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

-- shape, size (m), how many, m from one to the next, seconds, deepest overlap at the end over the thickness, fastest at the end (m/s)
local heaps = {
  { "box", { 2, 0.01, 0.01 }, 60, 0.03, 5, 0.2, 0.1 },
  { "box", { 2, 0.01, 0.01 }, 100, 0.03, 5, 0.3, 0.1 },
  { "box", { 0.2, 0.01, 0.01 }, 60, 0.03, 5, 0.2, 0.1 },
  { "box", { 1, 0.02, 1 }, 60, 0.04, 4, 0.3, 0.1 },
  { "capsule", { 2, 0.01 }, 60, 0.03, 4, 0.3, 2 },        -- capsules roll away
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
