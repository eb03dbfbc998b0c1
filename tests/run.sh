#!/usr/bin/env bash
# tests/run.sh - runs every test there is and ends with one line `N passed, N failed`.
#
#   BUILD=build [T=pattern] [SANITIZE=1] [RENDER=0] tests/run.sh [tests/unit/test_*.c ...]
#
# Four kinds, all found by wildcard:
#   tests/unit/test_NAME.c   built to $BUILD/unit/test_NAME; counts what cmocka reports
#   *.lua                    tests/{scenarios,worlds,laws}/, and *_spec.lua anywhere: `digbox test FILE`
#   tests/{cli,cost,view,hostile}/*.sh  the program and the build from outside; gets DIGBOX (the program) and BUILD
#   tests/lint/*.sh          the source text; gets BUILD
# A script counts as one, unless its last line is `N passed, N failed`; exit status 77
# says that it cannot run here. Each test has a TMPDIR of its own, a time limit, and
# fails when it checks nothing. Results are printed in the order of the list,
# whatever finishes first. `Only in the plain build: REASON` in the head of a file keeps it
# out of SANITIZE=1 and RENDER=0: what checks figures over minutes, on code that others run there.
# `Not in RENDER=0: REASON` keeps it out of that alone: what takes long and meets no renderer has the same code there.
set -u
cd "$(dirname "$0")/.." || exit 2
export LC_ALL=C BUILD=${BUILD:-build} SANITIZE=${SANITIZE:-0} RENDER=${RENDER:-1} V=${V:-0}
export DIGBOX=$PWD/$BUILD/digbox
# intercept_tls_get_addr: the leak checker of GCC 12 takes a library's thread memory that begins 16 bytes into a page for one of glibc 2.19's,
# reads its size from before it and ends with signal 11 ("DTLS 6 at 0x2a8"): one page in 256, by chance, of what was allocated before.
export ASAN_OPTIONS=${ASAN_OPTIONS:-detect_leaks=1:strict_string_checks=1:detect_stack_use_after_return=1:handle_segv=2:handle_sigbus=2:handle_abort=1:intercept_tls_get_addr=0}
export UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1}
export LSAN_OPTIONS=${LSAN_OPTIONS:-print_suppressions=0}        # digbox knows its suppressions
unit_lsan=$LSAN_OPTIONS:suppressions=$PWD/tests/lsan.supp
export CMOCKA_MESSAGE_OUTPUT=STDOUT
results=$PWD/$BUILD/results

# The counts in a log: the last line `N passed, N failed`, or nothing.
last_counts() {
    grep -E '^[0-9]+ passed, [0-9]+ failed$' "$1" | tail -n 1 | tr -dc '0-9 '
}

# cmocka prints a line for each test as it ends; a crash leaves the rest out.
cmocka_counts() {
    awk '/^\[       OK \]/ { ok++ }  /^\[  FAILED  \] [0-9]+ test/ { bad = $4 }
         END { print ok + 0, bad + 0 }' "$1"
}

log_of() { echo "$results/${1//\//_}.log"; }

# run_one NUMBER KIND PATH: leaves the log and, last of all, NUMBER.result (passed failed status seconds, CPU seconds).
run_one() {
    local number=$1 kind=$2 path=$3 limit=900 log status passed failed
    log=$(log_of "$path")
    local began=${EPOCHREALTIME%.*}
    export TMPDIR=$results/scratch-$number
    mkdir -p "$TMPDIR"
    [ "$SANITIZE" = 1 ] && limit=1200
    local command
    case $kind in
        unit) command=("$BUILD/unit/$(basename "$path" .c)"); local -x LSAN_OPTIONS=$unit_lsan ;;
        lua)  command=("$DIGBOX" test "$path") ;;
        *)    command=(bash "$path") ;;
    esac
    if [ ! -e "${command[0]}" ] && [ "${command[0]}" != bash ]; then
        echo "$path does not build" >"$log"
        status=1
    else
        timeout -k 10 "$limit" "${command[@]}" >"$log" 2>&1 </dev/null
        status=$?
    fi
    case $status in
        124|137) echo "(stopped: more than $limit s)" >>"$log" ;;
        129|1[3-9]?) echo "(ended by signal $((status - 128)))" >>"$log" ;;
    esac

    if [ "$kind" = unit ]; then
        read -r passed failed < <(cmocka_counts "$log")
    else
        read -r passed failed < <(last_counts "$log")
        if [ -z "${passed:-}" ] && [ "$kind" != lua ]; then
            passed=$((status == 0)) failed=$((status != 0))
        fi
    fi
    : "${passed:=0}" "${failed:=0}"
    [ "$status" -eq 77 ] && passed=0 failed=0
    [ "$status" -ne 0 ] && [ "$status" -ne 77 ] && [ "$failed" -eq 0 ] && failed=1
    if [ "$status" -eq 0 ] && [ "$((passed + failed))" -eq 0 ]; then
        echo "(checked nothing)" >>"$log"
        failed=1
    fi
    rm -rf "$TMPDIR"
    # CPU seconds of the children of this shell: what a test costs, however busy the machine is. A subshell would know of none.
    local cpu
    times >"$results/$number.new"
    cpu=$(awk -F '[ ms]+' 'NR == 2 { print int(60 * $1 + $2 + 60 * $3 + $4 + 0.5) }' "$results/$number.new")
    echo "$passed $failed $status $((${EPOCHREALTIME%.*} - began)) $cpu" >"$results/$number.new"
    mv "$results/$number.new" "$results/$number.result"
}

