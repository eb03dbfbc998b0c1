#!/usr/bin/env bash
# tests/export/check.sh - the .glb of some worlds before two strict readers: Khronos' gltf-validator and Blender.
#
# Called by `make export-check`; BUILD is the build folder. Needs node and npm (gltf-validator, by its lock file) and Blender.
set -u
root=$PWD
out=${BUILD:-build}/export
mkdir -p "$out/npm"
cp tests/export/package.json tests/export/package-lock.json "$out/npm/"
(cd "$out/npm" && npm ci --silent --no-audit --no-fund) || { echo "0 passed, 1 failed"; exit 1; }
cat >"$out/npm/validate.cjs" <<'JS'
const fs = require('fs'), validator = require('gltf-validator')
validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[2]))).then(report => {
  const { numErrors, numWarnings, messages } = report.issues
  for (const m of messages.slice(0, 10)) console.log(m.severity, m.code, m.message, m.pointer)
  console.log(`${numErrors} errors, ${numWarnings} warnings`)
  process.exit(numErrors + numWarnings ? 1 : 0)
})
JS
passed=0 failed=0
count() { if "$@"; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "failed: $*"; fi; }
for world in 02_slope 11_gears bridge sawn_plank hot_iron; do
    "$BUILD/digbox" run -q -o "$out" --seconds 3 --replay "$out/$world.replay" "worlds/$world.lua" >/dev/null 2>&1
    for form in glb csv; do count "$BUILD/digbox" export -q "$out/$world.replay" -o "$out/$world.$form"; done
    echo "$world: gltf-validator"
    count node "$out/npm/validate.cjs" "$out/$world.glb"
    echo "$world: Blender"
    count blender -b --factory-startup --python-exit-code 1 -P "$root/tests/export/blender.py" -- "$out/$world.glb" "$out/$world.csv" \
        >"$out/$world.log" 2>&1
    grep -a CHECKED "$out/$world.log"
done
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
