#!/usr/bin/env bash
# tests/cli/process.sh - a run is a process of its own: what its supervisor says of its end, passes on, and cleans up.
set -u
. "$(dirname "$0")/../check.sh"

cat >long.lua <<'LUA'
local world = require("digbox").world {}
world:ball { radius = 1 }
world:run "100000 s"
LUA
cat >loop.lua <<'LUA'
while true do end
LUA

# begin ARGUMENTS...: starts digbox; leaves the supervisor's pid in $parent and the run's in $child.
begin() {
    "$DIGBOX" "$@" >out.txt 2>err.txt </dev/null &
    parent=$!
    for _ in $(seq 200); do
        child=$(pgrep -P "$parent") && [ -n "$child" ] && sleep 0.2 && return
        sleep 0.02
    done
}
# ends CODE WHAT: waits for it.
ends() {
    local got
    wait "$parent" 2>/dev/null
    got=$?
    holds "$2: exit code $1 (got $got)" test "$got" = "$1"
}
gone() { ! kill -0 "$child" 2>/dev/null || grep -q '^State:.Z' "/proc/$child/status"; }     # nobody may wait for an orphan

for signal in KILL SEGV ABRT; do
    [ "$SANITIZE" = 1 ] && [ $signal != KILL ] && continue          # the sanitizer takes those
    begin run -q long.lua; kill -$signal "$child"
    ends 11 "a run that died of $signal"
    said 'digbox: long.lua: the run died (signal'
    said 'a fault of digbox'
    holds 'in one line' test "$(wc -l <err.txt)" = 1
done
for signal in INT:130 TERM:143; do
    begin run -q long.lua; kill "-${signal%:*}" "$parent"
    ends "${signal#*:}" "${signal%:*} is passed on"
    said 'digbox: long.lua:3: stopped by'
    holds 'and the run is gone' gone
done
begin run -q long.lua; kill -HUP "$parent"
ends 129 'HUP ends both'
begin run -q long.lua; kill -KILL "$parent"; wait "$parent" 2>/dev/null
for _ in $(seq 500); do gone && break; sleep 0.02; done           # on an idle machine at once
holds 'a run without its supervisor ends with it' gone

# A run that is stopped from outside cannot keep its own clock: the supervisor does.
begin run -q --time-limit 3 loop.lua; kill -STOP "$child"
ends 5 'a run that does not respond'
said 'digbox: loop.lua: does not respond; killed'

# A crash costs one scenario of several.
cat >crash_spec.lua <<'LUA'
local test = require "digbox.test"
test.scenario("long", function(s) s.world:ball { radius = 1 } s.world:run "100000 s" end)
test.scenario("fine", function() test.expect(1):is(1) end)
LUA
"$DIGBOX" test crash_spec.lua >out.txt 2>err.txt </dev/null &
parent=$!
for _ in $(seq 100); do grep -q . /proc/$parent/task/$parent/children 2>/dev/null && break; sleep 0.02; done
sleep 0.5; kill -KILL "$(pgrep -P "$parent")"
ends 11 'a scenario that died'
printed 'the run died (signal 9'; printed '1 passed, 1 failed'

checked
