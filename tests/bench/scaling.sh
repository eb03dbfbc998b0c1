#!/bin/sh
# tests/bench/scaling.sh - runs scaling.lua and puts what it measured between the marks of a document.
#
#   sh tests/bench/scaling.sh build/digbox docs/scaling.md
set -eu
digbox=$1 page=$2
part=$(mktemp) whole=$(mktemp)
trap 'rm -f "$part" "$whole"' EXIT
echo "scaling: a few minutes, one scene after the other" >&2
"$digbox" run tests/bench/scaling.lua -q -- --large true | grep -v '^ok ' >"$part"
grep -q '^| chains' "$part"
awk -v part="$part" '/^<!-- begin/ { print; print ""; while ((getline line < part) > 0) print line; inside = 1 }
    /^<!-- end/ { print ""; inside = 0 } !inside { if (!/^<!-- begin/) print }' "$page" >"$whole"
cp "$whole" "$page"
