#!/usr/bin/env bash
# tests/cli/sweep.sh - one world with many arguments and seeds: the plan, tasks by themselves, the summary, failures, going on.
set -u
. "${0%/*}/../check.sh"

cat >fall.lua <<'LUA'
local digbox = require "digbox"
local opt = digbox.args { height = { default = 1, unit = "m" }, material = "steel" }
local world = digbox.world {}
world:floor {}
local ball = world:ball { radius = 0.1, at = { 0, opt.height + 0.1, 0 }, material = opt.material }
local hit
ball:on("impact", function(e) hit = hit or e.time end)
world:run { seconds = 2, stop_when = function() return hit end }
print("one line of the script")
return { hit = hit, what = 'a "quoted", text', seed = world.seed, ball = ball, fine = true }
LUA

gives 0 'one run' run -q --result r.json fall.lua
if command -v python3 >/dev/null; then
    holds 'its result is JSON' python3 -c "
import json; r = json.load(open('r.json')); v = r['values']
assert abs(v['hit'] - (2 / 9.81) ** .5) < 1e-9 and v['what'] == 'a \"quoted\", text' and v['fine'] is True and 'ball' not in v
assert len(r['checksum']) == 16 and abs(r['energy']['numerical']) < 1e-9"
fi

gives 0 'a sweep' sweep fall.lua --set 'height=50..100 cm/3' --set material=steel,oak --seeds 2 -o a -j 2
printed 'a/summary.csv: 12 of 12 tasks are done'
lacks 'one line of the script'
holds 'that is in its log' grep -q 'one line of the script' a/0/log.txt
holds 'no draft is left' test -z "$(find a -name '*.tmp')"
holds 'the head' test "$(head -n 1 a/summary.csv)" = \
    'index,seed,height,material,exit,steps,time,checksum,energy_total,energy_lost,energy_numerical,fine,hit,seed,what'
holds 'a row for each' test "$(wc -l <a/summary.csv)" = 13
holds 'the last row' grep -q '^11,2,100 cm,oak,0,.*,2,"a ""quoted"", text"$' a/summary.csv
holds 'the value in the middle' grep -q '^4,1,75 cm,steel,0,.*,true,0\.39103' a/summary.csv      # sqrt(2 * 0.75 / 9.81)

# The same by single tasks, in another order.
gives 0 'a plan' sweep fall.lua --set 'height=50..100 cm/3' --set material=steel,oak --seeds 2 -o b --engine print
printed 'seq 0 11 | xargs -P 1 -n 1'
gives 1 'nothing is done' merge b/plan.jsonl;       said 'task 0 is missing'; printed '0 of 12 tasks are done'
gives 0 'odd ones' task b/plan.jsonl --index 1 --stride 2
gives 0 'even ones' task b --index 0 --stride 2
gives 0 'a task that is done' task b/plan.jsonl --index 3
gives 0 'all' merge b
holds 'the same summary' cmp a/summary.csv b/summary.csv
mkdir b/7.tmp; rm -r b/7                            # as if it had been killed
gives 1 'one was killed' merge b;                   said 'task 7 is missing'
gives 0 'goes on' sweep fall.lua --set 'height=50..100 cm/3' --set material=steel,oak --seeds 2 -o b
holds 'the same summary again' cmp a/summary.csv b/summary.csv

gives 1 'some fail' sweep fall.lua --set material=steel,butter -o c
said 'task 1 failed with exit code 1:'; said "unknown material 'butter'"; printed '1 of 2 tasks are done'
gives 1 'alone, too' task c/plan.jsonl --index 1
gives 2 'another sweep there' sweep fall.lua --set material=steel,oak -o c;     said 'c/plan.jsonl is of another sweep'
echo '-- changed' >>fall.lua
gives 2 'a script that changed' task c/plan.jsonl --index 1;                    said 'fall.lua has changed since'
gives 0 'an option for all' sweep fall.lua --seeds 2 --seconds 0.1 -o d -- --height 2
holds 'was heeded' grep -q '^0,1,0,6,' d/summary.csv
gives 0 'an open seed' sweep fall.lua --set height=1 -o e
holds 'is the script'\''s' grep -q '^0,,1,0,' e/summary.csv
if ! command -v sbatch >/dev/null; then     # where it is, this would submit jobs
gives 11 'Slurm that is not here' sweep fall.lua --seeds 3 -o "f 1" --engine slurm -j 2
holds 'its scripts are' grep -qF "task 'f 1/plan.jsonl' --index \"\$SLURM_ARRAY_TASK_ID\"" "f 1/job.sh"
holds 'two at a time' grep -q 'array=0-2%2' "f 1/job.sh"
fi

