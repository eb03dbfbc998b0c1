-- flush_panels.lua: what lies between fixed panels that are flush with each other and with it stays there, and can be taken out.
-- Only in the plain build: hundreds of runs; other scenes run the same code under sanitizers.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local g, mu = 9.81, 0.5
local plans = { "sketch", "play", "study", "reference" }
local clearances = { 0, 1e-9, 1e-6, 1e-4, 1e-3 }

local function about_y(degrees) return digbox.quat { axis = { 0, 1, 0 }, angle = math.rad(degrees) } end

-- Boxes of a scene that is turned about y
local function maker(world, degrees)
  local q = about_y(degrees)
  return function(size, at, mass)
    return world:box { fixed = mass == nil or nil, mass = mass, size = size, at = q:rotate(at), rotation = q, friction = mu }
  end, q
end

-- A peg of 0.1 by 0.4 by 0.1 m on a floor, between four planks that meet at its edges and rise so far over it
local function hole(put, clearance, rise)
  local h, tall = 0.05 + clearance, 0.4 + rise
  put({ 2, 1, 2 }, { 0, -0.5, 0 })
  for side = -1, 1, 2 do
    put({ 0.1, tall, 2 * h + 0.2 }, { side * (h + 0.05), tall / 2, 0 })
    put({ 2 * h, tall, 0.1 }, { 0, tall / 2, side * (h + 0.05) })
  end
  return { put({ 0.1, 0.4, 0.1 }, { 0, 0.2, 0 }, 3) }, { 0, 3 * (g + 1), 0 }
end

-- A drawer in a cabinet of five panels, open to z, that overlap by `laps`; it stands out by `rise`
local function cabinet(put, clearance, rise, laps)
  local w, h, o = 0.4 + 2 * clearance, 0.2 + 2 * clearance, 2 * (laps or 0)
  for side = -1, 1, 2 do
    put({ w + 0.04 + o, 0.02, 0.3 + o }, { 0, side * (h / 2 + 0.01), 0 })
    put({ 0.02, h + o, 0.3 + o }, { side * (w / 2 + 0.01), 0, 0 })
  end
  put({ w + 0.04, h + 0.04, 0.02 }, { 0, 0, -0.16 })
  return { put({ 0.4, 0.2, 0.3 + rise }, { 0, -clearance, rise / 2 }, 4) }, { 0, 0, 4 * (mu * g + 1) }
end

-- Eight boxes that fill a crate of five panels
local function crate(put, _, rise)
  put({ 0.7, 0.05, 0.5 }, { 0, -0.025, 0 })
  for side = -1, 1, 2 do
    put({ 0.05, 0.3 + rise, 0.4 }, { side * 0.325, 0.15 + rise / 2, 0 })
    put({ 0.7, 0.3 + rise, 0.05 }, { 0, 0.15 + rise / 2, side * 0.225 })
  end
  local boxes = {}
  for i = 0, 7 do
    local x, y, z = i % 2 - 0.5, i // 2 % 2 + 0.5, i // 4 - 0.5
    boxes[#boxes + 1] = put({ 0.3, 0.15, 0.2 }, { 0.3 * x, 0.15 * y, 0.2 * z }, 2)
  end
  return boxes
end

-- A brick in a wall of bricks, each row so far beside the one below; it stands out by `rise`
local function wall(put, clearance, rise, beside)
  for row = -1, 1 do
    for i = -2, 2 do
      if row ~= 0 or i ~= 0 then put({ 0.2, 0.1, 0.1 }, { 0.2 * i + (row == 0 and 0 or beside), 0.1 * row, 0 }) end
    end
  end
  local size = { 0.2 - 2 * clearance, 0.1 - 2 * clearance, 0.1 }
  return { put(size, { 0, -clearance, rise }, 3) }, { 0, 0, 3 * (mu * g + 1) }
end

-- At each plan and frame step, for each clearance, rise and turn: at rest nothing moves, and pushed it moves by 1 m/s^2, where there is so
-- much clearance
local function everywhere(name, build, more)
  for _, accuracy in ipairs(plans) do
    for _, rate in ipairs { 60, 30 } do
      scenario(("at %s and 1/%d s %s"):format(accuracy, rate, name), function(s)
        for _, clearance in ipairs(more.clearances or clearances) do
          for _, rise in ipairs(more.rises) do
            for _, degrees in ipairs { 0, 0.1, 13 } do
              local world = s:world { accuracy = accuracy, step = 1 / rate }
              local put, q = maker(world, degrees)
              local bodies, force = build(put, clearance, rise, more.option)
              local from = {}
              for i, body in ipairs(bodies) do from[i] = body.position end
              world:run(0.2)
              for i, body in ipairs(bodies) do expect(body.position):near(from[i], 1e-7) end
              expect(world.energy.numerical):near(0, 1e-6)
              if force and accuracy ~= "sketch" and clearance >= (more.loose or 0) then
                bodies[1]:push { force = q:rotate(force), lasts = 10 }
                world:run(0.2)
                local way = q:inverse():rotate(bodies[1].position - from[1])
                expect(way):near(digbox.vec(force) * (0.02 / digbox.vec(force):length()), 2e-5)
                expect(world.energy.numerical):near(0, 1e-5)
              end
            end
          end
        end
      end)
    end
  end
end

everywhere("a peg stays in a hole of four planks, and is lifted out", hole, { rises = { 0, 1e-4, -1e-4, -1e-3, 0.05 } })
everywhere("a drawer stays in a cabinet of five panels, and is pulled out", cabinet, { rises = { 0, 1e-3, -1e-3, 0.1 } })
everywhere("a drawer stays where panels overlap by 3 mm", cabinet, { rises = { 0, 0.1 }, option = 3e-3 })
everywhere("boxes stay in a crate that they fill", crate, { clearances = { 0 }, rises = { 0, -1e-4, -1e-2 } })
everywhere("a brick stays in a wall of bricks, and is pulled out", wall, { rises = { 0, 1e-4, -1e-3 }, option = 0, loose = 1e-4 })
everywhere("a brick stays in a bond of bricks, and is pulled out", wall, { rises = { 0, 1e-4, -1e-3 }, option = 0.1, loose = 1e-4 })

-- A wedge that stands with its edge in the inner corner of two blocks, and out of it by 0.2 mm
for _, accuracy in ipairs(plans) do
  scenario(("at %s what has an edge in an inner corner stays there"):format(accuracy), function(s)
    local world = s:world { accuracy = accuracy }
    local put = maker(world, 0)
    put({ 2, 1, 2 }, { 0, -0.5, 0 })
    put({ 0.2, 0.3, 0.6 }, { -0.1, 0.15, 0.1 })
    put({ 0.6, 0.3, 0.2 }, { 0.3, 0.15, -0.1 })
    local points = {}
    for _, y in ipairs { 0, 0.3002 } do
      for _, at in ipairs { { 0, 0 }, { 0.1, 0.03 }, { 0.03, 0.1 } } do points[#points + 1] = { at[1], y, at[2] } end
    end
    local wedge = world:hull { mass = 2, points = points, friction = mu }
    local from = wedge.position
    world:run(0.2)
    expect(wedge.position):near(from, 1e-6)
    wedge:push { force = { -20, 0, -20 }, lasts = 10 }
    world:run(0.2)
    expect(wedge.position):near(from, 1e-5)
    expect(world.energy.numerical):near(0, 1e-5)
  end)
end
