-- digbox/new.lua - the files of a new folder for `digbox new DIR`: a world, a spec for it, and what editors and luacheck want to know.

local core = ...

local world = [[
-- world.lua: a ball falls on a table.
--   digbox run world.lua                      a picture of the end in out/
--   digbox run world.lua -- --height "2 m"    from higher up
local digbox = require "digbox"

local opt = digbox.args {
  height = { default = 0.5, unit = "m", help = "drop height above the table top" },
}

local world = digbox.world { seed = 1 }      -- SI units, y up, gravity 9.81 m/s^2

world:floor { material = "tile" }
local top = world:box { name = "table", fixed = true, material = "oak", size = { 1.2, 0.04, 0.8 }, at = { 0, 0.74, 0 } }
local ball = world:ball { name = "ball", material = "rubber", radius = "4 cm", at = { 0, 0.8 + opt.height, 0 } }

world:sun { from = { 3, 6, 2 }, shadows = true }
world:camera { at = { 1.8, 1.6, 1.8 }, look_at = top, fov = "40 deg" }

ball:on("impact", { faster_than = "0.5 m/s" }, function(e)
  print(("t = %.3f s: %s hits %s at %.2f m/s"):format(e.time, e.self.name, e.other.name, e.speed))
end)

world:run "3 s"
print("rests at", ball.position, "touching", ball:neighbours())
]]

local spec = [[
-- world_spec.lua: what should hold in such a world.
--   digbox test
local test = require "digbox.test" ---@type digbox.test

test.scenario("a ball comes to rest on the table", function(s)
  local world = s.world
  world:floor {}
  local top = world:box { name = "table", fixed = true, material = "oak", size = { 1.2, 0.04, 0.8 }, at = { 0, 0.74, 0 } }
  local ball = world:ball { name = "ball", material = "steel", radius = "4 cm", at = { 0, 1.3, 0 } }

  s:eventually("the ball is asleep", "10 s", function() return ball.asleep end)
  test.expect(ball:touches(top)):is(true)
  test.expect(ball.position.y):near("0.8 m", "1 mm")
end)
]]

local luarc = [[
{
  "$schema": "https://raw.githubusercontent.com/LuaLS/vscode-lua/master/setting/schema.json",
  "runtime.version": "Lua 5.4",
  "workspace.library": ["digbox.d.lua"],
  "workspace.checkThirdParty": false
}
]]

local luacheckrc = [[
std = "lua54"
max_line_length = 140
exclude_files = { "digbox.d.lua", "out" }
files["*_spec.lua"] = { read_globals = { "digbox" } }
]]

-- core.new_files() -> list of {name, text}
function core.new_files()
  core.use "api"
  return { { "world.lua", world }, { "world_spec.lua", spec }, { ".luarc.json", luarc }, { ".luacheckrc", luacheckrc },
    { "digbox.d.lua", core.api_text "luacats" } }
end

return true
