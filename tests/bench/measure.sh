#!/bin/sh
# tests/bench/measure.sh - runs the performance scenes, engines interleaved, and collects the rows for report.lua.
#
#   BUILD=build [SCENE=towers] [ENGINE=digbox] [N=200] [FULL=1] [LIMIT=s] [TOTAL=s] [REPEATS=n] tests/bench/measure.sh
#
# One process at a time, each engine in its own. All engines run a scene before the next one begins, so that they meet the same
# state of the machine; then everything is repeated as often as the time allows. No step begins after LIMIT seconds of processor time
# (the row then has fewer steps), no run begins after TOTAL seconds by the wall clock.
set -u
dir=${BUILD:-build}/bench
rows=$dir/rows.lua
full=${FULL:-0}
scene=${SCENE:-}
engine=${ENGINE:-}
size=${N:-}
if [ "$full" = 1 ]; then
    limit=${LIMIT:-100} total=${TOTAL:-5400}
else
    limit=${LIMIT:-20} total=${TOTAL:-540}
fi
repeats=${REPEATS:-3}
began=$(date +%s)
scenes="pyramid towers chains pile_mixed pile_spheres sleeping large_world room"
case " $scenes " in
    *" ${scene:-room} "*) ;;
    *) echo "bench: no scene '$scene'; there are: $scenes" >&2; exit 1 ;;
esac
engines="digbox bullet ode mujoco"
case " $engines " in
    *" ${engine:-digbox} "*) ;;
    *) echo "bench: no engine '$engine'; there are: $engines" >&2; exit 1 ;;
esac

# scene size engines threads
plan() {
    cat <<END
pyramid      30    digbox,bullet,ode 1
towers       1000  digbox,bullet,ode 1
chains       100   digbox,bullet,ode 1
pile_mixed   4000  digbox,bullet,ode 1
pile_spheres 1000  digbox,bullet,ode 1
pile_spheres 8000  digbox,bullet,ode 1
sleeping     50000 digbox,bullet,ode 1
large_world  20000 digbox,bullet,ode 1
towers       1000  digbox 2
pile_mixed   4000  digbox 2
pile_spheres 8000  digbox 2
pyramid      15    digbox,bullet,ode,mujoco 1
towers       20    digbox,bullet,ode,mujoco 1
chains       20    digbox,bullet,ode,mujoco 1
pile_mixed   200   digbox,bullet,ode,mujoco 1
pile_spheres 300   digbox,bullet,ode,mujoco 1
END
    [ "$full" = 1 ] || return 0
    cat <<END
pile_spheres 2000  digbox,bullet,ode 1
pile_spheres 4000  digbox,bullet,ode 1
pile_spheres 16000 digbox,bullet,ode 1
towers       1000  ode 2
pile_mixed   4000  ode 2
pile_spheres 8000  ode 2
large_world  1000000 digbox,bullet 1
room         100000  digbox,bullet 1
END
}

chosen() {
    list=$(plan | while read -r s n e t; do
        [ -z "$scene" ] || [ "$s" = "$scene" ] || continue
        echo "$s ${size:-$n} $e $t"
    done)
    # A size of one's own: once for each number of threads.
    [ -z "$size" ] || list=$(echo "$list" | awk '!seen[$1 $4]++ { if ($4 == 1) $3 = "digbox,bullet,ode,mujoco"; print }')
    # A scene that stands in the table with FULL=1 only.
    [ -n "$list" ] || [ -z "$scene" ] || list="$scene ${size:-0} digbox,bullet,ode 1"
    echo "$list"
}

# one SCENE N ENGINE THREADS REPEAT
one() {
    program=$dir/bench-$3
    [ -x "$program" ] || return 0
    now=$(($(date +%s) - began))
    left=$((total - now))
    if [ "$left" -le 0 ]; then
        [ "$5" -gt 1 ] || echo "bench: no time left for $3 on $1 $2" >&2
        return 0
    fi
    [ "$left" -lt "$limit" ] || left=$limit
    printf 'bench: %4d s  %s %s %s, %s thread(s), run %s' "$now" "$1" "$2" "$3" "$4" "$5" >&2
    row=$(timeout $((8 * limit + 60)) "$program" "$1" "$2" "$4" "$left" 2>"$dir/err")
    case $? in
        0) echo "$row" >>"$rows"; echo >&2 ;;
        77) echo ": left out: $(tail -n 1 "$dir/err")" >&2 ;;
        124) echo ": stopped, it took too long" >&2; failed "$1" "$2" "$3" "$4" "took too long" ;;
        *) echo ": failed: $(tail -n 1 "$dir/err")" >&2; failed "$1" "$2" "$3" "$4" "failed" ;;
    esac
}

failed() {
    echo "row{scene = '$1', n = $2, engine = '$3', threads = $4, failed = '$5', steps = 0, cpu = {}, wall = {}}" >>"$rows"
}

# Has it run to its last step?
went_whole() {
    grep -q "^row{scene = '$1', n = $2, engine = '$3', threads = $4,.* steps = \([0-9]*\), steps_wanted = \1," "$rows"
}

mkdir -p "$dir"
: >"$rows"
for repeat in $(seq "$repeats"); do
    chosen | while read -r s n list threads; do
        for e in $(echo "$list" | tr , ' '); do
            [ -z "$engine" ] || [ "$e" = "$engine" ] || continue
            # What was cut short or failed is not repeated: that would only be as slow again.
            # MuJoCo takes longer to read a scene than to run it.
            [ "$repeat" = 1 ] || [ "$e" != mujoco ] || continue
            [ "$repeat" = 1 ] || went_whole "$s" "$n" "$e" "$threads" || continue
            one "$s" "$n" "$e" "$threads" "$repeat"
        done
    done
done
[ -s "$rows" ] || { echo "bench: nothing ran" >&2; exit 1; }
