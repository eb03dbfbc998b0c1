#!/usr/bin/env bash
# tests/lint/names.sh - words and names that have no place in the sources.
#
# Patterns are written so that they do not find themselves.
set -u
bad=0
text() { find . \( -name .git -o -name build -o -name out \) -prune -o -type f "$@" -print | sed 's|^\./||' | sort; }
code() { find engine lua worlds tests -type f \( -name '*.[ch]' -o -name '*.lua' -o -name '*.sh' \) | sort; }

# report WHY PATTERN: reads paths, prints the lines that match; false when there are any.
report() { ! xargs -r grep -nHE -- "$2" /dev/null | sed "s|^|$1: |" | grep .; }

# An open end is an issue or a test that fails, not a comment.
code | report 'open end' '\b(TOD[O]|FIXM[E]|XX[X]|HAC[K])\b|\bstu[b]\b|not implemente[d]' || bad=1
# A path of one machine is wrong on every other.
text ! -name '*.png' | report 'path of one machine' '(^|[^A-Za-z0-9_.~}/-])/(wor[k]|far[m]|(var/)?tm[p]|hom[e]|roo[t]|Use[r]s)(/|\b)|\.librar[y]/' || bad=1
# A type is a table, so nothing asks which one it is (style flaw 1).
find engine lua -name '*.[ch]' | sort |
    report 'switch on a type' 'switch \([^)]*(->|\.|_)type\b' || bad=1
# Tables aside, C here has no goto save for one clean-up label.
find engine lua -name '*.[ch]' | sort | xargs -r awk '
    /^[ \t]*goto[ \t]/ && $2 !~ /^(done|fail|cleanup|out);/ { print "goto: " FILENAME ":" FNR ": " $0; n++ }
    END { exit n > 0 }' || bad=1
# The first line of a file says what it is for.
find engine lua tests \( -name '*.[ch]' -o -name '*.lua' -o -name '*.sh' \) | sort | while read -r f; do
    head -n 3 "$f" | grep -qE '^(/\*|//|--|#) ?[^!]' || echo "$f:1: the first line does not say what the file is for"
done | grep . && bad=1
# The user fixed the names at the top level.
for entry in *; do
    case $entry in
        engine|lua|worlds|tests|docs|Makefile|README.md|LICENSE|build|out) ;;
        *) echo "$entry: not one of the names at the top level"; bad=1 ;;
    esac
done
exit $bad
