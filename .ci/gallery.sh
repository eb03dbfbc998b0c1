#!/bin/sh
# .ci/gallery.sh - the gallery of worlds: its page from their heads, and its pictures.
#
#   sh .ci/gallery.sh page DIGBOX               writes docs/gallery.md to stdout
#   sh .ci/gallery.sh pictures DIGBOX           a picture of every world into out/gallery/, small ones of some into docs/gallery/
set -eu
digbox=$2

# Worlds whose small picture is kept with the page, and the moment it shows, s.
kept='05_cradle 0.62
10_arch 1.4
11_gears 6
15_landscape 1.2
bridge 4.4
cog_board 1
hot_iron 20'

worlds() { find worlds -maxdepth 1 -name '*.lua' ! -name '*_spec.lua' | sort; }

# The lines of a world's head after "Look at:", "Law:" or "Expected:", as one.
part() {
    awk -v want="$2:" '
        !/^--/ { exit }
        { line = $0; sub(/^-- */, "", line) }
        line ~ /^(Look at|Law|Expected):/ { inside = index(line, want) == 1; sub(/^[A-Za-z ]+: */, "", line) }
        line ~ /^digbox / || line == "" { inside = 0 }
        inside { text = text (text == "" ? "" : " ") line }
        END { print text }' "$1"
}

page() {
    echo '# Gallery'
    echo
    echo 'Written by `make docs` from the heads of the worlds. `make gallery` draws a picture of each into `out/gallery/`.'
    echo 'Each film: `digbox run worlds/NAME.lua -- --film`; what may be changed: `digbox run worlds/NAME.lua -- --help`.'
    for world in $(worlds); do
        name=$(basename "$world" .lua)
        printf '\n## %s\n\n' "$name"
        [ ! -e "docs/gallery/$name.jpg" ] || printf '![%s](gallery/%s.jpg)\n\n' "$name" "$name"
        sed -n '1s/^-- *[a-z0-9_]*\.lua: *\(.\)/\1/p' "$world" | awk '{ print toupper(substr($0, 1, 1)) substr($0, 2) }'
        echo
        for label in 'Look at' 'Law' 'Expected'; do
            text=$(part "$world" "$label")
            [ -z "$text" ] || printf '* %s: %s\n' "$label" "$text" | sed 's/\*\([^ ]\)/\\*\1/g'
        done
        options=$("$digbox" run -q "$world" -- --help 2>/dev/null | sed -n 's/^  --\([a-z_]*\) VALUE *\(.*\)$/`--\1` \2/p' | paste -s -d ';' | sed 's/;/; /g')
        [ -z "$options" ] || printf '* Try: %s\n' "$options"
    done
}

pictures() {
    mkdir -p out/gallery docs/gallery
    for world in $(worlds); do
        name=$(basename "$world" .lua)
        moment=$(printf '%s\n' "$kept" | sed -n "s/^$name //p")
        # a world may refuse to end early: its own checks come too soon then
        "$digbox" run -q -o out/gallery "$world" ${moment:+--seconds "$moment"} >out/gallery/"$name".txt 2>&1 || :
        if [ -n "$moment" ] && [ -e "out/gallery/$name.png" ]; then
            ffmpeg -nostdin -loglevel error -y -i "out/gallery/$name.png" -vf scale=320:-1:flags=area -q:v 6 "docs/gallery/$name.jpg"
        fi
    done
    ls -l docs/gallery
}

"$1"
