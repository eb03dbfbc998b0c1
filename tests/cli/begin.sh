#!/usr/bin/env bash
# tests/cli/begin.sh - what helps to begin: digbox new, doctor and repl.
set -u
. "${0%/*}/../check.sh"

# ---- new ----
gives 0 'new' new deep/place;                   printed 'deep/place/world_spec.lua'
for name in world.lua world_spec.lua .luarc.json .luacheckrc digbox.d.lua; do holds "there is $name" test -s "deep/place/$name"; done
gives 2 'a folder with files' new deep/place;   said 'holds files already'
gives 2 'no name' new
gives 2 'two names' new a b
touch afile
gives 2 'a file in the way' new afile/x;        said 'afile'
holds 'nothing was made' test ! -e a
cd deep/place || exit 1
gives 0 'its world runs' run -q world.lua;      printed "touching	{body 'table'}"
holds 'and leaves a picture' test -s out/world.png
gives 0 'with its argument' run -q world.lua -- --height '2 m'; printed 'at 6.'
gives 0 'its spec passes' test;                 printed '1 passed, 0 failed'
gives 0 'its world is checked' check world.lua
if command -v luacheck >/dev/null; then holds 'luacheck finds nothing' luacheck --quiet .; fi
if command -v python3 >/dev/null; then holds '.luarc.json is JSON' python3 -m json.tool .luarc.json; fi
"$DIGBOX" api --luacats >now.lua
holds 'digbox.d.lua is what the program says' cmp now.lua digbox.d.lua
cd ../.. || exit 1

# ---- doctor ----
gives 0 'doctor' doctor
for word in digbox Lua libedit processor features threads seccomp landlock renderer 'all that is needed is there'; do printed "$word"; done
GALLIUM_DRIVER=softpipe gives 0 'a slow driver is said' doctor;     printed 'unset GALLIUM_DRIVER'
PATH=/nowhere gives 0 'what is not there is said' doctor;           printed 'apt-get install ffmpeg'
GALLIUM_DRIVER=llvmpipe gives 0 'variables are said' doctor;        printed 'GALLIUM_DRIVER=llvmpipe'
gives 2 'doctor of something' doctor me
if [ "$(id -u)" != 0 ]; then
    mkdir closed && chmod 555 closed && cd closed || exit 1
    "$DIGBOX" doctor >../o.txt 2>&1; code=$?
    cd ..
    holds 'a folder that cannot be written: exit 1' test "$code" = 1
    holds 'and it says what to do' grep -q 'use -o DIR' o.txt
fi

# ---- repl ----
says() {                        # says LINES: what the repl makes of them
    printf '%s\n' "$@" | "$DIGBOX" repl >out.txt 2>err.txt
}
says '1 +' '2';                                 printed '3'
says 'for i = 1, 2 do' 'print("line", i)' 'end';    printed 'line	2'
says 'x = 21' 'x * 2';                          printed '42'
says 'ball = world:ball { radius = "10 cm", at = { 0, 1, 0 } }' 'world:run "0.1 s"' 'ball.position.y < 1';  printed 'true'
says 'world:bll {}' '"still here"';             said "did you mean 'ball'?"; printed 'still here'
says 'x = = 1' '"still here"';                  said 'repl:1:'; printed 'still here'
says 'error({})' '"still here"';                printed 'still here'
says 'help "world:lamp"';                       printed 'how bright'
says '1 + 1' exit '"still here"';               printed '2'; lacks 'still here'
says 'io';                                      printed 'nil'
printf 'local digbox = require "digbox"\nlocal w = digbox.world {}\nw:box { name = "crate", size = 1 }\n' >crate.lua
echo 'world:find "crate"' | "$DIGBOX" repl crate.lua >out.txt 2>err.txt;    printed "body 'crate'"
printf '%s\n' 'local t = {} for i = 1, 1e9 do t[i] = ("x"):rep(1000) .. i end' '"still here"' |
    "$DIGBOX" repl --memory-limit 100 >out.txt 2>err.txt
said 'needs more than 100 MiB';                 printed 'still here'
gives 0 'its walls are said' repl --verbose;    said 'jail: landlock'
gives 0 'there are none for who is trusted' repl --trust --verbose;     said 'jail: none'
gives 2 'a limit that is none' repl --memory-limit much

# With a terminal: names are completed by Tab, and lines kept, in the one file that the walls leave open.
type_in() {                     # type_in TEXT...: what a terminal shows of the repl then; it must be reading before the first is typed
    (for text in "$@" '\004'; do sleep 1; printf '%b' "$text"; done; sleep 1) |
        HOME=$PWD XDG_STATE_HOME='' TERM=xterm timeout 20 script -qec "'$DIGBOX' repl" seen.txt >out.txt 2>err.txt
}
if command -v script >/dev/null && "$DIGBOX" doctor | grep -q '^ok *libedit'; then
    type_in 'answer = 6 * 7\nanswer + 4200\nworld:bodi\t()\n'
    holds 'it calculates' grep -q 4242 seen.txt
    holds 'lines are kept' grep -q 'answer' .digbox_history
    holds 'Tab completes names' grep -q 'world:bodies' .digbox_history
    holds 'for nobody else' test "$(stat -c %a .digbox_history)" = 600
    type_in 'while true do end\n' '\003' '"still " .. "here"\n'
    holds 'Ctrl-C ends the line, not the repl' grep -q 'still here' seen.txt
    holds 'old lines stay' grep -q 'world:bodies' .digbox_history
fi
gives 1 'a world that is not there' repl nowhere.lua
gives 2 'two worlds' repl a.lua b.lua
gives 0 'an empty input' repl
checked
