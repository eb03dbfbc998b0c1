#!/bin/sh
# tests/bench/replay.sh - what recording costs: instructions of the whole process, with and without --replay, and of its threads.
#
#   replay.sh PROGRAM FOLDER        (make bench SCENE=replay; valgrind counts)
#
# Those of a run without a step are taken off: loading, the script, one small picture.
set -eu
program=$1 folder=$2
mkdir -p "$folder"

# count NAME BOXES SECONDS [--replay FILE]: instructions, in thousands
count() {
    name=$1 boxes=$2 seconds=$3
    shift 3
    rm -f "$folder/$name".*
    valgrind -q --tool=callgrind --separate-threads=yes --callgrind-out-file="$folder/$name.%p" "$program" run --trust -q tests/bench/tumble.lua \
        -o "$folder" --force --set "n=$boxes" --set "seconds=$seconds" "$@" >"$folder/$name.log" 2>&1
    awk '/^summary:/ { sum += $2 } END { printf "%d\n", sum / 1000 }' "$folder/$name".*-*
}

for scene in "200 2" "1000 3"; do
    set -- $scene
    steps=$(($2 * 60))
    idle=$(count idle "$1" 0)
    plain=$(($(count plain "$1" "$2") - idle))
    kept=$(($(count kept "$1" "$2" --replay "$folder/kept.replay") - idle))
    packs=$(grep -l 'write_batch' "$folder"/kept.*-* | while read -r file; do
        grep -q 'dig_world_step' "$file" || awk '/^summary:/ { print int($2 / 1000) }' "$file"
    done | sort -n | tail -1)
    bytes=$(wc -c <"$folder/kept.replay")
    echo "$1 $steps $plain $kept ${packs:-0} $bytes" | awk '{ printf "%4d boxes, %d steps: %.2f M a step; recording %.2f M (%.1f %%), of it the thread that packs %.2f M; %d bytes a frame\n",
        $1, $2, $3 / $2 / 1000, ($4 - $3) / $2 / 1000, 100 * ($4 - $3) / $3, $5 / $2 / 1000, $6 / $2 }'
done
