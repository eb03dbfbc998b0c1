#!/usr/bin/env bash
# tests/lint/worlds.sh - every world is run by a test, and its books of energy are checked: its name stands in both.
set -u
bad=0
for world in worlds/*.lua; do
    [ -e "$world" ] || continue
    case $world in *_spec.lua) continue ;; esac
    name=$(basename "$world" .lua)
    if ! grep -rqwF --exclude-dir=lint --include='*.lua' --include='*.c' --include='*.sh' -- "$name" tests worlds/*_spec.lua 2>/dev/null; then
        echo "$world: no test names '$name'"
        bad=1
    fi
    if ! grep -qwF -- "\"$name\"" worlds/ledger_spec.lua; then
        echo "$world: worlds/ledger_spec.lua does not look at its books of energy"
        bad=1
    fi
done
exit $bad
