-- isolation_spec.lua: effects do not feel each other. With any one switched off, what does not call for it is the same to the last
-- bit: each part in a world of its own, and all parts far apart in one world.
local digbox = require "digbox"
local test = require "digbox.test"
local parts = require "parts"
local expect = test.expect

local frames, far = 90, 100                     -- m between parts

-- What the part calls for when it is alone: name -> true. Effects of the script bear the name of the place.
local function alone(name, off)
  local world = digbox.world {}
  local bodies = parts.build[name](world, digbox.vec(0, 0, 0))
  if off then world:effect(off, false) end
  world:step(frames)
  local uses = {}
  for effect, e in pairs(world:effects()) do uses[effect] = e.calls > 0 or nil end
  local state = parts.state_of(bodies)
  world:close()
  return state, uses
end

local function together(off)
  local world, states, bodies = digbox.world {}, {}, {}
  for i, name in ipairs(parts.names) do bodies[name] = parts.build[name](world, digbox.vec(far * i, 0, 0)) end
  if off then world:effect(off, false) end
  world:step(frames)
  for name, list in pairs(bodies) do states[name] = parts.state_of(list) end
  world:close()
  return states
end

local function effect_names()
  local names = {}
  local world = digbox.world {}
  for name in pairs(world:effects()) do names[#names + 1] = name end
  table.sort(names)
  world:close()
  return names
end

test.scenario("alone: a scene that does not call for an effect is the same with it switched off", function()
  local checked = 0
  local names = effect_names()
  for _, name in ipairs(parts.names) do
    local on, uses = alone(name)
    for _, effect in ipairs(names) do
      if not uses[effect] then
        expect(alone(name, effect) == on and "same" or ("%s without %s"):format(name, effect)):is "same"
        checked = checked + 1
      end
    end
  end
  expect(checked):at_least(50)
end)

-- Which results may change: those of parts that call for the effect, and they do change where it acts at all.
test.scenario("together: with an effect off, only the parts that call for it change", function()
  local on, uses = together(), {}
  for _, name in ipairs(parts.names) do
    local _, used = alone(name)
    uses[name] = used
  end
  for _, effect in ipairs(effect_names()) do
    local off, changed, users = together(effect), 0, 0
    for _, name in ipairs(parts.names) do
      if uses[name][effect] then
        users = users + 1
        changed = changed + (off[name] ~= on[name] and 1 or 0)
      else
        expect(off[name] == on[name] and "same" or ("%s without %s"):format(name, effect)):is "same"
      end
    end
    expect(users > 0 and effect or "no part calls for " .. effect):is(effect)
    expect(changed > 0 and effect or "nothing changes without " .. effect):is(effect)
  end
end)
