-- tests/bench/page.lua: 200 boxes that tumble into a heap for 10 s, for `make bench SCENE=page`.
local digbox = require "digbox"
local world = digbox.world { seed = 1 }

local function noise(i, k)          -- 0 to 1
  local x = math.sin(i * 12.9898 + k * 78.233) * 43758.5453
  return x - math.floor(x)
end

world:floor { material = "tile" }
for i = 0, 199 do
  world:box { name = "b" .. i, material = i % 2 == 0 and "oak" or "brick", size = { 0.2 + 0.1 * noise(i, 1), 0.2, 0.25 },
    at = { (i % 5) * 0.5 - 1, 0.6 + (i // 25) * 0.6, (i // 5 % 5) * 0.5 - 1 }, spin = { 3 * noise(i, 2), 2 * noise(i, 3), noise(i, 4) } }
end
world:camera { at = { 5, 4, 6 }, look_at = { 0, 1, 0 } }
world:record { to = "f-%05d.png", fps = 1e-3, size = { 16, 16 } }:close()
world:run "10 s"
