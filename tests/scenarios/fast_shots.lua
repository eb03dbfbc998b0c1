-- fast_shots.lua: what is fast and small does not pass through what is thin, at any accuracy. In a step it goes farther than both are
-- thick: before, a marble of 1 cm missed another one of its size at 13 m/s, and passed a plate of 1 cm that stands askew at 16 m/s.
local digbox = require "digbox"
local test = require "digbox.test"
local expect = test.expect

local function turned(degrees) return digbox.quat { axis = { 0, 0, 1 }, angle = degrees .. " deg" } end
local tetrahedron = { { -0.1, -0.1, -0.1 }, { 0.1, -0.1, -0.1 }, { 0, 0.1, -0.1 }, { 0, 0, 0.1 } }

local targets = {
  { "a marble", function(w) return w:ball { radius = 0.01, at = { 10, 0, 0 } } end },
  { "a fixed ball", function(w) return w:ball { radius = 0.02, at = { 10, 0, 0 }, fixed = true } end },
  { "a plate askew", function(w) return w:box { size = { 0.01, 0.2, 0.2 }, at = { 10, 0, 0 }, rotation = turned(30) } end },
  { "a fixed plate askew", function(w)
    return w:box { size = { 0.01, 0.2, 0.2 }, at = { 10, 0, 0 }, rotation = turned(30), fixed = true }
  end },
  { "a cube on its corner", function(w)
    return w:box { size = 0.2, at = { 10, 0, 0 }, rotation = digbox.quat { from = { 1, 1, 1 }, to = { 1, 0, 0 } } }
  end },
  { "a cube that spins", function(w) return w:box { size = 0.2, at = { 10, 0, 0 }, spin = { 3, 5, 30 } } end },
  { "a tetrahedron", function(w) return w:hull { points = tetrahedron, at = { 10, 0, 0 } } end },
  { "a rod", function(w) return w:cylinder { radius = 0.02, height = 0.4, at = { 10, 0, 0 } } end },
  { "a coin askew", function(w) return w:cylinder { radius = 0.1, height = 0.01, at = { 10, 0, 0 }, rotation = turned(50) } end },
  { "a capsule", function(w) return w:capsule { radius = 0.02, length = 0.2, at = { 10, 0, 0 } } end },
}

for _, target in ipairs(targets) do
  test.each_accuracy("a shot does not miss " .. target[1], function(s, accuracy)
    for speed = 7, 107, 10 do
      local w = s:world { gravity = { 0, 0, 0 }, accuracy = accuracy }
      local shot = w:ball { radius = 0.01, mass = 1, at = { -10, 0.003, 0.002 }, velocity = { speed, 0, 0 }, restitution = 0.5 }
      local hits, aim = 0, target[2](w)
      shot:on("impact", { with = aim }, function(e)
        hits = hits + 1
        expect(e.time):between(19.7 / speed, 20 / speed)
      end)
      w:run(20.5 / speed)
      expect(hits):at_least(1)
    end
  end)
end

test.scenario("marbles that meet head on exchange their speeds", function(s)
  for speed = 5, 65, 5 do
    local w = s:world { gravity = { 0, 0, 0 } }
    local a = w:ball { radius = 0.01, mass = 0.01, at = { -0.5, 0, 0 }, velocity = { speed, 0, 0 }, restitution = 1 }
    local b = w:ball { radius = 0.01, mass = 0.01, at = { 0.5, 0, 0 }, restitution = 1 }
    w:run(1.2 / speed)
    expect(a.speed):below(1e-9)
    expect(b.velocity):near({ speed, 0, 0 }, 1e-9)
  end
end)
