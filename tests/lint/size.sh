#!/usr/bin/env bash
# tests/lint/size.sh - a function fits on a screen, a file in a head.
#
# Aim: 60 lines a function, 500 a file. Limit, judged here: 80 and 800, and 160 columns (aim: 140).
# What is longer for a good reason stands in size_exceptions.txt as
#   path[:function] limit reason
set -u
files=$(find engine lua worlds tests \( -name '*.[ch]' -o -name '*.lua' \) | sort)
[ -n "$files" ] || exit 0
# shellcheck disable=SC2086  # a list of paths, none with spaces
awk -v function_limit=80 -v file_limit=800 -v columns=160 '
function judge(what, lines, limit, line) {
    if (what in allowed) { used[what] = 1; limit = allowed[what] }
    if (lines > limit) { print what ":" line ": " lines " lines, more than " limit; n++ }
}
function end_file() { if (last) judge(last, count, file_limit, 1) }

FILENAME ~ /size_exceptions/ {
    if ($0 !~ /^#/ && NF) {
        allowed[$1] = $2
        if (NF < 4) { print FILENAME ":" FNR ": " $1 " is excepted without a reason"; n++ }
    }
    next
}
FNR == 1 { end_file(); last = FILENAME; head = ""; start = 0; is_c = FILENAME ~ /\.[ch]$/ }
{ count = FNR }
length($0) > columns { print FILENAME ":" FNR ": " length($0) " columns, more than " columns; n++ }
# A function: its head begins in column 1 and its braces stand there too.
!is_c { next }
/^[A-Za-z_].*\(/ && !/;[ \t]*$/ && !/^typedef|^struct|^enum|^#/ { head = $0; head_line = FNR }
/^\{/ || (/^[A-Za-z_].*\).*\{$/ && !/=/) { if (head != "") start = head_line }
/^\}/ {
    if (start) {
        name = head; sub(/\(.*/, "", name); sub(/.*[ *]/, "", name)
        judge(FILENAME ":" name, FNR - start + 1, function_limit, start)
    }
    start = 0; head = ""
}
END {
    end_file()
    for (what in allowed) if (!used[what]) { print "tests/lint/size_exceptions.txt: " what " is not needed any more"; n++ }
    exit n > 0
}' tests/lint/size_exceptions.txt $files
