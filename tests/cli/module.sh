#!/usr/bin/env bash
# tests/cli/module.sh - digbox.so in a plain lua5.4: a ball falls, errors have their line, pictures are drawn.
set -u
[ "${SANITIZE:-0}" = 0 ] || { echo 'a plain Lua cannot load a module with a sanitizer'; exit 77; }
command -v lua5.4 >/dev/null || { echo 'lua5.4 is missing: make deps'; exit 77; }
tree=$(cd "${0%/*}/../.." && pwd)
env -u MAKEFLAGS -u MAKELEVEL make -s -C "$tree" BUILD="$BUILD" digbox.so || exit 1
export LUA_CPATH="$tree/$BUILD/?.so"
. "${0%/*}/../check.sh"

lua() { lua5.4 "$@" >out.txt 2>err.txt; }

holds 'a ball falls' lua -e '
local d = require "digbox"
local w = d.world {}
w:floor {}
local b = w:ball { radius = "10 cm", at = { 0, 1, 0 } }
w:run "3 s"
assert(math.abs(b.position.y - 0.1) < 1e-3, tostring(b.position))
print(b.position, d.version)'
printed '0.1'
cat >wrong.lua <<'LUA'
local d = require "digbox"

d.world {}:ball { radus = 1 }
LUA
holds 'a mistake ends it' test "$(lua wrong.lua; echo $?)" = 1
said "wrong.lua:3: world:ball: unknown field 'radus' (did you mean 'radius'?)"
holds 'the scenario kit' lua -e '
local test = require "digbox.test"
test.scenario("it works", function(s) test.expect(s.world.time):is(0) end)'
printed 'ok    it works'
holds 'a picture' lua -e '
local d = require "digbox"
local w = d.world {}
w:ball { radius = 1 }
w:render { to = "ball.png", size = { 32, 32 } }'
holds 'there it is' test -s out/ball.png
holds 'globals stay as they were' lua -e '
local before, sum = {}, 0
for k in pairs(_G) do before[k] = true end
require "digbox"
for k in pairs(_G) do assert(before[k], k) end'
holds 'two worlds, collected' lua -e '
local d = require "digbox"
for _ = 1, 50 do d.world {}:ball { radius = 1 } end
collectgarbage() collectgarbage()
assert(d.world {}:checksum() == d.world {}:checksum())'
checked
