#!/bin/sh
# tests/hard/peers/measure.sh - runs the hard cases on other engines, each in a process of its own; rows go to build/hard/peers/rows/.
#
#   BUILD=build [LIMIT=20] [PEER=ode] tests/hard/peers/measure.sh [CASE [STEP]]      CASE: the beginning of an id; STEP: 1/60 unless told
#
# LIMIT is the CPU seconds that one run may take; a run stopped there is shown as over time, with its figures so far. One that
# does not even come back from a step is ended at twice that.
set -u
build=${BUILD:-build}
out=$build/hard/peers
LIMIT=${LIMIT:-20}
case=${1:-all}
step=${2:-1/60}
mkdir -p "$out/rows"

list() { "$build/digbox" run tests/hard/run.lua -o "$out" -- --cases list 2>"$out/errors.txt" </dev/null | grep -E "^B[0-9]"; }

list | while read -r id at; do
    case $id in "$case"*) ;; *) [ "$case" = all ] || [ -z "$case" ] || continue ;; esac
    [ "$at" = "$step" ] || continue
    for module in "$out"/peer_*.so; do
        engine=${module##*/peer_}
        engine=${engine%.so}
        [ -e "$module" ] || continue
        [ -z "${PEER:-}" ] || [ "$PEER" = "$engine" ] || continue
        row="$out/rows/$id.$(echo "$at" | tr / _).$engine.tsv"
        (ulimit -t $((LIMIT * 2 + 20)) && exec timeout $((LIMIT * 30 + 60)) lua5.4 tests/hard/peers/run.lua "$out" "$engine" "$id" "$at" \
            "$LIMIT") 2>"$out/errors.txt" >"$out/output.txt" </dev/null
        status=$?
        grep -E "^$id	" "$out/output.txt" >"$row"
        if [ ! -s "$row" ]; then
            case $status in                                  # 134: it aborts, 139: it crashes; else: a step did not end in time
                134|139) verdict=fail why="ends the process: " ;;
                124|137|152) verdict="over time" why="stopped; " ;;
                *)       verdict=error why= ;;
            esac
            [ "$verdict" = error ] && which="head -n 1" || which="tail -n 1"         # a traceback comes after what is wrong
            printf '%s\t%s\t%s\t%s\t\t\t\t\t%s\n' "$id" "$at" "$engine" "$verdict" \
                "$why$(grep . "$out/errors.txt" | grep -v Aborted | $which | tr '\t' ' ')" >"$row"
        fi
        cat "$row"
    done
done
