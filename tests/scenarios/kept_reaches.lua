-- What lies is not looked at anew in each step: where it may get, and whom it may meet, is that of an earlier one, until it has moved
-- (engine/step/sense.c). A world that is loaded knows nothing of that and looks at all again, so one that is saved and loaded every few
-- frames goes the same way, to the last bit, if what was kept was right. Whatever may end that happens here to things that lie.
-- Only in the plain build: what is compared are bits; tests/unit/test_near.c and test_save.c run the same code under sanitizers.
local digbox = require "digbox"
local test = require "digbox.test"
local scenario, expect = test.scenario, test.expect

local file = "kept_reaches.dig"

local function lying()
  local world = digbox.world{sleeping = false}
  world:floor{}
  for i = 1, 12 do
    for k = 1, 5 do
      world:box{name = ("box %d %d"):format(i, k), size = {1, 1, 1}, at = {3 * i, k - 0.5, 0}}
    end
  end
  for i = 1, 40 do                                      -- and a heap, some of it nearly meeting
    world:sphere{name = "ball " .. i, radius = 0.2, at = {0.41 * (i % 5), 0.25 + 0.42 * (i // 10), 4 + 0.43 * (i // 5 % 2)}}
  end
  world:box{name = "shelf", size = {2, 0.1, 2}, at = {-4, 1, 0}, fixed = true}
  world:box{name = "book", size = {0.3, 0.05, 0.2}, at = {-4, 1.075, 0}}
  return world
end

-- Frame by frame; `act` does something at one of them. reload: so often the world is loaded anew.
local function run(frames, act, reload)
  local world = lying()
  for frame = 1, frames do
    if act then act(world, frame) end
    world:step()
    if reload and frame % reload == 0 then
      world:save(file)
      world = digbox.load(file)
    end
  end
  return world
end

local function at(wanted, act)
  return function(world, frame) if frame == wanted then act(world) end end
end

local acts = {
  ["nothing"] = function() end,
  ["gravity turns"] = at(60, function(w) w.gravity = { 3, -8, 0 } end),
  ["gravity turns round"] = at(60, function(w) w.gravity = { 0, 9.81, 0 } end),
  ["weight turns round"] = at(60, function(w) w:find("box 3 5").gravity_scale = -1 end),
  ["a push"] = at(60, function(w) w:find("box 5 5"):push{force = {40000, 0, 0}, lasts = 0.1} end),
  ["pushes that come and go"] = function(w, frame)
    if frame % 9 == 0 then w:find("box 5 1"):push{force = {2000, 0, 0}, lasts = 0.05} end
  end,
  ["a hit"] = at(60, function(w) w:find("box 7 3"):hit{impulse = {0, 0, 9000}} end),
  ["put elsewhere"] = at(60, function(w) w:find("box 2 5"):teleport{ at = { 6.9, 5.5, 0 } } end),
  ["put down just above"] = at(60, function(w) w:find("box 2 5"):teleport{ at = { -4.4, 1.5501, 0 } } end),
  ["a strong region comes"] = at(60, function(w)
    w:region{shape = digbox.box{size = {2, 2, 2}}, at = {-30, 3, 0}, laws = {gravity = {0, -200, 0}}}
  end),
  ["the shelf goes"] = at(60, function(w) w:find("shelf"):teleport{ at = { -4, 0.5, 0 } } end),
  ["the shelf is removed"] = at(60, function(w) w:find("shelf"):remove() end),
  ["a wall comes"] = at(60, function(w) w:plane{name = "wall", normal = {-1, 0, 0}, at = {36.505, 0, 0}, fixed = true} end),
  ["a box comes"] = at(60, function(w) w:box{name = "new", size = {1, 1, 1}, at = {9, 5.6, 0.3}} end),
  ["a bullet"] = at(60, function(w)
    w:sphere{name = "bullet", radius = 0.05, material = "steel", at = {-1, 2.5, 0}, velocity = {300, 0, 0}}
  end),
  ["a piston"] = at(40, function(w)
    w:box{name = "piston", size = {0.2, 1, 1}, at = {1, 0.55, 0}, kinematic = true, velocity = {1, 0, 0}}
  end),
}

for name, act in pairs(acts) do
  scenario("what is kept of who lies changes nothing: " .. name, function()
    local kept, anew = run(120, act), run(120, act, 3)
    expect(anew:checksum()):is(kept:checksum())
  end)
end
