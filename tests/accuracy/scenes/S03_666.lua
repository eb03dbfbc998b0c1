-- S03 666, of SimBenchmark: 6 x 6 x 6 frictionless balls of 10 kg fall on each other and on the ground, and scatter. S03p: plastic; error:
-- root mean square of the overlaps, summed over pairs. S03e: elastic, from 1 m higher; error: root mean square of the energy, relative.
local radius, count = 0.1, 6

-- Positions off by up to 1 mm, from a generator of its own (minimal standard, Park and Miller 1988)
local function noise(seed)
  return function()
    seed = seed * 48271 % 2147483647
    return (2 * seed / 2147483647 - 1) * 0.001
  end
end

local swept = "216 bodies in touch are more than any plan traces (96), and what is swept is of first order in the substep, if that: " ..
  "8.1e-6, 5.0e-6 and 7.5e-7 m with 4, 16 and 64 of them."

local function pile(letter, e, height, seconds)
  local scene = { id = "S03" .. letter, scale = 1, seconds = seconds, slow = true }
  scene.title = e > 0 and "216 elastic balls" or "216 plastic balls"
  scene.metric = e > 0 and "relative" or "m"
  scene.conserves = { energy = e == 1 }
  scene.limits = e == 0 and { floor = swept, bound = swept } or nil
  function scene.build(world)
    local s = { balls = {}, sum = 0, frames = 0, deepest = 0 }
    local off = noise(42)
    world:plane { normal = { 0, 0, 1 }, friction = 0, restitution = e }
    for i = 0, count * count * count - 1 do
      local x, y, z = i % count, i // count % count, i // (count * count)
      s.balls[i + 1] = world:ball { radius = radius, mass = 10, friction = 0, restitution = e,
                                    at = { 0.21 * x + off(), 0.21 * y + off(), 0.21 * z + height + math.abs(off()) } }
    end
    s.start = world.energy.kinetic + world.energy.potential
    return s
  end
  local function overlap(s)
    local xs, ys, zs, sum = {}, {}, {}, 0
    for i, ball in ipairs(s.balls) do xs[i], ys[i], zs[i] = ball.position:unpack() end
    for i = 1, #xs do
      local x, y, z = xs[i], ys[i], zs[i]
      local deep = radius - z
      if deep > 0 then sum, s.deepest = sum + deep * deep, math.max(s.deepest, deep) end
      for j = i + 1, #xs do
        local dx, dy, dz = xs[j] - x, ys[j] - y, zs[j] - z
        local square = dx * dx + dy * dy + dz * dz
        if square < 4 * radius * radius then
          local d = 2 * radius - math.sqrt(square)
          sum, s.deepest = sum + d * d, math.max(s.deepest, d)
        end
      end
    end
    return sum
  end
  function scene.frame(s)
    local now = s.world.energy
    s.sum = s.sum + (e > 0 and ((now.kinetic + now.potential) / s.start - 1) ^ 2 or overlap(s))
    s.frames = s.frames + 1
  end
  function scene.finish(s) return { error = math.sqrt(s.sum / s.frames), deepest = s.deepest } end
  return scene
end

return { pile("p", 0, 0.101, 10), pile("e", 1, 1.101, 10) }
