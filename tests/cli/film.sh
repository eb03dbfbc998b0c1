#!/usr/bin/env bash
# tests/cli/film.sh - frames as files (docs/frames.md; cases F3 to F15): runs that are cut at any moment and resumed, films that are
# there, folders that cannot be written, names and sizes that make no sense, two runs at once, and digbox verify.
#
# DIGBOX_FULL=1: 200 kills and 50 Ctrl-C instead of a few.
set -u
. "${0%/*}/../check.sh"
export LP_NUM_THREADS=0 MESA_SHADER_CACHE_DISABLE=true
FULL=${DIGBOX_FULL:-0}

cat >roll.lua <<'LUA'
local digbox = require "digbox"
local opt = digbox.args { to = { default = "f-%05d.png" }, width = { default = 48 } }
local world = digbox.world {}
world:floor {}
local ball = world:ball { radius = 0.1, at = { 0, 0.3, 0 }, velocity = { 1, 0, 0 } }
world:camera { at = { 1, 0.6, 2 }, look_at = ball, follow = ball }
world:record { to = opt.to, fps = 100, size = { opt.width, 32 }, samples = 0, overlay = { "time" } }
world:run "0.8 s"
LUA
gives 0 'a film that is not cut' run -q -o whole roll.lua
holds '81 frames and a manifest' test "$(ls whole | wc -l)" = 82
gives 0 'verify' verify whole;              printed 'whole/f-manifest.sha256: 81 frames: all as they were written'
holds 'sha256sum reads the manifest' bash -c 'cd whole && sha256sum --quiet --strict -c f-manifest.sha256'

# same FOLDER: its final names hold what the film that was not cut holds; prints what does not.
same() { for f in "$1"/*.png; do [ ! -e "$f" ] || cmp -s "$f" "whole/${f##*/}" || echo "$f"; done; }
# whole_film FOLDER: the same files, nothing else.
whole_film() { diff -r "$1" whole; }

# ---- F8, --force: a film that is there ----
gives 2 'no film is overwritten' run -q -o whole roll.lua;      said '81 frames of an earlier run are there; --resume goes on with them, --force takes them anew'
holds 'nothing changed' test -z "$(same whole)"
cp -r whole again
gives 0 'force' run -q -o again --force --seconds 0.1 roll.lua
holds 'frames of the longer film are gone' test "$(ls again/*.png | wc -l)" = 11
rm again/f-manifest.sha256
gives 2 'frames without a manifest' run -q -o again roll.lua;   said 'again/f-00000.png is there already'
gives 2 'both' run --force --resume roll.lua;                   said 'one of them'
mkdir used && echo mine >used/notes.txt
gives 0 'other files are none of its business' run -q -o used --seconds 0.05 roll.lua
holds 'they stay' grep -q mine used/notes.txt

# ---- F7: a film with holes, damage and a foreign picture ----
cp -r whole holes
rm holes/f-000{03,17,18,50,59,66,80}.png
for n in 00005 00076; do head -c 700 whole/f-$n.png >holes/f-$n.png; done
printf 'X' | dd of=holes/f-00071.png bs=1 seek=900 conv=notrunc status=none
gives 0 'resume' run -o holes --resume roll.lua
holds 'of frames that differ nothing is said' test "$(grep -cE 'one colour|same picture' err.txt)" = 0
for n in 00005 00076 00071; do said "holes/f-$n.png is damaged and is drawn again"; done
said '71 frames were there, 10 were drawn'
holds 'all is as it would have been' whole_film holes
printf 'local w = require("digbox").world {}\nw:ball { radius = 1 }\nw:render { to = "x.png", size = { 48, 32 } }' >other.lua
gives 0 'another picture' run -q -o other other.lua
sed -i 's/digbox /hatbox /' other/x.png; cp other/x.png holes/f-00042.png
gives 0 'resume over a damaged one' run -q -o holes --resume roll.lua;      said 'f-00042.png is damaged'
if command -v ffmpeg >/dev/null; then
    ffmpeg -nostdin -loglevel error -y -i other/x.png mine.png; cp mine.png holes/f-00042.png
    gives 0 'resume over a foreign one' run -q -o holes --resume roll.lua;  said 'holes/f-00042.png was not made by digbox; it stays as it is'
    holds 'it stays' cmp mine.png holes/f-00042.png
    gives 8 'which verify sees' verify holes;                              printed 'frame 42: holes/f-00042.png'
