-- tests/bench/tumble.lua: boxes that tumble into a heap, for `make bench SCENE=page` and SCENE=replay; nothing is drawn of them but one
-- small picture.
local digbox = require "digbox"
local options = digbox.args { n = { default = 200, help = "boxes" }, seconds = { default = 2, help = "s" } }
local world = digbox.world { seed = 1 }
local side = math.ceil((options.n / 8) ^ 0.5)

local function noise(i, k)          -- 0 to 1
  local x = math.sin(i * 12.9898 + k * 78.233) * 43758.5453
  return x - math.floor(x)
end

world:floor { material = "tile" }
for i = 0, options.n - 1 do
  world:box { name = "b" .. i, material = i % 2 == 0 and "oak" or "brick", size = { 0.2 + 0.1 * noise(i, 1), 0.2, 0.25 },
    at = { (i % side) * 0.5, 0.4 + (i // (side * side)) * 0.5, (i // side % side) * 0.5 },
    spin = { 3 * noise(i, 2), 2 * noise(i, 3), noise(i, 4) } }
end
world:camera { at = { 1.2 * side, 4, 1.4 * side }, look_at = { 0.25 * side, 1, 0.25 * side } }
world:record { to = "f-%05d.png", fps = 1e-3, size = { 16, 16 }, layer = "id", samples = 0 }:close()
if options.seconds > 0 then world:run { seconds = options.seconds } end
