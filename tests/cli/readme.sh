#!/usr/bin/env bash
# tests/cli/readme.sh - the world shown in README.md runs as it stands there, and leaves a picture.
set -u
awk '/^```lua$/ { if (!seen++) { inside = 1; next } } /^```$/ { inside = 0 } inside' README.md >"$TMPDIR/readme.lua"
[ "$(grep -c . "$TMPDIR/readme.lua")" -ge 5 ] || { echo "README.md shows no world"; exit 1; }
(cd "$TMPDIR" && "$DIGBOX" run readme.lua -o out) || exit 1
find "$TMPDIR/out" -name '*.png' -size +1k | grep -q . || { echo "no picture in out/"; exit 1; }
