#!/usr/bin/env bash
# tests/film/soak.sh - long films of small pictures (docs/frames.md).
#
#   DIGBOX=build/digbox tests/film/soak.sh FRAMES RESUMED [LAYER]        0 frames: without that part; LAYER id is drawn in a quarter of the time
#
# F13: while FRAMES frames are written, memory (RSS) and open files stay as they are from a tenth of it on, and the last twentieth takes
#      at most 1.1 times the CPU time of the first.
# F7:  of a film of RESUMED frames 7 are taken away, 3 damaged and 1 replaced by a foreign picture; --resume draws the ten, names the
#      damaged and the foreign, and leaves the rest alone; another seed is refused.
set -u
frames=${1:-100000} resumed=${2:-10000} layer=${3:-colour}
work=$(mktemp -d "${TMPDIR:-/tmp}/digbox-film-XXXXXX")
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 2
export LP_NUM_THREADS=0 MESA_SHADER_CACHE_DISABLE=true
passed=0 failed=0
holds() {       # holds WHAT COMMAND...
    local what=$1
    shift
    if "$@"; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "not so: $what"; fi
}
within() { awk "BEGIN { exit !($1 <= $2) }"; }

cat >film.lua <<LUA
local digbox = require "digbox"
local opt = digbox.args { frames = { default = 100 } }
local world = digbox.world { step = 1 / 60 }
world:floor {}
local ball = world:ball { radius = 0.1, at = { 0, 0.1, 0 } }
world:camera { at = { 1, 0.6, 2 }, look_at = { 0, 0, 0 } }
world:record { to = "f-%06d.png", fps = 60, size = { 32, 18 }, samples = 0, layer = "$layer" }
for i = 1, opt.frames - 1 do
  if i % 60 == 0 then ball:hit { impulse = { 0, ball.mass * 2, 0 } } end         -- so that frames differ
  world:step()
end
LUA

# ---- F13 ----
if [ "$frames" -gt 0 ]; then
"$DIGBOX" run -q -o long film.lua --set "frames=$frames" >/dev/null 2>err.txt </dev/null & pid=$!
part=$((frames / 20))
echo "frames  CPU s  RSS KiB  files"
for mark in $(seq "$part" "$part" $((frames - 1)) | head -n 19); do
    frame=long/f-$(printf %06d "$mark").png
    while [ ! -e "$frame" ] && kill -0 $pid 2>/dev/null; do sleep 0.05; done
    child=$(pgrep -P $pid | head -n 1)
    [ -n "$child" ] && [ -r "/proc/$child/stat" ] || break
    cpu=$(awk '{ sub(/^.*\) /, ""); print ($12 + $13) / 100 }' "/proc/$child/stat")
    rss=$(awk '/^VmRSS/ { print $2 }' "/proc/$child/status")
    # the least of some: one is open while a frame is written
    files=$(for _ in 1 2 3 4 5 6 7 8; do ls "/proc/$child/fd" | wc -l; sleep 0.01; done | sort -n | head -n 1)
    echo "$mark $cpu $rss $files" | tee -a samples.txt
done
wait $pid
holds "the film of $frames frames ends well: $(head -n 1 err.txt)" test $? = 0
holds 'all its frames are there' test "$(find long -name '*.png' | wc -l)" = "$frames"
holds 'verify' "$DIGBOX" verify long
read -r growth files first last < <(awk '{ cpu[NR] = $2; rss[NR] = $3; files[NR] = $4 }
    END { print rss[NR] / rss[2], files[NR] - files[2], (cpu[3] - cpu[1]) / 2, (cpu[NR] - cpu[NR - 2]) / 2 }' samples.txt)
echo "F13: from $((2 * part)) to $((19 * part)) frames RSS times $growth, files plus $files; CPU s per $part frames: $first at first, $last at last"
holds 'RSS is flat within 2 %' within "$growth" 1.02
holds 'no file is left open' test "$files" -le 0
holds 'the last frames take at most 1.1 times what the first took' within "$last" "1.1 * $first"
rm -rf long
fi
if [ "$resumed" -eq 0 ]; then
    echo "$passed passed, $failed failed"
    exit $((failed > 0))
fi

# ---- F7 ----
"$DIGBOX" run -q -o whole film.lua --set "frames=$resumed" </dev/null || failed=$((failed + 1))
cp -r whole holes
name() { printf 'holes/f-%06d.png' $(($1 * resumed / 100)); }
for i in 1 13 14 37 58 71 99; do rm "$(name $i)"; done
for i in 5 44 90; do head -c 300 "$(name $i)" >cut && cp cut "$(name $i)"; done
# a foreign picture: one pixel, by hand
printf '\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\1\0\0\0\1\x08\0\0\0\0\x3a\x7e\x9b\x55\0\0\0\nIDATx\x9cc`\0\0\0\2\0\1\x48\xaf\xa4\x71\0\0\0\0IEND\xaeB`\x82' >mine.png
cp mine.png "$(name 66)"
"$DIGBOX" run -o holes --resume film.lua --set "frames=$resumed" >/dev/null 2>err.txt </dev/null
holds 'resume' test $? = 0
holds "it draws ten: $(tail -n 1 err.txt)" grep -q "$((resumed - 11)) frames were there, 10 were drawn" err.txt
for i in 5 44 90; do holds "$(name $i) is named" grep -qF "$(name $i) is damaged and is drawn again" err.txt; done
holds 'the foreign one is named' grep -qF "$(name 66) was not made by digbox" err.txt
holds 'and stays' cmp -s mine.png "$(name 66)"
cp "whole/$(basename "$(name 66)")" "$(name 66)"
holds 'all else is as it would have been' diff -r whole holes
"$DIGBOX" run -q -o holes --resume --seed 7 film.lua --set "frames=$resumed" >/dev/null 2>err.txt </dev/null
holds 'another seed: exit code 2' test $? = 2
holds 'with the difference' grep -q 'wanted: seed: 7' err.txt
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
