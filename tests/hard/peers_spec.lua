-- tests/hard/peers_spec.lua - the world that hard cases are given on other engines, and the verdict on them: on an engine written here.
--
-- Drivers and measures are tested with the engines themselves, by `make hard-peers`.
local digbox = require "digbox"
local test = require "digbox.test"
local hard = require "hard"
local shim = require "peers.shim"
local judge = require "peers.judge"

-- ---- an engine without forces: move(state, step) may spoil the motion ----

local Core = {}
Core.__index = Core
function Core:body(b)
  local s = {}
  for _, part in ipairs { b.at, b.turn, b.v, b.spin } do table.move(part, 1, #part, #s + 1, s) end
  self.states[#self.states + 1] = s
  return #self.states - 1, b.mass
end
function Core:state(i) return table.unpack(self.states[i + 1]) end
function Core.totals() return 0, 0, 0, 0, 0, 0, 0, 0, 0 end
function Core.penetration() return 0 end
function Core.open() end
function Core.close() end
function Core:step()
  for _, s in ipairs(self.states) do
    for k = 1, 3 do s[k] = s[k] + s[7 + k] * self.dt end
    self.move(s, self.dt)
  end
end

local function engine(move)
  return { world = function(dt) return setmetatable({ dt = dt, move = move, states = {} }, Core) end }
end

-- A hard case as it is, on that engine
local function on(move, id)
  hard.digbox = shim(engine(move))
  local row = hard.run(hard.cases { id }[1], { seconds = 1, repeats = false })
  hard.digbox = digbox
  return judge(hard, row, "ode"), row
end

test.scenario("a case on another engine gets the verdict it deserves", function()
  test.expect(on(function() end, "B18a")):is "pass"
  local verdict, row = on(function(s) s[8] = s[8] * (1 - 1e-7) end, "B18a")
  test.expect(verdict):is "fail"
  test.expect(row.worst.name):is "speed off 3 m/s, relative"
  test.expect(on(function(s) s[2] = 0 / 0 end, "B18a")):is "fail"                 -- lost, though no criterion looks at it
  test.expect(on(function() end, "B18b")):is "pass"
  test.expect(on(function(s, dt) s[1] = s[1] + 2e-3 * dt end, "B18b")):is "fail"
end)

-- B12b's angles are texts with a unit: for months it could not be built there, and the report called that a case they have no call for
test.scenario("every case can be built for another engine", function()
  Core.joint = function() return 0 end
  Core.joint_state = function() return 0, 0 end
  Core.drive = function() end
  hard.digbox = shim(engine(function() end))
  local cannot = {}
  for _, case in ipairs(hard.cases()) do
    local ok, why = pcall(function() case.build(hard.place(hard.open(case.world, 1 / 60)), hard.digbox) end)
    if not ok then cannot[#cannot + 1] = case.id .. ": " .. tostring(why) end
  end
  hard.digbox = digbox
  test.expect(table.concat(cannot, "; ")):is ""
end)

test.scenario("criteria on what only digbox tells are left out", function()
  local list = { hard.most("events more or less", 3, 0) }
  test.expect(judge(hard, { criteria = list, always = {}, traced = 0, conserved = 0, swept = 0 }, "ode")):is "none"
  list[2] = hard.most("force of a hinge / weight", 11, 10)
  test.expect(judge(hard, { criteria = list, always = {}, traced = 0, conserved = 0, swept = 0 }, "mujoco")):is "none"
  test.expect(judge(hard, { criteria = list, always = {}, traced = 0, conserved = 0, swept = 0 }, "ode")):is "fail"
end)

test.scenario("vectors and quaternions are as digbox has them", function()
  local other = shim(engine(function() end))
  for k = 1, 20 do
    local axis, angle, v = { k, 3 - k, 0.5 * k }, 0.37 * k, { 1, -2, 0.3 * k }
    local p, q = digbox.quat { axis = axis, angle = angle }, other.quat { axis = axis, angle = angle }
    local a, b = (p * p):rotate(v), (q * q):rotate(v)
    test.expect(math.abs(a.x - b.x) + math.abs(a.y - b.y) + math.abs(a.z - b.z)):below(1e-12)
    test.expect(math.abs(#(a - v) - #(b - v))):below(1e-12)
    test.expect(math.abs(digbox.vec(v):dot(a) - other.vec(v):dot(b))):below(1e-12)
    test.expect((digbox.vec(v):normalized() * 2).y):near(((other.vec(v):normalized()) * 2).y, 1e-12)
  end
end)
