/* view/past.h - what was before a moment: for trails of bodies and the strip with the energies.
 *
 * A film of a running world and one drawn from its replay feed it the same steps, and get the same pictures: nothing in it depends on
 * what comes later. Where bodies are is taken as the script left them before a step, energies as the step led to them.
 *
 * A trail has a point at each multiple of `stride` steps within the last second, and where the body is now. Of energies at most
 * PAST_ROWS are kept, at even distances of a power of two steps, and those of the last step.
 *
 * Owns:      its points and rows; past_close releases them.
 * Invariant: steps come in their order; an earlier one than the last (a world that was restored) forgets all.
 * Floor:     view. Includes base, math and world.
 */
#ifndef DIG_PAST_H
#define DIG_PAST_H

#include "base/list.h"
#include "view/view.h"

enum { PAST_POINTS = 31, PAST_ROWS = 512, PAST_ENERGIES = 4 };      /* kinetic, potential, elastic, lost */

typedef struct PastPoint { vec3 x; uint32_t gen, spare; } PastPoint;       /* m, centre of mass; gen 0: not there */

typedef struct PastMoment { uint64_t step; LIST(PastPoint) points; } PastMoment;       /* points by slot of the body */

typedef struct PastRow { uint64_t step; real energy[PAST_ENERGIES]; } PastRow;         /* J */

typedef struct Past {
    uint64_t   first;           /* step with which it begins                        */
    real       step;            /* s                                                */
    uint64_t   stride;          /* steps between two points of a trail              */
    PastMoment moments[PAST_POINTS - 1];    /* a ring; a step that is a multiple of the stride has its place */
    PastMoment now;             /* where all is now                                 */
    bool       begun;
    uint64_t   row_stride;      /* steps between two rows                           */
    PastRow    rows[PAST_ROWS + 1];         /* the last may lie between             */
    int        row_count;
    LIST(real) flat;            /* as pictures want them                            */
    real       table[PAST_ROWS + 1][1 + PAST_ENERGIES];
} Past;

/* What a picture shows of it; belongs to the Past, until it changes. */
typedef struct ViewPast {
    const real *trails;         /* [trail_count][trail_length][3] m, world; oldest first; NAN = not there */
    int         trail_count, trail_length;
    real        head;           /* how far apart in time the last two points of a trail are; all others are 1 */
    const real *energies;       /* [energy_count][1 + PAST_ENERGIES] s since `begin`, J */
    int         energy_count;
    real        begin;          /* s */
} ViewPast;

/* Begins with that step of a world whose frames take so long (s). */
void       past_open(Past *p, uint64_t first, real step);
void       past_close(Past *p);
/* Where bodies are, before the step that follows `step`: first this, then each dynamic body. DIG_E_MEMORY leaves some out. */
void       past_begin(Past *p, uint64_t step);
dig_status past_point(Past *p, uint32_t slot, uint32_t gen, vec3 x);
/* All of a world's bodies. */
dig_status past_take(Past *p, const dig_world *w);
/* After the step that led to `step`. */
void       past_energy(Past *p, uint64_t step, const dig_energy *e);
/* Is a trail's point or a row of energies due at that step, if the last that is asked for is `last`? */
bool       past_wants_points(const Past *p, uint64_t step, uint64_t last);
dig_status past_show(Past *p, ViewPast *out);

#endif
