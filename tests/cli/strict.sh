#!/usr/bin/env bash
# tests/cli/strict.sh - runs that became unreliable: what they say, and exit code 12 under --strict.
set -u
. "${0%/*}/../check.sh"

# A ball of 1 m between walls 0.8 m apart.
cat >pinned.lua <<'LUA'
local digbox = require "digbox"
local world = digbox.world {}
world:box { size = { 1, 4, 4 }, at = { -0.9, 0, 0 }, fixed = true }
world:box { size = { 1, 4, 4 }, at = { 0.9, 0, 0 }, fixed = true }
world:ball { name = "pinned", radius = 0.5, at = { 0, 0, 0 } }
world:run(2)
for _, w in ipairs(world:warnings()) do
  print(w.rule, w.body and w.body.name, w.name, w.time < 1, w.value > w.bound, w.unit, w.times >= 1, w.dig > 0, #w.reason > 0, #w.advice > 0)
end
print("counted", world:stats().warnings >= #world:warnings())
LUA
cat >calm.lua <<'LUA'
local digbox = require "digbox"
local world = digbox.world {}
world:floor {}
world:ball { radius = 0.5, at = { 0, 1, 0 } }
world:run(1)
print(#world:warnings(), world:stats().warnings)
LUA
cat >closed.lua <<'LUA'
local digbox = require "digbox"
local world = digbox.world {}
world:box { size = { 1, 4, 4 }, at = { -0.9, 0, 0 }, fixed = true }
world:box { size = { 1, 4, 4 }, at = { 0.9, 0, 0 }, fixed = true }
world:ball { name = "shut in", radius = 0.5, at = { 0, 0, 0 } }
world:run(1)
world:close()
LUA

gives 0 'a run without --strict' run pinned.lua
said "digbox: unreliable: at t = "
said "bodies stay inside each other, at 'pinned' in DIG "
said 'make room for them'
said '1 warning (overlap)'
holds 'one line for each rule' test "$(grep -c '^digbox: unreliable' err.txt)" = 1
printed "overlap	pinned	pinned	true	true	m	true	true	true	true"
printed 'counted	true'
gives 12 'the same with --strict' run --strict pinned.lua
said "digbox: unreliable (1 warning): at t = "
gives 12 'quietly' run --strict -q pinned.lua
holds 'one line only' test "$(wc -l <err.txt)" = 1
gives 0 'quietly without it' run -q pinned.lua
holds 'nothing is said' test ! -s err.txt
gives 12 'a world that the script closes' run --strict -q closed.lua;   said "'shut in'"
gives 0 'a calm world' run --strict calm.lua;                           printed '0	0'
holds 'no warning' test "$(grep -c unreliable err.txt)" = 0
gives 0 'help names the option' run --help;                             printed '--strict'
gives 0 'help names the code' --help;                                   printed '12 unreliable'

# ---- scenarios ----
cat >reliable.lua <<'LUA'
local test = require "digbox.test"
test.scenario("calm", function(s)
  s.world:floor {}
  s.world:ball { radius = 0.5, at = { 0, 1, 0 } }
  s:settle(1)
  s:expect_reliable()
end)
LUA
cat >unreliable.lua <<'LUA'
local test = require "digbox.test"
test.scenario("pinned", function(s)
  s.world:box { size = { 1, 4, 4 }, at = { -0.9, 0, 0 }, fixed = true }
  s.world:box { size = { 1, 4, 4 }, at = { 0.9, 0, 0 }, fixed = true }
  s.world:ball { name = "pinned", radius = 0.5, at = { 0, 0, 0 } }
  s:settle(1)
  s:expect_reliable()
end)
LUA
gives 0 'a scenario that is reliable' test reliable.lua
gives 6 'a scenario that is not' test unreliable.lua
holds 'it says why' grep -q "unreliable.lua:7: the run became unreliable: .*at 'pinned'" out.txt err.txt

checked
