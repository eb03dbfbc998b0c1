#!/usr/bin/env bash
# tests/lint/selftest.sh - each lint finds what it is there to find: offences are planted in a toy tree.
set -u
root=$PWD
scratch=$(mktemp -d)
toy=$scratch/toy
said=$scratch/said
mkdir "$toy"
trap 'rm -rf "$scratch"' EXIT
passed=0 failed=0

fresh() {
    rm -rf "${toy:?}"/*
    mkdir -p "$toy"/{docs,engine/{base,math,geom,effect,joint,render},lua/digbox,worlds,tests/{unit,lint,scenarios},build}
    cp "$root/docs/floors.txt" "$toy/docs/"
    cp "$root"/tests/lint/*.sh "$toy/tests/lint/"
    echo '# none' >"$toy/tests/lint/size_exceptions.txt"
    echo '/* engine/digbox.h - toy */' >"$toy/engine/digbox.h"
}
# put FILE TEXT: the text follows a proper first line.
put() { printf '/* %s - a toy file */\n%b\n' "$1" "$2" >"$toy/$1"; }
verdict() {
    if [ "$1" = "$2" ]; then passed=$((passed + 1)); return; fi
    failed=$((failed + 1))
    echo "$3: want exit status $2, got $1; it said:"
    sed 's/^/    /' "$said"
}
# catches WHAT LINT.sh: the lint fails on the toy tree.  accepts WHAT LINT.sh: it does not.
lint() { (cd "$toy" && BUILD=build bash "tests/lint/$1" >"$said" 2>&1); }
catches() { lint "$2"; verdict $(($? != 0)) 1 "$2 must catch: $1"; fresh; }
accepts() { lint "$2"; verdict $(($? != 0)) 0 "$2 must accept: $1"; fresh; }
library() {     # compiles the toy's engine/base/a.c
    (cd "$toy" && ${CC:-gcc} -std=c17 -O1 -c -o build/a.o engine/base/a.c && ar rcs build/libdigbox.a build/a.o)
}
fresh

put engine/math/a.c '#include "base/base.h"\n#include "digbox.h"\n#include <math.h>';  accepts 'a look down' floors.sh
put engine/base/a.c '#include "math/vec.h"';                     catches 'a look up' floors.sh
put engine/math/a.c '#include "vec.h"';                          catches 'an include without its folder' floors.sh
put engine/math/a.c '#  include "../geom/box.h"';                catches 'an include with ..' floors.sh
put engine/effect/heat.c '#include "effect/friction.h"';         catches 'an effect that knows another' floors.sh
put engine/effect/heat.c '#include "effect/heat.h"\n#include "effect/effect.h"';       accepts 'an effect and its interface' floors.sh
put engine/base/a.c '#include <lua.h>';                          catches 'Lua in the engine' floors.sh
put engine/geom/a.c '#include <GL/gl.h>';                        catches 'OpenGL outside render' floors.sh
put engine/geom/a.c '#ifdef DIGBOX_NO_RENDER\n#endif';           catches 'code of one build alone' floors.sh
put engine/digbox.h '#include "base/base.h"';                    catches 'a public header that includes the engine' floors.sh
put lua/a.c '#include "world/world.h"';                          catches 'Lua bindings that look inside' floors.sh
put lua/bind.h ''; put lua/a.c '#include "bind.h"\n#include "digbox.h"\n#include "render/render.h"\n#include <lua.h>'
accepts 'Lua bindings on the public headers' floors.sh
mkdir "$toy/engine/attic"; put engine/attic/a.c '';              catches 'a folder without a row' floors.sh

long() { echo "static int longest(int x)"; echo "{"; for _ in $(seq "$1"); do echo "    x++;"; done; echo "    return x;"; echo "}"; }
long 76 >"$toy/engine/base/a.c";                                 accepts 'a function of 80 lines' size.sh
long 77 >"$toy/engine/base/a.c";                                 catches 'a function of 81 lines' size.sh
long 77 >"$toy/engine/base/a.c"; echo 'engine/base/a.c:longest 90 one table of cases' >"$toy/tests/lint/size_exceptions.txt"
accepts 'an exception with a reason' size.sh
long 77 >"$toy/engine/base/a.c"; echo 'engine/base/a.c:longest 90' >"$toy/tests/lint/size_exceptions.txt"
catches 'an exception without a reason' size.sh
echo 'engine/base/a.c:longest 90 not needed' >"$toy/tests/lint/size_exceptions.txt"; put engine/base/a.c ''
catches 'an exception that nothing needs' size.sh
seq 801 >"$toy/lua/digbox/a.lua";                                catches 'a file of 801 lines' size.sh
printf '%161s\n' x >"$toy/engine/base/a.h";                      catches 'a line of 161 columns' size.sh

put engine/base/a.c '/* TO''DO */';                              catches 'an open end' names.sh
put engine/base/a.c '/* see /ho''me/me/notes */';                catches 'a path of one machine' names.sh
put engine/base/a.c 'const char *p = "/va''r/t''mp/notes";';           catches 'a folder of one system' names.sh
put engine/base/a.c 'static int f(const Shape *s) { switch (s->type) { default: return 0; } }'
catches 'a switch on a type' names.sh
echo 'int x;' >"$toy/engine/base/a.c";                           catches 'a file that does not say what it is for' names.sh
touch "$toy/notes.txt";                                          catches 'a new name at the top level' names.sh
put engine/base/a.c 'int main(void) { return 0; }';              accepts 'an ordinary file' names.sh

put engine/base/a.c 'int f(void);\nint f(void) { static int n; return n++; }';    library; catches 'a static counter' globals.sh
put engine/base/a.c 'int shared = 3;';                           library; catches 'a global variable' globals.sh
put engine/base/a.c 'const char *const names[] = {"a", "b"};';   library; accepts 'a table of constants' globals.sh
put engine/base/a.c '#include <stdio.h>\nvoid f(void);\nvoid f(void) { printf("%d", 3); }'; library; catches 'a print' globals.sh
put engine/base/a.c '#include <stdlib.h>\nvoid f(void);\nvoid f(void) { abort(); }';        library; catches 'an abort' globals.sh

put engine/render/a.c 'static const char s[] = "#version 330 core\\n";';   accepts 'version 330' shaders.sh
put engine/render/a.c 'static const char s[] = "#version 450\\n";';        catches 'version 450' shaders.sh

touch "$toy/worlds/01_drop.lua";                                 catches 'a world without a test' worlds.sh
touch "$toy/worlds/01_drop.lua"; echo 'run "01_drop"' >"$toy/tests/scenarios/a.lua";        catches 'a world whose books nobody checks' worlds.sh
touch "$toy/worlds/01_drop.lua"; echo 'run "01_drop"' >"$toy/worlds/ledger_spec.lua";         accepts 'a world with both' worlds.sh
echo 'x = 1' >"$toy/worlds/a.lua";                               catches 'a global variable in Lua' lua.sh

put engine/digbox.h 'dig_status dig_toy_set(dig_world *w, int x);';          catches 'a call that no replay knows of' commands.sh
put engine/digbox.h 'dig_status dig_toy_get(const dig_world *w, int *x);';   accepts 'a call that looks only' commands.sh

echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