fi
gives 2 'another seed' run -q -o whole --resume --seed 5 roll.lua;          said 'there:  seed: 1'; said 'wanted: seed: 5'
gives 2 'another size' run -q -o whole --resume --set width=50 roll.lua;    said 'wanted: set: {"width":"50"}'
{ cat roll.lua; echo '-- changed'; } >changed.lua; mkdir -p elsewhere; mv changed.lua elsewhere/roll.lua
gives 2 'another script' run -q -o whole --resume elsewhere/roll.lua;       said 'script hash'
holds 'nothing changed' whole_film whole whole
# What no line of the manifest tells: a module that was changed, a world that goes another way.
echo 'return { colour = "red", height = 1 }' >part.lua
cat >modular.lua <<'LUA'
local part = require "part"
local world = require("digbox").world {}
world:ball { radius = 0.1, at = { 0, part.height, 0 } }
world:record { to = "m-%02d.png", fps = 60, size = { 32, 18 }, samples = 0 }
world:step(5)
LUA
gives 0 'a world of two files' run -q -o modular modular.lua
echo 'return { colour = "blue", height = 1 }' >part.lua
gives 2 'another module' run -q -o modular --resume modular.lua;            said 'frame 0 (modular/m-00.png) shows another scene'
echo 'return { colour = "red", height = 2 }' >part.lua
gives 2 'another world' run -q -o modular --resume modular.lua;             said 'shows another world'

# ---- F4, F5, F6: cut at any moment ----
# cut SIGNAL FRAME MS FOLDER: a run that gets it so many ms after that frame is there (-1: after its start); leaves its exit code in $code.
cut() {
    "$DIGBOX" run -q -o "$4" --resume roll.lua >out.txt 2>err.txt </dev/null &
    local pid=$! frame
    frame=$4/f-$(printf %05d "${2#-}").png
    while [ "$2" -ge 0 ] && [ ! -e "$frame" ] && kill -0 $pid 2>/dev/null; do sleep 0.01; done
    sleep "$(printf '0.%03d' "$3")"
    kill "-$1" $pid 2>/dev/null
    wait $pid 2>/dev/null
    code=$?
}
judge() {       # judge FOLDER: files whole, manifest holds
    local bad
    bad=$(same "$1")
    [ -z "$bad" ] || { echo "torn or wrong: $bad"; failed=$((failed + 1)); }
    [ ! -e "$1/f-manifest.sha256" ] || "$DIGBOX" verify "$1" >verify.txt 2>&1 || { cat verify.txt; failed=$((failed + 1)); }
}
RANDOM=9
[ "$FULL" = 1 ] && kills=200 breaks=50 || kills=4 breaks=2
mkdir -p killed broken
cuts=0
for i in $(seq $kills); do
    # every fourth while it starts; the others a few frames beyond what is there, until the film begins again
    there=$(find killed -name '*.png' 2>/dev/null | wc -l)
    if [ "$there" -gt 70 ]; then rm -rf killed; there=0; fi
    if [ $((i % 4)) = 0 ]; then cut KILL -1 $((RANDOM % 600)) killed; else cut KILL $((there + RANDOM % 8)) $((RANDOM % 20)) killed; fi
    [ $code = 137 ] && cuts=$((cuts + 1))
    judge killed
done
holds "kills that hit: $cuts of $kills" test $cuts -ge $((kills / 2))
gives 0 'and to its end' run -q -o killed --resume roll.lua
holds "all is as it would have been after $kills kills" whole_film killed
hits=0
for i in $(seq $breaks); do
    rm -rf broken
    cut INT $((RANDOM % 60 - 1)) $((RANDOM % 20)) broken
    [ $code = 130 ] && hits=$((hits + 1))
    [ $code = 130 ] || [ $code = 0 ] || { echo "Ctrl-C: exit code $code"; failed=$((failed + 1)); }
    judge broken
    [ -z "$(find broken -name '.*' -type f 2>/dev/null)" ] || { echo "Ctrl-C leaves a draft"; failed=$((failed + 1)); }
