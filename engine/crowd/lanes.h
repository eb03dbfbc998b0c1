/* crowd/lanes.h - so many lanes of a batch as are computed at once, as one number.
 *
 * wide.c is compiled for eight, and by wide16.c for sixteen, which fill a register of AVX-512: all of a batch. Every lane computes with the
 * same rounded operations in the same order: the bits are the same.
 *
 * Floor: crowd. Includes base, math, geom, world, solve.
 */
#ifndef DIG_CROWD_LANES_H
#define DIG_CROWD_LANES_H

#include "crowd/system.h"
#include "math/pair.h"

/* A Six, in a register. */
typedef float six __attribute__((vector_size(SIX * sizeof(float))));

INLINE wide pick(wide_int which, wide yes, wide no) { return (wide)((which & (wide_int)yes) | (~which & (wide_int)no)); }
INLINE wide most(wide a, wide b) { return pick(a > b, a, b); }
INLINE wide least(wide a, wide b) { return pick(a < b, a, b); }

INLINE wide root(wide x)
{
    UNROLL
    for (int i = 0; i < HALF; i++)
        for (int k = i; k < AT_ONCE; k += HALF)
            x[k] = __builtin_sqrtf(x[k]);
    return x;
}

#define SHUFFLE __builtin_shufflevector

/* SHUFFLES of two wide numbers does with each eight what SHUFFLE does with those of two numbers of eight: places from 8 on are in the second. */
#if AT_ONCE == 16
INLINE wide all(float x) { return (wide){x, x, x, x, x, x, x, x, x, x, x, x, x, x, x, x}; }
#define AMONG(p) ((p) < HALF ? (p) : (p) + HALF)
#define SHUFFLES(a, b, p0, p1, p2, p3, p4, p5, p6, p7) \
    SHUFFLE(a, b, AMONG(p0), AMONG(p1), AMONG(p2), AMONG(p3), AMONG(p4), AMONG(p5), AMONG(p6), AMONG(p7), AMONG(p0) + HALF, \
            AMONG(p1) + HALF, AMONG(p2) + HALF, AMONG(p3) + HALF, AMONG(p4) + HALF, AMONG(p5) + HALF, AMONG(p6) + HALF, AMONG(p7) + HALF)
#else
INLINE wide all(float x) { return (wide){x, x, x, x, x, x, x, x}; }
#define SHUFFLES SHUFFLE
#endif

/* Eight rows of eight become eight columns. */
INLINE void transpose(wide r[8])
{
    wide s[8];
    UNROLL
    for (int i = 0; i < 8; i += 2) {
        s[i] = SHUFFLES(r[i], r[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
        s[i + 1] = SHUFFLES(r[i], r[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
    }
    UNROLL
    for (int i = 0; i < 8; i += 4) {
        r[i] = SHUFFLES(s[i], s[i + 2], 0, 1, 8, 9, 4, 5, 12, 13);
        r[i + 1] = SHUFFLES(s[i], s[i + 2], 2, 3, 10, 11, 6, 7, 14, 15);
        r[i + 2] = SHUFFLES(s[i + 1], s[i + 3], 0, 1, 8, 9, 4, 5, 12, 13);
        r[i + 3] = SHUFFLES(s[i + 1], s[i + 3], 2, 3, 10, 11, 6, 7, 14, 15);
    }
    UNROLL
    for (int i = 0; i < 4; i++) {
        wide low = SHUFFLES(r[i], r[i + 4], 0, 1, 2, 3, 8, 9, 10, 11), high = SHUFFLES(r[i], r[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
        s[i] = low;
        s[i + 4] = high;
    }
    UNROLL
    for (int i = 0; i < 8; i++)
        r[i] = s[i];
}

/* The bodies of the lanes, as eight wide numbers, and back. */
INLINE void gather(const Six *from, const int32_t at[AT_ONCE], wide to[8])
{
    UNROLL
    for (int i = 0; i < HALF; i++)
#if AT_ONCE == 16
        to[i] = SHUFFLE(*(const six *)(const void *)&from[at[i]], *(const six *)(const void *)&from[at[HALF + i]], 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10,
                        11, 12, 13, 14, 15);
#else
        to[i] = *(const six *)(const void *)&from[at[i]];
#endif
    transpose(to);
}

INLINE void scatter(Six *to, const int32_t at[AT_ONCE], wide from[8])
{
    transpose(from);
    UNROLL
    for (int i = 0; i < HALF; i++) {
#if AT_ONCE == 16
        *(six *)(void *)&to[at[i]] = SHUFFLE(from[i], from[i], 0, 1, 2, 3, 4, 5, 6, 7);
        *(six *)(void *)&to[at[HALF + i]] = SHUFFLE(from[i], from[i], 8, 9, 10, 11, 12, 13, 14, 15);
#else
        *(six *)(void *)&to[at[i]] = from[i];
#endif
    }
}

/* A vector of numbers that lie in a batch. */
#define THREE(v) {(v)[0].own, (v)[1].own, (v)[2].own}

INLINE wide dot(const wide a[3], const wide b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
/* Of one that lies in a batch. */
INLINE wide dot_of(const Wide a[3], const wide b[3]) { return a[0].own * b[0] + a[1].own * b[1] + a[2].own * b[2]; }

INLINE void cross(const wide a[3], const wide b[3], wide out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

INLINE void put(const wide v[3], Wide to[3])
{
    UNROLL
    for (int i = 0; i < 3; i++)
        to[i].own = v[i];
}

/* ---- the lanes of a batch that are computed at once ---- */

typedef struct Lot {
    int32_t *a, *b;             /* [AT_ONCE] */
    int   points;
    bool  round;
    WideContact *of;
    wide  n[3], ra, rb;         /*      of that */
    WidePoint *point;
    WideArms  *arms;
    Wide      *drive;
    WidePatch *patch;
    WideRub   *rub;
    WideTwist *twist;
    WideRoll  *roll;
} Lot;

/* How many lots a batch is. */
INLINE int lots(const Batch *b) { return AT_ONCE == LANES ? 1 : b->halves; }

/* What begins with a wide number, from that lane on. */
#define FROM(p, lane) ((void *)((float *)(void *)(p) + (lane)))

INLINE Lot lot_of(Batch *b, int i)
{
    const int lane = i * AT_ONCE;
    WideContact *of = FROM(b->of, lane);
    Lot x = {.a = b->a + lane, .b = b->b + lane, .points = b->points, .round = b->round, .of = of, .n = THREE(of->n),
             .ra = of->ra.own, .rb = of->rb.own, .point = FROM(b->point, lane)};
    x.arms = b->arms ? FROM(b->arms, lane) : NULL;
    x.drive = b->drive ? FROM(b->drive, lane) : NULL;
    x.patch = b->patch ? FROM(b->patch, lane) : NULL;
    x.rub = b->rub ? FROM(b->rub, lane) : NULL;
    x.twist = b->twist ? FROM(b->twist, lane) : NULL;
    x.roll = b->roll ? FROM(b->roll, lane) : NULL;
    return x;
}

#endif
