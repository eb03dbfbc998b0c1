-- 17_bridge.lua: a train of three wagons crosses a bridge of struts, bought on a budget.
--   Look at:   struts turn from green to red with their stress. With --axle 100e3 the top chord goes first, and the train falls.
--   Law:       evenly spaced axles load each node of the deck with one axle, wherever they stand: the chord 6-7 then bears 2.6667 axles.
--   Expected:  with 60 kN an axle -160 kN in 6-7 and 36.056 kN... in 5-1 (dead load added); struts of 250 kN bear 93.75 kN an axle.
--   digbox run worlds/17_bridge.lua -- --film --axle "100 kN"
local digbox = require "digbox"
local opt = digbox.args {
  axle = { default = 60e3, unit = "N", help = "load of one axle" },
  film = { default = false, help = "record a film" },
}
local g, speed, deck = 9.81, 5, 0.2

local world = digbox.world { sleeping = false }
world:plane { name = "river", normal = { 0, 1, 0 }, offset = -5, material = "ice" }
for side, x in pairs { [-1] = -15.01, [1] = 31.03 } do
  world:box { name = side < 0 and "left bank" or "right bank", fixed = true, material = "stone", size = { 30, 5 + deck / 2, 5 },
              at = { x, -2.5 + deck / 4, 0 } }
end

local nodes = { ["0"] = { at = { 0, 0, 0 }, fixed = true }, ["4"] = { at = { 16, 0, 0 }, fixed = "y", mass = 200 } }
for i, x in ipairs { 4, 8, 12 } do nodes[tostring(i)] = { at = { x, 0, 0 }, mass = 200 } end
for i, x in ipairs { 2, 6, 10, 14 } do nodes[tostring(i + 4)] = { at = { x, 3, 0 }, mass = 200 } end
local struts = {}
for k in ("01 12 23 34 56 67 78 05 51 16 62 27 73 38 84"):gmatch "%d+" do
  struts[#struts + 1] = { k:sub(1, 1), k:sub(2, 2), deck = k:match "[5-8]" == nil }
end
local bridge = world:truss { name = "bridge", nodes = nodes, struts = struts, plane = "xy", material = "steel", stiffness = 2e8,
  breaks_at = 250e3, price = 100, budget = 1500, radius = 0.12, deck = { width = 3, thickness = deck, gap = 0, mass = 400, material = "wood" } }

-- Six axles, 4 m apart
local train = {}
for i = 1, 3 do
  local mass, x, r = 2 * opt.axle / g, -3 - 8 * (i - 1), 0.4
  local wheel = 200
  local wagon = world:box { name = "wagon " .. i, material = "steel", mass = mass - 2 * wheel, size = { 6.4, 1.2, 1.6 },
    at = { x - 2, deck / 2 + r + 0.7, 0 }, velocity = { speed, 0, 0 }, colour = { 0.6, 0.1 * i, 0.1 } }
  world:guide { a = wagon, axis = { 0, 0, 1 }, keeps = "flat" }
  for k, dx in ipairs { 2, -2 } do
    local w = world:cylinder { name = ("wheel %d.%d"):format(i, k), material = "iron", mass = wheel, radius = r, height = 0.2,
      at = { x - 2 + dx, deck / 2 + r, 0 }, rotation = digbox.quat { axis = { 1, 0, 0 }, angle = math.pi / 2 }, velocity = { speed, 0, 0 },
      spin = { 0, 0, -speed / r } }
    world:hinge { a = w, b = wagon, at = w.position, axis = { 0, 0, 1 } }
  end
  if i > 1 then world:distance { a = wagon, b = train[i - 1], at_a = { x + 1.2, deck / 2 + r + 0.5, 0 }, at_b = { x + 2.8, deck / 2 + r + 0.5, 0 } } end
  train[i] = wagon
end

world:sun { from = { 2, 5, 4 }, shadows = true }
local eye = world:camera { at = { 8, 5, 26 }, look_at = { 8, 0.2, 0 }, fov = "44 deg" }
if opt.film then world:record { camera = eye, to = "17_bridge-%05d.png", fps = 30, overlay = { "stress" } } end

local first, sum, count, most = nil, { ["67"] = 0, ["51"] = 0 }, 0, 0
local ways = {}
world:on("broken", function(e) if not first then first = { name = e.joint.name, digs = #world:digs(), time = e.time } end end)
while world.time < 7.5 do
  world:step()
  local head = train[1].position.x + 2                  -- the first axle
  if head > 16.5 and head < 20 and not first then       -- axles at 1, 2, 3 and both ends
    for key in pairs(sum) do sum[key] = sum[key] + bridge:force(key) end
    count = count + 1
  end
  most = math.max(most, bridge:stress())
  local st=world:stats()
  if world.steps % 60 == 0 then print(world.time, head, train[1].position.y, bridge:stress(), bridge.broken, st.swept, st.conserved, st.traced, st.iterations, ("%.0f us"):format(st.us_advance or 0), st.residual, world.energy.numerical) end
end
for key in pairs(sum) do print(key, sum[key]/math.max(count,1)) end
print("most", most, first and first.name, first and first.time)
