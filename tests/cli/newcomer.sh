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

# ---- what Lua says of what is not there ----
# hints LINE HINT: a world of that line ends with the line's number and the hint.
hints() {
    world hinted <<<"$1"
    gives 1 "$1" run -q hinted.lua
    said 'hinted.lua:4: '
    said "$2"
}
hints 'local f = io.open("x.txt", "w")'         'worlds have no io: print(...) writes lines'
hints 'print(os.clock())'                       'worlds have no os: world.time is the time'
hints 'dofile "other.lua"'                      "require 'name' runs name.lua beside the script"
hints 'local v = Vector3.new(1, 2, 3)'          'vectors are made by digbox.vec(x, y, z)'
hints 'wait(1)'                                 'world:spawn(function(task) task:wait(1) end)'
hints 'print(unpack { 1 })'                     'Lua 5.4 has table.unpack'
hints 'print(math.pow(2, 3))'                   'powers are x ^ y'
hints 'for b in world:bodies() do end'          'for i, thing in ipairs(list) do'
hints 'if ball ~= None then end'                "there is no 'None': Lua writes nil"
hints 'world:box { size = 1, fixed = True }'    "there is no 'True': Lua writes true"
hints 'if ball != nil then end'                 "'not equal' is ~= in Lua"
hints 'local n = 1; n += 1'                     'Lua has no += and no ++'
hints 'world:ball { radius = 0.1 at = 3 }'      'is there a comma between the fields?'
hints 'world:ball { radius: 0.1 }'              'fields are written name = value'
hints 'if ball = nil then end'                  '== compares'
world open <<<'for i = 1, 3 do print(i)'
gives 1 'a loop without its end' run -q open.lua;       said 'has its `end`'
printf '%s\n' 'world:ball { radius = 0.1 }' >bare.lua
gives 1 'a world that was not made' run -q bare.lua;    said 'make one first: local world = digbox.world {}'
world handled <<<'ball:on("slept", function() io.write("x") end) world:floor {} world:run(9)'
gives 1 'in a handler' run -q handled.lua;              said 'worlds have no io'
world tasked <<<'world:spawn(function(task) task:wait(0.1) os.exit() end) world:run(1)'
gives 1 'in a task' run -q tasked.lua;                  said 'worlds have no os'
gives 0 'trusted' run -q --trust tasked.lua;            holds 'there it is' test ! -s err.txt
world plain <<<'assert(io == nil and rawget(_G, "None") == nil and nothing == nil and type(os) == "nil") print(pcall(function() io.x() end))'
gives 0 'scripts may ask, and see the message as it is' run -q plain.lua
lacks 'worlds have no io'
cat >spec.lua <<'LUA'
local test = require "digbox.test"
test.scenario("time", function() os.time() end)
LUA
gives 6 'in a test' test spec.lua;                      printed 'worlds have no os'

checked
