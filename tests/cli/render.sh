#!/usr/bin/env bash
# tests/cli/render.sh - digbox render: a replay's frames are those of the run's own film, whatever the split; resuming; bad input.
set -u
. "${0%/*}/../check.sh"

cat >fall.lua <<'LUA'
local digbox = require "digbox"
local world = digbox.world {}
world:floor {}
local ball = world:ball { name = "ball", radius = 0.1, at = { 0, 0.4, 0 }, velocity = { 1, 0, 0 } }
local eye = world:camera { name = "eye", at = { 1, 0.6, 2 }, look_at = ball, follow = ball }
world:camera { name = "side", at = { 3, 0.5, 0 }, look_at = { 0, 0.2, 0 } }
world:record { camera = eye, to = "film-%05d.png", fps = 47, size = { 96, 54 }, overlay = { "time" } }
world:run "0.3 s"
LUA

export MESA_SHADER_CACHE_DISABLE=true LP_NUM_THREADS=0
gives 0 'a run with a replay and a film' run -q -o film --replay fall.replay fall.lua
if [ ! -e film/film-00000.png ]; then      # a build without pictures refuses
    gives 2 'render without a renderer' render fall.replay
    said 'RENDER=0'
    checked
    exit
fi

# The image data alone: the texts before it differ.
image() { tr -d '\n' <"$1" | LC_ALL=C sed 's/.*IDAT//' | md5sum; }
gives 0 'two processes' render fall.replay -j 2 -o two/f-%05d.png
frames=$(ls film/*.png | wc -l)
holds 'as many frames as the film has, and a manifest' test "$(ls two | wc -l)" = $((frames + 1))
for n in 00000 00001 00007; do
    holds "frame $n is the film's" test "$(image "film/film-$n.png")" = "$(image "two/f-$n.png")"
done
gives 0 'one process' render fall.replay -o one/f-%05d.png;                 said "digbox: one/f-%05d.png: $frames frames"
gives 0 'a part, quietly' render fall.replay -q -o one/part-%05d.png --frames 5..8
holds 'not a word' test ! -s err.txt
for f in two/*; do holds "$f does not depend on the split" cmp "$f" "one/${f#two/}"; done
holds 'four frames' test "$(ls one/part-*.png | wc -l)" = 4
gives 0 'verify' verify two one;        printed "two/f-manifest.sha256: $frames frames: all"; printed 'one/part-manifest-5-8.sha256: 4 frames: all'
holds 'sha256sum reads the manifests' bash -c 'cd one && sha256sum --quiet --strict -c *.sha256'
gives 2 'no film is overwritten' render fall.replay -o two/f-%05d.png;      said "$frames frames of an earlier run are there"
gives 2 'nor a part of one' render fall.replay -o one/part-%05d.png --frames 5..8
gives 0 'a part beside it' render fall.replay -o one/part-%05d.png --frames 9..9
gives 2 'frames without a manifest' render fall.replay -o film/film-%05d.png --frames 2..3; said 'film/film-00002.png is there already'
gives 2 'both' render fall.replay --force --resume;                         said 'one of them'
holds 'the part is the same' cmp one/part-00006.png two/f-00006.png
gives 0 'another camera' render fall.replay --camera side -o side/f-%05d.png --frames 3..3
gives 0 'another film' render fall.replay -o part3/f-%05d.png --frames 3..3
gives 0 'force' render fall.replay --camera side -o part3/f-%05d.png --frames 3..3 --force
holds 'takes it anew' cmp part3/f-00003.png side/f-00003.png
holds 'shows something else' test "$(md5sum <side/f-00003.png)" != "$(md5sum <two/f-00003.png)"
gives 0 'motion blur' render fall.replay --blur 4 -o blur/f-%05d.png --frames 3..3
holds 'differs' test "$(md5sum <blur/f-00003.png)" != "$(md5sum <two/f-00003.png)"

# Trails and energies show what was before, and nothing of what comes: a live film, that of its replay, and a longer run's are the same.
cat >past.lua <<'LUA'
local digbox = require "digbox"
local world = digbox.world {}
world:floor {}
local ball = world:ball { name = "ball", radius = 0.1, at = { 0, 1, 0 }, velocity = { 1, 0, 0 } }
local box = world:box { size = 0.2, at = { -0.6, 0.6, 0 }, velocity = { 2, 2, 0.3 }, spin = { 1, 4, 2 } }
world:camera { at = { 1, 1, 3 }, look_at = { 0.3, 0.4, 0 } }
world:run "0.11 s"
box:teleport { velocity = { 1, 3, 0 } }       -- between a step and the film's begin
world:record { to = "late-%05d.png", fps = 47, size = { 96, 54 }, overlay = { "trails", "energy" } }
world:run "0.3 s"
box:remove()
world:ball { radius = 0.05, at = { 0.3, 1, 0 }, velocity = { 0, 1, 0 } }
ball:teleport { velocity = { 1, 2, 0 } }
world:run(digbox.args { rest = { default = 0.4, unit = "s", help = "how long" } }.rest)
world:render { to = "end.png", size = { 96, 54 }, overlay = "trails" }
ball:teleport { at = { 0, 1, 0 } }
LUA
gives 0 'a film that shows the past' run -q -o past --replay past.replay past.lua
gives 0 'and of its replay' render past.replay -j 2 -o again/f-%05d.png
late=(past/late-*.png) again=(again/f-*.png)
holds 'it began later' test "${#late[@]}" -lt "${#again[@]}"
for ((k = 0; k < ${#late[@]}; k++)); do
    there=${again[k + ${#again[@]} - ${#late[@]}]}
    holds "${late[k]} is $there" test "$(image "${late[k]}")" = "$(image "$there")"
done
gives 0 'without the past' render past.replay -o now/f-%05d.png --overlay time --frames 20..20
holds 'something else' test "$(image now/f-00020.png)" != "$(image again/f-00020.png)"
gives 0 'a longer run' run -q -o longer past.lua --set rest=1.2
for f in past/late-*[05].png; do
    [ "$f" = "${late[-1]}" ] || holds "$f does not know the future" test "$(image "$f")" = "$(image "longer/${f#past/}")"
done
printf 'local w = require("digbox").world {}\nw:floor {}\nw:run(0.1)\nw:render { to = "a.png", overlay = "energy" }\n' >early.lua
gives 1 'a picture of what nobody kept' run -q early.lua;  said 'begin a film with that overlay first'

# Resuming: what is missing or damaged is drawn again, what is foreign stays, other options are refused.
rm two/f-00002.png
head -c 700 one/f-00004.png >two/f-00004.png
cp film/film-00000.png two/f-00005.png
gives 8 'verify sees it' verify two;    printed 'frame 2: two/f-00002.png: No such file'
gives 0 'resuming' render fall.replay -j 2 -o two/f-%05d.png --resume
said 'two/f-00004.png is damaged'
said 'two/f-00005.png was not made by digbox render'
holds 'the missing one is there' cmp one/f-00002.png two/f-00002.png
holds 'the damaged one is whole' cmp one/f-00004.png two/f-00004.png
holds 'the foreign one is as it was' cmp film/film-00000.png two/f-00005.png
gives 2 'resuming with other options' render fall.replay -o two/f-%05d.png --resume --size 80x45
said 'there:  picture: '; said 'wanted: picture: '
gives 8 'the foreign one is not the film' verify two;                       printed 'frame 5: two/f-00005.png'
rm two/f-00005.png
gives 0 'resuming to the end' render fall.replay -o two/f-%05d.png --resume;    said "$((frames - 1)) frames were there, 1 were drawn"
for f in two/*; do holds "$f is as if it had not been cut" cmp "$f" "one/${f#two/}"; done
# Films that were drawn before there were manifests are gone on with, too.
rm two/f-manifest.sha256 two/f-00003.png
gives 0 'resuming without a manifest' render fall.replay -o two/f-%05d.png --resume
for f in two/*; do holds "$f is as with one" cmp "$f" "one/${f#two/}"; done
rm two/f-manifest.sha256
gives 2 'which tells other options as well' render fall.replay -o two/f-%05d.png --resume --size 80x45;     said 'was drawn otherwise'

# ---- cut at any moment: by SIGKILL, by Ctrl-C, by a full disk; a worker does not outlive the process it works for ----
for i in 1 2 3 4; do
    "$DIGBOX" render fall.replay -j 2 -o "killed-$$/f-%05d.png" --resume --size 640x360 >/dev/null 2>&1 </dev/null & pid=$!
    for _ in $(seq 200); do [ -e "killed-$$/f-0000$((3 * i - 2)).png" ] && break; sleep 0.02; done
    if [ "$i" = 4 ]; then kill -INT $pid 2>/dev/null; else pkill -KILL -P $pid; kill -KILL $pid 2>/dev/null; fi
    wait $pid 2>/dev/null; code=$?
    [ "$i" -lt 4 ] || [ "$code" = 0 ] || holds "Ctrl-C: exit code 130 (got $code)" test "$code" = 130
    for _ in $(seq 100); do pgrep -f "killed-$$/f-" >/dev/null || break; sleep 0.05; done      # on a busy machine it takes a moment to die
    holds "cut $i leaves no worker" test -z "$(pgrep -f "killed-$$/f-" | head -n 1)"
    "$DIGBOX" verify killed-$$ >verify.txt 2>&1 || { cat verify.txt; failed=$((failed + 1)); }
done
gives 0 'and to its end' render fall.replay -o killed-$$/f-%05d.png --resume --size 640x360
gives 0 'the same at once' render fall.replay -o atonce/f-%05d.png --size 640x360
holds 'all is as it would have been' diff -r killed-$$ atonce
(ulimit -f 4; exec "$DIGBOX" render fall.replay -j 2 -o limited/f-%05d.png --size 640x360) >out.txt 2>err.txt </dev/null
code=$?
holds "a file-size limit: exit code 9 (got $code)" test $code = 9
said 'File too large'; said 'go on with --resume'
holds 'nothing torn' test -z "$(find limited -name '*.png')"

if command -v ffmpeg >/dev/null; then
    gives 0 'a film' render fall.replay -j 2 -o a.mp4
    gives 0 'the same film by one process' render fall.replay -o b.mp4
    holds 'byte for byte' cmp a.mp4 b.mp4
    gives 0 'another kind of film' render fall.replay -o c.webm --frames 0..5
    if command -v ffprobe >/dev/null; then
        for film in a.mp4:h264:$frames c.webm:vp9:6; do
            got=$(ffprobe -v error -count_frames -show_entries stream=codec_name,nb_read_frames -of csv=p=0 "${film%%:*}")
            holds "$film: a player reads it (got $got)" test "${film%%:*}:${got/,/:}" = "$film"
        done
    fi
fi

gives 8 'no such file' render nowhere.replay;                       said 'nowhere.replay: cannot be read'
gives 8 'not a replay' render fall.lua;                             said 'not a replay'
gives 2 'an unknown camera' render fall.replay --camera syde;       said "unknown camera 'syde' (did you mean 'side'?)"
gives 2 'frames that are not there' render fall.replay --frames 3..999; said 'there are frames 0..'
gives 2 'frames that go backwards' render fall.replay --frames 5..3; said '5..3 goes backwards'
gives 2 'a size' render fall.replay --size big;                     said "--size: 'big' is not of the form 1280x720"
gives 2 'a name without a number' render fall.replay -o f.png;      said 'needs a place for the number'
gives 2 'no replay' render;                                         said 'which replay'

# A run that filmed nothing has a camera all the same.
printf 'local w = require("digbox").world {}\nw:floor {}\nw:ball { radius = 0.1, at = { 0, 1, 0 } }\nw:run "0.1 s"\n' >plain.lua
gives 0 'a run without a film' run -q --replay plain.replay plain.lua
gives 0 'is drawn' render plain.replay -o plain/f-%05d.png --size 160x90
gives 2 'a camera where there is none' render plain.replay --camera eye;   said 'the script of this replay made no camera'
printf 'local w = require("digbox").world {}\nw:ball { radius = 0.1, at = { 0, 1, 0 } }\nw:camera { at = { 1, 1, 3 } }\nw:run "0.1 s"\n' >one.lua
gives 0 'a camera without a name' run -q --replay one.replay one.lua
gives 0 'is called by its number' render one.replay -o unnamed/f-%05d.png --size 64x36 --camera 'camera 1'
gives 2 'another one is not there' render one.replay --camera 'camera 2'; said "did you mean 'camera 1'?"
holds 'frame by frame' test "$(ls plain/*.png | wc -l)" -ge 3

checked
