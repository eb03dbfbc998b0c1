#!/usr/bin/env bash
# tests/cli/fuel.sh - work of the engine is charged to the script that asks for it: it stops at the same call every time (exit code 4).
# Only in the plain build: what is compared are counts of instructions; tests/hostile/hostile.sh meets the same limits under sanitizers.
set -u
. "${0%/*}/../check.sh"

cat >begin.lua <<'LUA'
local digbox = require "digbox"
world = digbox.world {}
world:floor {}
for i = 1, 30 do world:ball { name = "b" .. i, radius = 0.1, at = { i % 5, 0.15 + i // 5, 0.01 * i } } end
corners = {}
for i = 1, 60 do corners[i] = { math.sin(i), math.cos(2 * i), math.sin(3 * i) } end
return world
LUA
# Each line asks for something dear with few instructions.
cat >dear.txt <<'LINES'
steps|while true do world:step(100) end
rays|while true do for i = 1, 50 do world:ray { from = { -5, 0.2, 0 }, to = { 9, 0.2, 0 } } end end
overlaps|while true do world:overlap { sphere = { radius = 9 } } end
sweeps|while true do world:sweep { sphere = { radius = 2 }, at = { 0, 9, 0 }, velocity = { 0, -9, 0 } } end
hulls|while true do world:hull { points = corners, at = { 0, 50, 0 } }:remove() end
questions|while true do world:ask { body = world:find "b1", along = { 0, 1, 0 }, within = 0.2 } end
snapshots|while true do world:restore(world:snapshot()) end
checksums|while true do world:checksum() end
worlds|while true do digbox.world {}:close() end
lists|while true do world:bodies() end
LINES
while IFS='|' read -r what line; do
    { echo 'local digbox, world = require "digbox", require "begin"'; echo 'local corners = corners'; echo "$line"; } >dear.lua
    gives 4 "$what" run -q --fuel 3000000 dear.lua
    said 'dear.lua:3: used up its instructions (3000000)'
    cp err.txt first.txt
    gives 4 "$what again" run -q --fuel 3000000 --threads 2 dear.lua
    holds "$what: the same place, with two threads" cmp first.txt err.txt
done <dear.txt

# Few instructions, much work: a limit of instructions alone would let it go on a hundred times as long.
printf 'local world = require "begin"\nworld:step(200)\nprint(world:stats().work > 200 * 1000)\n' >counted.lua
gives 0 'work is counted' run -q --fuel 1000000000 --verbose counted.lua;  printed true; said 'digbox: fuel:'
used=$(sed -n 's/^digbox: fuel: \([0-9]*\) used$/\1/p' err.txt)
holds 'and charged' test "${used:-0}" -gt 400000
gives 4 'so that it does not fit' run -q --fuel $((used * 9 / 10)) counted.lua
gives 0 'or just does' run -q --fuel $((used + 2000)) counted.lua
checked
