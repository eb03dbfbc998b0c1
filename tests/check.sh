# tests/check.sh - sourced by the scripts of tests/cli: an empty folder to work in, checks that count, and what digbox said.
#
# DIGBOX is the program. `checked` comes last: the line that counts, and the exit status.
# shellcheck shell=bash
work=${TMPDIR:-/tmp}/digbox-check-$$
mkdir -p "$work" && cd "$work" || exit 1
trap 'rm -rf "$work"' EXIT
passed=0 failed=0

# holds WHAT COMMAND...: the command succeeds.
holds() {
    local what=$1
    shift
    if "$@" >/dev/null 2>&1; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "not so: $what"; fi
}
# gives CODE WHAT ARGUMENTS...: exit code of digbox; leaves its output in out.txt and err.txt.
gives() {
    local want=$1 what=$2 got
    shift 2
    "$DIGBOX" "$@" >out.txt 2>err.txt </dev/null
    got=$?
    if [ "$got" = "$want" ]; then passed=$((passed + 1)); return; fi
    failed=$((failed + 1))
    echo "$what: exit code $got, want $want"
    head -n 5 err.txt
}
said()    { holds "stderr says: $1" grep -qF -- "$1" err.txt; }
printed() { holds "stdout says: $1" grep -qF -- "$1" out.txt; }
lacks()   { holds "stdout does not say: $1" test "$(grep -cF -- "$1" out.txt)" = 0; }

checked() {
    echo "$passed passed, $failed failed"
    [ "$failed" -eq 0 ]
}
