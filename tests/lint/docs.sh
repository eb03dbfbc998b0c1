#!/usr/bin/env bash
# tests/lint/docs.sh - what the documents say of the code is so.
#
#   effects       each EffectType has its row in docs/effects.md, with its law, and its source in docs/references.bib
#   plans         each row of engine/solve/plan.c stands in docs/accuracy.md with the same numbers
#   excerpts      each line of a block opened by ```c PATH (or ```lua PATH) is a line of that file; ... is left out
#   names         each path in backquotes that begins with a folder of the tree exists
set -u
bad=0
say() { echo "$*"; bad=1; }
documents=$(ls README.md docs/*.md 2>/dev/null)
[ -n "$documents" ] || exit 0

# The text of `.FIELD = "..."` in a file.
field() { sed -n "s/^ *\\.$1 = \"\\(.*\\)\",\$/\\1/p" "$2"; }

for file in $(grep -l '^const EffectType effect_' engine/effect/*.c 2>/dev/null); do
    name=$(field name "$file")
    row=$(grep -F "| \`$name\` |" docs/effects.md | sed 's/\\|/|/g')
    [ -n "$row" ] || { say "docs/effects.md: no row for the effect '$name' of $file"; continue; }
    cite=$(field cite "$file")
    case $row in *"| $(field law "$file") | $cite |"*) ;; *) say "docs/effects.md: law or source of '$name' differs from $file" ;; esac
    grep -qE "^@[a-z]+\{$cite,\$" docs/references.bib || say "docs/references.bib: no entry '$cite', which $file cites"
done

if [ -e engine/solve/plan.c ]; then
    sed -n 's/^ *{\("[a-z]*",.*\)},$/\1/p' engine/solve/plan.c | tr -d '" ' | while IFS= read -r plan; do
        tr -d '` ' <docs/accuracy.md | grep -qF "|${plan//,/|}|" || echo "docs/accuracy.md: no row for the plan $plan of engine/solve/plan.c"
    done | grep . && bad=1
fi

# shellcheck disable=SC2086  # a list of paths, none with spaces
awk '
function trim(s) { gsub(/^[ \t]+|[ \t]+$/, "", s); return s }
/^ *```(c|lua) [a-z]/ { path = $2; inside = 1; if (!(path in loaded)) { loaded[path] = 1
                        while ((getline line < path) > 0) have[path, trim(line)] = 1 } next }
/^ *```/ { inside = 0; next }
function begins(line,   key) {     # is it the beginning of a line of the file?
    for (key in have) if (index(key, path SUBSEP line) == 1) return 1
    return 0
}
inside {
    line = trim($0)
    known = line == "" || line == "..." || (path, line) in have
    if (!known && sub(/ \.\.\.$/, "", line)) known = begins(line)
    if (!known) { print FILENAME ":" FNR ": not in " path ": " line; n++ }
}
END { exit n > 0 }' $documents || bad=1

# shellcheck disable=SC2086
grep -noE '`(engine|lua|worlds|tests|docs|\.ci)/[a-z0-9_./-]+`' $documents | tr -d '`' | while IFS=: read -r document line path; do
    [ -e "${path%/}" ] || echo "$document:$line: there is no $path"
done | grep . && bad=1
exit $bad
