-- A09 a free box 1 x 0.6 x 0.2 m turning near its middle axis flips over and over (Dzhanibekov). A09n: the tumbling brick of the NASA
-- check cases (NASA/TM-2015-218675, case 2), whose moments of inertia are 0.001894220, 0.006211019, 0.007194665 slug ft^2.
local exact = require "exact"

-- Only ratios of moments matter, so they are given in numbers without rounding: near the middle axis errors grow 1e5 times.
local function reference(ratios, spin, parts)
  return exact.once(function(frames, dt)
    return exact.trajectory(exact.rotor(ratios), { 0, 0, 0, 1, spin[1], spin[2], spin[3] }, dt, frames, parts)
  end)
end

local function worst_of(a, b)
  local worst = 0
  for i = 1, #b do worst = math.max(worst, math.abs(a[i] - b[i])) end
  return worst
end

-- A box with these principal moments: m (b^2 + c^2) / 12 and so on
local function box_of(mass, inertia)
  local a, b, c = table.unpack(inertia)
  local function side(p, q, r) return math.sqrt(6 / mass * (q + r - p)) end
  return { side(a, b, c), side(b, c, a), side(c, a, b) }
end

local function rotor(id, title, seconds, size, mass, ratios, spin, parts, reaches)
  local want = reference(ratios, spin, parts)
  return {
    id = id, title = title, metric = "rad", scale = 1, seconds = seconds,
    world = { gravity = { 0, 0, 0 } }, conserves = { energy = true, angular = true },
    check = function(dt) return reaches(want(math.floor(seconds / dt + 0.5), dt)[math.floor(seconds / dt + 0.5)]) end,
    build = function(world)
      return { worst = 0, rate = 0, body = world:box { size = size, mass = mass, spin = spin },
               want = want(math.floor(seconds / world.frame + 0.5), world.frame) }
    end,
    frame = function(s, _, k)
      local y = s.want[k]
      s.worst = math.max(s.worst, exact.angle_between(s.body.rotation, y))
      s.rate = math.max(s.rate, #(s.body.rotation:inverse():rotate(s.body.spin) - { y[5], y[6], y[7] }))
    end,
    finish = function(s) return { error = s.worst, rate = s.rate } end,
  }
end

local brick = { 0.001894220, 0.006211019, 0.007194665 }
local deg = math.pi / 180

local free = rotor("A09", "free asymmetric rotor, 10 s", 10, { 1, 0.6, 0.2 }, 1, { 5, 13, 17 }, { 0.1, 5, 0.1 }, 4,
  function(y)
    return math.max(worst_of({ y[4], y[1], y[2], y[3] }, { 0.04708551769268645, -0.33976629267684835, -0.04007006820467736,
                                                           -0.93847547118628223 }),
                    worst_of({ y[5], y[6], y[7] }, { -0.65328677596279357, -4.9516760629825136, 0.50514040660107051 }))
  end)
free.rounding = 1e-10
free.goal = { fast = { 1e-3, 0.06 }, accurate = { 1e-8, 0.25 } }

return {
  free,
  rotor("A09n", "tumbling brick, 30 s", 30, box_of(1, brick), 1, brick, { 10 * deg, 20 * deg, 30 * deg }, 1, function(y)
    return math.max(
      exact.angle_between({ 0.4701825277666925, 0.0117282523248712, 0.0486875394720838, -0.8811471853104235 }, y),
      worst_of({ y[5], y[6], y[7] }, { 12.618390775914220 * deg, -17.397474761611393 * deg, 31.119588886944344 * deg }))
  end),
}
