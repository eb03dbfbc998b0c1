-- stack.lua: 600 frames of a stack of ten boxes; its instructions are counted by instructions.sh.
local digbox = require "digbox"
local world = digbox.world { sleeping = false }
world:floor {}
for i = 1, 10 do world:box { size = 0.2, at = { 0.01 * (i % 2), 0.2 * i - 0.1, 0 } } end
world:step(600)
