-- own_effects.lua: world:add_effect, and world:effects() with the lines of the script that called for them.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local g = 9.81

local function expect_failure(fn, text) expect(expect(fn):fails()):contains(text) end

-- The line that calls this.
local function here()
  return tonumber(select(2, pcall(error, "x", 3)):match ":(%d+): x")
end

local function line_of(why) return tonumber(why:match "own_effects%.lua:(%d+)") end

local function pull(k) return function(_, bodies) for _, b in ipairs(bodies) do b.force = -k * b.position end end end

-- ---- forces ----

test.each_accuracy("a spring written in Lua swings as the closed form says", function(s, accuracy)
  local world = s:world { gravity = { 0, 0, 0 }, accuracy = accuracy }
  local k, m, a = 50, 2, 0.3
  local ball = world:ball { radius = 0.1, mass = m, at = { a, 0, 0 } }
  world:add_effect { name = "spring", bodies = { ball }, step = pull(k),
    energy = function(_, bodies) return 0.5 * k * bodies[1].position:dot(bodies[1].position) end }
  world:run(2)
  local bound = ({ sketch = 0.02, play = 1e-6, study = 1e-9, reference = 1e-12 })[accuracy]
  expect(ball.position.x):near(a * math.cos(math.sqrt(k / m) * world.time), bound)
  expect(world.energy.total):near(0.5 * k * a * a, 30 * bound)
  expect(world.energy.numerical):near(0, 30 * bound)
end)

