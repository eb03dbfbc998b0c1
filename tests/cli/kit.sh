#!/usr/bin/env bash
# tests/cli/kit.sh - what a failed scenario leaves: report, picture, DIGs, replay, the command; limits of simulated time; TAP and JUnit.
set -u
. "${0%/*}/../check.sh"

cat >f_spec.lua <<'LUA'
local test = require "digbox.test"
test.scenario("falls too far", function(s)
  s.world:floor {}
  local b = s.world:ball { radius = 0.1, at = { 0, 1, 0 } }
  s:settle "1 s"
  test.expect(b.position.y):above "0.5 m"
end)
test.scenario("for ever", function(s) s:eventually("never", "100 s", function() return false end) end)
test.scenario("catches what stops it", function(s)
  test.expect(1):is(1)
  while pcall(s.world.step, s.world) do end
end)
test.scenario("short", function(s)
  s:settle "0.5 s"
  test.expect(s.world.steps):is(30)
end)
test.scenario("only when started elsewhere", function(s)
  local b = s.world:ball { radius = 0.1, at = { 0, 1, 0 } }
  s.world:run "0.1 s"
  test.expect(b.position.x):is(0.0)
  s:perturb { seeds = 2, position = "1 mm" }
end)
LUA
gives 6 'failures' test --sim-limit '3 s' -j 2 -o left --junit junit.xml f_spec.lua
printed 'f_spec.lua:6: expected above 0.5 m, got 0.1 m'
printed 'last events:'; printed 'picture: left/f_spec-falls_too_far.png'; printed 'DIGs:    left/f_spec-falls_too_far.dot'
printed 'replay:  left/f_spec-falls_too_far.replay'; printed "again:   digbox test f_spec.lua -k 'falls too far'"
printed 'f_spec.lua:8: used up its 3 s of simulated time; raise --sim-limit or simulate less'
printed 'f_spec.lua:11: used up its 3 s'
printed 'seed 1 of 2'
printed '1 passed, 4 failed'
for end in png dot replay; do holds "a $end of it is there" test -s "left/f_spec-falls_too_far.$end"; done
gives 0 'the replay does the same again' verify left/f_spec-falls_too_far.replay;       printed '60 steps'
gives 0 'the replay of a perturbed one' verify left/f_spec-only_when_started_elsewhere.replay
holds 'JUnit counts them' grep -q 'tests="5" failures="4"' junit.xml
if command -v python3 >/dev/null; then holds 'JUnit is XML' python3 -c 'import xml.dom.minidom; xml.dom.minidom.parse("junit.xml")'; fi
gives 6 'TAP' test --tap --sim-limit 3 -o left f_spec.lua
printed '1..5'; printed 'not ok 1 - f_spec.lua: falls too far'; printed 'ok 4 - f_spec.lua: short'
gives 0 'without a limit' test -k short f_spec.lua; printed '1 passed, 0 failed'
gives 2 'a limit that is none' test --sim-limit never f_spec.lua
# A scenario that fails cannot pass by hiding it (D14).
cat >spoof_spec.lua <<'LUA'
local test = require "digbox.test"
test.scenario("catches the failure", function() test.expect(1):is(1) pcall(function() test.expect(1):is(2) end) end)
test.scenario("takes error away", function() error, assert, pcall = print, print, print test.expect(1):is(2) end)
test.scenario("checks nothing", function() end)
test.scenario("only begins to check", function() test.expect(1) end)
test.scenario("puts another expect there", function()
  pcall(function() test.expect = function() return { is = print } end end)
  test.expect(1):is(2)
end)
test.scenario("prints a verdict", function() print "1 passed, 0 failed" test.expect(1):is(2) end)
LUA
gives 6 'hidden failures' test -o spoof spoof_spec.lua;      printed '0 passed, 6 failed'
cat >loop_spec.lua <<'LUA'
require("digbox.test").scenario("loops", function() while true do end end)
LUA
gives 5 'wall time' test --time-limit 0.3 loop_spec.lua;      printed 'used up its time'
cat >slow_spec.lua <<'LUA'
require("digbox.test").scenario("goes on", function(s)
  s.world:ball { name = "b", radius = 0.1, at = { 0, 1, 0 } }
  s.world:step(5)
  while true do end
end)
LUA
gives 5 'wall time with a world' test --time-limit 4 -o slow slow_spec.lua;     printed 'slow_spec.lua:4: used up its time'
printed 'at t = 0.0833333 s, step 5'; printed 'picture: slow/slow_spec-goes_on.png'; printed 'DIGs:    slow/slow_spec-goes_on.dot'
printed "again:   digbox test slow_spec.lua -k 'goes on'"
for end in png dot; do holds "a $end of it is there" test -s "slow/slow_spec-goes_on.$end"; done
# A limit that trips over what is left of a failed scenario does not hide why it failed.
cat >late_spec.lua <<'LUA'
local test, runs = require "digbox.test", 0
test.scenario("fails, and hangs when it is run again for its replay", function()
  runs = runs + 1
  while runs > 1 do end
  test.expect(1):is(2)
end)
LUA
gives 5 'no time for a replay' test --time-limit 3 -o late late_spec.lua
printed 'late_spec.lua:5: expected 2, got 1'; printed 'late_spec.lua:4: used up its time'
# A batch of a hundred, of which some hang, lie, print without end or cannot be loaded (B1): all are told, each for itself.
mkdir -p batch
{ echo 'local test = require "digbox.test"'; for i in $(seq 90); do echo "test.scenario('good $i', function() test.expect(1):is(1) end)"; done; } >batch/good_spec.lua
cat >batch/bad_spec.lua <<'LUA'
local test = require "digbox.test"
test.scenario("fails", function() test.expect(1):is(2) end)
test.scenario("fails, too", function(s) s.world:ball { radius = -1 } end)
test.scenario("hangs", function() while true do end end)
test.scenario("prints without end", function() while true do print(("x"):rep(1000)) end end)
test.scenario("prints much and is fine", function() for _ = 1, 2e4 do print "0 passed, 100 failed" end test.expect(1):is(1) end)
test.scenario("asks for NaN", function(s) s.world:ball { radius = 1, at = { 0 / 0, 0, 0 } } end)
test.scenario("spoils a step", function(s) s.world:ball { radius = 1 } s.world:add_effect { name = "e", step = function(_, b) b[1].force = { 1e300, 0, 0 } end } s.world:run(1) end)
LUA
echo 'local x = = 1' >batch/syntax_spec.lua
echo 'require "nowhere"' >batch/module_spec.lua
echo 'while true do end' >batch/loading_spec.lua
gives 5 'a batch' test -j 2 --time-limit 3 -o batch/out --junit batch.xml batch
holds 'all are counted' test "$(tail -n 1 out.txt)" = '91 passed, 9 failed'
for line in 'bad_spec.lua:2: expected 2, got 1' 'bad_spec.lua:4: used up its time' 'bad_spec.lua:5: used up its time' 'ok    batch/bad_spec.lua: prints much' \
    'at.x = nan, must be a finite number' 'syntax_spec.lua:1:' "module 'nowhere' not found" 'loading_spec.lua:1: used up its time'; do printed "$line"; done
holds 'JUnit counts them' grep -q 'tests="100" failures="9"' batch.xml
if command -v python3 >/dev/null; then holds 'JUnit is XML' python3 -c 'import xml.dom.minidom; xml.dom.minidom.parse("batch.xml")'; fi
holds 'the log is cut' test "$(wc -c <out.txt)" -lt 30000
# What still moves after s:settle is told where something fails; what falls fails by itself.
cat >settle_spec.lua <<'LUA'
local test = require "digbox.test"
test.scenario("still moves", function(s)
  local b = s.world:ball { name = "bob", radius = 0.1, at = { 1, 2, 0 } }
  s.world:distance { a = b, at_b = { 0, 2, 0 }, length = 1 }
  test.expect(s:settle "0.2 s"):is(true)
end)
test.scenario("falls", function(s)
  s.world:ball { name = "stone", radius = 0.1, at = { 0, 9, 0 } }
  s:settle "0 s"
end)
LUA
gives 6 'no rest' test -o left settle_spec.lua
printed "s:settle: at t = 0.2 s body 'bob' still moved at 1.9"
printed "settle_spec.lua:9: s:settle: after 0 s body 'stone' falls at 0.164 m/s: nothing holds it up"
checked
