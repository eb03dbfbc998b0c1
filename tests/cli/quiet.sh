#!/usr/bin/env bash
# tests/cli/quiet.sh - steps of a world that nobody looks at are taken by a shorter way (lua/digbox/run.lua): what is added between two
# of them is heeded from the next one on.
set -u
. "${0%/*}/../check.sh"

# world NAME: takes ten steps alone, then what standard input adds, then ten more
world() {
    {
        echo 'local digbox = require "digbox"'
        echo 'local world = digbox.world {}'
        echo 'world:floor {}'
        echo 'local ball = world:ball { name = "ball", radius = 0.1, at = { 0, 0.3, 0 } }'
        echo 'for _ = 1, 10 do world:step() end'
        cat
        echo 'for _ = 1, 10 do world:step() end'
    } >"$1.lua"
}

world handler <<'LUA'
ball:on("contact_begin", function(e) print(("met at step %d"):format(world.steps)) end)
LUA
gives 0 'a handler' run -q handler.lua
printed 'met at step 13'

world film <<'LUA'
world:record { to = "f-%02d.png", fps = 60, size = { 32, 18 }, samples = 0 }
LUA
gives 0 'a film' run -q -o film film.lua
holds 'it has its frames' test -e film/f-10.png

world task <<'LUA'
world:spawn(function(task)
  print("begun", pcall(world.step, world))
  task:wait(0.05)
  print(("waited until step %d"):format(world.steps))
end)
LUA
gives 0 'a task' run -q task.lua
printed 'cannot be called inside a task'
printed 'waited until step 13'

world region <<'LUA'
world:region { box = { size = { 9, 9, 9 } }, laws = { force = function(body) return { 0, 100 * body.mass, 0 } end } }
LUA
echo 'print("lifted: " .. tostring(ball.velocity.y > 5))' >>region.lua
gives 0 'a force of a region' run -q region.lua
printed 'lifted: true'

world effect <<'LUA'
local calls = 0
world:add_effect { name = "wind", step = function(effect, bodies, dt) calls = calls + 1 end }
LUA
echo 'print("called: " .. tostring(calls >= 10))' >>effect.lua
gives 0 'an effect' run -q effect.lua
printed 'called: true'

world own <<'LUA'
local before, calls = world:snapshot(), 0
ball:on("moved", function() calls = calls + 1 end)
for _ = 1, 5 do world:step() end
world:restore(before)
LUA
echo 'print(("moved: %d times, at step %d"):format(calls, world.steps))' >>own.lua
gives 0 'a world put back' run -q own.lua
printed 'moved: 6 times, at step 20'

world end <<'LUA'
LUA
echo 'print("step " .. world.steps)' >>end.lua
gives 0 'an end given by --seconds' run --seconds 0.25 end.lua
said "15 steps"

checked
