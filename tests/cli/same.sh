#!/usr/bin/env bash
# tests/cli/same.sh - the same world gives the same bytes: by any number of threads (D1), wherever, whenever and by whom it is run
# (D2, D3), drawn by any number of threads (D5), and after each step was taken back and taken again (D4).
# Only in the plain build: what is compared are bits, of every world run three times.
set -u
worlds=$(cd "${0%/*}/../../worlds" && pwd)
. "${0%/*}/../check.sh"
export MESA_SHADER_CACHE_DISABLE=true

# ---- D1, D2, D3: every world, 2 or 8 threads; another folder, environment, place in memory ----
mkdir -p here there/deep/er many
threads=8
fixed=(); setarch -R true 2>/dev/null && fixed=(setarch -R)         # a container may not allow it
for path in "$worlds"/*.lua; do
    name=$(basename "$path" .lua)
    case $name in *_spec) continue ;; esac
    (cd here && "$DIGBOX" run -q --seconds 0.5 --replay "$name.replay" "$path" >"$name.txt" 2>/dev/null </dev/null)
    (cd there/deep/er && env -i PATH="$PATH" TZ=Asia/Kathmandu LANG=tr_TR.UTF-8 LC_ALL=tr_TR.UTF-8 HOME=/nowhere SEED="$RANDOM" \
        ASAN_OPTIONS="${ASAN_OPTIONS:-}" "${fixed[@]}" "$DIGBOX" run -q --seconds 0.5 --replay "$name.replay" "$path" >"$name.txt" 2>/dev/null </dev/null)
    holds "$name prints the same" cmp "here/$name.txt" "there/deep/er/$name.txt"
    holds "$name does the same" cmp "here/$name.replay" "there/deep/er/$name.replay"
    threads=$((10 - threads))
    (cd many && "$DIGBOX" run -q --seconds 0.5 --threads $threads --replay "$name.replay" "$path" >/dev/null 2>&1 </dev/null)
    gives 0 "$name does the same with $threads threads" diff "here/$name.replay" "many/$name.replay"
done
holds 'there were worlds' test "$(find here -name '*.replay' -size +1k | wc -l)" -ge 12

# ---- D2: twice in one process, and after another world ----
cat >twice.lua <<'LUA'
local digbox = require "digbox"
local function run(seed)
  local world = digbox.world { seed = seed }
  world:floor {}
  for i = 1, 20 do
    world:box { size = 0.2, at = { math.random(), 0.3 * i, 0.1 * math.random() }, spin = { 1, i, 0 } }
  end
  local sums = {}
  for i = 1, 60 do world:step() sums[i] = world:checksum() end
  return table.concat(sums, " "), world
end
local first, kept = run(7)
run(8)
math.randomseed(1)                              -- a world's seed is that of math.random
assert(run(7) == first and kept:checksum() == first:match "%S+$")
print "the same"
LUA
gives 0 'twice in one process' run -q twice.lua;         printed 'the same'

# ---- D4: each step twice, from a snapshot ----
cat >rewind.lua <<'LUA'
local digbox = require "digbox"
local parts, n = digbox.parts, 0
local scenes = {
  function(w) for i = 1, 6 do w:box { size = 0.2, at = { 0, 0.1 + 0.21 * i, 0.01 * i } } end end,
  function(w) for i = 1, 20 do w:ball { radius = 0.1, at = { 0.13 * (i % 4), 0.3 * i, 0.07 * (i % 3) }, restitution = 0.6 } end end,
  function(w) w:rope { a = w:ball { radius = 0.1, at = { 0, 1, 0 } }, at = { 1, 3, 0 }, segments = 12, radius = 0.02 } end,
  function(w) parts.ragdoll(w, { at = { 0, 1, 0 } }) end, function(w) parts.truck(w, { at = { 0, 0.5, 0 } }):drive(1) end,
  function(w) parts.clock(w, { at = { 0, 1, 0 } }) end,
  function(w) w:cloth { at = { 0, 3, 0 }, across = { 1, 0, 0 }, down = { 0, 0, 1 }, columns = 5, rows = 5, mass = 1, stiffness = 1e3 } end,
  function(w) w:plank { from = { 0, 1, 0 }, to = { 2, 1, 0 }, width = 0.1, height = 0.02, material = "oak", segments = 6, from_end = "clamped" } end,
  function(w) w:water {} w:box { size = 0.3, at = { 0, 0.2, 0 }, density = 500, temperature = 350 } end,
  function(w) local a = w:box { size = 0.2, at = { 0, 2, 0 } } w:hinge { a = a, at = { 0.5, 2, 0 }, axis = { 0, 0, 1 }, breaks_at = 8 } end,
  function(w) local a = w:ball { radius = 0.1, at = { 0, 1, 0 } } w:on("impact", function(e) a:send(a, "hit", e.impulse) end) end,
  function(w) w:region { sphere = { radius = 1 }, at = { 0, 1, 0 }, laws = { drag = 2 } } w:cone { radius = 0.2, height = 0.4, at = { 0, 2, 0 } } end,
}
for i, build in ipairs(scenes) do
  local world = digbox.world { seed = i }
  world:floor {}
  build(world)
  for step = 1, STEPS do
    local before = world:snapshot()
    world:step()
    local once = world:checksum()
    world:restore(before)
    world:step()
    if world:checksum() ~= once then error(("scene %d, step %d: another state"):format(i, step)) end
    n = n + 1
  end
  world:close()
end
print(n .. " steps taken twice")
LUA
steps=100; [ "${DIGBOX_FULL:-0}" = 1 ] && steps=1000
sed -i "s/STEPS/$steps/" rewind.lua
gives 0 'each step twice' run -q rewind.lua;             printed "$((12 * steps)) steps taken twice"

# ---- D5: pictures by any number of threads, with wide and narrow vectors ----
if "$DIGBOX" doctor 2>/dev/null | grep -q '^ok *renderer'; then
    cat >scene.lua <<'LUA'
local world = require("digbox").world {}
world:floor { material = "tile" }
for i = 1, 5 do world:ball { radius = 0.2, at = { 0.5 * i, 0.2, 0 }, material = "steel" } end
world:sun { from = { 3, 6, 2 }, shadows = true }
world:camera { at = { 2, 1.5, 3 }, look_at = { 1.5, 0.2, 0 } }
for _, samples in ipairs { 0, 4 } do world:render { to = ("p%d.png"):format(samples), size = { 160, 90 }, samples = samples } end
LUA
    for how in LP_NUM_THREADS=0 LP_NUM_THREADS=1 LP_NUM_THREADS=8 LP_NATIVE_VECTOR_WIDTH=128; do
        env "$how" "$DIGBOX" run -q -o "${how#*_}" scene.lua >out.txt 2>err.txt </dev/null
        for picture in p0 p4; do
            [ "$how" = LP_NATIVE_VECTOR_WIDTH=128 ] && continue          # says another renderer in its texts
            holds "$how: $picture is the same" cmp "NUM_THREADS=0/$picture.png" "${how#*_}/$picture.png"
        done
    done
    if command -v ffmpeg >/dev/null; then                               # pixels: at most 2 of 255 levels apart
        for picture in NUM_THREADS=0/p0 NUM_THREADS=0/p4 NATIVE_VECTOR_WIDTH=128/p0 NATIVE_VECTOR_WIDTH=128/p4; do
            ffmpeg -nostdin -loglevel error -y -i $picture.png -f rawvideo -pix_fmt rgb24 $picture.raw
        done
        for p in p0 p4; do
            cmp -l NUM_THREADS=0/$p.raw NATIVE_VECTOR_WIDTH=128/$p.raw |
                awk 'function octal(d) { return 64 * int(d / 100) + 8 * (int(d / 10) % 10) + d % 10 }
                     { a = octal($2) - octal($3); if (a < 0) a = -a; if (a > most) most = a } END { print most + 0 }' >most.txt
            holds "vectors of 128 bits: $p is off by $(cat most.txt) levels" test "$(cat most.txt)" -le 2 -a -s NATIVE_VECTOR_WIDTH=128/$p.raw
        done
    fi
fi
checked
