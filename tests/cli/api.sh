#!/usr/bin/env bash
# tests/cli/api.sh - digbox api: text, suggestions, the forms for editors, shell and paper; docs/lua.md is what the program says.
#
# Only in the plain build: hundreds of short runs that print tables, which start three times as slowly under sanitizers.
set -u
. "${0%/*}/../check.sh"
tree=$(cd "${DIGBOX%/*}/.." && while [ ! -e Makefile ] && [ "$PWD" != / ]; do cd ..; done; pwd)

gives 0 'everything' api;                       printed 'world:camera'; printed 'contact_begin'
gives 0 'one method' api world:lamp;            printed 'number, W, > 0'; printed 'required'; printed 'how bright'
gives 0 'by its last word' api lamp;            printed 'world:lamp{'
gives 0 'a joint, with what its tables hold' api hinge;   printed 'motor.max_torque'
gives 0 'a type' api body;                      printed 'body.position'; printed 'body:push'; printed 'emissivity'
gives 0 'a property' api body.position;         printed 'of its origin'
gives 0 'a default of three numbers' api digbox.world;  printed 'default {0, -9.81, 0}'
gives 0 'an energy with its zero' api body.energy;      printed 'kinetic and potential'
gives 0 'a field' api gravity_scale;            printed 'share of gravity'
gives 0 'an event' api contact_begin;           printed 'e.speed'
gives 2 'an unknown name' api lmap;             said "unknown name 'lmap' (did you mean 'lamp'?)"
gives 2 'two names' api lamp camera
gives 2 'a name for what has none' api --man lamp
gives 2 'a shell that is not known' api --completion tcsh
gives 2 'an unknown option' api --frobnicate

# ---- the forms ----
gives 0 'markdown' api --markdown
holds 'docs/lua.md is of today (make docs)' cmp out.txt "$tree/docs/lua.md"
gives 0 'a material' api oak; printed 'material = "oak" gives a body'; printed '720 kg/m^3'
gives 0 'materials' api --materials
holds 'docs/materials.md is of today (make docs)' cmp out.txt "$tree/docs/materials.md"
(cd "$tree" && sh .ci/gallery.sh page "$DIGBOX") >gallery.md
holds 'docs/gallery.md is of today (make docs)' cmp gallery.md "$tree/docs/gallery.md"
gives 0 'LuaCATS' api --luacats; cp out.txt digbox.d.lua
printed '---@class digbox.body'; printed 'function world:camera(fields) end'
command -v luacheck >/dev/null && holds 'luacheck takes it' luacheck --quiet digbox.d.lua
gives 0 'JSON' api --json
if command -v python3 >/dev/null; then
    python3 - out.txt >parsed.txt <<'PY'
import json, sys
api = json.load(open(sys.argv[1]))
lamp = api["functions"]["world:lamp"]["fields"]["power"]
print(lamp["unit"], lamp["default"], lamp["above"], "position" in api["types"]["body"]["properties"], len(api["events"]))
PY
    holds 'JSON can be read' grep -q '^W 60 0 True 18$' parsed.txt
fi
gives 0 'JSON of one' api --json lamp;          printed '"world:lamp"'; lacks '"world:camera"'
gives 0 'names' api --names;                    printed 'body:push'
gives 0 'man' api --man;                        printed '.SH EXIT STATUS'
command -v man >/dev/null && holds 'man takes it' man --warnings -l out.txt

# ---- completion: what it offers is what the program takes ----
gives 0 'completion' api --completion bash; cp out.txt completion.bash
holds 'it is bash' bash -n completion.bash
complete_line() {               # what is offered for a line
    bash -c '. ./completion.bash; COMP_LINE=$1; COMP_POINT=${#1}; read -ra COMP_WORDS <<<"$1"
             case $1 in *" ") COMP_WORDS+=("");; esac; COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _digbox; printf "%s\n" "${COMPREPLY[@]}"' _ "$1"
}
holds 'a command' grep -qx 'check' <(complete_line 'digbox ch')
holds 'an option' grep -qx -- '--accuracy' <(complete_line 'digbox run --acc')
holds 'a value' grep -qx 'reference' <(complete_line 'digbox run --accuracy ref')
holds 'a name' grep -qx 'world.time' <(complete_line 'digbox api world.ti')
holds 'a name after a colon' grep -qx 'lamp' <(complete_line 'digbox api world:lam')
for command in $("$DIGBOX" --help | sed -n 's/^  digbox \([a-z]*\) .*/\1/p' | sort -u); do
    holds "completion knows $command" grep -q "^        $command) options=" completion.bash
    for option in $(sed -n "s/^        $command) options='\(.*\)' ;;/\1/p" completion.bash); do
        "$DIGBOX" "$command" "$option" </dev/null >o.txt 2>e.txt
        holds "$command takes $option" test "$(grep -c -e 'unrecognized' -e 'invalid option' e.txt)" = 0
    done
done
# The help of every command says more than its name.
for command in $("$DIGBOX" --help | sed -n 's/^  digbox \([a-z]*\) .*/\1/p' | sort -u); do
    gives 0 "help of $command" help "$command"
    holds "says more than the list of commands" test "$(wc -l <out.txt)" -ge 4
done
gives 0 'what layers hold' help render;                 printed 'depth, 16-bit grey, mm'; printed 'R + 256 G + 65536 B'
gives 2 'a misspelt option of the program' --hepl;      said "did you mean '--help'?"
gives 2 'an accuracy that is none' run x.lua --accuracy plya;          said "--accuracy: unknown accuracy 'plya' (did you mean 'play'?)"
gives 2 'an accuracy of a mass' run x.lua --accuracy 3kg;              said "--accuracy: wants a length; '3kg' is a mass"
for length in 1e5 1e-13; do
    gives 2 'an accuracy out of bounds' run x.lua --accuracy $length;  said "--accuracy: $length m is not from 1e-12 to 1 m"
done
gives 2 'a time that is none' run x.lua --seconds -1;   said '--seconds: -1 s is not from 0 to 1e+09 s'
checked
