-- tests/hard/peers/selftest.lua - do the measures of module.c find what is there, and does the driver build what was described?
--
--   lua5.4 tests/hard/peers/selftest.lua build/hard/peers ode
--
-- Run before the hard cases: a judge that sees nothing would pass everything.
local folder, engine = arg[1], arg[2]
local here = arg[0]:match "^(.*)/" or "."
package.path = here .. "/?.lua;" .. package.path
package.cpath = folder .. "/?.so;" .. package.cpath
local digbox = require "shim"(require("peer_" .. engine))
local bad = 0

local function expect(what, got, want, off)
  if math.abs(got - want) <= (off or 1e-9) then return end
  bad = bad + 1
  print(("%s: %s is %.12g, not %.12g"):format(engine, what, got, want))
end

-- ---- measures of what was described: no engine is opened ----

local function corners(x, y, z)
  local list = {}
  for i = -1, 1, 2 do for j = -1, 1, 2 do for k = -1, 1, 2 do list[#list + 1] = { x * i, y * j, z * k } end end end
  return list
end

local function totals()
  local w = digbox.world {}
  w:box { size = { 0.2, 0.4, 0.6 }, density = 500, at = { 1, 2, 3 }, velocity = { 4, 0, 0 }, spin = { 0, 0, 6 } }
  local m, i = 24, 24 * (0.04 + 0.16) / 12
  expect("kinetic energy of a box", w.energy.kinetic, m * 16 / 2 + i * 36 / 2)
  expect("its potential energy", w.energy.potential, m * 9.81 * 2)
  expect("its momentum", w.momentum.x, m * 4)
  expect("its angular momentum", w.angular_momentum.z, 6 * i - m * 2 * 4)
  local v = digbox.world { gravity = { 0, 0, 0 } }
  local turn = digbox.quat { axis = { 1, 2, 3 }, angle = 0.7 }
  local at = turn:rotate { 0.3, 0.1, -0.2 }
  local points = corners(0.1, 0.2, 0.3)
  for _, p in ipairs(points) do p[1], p[2], p[3] = p[1] + 0.3, p[2] + 0.1, p[3] - 0.2 end
  local hull = v:hull { points = points, density = 500, rotation = turn, spin = turn:rotate { 0, 0, 6 } }
  expect("mass of a box as a hull", hull.mass, m)
  expect("its centre, off", #(hull.position - at), 0)
  expect("its kinetic energy", v.energy.kinetic, i * 36 / 2)
end

local function overlaps()
  local w = digbox.world {}
  w:floor {}
  w:box { size = 1, at = { 0, 0.49, 0 } }
  expect("a box in the floor", w:stats().penetration, 0.01)
  w:ball { radius = 0.5, at = { 0, 1.47, 0 } }
  expect("a ball in a box", w:stats().penetration, 0.02)
  local v = digbox.world {}
  v:floor {}
  v:cylinder { radius = 0.3, height = 0.8, at = { 0, 0.4, 0 }, rotation = digbox.quat { axis = { 0, 0, 1 }, angle = math.rad(30) } }
  expect("a leaning cylinder in the floor", v:stats().penetration, 0.4 * math.cos(math.rad(30)) + 0.15 - 0.4)
end

local function joints()
  local w = digbox.world { gravity = { 0, 0, 0 } }
  local a = w:box { size = 1, mass = 1, at = { 0.5, 0, 0 } }
  local j = w:hinge { a = a, at = { 0, 0, 0 }, axis = { 0, 0, 1 } }
  w:spring { a = a, at_b = { 0.5, 3, 0 }, length = 1, stiffness = 8 }
  expect("gap of a joint", j.error, 0)
  expect("energy of a spring", w.energy.elastic, 16)
end

-- ---- what the engine makes of it; first-order integration, float, soft contacts: coarse bounds ----

local function falls()
  local w = digbox.world {}
  local turn = digbox.quat { axis = { 0, 1, 0 }, angle = 0.3 }
  local box = w:box { size = { 0.2, 0.4, 0.6 }, at = { 1, 2, 3 }, velocity = { 0.5, 4, -0.25 }, rotation = turn, spin = { 0, 2, 0 } }
  for _ = 1, 60 do w:step() end
  local p, x = box.position, box.rotation:rotate { 1, 0, 0 }
  expect("x of what falls", p.x, 1.5, 1e-4)
  expect("its height", p.y, 2 + 4 - 9.81 / 2, 0.1)
  expect("z of it", p.z, 2.75, 1e-4)
  expect("its speed", box.velocity.y, 4 - 9.81, 1e-3)
  expect("its turn", x.z, -math.sin(2.3), 1e-2)
  box:hit { impulse = { 0, 0, 48 * 3 } }
  w:step()
  expect("speed after a blow", box.velocity.z, 2.75, 1e-3)
end

local function rests()
  local w = digbox.world {}
  w:floor { friction = 0.5 }
  local disc = w:cylinder { radius = 0.3, height = 0.2, mass = 2, friction = 0.5, at = { 2, 0.1, 0 } }
  local cube = w:box { size = { 0.2, 0.4, 0.2 }, mass = 3, friction = 0.5, at = { 0, 0.2, 0 } }
  for _ = 1, 120 do w:step() end
  local up = 0
  for _, link in ipairs(cube:links()) do up = up + link.effort.y * (link.b == cube and 1 or -1) end
  expect("force on what rests", up, 3 * 9.81, 1)
  expect("height of what rests", cube.position.y, 0.2, 5e-3)
  expect("height of the disc", disc.position.y, 0.1, 5e-3)
end

local function hangs()
  local w = digbox.world {}
  local limit = math.rad(40)
  local a = w:box { size = { 1, 0.1, 0.1 }, mass = 1, at = { 0.5, 0, 0 } }
  local b = w:box { size = { 1, 0.1, 0.1 }, mass = 1, at = { 1.5, 0, 0 } }
  local first = w:hinge { a = a, at = { 0, 0, 0 }, axis = { 0, 0, 1 }, limits = { -limit, limit } }
  local second = w:hinge { a = b, b = a, at = { 1, 0, 0 }, axis = { 0, 0, 1 }, limits = { -limit, limit } }
  for _ = 1, 300 do w:step() end
  expect("angle at its limit, degrees", math.deg(first.angle), -40, 2)
  expect("angle of the second, degrees", math.deg(second.angle), -40, 2)
  expect("gap while it hangs", second.error, 0, 5e-3)
  local force = first.force
  if #force > 0 then expect("force of the hinge", math.abs(force.y), 2 * 9.81, 2) end
end

local function carries()
  local w = digbox.world {}
  local table = w:box { size = { 4, 0.2, 4 }, kinematic = true, friction = 1, at = { 0, -0.1, 0 } }
  local cube = w:box { size = 0.5, friction = 1, at = { 0, 0.25, 0 } }
  for _ = 1, 60 do
    table:drive { velocity = { 0.5, 0, 0 } }
    w:step()
  end
  expect("a table that is driven", table.position.x, 0.5, 1e-3)
  expect("what stands on it", cube.position.x, 0.5, 0.05)
  local disc = digbox.world {}
  local turning = disc:cylinder { radius = 2, height = 0.2, kinematic = true, friction = 1, at = { 0, -0.1, 0 } }
  local ball = disc:box { size = 0.2, friction = 1, at = { 1, 0.1, 0 } }
  for _ = 1, 60 do
    turning:drive { spin = { 0, 0.5, 0 } }
    disc:step()
  end
  expect("a disc that is driven", turning.rotation:rotate({ 1, 0, 0 }).z, -math.sin(0.5), 1e-3)
  expect("what stands on that", ball.position.z, -math.sin(0.5), 0.05)
end

-- A crank with a motor moves a piston that slides: a loop
local function runs()
  local w = digbox.world {}
  local crank = w:box { size = { 0.3, 0.06, 0.06 }, mass = 3, at = { 0.15, 1, 0 }, group = -1 }
  local rod = w:box { size = { 0.7, 0.05, 0.05 }, mass = 1.5, at = { 0.65, 1, 0 }, group = -1 }
  local piston = w:box { size = 0.2, mass = 2, at = { 1, 1, 0 }, group = -1 }
  w:hinge { a = crank, at = { 0, 1, 0 }, axis = { 0, 0, 1 }, motor = { speed = 10, max_torque = 50 } }
  w:hinge { a = rod, b = crank, at = { 0.3, 1, 0 }, axis = { 0, 0, 1 } }
  w:hinge { a = piston, b = rod, at = { 1, 1, 0 }, axis = { 0, 0, 1 } }
  w:slider { a = piston, along = { 1, 0, 0 } }
  local turned, low, high, off = 0, 1, 1, 0
  for _ = 1, 120 do
    w:step()
    local p = piston.position
    turned, low, high = turned + math.abs(crank.spin.z) / 60, math.min(low, p.x), math.max(high, p.x)
    off = math.max(off, math.abs(p.y - 1), math.abs(p.z))
  end
  expect("way of a crank in 2 s, rad", turned, 20, 2)
  expect("how far in its piston goes", low, 0.4, 0.05)
  expect("how far out", high, 1, 0.05)
  expect("the piston off its line", off, 0, 0.01)
end

for _, test in ipairs { totals, overlaps, joints, falls, rests, hangs, carries, runs } do test() end
os.exit(bad == 0)
