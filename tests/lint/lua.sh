#!/usr/bin/env bash
# tests/lint/lua.sh - luacheck over every Lua file (settings in .luacheckrc).
set -u
files=$(find lua worlds tests -path tests/hostile -prune -o -name '*.lua' -print | sort)
[ -n "$files" ] || exit 0
command -v luacheck >/dev/null 2>&1 || { echo "luacheck is missing: make deps"; exit 1; }
# shellcheck disable=SC2086  # a list of paths, none with spaces
luacheck --quiet --codes --no-color $files
