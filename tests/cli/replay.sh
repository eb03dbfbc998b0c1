#!/usr/bin/env bash
# tests/cli/replay.sh - digbox run --replay: a file that is whole whatever becomes of the run; digbox diff: where two of them part.
set -u
. "${0%/*}/../check.sh"

cat >fall.lua <<'LUA'
local digbox = require "digbox"
local opt = digbox.args { nudge = { default = 0, unit = "m" } }
local world = digbox.world {}
world:floor {}
world:ball { name = "ball", radius = 0.1, at = { opt.nudge, 0.3, 0 }, velocity = { 0.2, 0, 0 } }
world:box { name = "box", size = 0.2, at = { 1, 0.1, 0 } }
world:camera { at = { 1, 1, 3 }, look_at = { 0, 0, 0 } }
world:spawn(function(task)
  task:wait "0.2 s"
  world:ball { name = "late", radius = 0.05, at = { 2, 1, 0 } }
end)
world:step(3)
world:run "0.5 s"
print(world.time)
LUA

gives 0 'a run without' run -q fall.lua
cp out.txt plain.txt
rm -rf out
gives 0 'a run with' run -q --replay a.replay fall.lua
holds 'the script sees no difference' cmp out.txt plain.txt
holds 'no picture was made of it' test ! -e out/fall.png
gives 0 'the same again' run -q --replay b.replay fall.lua
holds 'gives the same bytes' cmp a.replay b.replay
gives 0 'on two threads' run -q --threads 2 --replay c.replay fall.lua
gives 0 'nothing differs' diff a.replay c.replay;                       printed 'the same to the last bit: 34 frames, 4 bodies'

# ---- where they part ----
gives 0 'from elsewhere' run -q --replay near.replay fall.lua -- --nudge 1e-6
gives 7 'a ball that began elsewhere' diff a.replay near.replay
printed "first difference after step 0 (frame 0, t = 0 s): body 'ball' by 1e-06 m and 0 rad"
gives 7 'quietly' diff -q a.replay near.replay
holds 'without a word' test ! -s out.txt
gives 0 'near enough' diff --tolerance '1 mm' a.replay near.replay;     printed 'the same to 0.001 m and rad: 34 frames'
sed 's/world:run "0.5 s"/world:run "0.1 s" world:find "box":teleport { at = { 1, 0.35, 0 } } world:run "0.4 s"/' fall.lua >other.lua
gives 0 'moved on the way' run -q --replay other.replay other.lua
gives 7 'they part there' diff a.replay other.replay
printed "first difference after step 9 (frame 9, t = 0.15 s): body 'box' by 0.25 m"
sed 's/world:run "0.5 s"/world:run "0.3 s"/' fall.lua >short.lua
gives 0 'a shorter run' run -q --replay short.replay short.lua
gives 7 'the same as far as it goes' diff a.replay short.replay;        printed 'the same up to frame 21, where short.replay ends; a.replay has 12 more'
sed '/late/d' fall.lua >alone.lua
gives 0 'without the late one' run -q --replay alone.replay alone.lua
gives 7 'a body too few' diff a.replay alone.replay;                    printed "body 'late' is in a.replay only"

# ---- runs that end badly ----
printf 'local world = require("digbox").world {}\nworld:ball { radius = 0.1 }\nworld:step(3)\nerror "enough"\n' >fails.lua
gives 1 'a script that fails' run -q --replay fails.replay fails.lua
gives 0 'leaves a whole replay' diff fails.replay fails.replay;         printed '4 frames, 1 body'
printf 'local world = require("digbox").world {}\nworld:ball { radius = 0.1 }\nworld:step(3)\nworld:close()\n' >closes.lua
gives 0 'a script that closes its world' run -q --replay closes.replay closes.lua
gives 0 'leaves a whole replay' diff fails.replay closes.replay;        printed '4 frames, 1 body'
printf 'local world = require("digbox").world {}\nworld:ball { radius = 0.1 }\n' >still.lua
gives 0 'a world that takes no step' run -q --replay still.replay still.lua
gives 0 'is kept as it is' diff still.replay still.replay;              printed '1 frame, 1 body'
printf 'local world = require("digbox").world {}\nworld:ball { radius = 0.1 }\nworld:run(1e6)\n' >long.lua
gives 5 'a run out of time' run -q --time-limit 0.5 --replay long.replay long.lua
gives 0 'leaves a whole replay' diff -q long.replay long.replay
holds 'that says nothing of an early end' test ! -s err.txt

# A stop in the middle of a step, inside a function of an effect: of the run till then nothing is lost.
cat >inside.lua <<'LUA'
local world = require("digbox").world {}
world:ball { radius = 0.1, at = { 0, 1, 0 } }
world:record { to = "f-%02d.png", fps = 60, size = { 16, 16 }, samples = 0 }
local n, heap = 0, {}
local function act() while n == 5 do if HEAP then heap[#heap + 1] = ("x"):rep(1000) .. #heap end end return 0 end
world:add_effect { name = "e", step = act, energy = ENERGY and act or nil }
for i = 1, 10 do n = i world:step() end
LUA
for limit in '4 --fuel 2000000' '5 --time-limit 2' '3 --memory-limit 60'; do
    code=${limit%% *}
    sed "s/HEAP/$([ $code = 3 ] && echo true || echo false)/; s/ENERGY/$([ $code = 5 ] && echo true || echo false)/" inside.lua >stops.lua
    gives $code "a stop inside an effect" run -o stops --force ${limit#* } --replay stops.replay stops.lua
    said 'digbox: stops.lua:5: '; lacks 'does not respond'
    gives 0 'leaves a whole replay' diff -q stops.replay stops.replay
    gives 0 'which does the same again' verify stops.replay stops;      printed 'stops.replay: 4 steps'; printed '5 frames of a film that was cut'
done

# ---- bad files ----
head -c 3000 a.replay >cut.replay
gives 8 'a file without a frame' diff a.replay cut.replay;              said 'cut.replay: file ends after 3000 bytes, before its first frame'
head -c "$(($(wc -c <a.replay) - 30))" a.replay >cut.replay
gives 0 'a file without its end' diff a.replay cut.replay;              said 'cut.replay ends early: its first 34 frames are compared'
gives 8 'a script is no replay' diff a.replay fall.lua;                 said 'fall.lua: this is not a replay of digbox'
holds 'and how one is made' grep -q 'digbox run WORLD.lua --replay FILE writes one' err.txt
printf '\001' | dd of=b.replay bs=1 seek=8 conv=notrunc 2>err.txt
gives 8 'a replay of another format' verify b.replay;                   said 'replay of format 1, but digbox'; said 'record it again'
gives 8 'no file' diff a.replay none.replay;                            said 'none.replay: cannot be read: No such file'
gives 9 'a folder that is not there' run -q --replay nowhere/a.replay fall.lua;    said 'nowhere/a.replay: the replay cannot be written'
holds 'which is said once' test "$(grep -c 'cannot be written' err.txt)" = 1
gives 9 'a full disk' run -q --replay /dev/full fall.lua;               said 'No space left on device'
gives 2 'one file' diff a.replay;                                       said 'which two?'
gives 2 'no tolerance' diff --tolerance much a.replay b.replay

checked
