-- ledger_spec.lua: the books of energy of every world: what came in is stored, lost, or the integration's own error, and that
-- error has its own figure. Each world is run as it stands and with the accuracy "study".
--
--   initial + work_in + law = total + lost - numerical
--
-- At "study" that figure itself may be a millionth of the energy moved. The exceptions are listed with the reason.
-- Only in the plain build: figures; the worlds run under sanitizers from other tests.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local traced = 1e-6
local worlds = {                            -- world, largest part of the energy moved that "study" may make up or lose
  { "01_drop", traced }, { "02_slope", traced }, { "03_rolling", traced }, { "04_collision", traced }, { "05_cradle", traced },
  { "06_pendulum", traced }, { "07_spinning_box", traced },
  { "08_tipping", traced },
  { "09_stack", traced },
  { "10_arch", traced },
  { "11_gears", traced }, { "12_spring", traced }, { "13_room", traced }, { "14_three_spheres", traced },
  { "15_landscape", traced },               -- swept, for height fields are: balls that meet the next triangle slowly are located
  { "16_integrators", 0.1 },                -- shows what simpler rules make up: Euler's 4 % at a step of 1/15 s
  { "mirror_room", traced }, { "floating_crate", traced }, { "hot_iron", traced },
  { "bridge" },                             -- at "study" left out here: two minutes a train. The light one: 3.5e-7, measured 2026-11-22
  { "sawn_plank", traced },
  { "orbit", traced }, { "everything", traced }, { "lava_lamp", traced },
  { "bolted_door", traced }, { "cog_board", traced },
  { "ball_table_bucket", traced },
}

-- Runs the world with the accuracy, and returns all the worlds that it opened. jolt: does something to what the world's spec builds.
local function run(name, accuracy, jolt)
  local made, open = {}, digbox.world
  digbox.world = function(fields)
    local asked = {}
    for key, value in pairs(fields or {}) do asked[key] = value end
    asked.accuracy = accuracy or asked.accuracy
    made[#made + 1] = open(asked)
    return made[#made]
  end
  local ok, scene = pcall(require, name)
  if ok and type(scene) == "table" and scene.build then       -- one that its spec builds and runs
    local world = digbox.world {}
    local built = scene.build(world)
    if jolt then jolt(built) end
    scene.act(built)
    world:run "12 s"
  end
  digbox.world = open
  if not ok then error(scene, 0) end
  return made
end

-- What the bodies, springs and effects have, J, added up here.
local function stored(world)
  local sum, e = 0, world.energy
  for _, body in ipairs(world:bodies()) do
    if body.kind == "dynamic" then sum = sum + body.energy end
  end
  return sum + e.elastic + e.heat + e.electric
end

local function check(world, bound)
  local e = world.energy
  local moved = math.max(1, e.lost, math.abs(e.work_in), math.abs(e.law), e.kinetic)
  if not world:effects().buoyancy.on then                 -- water has a potential of its own
    expect(e.total):near(stored(world), 1e-9 * math.max(1, math.abs(e.total)))
  end
  expect(e.initial + e.work_in + e.law):near(e.total + e.lost - e.numerical, 1e-9 * math.max(moved, math.abs(e.total)))
  expect(e.lost):at_least(-1e-9 * moved)
  if bound then expect(math.abs(e.numerical) / moved):at_most(bound) end
  return math.abs(e.numerical) / moved
end

for _, row in ipairs(worlds) do
  local name, bound = table.unpack(row)
  scenario(name .. " keeps its books as it stands", function()
    for _, world in ipairs(run(name)) do check(world) end
  end)
  if bound then
    scenario(name .. " closes its books at study", function()
      for _, world in ipairs(run(name, "study")) do check(world, bound) end
    end)
  end
end

-- From 7 s on the bucket is pulled up, bangs against table and rod, and its steps are often swept. What is made up there hangs on the
-- last digits of the start: of 30 such starts none made up more than 4.0e-7 on 2026-11-26 (4.8e-5 before such sweeps were finer), the
-- median 3.7e-8.
scenario("ball_table_bucket closes its books at study from starts a little apart", function()
  for _, part in ipairs { 2, 19 } do
    local jolt = function(s) s.ball:hit { impulse = { part * 1e-13, 0, 0 } } end
    for _, world in ipairs(run("ball_table_bucket", "study", jolt)) do check(world, 5e-6) end
  end
end)
