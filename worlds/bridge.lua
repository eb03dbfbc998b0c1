-- bridge.lua: a train of three wagons crosses a bridge of struts bought on a budget; a heavier one brings it down.
--   Look at:   struts turn from green to red with their stress. Under 100 kN an axle the top chord snaps first, the bridge falls in two,
--              and the train with it.
--   Law:       axles as far apart as the nodes load each node of the deck with one axle, wherever they stand, and the middle of the top
--              chord bears 2.6667 axles (moments about node 2). The bridge's own weight adds 20.93 kN there.
--   Expected:  60 kN an axle: -180.9 kN in 6-7, 250 kN break it. 100 kN an axle would be -287.6 kN: 6-7 is the first to go.
--   digbox run worlds/bridge.lua -- --film
local digbox = require "digbox"
local opt = digbox.args {
  light = { default = 60e3, unit = "N", help = "load of an axle of the first train" },
  heavy = { default = 100e3, unit = "N", help = "of the second" },
  film = { default = false, help = "record films" },
}
local g, speed, deck, r = 9.81, 5, 0.2, 0.4

local function build_bridge(world)
  world:plane { name = "river", normal = { 0, 1, 0 }, offset = -5, material = "ice", colour = { 0.10, 0.22, 0.30 } }
  for name, x in pairs { ["left bank"] = -15.01, ["right bank"] = 31.03 } do       -- 1 cm and, for the roller, 3 cm from the deck
    world:box { name = name, fixed = true, material = "stone", size = { 30, 5 + deck / 2, 5 }, at = { x, -2.5 + deck / 4, 0 } }
  end
  local nodes = { ["0"] = { at = { 0, 0, 0 }, fixed = true }, ["4"] = { at = { 16, 0, 0 }, fixed = "y", mass = 200 } }
  for i, x in ipairs { 4, 8, 12 } do nodes[tostring(i)] = { at = { x, 0, 0 }, mass = 200 } end
  for i, x in ipairs { 2, 6, 10, 14 } do nodes[tostring(i + 4)] = { at = { x, 3, 0 }, mass = 200 } end
  local struts = {}
  for k in ("01 12 23 34 56 67 78 05 51 16 62 27 73 38 84"):gmatch "%d+" do
    struts[#struts + 1] = { k:sub(1, 1), k:sub(2, 2), deck = not k:match "[5-8]" }
  end
  return world:truss { name = "bridge", nodes = nodes, struts = struts, plane = "xy", material = "steel", stiffness = 2e8,
    breaks_at = 250e3, price = 100, budget = 1500, radius = 0.14,
    deck = { width = 3, thickness = deck, gap = 0, mass = 400, material = "wood" } }
end

-- Six axles, 4 m apart, on three wagons
local function build_train(world, axle)
  local train, wheel = {}, 200
  for i = 1, 3 do
    local x = -5 - 8 * (i - 1)
    local wagon = world:box { name = "wagon " .. i, material = "steel", mass = 2 * (axle / g - wheel), size = { 6.4, 1.2, 1.6 },
      at = { x, deck / 2 + r + 0.7, 0 }, velocity = { speed, 0, 0 }, colour = { 0.45, 0.06 + 0.08 * i, 0.05 } }
    world:guide { a = wagon, axis = { 0, 0, 1 }, keeps = "flat" }       -- rails
    for k, dx in ipairs { 2, -2 } do
      local w = world:cylinder { name = ("wheel %d.%d"):format(i, k), material = "iron", mass = wheel, radius = r, height = 1.7,
        at = { x + dx, deck / 2 + r, 0 }, rotation = digbox.quat { axis = { 1, 0, 0 }, angle = math.pi / 2 },
        velocity = { speed, 0, 0 }, spin = { 0, 0, -speed / r } }
      world:hinge { a = w, b = wagon, at = w.position, axis = { 0, 0, 1 } }
    end
    if i > 1 then
      local y = deck / 2 + r + 0.5
      world:distance { name = "coupling", breaks_at = 150e3, a = wagon, b = train[i - 1],
        at_a = { x + 3.2, y, 0 }, at_b = { x + 4.8, y, 0 } }
    end
    train[i] = wagon
  end
  return train
end

local function cross(axle, name)
  local world = digbox.world {}
  local bridge, train = build_bridge(world), build_train(world, axle)
  world:sun { from = { 2, 5, 4 }, shadows = true }
  local eye = world:camera { at = { 8, 5, 24 }, look_at = { 8, 0, 0 }, fov = "44 deg" }
  local film = opt.film and world:record { camera = eye, to = name .. "-%05d.png", fps = 30, overlay = { "stress" } }
  local seen = { sum = 0, count = 0, most = 0, splits = 0 }
  world:on("broken", function(e) if not seen.first then seen.first, seen.stress = e.joint.name, e.stress end end)
  world:on("split", function() seen.splits = seen.splits + (seen.first and 1 or 0) end)
  while world.time < 7 do
    local head = train[1].position.x + 2
    world:step()
    if head > 16.5 and head < 20 and not seen.first then                -- an axle in each bay, and beyond
      seen.sum, seen.count = seen.sum + bridge:force "67", seen.count + 1
    end
    seen.most = math.max(seen.most, bridge:stress())
  end
  if film then film:close() end
  seen.cost, seen.broken, seen.train = bridge.cost, bridge.broken, train[1].position
  seen.apart = #digbox.path(bridge:node "0", bridge:node "4", { kind = "joint" }) == 0
  return seen
end

local light, heavy = cross(opt.light, "bridge_light"), cross(opt.heavy, "bridge_heavy")
local own = g * (1300 * 8 - 600 * 4 - 200 * (6 + 2)) / 3                -- moments about node 2, of the reaction and what is left of it
local law = {
  { "price of the bridge", light.cost, 1500, 0 },
  { "60 kN: force in 6-7, kN", light.sum / light.count / 1e3, -(8 / 3 * opt.light + own) / 1e3, 1.8 },      -- 1 %
  { "60 kN: struts broken", light.broken, 0, 0 },
  { "60 kN: train beyond, m", light.train.x > 25 and 1 or 0, 1, 0 },
  { "100 kN: first to go", tonumber(heavy.first), 67, 0 },
  { "100 kN: its load over limit", heavy.stress, 1, 0.05 },
  { "100 kN: in two parts", heavy.apart and 1 or 0, 1, 0 },
  { "100 kN: train in the river", heavy.train.y < 0 and 1 or 0, 1, 0 },
}
for _, row in ipairs(law) do print(("%-28s measured %11.6f   expected %11.6f   +- %g"):format(table.unpack(row))) end
return law
