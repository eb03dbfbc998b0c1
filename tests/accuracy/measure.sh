#!/bin/sh
# tests/accuracy/measure.sh - runs the accuracy suite on digbox and its peers, scene by scene, and collects the rows.
#
#   BUILD=build tests/accuracy/measure.sh [SCENE [ENGINE]]
#
# All engines run one scene before the next one begins, so that they meet the same state of the machine. The rows of
# each scene and engine are kept in build/accuracy/rows/, and all together make build/accuracy/results.csv: a run of
# one scene replaces its rows only. LIMIT is what an engine may take for the settings of a scene file, in seconds of CPU time, so
# that other work on the machine takes no rows away; four times that in seconds of time. TOTAL is for everything, in seconds of time.
set -u
out=${BUILD:-build}/accuracy
scene=${1:-}
engine=${2:-}
LIMIT=${LIMIT:-45}
TOTAL=${TOTAL:-840}
begin=$(date +%s)
all=$(cd tests/accuracy/scenes && printf "%s\n" *.lua | sed -n "s/^\([A-Z][0-9]*\)_.*/\1/p" | sort)
family=$(echo "$scene" | sed 's/^\([A-Z][0-9]*\).*/\1/')
chosen=$(for s in $all; do case $s in "$family"*) echo "$s" ;; esac; done)
[ -n "$chosen" ] || { echo "accuracy: no scene begins with '$scene'; there are: $(echo $all)" >&2; exit 1; }
mkdir -p "$out/rows"

engines=digbox
for peer in bullet bullet64 ode mujoco; do
    if [ -x "$out/peer-$peer" ]; then
        engines="$engines $peer"
    else
        echo "accuracy: $peer is left out: its Debian package is not installed" >&2
        rm -f "$out"/rows/*."$peer".csv
    fi
done
case " $engines " in
    *" ${engine:-digbox} "*) ;;
    *) echo "accuracy: no engine '$engine'; there are: $engines" >&2; exit 1 ;;
esac

# Sets `seconds`, what the next run may take; false when the time for everything is over.
left() {
    seconds=$((TOTAL - $(date +%s) + begin))
    [ "$seconds" -le "$LIMIT" ] || seconds=$LIMIT
    [ "$seconds" -gt 0 ] || { echo "accuracy: $1: no time left for $2" >&2; return 1; }
}

# Ends the process group $1 when it has used `seconds` of CPU time.
watch() {
    while [ "$(ps -eo pgid=,cputimes= | awk -v group="$1" '$1 == group { used += $2 } END { print used + 0 }')" -lt "$seconds" ]; do
        sleep 1
    done
    kill "$1"
}

# Runs the rest of its arguments for at most `seconds` of CPU time. Not by ulimit -t: with such a limit Linux counts the CPU time of a
# process in ticks of some milliseconds, and most scenes take less.
limited() {
    timeout "$((4 * seconds))" "$@" &
    program=$!
    watch "$program" >/dev/null &
    watcher=$!
    wait "$program"
    status=$?
    kill "$watcher" 2>/dev/null
    return "$status"
}

# Plans first, the coarse ones of all scenes before the finest of any: when the time runs out, it is the finest tolerances that are missing.
digbox_rows() {
    for settings in plans ladder; do
        left "$1" "the $settings of digbox" || continue
        limited stdbuf -oL "${BUILD:-build}/digbox" run tests/accuracy/run.lua -- --scenes "$1" --settings "$settings" 2>"$out/$1.err"
        case $? in
            0) ;;
            124|137|143) echo "accuracy: $1: the $settings of digbox took more than $seconds s; rows are missing" >&2 ;;
            *) echo "accuracy: $1: digbox failed at its $settings:" >&2; tail -n 3 "$out/$1.err" >&2 ;;
        esac
    done | grep -E "^[A-Z][0-9]+[a-z]*,digbox,"
}

peer_rows() {
    left "$1" "$2" || return
    limited "$out/peer-$2" "$1"
    case $? in
        0|77) ;;                        # 77: no such scene for the peers
        124|137|143) echo "accuracy: $1: $2 took more than $seconds s; rows are missing" >&2 ;;
        *) echo "accuracy: $1: $2 failed" >&2 ;;
    esac
}

for s in $chosen; do
    printf "accuracy: %4s s  %s" $(($(date +%s) - begin)) "$s" >&2
    for e in $engines; do
        [ -z "$engine" ] || [ "$e" = "$engine" ] || continue
        printf ' %s' "$e" >&2
        case $e in
            digbox) digbox_rows "$s" ;;
            *) peer_rows "$s" "$e" ;;
        esac >"$out/new.csv"
        mv "$out/new.csv" "$out/rows/$s.$e.csv"
    done
    echo >&2
done

{
    echo scene,engine,setting,error,cpu_ms_per_s,steps,evaluations,refused,events,energy_drift,momentum_drift,gave_up
    cat "$out"/rows/*.csv
} >"$out/results.csv"
echo "accuracy: $(($(date +%s) - begin)) s, $(($(wc -l <"$out/results.csv") - 1)) rows in $out/results.csv" >&2
