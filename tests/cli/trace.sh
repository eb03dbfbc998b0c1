#!/usr/bin/env bash
# tests/cli/trace.sh - digbox run --trace: one span a step with its phases, valid to the end; files that cannot be written.
set -u
. "${0%/*}/../check.sh"

cat >fall.lua <<'LUA'
local digbox = require "digbox"
local world = digbox.world {}
world:floor {}
world:ball { radius = 0.1, at = { 0, 0.3, 0 } }
world:run "0.5 s"
print(world.time)
LUA

gives 0 'a run without' run -q fall.lua
cp out.txt plain.txt
gives 0 'a run with' run -q --trace steps.json fall.lua
holds 'the script sees no difference' cmp out.txt plain.txt
holds 'it begins as an array' test "$(head -n 1 steps.json)" = '['
holds 'it ends as one' test "$(tail -n 1 steps.json)" = ']'
holds 'no line but the last lacks a comma' test "$(sed '1d;$d' steps.json | head -n -1 | grep -vc ',$')" = 0
for name in step sense advance touch commit graph report counts groups; do
    holds "30 of $name" test "$(grep -c "\"name\":\"$name\"" steps.json)" = 30
done
holds 'no figure that JSON does not know' test "$(grep -ciE ':(-?nan|-?inf)' steps.json)" = 0

gives 9 'a folder that is not there' run -q --trace nowhere/steps.json fall.lua;     said 'nowhere/steps.json: No such file'
gives 2 'no file' run fall.lua --trace;                                              said 'run: --trace wants a value'

# What a script leaves when it fails is still closed.
printf 'local world = require("digbox").world {}\nworld:step(3)\nerror "enough"\n' >fails.lua
gives 1 'a script that fails' run -q --trace fails.json fails.lua
holds 'has its three steps' test "$(grep -c '"name":"step"' fails.json)" = 3
holds 'and an end' test "$(tail -n 1 fails.json)" = ']'

checked