scenario("it agrees with the built-in spring", function(s)
  local function swing(own)
    local world = s:world { gravity = { 0, 0, 0 }, accuracy = "study" }
    local ball = world:ball { radius = 0.1, mass = 2, at = { 0.3, 0, 0 }, velocity = { 0, 1, 0 } }
    if own then
      world:add_effect { name = "spring", step = function(_, bodies)
        local x = bodies[1].position
        bodies[1].force = -50 * (#x - 0.1) / #x * x
      end }
    else
      world:spring { a = ball, at = { 0.3, 0, 0 }, at_b = { 0, 0, 0 }, stiffness = 50, length = 0.1 }
    end
    world:run(2)
    return ball.position
  end
  expect(swing(true)):near(swing(false), 2e-9)
end)

-- Bodies that the world's gravity leaves alone and the script's does not, against the others.
local function fall(s, own, options, build)
  local world = s:world(options)
  world:floor { friction = 0.3 }
  local bodies = build(world, own and 0 or 1)
  if own then
    world:add_effect { name = "weight", bodies = bodies, step = function(_, list)
      for _, b in ipairs(list) do b.force = { 0, -g * b.mass, 0 } end
    end }
  end
  world:run(1.5)
  local states = {}
  for i, b in ipairs(bodies) do states[i] = ("%a %a %a %a"):format(b.position.x, b.position.y, b.velocity.y, b.spin.z) end
  return table.concat(states, "\n")
end

scenario("gravity written in Lua gives the bits of gravity where both are swept", function(s)
  local function pile(world, scale)
    local bodies = {}
    for i = 1, 12 do
      bodies[i] = world:box { size = { 0.2, 0.2, 0.2 }, at = { 2 * i, 0.2 + 0.05 * i, 0 }, spin = { i, 1, 2 },
        gravity_scale = scale, restitution = 0.2, friction = 0.3, integrator = "verlet" }
    end
    return bodies
  end
  expect(fall(s, true, {}, pile)):is(fall(s, false, {}, pile))
end)

scenario("a torque spins a ball up: w = tau t / I", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local ball = world:ball { radius = 0.1, mass = 3, spin = { 0, 1, 0 } }
  world:add_effect { name = "motor", step = function(_, bodies) bodies[1].torque = { 0, "0.06 N m", 0 } end }
  world:run(1)
  expect(ball.spin.y):near(1 + 0.06 / (0.4 * 3 * 0.01), 1e-9)
  expect(ball.velocity):near({ 0, 0, 0 }, 1e-15)
end)

scenario("forces that depend on time are asked for at the time they act: v = (1 - cos t)", function(s)
  local world = s:world { gravity = { 0, 0, 0 }, accuracy = "study" }
  local ball = world:ball { radius = 0.1, mass = 1 }
  world:add_effect { name = "shake", step = function(effect, bodies) bodies[1].force = { math.sin(effect.time), 0, 0 } end }
  world:run(2)
  expect(ball.velocity.x):near(1 - math.cos(2), 1e-9)
end)

scenario("bodies are pushed and twisted there as anywhere: several pushes add up, one beside the centre turns", function(s)
  local function run(step)
    local world = s:world { gravity = { 0, 0, 0 } }
    local box = world:box { size = 0.2, mass = 2, name = "box", at = { 1, 2, 3 }, spin = { 0.1, 0, 0 }, data = 5 }
    world:add_effect { name = "thrust", step = step }
    world:run(0.5)
    return ("%a %a %a"):format(box.velocity.x, box.velocity.y, box.spin.z), box
  end
  local pushed, box = run(function(_, bodies)
    for _, b in ipairs(bodies) do
      expect(b.name):is "box"
      expect(b.data):is(5)
      expect(b.speed):is(#b.velocity)
      b:push { force = "3 N", along = { 1, 0, 0 }, at = b.centre + { 0, 0.1, 0 } }:push { force = { 0, 1, 0 } }
      b:twist { torque = { 0, 0, "0.2 N m" } }:twist { torque = 0.05, along = { 0, 0, 1 } }
    end
  end)
  expect(box.velocity):near({ 0.75, 0.25, 0 }, 1e-12)
  expect(pushed):is((run(function(_, bodies)
    for _, b in ipairs(bodies) do b.force, b.torque = { 3, 1, 0 }, { 0, 0, 3 * (b.centre.y + 0.1 - b.centre.y) * -1 + 0.2 + 0.05 } end
  end)))
end)

-- ---- who takes part ----

scenario("a filter is asked about later bodies, too; join and leave", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local light = world:ball { radius = 0.1, mass = 1, at = { 0, 0, 0 } }
  local heavy = world:ball { radius = 0.1, mass = 5, at = { 0, 3, 0 } }
  local effect = world:add_effect { name = "wind", bodies = function(b) return b.mass < 2 end,
    step = function(_, bodies) for _, b in ipairs(bodies) do b.force = { b.mass, 0, 0 } end end }
  world:step(6)
  local later = world:ball { radius = 0.1, mass = 1, at = { 0, 6, 0 } }
  world:step(6)
  expect(light.velocity.x):near(0.2, 1e-12)
  expect(later.velocity.x):near(0.1, 1e-12)
  expect(heavy.velocity.x):is(0)
  expect(world:effects().wind.bodies):is(2)
  effect:join(heavy):leave(light)
  world:step(6)
  expect(light.velocity.x):near(0.2, 1e-12)
  expect(heavy.velocity.x):near(0.1, 1e-12)
  effect:remove()
  world:step(6)
  expect(heavy.velocity.x):near(0.1, 1e-12)
  expect(world:effects().wind):is(nil)
end)

scenario("the stage settle looks, once a frame step, and effects see bodies alone", function(s)
  local world = s.world
  local ball = world:ball { radius = 0.1, name = "ball" }
  local seen, frame = {}, nil
  world:add_effect { name = "look", stage = "settle", data = 7, step = function(effect, bodies, dt)
    seen[#seen + 1], frame = bodies[1].velocity.y, dt
    expect(effect.data):is(7)
    expect(bodies[1].body):is(ball)
    expect(bodies[1].body.name):is "ball"
  end }
  world:step(3)
  expect(#seen):is(3)
  expect(frame):is(world.frame)
  expect(seen[3]):near(-g * 3 * world.frame, 1e-12)
end)

-- ---- the same bits ----

local function swarm(s, threads)
  local world = s:world { threads = threads }
  world:floor {}
  for i = 1, 24 do
    world:ball { radius = 0.1, at = { 3 * i, 0.15, 0 } }
    world:ball { radius = 0.1, at = { 3 * i + 0.05 * (i % 4), 0.4 + 0.01 * i, 0 } }
  end
  local calls = 0
  world:add_effect { name = "wind", step = function(_, bodies)
    calls = calls + 1                           -- what depends on the order of calls shows it
    for _, b in ipairs(bodies) do b.force = { 0.01 * (calls % 7), 0, b.velocity.y } end
  end }
  return world
end

scenario("any number of threads gives the same bits", function(s)
  local sums = {}
  for i, threads in ipairs { 1, 2, 4 } do
    local world = swarm(s, threads)
    world:run(0.5)
    sums[i] = world:checksum()
  end
  expect(sums[2]):is(sums[1])
  expect(sums[3]):is(sums[1])
end)

scenario("snapshots keep effects; what was added after one is gone with it", function(s)
  local world = s:world { gravity = { 0, 0, 0 } }
  local ball = world:ball { radius = 0.1, mass = 1, at = { 1, 0, 0 } }
  local before = world:snapshot()
  world:add_effect { name = "spring", step = pull(20) }
  world:step(20)
  local mid = world:snapshot()
  world:step(20)
  local sum = world:checksum()
  world:restore(mid)
  world:step(20)
  expect(world:checksum()):is(sum)
  world:restore(before)
  expect(world:effects().spring):is(nil)
  world:step(10)
  expect(ball.velocity):near({ 0, 0, 0 }, 1e-15)
  world:add_effect { name = "spring", step = pull(20) }
  world:step(40)
  expect(ball.position.x):near(math.cos(math.sqrt(20) * 40 / 60), 1e-5)
end)

-- ---- errors ----

scenario("an error names the effect, at its line, and the world is as it was", function(s)
  local world = s.world
  world:ball { radius = 0.1, name = "ball" }
  world:step()
  local sum = world:checksum()
  local faults = {
    { "effect 'fault': attempt to index a nil value", function() local x = nil; return x.y end },
    { "effect 'fault': a body has no field 'forze' (did you mean 'force'?)", function(_, bodies) bodies[1].forze = 1 end },
    { "effect 'fault'.force wants a vector", function(_, bodies) bodies[1].force = 3 end },
    { "at t = 0.0166667 s effect 'fault' gave body 'ball' a non-finite force", function(_, bodies) bodies[1].force = { 0 / 0, 0, 0 } end },
    { "at t = 0.0166667 s effect 'fault' gave body 'ball' a non-finite torque",
      function(_, bodies) bodies[1].torque = digbox.vec(0, 1e308, 0) * 10 end },
    { "effect 'fault': body:push: unknown field 'forse' (did you mean 'force'?)", function(_, bodies) bodies[1]:push { forse = 1 } end },
    { "effect 'fault': body:push.lasts: not here, an effect is asked again at every step",
      function(_, bodies) bodies[1]:push { force = { 1, 0, 0 }, lasts = 1 } end },
    { "effect 'fault'.torque", function(_, bodies) bodies[1].torque = { 0, "3 kg", 0 } end },
    { "effect 'fault': its functions see the bodies they are given", function() world:ball { radius = 1 } end },
    { "effect 'fault': its functions see the bodies they are given", function(_, bodies) bodies[1].body:push { force = { 1, 0, 0 } } end },
    { "effect 'fault': its functions see the bodies they are given", function() world:step() end },
    { "effect 'fault': its functions see the bodies they are given", function() world:effect("fault", false) end },
    { "effect 'fault': attempt to yield", function() coroutine.yield() end },
    { "effect 'fault': mine", function() error "mine" end },
    { "effect 'fault': error was called with a table, must be with a text", function() error { code = 3 } end },
    { "effect 'fault': error was called with a nil, must be with a text", function() error() end },
  }
  for _, fault in ipairs(faults) do
    local effect = world:add_effect { name = "fault", step = fault[2] }
    local line = expect(function() world:step() end):fails()
    expect(line:find(fault[1], 1, true) and fault[1] or line):is(fault[1])
    expect((line:find "own_effects%.lua:%d+: effect" or line:find "own_effects%.lua:%d+: at t = ") and true or line):is(true)
    effect:remove()
    expect(world:checksum()):is(sum)
  end
  expect_failure(function() world:add_effect { name = "e", step = print, energy = function() return "3 m" end } end, "energy")
  expect(world:effects().e):is(nil)
  local infinite = world:add_effect { name = "huge", step = function(_, bodies) bodies[1].force = { 1e308, 1e308, 0 } * 10 end }
  expect_failure(function() world:step() end, "huge")
  infinite:remove()
  world:step()
end)

scenario("wrong arguments", function(s)
  local world = s.world
  local function bad(fields, text) expect_failure(function() world:add_effect(fields) end, text) end
  bad({ step = print }, "name is missing")
  bad({ name = "a" }, "step is missing")
  bad({ name = "a", step = 3 }, "step wants a function")
  bad({ name = "a", step = print, stage = "forse" }, "unknown stage 'forse' (did you mean 'force'?)")
  bad({ name = "gravity", step = print }, "there is an effect 'gravity' already")
  bad({ name = "", step = print }, "1 to 31 bytes")
  bad({ name = "a", step = print, bodies = { 3 } }, "bodies[1] wants a body")
  bad({ name = "a", step = print, bodys = {} }, "unknown field 'bodys'")
  expect_failure(function() for i = 1, 40 do world:add_effect { name = "e" .. i, step = print } end end, "at most 32 effects")
end)

-- ---- what is on, and why ----

scenario("effects say which line called for them", function(s)
  local world = s.world
  expect(world:effects().gravity.why):is "nothing calls for it"
  local line = here()
  local floor = world:floor { friction = 0 }
  local smooth = world:ball { name = "smooth", radius = 0.1, friction = 0, at = { 0, 0.1, 0 } }
  world:step()
  local rough = world:ball { name = "rough", radius = 0.1, friction = 0.5, at = { 3, 0.1, 0 } }
  local plate = world:box { name = "plate", size = { 1, 0.1, 1 }, fixed = true, friction = 0.5, at = { 3, -0.05, 0 } }
  world:hinge { name = "door", a = world:box { size = { 1, 1, 1 }, at = { 9, 9, 9 } }, at = { 8, 9, 9 }, axis = { 0, 1, 0 } }
  world:step()
  rough:push { force = { 1, 0, 0 } }
  world:region { sphere = { radius = 1 }, at = { 99, 0, 0 }, laws = { drag = 1 } }
  world:step()
  rough:remove()                                -- what it called for is not forgotten with it
  world:step()
  local e = world:effects()
  expect(line_of(e.contact.why)):is(line + 2)
  expect(e.contact.why:match "%b()"):is "(body 'smooth')"
  expect(line_of(e.gravity.why)):is(line + 2)
  expect(line_of(e.friction.why)):is(line + 4)
  expect(e.friction.why:match "%b()"):is "(body 'rough')"
  expect(line_of(e.joints.why)):is(line + 6)
  expect(e.joints.why:match "%b()"):is "(hinge 'door')"
  expect(line_of(e.push.why)):is(line + 8)
  expect(line_of(e.region.why)):is(line + 9)
  expect(e.rolling.why):is "nothing calls for it"
  expect(e.rolling.calls):is(0)
  expect(floor.valid and smooth.valid and plate.valid):is(true)
  world:effect("gravity", false)
  expect(world:effects().gravity.why):is "switched off"
end)

scenario("a saved world keeps the reasons, not the functions", function(s)
  local world = s.world
  world:ball { name = "ball", radius = 0.1 }
  world:add_effect { name = "wind", step = function() end }
  world:step()
  local why = world:effects().gravity.why
  world:save "own.dig"
  local again = digbox.load "own.dig"
  expect(again:effects().gravity.why):is(why)
  expect(again:effects().wind):is(nil)
  again:step()
end)

-- ---- what is not solved ----

scenario("the spin of spheres that nothing can turn stays to the last bit, and they turn evenly", function(s)
  for _, accuracy in ipairs { "sketch", "play", "study" } do
    local world, balls = s:world { accuracy = accuracy }, {}
    world:room { size = 3, friction = 0, restitution = 0.9 }
    for i = 1, 12 do
      balls[i] = world:ball { radius = 0.15, friction = 0, restitution = 0.9, spin = { 0.1 * i, 1, 2 },
        velocity = { 1 + i % 3, i % 2, -i % 2 }, at = { 0.5 * (i % 5) - 1, 0.3, 0.5 * (i // 5) - 1 } }
    end
    world:step()
    expect(world:stats().unturned):is(12)
    expect(world:stats().smooth):is(world:stats().pairs)
    world:run(1)
    for i, b in ipairs(balls) do
      expect(b.spin):is(digbox.vec(0.1 * i, 1, 2))
      local axis = b.spin:normalized()
      local turned = digbox.quat { axis = axis, angle = #b.spin * world.time }
      expect(b.rotation:rotate { 1, 0, 0 }):near(turned:rotate { 1, 0, 0 }, 1e-12)
    end
    expect(world:effects().friction.calls):is(0)
  end
end)

scenario("a sphere that something can turn is solved; what flies fast is told", function(s)
  local world = s.world
  world:floor { friction = 0.5 }
  local ball = world:ball { radius = 0.1, at = { 0, 0.1, 0 }, velocity = { 1, 0, 0 }, friction = 0.5 }
  local bullet = world:ball { radius = 0.01, at = { 0, 9, 0 }, velocity = { 50, 0, 0 } }
  world:step()
  local stats = world:stats()
  expect(stats.unturned):is(1)
  expect(stats.fast):is(1)
  expect(ball.spin.z < 0 and bullet.valid):is(true)
end)

scenario("a force too large to follow fails the step, and the world goes on without it", function(s)
  local world = s:world {}
  local ball = world:ball { name = "b", radius = 0.1, mass = 1 }
  world:step()
  local before, at = world:checksum(), ball.position
  local huge = world:add_effect { name = "huge", step = function(_, bodies) bodies[1].force = { 0, 1e300, 0 } end }
  local fine, message = pcall(world.step, world)
  expect(fine):is(false)
  expect(tostring(message)):contains("body 'b' would have a velocity or spin of")
  expect(ball.position):is(at)
  huge:remove()
  expect(world:checksum()):is(before)
  for _, way in ipairs { function() ball:hit { impulse = { 1e20, 0, 0 } } end, function() ball:teleport { velocity = { 1e20, 0, 0 } } end,
                         function() ball:teleport { at = { 0, 1e20, 0 } } end } do
    expect(pcall(way)):is(false)
    expect(world:checksum()):is(before)
  end
  world:step()
  world:save("huge.dig")
  expect(digbox.load("huge.dig"):checksum()):is(world:checksum())
end)
