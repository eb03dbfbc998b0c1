#!/usr/bin/env bash
# tests/lint/compiler.sh - the other compiler has nothing to say either: gcc and clang both build without a warning.
#
# Checks syntax and warnings only. Skipped when there is no second compiler.
set -u
case ${CC:-gcc} in *clang*) other=gcc ;; *) other=clang ;; esac
command -v "$other" >/dev/null 2>&1 || { echo "no $other here: skipped"; exit 77; }
# -fno-ipa-ra: gcc alone knows and needs it.
flags=$(sed "s/^[^ ]* //; s/ -fno-ipa-ra//" "${BUILD:-build}/obj/flags.txt") || exit 1
# shellcheck disable=SC2086  # flags are words
find engine lua tests/unit -name '*.c' | sort | xargs -r -n 16 -P "$(nproc 2>/dev/null || echo 2)" \
    "$other" $flags -fsyntax-only -Itests -I. -Ilua
