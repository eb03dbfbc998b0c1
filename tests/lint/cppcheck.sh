#!/usr/bin/env bash
# tests/lint/cppcheck.sh - a second pair of eyes over the C code, where cppcheck is installed.
set -u
command -v cppcheck >/dev/null 2>&1 || { echo "no cppcheck here: skipped"; exit 77; }
cache=${BUILD:-build}/cppcheck
mkdir -p "$cache"
cppcheck --quiet --cppcheck-build-dir="$cache" --std=c11 --enable=warning,portability --inline-suppr --error-exitcode=1 \
    --suppress=missingIncludeSystem --suppress=unknownMacro -j "$(nproc 2>/dev/null || echo 2)" -Iengine engine lua 2>&1