done
holds "Ctrl-C that hit: $hits of $breaks" test $hits -ge $((breaks / 2))
gives 0 'and to its end' run -q -o broken --resume roll.lua
holds 'all is as it would have been after Ctrl-C' whole_film broken
for signal in TERM:143 HUP:129; do
    rm -rf broken
    cut "${signal%:*}" 30 5 broken
    holds "${signal%:*}: exit code ${signal#*:} (got $code)" test $code = "${signal#*:}"
    judge broken
    holds 'no draft is left' test -z "$(find broken -name '.*' -type f)"
done

# Ctrl-C twice ends at once; a reader that goes away ends nothing.
sed 's/"0.8 s"/"1000 s"/' roll.lua >long.lua
"$DIGBOX" run -q -o twice long.lua >/dev/null 2>&1 </dev/null & pid=$!
for _ in $(seq 200); do [ -e twice/f-00000.png ] && break; sleep 0.05; done
kill -INT $pid; kill -INT $pid; wait $pid; code=$?
holds "Ctrl-C twice: exit code 130 (got $code)" test $code = 130
gives 0 'its frames are whole' verify twice
sed 's/^world:run.*/for i = 1, 48 do for _ = 1, 400 do print("a line that nobody reads", i) end world:step() end/' roll.lua >talk.lua
{ "$DIGBOX" run -q -o piped talk.lua 2>err.txt; echo $? >code; } </dev/null | head -n 1 >/dev/null
holds "a reader that goes away: exit code 0 or 141 (got $(cat code))" grep -qxE '0|141' code
holds 'and nothing is said' test ! -s err.txt
gives 0 'its film is complete' verify piped;                    printed '81 frames: all'

# A run that dies while its supervisor lives
"$DIGBOX" run -q -o died long.lua >/dev/null 2>err.txt </dev/null & pid=$!
for _ in $(seq 200); do [ -e died/f-00002.png ] && break; sleep 0.05; done
kill -KILL "$(pgrep -P $pid)"; wait $pid; code=$?
holds "a run that died: exit code 11 (got $code)" test $code = 11
gives 0 'its frames are whole' verify died
if command -v ffmpeg >/dev/null; then
    sed 's/f-%05d.png/v.mp4/' long.lua >video.lua
    "$DIGBOX" run -q -o video video.lua >/dev/null 2>&1 </dev/null & pid=$!
    for _ in $(seq 200); do ls -A video 2>/dev/null | grep -q . && break; sleep 0.05; done
    sleep 0.5; kill -KILL $pid; wait $pid 2>/dev/null
    holds 'a killed video has no name' test ! -e video/v.mp4
    for _ in $(seq 100); do pgrep -f "video/.digbox-.*v.mp4" >/dev/null || break; sleep 0.05; done
    gives 0 'the next run does not mind' run -q -o video --seconds 0.1 video.lua
    holds 'and clears up' test "$(ls -A video)" = v.mp4
    cp video/v.mp4 v.mp4
    gives 2 'a video is not overwritten' run -q -o video --seconds 0.1 video.lua;   said 'video/v.mp4: a film is there; --force takes it anew'
    holds 'nothing changed' cmp v.mp4 video/v.mp4
    gives 0 'but with --force' run -q -o video --force --seconds 0.1 video.lua
    holds 'it is the same again' cmp v.mp4 video/v.mp4
    # Two at once: the second ffmpeg must not hold the pipe of the first, whose end would never come.
    cat >two.lua <<'LUA'
local digbox = require "digbox"
local world, opt = digbox.world {}, digbox.args { seconds = 0.3 }
world:ball { radius = 0.1, at = { 0, 1, 0 } }
for _, name in ipairs { "a", "b" } do world:record { to = name .. ".mp4", fps = 30, size = { 32, 18 }, samples = 0 } end
world:run(opt.seconds)
LUA
    gives 0 'two videos at once' run -q -o two --time-limit 60 two.lua
    holds 'both are there, and nothing else' test "$(ls -A two | tr '\n' ' ')" = 'a.mp4 b.mp4 '
    gives 5 'two videos that take too long' run -q -o late --time-limit 1 --set seconds=1e5 two.lua
    for _ in $(seq 100); do pgrep -f 'late/.digbox-.*mp4' >/dev/null || break; sleep 0.05; done
    holds 'no ffmpeg lingers' test -z "$(pgrep -f 'late/.digbox-.*mp4')"
