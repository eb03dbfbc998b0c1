-- The example scenario of the founding document (row 92): who belongs to which DIG at every stage.
local test = require "digbox.test"
local digbox = require "digbox"
local scene = require "ball_table_bucket"
local scenario, expect = test.scenario, test.expect

-- The sets, whatever their order and the order of names in them.
local function sets(world)
  local all = {}
  for _, dig in ipairs(world:digs()) do
    local names = {}
    for _, member in ipairs(dig:members()) do names[#names + 1] = member.name end
    table.sort(names)
    all[#all + 1] = "{" .. table.concat(names, ",") .. "}"
  end
  table.sort(all)
  return table.concat(all, " ")
end

-- Runs to a time and returns how often the DIGs changed on the way.
local function run_to(world, time)
  local changes, last = 0, sets(world)
  while world.time < time - 1e-9 do
    world:step()
    local now = sets(world)
    if now ~= last then changes = changes + 1 end
    last = now
  end
  return changes
end

-- Runs on until the sets are these; the time it took, or nil.
local function wait_for(world, wanted, seconds)
  local until_time = world.time + seconds
  while world.time < until_time do
    world:step()
    if sets(world) == wanted then return world.time end
  end
end

local function play(world)
  local s = scene.build(world)
  scene.act(s)

  -- i to iv: apart at first; the ball bounces on the table, which stands still
  expect(sets(world)):is "{ball} {bucket,handle} {rod} {table}"
  local bounces = 0
  s.ball:on("contact_begin", { with = s.table }, function() bounces = bounces + 1 end)
  -- v: at rest it joins the table: one change of membership, none per bounce
  expect(run_to(world, scene.pull.at - 0.1)):is(1)
  expect(bounces):at_least(3)
  expect(sets(world)):is "{ball,table} {bucket,handle} {rod}"
  expect(s.ball.mode):is "resting"

  -- vi: the table is pulled gently; the ball stays where it is on the table
  local place = s.ball.position.x - s.table.position.x
  expect(run_to(world, scene.stop.at)):is(0)
  expect(s.table.velocity.x):above(1)
  expect(math.abs(s.ball.position.x - s.table.position.x - place)):below(1e-3)

  -- vii: it is stopped; the ball rolls off. viii: into the bucket
  local left = wait_for(world, "{ball} {bucket,handle} {rod} {table}", 1)
  expect(left ~= nil):is(true)
  expect(s.ball.spin.z):below(-5)                             -- it rolled, it did not slide
  run_to(world, scene.lift.at - 0.1)
  expect(sets(world)):is "{ball,bucket,handle} {rod} {table}"
  expect(s.bucket:contains(s.ball)):is(true)
  expect(s.bucket.position.y):near(0, 1e-3)

  -- ix: the handle is pulled up, swings to the vertical, and the bucket lifts. x: its rim meets the rod
  local met = wait_for(world, "{ball,bucket,handle,rod} {table}", 2)
  expect(met ~= nil):is(true)
  expect(s.bucket.position.y):above(0.3)

  -- xi: it tips and the ball rolls out. xii: on to the table; the bucket swings out and hangs
  local out = wait_for(world, "{ball,table} {bucket,handle} {rod}", 4)
  expect(out ~= nil):is(true)
  run_to(world, 16)
  expect(sets(world)):is "{ball,table} {bucket,handle} {rod}"
  expect(s.ball:touches(s.table)):is(true)
  expect(s.ball.speed):below "1 mm/s"
  expect(s.bucket.speed):below "1 mm/s"
  local up = s.bucket.rotation:rotate(digbox.vec(0, 1, 0))
  expect(up.y):above(0.99)                                    -- upright again
end

scenario("row 92: ball, table, bucket and rod, steps i to xii", function(s)
  play(s.world)
end)
