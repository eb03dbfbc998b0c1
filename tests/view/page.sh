#!/usr/bin/env bash
# tests/view/page.sh - the page of `digbox view` in a browser (page.mjs). Needs what `make viewer` builds, and chromium.
set -u
cannot() {      # on a developer's machine the browser may be missing, in continuous integration it may not
    echo "$1"
    [ "${CI:-}" = true ] && exit 1
    exit 77
}
[ "${SANITIZE:-0}" = 1 ] && { echo "judged on the plain build"; exit 77; }
[ -e build/viewer/page.html ] || cannot "there is no page: make viewer builds it"
CHROMIUM=$(command -v chromium || command -v chromium-browser || command -v google-chrome) || cannot "there is no chromium"
command -v node >/dev/null || cannot "there is no node"
here=$PWD/tests/view NODE_MODULES=$PWD/build/viewer/node_modules shell=$PWD/build/viewer/page.html
export CHROMIUM NODE_MODULES
cd "$TMPDIR" || exit 1

cat >run.lua <<'LUA'
local digbox = require "digbox"
local world = digbox.world {}
world:floor { name = "floor", material = "tile" }
local ball = world:ball { name = "ball", material = "steel", radius = "8 cm", at = { 0, 1.2, 0 } }
world:box { name = "</script><b>", material = "oak", size = { 0.6, 0.2, 0.4 }, at = { 0.1, 0.1, 0 } }
world:box { name = "crate", material = "oak", size = 0.3, at = { 0.8, 1, 0.2 }, velocity = { -1, 0, 0 }, spin = { 1, 2, 3 } }
ball:push { force = "3 N", along = { 1, 0, 0 }, lasts = "0.3 s" }
world:camera { name = "chase", at = { 1, 1, 2 }, follow = ball }
world:camera { name = "all", fov = "30 deg" }
world:sun { from = { -1, 1, 0.2 } }
world:lamp { at = { 1, 2, 1 }, power = "80 W" }
world:sky "overcast"
world:record { to = "f-%05d.png", fps = 1 }:close()
world:run "1.5 s"
LUA
"$DIGBOX" run -q run.lua --replay run.replay && "$DIGBOX" view -q run.replay -o run.html && "$DIGBOX" export -q run.replay -o run.csv &&
    "$DIGBOX" export -q run.replay -o run.jsonl &&
    node "$here/sample.mjs" "$shell" sample.html || exit 1
timeout -k 5 600 node "$here/page.mjs" sample.html run.html run.csv run.jsonl ${PICTURES:+"$PICTURES"}