fi

# A draft of a killed process is swept away, one that is being written is not.
mkdir -p swept && echo torn >swept/.digbox-1-0-f-00000.png.tmp && echo busy >swept/.digbox-2-0-f-00001.png.tmp
exec 9<swept/.digbox-2-0-f-00001.png.tmp && flock 9
gives 0 'a folder with drafts' run -q -o swept --seconds 0.05 roll.lua
holds 'the torn one is gone, the other is there' test "$(find swept -name '.*' -type f)" = swept/.digbox-2-0-f-00001.png.tmp
exec 9<&-

# ---- F14: two runs, one film ----
"$DIGBOX" run -q -o both long.lua >/dev/null 2>&1 </dev/null & first=$!
for _ in $(seq 200); do [ -e both/f-00000.png ] && break; sleep 0.05; done
gives 2 'the second run' run -q -o both --force long.lua;       said 'both/f-manifest.sha256: its film is in use by process '
holds 'which is the first' test "$(sed -n 's/.*process \([0-9]*\).*/\1/p' err.txt)" = "$(pgrep -P $first)"
gives 0 'another film beside it' run -q -o both --seconds 0.05 --set 'to=g-%03d.png' roll.lua
kill -INT $first; wait $first

# ---- F3, F1: no room ----
(ulimit -f 8; exec "$DIGBOX" run -q -o limited --set width=3000 roll.lua) >out.txt 2>err.txt </dev/null
code=$?
holds "RLIMIT_FSIZE: exit code 9 (got $code)" test $code = 9
said 'File too large'; said 'frame 0: limited/f-00000.png'; said '0 frames are complete'
holds 'nothing torn' test "$(ls -A limited)" = f-manifest.sha256
for device in /dev/full; do
    mkdir -p devices && ln -sf $device devices/f-00001.png
    gives 9 "a link to $device for a frame" run -q -o devices --force roll.lua;     said 'frame 1: devices/f-00001.png: exists and is not an ordinary file; 1 frames are complete'
    holds 'it is still there' test -L devices/f-00001.png
done
if mkdir -p small && mount -t tmpfs -o size=100k none small 2>/dev/null; then
    gives 9 'a full disk' run -q -o small/out roll.lua;     said 'No space left on device'
    judge small/out
    mount -o remount,size=4m small
    gives 0 'with room' run -q -o small/out --resume roll.lua
    holds 'all is as it would have been' whole_film small/out
    umount small
fi

# ---- F2, F9: names ----
mkfifo pipe.png; mkdir -p named; mv pipe.png named/f-00000.png
gives 9 'a pipe for a frame' run -q -o named --force roll.lua;   said 'is not an ordinary file'
if [ "$(id -u)" != 0 ]; then
    mkdir -p closed && chmod 555 closed
    gives 9 'a folder that may not be written' run -q -o closed roll.lua;   said 'closed/f-manifest.sha256: Permission denied'
fi
touch afile
gives 9 'a file for a folder' run -q -o afile roll.lua
long=$(printf 'x%.0s' $(seq 300))
for bad in '../%d.png' '/etc/%d.png' 'a/../../%d.png' '%s.png' '%n.png' '%999999d.png' 'none.png' '%d%d.png' '%d/' 'f-%5d.png' '%x.png' ''; do
    gives 1 "the name '$bad'" run -q -o named --set "to=$bad" roll.lua
