#!/usr/bin/env bash
# tests/lint/cppcheck.sh - a second pair of eyes over the C code, where cppcheck is installed.
#
# __GNUC__ is defined as by both compilers, __clang__ is not (it chooses names of attributes and pragmas only): each file is read half as often.
# Every other question of the preprocessor is still asked both ways, which --force says, as -D alone would end that.
# ctuuninitvar is left out: release 2.10 takes a pointer into what a function fills for a reading of it (geom/patch.c, find_face).
set -u
command -v cppcheck >/dev/null 2>&1 || { echo "no cppcheck here: skipped"; exit 77; }
cache=${BUILD:-build}/cppcheck
mkdir -p "$cache"
cppcheck --quiet --cppcheck-build-dir="$cache" --std=c11 --enable=warning,portability --inline-suppr --error-exitcode=1 \
    --suppress=missingIncludeSystem --suppress=unknownMacro --suppress=ctuuninitvar -U__clang__ -D__GNUC__=12 --force -j "$(nproc 2>/dev/null || echo 2)" -Iengine engine lua 2>&1
