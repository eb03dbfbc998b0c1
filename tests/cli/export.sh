#!/usr/bin/env bash
# tests/cli/export.sh - digbox export: every format is read again by other programs and says what the run did.
set -u
. "${0%/*}/../check.sh"

cat >fall.lua <<'LUA'
local digbox = require "digbox"
local world = digbox.world {}
world:floor {}
local ball = world:ball { name = 'the "ball", red', radius = 0.1, at = { 1, 2, -0.5 }, velocity = { 0.4, 0, 0 }, restitution = 0.5 }
world:weld { a = world:box { name = "left", size = 0.2, at = { -1, 0.1, 0 } }, b = world:box { name = "right", size = 0.2, at = { -0.8, 0.1, 0 } } }
world:camera { at = { 3, 2, 5 }, look_at = { 0, 0.5, 0 } }
world:run "0.5 s"
world:ball { name = "late", radius = 0.05, at = { 0, 1, 1 }, opacity = 0.25 }
world:run "0.5 s"
ball:remove()
world:run "0.5 s"
LUA
gives 0 'a run that is kept' run -q --replay fall.replay fall.lua
for form in csv jsonl npy dot glb; do
    gives 0 "as $form" export fall.replay -o "fall.$form"; said "fall.$form:"
done
gives 0 'ten frames a second' export -q fall.replay -o ten.csv --fps 10
gives 0 'some frames' export -q fall.replay -o some.jsonl --frames 10..20
gives 0 'one moment' export -q fall.replay -o early.dot --at '0.1 s'

# The same numbers in all: read by Python with nothing but its own library, and by the programs that the formats are for.
cat >read.py <<'PY'
import csv, json, struct, sys

rows = list(csv.DictReader(open("fall.csv", newline="")))
ball = {int(r["frame"]): r for r in rows if r["name"] == 'the "ball", red'}
late = {int(r["frame"]): r for r in rows if r["name"] == "late"}
assert sorted(ball) == list(range(60)) and sorted(late) == list(range(30, 91)), (len(ball), min(late), max(late))
for n in (0, 10):                                           # free fall, exact in each step
    t = n / 60
    assert abs(float(ball[n]["y"]) - (2 - 9.81 * t * t / 2)) < 1e-12 and abs(float(ball[n]["x"]) - 1 - 0.4 * t) < 1e-12
ten = sorted({int(r["frame"]) for r in csv.DictReader(open("ten.csv", newline=""))})
assert ten == list(range(0, 91, 6)), ten

lines = [json.loads(line) for line in open("fall.jsonl")]
head, frames = lines[0], lines[1:]
index = next(b["body"] for b in head["bodies"] if b["name"] == 'the "ball", red')
assert head["frames"] == 91 and len(frames) == 91 and len({f["checksum"] for f in frames}) > 60
for n in (0, 17, 59):
    body = next(b for b in frames[n]["bodies"] if b["body"] == index)
    assert body["position"] == [float(ball[n][k]) for k in "xyz"]
assert any(e["kind"] == "impact" and index in (e["a"], e.get("b")) for f in frames for e in f["events"])
assert any(l["kind"] == "joint" for l in frames[-1]["links"]) and any(l["kind"] == "contact" for l in frames[-1]["links"])
some = [json.loads(line) for line in open("some.jsonl")]
assert [f["frame"] for f in some[1:]] == list(range(10, 21))

data = open("fall.glb", "rb").read()
magic, version, size, json_size, kind = struct.unpack("<4sIIII", data[:20])
assert (magic, version, size, kind) == (b"glTF", 2, len(data), 0x4E4F534A)
scene, binary = json.loads(data[20:20 + json_size]), data[28 + json_size:]

blended = [m for m in scene["materials"] if m.get("alphaMode") == "BLEND"]
assert len(blended) == 1 and blended[0]["pbrMetallicRoughness"]["baseColorFactor"][3] == 0.25, blended
assert all(m["pbrMetallicRoughness"]["baseColorFactor"][3] == 1 for m in scene["materials"] if m not in blended)

