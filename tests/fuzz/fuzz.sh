#!/usr/bin/env bash
# tests/fuzz/fuzz.sh - runs the programs of `make fuzz` one after the other (fuzz.mk); ends with `N passed, N failed`.
#
#   T=pattern SECONDS_EACH=60 RUNS= bash tests/fuzz/fuzz.sh tests/fuzz/target_*.c
#
# Seconds are those of the processor: a busy machine makes them last longer, not count for less.
# RUNS=short: so many inputs of each target that it takes some seconds; the same ones each time.
set -u
declare -A short=([api]=100 [mesh]=1500 [replay]=5000 [save]=3000 [script]=200)
folder=build/fuzz
export ASAN_OPTIONS=${ASAN_OPTIONS:-detect_leaks=1:strict_string_checks=1:detect_stack_use_after_return=1:allocator_may_return_null=1}
export UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1}
passed=0 failed=0

# Runs "$@", and asks it to end (SIGUSR1) when it has used so many seconds of CPU time; 0: never.
for_cpu_seconds() {
    local most=$1 pid ticks used=0
    shift
    ticks=$(getconf CLK_TCK)
    "$@" &
    pid=$!
    while [ "$most" -gt 0 ] && kill -0 $pid 2>/dev/null; do
        used=$(awk '{ sub(/.*\) /, ""); print $12 + $13 }' /proc/$pid/stat 2>/dev/null) || break
        [ "${used:-0}" -ge $((most * ticks)) ] && { kill -USR1 $pid; break; }
        sleep 1
    done
    wait $pid
}

for source in "$@"; do
    name=$(basename "$source" .c)
    name=${name#target_}
    [[ $name == *"${T:-}"* ]] || continue
    program=$folder/fuzz_$name corpus=$folder/$name log=$folder/$name.log
    mkdir -p "$corpus"
    how=() limit=$SECONDS_EACH
    runs=$RUNS
    [ "$RUNS" = short ] && runs=${short[$name]:-200}
    if [ -n "$runs" ]; then             # the same inputs each time: nothing that was learnt before
        rm -rf "$corpus"
        mkdir -p "$corpus"
        how=(-runs="$runs" -seed=1)
        limit=0
    fi
    how+=(-timeout=60 -rss_limit_mb=4096 -close_fd_mask=1 -print_final_stats=1 -artifact_prefix="$folder/$name-")
    if "$program" --seeds "$corpus" && for_cpu_seconds "$limit" "$program" "${how[@]}" "$corpus" >"$log" 2>&1; then
        passed=$((passed + 1))
        echo "ok    $name: $(grep -E '^#[0-9]+' "$log" | tail -n 1 | tr '\t' ' ')"
    else
        failed=$((failed + 1))
        grep -vE '^#[0-9]|^INFO|NEW_FUNC' "$log" | head -n 60
        input=$(sed -n 's/.*Test unit written to //p' "$log" | tail -n 1)
        echo "FAIL  $name: whole log in $log"
        [ -n "$input" ] && echo "      again: $program $input      what it stands for: $program --show $input"
    fi
done
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
