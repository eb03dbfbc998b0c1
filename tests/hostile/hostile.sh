#!/usr/bin/env bash
# tests/hostile/hostile.sh - every script of scripts/ as the main file, in a callback, as a module, in a coroutine and as a scenario.
#
#   DIGBOX=build/digbox tests/hostile/hostile.sh [FOLDER [PATTERN]]      (LIMIT= ms of wall time, JOBS=, TABLE=1 prints all)
#
# The head of a script says what must come of it:
#   -- expect: ok      ends by itself and prints "fine" (or OK)
#   -- expect: error   ends with an error of its own: one line, no control bytes, at most 4000
#   -- expect: limit   is stopped by a limit: memory, fuel or time (cpu and stop mean the same, stop an error as well)
#   -- expect: same    prints the same twice
#   -- expect: any     any of these
# Whatever it expects: within 1.5 times the limit (and a start on a busy machine), no crash, nothing written outside the output folder.
set -u
export LC_ALL=C
here=$(cd "$(dirname "$0")" && pwd)

# script_of SETUP FILE: the script that is run
script_of() {
    case $1 in
        coroutine) echo 'coroutine.wrap(function()' ;;
        callback)
            echo 'local world_of_callback = require("digbox").world {} world_of_callback:floor {}'
            echo 'local ball_of_callback = world_of_callback:ball { radius = 1, at = { 0, 0.99, 0 } }'
            echo 'local called = false'
            echo 'ball_of_callback:on("contact_begin", function() if called then return end called = true' ;;
        scenario) echo 'local test = require "digbox.test" test.scenario("hostile", function() test.expect(1):is(1)' ;;
    esac
    cat "$2"
    case $1 in
        coroutine) printf '\nend)()\n' ;;
        callback)
            printf '\nend)\n'
            echo 'world_of_callback:step(3) if not called then error "the callback was not called" end world_of_callback:close()' ;;
        scenario) printf '\nend)\n' ;;
    esac
}

# Few processes: starting them is what hundreds of cases would spend their time on.
# one FILE SETUP WORK LIMIT(ms): prints VERDICT|name|setup|expect|code|ms|first line of errors.
one() {
    local file=$1 setup=$2 work=$3 limit=$4 expect='' line
    local name=${file##*/}
    name=${name%.lua}
    while read -r line; do
        [[ $line =~ ^--\ expect:\ *([a-z]+) ]] && expect=${BASH_REMATCH[1]} && break
    done <"$file"
    [[ $expect == ok || $expect == error || $expect == same ]] && limit=10000       # those end by themselves
    [[ $expect$name == @(limit|cpu|stop)@(loop|c)_* ]] && limit=$ENDLESS            # those never do; a few fill memory within a second
    local place=$work/$name-$setup seconds
    mkdir "$place" && cd "$place" || exit 1
    printf -v seconds '%d.%03d' $((limit / 1000)) $((limit % 1000))
    local command=(run -q -o out --time-limit "$seconds" --memory-limit 96 main.lua)
    case $setup in
        scenario) command=(test -o out --time-limit "$seconds" main_spec.lua); script_of scenario "$file" >main_spec.lua ;;
        module) script_of module "$file" >inner.lua; echo 'require "inner"' >main.lua ;;
        *) script_of "$setup" "$file" >main.lua ;;
    esac
    local before=${EPOCHREALTIME/./} code ms
    timeout -k 1 30 "$DIGBOX" "${command[@]}" >out.txt 2>err.txt </dev/null
    code=$?
    ms=$(((${EPOCHREALTIME/./} - before) / 1000))
    if [ "$expect" = same ]; then
        timeout -k 1 30 "$DIGBOX" "${command[@]}" >again.txt 2>/dev/null </dev/null
        sed -i 's/([0-9.]* s)//' out.txt again.txt          # of a scenario's line
        cmp -s out.txt again.txt || code=99
    fi
    local failure=1 limits=' 3 4 5 ' want why=
    [ "$setup" = scenario ] && failure=6
    case $expect in
        ok | same) want=' 0 ' ;;
        error) want=" $failure " ;;
        limit | cpu) want=$limits ;;
        stop) want="$limits$failure " ;;
        any) want="$limits 0 $failure " ;;
        *) want=none ;;
    esac
    [[ $want == *" $code "* ]] || why="exit code $code, want$want"
    if [ "$expect" = ok ] && [ "$setup" != scenario ]; then
        local fine=0
        while read -r line; do [[ $line == fine* || $line == OK* ]] && fine=1; done <out.txt
        [ "$fine" = 1 ] || why="$why; it does not print fine"
    fi
    [ "$ms" -gt $((limit * 3 / 2 + 3000)) ] && why="$why; $ms ms"
    grep -lP '[\x00-\x08\x0b-\x1f\x7f]' err.txt out.txt >bad.txt && why="$why; control bytes in $(<bad.txt)"
    local errors=
    IFS= read -r -d '' -n 6001 errors <err.txt
    [ "${#errors}" -gt 6000 ] && why="$why; more than 6000 bytes on stderr"
    compgen -G "$work/up*" >up.txt && why="$why; it wrote outside"
    errors=${errors%%$'\n'*}
    echo "${why:-ok}|$name|$setup|$expect|$code|$ms|${errors:0:100}"
    cd "$work" && rm -rf "$place"
}
if [ "${1:-}" = --some ]; then
    work=$2 limit=$3
    shift 3
    while [ $# -ge 2 ]; do one "$1" "$2" "$work" "$limit"; shift 2; done
    exit 0
fi

folder=$(realpath "${1:-$here/scripts}") pattern=${2:-}
# Three times as slow under sanitizers: what is endless gets as far in 1500 ms as in 500 in the plain build; what fills memory needs 3000.
export ENDLESS=${LIMIT:-500}
[ "${SANITIZE:-0}" = 1 ] && ENDLESS=${LIMIT:-1500} LIMIT=${LIMIT:-3000}
limit=${LIMIT:-500}
work=${TMPDIR:-/tmp}/digbox-hostile-$$
mkdir -p "$work"
trap 'rm -rf "$work"' EXIT
export DIGBOX
setups=(main callback module coroutine scenario) turn=0
# Under sanitizers, which take three times as long, each script is run in two of the five, in turn.
each=$([ "${SANITIZE:-0}" = 1 ] && echo 2 || echo 5)
for file in "$folder"/*"$pattern"*.lua; do
    for ((i = 0; i < each; i++, turn++)); do printf '%s\0%s\0' "$file" "${setups[turn % 5]}"; done
done | xargs -0 -n 16 -P "${JOBS:-2}" bash "$here/hostile.sh" --some "$work" "$limit" >"$work/table"
[ "${TABLE:-0}" = 1 ] && sort "$work/table"
grep -v '^ok|' "$work/table" | sort
passed=$(grep -c '^ok|' "$work/table") failed=$(grep -vc '^ok|' "$work/table")
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
