#!/usr/bin/env bash
# tests/lint/shaders.sh - every shader says #version 330 (core); anything newer is missing on some drivers.
set -u
found=$(grep -rnE '#version' engine/render 2>/dev/null)
[ -n "$(find engine/render -name '*.c' | head -n 1)" ] && [ -z "$found" ] && { echo "engine/render: no shader names its version"; exit 1; }
wrong=$(printf '%s\n' "$found" | grep -vE '#version 330( core)?([^ 0-9a-z]|$| [^0-9a-z])' | grep .)
[ -z "$wrong" ] && exit 0
printf '%s\n' "$wrong"
exit 1
