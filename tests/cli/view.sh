#!/usr/bin/env bash
# tests/cli/view.sh - digbox view: arguments, files that are no replay, what the page holds; without the page, how to build it.
set -u
. "${0%/*}/../check.sh"

gives 0 'help' view --help;                       printed 'digbox view REPLAY -o page.html'
gives 2 'no replay' view;                         said 'view: which replay?'
gives 2 'two replays' view a.replay b.replay;     said "'b.replay' is too many"
gives 2 'no page' view a.replay;                  said 'view: where to?'
gives 2 'a page that is none' view a.replay -o a.csv;      said "'a.csv' must end in .html"
gives 2 'an unknown option' view --frobnicate

cat >drop.lua <<'LUA'
local world = require "digbox".world {}
world:floor {}
world:ball { name = 'a "b" </script> \\', radius = 0.1, at = { 0, 0.5, 0 } }
world:record { to = "f-%05d.png", fps = 1 }:close()
world:run "0.5 s"
LUA
gives 0 'a run' run -q drop.lua --replay drop.replay
"$DIGBOX" view drop.replay -o page.html 2>err.txt
if grep -q 'make viewer' err.txt; then
    gives 2 'a program without the page' view drop.replay -o page.html;  said "'make viewer' builds it in"
    holds 'and then there is no page' test ! -e page.html
    checked
    exit
fi
gives 0 'a page' view drop.replay -o page.html;   said 'page.html: '
holds 'one header' test "$(grep -c 'id="digbox-head"' page.html)" = 1
holds 'one block of data' test "$(grep -c 'id="digbox-data"' page.html)" = 1
holds 'no mark is left' test "$(grep -c 'DIGBOX-DATA' page.html)" = 0
holds 'names end no script' grep -qF 'a \"b\" \u003c/script> \\' page.html
holds 'no address' test "$(grep -cE '(src|href)="(https?:)?//' page.html)" = 0
cp page.html first.html
gives 0 'again' view drop.replay -o page.html;    holds 'the same bytes' cmp first.html page.html
gives 0 'quiet' view -q drop.replay -o page.html; holds 'says nothing' test ! -s err.txt
gives 0 'some frames' view drop.replay -o few.html --frames 5..9 --title '<few>'
holds 'five of them' grep -q '"frames":5,' few.html
holds 'with the title' grep -qF '"title":"\u003cfew>"' few.html
gives 0 'fewer a second' view drop.replay -o few.html --fps 10;         holds 'six of them' grep -q '"frames":6,' few.html
gives 2 'frames that are not there' view drop.replay -o few.html --frames 5..99; said 'not within the frames of the replay'
gives 9 'a folder that is not there' view drop.replay -o nowhere/page.html
head -c 300 drop.replay >cut.replay
gives 8 'a replay without a frame' view cut.replay -o cut.html;         holds 'leaves no page' test ! -e cut.html
gives 8 'no replay at all' view drop.lua -o cut.html
gives 8 'a file that is not there' view nowhere.replay -o cut.html
# A cloth of 4 columns and 3 rows is 6 quads, written once for all frames, and has no balls.
cat >cloth.lua <<'LUA'
local world = require "digbox".world {}
world:cloth { at = { 0, 2, 0 }, across = { 1, 0, 0 }, down = { 0, -1, 0 }, columns = 4, rows = 3, mass = 0.1, stiffness = 100 }
world:run(0.2)
LUA
gives 0 'a cloth' run -q cloth.lua --replay cloth.replay
gives 0 'its page' view -q cloth.replay -o cloth.html
holds 'six quads' grep -qE '"sheet":\["f32",[0-9]+,6,' cloth.html
holds 'no shape beside them' grep -qE '"shapes":\[[[:space:]]*\]' cloth.html
checked
