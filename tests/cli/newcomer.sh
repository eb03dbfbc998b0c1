#!/usr/bin/env bash
# tests/cli/newcomer.sh - what the program says to somebody who writes his first worlds: lines, hints, once and where they belong.
set -u
. "${0%/*}/../check.sh"

# world NAME: stdin becomes NAME.lua, below three lines that everybody writes (the first line of stdin is the fourth)
world() {
    printf '%s\n' 'local digbox = require "digbox"' 'local world = digbox.world {}' 'local ball = world:ball { radius = 0.1, at = { 0, 1, 0 } }' >"$1.lua"
    cat >>"$1.lua"
}

# ---- angles ----
world turned <<'LUA'
for i = 1, 3 do
  world:box { size = 0.1, at = { i, 1, 0 }, rotation = { axis = { 0, 0, 1 }, angle = 90 } }
end
LUA
gives 0 'an angle of 90 radians is legal' check turned.lua
said "turned.lua:5: world:box.rotation.angle = 90 rad: write '90 deg' if degrees are meant"
holds 'and is remarked upon once' test "$(grep -c 'degrees are meant' err.txt)" = 1
gives 0 'quiet' run -q turned.lua;      holds 'nothing is remarked' test ! -s err.txt

checked
