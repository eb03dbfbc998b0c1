#!/usr/bin/env bash
# tests/hostile/hostile.sh - every script of scripts/ as the main file, in a callback, as a module, in a coroutine and as a scenario.
#
#   DIGBOX=build/digbox tests/hostile/hostile.sh [FOLDER [PATTERN]]      (LIMIT= seconds of wall time, JOBS=, TABLE=1 prints all)
#
# The head of a script says what must come of it:
#   -- expect: ok      ends by itself and prints "fine" (or OK)
#   -- expect: error   ends with an error of its own: one line, no control bytes, at most 4000
#   -- expect: limit   is stopped by a limit: memory, fuel or time (cpu and stop mean the same, stop an error as well)
#   -- expect: same    prints the same twice
#   -- expect: any     any of these
# Whatever it expects: within 1.5 times the limit (and a start on a busy machine), no crash, nothing written outside the output folder.
set -u
here=$(cd "$(dirname "$0")" && pwd)
if [ "${1:-}" = --one ]; then
    file=$2 setup=$3 work=$4 limit=$5
    name=$(basename "$file" .lua)
    expect=$(sed -n 's/^-- expect: *\([a-z]*\).*/\1/p' "$file" | head -n 1)
    [[ $expect == ok || $expect == error || $expect == same ]] && limit=10          # those end by themselves
    place=$work/$name-$setup
    mkdir -p "$place" && cd "$place" || exit 1
    # NUL: bash would drop it; none of the scripts holds one.
    body() { cat "$file"; echo; }
    command=(run -q -o out --time-limit "$limit" --memory-limit 96 main.lua)
    case $setup in
        main) body >main.lua ;;
        module) body >inner.lua; echo 'require "inner"' >main.lua ;;
        coroutine) { echo 'coroutine.wrap(function()'; body; echo 'end)()'; } >main.lua ;;
        callback)
            {
                echo 'local world_of_callback = require("digbox").world {} world_of_callback:floor {}'
                echo 'local ball_of_callback = world_of_callback:ball { radius = 1, at = { 0, 0.99, 0 } }'
                echo 'local called = false'
                echo 'ball_of_callback:on("contact_begin", function() if called then return end called = true'
                body
                echo 'end)'
                echo 'world_of_callback:step(3) if not called then error "the callback was not called" end world_of_callback:close()'
            } >main.lua ;;
        scenario)
            { echo 'local test = require "digbox.test" test.scenario("hostile", function() test.expect(1):is(1)'; body; echo 'end)'; } >main_spec.lua
            command=(test -o out --time-limit "$limit" main_spec.lua) ;;
    esac
    before=$(date +%s%N)
    timeout -k 1 30 "$DIGBOX" "${command[@]}" >out.txt 2>err.txt </dev/null
    code=$?
    ms=$((($(date +%s%N) - before) / 1000000))
    if [ "$expect" = same ]; then
        timeout -k 1 30 "$DIGBOX" "${command[@]}" >again.txt 2>/dev/null </dev/null
        sed -i 's/([0-9.]* s)//' out.txt again.txt          # of a scenario's line
        cmp -s out.txt again.txt || code=99
    fi
    failure=1
    [ "$setup" = scenario ] && failure=6
    limits=' 3 4 5 '
    case $expect in
        ok|same) want=' 0 ' ;;
        error) want=" $failure " ;;
        limit|cpu) want=$limits ;;
        stop) want="$limits$failure " ;;
        any) want="$limits 0 $failure " ;;
        *) want=none ;;
    esac
    why=
    [[ $want == *" $code "* ]] || why="exit code $code, want$want"
    [ "$expect" = ok ] && [ "$setup" != scenario ] && ! grep -qE '^(fine|OK)' out.txt && why="$why; it does not print fine"
    awk "BEGIN { exit !($ms / 1000 > 1.5 * $limit + 3) }" && why="$why; $ms ms"
    LC_ALL=C grep -qP '[\x00-\x08\x0b-\x1f\x7f]' err.txt && why="$why; control bytes on stderr"
    LC_ALL=C grep -qP '[\x00-\x08\x0b-\x1f\x7f]' out.txt && why="$why; control bytes on stdout"
    [ "$(wc -c <err.txt)" -gt 6000 ] && why="$why; $(wc -c <err.txt) bytes on stderr"
    [ -n "$(find "$work" -maxdepth 1 -name 'up*' 2>/dev/null)" ] && why="$why; it wrote outside"
    echo "${why:-ok}|$name|$setup|$expect|$code|$ms|$(head -n 1 err.txt | cut -c 1-100)"
    rm -rf "$place"
    exit 0
fi

folder=${1:-$here/scripts} pattern=${2:-}
[ "${SANITIZE:-0}" = 1 ] && LIMIT=${LIMIT:-3}
limit=${LIMIT:-0.5}
work=${TMPDIR:-/tmp}/digbox-hostile-$$
mkdir -p "$work"
trap 'rm -rf "$work"' EXIT
export DIGBOX
setups=(main callback module coroutine scenario) turn=0
# Under sanitizers, which take three times as long, each script is run in two of the five, in turn.
each=$([ "${SANITIZE:-0}" = 1 ] && echo 2 || echo 5)
for file in "$folder"/*"$pattern"*.lua; do
    for ((i = 0; i < each; i++, turn++)); do printf '%s\0%s\0' "$(realpath "$file")" "${setups[turn % 5]}"; done
done | xargs -0 -n 2 -P "${JOBS:-2}" bash -c 'bash "$0" --one "$3" "$4" "$1" "$2"' "$here/hostile.sh" "$work" "$limit" >"$work/table"
[ "${TABLE:-0}" = 1 ] && sort "$work/table"
grep -v '^ok|' "$work/table" | sort
passed=$(grep -c '^ok|' "$work/table") failed=$(grep -vc '^ok|' "$work/table")
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
