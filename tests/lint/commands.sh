#!/usr/bin/env bash
# tests/lint/commands.sh - every public call that may change a world is logged as a command (engine/api/command.h), so that a
# replay leads to the same states; or it stands here, with the reason why not.
set -u
excepted='
dig_world_close          it is gone
dig_world_check          looks only
dig_world_save           looks only
dig_world_pack           looks only
dig_world_note           is no part of the state
dig_time_every_step      the clock is no part of the state
dig_tell_moves           who listens is no part of the state
dig_message_send         through dig_message_post
dig_message_broadcast    through dig_message_post
dig_ask                  asks a copy
dig_overlap              looks only
dig_sweep                looks only
dig_world_tap            listens
dig_command_play         plays what it is given
'
calls=$(sed -nE 's/^[a-z_]+ +(dig_[a-z_]+)\(dig_world \*w\b.*/\1/p' engine/digbox.h)
bad=0
for call in $calls; do
    if grep -qE "^$call +[a-z]" <<<"$excepted"; then continue; fi
    # its body, wherever in api/ it stands
    awk -v call="$call" '
        /^[a-z_]+ +\**dig_/ { inside = $0 ~ ("[ *]" call "\\(") && !/;[ \t]*$/ }
        inside && /COMMAND\(|command_do\(/ { found = 1 }
        /^}/ { inside = 0 }
        END { exit !found }' engine/api/*.c && continue
    echo "engine/digbox.h: $call is no command: a replay would not know of it (or say in tests/lint/commands.sh why it need not)"
    bad=1
done
for name in $(awk 'NF { print $1 }' <<<"$excepted"); do
    grep -qE "\b$name\(" engine/digbox.h || { [ -n "$calls" ] && echo "tests/lint/commands.sh: $name is no call any more" && bad=1; }
done
exit $bad
