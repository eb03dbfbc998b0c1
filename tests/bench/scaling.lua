-- tests/bench/scaling.lua - what a step costs per body, pair, contact and joint: measured, fitted, and carried on to a million.
--
--   digbox run tests/bench/scaling.lua -q                  prints the part of docs/scaling.md that is measured
--   digbox run tests/bench/scaling.lua -q -- --large true  with piles of 16,000
local digbox = require "digbox"
local test = require "digbox.test"

local options = digbox.args {
  large = { default = false, help = "also a pile of 16,000 balls" },
  steps = { default = 48, help = "steps that are timed, of each scene" },
}

-- n places in a cube-like lattice of this pitch above the floor
local function lattice(n, pitch, wide, low)
  local side = wide or math.ceil(n ^ (1 / 3))
  local i = 0
  return function()
    if i == n then return end
    local x, z, y = i % side, i // side % side, i // (side * side)
    i = i + 1
    return digbox.vec((x - side / 2) * pitch + 0.01 * (y % 3), low + y * pitch, (z - side / 2) * pitch + 0.01 * (y % 2))
  end
end

local scenes = {}

function scenes.falling(world, n)
  for at in lattice(n, 2, nil, 100) do world:ball { radius = 0.25, at = at } end
end

function scenes.flat(world, n)
  world:floor { friction = 0.5 }
  for at in lattice(n, 1, math.ceil(n ^ 0.5), 0.25) do world:box { size = 0.5, at = at } end
end

-- In a square pit of 18 balls' width
function scenes.pile(world, n)
  world:floor { friction = 0.5 }
  for _, wall in ipairs { { 1, 0 }, { -1, 0 }, { 0, 1 }, { 0, -1 } } do
    world:plane { normal = { -wall[1], 0, -wall[2] }, offset = -4.6, friction = 0.5 }
  end
  for at in lattice(n, 0.505, 18, 0.25) do world:ball { radius = 0.25, at = at, friction = 0.5 } end
end

function scenes.towers(world, n)
  world:floor { friction = 0.5 }
  for at in lattice(n // 10, 1.5, math.ceil((n // 10) ^ 0.5), 0.25) do
    for k = 0, 9 do world:box { size = 0.5, at = at + digbox.vec(0, 0.5 * k, 0), friction = 0.5 } end
  end
end

function scenes.chains(world, n)
  for at in lattice(n // 20, 2, math.ceil((n // 20) ^ 0.5), 0) do
    local last
    for k = 1, 20 do
      local link = world:capsule { radius = 0.05, length = 0.3, at = at + digbox.vec(0.4 * k, 0, 0), group = -1,
                                   rotation = { axis = { 0, 0, 1 }, angle = math.pi / 2 } }
      world:ball_joint { a = link, b = last, at = at + digbox.vec(0.4 * k - 0.2, 0, 0) }
      last = link
    end
  end
end

local runs = {
  { "falling", 1000 }, { "falling", 8000 }, { "flat", 1000 }, { "flat", 8000 },
  { "pile", 1000 }, { "pile", 2000 }, { "pile", 4000 }, { "pile", 8000 },
  { "towers", 1000 }, { "towers", 8000 }, { "chains", 1000 }, { "chains", 4000 },
}
if options.large then runs[#runs + 1] = { "pile", 16000 } end

local function measure(s, name, n)
  local world = digbox.world { sleeping = false }
  scenes[name](world, n)
  for _ = 1, name == "pile" and 90 or 30 do world:step() end
  local before = s.cpu_seconds()
  for _ = 1, options.steps do world:step() end
  local us = (s.cpu_seconds() - before) / options.steps * 1e6
  local stats = world:stats()
  local row = { name = name, bodies = n, us = us, pairs = stats.pairs, contacts = stats.contacts, joints = stats.joints,
                bytes = stats.bytes, penetration = stats.penetration }
  world:close()
  return row
end

-- What a step has of each: bodies, pairs near each other, touching contacts, joints
local function counts(row) return { row.bodies, row.pairs, row.contacts, row.joints } end
local terms = { "body awake", "pair near each other", "contact", "joint" }

-- Least squares of the relative error with no cost below zero: coordinate descent
local function fit(rows)
  local cost = { 0, 0, 0, 0 }
  for _ = 1, 20000 do
    for k = 1, 4 do
      local top, bottom = 0, 0
      for _, row in ipairs(rows) do
        local x = counts(row)
        local rest = 1
        for m = 1, 4 do rest = rest - (m ~= k and cost[m] * x[m] / row.us or 0) end
        top = top + rest * x[k] / row.us
        bottom = bottom + (x[k] / row.us) ^ 2
      end
      cost[k] = bottom > 0 and math.max(0, top / bottom) or 0
    end
  end
  return cost
end

local function predict(cost, x)
  local us = 0
  for k = 1, 4 do us = us + cost[k] * x[k] end
  return us
end

local function print_table(rows, cost)
  print "| scene | bodies | pairs | contacts | joints | us a step | by the model | us a body | bytes a body | deepest, mm |"
  print "|---|---|---|---|---|---|---|---|---|---|"
  for _, row in ipairs(rows) do
    print(("| %s | %d | %d | %d | %d | %.0f | %.0f | %.2f | %.0f | %.2f |"):format(row.name, row.bodies, row.pairs, row.contacts,
      row.joints, row.us, predict(cost, counts(row)), row.us / row.bodies, row.bytes / row.bodies, 1e3 * row.penetration))
  end
end

test.scenario("scaling", function(s)
  local rows = {}
  for i, run in ipairs(runs) do rows[i] = measure(s, run[1], run[2]) end
  local cost = fit(rows)
  print_table(rows, cost)
  print ""
  for k, name in ipairs(terms) do print(("* %.0f ns a %s"):format(1e3 * cost[k], name)) end
  local last = rows[8]
  local share = { 1, last.pairs / last.bodies, last.contacts / last.bodies, 0 }
  local million = {}
  for k = 1, 4 do million[k] = 1e6 * share[k] end
  print(("\nA pile of a million balls, with as many pairs and contacts a ball as one of %d: %.1f s a step, %.1f GB."):format(last.bodies,
    predict(cost, million) / 1e6, last.bytes / last.bodies * 1e6 / 1e9))
  test.expect(#rows):above(0)
end)
