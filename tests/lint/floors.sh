#!/usr/bin/env bash
# tests/lint/floors.sh - no file includes what its floor may not see (docs/floors.txt, docs/floors.md), and only
# lua/bind_film.c is compiled otherwise without a renderer: what runs in both builds is tested in one (.ci/run).
set -u
files=$(find engine lua -name '*.[ch]' | sort)
[ -n "$files" ] || exit 0
# shellcheck disable=SC2086  # a list of paths, none with spaces
awk '
function bad(text) { print FILENAME ":" FNR ": " text; n++ }

NR == FNR {                                     # the table
    split($0, row, ":")
    if (substr($0, 1, 1) == "<") system_for[row[1]] = row[2] " "
    else may_see[row[1]] = " " row[1] row[2] " "
    next
}
/DIGBOX_NO_RENDER/ && FILENAME != "lua/bind_film.c" { bad("only lua/bind_film.c may ask whether there is a renderer") }
FNR == 1 {
    split(FILENAME, part, "/")
    public = FILENAME == "engine/digbox.h"
    floor = part[1] == "lua" ? "lua" : part[2]
    own = part[3]; sub(/\..*/, "", own)
    if (!public && !(floor in may_see)) bad("the folder " floor " has no row in docs/floors.txt")
}
/^[ \t]*#[ \t]*include[ \t]*</ {
    header = $0; sub(/^[^<]*/, "", header)
    for (start in system_for)
        if (index(header, start) == 1 && !index(system_for[start], " " floor " "))
            bad((public ? "digbox.h" : floor) " may not include " header)
}
/^[ \t]*#[ \t]*include[ \t]*"/ {
    split($0, quoted, "\""); header = quoted[2]
    split(header, to, "/"); file = to[2]; sub(/\..*/, "", file)
    if (public) { bad("digbox.h includes nothing of the engine"); next }
    if (header ~ /\.\./) { bad("an include has no .. in it: " header); next }
    if (floor == "lua") {
        if (!index(may_see["lua"], " " header " ") && (to[2] != "" || system("test -e lua/" header) != 0))
            bad("lua may not include " header)
        next
    }
    if (header == "digbox.h") next
    if (to[2] == "") { bad("write the folder too: \"" header "\""); next }
    if (!index(may_see[floor], " " to[1] " ")) bad(floor " may not include " header)
    else if ((floor == "effect" || floor == "joint") && to[1] == floor && file != own && file != floor && file != floor "s")
        bad(floor "s do not know each other: " header)
}
END { exit n > 0 }' docs/floors.txt $files
