#!/usr/bin/env bash
# tests/cli/aside.sh - a body whose numbers are not finite any more is set aside, and the others do what they would have done without
# it (A13). The number comes from --inject.
set -u
. "${0%/*}/../check.sh"

# 40 balls that fall on each other, some joined. --by 1: the script disables the seventh itself, at the moment of the fault.
cat >balls.lua <<'LUA'
local digbox = require "digbox"
local opt = digbox.args { by = { default = 0, help = "1: the script" }, joined = { default = 0, help = "1: with joints" } }
local world = digbox.world {}
world:floor { restitution = 0.3 }
local ball = {}
for i = 1, 40 do
  ball[i] = world:ball { radius = 0.2, mass = 1, at = { i % 5 * 0.41, 0.3 + i // 5 * 0.45, 0.01 * i } }
end
if opt.joined == 1 then
  world:ball_joint { a = ball[7], b = ball[8], at = ball[7].position }
  world:hinge { a = ball[7], b = ball[12], at = ball[12].position, axis = { 1, 0, 0 } }
end
world:on("disabled", function(e) print("disabled", e.self, e.time, world.steps) end)
while world.steps < 100 do
  if world.steps == 60 and opt.by == 1 then ball[7]:disable() end
  world:step()
end
print(world:checksum(), ball[7].mode, ball[7].velocity, #world:bodies(), #world:joints())
LUA
for joined in 0 1; do
    for accuracy in play $([ $joined = 1 ] && [ "${SANITIZE:-0}" = 0 ] && echo study); do
        gives 10 'a number that is none' run -q --accuracy $accuracy --inject nan:body=7,step=60 balls.lua -- --joined $joined
        said 'body #7, made at balls.lua:7, was set aside at t = 1 s'
        printed 'disabled	body #7	1.0	61'; printed 'fixed	(0, 0, 0)	41	0'
        holds 'one line' test "$(wc -l <err.txt)" = 1
        cp out.txt injected.txt
        gives 0 'disabled by the script' run -q --accuracy $accuracy balls.lua -- --joined $joined --by 1
        holds "the same bits ($accuracy, joined $joined)" cmp -s injected.txt out.txt
    done
done
gives 10 'what is said at once' run --inject nan:body=7,step=60 balls.lua
said "digbox: at t = 1 s effect 'state' gave body #7 a non-finite velocity; body #7, made at balls.lua:7, is set aside"
said '100 steps'
holds 'the run came to its end' test "$(grep -c stopped err.txt)" = 0
gives 10 'with 4 threads' run -q --threads 4 --accuracy $accuracy --inject nan:body=7,step=60 balls.lua -- --joined 1
holds 'the same bits with 4 threads' cmp -s injected.txt out.txt
gives 10 'traced' run -q --trace trace.json --inject nan:body=7,step=60 balls.lua

# Its replay holds the fault, and does the same again.
gives 10 'with a replay' run -q --replay balls.replay --inject nan:body=7,step=60 balls.lua -- --joined 1
gives 0 'the replay' verify balls.replay; printed '100 steps'

# The same where nobody looks between the steps, which are then taken in one go; and for a body that is pushed until it is too fast.
cat >run.lua <<'LUA'
local digbox = require "digbox"
local world = digbox.world { gravity = { 0, 0, 0 } }
local ball = {}
for i = 1, 5 do ball[i] = world:ball { radius = 0.2, mass = 1, at = { i, 1, 0 } } end
if digbox.args { push = { default = 0, help = "1: the third is pushed" } }.push == 1 then
  ball[3]:push { force = { 3e12, 0, 0 }, lasts = 10 }
end
world:run "2 s"
print(world.steps, ball[3].mode, ball[4].mode)
LUA
gives 10 'a run in one go' run -q --inject nan:body=2,step=60 run.lua;      printed '120	fixed	'; said 'body #2, made at run.lua:4, was set aside at t = 1 s'
gives 10 'too fast, in one go' run -q run.lua -- --push 1;                  printed '120	fixed	'; said 'body #2, made at run.lua:4, was set aside'

# A world that deals with it.
cat >deals.lua <<'LUA'
local digbox = require "digbox"
local world = digbox.world {}
world:floor {}
local ball = world:ball { name = "red", radius = 0.2, at = { 0, 1, 0 }, temperature = 300 }
ball:on("disabled", function(e) e.self:remove() return true end)
world:run(1)
print(ball.valid, world:stats().rejected, world.energy.total == world.energy.total)
LUA
gives 0 'a world that deals with it' run -q --inject nan:body=1,step=7 deals.lua; printed 'false	1	true'
gives 2 'a body that is not there' run -q --inject nan:body=9,step=7 deals.lua;   said 'there is no body #9 at step 7'
gives 2 'a step that does not come' run -q --inject nan:body=1,step=700 deals.lua; said 'no world took the step after step 700'
gives 1 'a body that cannot be pushed' run -q --inject nan:body=0,step=7 deals.lua; said 'is fixed'
for wrong in nan inf:body=1,step=1 nan:body=-1,step=1 nan:body=1 nan:body=1,step=1x nan:body=1,step=; do
    gives 2 "--inject $wrong" run --inject "$wrong" deals.lua;                      said 'is not nan:body=N,step=N'
done

checked
