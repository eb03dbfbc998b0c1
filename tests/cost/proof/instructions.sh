#!/usr/bin/env bash
# tests/cost/proof/instructions.sh - instructions of 600 frames of a stack with all effects compiled in, and with the mechanical ones
# alone (FEWER); they may differ by 0.1 %. Counted by callgrind within dig_world_step.
set -u
command -v valgrind >/dev/null 2>&1 || { echo "valgrind is missing: sudo apt-get install valgrind"; exit 77; }
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
count() {
    # The run is a child of its supervisor: each writes a file, and the supervisor takes no step.
    valgrind --tool=callgrind --toggle-collect=dig_world_step --callgrind-out-file="$work/$2.%p" "$1" run -q tests/cost/proof/stack.lua \
        -o "$work" >"$work/log" 2>&1 || { cat "$work/log" >&2; return 1; }
    awk '($1 == "totals:" || $1 == "summary:") && $2 > n { n = $2 } END { print n + 0 }' "$work/$2".*
}
all=$(count "$DIGBOX" all) && few=$(count "$FEWER" few) || exit 1
echo "instructions of 600 frames of a stack of 10 boxes: all effects $all, the mechanical ones alone $few"
awk -v a="$all" -v b="$few" 'BEGIN { d = 100 * (a - b) / b; printf "difference %.4f %%, at most 0.1 %%\n", d; exit !(a > 1e6 && d < 0.1 && d > -0.1) }'