def values(accessor):
    a = scene["accessors"][accessor]
    view, width = scene["bufferViews"][a["bufferView"]], {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[a["type"]]
    flat = struct.unpack_from("<%df" % (a["count"] * width), binary, view["byteOffset"])
    return [flat[i:i + width] for i in range(0, len(flat), width)]

def track(name, path):
    node = next(i for i, n in enumerate(scene["nodes"]) if n.get("name") == name)
    for channel in scene["animations"][0]["channels"]:
        if channel["target"] == {"node": node, "path": path}:
            sampler = scene["animations"][0]["samplers"][channel["sampler"]]
            return dict(zip((t for (t,) in values(sampler["input"])), values(sampler["output"])))
    return {}

moves = track('the "ball", red', "translation")
for n in (0, 17, 59):
    time = min(moves, key=lambda t: abs(t - n / 60))
    assert abs(time - n / 60) < 1e-6 and all(abs(moves[time][k] - float(ball[n]["xyz"[k]])) < 1e-6 for k in range(3))
gone = track('the "ball", red', "scale")
assert [s[0] for t, s in sorted(gone.items())] == [1, 0] and abs(max(gone) - 1) < 1e-6
come = track("late", "scale")
assert [s[0] for t, s in sorted(come.items())] == [0, 1] and abs(max(come) - 0.5) < 1e-6
assert not track("left", "translation") or len(track("left", "translation")) < 61, "what rests has few keys"
assert len(scene["cameras"]) == 1
print("read")
PY
gives_python() { holds "$1" test "$(python3 read.py 2>err.txt)" = read; grep -q . err.txt && tail -n 2 err.txt; return 0; }
gives_python 'csv, jsonl and glb say the same as the laws'

# A strut between bodies that were there before it: it is a node of its own all the same.
cat >brace.lua <<'LUA'
local digbox = require "digbox"
local world = digbox.world {}
world:floor {}
local a, b = world:box { size = 0.2, at = { 0, 0.1, 0 } }, world:box { size = 0.2, at = { 1, 0.1, 0 } }
world:run "0.5 s"
world:strut { a = a, b = b, at_a = { 0, 0.1, 0 }, at_b = { 1, 0.1, 0 }, radius = 0.02, stiffness = 1e5 }
world:run "0.2 s"
LUA
"$DIGBOX" run -q brace.lua --replay brace.replay && "$DIGBOX" export -q brace.replay -o brace.glb
holds 'a strut that comes later is in the scene' grep -aq '"name":"strut [0-9]*"' brace.glb

# Cloth is its particles and threads; the surface that pictures show in their place would hang fixed at its first particle.
cat >cloth.lua <<'LUA'
local world = require "digbox".world {}
world:cloth { at = { 0, 2, 0 }, across = { 1, 0, 0 }, down = { 0, 0, 1 }, columns = 3, rows = 3, mass = 0.1, stiffness = 100 }
world:run "0.1 s"
LUA
"$DIGBOX" run -q cloth.lua --replay cloth.replay && "$DIGBOX" export -q cloth.replay -o cloth.glb
holds 'cloth is in the scene' grep -aq '"name":"cloth [0-9 ]*"' cloth.glb
holds 'each particle with its ball alone' test "$(grep -ao '"children":\[[0-9,]*\]' cloth.glb | grep -c ,)" = 0

# Debian's Python has Debian's NumPy, whichever one comes first on the path.
python=python3
python3 -c 'import numpy' 2>/dev/null || python=/usr/bin/python3
if "$python" -c 'import numpy' 2>/dev/null || [ "${CI:-}" = true ]; then
    holds 'NumPy reads the array' "$python" -c '
import numpy
a = numpy.load("fall.npy")
assert a.shape == (91, 5) and abs(a["time"][60, 0] - 1) < 1e-12
ball = a["position"][:, 1]
assert abs(ball[10, 1] - (2 - 9.81 / 72)) < 1e-12 and numpy.isnan(ball[90]).all()'
fi
if command -v dot >/dev/null || [ "${CI:-}" = true ]; then
    holds 'Graphviz draws the graphs' dot -Tsvg fall.dot -o fall.svg
    holds 'both welded boxes are in it' test "$(grep -cE '>(left|right)<' fall.svg)" = 2
fi
holds 'the weld is a bold line' grep -q 'style=bold' fall.dot
holds 'the moment is named' grep -q '^// t = 0.1 s, frame 6$' early.dot

gives 0 'the same bytes again' export -q fall.replay -o again.glb;    holds 'glb' cmp fall.glb again.glb

# ---- what is asked wrongly ----
gives 2 'no replay' export -o x.glb;                                  said 'which replay?'
gives 2 'no output' export fall.replay;                               said 'where to?'
gives 2 'a moment beyond its end' export fall.replay -o x.dot --at 300;   said 's is not within the replay, 0 to'
gives 2 'a moment of a table' export fall.replay -o x.csv --at 0.1;       said 'only .dot is'
gives 2 'an unknown ending' export fall.replay -o x.fbx;              said '.glb, .csv, .jsonl, .npy, .dot'
gives 2 'frames that are not there' export fall.replay -o x.csv --frames 80..91;  said '0..90'
gives 2 'frames backwards' export fall.replay -o x.csv --frames 20..10;           said 'not within'
gives 2 'no frames' export fall.replay -o x.csv --frames ten;         said "is not A..B"
gives 8 'no such file' export nowhere.replay -o x.csv;                said 'nowhere.replay'
gives 8 'not a replay' export fall.lua -o x.csv;                      said 'fall.lua'
gives 9 'a folder that is not there' export fall.replay -o nowhere/x.csv;         said 'nowhere/x.csv'
holds 'nothing is left of them' test -z "$(ls x.* 2>/dev/null)"
head -c -200 fall.replay >cut.replay
gives 0 'a file that was cut short' export cut.replay -o cut.csv;     said 'cut short'

checked
