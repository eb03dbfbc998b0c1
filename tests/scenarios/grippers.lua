-- grippers.lua: two jaws that have closed on a box hold it, whatever else acts on it, until they open.
-- Only in the plain build: figures of long holds; squeezed.lua runs the same code under sanitizers.
local digbox = require "digbox"
local test = require "digbox.test"
local expect = test.expect

local steps = { 1 / 30, 1 / 60, 1 / 1000 }
local squeezes = { 1e-4, 0, 2e-3 }              -- m  by which they are nearer than the box is wide: 0 is an exact fit

-- A box of 1 kg on the floor, and two movers that have closed on it.
local function gripper(s, accuracy, step, squeeze)
  local g = { w = s:world { accuracy = accuracy, step = step } }
  g.w:floor { friction = 0.5 }
  g.box = g.w:box { name = "box", size = 0.2, mass = 1, friction = 0.5, at = { 0, 0.1, 0 } }
  local jaw = { kinematic = true, size = { 0.1, 0.18, 0.3 }, friction = 0.5 }
  jaw.at = { -0.17, 0.12, 0 }
  g.left = g.w:box(jaw)
  jaw.at = { 0.17, 0.12, 0 }
  g.right = g.w:box(jaw)
  local count = math.floor(0.1 / step + 0.5)
  local speed = (0.02 + squeeze / 2) / (count * step)
  function g:drive(closing, velocity)
    self.left:drive { velocity = digbox.vec(closing, 0, 0) + digbox.vec(velocity or { 0, 0, 0 }) }
    self.right:drive { velocity = digbox.vec(-closing, 0, 0) + digbox.vec(velocity or { 0, 0, 0 }) }
  end
  function g:go(velocity, time)
    self:drive(0, velocity)
    self.w:run(time)
    self:drive(0)
  end
  function g:held() return self.box.position - (self.left.position + self.right.position) / 2 end
  g:drive(speed)
  for _ = 1, count do g.w:step() end
  g:go({ 0, 0.2, 0 }, 1)
  g.place = g:held()
  return g
end

local function each(s, accuracy, run)
  for _, step in ipairs(steps) do
    for _, squeeze in ipairs(squeezes) do
      local g = gripper(s, accuracy, step, squeeze)
      expect(g.place):near({ 0, -0.02, 0 }, 1e-9)
      run(g, step, squeeze)
    end
  end
end

local function laid_on(g, mass, above)
  return g.w:box { size = 0.05, mass = mass, at = g.box.position + digbox.vec(0, 0.125 + above, 0) }
end

test.each_accuracy("what jaws hold bears pushes and what is laid or dropped on it", function(s, accuracy)
  each(s, accuracy, function(g)
    for _, force in ipairs { 0.01, 1 } do
      g.box:push { force = { 0, -0.6 * force, 0.8 * force }, lasts = 0.5 }
      g.w:run(0.6)
    end
    local gram = laid_on(g, 1e-3, 1e-3)
    g.w:run(0.2)
    local other = g.w:box { size = 0.05, mass = 0.1, at = g.box.position + digbox.vec(0, 0.125 + 0.051 + 0.1, 0) }
    g.w:run(0.3)
    expect(g:held()):near(g.place, 1e-9)
    expect(gram.position.y):near(g.box.position.y + 0.125, 1e-4)
    expect(other.position.y):above(g.box.position.y + 0.1)
  end)
end)

-- What lies on the floor cannot give way, and is not crushed: the box slips up between the jaws as it does on the floor itself.
test.each_accuracy("a box that is put down on a stack of two, 4 mm too low, lies on it", function(s, accuracy)
  for _, step in ipairs { 1 / 30, 1 / 60 } do
    local g, deepest = gripper(s, accuracy, step, 1e-4), 0
    g:go({ 0, 1, 0 }, 0.4)
    local boxes = {}
    for i = 1, 2 do boxes[i] = g.w:box { size = 0.2, mass = 1, friction = 0.5, at = { 0.02 * i, 0.2 * i - 0.1, 0 } } end
    g.w:run(0.2)
    local low = math.floor((g.box.position.y - 0.5 + 0.004) / 0.2 / step + 0.5) * step
    g:drive(0, { 0, -0.2, 0 })
    for _ = 1, math.floor(low / step + 0.5) do
      g.w:step()
      deepest = math.max(deepest, g.w:stats().penetration)
    end
    g:drive(0)
    g.w:run(0.3)
    g:drive(-0.2)
    g.w:run(1)
    expect(deepest):below(1e-3)
    expect(g.box.position):near({ 0, 0.5, 0 }, 1e-3)
    for i = 1, 2 do expect(boxes[i].position):near({ 0.02 * i, 0.2 * i - 0.1, 0 }, 2e-3) end
  end
end)