if [ "${1:-}" = --one ]; then
    shift
    run_one "$@"
    exit 0
fi

# ---- what there is to run: "kind path" ----
lua_tests() {
    find tests worlds -name '*.lua' 2>/dev/null | sort | grep -E '^tests/(scenarios|worlds|laws)/|_spec\.lua$' |
    while read -r path; do
        # Without a renderer, what takes pictures cannot run.
        if [ "$RENDER" = 0 ] && grep -qE ':(render|record|golden)\b' "$path"; then continue; fi
        echo "lua $path"
    done
}
everything=$(
    for path in "$@"; do echo "unit $path"; done
    [ -x "$DIGBOX" ] && lua_tests
    if [ "$RENDER" = 1 ] && [ -x "$DIGBOX" ]; then
        for path in tests/cli/*.sh tests/cost/*.sh tests/view/*.sh tests/hostile/*.sh; do [ -e "$path" ] && echo "cli $path"; done
    fi
    # The text of the sources is the same in every build: judged in the plain one.
    if [ "$SANITIZE" = 0 ] && [ "$RENDER" = 1 ]; then
        for path in tests/lint/*.sh; do [ -e "$path" ] && echo "lint $path"; done
    fi
)
list=$(
    printf '%s\n' "$everything" | while read -r kind path; do
        if [ "$SANITIZE$RENDER" != 01 ] && head -n 20 "$path" | grep -q 'Only in the plain build: '; then continue; fi
        if [ "$RENDER" = 0 ] && head -n 20 "$path" | grep -q 'Not in RENDER=0: '; then continue; fi
        echo "$kind $path"
    done
)
if [ -n "${T:-}" ]; then
    list=$(printf '%s\n' "$list" | grep -F -- "$T")
fi
if [ -z "$list" ]; then
    if printf '%s\n' "$everything" | grep -qF -- "${T:-}"; then
        echo "what has '${T:-}' in its path is tested in the plain build only: say neither SANITIZE=1 nor RENDER=0"
    else
        echo "no test has '${T:-}' in its path"
    fi
    echo "0 passed, 0 failed"
    exit 1
fi

rm -rf "$results"
mkdir -p "$results"
# What began last and is long would keep one core busy alone. So first what only the plain build runs, as it takes long, then the others from both
# ends in turn: the scripts at the end are the longest.
printf '%s\n' "$list" | awk '
    { for (i = 0; i < 20 && (getline head < $2) > 0; i++) if (head ~ /Only in the plain build: /) early = 1 }
    { close($2); if (early) print NR, $0; else at[++n] = NR " " $0; early = 0 }
    END { for (i = 1; i <= n - i + 1; i++) { print at[i]; if (i < n - i + 1) print at[n - i + 1] } }' |
    xargs -P "$(nproc 2>/dev/null || echo 2)" -L 1 bash tests/run.sh --one &
runner=$!
trap 'kill "$runner" 2>/dev/null' INT TERM

# ---- print in order, as results come in ----
all_passed=0 all_failed=0 number=0 failures=()
while read -r kind path; do
    number=$((number + 1))
    while [ ! -e "$results/$number.result" ] && kill -0 "$runner" 2>/dev/null; do sleep 0.05; done
    if ! read -r passed failed status seconds cpu 2>/dev/null <"$results/$number.result"; then
        passed=0 failed=1 status=none seconds=0 cpu=0
    fi
    took=; [ "$seconds" -lt 5 ] || took="  $seconds s, $cpu of CPU"                   # what is slow says so
    all_passed=$((all_passed + passed)) all_failed=$((all_failed + failed))
    if [ "$status" = 77 ]; then
        printf 'skip  %-48s %s\n' "$path" "$(tail -n 1 "$(log_of "$path")")"
    elif [ "$failed" -eq 0 ]; then
        printf 'ok    %-48s %4d%s\n' "$path" "$passed" "$took"
        [ "$V" = 1 ] && sed 's/^/      | /' "$(log_of "$path")"
    else
        printf 'FAIL  %-48s %4d passed, %d failed (exit status %s)\n' "$path" "$passed" "$failed" "$status"
        grep -vE '^\[( RUN      |       OK |==========|----------)\]' "$(log_of "$path")" | tail -n 60 | sed 's/^/      | /'
        failures+=("$path")
    fi
done <<<"$list"
wait "$runner" 2>/dev/null

[ "$all_failed" -eq 0 ] || printf 'failed: %s\n' "${failures[@]}"
[ "$all_failed" -eq 0 ] || echo "whole logs are in $BUILD/results/; one test alone: make test T=path"
echo "$all_passed passed, $all_failed failed"
[ "$all_failed" -eq 0 ]
