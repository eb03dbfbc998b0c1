#!/usr/bin/env bash
# tests/cli/faults.sh - the Nth call that writes fails (F1, F2, M3), once or from then on: frames, manifest, pictures and saved worlds are
# whole or not there, the message says which and why, nothing is left beside them, and --resume makes the film what it would have been.
#
# One run tries all points, each in a folder whose name tells tests/cli/faults.c what shall fail.
set -u
source=$(cd "${0%/*}" && pwd)/faults.c
. "${0%/*}/../check.sh"
export LP_NUM_THREADS=0 MESA_SHADER_CACHE_DISABLE=true
"${CC:-gcc}" -shared -fPIC -O1 -o faults.so "$source" || exit 77
faulty() { LD_PRELOAD=$PWD/faults.so ASAN_OPTIONS=${ASAN_OPTIONS:-}:verify_asan_link_order=0 "$DIGBOX" "$@"; }

cat >points.lua <<'LUA'
local digbox = require "digbox"
local errors = { 28, 5, 122, 30, 13 }          -- ENOSPC, EIO, EDQUOT, EROFS, EACCES
local size = { 32, 18 }
local function try(folder)
  local world, film = digbox.world {}, nil
  world:ball { radius = 0.1, at = { 0, 0.3, 0 } }
  for _, act in ipairs {
    { "film", function() film = world:record { to = folder .. "/sub/f-%05d.png", fps = 60, size = size, samples = 0 } end },
    { "picture", function() world:render { to = folder .. "/sub/one.png", size = size, samples = 0 } end },
    { "save", function() world:save(folder .. "/sub/end.dig") end },
    { "film", function() if film then world:step(2) film:close() end end } } do
    local fine, message = pcall(act[2])
    if not fine then print(folder .. " " .. act[1] .. ": " .. message) end
  end
  world:close()
end
local most = { open = 8, write = 14, short = 12, fsync = 9, close = 8, rename = 6, mkdir = 1 }
for call, n in pairs(most) do
  for i = 1, n do
    for _, kind in ipairs { "once", "on" } do try(("fault-%s-%d-%s-%d"):format(call, i, kind, errors[(i - 1) % #errors + 1])) end
  end
end
try "fault-none"
LUA
faulty run -q points.lua >out.txt 2>err.txt </dev/null
holds 'the run itself goes on: scripts may catch what fails' test $? = 0

points=$(ls out | grep -c .)
holds 'all points were tried' test "$points" -gt 100
# Each call fails somewhere: the counts above reach behind the last one.
for call in open write fsync close rename mkdir; do holds "$call fails" grep -q "^fault-$call-1-once" out.txt; done
for call in open write fsync close rename; do
    n=$(ls out | sed -n "s/^fault-$call-\([0-9]*\)-once.*/\1/p" | sort -n | tail -n 1)
    holds "no $call is left out: the last point fails nothing" test "$(grep -c "^fault-$call-$n-once" out.txt)" = 0
done
holds 'half of a write is no failure' test "$(grep -c '^fault-short' out.txt)" = 0
holds 'nothing fails where nothing should' test "$(grep -c '^fault-none' out.txt)" = 0
# What is said names a file in the folder and the reason of the system.
bad=$(grep -vE '^(fault-[a-z]+-[0-9]+-(once|on)-[0-9]+) (film|picture|save): points.lua:[0-9]+: (frame [0-9]: )?out/\1/sub.*: (No space left on device|Input/output error|Disk quota exceeded|Read-only file system|Permission denied)(; [0-9] frames are complete; once it can be written, go on with --resume)?$' out.txt | head -n 3)
holds "every message is whole: $bad" test -z "$bad"
holds 'frames say how many there are' grep -q 'frame 1: .*; 1 frames are complete' out.txt
holds 'no draft is left' test -z "$(find out -name '.*' -type f)"

# Whatever stands under a final name is what a run without faults writes.
whole() { [ -z "$(for f in out/fault-*/sub/*.png out/fault-*/sub/*.dig; do cmp -s "$f" "out/fault-none/sub/${f##*/}" || echo "$f"; done | tee torn.txt)" ]; }
holds 'six files without faults' test "$(ls out/fault-none/sub | wc -l)" = 6
whole; holds "no torn file: $(head -n 3 torn.txt)" test ! -s torn.txt
find out -name '*.sha256' -size +0 | sort >lists.txt
xargs "$DIGBOX" verify <lists.txt >verify.txt 2>&1
holds "manifests hold: $(grep -v 'as they were written' verify.txt | head -n 3)" test "$(grep -c 'as they were written' verify.txt)" = "$(wc -l <lists.txt)"

# And what was cut can be gone on with.
gives 0 'resuming all of them' run -q --resume points.lua
whole; holds "every film is complete: $(head -n 3 torn.txt)" test ! -s torn.txt
for list in out/fault-*/sub/f-manifest.sha256; do cmp -s "$list" out/fault-none/sub/f-manifest.sha256 || echo "$list"; done >differ.txt
holds "and so is its manifest: $(head -n 3 differ.txt)" test ! -s differ.txt
holds 'as many files in each' test "$(find out -type f | wc -l)" = $((6 * points))

# ---- F11: no renderer ----
cat >plain.lua <<'LUA'
local world = require("digbox").world {}
world:record { to = "f-%05d.png", fps = 60, size = { 32, 18 }, samples = 0 }
world:step(5)
LUA
for what in 'library:libOSMesa.so.8 cannot be loaded' create:OSMesaCreateContextAttribs 'current:cannot be made current'; do
    step=${what#*:} what=${what%:*}
    DIGBOX_NO_GL=$what faulty run -q -o dark plain.lua >out.txt 2>err.txt </dev/null
    code=$?
    holds "no renderer ($what): exit code 9 (got $code)" test $code = 9
    said 'no picture can be drawn: osmesa: '; said "$step"; said '; egl: libEGL.so.1 cannot be loaded'
    holds 'and no black frame' test -z "$(ls -A dark 2>/dev/null)"
done

# ---- what draws nothing starts no renderer: with one that cannot be started it works all the same ----
echo 'require("digbox").world {}:step(5)' >moves.lua
cat >moves_spec.lua <<'LUA'
local test = require "digbox.test"
test.scenario("moves", function(s) test.expect(s:world {}.steps):is(0) end)
LUA
holds 'the program is not linked to OSMesa' test -z "$(ldd "$DIGBOX" | grep OSMesa)"
export DIGBOX_NO_GL=library
for command in 'run -q --replay moves.replay moves.lua' 'test moves_spec.lua' 'verify moves.replay' 'diff moves.replay moves.replay' \
    'export moves.replay -o moves.csv' 'check moves.lua' 'cost moves.lua --seconds 0.1'; do
    faulty $command >out.txt 2>err.txt </dev/null
    code=$?
    holds "no renderer is started by: $command (exit code $code)" test $code = 0
done

checked