test.each_accuracy("what jaws hold bears what is welded to it or hangs from it", function(s, accuracy)
  each(s, accuracy, function(g, step)
    local welded = g.w:box { size = 0.05, mass = 1, at = g.box.position + digbox.vec(0, -0.125, 0) }
    g.w:weld { a = welded, b = g.box }
    local hangs = g.w:box { size = 0.05, mass = 1, at = g.box.position + digbox.vec(0.04, 0.02, -0.3) }
    g.w:distance { a = hangs, b = g.box }
    g:go({ 0, 0.2, 0 }, 0.5)
    g.w:run(step)
    expect(g:held()):near(g.place, 1e-9)
    expect(welded.position - g.box.position):near({ 0, -0.125, 0 }, 1e-3)
    expect(#(hangs.position - g.box.position)):near(0.3052867, 2e-3)
  end)
end)

-- A closed fist: 3 m/s^2 up and 1 m/s^2 aside, with a gram on top; down again with 5 m/s^2.
test.each_accuracy("jaws take along what they hold, slowly or not", function(s, accuracy)
  each(s, accuracy, function(g, step)
    local gram = laid_on(g, 1e-3, 0)
    for i = 1, math.floor(0.5 / step) do
      g:drive(0, { 0, 3 * i * step, i * step })
      g.w:step()
    end
    for i = 1, math.floor(0.2 / step) do
      g:drive(0, { 0, 1.5 - 5 * i * step, 0.5 })
      g.w:step()
    end
    expect(g:held()):near(g.place, 1e-9)
    expect(gram.position.y):near(g.box.position.y + 0.125, 0.01)
  end)
end)

-- N on the box, of each jaw
local function borne(g)
  local sum = {}
  for _, link in ipairs(g.box:links()) do
    local other = link.a == g.box and link.b or link.a
    for name, jaw in pairs { left = g.left, right = g.right } do
      if other == jaw then sum[name] = link.a == g.box and -link.effort or link.effort end
    end
  end
  return sum.left, sum.right
end

test.each_accuracy("jaws tell what they bear", function(s, accuracy)
  each(s, accuracy, function(g)
    local function both_bear(x, y, z)
      local left, right = borne(g)
      expect(left):near({ x / 2, y / 2, z / 2 }, 1e-6)
      expect(right):near({ x / 2, y / 2, z / 2 }, 1e-6)
    end
    g.w:run(0.1)
    both_bear(0, 9.81, 0)
    g.box:push { force = { 0, -2, 3 }, lasts = 0.2 }
    g.w:run(0.1)
    both_bear(0, 11.81, -3)
    g.w:run(0.2)
    g.box:push { force = { 5, 0, 0 }, lasts = 0.2 }     -- the right one holds against it
    g.w:run(0.1)
    local left, right = borne(g)
    expect(left):near({ 0, 4.905, 0 }, 1e-6)
    expect(right):near({ -5, 4.905, 0 }, 1e-6)
    g.w:run(0.2)
    laid_on(g, 0.5, 0)
    g.w:run(1)
    both_bear(0, 1.5 * 9.81, 0)
  end)
end)

test.each_accuracy("jaws that open let go at once", function(s, accuracy)
  each(s, accuracy, function(g, step, squeeze)
    local from = g.box.position.y
    g.w:run(1)                                          -- it sleeps
    g:drive(-0.2)
    local count = math.floor(0.18 / step)
    for _ = 1, count do g.w:step() end
    local time = count * step
    local late = time - squeeze / 0.4                   -- as soon as they are not deep in it any more
    expect(from - g.box.position.y):between(0.5 * 9.81 * late * late - 2e-3, 0.5 * 9.81 * time * time + 2e-3)
  end)
end)

test.each_accuracy("a gripper puts down what it holds, and slips off what it cannot push on", function(s, accuracy)
  each(s, accuracy, function(g)
    g:go({ 0, -0.2, 0 }, 1.05)                          -- 1 cm too far
    expect(g.box.position.y):near(0.1, 1e-3)
    g:drive(-0.2)
    g.w:run(0.5)
    expect(g.box.position):near({ 0, 0.1, 0 }, 2e-3)
  end)
end)

test.each_accuracy("what stands in a place that fits, or between walls, is free", function(s, accuracy)
  for _, case in ipairs { { true, 0 }, { false, 0 }, { false, 1e-4 } } do
    local mover, narrow = table.unpack(case)
    local w = s:world { accuracy = accuracy }
    local box = w:box { size = 0.2, mass = 1, friction = 0.5, at = { 0, 1, 0 } }
    for side = -1, 1, 2 do
      w:box { kinematic = mover, fixed = not mover, size = { 0.1, 2, 1 }, at = { side * (0.15 - narrow / 2), 1, 0 }, friction = 0.5 }
    end
    w:run(0.3)
    expect(box.position.y):below(0.6)
  end
end)

-- In jaws that turn about the origin, with 0.1 kg on top of it and under pushes.
test.each_accuracy("what jaws that turn hold bears a load", function(s, accuracy)
  for _, step in ipairs(steps) do
    local w = s:world { accuracy = accuracy, step = step }
    local grip = w:body { kinematic = true, friction = 0.5, spin = { 0, 6, 0 }, parts = {
      digbox.box { size = { 1, 0.2, 0.1 }, at = { 0.5, 0, 0.149 } }, digbox.box { size = { 1, 0.2, 0.1 }, at = { 0.5, 0, -0.149 } } } }
    local box = w:box { size = 0.2, mass = 1, friction = 0.5, at = { 0.25, 0, 0 }, velocity = { 0, 0, -1.5 }, spin = { 0, 6, 0 } }
    w:run(2 * step)
    local place = grip.rotation:inverse():rotate(box.position - grip.position)
    local load = w:box { size = { 0.15, 0.02, 0.15 }, mass = 0.1, friction = 20, at = box.position + digbox.vec(0, 0.11, 0),
      velocity = box.velocity, spin = box.spin, rotation = box.rotation }
    box:push { force = { 0, -1, 0 }, lasts = 0.5 }
    w:run(1)
    expect(grip.rotation:inverse():rotate(box.position - grip.position)):near(place, 1e-9)
    expect(#box.velocity):near(1.5, 1e-6)
    expect(load.position.y):near(0.11, 1e-3)
  end
end)

-- A box of 1 kg between two jaws on sliders, each pressed by F: 2 mu F bears it from F = 9.81 N on. The table under it goes.
test.each_accuracy("jaws that a force closes hold what friction bears, and no more", function(s, accuracy)
  for _, step in ipairs(steps) do
    for _, share in ipairs { 0.97, 1.03 } do
      local w = s:world { accuracy = accuracy, step = step }
      local box = w:box { size = 0.2, mass = 1, friction = 0.5, at = { 0, 1, 0 } }
      local stand = w:box { kinematic = true, size = { 0.15, 0.1, 0.15 }, at = { 0, 0.85, 0 } }
      for side = -1, 1, 2 do
        local jaw = w:box { size = { 0.1, 0.18, 0.3 }, mass = 0.5, friction = 0.5, at = { side * 0.16, 1, 0 } }
        w:slider { a = jaw, axis = { -side, 0, 0 }, motor = { speed = 0.1, max_force = share * 9.81 } }
      end
      w:run(0.5)
      stand:drive { velocity = { 0, -2, 0 } }
      w:run(0.5)
      if share > 1 then
        expect(box.position.y):near(1, 1e-3)
      else
        expect(1 - box.position.y):between(0.01, 0.1)   -- by 3 % of a fall
      end
    end
  end
end)

test.scenario("a world that is saved knows what its jaws hold", function(s)
  local g = gripper(s, "play", 1 / 60, 0)
  g.w:save "gripper.world"
  local again = digbox.load "gripper.world"
  local box = again:find "box"
  box:push { force = { 0, -1, 0 }, lasts = 0.2 }
  again:run(0.5)
  expect(box.position):near(g.box.position, 1e-9)
end)

test.scenario("a minute in closed jaws moves nothing", function(s)
  for _, accuracy in ipairs { "sketch", "play", "study" } do
    local g = gripper(s, accuracy, 1 / 60, 1e-4)
    laid_on(g, 0.1, 0)
    for k = 1, 60 do
      g.box:push { force = { 0, -1, 0.01 * k }, lasts = 0.5 }
      g.w:run(1)
    end
    expect(g:held()):near(g.place, 1e-9)
  end
end)

-- A box between the walls of a guide that turns with w = 3 rad/s slides out: r'' = w^2 r - 2 mu w r'. That the middles of its contacts are
-- not opposite each other, where one wall is shorter, closes nothing.
test.each_accuracy("in a guide that fits and turns a box slides", function(s, accuracy)
  local w, mu, time = 3, 0.05, 0.2
  local root = math.sqrt(1 + mu * mu)
  local a, b = w * (root - mu), -w * (root + mu)
  local far = 0.4 * (a * math.exp(b * time) - b * math.exp(a * time)) / (a - b)
  for _, apart in ipairs { true, false } do
    local world = s:world { accuracy = accuracy, gravity = { 0, 0, 0 } }
    local walls = {}
    for i, long in ipairs { 0.95, 0.4 } do
      walls[i] = digbox.box { size = { long, 0.2, 0.1 }, at = { 0.05 + long / 2, 0, 0.45 - 0.3 * i } }
    end
    local guide
    for _, parts in ipairs(apart and { { walls[1] }, { walls[2] } } or { walls }) do
      guide = world:body { kinematic = true, friction = mu, spin = { 0, w, 0 }, parts = parts }
    end
    local box = world:box { size = 0.2, mass = 1, friction = mu, at = { 0.4, 0, 0 }, spin = { 0, w, 0 }, velocity = { 0, 0, -0.4 * w } }
    world:run(time)
    expect(guide.rotation:inverse():rotate(box.position).x):near(far, 5e-4)
  end
end)

test.each_accuracy("jaws take nothing out of the plane of its world, nor turn what does not turn", function(s, accuracy)
  local w = s:world { accuracy = accuracy, plane = "xy" }
  local flat = gripper({ world = function() return w end }, accuracy, 1 / 60, 2e-3)
  flat:go({ 0, 0, 0.2 }, 0.2)
  expect(flat.box.position.z):is(0)
  local g = gripper(s, accuracy, 1 / 60, 2e-3)
  local keeps = g.w:box { size = 0.2, mass = 1, friction = 0.5, turns = false, at = { 0, 2, 0 } }
  local jaws = g.w:body { kinematic = true, friction = 0.5, at = { 0, 2, 0 }, spin = { 0.5, 0, 0 }, parts = {
    digbox.box { size = { 0.1, 0.2, 0.2 }, at = { 0.149, 0, 0 } }, digbox.box { size = { 0.1, 0.2, 0.2 }, at = { -0.149, 0, 0 } } } }
  g.w:run(0.2)
  expect(jaws.rotation.x):above(0.04)
  expect(math.abs(keeps.rotation.x)):below(1e-6)
end)

test.each_accuracy("what wind and water do to what jaws hold is in the books", function(s, accuracy)
  for _, medium in ipairs { "air", "water" } do
    local g = gripper(s, accuracy, 1 / 60, 0)
    if medium == "air" then g.w:air { wind = { 0, 0, 5 } } else g.w:water { level = 2 } end
    g:go({ 0, 0.3, 0.3 }, 0.5)
    laid_on(g, 1, 0)
    g:go({ 0, 0.3, 0.3 }, 0.5)
    expect(g:held()):near(g.place, 1e-9)
    expect(math.abs(g.w.energy.numerical)):below(1e-6)
  end
end)
