#!/usr/bin/env bash
# tests/cli/verify.sh - digbox verify: every world of worlds/ and what scripts may do between steps, simulated again from its
# replay; files that are changed, cut or mixed.
set -u
worlds=$(cd "${0%/*}/../../worlds" && pwd)
. "${0%/*}/../check.sh"

# again NAME STEPS: a replay is simulated again, with the same checksums.
again() {
    gives 0 "$1, again" verify "$1.replay"
    printed 'every checksum the same'
    [ -z "$2" ] || printed ": $2 steps, "
}

# ---- all worlds; some complain that they were stopped early (exit code 1), which is no matter here ----
for path in "$worlds"/*.lua; do
    name=$(basename "$path" .lua)
    case $name in *_spec) continue ;; esac
    "$DIGBOX" run -q --seconds 2 --replay "$name.replay" "$path" >/dev/null 2>err.txt </dev/null
    holds "$name runs" test $? -le 1
    again "$name" ''
done
for name in orbit mirror_room everything; do
    "$DIGBOX" run -q --seconds 1 --threads 2 --replay "$name.replay" "$worlds/$name.lua" >/dev/null 2>&1 </dev/null
    again "$name" ''
done

# ---- what a script may do between steps ----
cat >acts.lua <<'LUA'
local digbox = require "digbox"
local world = digbox.world { seed = 3 }
world:floor { name = "floor" }
local balls = {}
for i = 1, 5 do balls[i] = world:ball { name = "b" .. i, radius = 0.1, at = { 0.3 * i, 0.5, 0 }, restitution = 0.4 } end
local early = world:snapshot()             -- before the replay begins
world:step(3)
local curl = world:add_effect {
  name = "curl", law = "F = k v x up",
  step = function(_, bodies)
    for _, b in ipairs(bodies) do b.force = math.random() * digbox.vec(b.velocity.z, 0, -b.velocity.x) end
  end,
}
local hits = 0
balls[1]:on("impact", function() hits = hits + 1; world:ball { radius = 0.05, at = { 0, 2 + hits, 0 } } end)
for i = 1, 60 do
  if i == 10 then balls[2]:push { force = { 0, 0, 5 }, lasts = 0.2 } end
  if i == 20 then balls[3]:remove() end
  if i == 25 then world.gravity = { 0.5, -9.81, 0 } end
  if i == 30 then
    local snap = world:snapshot()
    world:step(4)
    world:restore(snap)
  end
  if i == 35 then world:hinge { a = balls[1], b = balls[2], axis = { 0, 0, 1 } } end
  if i == 40 then curl:remove() end
  if i == 50 then world:restore(early) end
  pcall(world.ball, world, { radius = -1, at = { 0, 0, 0 } })
  balls[4]:send(balls[5], "hello", i)
  world:step()
end
print(world.time)
LUA
gives 0 'a script with a will of its own' run -q --replay acts.replay acts.lua
again acts 67
gives 0 'the same on two threads' run -q --threads 2 --replay threads.replay acts.lua
again threads 67

# ---- a world that was saved in the middle, with things that move, sleep and wait ----
cat >load.lua <<'LUA'
local digbox = require "digbox"
local first = digbox.world {}
first:floor {}
for i = 0, 3 do first:box { name = "box" .. i, size = 0.2, at = { 0, 0.1 + 0.2 * i, 0 } } end
first:ball { name = "ball", radius = 0.1, at = { 0.2, 3, 0 } }
first:find "ball":send(first:find "box0", "later", 1, { after = 1.5 })
for _ = 1, 70 do first:step() end
first:save "half.dig"
LUA
printf 'local world = require("digbox").load "out/half.dig"\nfor _ = 1, 120 do world:step() end\n' >half.lua
gives 0 'half a run' run -q load.lua
gives 0 'the other half' run -q --replay half.replay half.lua
again half 120

# ---- what is not the same ----
cat >bounce.lua <<'LUA'
local digbox = require "digbox"
local opt = digbox.args { restitution = { default = 0.5, help = "of the ball" } }
local world = digbox.world {}
world:floor {}
world:ball { name = "ball", radius = 0.1, at = { 0, 0.3, 0 }, restitution = opt.restitution }
world:run "1 s"
LUA
gives 0 'a ball' run -q --replay a.replay bounce.lua
gives 0 'that bounces higher' run -q --replay b.replay --set restitution=0.6 bounce.lua
at() { grep -abo "$2" "$1" | head -n 1 | cut -d: -f1; }
# The start of the second in the run of the first; without an index it is read from section to section.
begin=$(at a.replay STRT) end=$(at a.replay MESH) other=$(at b.replay STRT) other_end=$(at b.replay MESH)
{
    head -c "$begin" a.replay
    tail -c +$((other + 1)) b.replay | head -c $((other_end - other))
    tail -c +$((end + 1)) a.replay | head -c -24
} >mixed.replay
gives 7 'the run of another ball' verify mixed.replay
printed 'differs at frame'; printed 'the step led to another state'; printed 'checksum'
gives 8 'the worst of three' verify a.replay mixed.replay bounce.lua;   printed 'a.replay: 60 steps, 60 commands: every checksum the same'

# ---- what is no replay, or not a whole one ----
gives 0 'many steps' run -q --seconds 20 --replay long.replay "$worlds/06_pendulum.lua"
head -c $(($(stat -c %s long.replay) * 3 / 4)) long.replay >cut.replay
gives 0 'a file that ends early' verify cut.replay;     printed 'of a file that ends early: every checksum the same'
head -c 30 a.replay >stump.replay
gives 8 'a stump' verify stump.replay;                  said 'stump.replay'
gives 8 'a file that is not there' verify none.replay;  said 'none.replay'
gives 8 'a script' verify bounce.lua;                   said 'bounce.lua'
gives 2 'no file' verify;                               said 'which replays?'
gives 2 'an option' verify --fast a.replay
gives 0 'help' verify --help;                           printed 'every command that changed it'

checked
