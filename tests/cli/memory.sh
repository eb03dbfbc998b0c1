#!/usr/bin/env bash
# tests/cli/memory.sh - the Nth allocation of the program fails, once or from then on (M2): engine, Lua, replay, saved world, export,
# picture. The run ends with a sentence and the code for no memory or failed output, or goes on where it can; it never dies.
#
# DIGBOX_FULL=1: every allocation instead of some.
set -u
[ "${SANITIZE:-0}" = 1 ] && { echo 'a sanitizer has its own malloc'; exit 77; }
source=$(cd "${0%/*}" && pwd)/memory.c
. "${0%/*}/../check.sh"
export LP_NUM_THREADS=0 MESA_SHADER_CACHE_DISABLE=true
"${CC:-gcc}" -shared -fPIC -O1 -o memory.so "$source" || exit 77

cat >all.lua <<'LUA'
local digbox = require "digbox"
local world = digbox.world {}
world:floor {}
local points = {}
for i = 1, 30 do points[i] = { math.sin(i), math.cos(2 * i), math.sin(3 * i) } end
local hull = world:hull { points = points, at = { 5, 3, 0 }, temperature = 300 }
world:mesh { vertices = { { 9, 0, 0 }, { 10, 0, 0 }, { 9, 0, 1 } }, triangles = { { 1, 3, 2 } }, fixed = true }
for i = 1, 12 do world:ball { name = "b" .. i, radius = 0.1, at = { 0.15 * i, 0.3, 0 } } end
world:hinge { a = world:find "b1", b = world:find "b2", at = { 0.2, 0.3, 0 }, axis = { 0, 0, 1 } }
world:cloth { at = { 0, 3, 0 }, across = { 1, 0, 0 }, down = { 0, -1, 0 }, columns = 3, rows = 3, mass = 1, stiffness = 1e3 }
world:region { sphere = { radius = 1 }, at = { 0, 1, 0 }, laws = { drag = 1 } }
world:on("impact", function(e) e.self:send(e.other, "hit", e.impulse) end)
local snapshot = world:snapshot()
world:step(20)
world:restore(snapshot)
world:find "b3":can_move { along = { 1, 0, 0 }, by = 0.01 }
world:ray { from = { -1, 0.2, 0 }, to = { 3, 0.2, 0 } }
world:save "end.dig"
digbox.load("out/end.dig"):step(3)
if PICTURE then world:render { to = "end.png", size = { 16, 9 }, samples = 0 } end
LUA

# tries NAME POINTS COMMAND...: so many points, spread over all allocations of the command
tries() {
    local name=$1 points=$2 n step at kind code bad=0 died=0 tried=0
    shift 2
    rm -rf out made
    head -c 8 /dev/zero >count
    DIGBOX_COUNT=$PWD/count LD_PRELOAD=$PWD/memory.so "$DIGBOX" "$@" >out.txt 2>err.txt </dev/null
    holds "$name: it works with memory (exit code $?)" test $? = 0
    n=$(($(od -An -t d8 count)))
    holds "$name: allocations are counted ($n)" test "${n:-0}" -gt 20
    [ "${DIGBOX_FULL:-0}" = 1 ] && points=$n
    step=$((n / points + 1))
    for ((at = 1; at <= n; at += at < 20 ? 1 : step)); do
        kind=$([ $((at % 2)) = 0 ] && echo on || echo once)
        rm -rf out made
        DIGBOX_FAIL=$at-$kind LD_PRELOAD=$PWD/memory.so timeout -k 1 60 "$DIGBOX" "$@" >out.txt 2>err.txt </dev/null
        code=$?
        tried=$((tried + 1))
        case $code in
            0) ;;
            1|3|9) grep -q '^digbox: ' err.txt || { echo "$name, allocation $at $kind: code $code without a word"; bad=$((bad + 1)); } ;;
            *) echo "$name, allocation $at $kind: exit code $code: $(head -n 1 err.txt)"; died=$((died + 1)) ;;
        esac
    done
    holds "$name: every failure is told ($tried points)" test $bad = 0
    holds "$name: no run dies ($tried points)" test $died = 0
}
sed -i '1i local PICTURE = false' all.lua
tries 'a run' 120 run -q --replay made all.lua
cp made kept.replay 2>/dev/null || "$DIGBOX" run -q --replay kept.replay all.lua >/dev/null 2>&1
sed 's/PICTURE = false/PICTURE = true/' all.lua >picture.lua
tries 'a picture' 20 run -q picture.lua
tries 'an export' 40 export kept.replay -o made.glb
tries 'a replay, verified' 30 verify kept.replay
checked
