#!/bin/sh
# tests/hard/soak.sh - random worlds in processes of ten seeds each, two at a time; what failed is printed at the end.
#
#   BUILD=build tests/hard/soak.sh FIRST_SEED COUNT SECONDS [world|machines|rooms]
set -u
out=${BUILD:-build}/soak
first=$1 count=$2 seconds=$3 kind=${4:-world}
rm -rf "$out"
mkdir -p "$out"
i=0
while [ "$i" -lt "$count" ]; do
    n=$((count - i < 10 ? count - i : 10))
    echo "$((first + i)) $n"
    i=$((i + 10))
done | xargs -P "$(nproc 2>/dev/null || echo 2)" -L 1 sh -c '
    timeout 3600 "$0/digbox" run tests/hard/stress.lua -- --seed "$3" --count "$4" --seconds "$1" --kind "$2" --limit 60 >"$0/soak/$3.txt" 2>&1 </dev/null
    grep -cE "	(pass|fail|over time)	" "$0/soak/$3.txt" | sed "s/^/seeds from $3: /"
' "${BUILD:-build}" "$seconds" "$kind"
verdicts() { cat "$out"/*.txt | grep -cE "^seed [0-9]+	[^	]*	$1	"; }
passed=$(verdicts pass) failed=$(verdicts fail) late=$(verdicts "over time")
grep -hE "^seed [0-9]+	[^	]*	fail	" "$out"/*.txt
echo "soak: $count seeds of $seconds s: $passed passed, $failed failed, $late over time, $((count - passed - failed - late)) without a verdict"
[ "$passed" -eq "$count" ]
