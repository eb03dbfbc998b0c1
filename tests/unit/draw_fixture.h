/* tests/unit/draw_fixture.h - random numbers, vectors and directions that are the same in every run: xorshift64 (Marsaglia 2003). */
#ifndef DIG_DRAW_FIXTURE_H
#define DIG_DRAW_FIXTURE_H

#include "math/vec.h"

static inline uint64_t draw_bits(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

/* In [-1, 1]. */
static inline real draw(uint64_t *state) { return (real)(draw_bits(state) >> 11) / 4503599627370496.0 - 1; }

static inline vec3 draw_vec3(uint64_t *state)
{
    real x = draw(state), y = draw(state), z = draw(state);
    return (vec3){x, y, z};
}

static inline vec3 draw_unit(uint64_t *state)
{
    for (;;) {
        vec3 v = draw_vec3(state);
        real n = vec3_length(v);
        if (n > 0.1 && n < 1)
            return vec3_scale(1 / n, v);
    }
}

#endif
