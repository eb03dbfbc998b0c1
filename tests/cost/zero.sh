#!/usr/bin/env bash
# tests/cost/zero.sh - what no scene calls for costs nothing: for every effect there is, the scenes that do not call for it make no
# call, keep no byte, and end in the same bits in a build without that effect.
set -u
here=$PWD/tests/cost
build() { env -u MAKEFLAGS -u MAKELEVEL -u MFLAGS make -s -j1 without WITHOUT="$1" BUILD="$BUILD" SANITIZE="$SANITIZE" CC="${CC:-gcc}" >&2; }
program() { echo "$PWD/$BUILD/without-$1/digbox"; }

whole=$("$DIGBOX" run -q "$here/scenes.lua" -o "${TMPDIR:-/tmp}") || { echo "the scenes fail"; exit 1; }
effects=$(awk '$2 == "effect" && $3 != "own" { print $3 }' <<<"$whole" | sort -u)
scenes=$(awk '{ print $1 }' <<<"$whole" | sort -u)
passed=0 failed=0
holds() {
    if eval "$2"; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "not so: $1"; fi
}
# lines SCENE BUT: what the scene printed, without the lines of that effect
lines() { awk -v scene="$1" -v but="$2" '$1 == scene && !($2 == "effect" && $3 == but)'; }

holds "there are effects and scenes" '[ "$(wc -w <<<"$effects")" -ge 7 ] && [ "$(wc -w <<<"$scenes")" -ge 10 ]'
holds "no scene fails" '! grep -q "failed" <<<"$whole"'
for effect in $effects; do
    build "$effect" || { holds "a build without $effect" false; continue; }
    fewer=$("$(program "$effect")" run -q "$here/scenes.lua" -o "${TMPDIR:-/tmp}")
    free=0 used=0
    for scene in $scenes; do
        read -r calls bytes < <(awk -v scene="$scene" -v effect="$effect" '$1 == scene && $3 == effect { print $5, $7 }' <<<"$whole")
        if [ "$calls" -gt 0 ]; then used=$((used + 1)); continue; fi
        free=$((free + 1))
        holds "$scene: $effect keeps nothing ($bytes bytes)" '[ "$bytes" = 0 ]'
        holds "$scene: the same bits without $effect" 'cmp -s <(lines "$scene" "$effect" <<<"$whole") <(lines "$scene" "$effect" <<<"$fewer")'
    done
    holds "some scene does without $effect" '[ "$free" -gt 0 ]'
    # the builds differ: what calls for the effect misses it
    [ "$used" = 0 ] || holds "$effect is missing in the build without it" '! cmp -s <(echo "$whole") <(echo "$fewer")'
    echo "$effect: $free scenes without it, $used with it"
done
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
