#!/usr/bin/env bash
# tests/cli/cost.sh - digbox cost: table, CSV, plot, closing sentence; chaotic, motionless, failing and endless worlds; wrong arguments.
set -u
. "${0%/*}/../check.sh"

# cell SETTING COLUMN: of out/cost.csv
cell() {
    awk -F, -v setting="$1" -v column="$2" 'NR == 1 { for (i = 1; i <= NF; i++) if ($i == column) k = i }
        $1 == setting { print $k }' out/cost.csv
}
# compares SETTING COLUMN OPERATOR NUMBER
compares() {
    local value
    value=$(cell "$1" "$2")
    holds "$2 of $1, '$value', is $3 $4" awk -v x="${value:-nan}" 'BEGIN { exit !(x '"$3 $4"') }'
}

# ---- help and usage ----
gives 0 'help' help cost;                                printed 'digbox cost WORLD.lua'; printed '--within'
cp out.txt help.txt
gives 0 'help by option' cost --help;                    holds 'is the same' cmp out.txt help.txt
gives 2 'no world' cost;                                 said 'cost: which world?'
gives 2 'two worlds' cost a.lua b.lua;                   said "'b.lua' is too many"
gives 2 'an unknown option' cost --frobnicate a.lua
gives 2 'accuracy is not to be chosen' cost --accuracy play a.lua
gives 2 'no length' cost --within '3 s' a.lua;           said '--within'
gives 2 'no budget' cost --budget 0 a.lua
gives 2 'set without =' cost --set height a.lua
gives 1 'a world that is not there' cost nowhere.lua;    said 'digbox: nowhere.lua: No such file'; holds 'and no run is said to have failed' test "$(grep -c 'CPU time' err.txt)" = 0

# ---- a world whose error is known to come from the integration alone: a pendulum ----
cat >pendulum.lua <<'LUA'
local digbox = require "digbox"
local opt = digbox.args { start = { default = "30 deg", unit = "rad" } }
local world = digbox.world {}
local bob = world:ball { radius = "5 cm", material = "steel", at = { math.sin(opt.start), -math.cos(opt.start), 0 } }
world:hinge { a = bob, at = { 0, 0, 0 }, axis = { 0, 0, 1 } }
world:record { to = "out/f-%05d.png", fps = 30 }:close()
world:run "0.5 s"
world:render { to = "out/end.png" }
print "of the script"
LUA
gives 0 'a pendulum' cost pendulum.lua --within 1mm
printed 'pendulum.lua: 0.5 s simulated, 30 frame steps of 0.01667 s, 1 moving body'
printed 'CPU ms per s'; printed 'where the time went'; printed 'Not chaotic'
printed 'cheapest setting that stays within 1 mm is'
lacks 'of the script'
said 'cost: sketch'
for setting in sketch play study reference 1e-2 1e-5 1e-9; do holds "a row of $setting" grep -q "^$setting " out.txt; done
holds 'twelve settings in the CSV' test "$(wc -l <out/cost.csv)" = 13
holds 'as many columns in each row' test "$(awk -F, '{ print NF }' out/cost.csv | sort -u | wc -l)" = 1
holds 'one reference' test "$(grep -c ',yes,' out/cost.csv)" = 1
for column in setting cpu_ms_per_s ratio_to_play error_m rms_m position_error_m rotation_error_rad events evaluations refused gave_up \
    energy_drift_J sense_ms graph_ms advance_ms commit_ms report_ms; do
    holds "a column $column" grep -qE "(^|,)$column(,|\$)" out/cost.csv
done
compares play steps == 30
compares play ratio_to_play == 1
compares play cpu_ms '>' 0
compares sketch error_m '>=' 0
compares sketch error_m '<' 0.5
holds 'no pictures of the world' test "$(find out -name '*.png' ! -name cost.png | wc -l)" = 0
if command -v gnuplot >/dev/null; then
    printed 'the plot in out/cost.svg and out/cost.png'
    holds 'a PNG' grep -qa IHDR out/cost.png
    holds 'an SVG that names the plans' grep -q '>reference' out/cost.svg
fi
gives 0 'quiet, another folder, another start' cost -q -o "it's there/deep" --set 'start=10 deg' --seconds 0.25 pendulum.lua
printed '0.25 s simulated'
holds 'stderr is empty' test ! -s err.txt
holds 'the table is there' test -s "it's there/deep/cost.csv"
command -v gnuplot >/dev/null && holds 'the plot is there' test -s "it's there/deep/cost.png"
gives 0 'arguments after --' cost -q --seconds 0.1 pendulum.lua -- --start 0.1
gives 2 'an unknown argument' cost -q --set strat=1 pendulum.lua;     said "unknown argument 'strat' (did you mean 'start'?)"
PATH=/nonexistent gives 0 'without gnuplot' cost -q --seconds 0.1 pendulum.lua
printed 'gnuplot is not installed here'; printed 'gnuplot out/cost.gp'
touch afile
gives 9 'an output folder that cannot be made' cost -o afile/x pendulum.lua

# ---- free fall: exact at every accuracy, so nothing differs by more than rounding ----
cat >fall.lua <<'LUA'
local digbox = require "digbox"
local world = digbox.world {}
world:ball { radius = 0.1 }
world:run "0.2 s"
LUA
gives 0 'free fall' cost -q fall.lua --within "1 nm"
compares sketch error_m '<' 1e-12
printed 'stays within 1 nm is'

