#!/bin/sh
# .ci/film.sh - says where the frames of `make demo` are; joins them to an mp4 when ffmpeg is there.
#
#   sh .ci/film.sh out/NAME          frames are out/NAME*00000.png and on
set -eu
first=$(ls "$1"*[0-9].png 2>/dev/null | sort | head -n 1)
[ -n "$first" ] || { echo "digbox: no frames at $1*.png" >&2; exit 1; }

digits=$(expr "$first" : '.*[^0-9]\([0-9][0-9]*\)\.png$' || :)     # expr fails on a number that is zero
stem=${first%"$digits".png}
film=$(ls "$1"*.mp4 2>/dev/null | head -n 1)
echo "frames: $(ls "$stem"*[0-9].png | wc -l), from $first"

if [ -z "$film" ] && command -v ffmpeg >/dev/null 2>&1; then
    film=$1.mp4
    ffmpeg -nostdin -loglevel error -y -framerate "${FPS:-30}" -start_number "$digits" -i "$stem%0${#digits}d.png" \
        -vf "pad=ceil(iw/2)*2:ceil(ih/2)*2" -pix_fmt yuv420p -movflags +faststart "$film"
fi
if [ -n "$film" ]; then
    echo "film:   $film"
else
    echo "no ffmpeg here, so no mp4; sudo apt-get install ffmpeg, then make demo again"
fi
