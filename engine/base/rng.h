/* base/rng.h - seeded random numbers: splitmix64 (Steele, Lea, Flood 2014). State is one word, part of the world.
 *
 * Floor: base.
 */
#ifndef DIG_RNG_H
#define DIG_RNG_H

#include "base/base.h"

static inline uint64_t rng_next(uint64_t *state)
{
    uint64_t z = (*state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/* In [0, 1). */
static inline real rng_real(uint64_t *state) { return (real)(rng_next(state) >> 11) * 0x1p-53; }

#endif
