-- flush_rows.lua: what just fits, with faces that touch and nothing that presses them together, is not held by them.
-- Only in the plain build: hundreds of runs; other scenes run the same code under sanitizers.

local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local g = 9.81
local plans = { "play", "study", "reference" }

local function floor(world, friction)
  world:box { name = "floor", fixed = true, size = { 40, 1, 10 }, at = { 0, -0.5, 0 }, friction = friction }
end

-- A box of 0.5 m and 36 kg between two walls that it touches
local function slot(world, friction)
  floor(world, friction)
  for side = -1, 1, 2 do
    world:box { name = "wall", fixed = true, size = { 40, 1, 0.2 }, at = { 0, 0.5, 0.35 * side }, friction = 0.5 }
  end
  return world:box { size = 0.5, mass = 36, at = { 0, 0.25, 0 }, friction = 0.5 }
end

-- n books of 4 cm and 1.68 kg between two bookends
local function row(world, n)
  floor(world, 0.4)
  for side = -1, 1, 2 do
    world:box { name = "bookend", fixed = true, size = { 0.1, 0.3, 0.2 }, at = { side * (0.02 * n + 0.05), 0.15, 0 }, friction = 0.4 }
  end
  local books = {}
  for i = 1, n do
    books[i] = world:box { size = { 0.04, 0.25, 0.18 }, mass = 1.68, at = { 0.04 * (i - (n + 1) / 2), 0.125, 0 }, friction = 0.4 }
  end
  return books
end

-- Pushes it, and says how far it gets in so long, for an acceleration of 1 m/s^2
local function push(world, body, force, seconds)
  local from, start = body.position, world.time
  body:push { force = force, lasts = 10 }
  world:run(seconds)
  return body.position - from, (world.time - start) ^ 2 / 2
end

-- Each at every plan of the list and at frames of 1/60 and 1/30 s
local function everywhere(list, name, run)
  for _, accuracy in ipairs(list) do
    for _, rate in ipairs { 60, 30 } do
      scenario(("at %s and 1/%d s %s"):format(accuracy, rate, name), function(s)
        local world = s:world { accuracy = accuracy, step = 1 / rate }
        run(world)
        expect(world.energy.numerical):near(0, 1e-5)
      end)
    end
  end
end

for _, force in ipairs { 200, 2000 } do
  everywhere(plans, ("a box that just fits between two walls is pushed along them by %g N"):format(force), function(world)
    local box = slot(world, 0.5)
    world:run(0.2)
    local moved, unit = push(world, box, { force, 0, 0 }, 0.5)
    expect(moved.x / ((force / 36 - 0.5 * g) * unit)):near(1, 1e-4)
    expect(moved.z):near(0, 1e-8)
  end)
end

for n = 1, 6 do
  everywhere(plans, ("one of %d books in a row without gaps is pulled out"):format(n), function(world)
    local books = row(world, n)
    world:run(0.2)
    local moved, unit = push(world, books[(n + 1) // 2], { 0, 0, 1.1 * 1.68 * 0.4 * g }, 0.25)
    expect(moved.z / (0.04 * g * unit)):near(1, 1e-4)
    for i, book in ipairs(books) do
      expect(i == (n + 1) // 2 and 0 or book.position.z):near(0, 1e-9)
    end
  end)
end

-- ---- walls that are pressed hold by what presses ----

everywhere(plans, "a box that is pushed against one of two walls rubs at it", function(world)
  local box = slot(world, 0)
  world:run(0.2)
  local moved, unit = push(world, box, { 360, 0, 300 }, 0.5)
  expect(moved.x / ((360 - 150) / 36 * unit)):near(1, 1e-4)
end)

everywhere(plans, "a box that is pressed against one of two walls stays there", function(world)
  local box = slot(world, 0)
  box:push { force = { 0, 0, 1000 }, lasts = 10 }
  world:run(0.2)
  local moved = push(world, box, { 490, 0, 0 }, 0.5)
  expect(moved:length()):near(0, 1e-5)
end)

-- ---- where groups are swept: at sketch, of more bodies than are traced, and in trials of a question ----

local all = { "sketch", "play", "study", "reference" }

for _, force in ipairs { 200, 2000 } do
  everywhere({ "sketch" }, ("a box that just fits between two walls is pushed along them by %g N"):format(force), function(world)
    local box = slot(world, 0.5)
    world:run(0.5)
    local moved, unit = push(world, box, { force, 0, 0 }, 0.5)
    expect(moved.x / ((force / 36 - 0.5 * g) * unit)):near(1, 1e-4)
  end)
end

everywhere({ "sketch", "play" }, "one of 14 books in a row without gaps is pulled out", function(world)
  local books = row(world, 14)
  world:run(0.2)
  local moved, unit = push(world, books[7], { 0, 0, 1.1 * 1.68 * 0.4 * g }, 0.25)
  expect(moved.z / (0.04 * g * unit)):near(1, 1e-3)
  expect(books[6].position.z):near(0, 1e-6)
  expect(books[8].position.z):near(0, 1e-6)
end)

everywhere(all, "a box that just fits needs no more than the floor holds", function(world)
  local box = slot(world, 0.5)
  world:run(0.2)
  expect(box:can_move { along = { 1, 0, 0 } }.needs / (36 * 0.5 * g)):near(1, 2e-3)
end)

for _, n in ipairs { 1, 4 } do
  everywhere(all, ("a book in a row of %d needs no more than the shelf holds"):format(n), function(world)
    local book = row(world, n)[(n + 1) // 2]
    world:run(0.2)
    expect(book:can_move { along = { 0, 0, 1 } }.needs / (1.68 * 0.4 * g)):near(1, 0.02)
  end)
end

everywhere(all, "a peg in a hole of its width is lifted by its weight", function(world)
  floor(world, 0.4)
  for side = -1, 1, 2 do
    world:box { fixed = true, size = { 0.2, 0.4, 0.5 }, at = { 0.15 * side, 0.2, 0 }, friction = 0.5 }
    world:box { fixed = true, size = { 0.08, 0.4, 0.2 }, at = { 0, 0.2, 0.15 * side }, friction = 0.5 }
  end
  local peg = world:box { size = { 0.1, 0.4, 0.1 }, mass = 3, at = { 0, 0.2, 0 }, friction = 0.5 }
  world:run(0.2)
  expect(peg:can_move { along = { 0, 1, 0 } }.needs / (3 * g)):near(1, 0.01)
  local moved, unit = push(world, peg, { 0, 3 * (g + 1), 0 }, 0.3)
  expect(moved.y / unit):near(1, 1e-3)
end)

everywhere(all, "a blow sends a box along the walls that it touches", function(world)
  local box = slot(world, 0.5)
  world:run(0.2)
  box:hit { impulse = { 72, 0, 0 } }
  world:run(0.8)
  expect(box.position.x / (4 / g)):near(1, 1e-3)
end)
