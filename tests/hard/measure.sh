#!/bin/sh
# tests/hard/measure.sh - runs the hard cases, each in a process of its own, and keeps the row of each in build/hard/rows/.
#
#   BUILD=build [LIMIT=60] [FILM=1] tests/hard/measure.sh [CASE [STEP]]      CASE: the beginning of an id; STEP: 1/30, 1/60, 1/1000
#
# LIMIT is the CPU seconds that one run may take; a run stopped there is shown as over time, with its figures so far.
set -u
out=${BUILD:-build}/hard
LIMIT=${LIMIT:-60}
case=${1:-all}
step=${2:-}
mkdir -p "$out/rows" "$out/pictures"
run() { "${BUILD:-build}/digbox" run tests/hard/run.lua -o "$out/pictures" -- "$@" 2>"$out/errors.txt" </dev/null; }

run --cases list | grep -E "^B[0-9]" | while read -r id at; do
    case $id in "$case"*) ;; *) [ "$case" = all ] || continue ;; esac
    [ -z "$step" ] || [ "$at" = "$step" ] || continue
    row="$out/rows/$id.$(echo "$at" | tr / _).tsv"
    timeout $((LIMIT * 5 + 30)) "${BUILD:-build}/digbox" run tests/hard/run.lua -o "$out/pictures" -- --cases "$id" --steps "$at" --limit "$LIMIT" \
        ${FILM:+--pictures true} 2>"$out/errors.txt" </dev/null | grep -E "^$id	" >"$row"
    [ -s "$row" ] || printf '%s\t\t%s\terror\tgives a row\t1\t<= 0\t0\t\t\t\t\t\t%s\n' "$id" "$at" "$(tail -n 1 "$out/errors.txt")" >"$row"
    cut -f 1,3,4,5,6,7,9,12 "$row"
done