# What would fail in every task is refused at once, and leaves nothing behind.
gives 2 'a misspelt argument' sweep fall.lua --set hieght=1..2/3 -o g
said "digbox: sweep: unknown argument 'hieght' (did you mean 'height'?)"
holds 'no task was begun, no plan is left' test ! -e g
gives 2 'a value of another kind' sweep fall.lua --set height=3kg,4kg -o g;    said "argument 'height' wants a length; '3kg' is a mass"
echo 'require "digbox".world {}:run(1)' >plain.lua
gives 2 'a world without arguments' sweep plain.lua --set height=1..2/3 -o g;  said 'sweep: this world declares no arguments (digbox.args); --set height'
mkdir g; echo mine >g/notes.txt
gives 2 'in a folder that is there' sweep fall.lua --set hieght=1..2/3 -o g --engine print
holds 'which keeps what is in it' test "$(ls g)" = notes.txt
rm -r g

# ---- Ctrl-C, in tasks and while the world is tried before them ----
cat >slow.lua <<'LUA'
local digbox = require "digbox"
local opt = digbox.args { builds = 0 }
while opt.builds > 0 do end
digbox.world {}:run "1e6 s"
LUA
# stopped WHAT FILE BUILDS: SIGINT once FILE is there.
stopped() {
    "$DIGBOX" sweep -q slow.lua --set "builds=$3" -j 2 --time-limit 20 -o g >out.txt 2>err.txt & child=$!
    for _ in $(seq 100); do [ -e "$2" ] && break; sleep 0.1; done
    sleep 0.5; kill -INT "$child"; wait "$child"; code=$?
    holds "Ctrl-C $1 ends with 130" test "$code" = 130
}
stopped 'while its first world is built' g/0.tmp/log.txt 1
holds 'which leaves nothing' test ! -e g
stopped 'in tasks' g/1.tmp/log.txt 0,-1
holds 'which leaves the plan and nothing done' test -e g/plan.jsonl -a ! -e g/0
rm -r g

gives 2 'nothing varied' sweep fall.lua -o g;                       said 'nothing is varied'
gives 2 'no folder' sweep fall.lua --seeds 2;                       said 'where to?'
gives 2 'a range without a number' sweep fall.lua --set height=1..2 -o g;      said 'A..B/N'
gives 2 'a range of words' sweep fall.lua --set height=low..high/3 -o g;       said "'low' is not a number"
gives 2 'two units' sweep fall.lua --set 'height=1 cm..1 m/3' -o g; said 'are in different units'
gives 2 'too many' sweep fall.lua --set height=1..2/2000 --set material=1..2/2000 -o g;   said 'more than 1000000 tasks'
gives 2 'twice' sweep fall.lua --set height=1 --set height=2 -o g;  said 'is given twice'
gives 2 'another engine' sweep fall.lua --seeds 2 --engine diesel -o g;        said "'diesel' is not local, slurm or print"
gives 1 'no world' sweep nowhere.lua --seeds 2 -o g;                said 'nowhere.lua: No such file'
gives 8 'no plan' merge nowhere;                                    said 'nowhere: No such file'
printf '{"index":0' >torn.jsonl
gives 8 'a torn plan' task torn.jsonl --index 0;                    said 'torn.jsonl: is no JSON of digbox sweep'
gives 8 'a plan of others' merge fall.lua
gives 2 'no index' task a/plan.jsonl;                               said 'which of the plan?'
gives 2 'an index beyond' task a/plan.jsonl --index 12;             said 'tasks 0 to 11'
checked
