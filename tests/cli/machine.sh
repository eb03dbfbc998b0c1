#!/usr/bin/env bash
# tests/cli/machine.sh - a run on a machine that is against it (B4 to B9): standard files closed or full, limits of the system, odd
# scripts, signals that stop it, another locale, and terminals that would act upon what is printed.
set -u
. "${0%/*}/../check.sh"
export LP_NUM_THREADS=0 MESA_SHADER_CACHE_DISABLE=true

cat >ball.lua <<'LUA'
local world = require("digbox").world {}
world:floor {}
world:ball { radius = 0.1, at = { 0, 0.3, 0 } }
world:record { to = "f-%02d.png", fps = 60, size = { 32, 18 }, samples = 0 }
for i = 1, 10 do print("a line of text", i / 4) world:step() end
LUA
gives 0 'a run' run -q -o whole ball.lua
cp out.txt whole.txt
same() { cmp -s "$1/f-00.png" whole/f-00.png && cmp -s "$1/f-10.png" whole/f-10.png && [ "$(ls "$1" | wc -l)" = 12 ]; }
# ends CODE WHAT: of the command before
ends() { local got=$?; holds "$2: exit code $1 (got $got)" test $got = "$1"; }

# ---- B8, B9: standard input, output and errors that are closed or full ----
"$DIGBOX" run -q -o no-out ball.lua >&- 2>err.txt </dev/null;           ends 9 'no standard output'
said 'standard output: Bad file descriptor'
holds 'and nothing of it in a frame' same no-out
"$DIGBOX" run -q -o none ball.lua <&- >&- 2>&-;                         ends 9 'none of the three'
holds 'and nothing of them in a frame' same none
"$DIGBOX" run -q -o no-err ball.lua 2>&- >out.txt </dev/null;           ends 0 'no standard error'
holds 'the frames are whole' same no-err
"$DIGBOX" run -o no-in ball.lua <&- >out.txt 2>err.txt;                 ends 0 'no standard input'
holds 'the frames are whole' same no-in
"$DIGBOX" run -q -o full ball.lua >/dev/full 2>err.txt </dev/null;      ends 9 'a full standard output'
said 'standard output: No space left on device'
holds 'the frames are whole' same full
"$DIGBOX" run -o full-err ball.lua >out.txt 2>/dev/full </dev/null;     ends 0 'full standard errors'
holds 'the frames are whole' same full-err
"$DIGBOX" api body >/dev/full 2>err.txt;                                ends 9 'help that cannot be written'
env -i "$DIGBOX" run -q -o bare ball.lua >out.txt 2>err.txt </dev/null; ends 0 'no environment at all'
holds 'the frames are whole' same bare
locale=$(locale -a 2>/dev/null | grep -m 1 -E '^(de|fr|es|ru)_')
LC_ALL=${locale:-de_DE.UTF-8} gives 0 "in the locale ${locale:-that is not there}" run -q -o german ball.lua
holds 'numbers have points' cmp out.txt whole.txt

# ---- B9: limits of the system ----
(ulimit -n 10; exec "$DIGBOX" run -q -o few ball.lua) >out.txt 2>err.txt </dev/null
code=$?
holds "ten open files: exit code 0, 9 or 11 (got $code)" grep -qx '0\|9\|11' <<<$code
[ $code = 0 ] && holds 'and then whole frames' same few
[ $code = 0 ] || holds 'and then a sentence' grep -q '^digbox: ' err.txt
if [ "$SANITIZE" = 0 ]; then
    (ulimit -v 300000; exec "$DIGBOX" run -q -o little ball.lua) >out.txt 2>err.txt </dev/null
    code=$?
    holds "300 MB of addresses: exit code 0, 3, 9 or 11 (got $code)" grep -qx '0\|3\|9\|11' <<<$code
    [ $code = 0 ] && holds 'and then whole frames' same little
    [ $code = 0 ] || holds 'and then a sentence' grep -q '^digbox: ' err.txt
fi
if [ "$(id -u)" != 0 ]; then
    (ulimit -u 1; exec "$DIGBOX" run -q -o alone ball.lua) >out.txt 2>err.txt </dev/null;       ends 11 'no more processes'
    said 'digbox: cannot start a process'
fi

