-- digbox/heat.lua - the air and heaters. Temperatures are fields of bodies (the effect "heat"); what is here only sets them.

local core = ...

local methods = core.types.world.methods

core.declare("world:ambient", { "The air, or water, that bodies cool to, by convection and radiation.", fields = {
  temperature = { "real K >=0", "at the height of the origin", need = true },
  gradient = { "real K/m", "by which it is warmer higher up; default 0" } }, gives = "world" })

-- world:ambient{temperature = 293.15, gradient = 0}: the air, or water, that bodies cool to, by convection and radiation; it may be
-- warmer higher up, K/m, or colder: temperature is that at the origin's height
function methods.ambient(world, fields)
  local own = core.check(fields, "world:ambient")
  if own.temperature == nil then core.fail("world:ambient: temperature is missing") end
  world:effect("heat", { ambient = own.temperature, gradient = own.gradient })
  return world
end

-- ---- heaters ----

-- What a heater knows, by the heater itself, so that all its fields can be checked.
local inside = setmetatable({}, { __mode = "k" })

local Heater = {}

-- A body may have several: each adds its share to the body's heating.
local function feed(heater, power)
  local h = inside[heater]
  h.body.heating = h.body.heating + power - h.fed
  h.fed = power
  return heater
end

-- heater:on(), heater:off(): with its power, or without
function Heater.on(heater) return feed(heater, inside[heater].power) end
function Heater.off(heater) return feed(heater, 0) end

local heater_fields = { on = { "any", "the body it heats", type = "body", need = true },
  power = { "real W", "how much; negative cools", need = true } }
core.declare("world:heater", { "Feeds power into a body, which thereby has a temperature.", fields = heater_fields, gives = "heater" })
local fields_of_heater = core.declare_type("heater", "Feeds power into a body.", Heater, {
  power = { "number", "how much when it is on", unit = "W", set = true }, body = { "body", "what it heats" },
  running = { "boolean", "it is on" } })
core.declare("heater:on", { "Heats.", gives = "heater" })
core.declare("heater:off", { "Stops.", gives = "heater" })

local function read(heater, key)
  local h = inside[heater]
  if key == "power" or key == "body" then return h[key] end
  if key == "running" then return h.body.valid and h.fed ~= 0 end
  if not Heater[key] then core.unknown("heater", "has no field or method", tostring(key), fields_of_heater, Heater) end
  return Heater[key]
end

local function write(heater, key, value)
  if key ~= "power" then core.fail("heater: only power can be assigned; got %s", tostring(key)) end
  local h = inside[heater]
  local running = h.fed ~= 0 or h.power == 0
  h.power = core.check({ power = value }, "heater", heater_fields).power
  if running then feed(heater, h.power) end
end

local kind = { __index = read, __newindex = write, __metatable = false, __name = "heater", __tostring = function() return "heater" end }

-- world:heater{on = body, power = 1500} -> heater: feeds power into a body, which thereby has a temperature
function methods.heater(world, fields)
  local own = core.check(fields, "world:heater")
  if core.type(own.on) ~= "body" then core.fail("world:heater.on wants a body; got %s", core.type(own.on)) end
  if own.power == nil then core.fail("world:heater: power is missing (in W; 0 for one that is to be set later)") end
  local heater = setmetatable({}, kind)
  inside[heater] = { world = world, body = own.on, power = own.power, fed = 0 }
  if not own.on.temperature then own.on.heating = 0 end
  return feed(heater, own.power)
end

-- ---- snapshots ----

-- A snapshot has the heating of bodies; with it goes each heater's share of that. Snapshot -> heater -> {power, fed}
local kept = setmetatable({}, { __mode = "k" })
local snapshot, restore = methods.snapshot, core.restore

function methods.snapshot(world)
  local snap, shares = snapshot(world), nil
  for heater, h in next, inside do
    if h.world == world then
      shares = shares or setmetatable({}, { __mode = "k" })
      shares[heater] = { power = h.power, fed = h.fed }
    end
  end
  kept[snap] = shares
  return snap
end

function core.restore(world, snap)
  restore(world, snap)
  local shares = kept[snap] or {}
  for heater, h in next, inside do
    if h.world == world then
      local share = shares[heater]
      h.power, h.fed = share and share.power or h.power, share and share.fed or 0       -- 0: made after the snapshot
    end
  end
end
