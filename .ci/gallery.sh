#!/bin/sh
# .ci/gallery.sh - the gallery of worlds: its page from their heads, and its pictures.
#
#   sh .ci/gallery.sh page DIGBOX               writes docs/gallery.md to stdout
#   sh .ci/gallery.sh pictures DIGBOX           a picture of every world into out/gallery/, a small one into docs/gallery/
set -eu
digbox=$2

# What the picture of a world shows when it is not the end of its run: the moment (s, a multiple of 1/30), and overlays if it has any.
moments='05_cradle 0.6 joints
10_arch 1.4
11_gears 6
12_spring 2.2 joints
13_room 2 joints
15_landscape 1.2
ball_table_bucket 0.8
bridge 4.4 stress
cog_board 1
hot_iron 20 temperature
orbit 7.8 trails'

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

# A world may refuse to end early: its own checks come too soon then. With overlays its replay is drawn, which knows what was before.
draw() {
    name=$1 moment=$2 overlay=$3
    set -- "$digbox" run -q -o "$work" "worlds/$name.lua"
    [ -z "$moment" ] || set -- "$@" --seconds "$moment" --replay "$work/$name.replay"
    "$@" >"out/gallery/$name.txt" 2>&1 || :
    [ -z "$moment" ] || "$digbox" render "$work/$name.replay" --overlay "$overlay" -o "$work/$name-%05d.png" \
        --size 1280x720 --fps 30 --frames "$(frame "$moment")" 2>>"out/gallery/$name.txt" || :
    for picture in "$work/$name"*.png; do       # the only one
        [ ! -e "$picture" ] || mv "$picture" "out/gallery/$name.png"
    done
}
frame() { awk -v t="$1" 'BEGIN { n = int(30 * t + 0.5); print n ".." n }'; }

pictures() {
    mkdir -p out/gallery docs/gallery
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    for world in $(worlds); do
        name=$(basename "$world" .lua)
        shown=$(printf '%s\n' "$moments" | sed -n "s/^$name //p")
        moment=${shown%% *} overlay=
        [ "$moment" = "$shown" ] || overlay=${shown#* }
        rm -f "out/gallery/$name.png" "$work"/*
        draw "$name" "$moment" "$overlay"
        [ ! -e "out/gallery/$name.png" ] ||
            ffmpeg -nostdin -loglevel error -y -i "out/gallery/$name.png" -vf scale=320:-1:flags=area -q:v 6 "docs/gallery/$name.jpg"
    done
    ls -l docs/gallery
}

"$1"