# ---- B4: arguments ----
for bad in 0 -1 1e9 abc '' 1.5 99999999999999999999; do
    gives 2 "jobs '$bad'" test -j "$bad";                               said 'is not a whole number from 1 to 256'
done
gives 2 'an empty word' run '' ball.lua
gives 1 'an empty name' run '';                                         said 'digbox: '
gives 2 'an empty command' ''
gives 0 'an option twice: the last holds' run -q -o one --output two --seconds 0.02 ball.lua
holds 'the last holds' test -d two -a ! -d one
gives 0 'a name after --' check -- ball.lua
seq 100000 | xargs -n 200000 "$DIGBOX" run >out.txt 2>err.txt;          holds '100,000 arguments' test $? -ge 1
said 'one world at a time'

# ---- B5, B6: scripts ----
mkfifo pipe.lua
gives 1 'a pipe' run pipe.lua;                                          said 'pipe.lua: '
gives 1 'a device' run /dev/zero;                                       said '/dev/zero: '
truncate -s 1G huge.lua
gives 1 'a script of 1 GiB' run huge.lua;                               said 'huge.lua: '
name=$(printf 'caf\351.lua'); cp ball.lua "$name"
gives 0 'a name that is not UTF-8' run -q -o latin "$name"
if [ "$(id -u)" != 0 ]; then
    cp ball.lua secret.lua && chmod 000 secret.lua
    gives 1 'no permission' run secret.lua;                             said 'secret.lua: Permission denied'
fi
printf 'print(1)\nlocal t = {\nx = = 1 }\n' >three.lua
gives 1 'a mistake in line 3' run three.lua;                            said 'three.lua:3: '
echo 'require "three"' >outer.lua
gives 1 'in a module' run outer.lua;                                    said 'three.lua:3: '
printf 'a\0b = = 1\n' >nul.lua
gives 1 'a NUL in the text' run nul.lua;                                said 'nul.lua:1: '
{ printf 'local x = "'; head -c 300000 /dev/zero | tr '\0' 'y'; printf '" .. = 1\n'; } >long.lua
gives 1 'a line of 300,000 bytes' run long.lua;                         said 'long.lua:1: '
holds 'of which little is said' test "$(wc -c <err.txt)" -lt 400

# ---- B7: stopped and continued, which is not its own time ----
cat >busy.lua <<'LUA'
local world = require("digbox").world {}
world:ball { radius = 0.1, at = { 0, 9, 0 } }
for _ = 1, 400 do world:step(50) end
print(world.steps)
LUA
"$DIGBOX" run -q -o busy busy.lua >out.txt 2>err.txt </dev/null & pid=$!
for _ in 1 2 3 4 5; do kill -STOP $pid; sleep 0.05; kill -CONT $pid; sleep 0.05; done
wait $pid;                                                              ends 0 'stopped five times'
printed 20000

# ---- a terminal does not act upon what a stranger's world prints, nor do its names hold such bytes ----
cat >paints.lua <<'LUA'
print("\27]0;title\7\27[2J\8\r1 passed", "\u{9b}31m", "\xff", "\0", "caf\u{e9}\n\ttab")
local fine, why = pcall(require("digbox").world {}.ball, require("digbox").world {}, { radius = 1, name = "caf\xe9" })
print(fine, why)
LUA
gives 0 'a world that paints' run -q paints.lua
printf '?]0;title??[2J??1 passed\t?31m\t?\t?\tcaf\303\251\n\ttab\n' >clean.txt
holds 'is printed as text' cmp <(head -n 2 out.txt) clean.txt
printed 'name is not UTF-8'
gives 0 'unless it is trusted' run -q --trust paints.lua;               holds 'then it may' grep -q "$(printf '\033')" out.txt
cat >names_spec.lua <<'LUA'
local test = require "digbox.test"
test.scenario("caf\xe9 <b> \u{9b}31m \"&\"", function() print "\27[2J]]>" test.expect("\xff\u{85}"):is "\27<" end)
LUA
gives 6 'a scenario with such a name' test names_spec.lua --junit junit.xml
holds 'no control byte comes out' test "$(LC_ALL=C tr -d '\n\t -~\200-\377' <out.txt | wc -c)" = 0
if command -v python3 >/dev/null; then holds 'JUnit is XML' python3 -c 'import xml.dom.minidom; xml.dom.minidom.parse("junit.xml")'; fi

checked
