-- digbox/fluid.lua - air and water: what bodies move through and float in.

local core = ...

local methods = core.types.world.methods

-- The same as world:effect(name, fields), whose rows it checks; errors name what the script called.
local function set(world, what, name, fields)
  if fields == nil then fields = {} end
  local ok, message = pcall(methods.effect, world, name, fields)
  if not ok then error(type(message) == "string" and message:gsub("world:effect%(.-%)", what, 1) or message, 0) end
end

core.declare("world:air", { "Every body feels the drag of air; world:air(false): none does.", with = { "effect drag" }, optional = true })
core.declare("world:water", {
  "Bodies float in it, by what their shapes displace: a hollow one by its walls alone; world:water(false): there is none.",
  with = { "effect buoyancy" }, optional = true })

-- world:air{ density =, wind = }: every body feels the drag of air; world:air(false): none does
function methods.air(world, fields)
  set(world, "world:air", "drag", fields)
end

-- world:water{ level =, density =, current =, damping =, at =, size = }: bodies float in it; world:water(false): there is none
function methods.water(world, fields)
  set(world, "world:water", "buoyancy", fields)
end