# ---- chaos: balls between hard walls; twins must part within a few impacts ----
cat >billiard.lua <<'LUA'
local digbox = require "digbox"
local world = digbox.world { gravity = { 0, 0, 0 } }
world:room { size = { 2, 1, 1 }, restitution = 1, friction = 0 }
for i = 1, 6 do
  world:ball { radius = "8 cm", restitution = 1, friction = 0, at = { -0.8 + 0.27 * i, 0.5, 0.01 * i },
    velocity = { (-1) ^ i * (1 + 0.3 * i), 0.7, 0.2 * i } }
end
world:run "4 s"
LUA
gives 0 'a chaotic world' cost -q billiard.lua
printed 'Chaotic from t ='; printed 'differences grow'; printed 'Errors are those up to'
compares play simulated_s '>' 3.9
compares play compared_until_s '<' 3.9
compares play compared_until_s '>' 0.2

# ---- worlds that have nothing to compare ----
printf 'local digbox = require "digbox"\nlocal world = digbox.world {}\nworld:floor {}\nworld:step(5)\n' >still.lua
gives 0 'nothing moves' cost -q still.lua;               printed 'No body in this world moves of itself'
printf 'local digbox = require "digbox"\nlocal world = digbox.world {}\nworld:ball { radius = 0.1 }\n' >idle.lua
gives 0 'a script that does not step goes on for 10 s' cost -q idle.lua;      printed '10 s simulated, 600 frame steps'
gives 0 'or for --seconds' cost -q idle.lua --seconds 0.5;                    printed '0.5 s simulated'
echo 'local x = 1' >none.lua
gives 1 'no world at all' cost -q none.lua;              said 'none.lua: the script makes no world'
printf 'local digbox = require "digbox"\nlocal a, b = digbox.world {}, digbox.world {}\na:ball { radius = 0.1 }\nfor i = 1, 10 do b:step() a:step() end\n' >two.lua
gives 0 'two worlds' cost -q two.lua;                    printed 'several worlds'; printed 'No body in this world'

# ---- what world:stats() says of the work, and that no script sees the clock ----
cat >stats.lua <<'LUA'
local digbox = require "digbox"
local world = digbox.world {}
world:ball { radius = 0.1 }
world:step(2)
local s = world:stats()
for _, name in ipairs { "traced", "conserved", "swept", "evaluations", "refused", "trace_events", "gave_up" } do
  assert(math.type(s[name]) == "integer", name)
end
assert(s.traced + s.conserved + s.swept == s.groups and s.groups == 1)
assert(s.gave_up > 0 or s.gave_up_why == nil)
assert(s.energy_drift == world.energy.numerical)
assert(not pcall(function() return digbox.cpu_seconds end) and cpu_seconds == nil and os == nil)
LUA
gives 0 'stats, and no clock' run -q stats.lua
gives 0 'the same while it is measured' cost -q stats.lua

# ---- what each effect costs ----
gives 0 'effects' cost -q --effects --seconds 0.5 pendulum.lua;               printed 'with everything on'; printed 'called for by'
holds 'a row for each effect that is on' test "$(cut -d, -f1 out/effects.csv | sort | tr '\n' ' ')" = 'effect gravity joints '
holds 'with the line that calls for it' grep -q '^joints,.*pendulum.lua:5 (a hinge)' out/effects.csv
holds 'numbers' awk -F, 'NR > 1 && !($2 + 0 == $2 && $3 >= 0 && $8 == 30 && $9 > 0 && $11 == 7) { bad = 1 } END { exit bad }' out/effects.csv
if command -v gnuplot >/dev/null 2>&1; then
    holds 'bars' test -s out/effects.png -a -s out/effects.svg
fi
cat >still.lua <<'LUA'
local digbox = require "digbox"
digbox.world { gravity = { 0, 0, 0 } }:ball { radius = 0.1 }
LUA
gives 0 'a world where nothing is on' cost -q --effects --seconds 0.1 still.lua;  printed 'nothing is on'

# ---- failures ----
sed 's/world:run .*/world:run "0.1 s" error "boom"/' fall.lua >boom.lua
gives 1 'a script that fails' cost -q boom.lua;          said 'digbox: boom.lua:4: boom'
sed 's/world:run .*/world:run "0.1 s" assert(world.accuracy ~= "sketch", "too coarse")/' fall.lua >coarse.lua
gives 0 'a script that fails at one setting' cost -q coarse.lua;              printed 'sketch failed: coarse.lua:4: too coarse'
sed 's/world:run .*/while true do world:step() end/' fall.lua >endless.lua
gives 5 'a script without an end' cost -q --budget 0.05 endless.lua;          said '--seconds N makes it shorter'
gives 0 'has one with --seconds' cost -q --seconds 0.2 endless.lua;           printed '0.2 s simulated'
cp billiard.lua long.lua
"$DIGBOX" cost -q --seconds 100000 --budget 1000 long.lua >out.txt 2>err.txt </dev/null & child=$!
sleep 0.5
kill -INT "$child"; wait "$child"; code=$?
holds 'Ctrl-C ends with 130' test "$code" = 130

checked
