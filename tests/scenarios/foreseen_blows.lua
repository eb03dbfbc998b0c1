-- What happens within a frame, and how many evaluations of the equations of motion it takes to find that: contacts that let go, slips that
-- turn as they end, blows that can be foreseen.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

-- Two planks that lean on each other and slide apart: their edges part when the planks have got so fast that the load between them is gone.
local function planks(world, lean)
  local h, t = 1, 0.02
  local rise, foot = h * math.cos(lean) + t * math.sin(lean), h * math.sin(lean)
  local mu = 0.9 * math.tan(lean) / 2
  world:floor { friction = mu * mu / 2 }
  local list = {}
  for side = -1, 1, 2 do
    list[#list + 1] = world:box { size = { t, h, 0.7 }, mass = 0.1, friction = 2, rotation = { axis = { 0, 0, 1 }, angle = side * lean },
                                  at = { side * (foot / 2 + t / 2 * math.cos(lean)), rise / 2, 0 } }
  end
  return list
end

scenario("where the last of a contact's force goes, its friction does not yield first", function(s)
  for _, lean in ipairs { 20, 25, 30, 35 } do
    local world = s:world {}
    local pair = planks(world, math.rad(lean))
    local most = 0
    for _ = 1, 180 do
      world:step()
      expect(world:stats().gave_up, ("steps given up, planks at %d degrees"):format(lean)):is(0)
      most = math.max(most, world:stats().evaluations)
    end
    expect(most, "evaluations of the dearest frame"):below(60)           -- 211 to 400, and then it was swept
    expect(pair[2].position.x - pair[1].position.x):above(1)
    expect(world.energy.numerical):near(0, 1e-6)
  end
end)

-- A table that turns at 1 rad/s, and a ball on it
local function turning_table(world, at)
  local disc = world:cylinder { radius = 2, height = 0.1, kinematic = true, friction = 1, at = { 0, -0.05, 0 }, spin = { 0, 1, 0 } }
  disc:drive { spin = { 0, 1, 0 } }
  return world:ball { radius = 0.1, friction = 1, at = { at, 0.1, 0 } }
end

-- What drags a slip aside turns it the faster the slower it gets: steps over its end were refused one after the other.
scenario("a ball that is let down on a turning table rolls before the first frame is over", function(s)
  for _, at in ipairs { 0.2, 0.5, 0.8 } do
    local world, fine = s:world {}, digbox.world { accuracy = "reference" }
    local ball, other = turning_table(world, at), turning_table(fine, at)
    world:step(2)
    fine:step(2)
    expect(world:stats().traced):is(1)
    expect(ball.velocity):near(other.velocity, 1e-7)
  end
  local world = s:world {}
  turning_table(world, 0.5)
  world:step()
  expect(world:stats().evaluations):below(100)                            -- 155
end)

local function rocker(world)
  local turn = digbox.quat { axis = { 0, 0, 1 }, angle = 0.1 }
  local corner = turn:rotate { -0.25, -0.5, 0 }
  world:floor { friction = 2 }
  return world:box { size = { 0.5, 1, 0.5 }, friction = 2, rotation = turn, at = { -corner.x, -corner.y, 0 } }
end

-- Each blow leaves it a part of its spin (Housner 1963), and it rocks on until it is flat: 22 blows in one frame. A step to the end of the
-- frame over each of them, and each blow's step made anew, took 309 evaluations.
scenario("a block that rocks is struck where it was foreseen", function(s)
  local world, fine = s:world {}, digbox.world { accuracy = "reference" }
  local block, other = rocker(world), rocker(fine)
  local all, most = 0, 0
  for _ = 1, 100 do
    world:step()
    fine:step()
    local stats = world:stats()
    all, most = all + stats.evaluations, math.max(most, stats.evaluations)
    expect(block.position):near(other.position, 1e-8)
    expect(block.spin):near(other.spin, 1e-6)
    expect(world.energy.numerical):near(0, 1e-6)
  end
  expect(most, "evaluations of the dearest frame"):below(120)
  expect(all, "evaluations"):below(720)                                   -- 952
  expect(block.position):near({ block.position.x, 0.5, 0 }, 1e-9)
end)