done
gives 1 'a name of 5,000 bytes' run -q -o named --set "to=$(printf 'y%.0s' $(seq 5000))%d.png" roll.lua;    said 'bytes, must have at most'
gives 9 'a name of 300 bytes' run -q -o named --set "to=$long%d.png" roll.lua;                              said 'File name too long'
gives 0 'a name of 230 bytes' run -q -o named --seconds 0.02 --set "to=${long:0:230}%d.png" roll.lua
gives 0 'a folder for each frame' run -q -o deep --seconds 0.05 --set 'to=shot-%02d/a/eye.png' roll.lua
gives 0 'is verified' verify deep;                          printed 'deep/shot-manifest-a-eye.sha256: 6 frames' || ls deep
gives 0 'and resumed' run -q -o deep --resume --seconds 0.1 --set 'to=shot-%02d/a/eye.png' roll.lua
gives 0 'is verified' verify deep;                          printed '11 frames'

# ---- F10: sizes ----
for bad in 0 -1 16385 2147483648 1.5 '{}' nan; do
    sed "s/opt.width, 32/tonumber '$bad' or {}, 32/" roll.lua >size.lua
    gives 1 "the width $bad" run -q -o sizes size.lua;      said 'must be a whole number from 1 to 16384'
done
cat >need.lua <<'LUA'
local world = require("digbox").world {}
world:ball { radius = 1 }
world:record { to = "f-%d.png", fps = 60, size = { 16384, 16384 }, samples = 4 }
print "begun"
world:step(600)
LUA
gives 1 'pictures for which there is no memory' run -q -o sizes --memory-limit 64 need.lua
said 'world:record: a picture of 16384 x 16384 pixels with 4 samples each needs about 12.6 GiB of memory, here are at most 0.8 GiB'
holds 'are refused before anything is done' test ! -s out.txt -a ! -e sizes
gives 0 'a width of one pixel' run -q -o sizes --seconds 0.02 --set width=1 roll.lua
holds 'nothing else was written' test "$(ls sizes | wc -l)" = 5

# ---- F12: frames that show nothing, or always the same ----
cat >still.lua <<'LUA'
local world = require("digbox").world { gravity = { 0, 0, 0 } }
world:ball { name = "b", radius = 0.1, at = { 0, 0, 0 } }
world:camera { at = { 0, 0, 9 }, look_at = { 0, 0, 20 } }
world:sky "black"
world:record { to = "f-%03d.png", fps = 60, size = { 8, 8 }, samples = 0 }
world:step(101)
LUA
gives 0 'a black film' run -o still still.lua
said 'f-%03d.png: 102 frames have one colour, the first is frame 0'; said '102 frames from frame 0 on show the same picture'
holds 'is written' test "$(ls still | wc -l)" = 103

# ---- F15: verify ----
cp -r whole bad
printf 'X' | dd of=bad/f-00070.png bs=1 seek=500 conv=notrunc status=none
gives 8 'a frame with another byte' verify bad;             printed 'frame 70: bad/f-00070.png is not what was written'
rm bad/f-00060.png
gives 8 'the first of two' verify bad;                      printed 'frame 60: bad/f-00060.png: No such file'; printed 'others differ, too'
cp whole/f-manifest.sha256 list
manifest() { mkdir -p lists && rm -f lists/* && cat >lists/f-manifest.sha256; }
sed 's|f-00003.png|../list|' list | manifest
gives 8 'a name outside' verify lists;                      said 'lists/f-manifest.sha256:22: is not what digbox writes'
sed 's|f-00003.png|/etc/passwd|' list | manifest;           gives 8 'an absolute name' verify lists
sed '20s/[0-9] bytes/9 bytes/' list | manifest;             gives 8 'another size' verify lists
head -c 2000 list | manifest;                               gives 8 'frames that are not there' verify lists
tr 'a' '\0' <list | manifest;                               gives 8 'not text' verify lists
: | manifest;                                               gives 0 'nothing' verify lists; printed '0 frames of a film that was cut'
gives 8 'no manifest' verify named/a;                       gives 8 'no folder' verify nowhere.sha256
for n in 1500; do
    rm -rf cut; cp -r whole cut; head -c $n list >cut/f-manifest.sha256
    gives 0 "a manifest of $n bytes" verify cut;            printed 'of a film that was cut'
    gives 0 'is gone on with' run -q -o cut --resume roll.lua
    holds 'all is as it would have been' whole_film cut
done

checked
