#!/usr/bin/env bash
# tests/cli/install.sh - what `make install` leaves is enough: a C program of one header and one library simulates.
set -u
[ "${SANITIZE:-0}" = 1 ] && { echo "judged on the plain build"; exit 77; }
place=$TMPDIR/place
env -u MAKEFLAGS -u MAKELEVEL -u MFLAGS make -s -j1 install BUILD="$BUILD" CC="${CC:-gcc}" DESTDIR="$place" PREFIX=/usr || exit 1

cat >"$TMPDIR/fall.c" <<'END'
#include <digbox.h>
#include <math.h>
#include <stdio.h>

/* A ball falls freely for ten frames: y = -g t^2 / 2. */
int main(void)
{
    char why[200] = "";
    dig_world_def settings = dig_world_defaults();
    dig_world *w = NULL;
    if (dig_world_open(&settings, &w, why, sizeof why) != DIG_OK)
        return printf("%s\n", why), 1;

    dig_sphere_def sphere = {.radius = 0.1};
    dig_shape_def shape = {.type = "sphere", .data = &sphere, .colour = {-1, -1, -1}};
    dig_body_def def = dig_body_defaults();
    def.shapes = &shape;
    def.shape_count = 1;
    dig_body ball;
    if (dig_body_create(w, &def, &ball) != DIG_OK)
        return printf("%s\n", dig_error(w)), 1;
    for (int i = 0; i < 10; i++)
        if (dig_world_step(w) != DIG_OK)
            return printf("%s\n", dig_error(w)), 1;

    dig_body_state state;
    if (dig_body_get(w, ball, &state) != DIG_OK)
        return printf("%s\n", dig_error(w)), 1;
    double t = 10.0 / 60, want = -9.81 * t * t / 2;
    dig_world_close(w);
    printf("y = %.6f m, want %.6f +- 0.005\n", state.position.y, want);
    return !(fabs(state.position.y - want) < 0.005);
}
END
"${CC:-gcc}" -std=c17 -Wall -Wextra -Werror -I"$place/usr/include" "$TMPDIR/fall.c" -o "$TMPDIR/fall" \
    -L"$place/usr/lib" -ldigbox -lqhull_r -lm -pthread && "$TMPDIR/fall" || exit 1

"$place/usr/bin/digbox" --version | grep -qE '[0-9]+\.[0-9]+\.[0-9]+' || { echo "no version"; exit 1; }
[ -z "$(find "$place" -type f -not -path "$place/usr/*")" ]
