/* tests/unit/joint_fixture.h - two moving bodies with a joint between them, for tests of rows.
 *
 * Differences are of fourth order: d(f)/dt = (8 (f(t) - f(-t)) - (f(2t) - f(-2t))) / 12 t, off by about t^4.
 */
#ifndef DIG_JOINT_FIXTURE_H
#define DIG_JOINT_FIXTURE_H

#include "check.h"
#include "solve/joint_type.h"

#define TICK 1e-4           /* s, of differences */

typedef struct Rig {
    int  body[2];           /* < 0 = the world: does not move */
    vec3 x[2], v[2], w[2];
    quat q[2];
    vec3 anchor[2];         /* m, body axes   */
    quat frame[2];          /* in body axes   */
} Rig;

typedef struct Dice { uint64_t state; } Dice;

/* In [-1, 1]; the generator of Knuth's MMIX. */
static inline real dice(Dice *d)
{
    d->state = d->state * 6364136223846793005u + 1442695040888963407u;
    return (real)(d->state >> 11) / 4503599627370496.0 - 1;
}

static inline vec3 dice_vec(Dice *d)
{
    real x = dice(d), y = dice(d);
    return (vec3){x, y, dice(d)};
}

static inline quat dice_quat(Dice *d) { return quat_exp(vec3_scale(1.7, dice_vec(d))); }

/* The anchors meet at `at`, the frames coincide with `frame`. */
static inline void rig_join(Rig *g, const vec3 at[2], quat frame)
{
    for (int i = 0; i < 2; i++) {
        g->anchor[i] = quat_unrotate(g->q[i], vec3_sub(at[i], g->x[i]));
        g->frame[i] = quat_mul(quat_conjugate(g->q[i]), frame);
    }
}

static inline void rig_stop(Rig *g, int i)
{
    g->body[i] = -1;
    g->x[i] = g->v[i] = g->w[i] = vec3_zero();
    g->q[i] = quat_identity();
}

/* Two bodies somewhere, joined; the second is the world when `bound`. */
static inline Rig rig_make(Dice *d, bool bound)
{
    Rig g;
    for (int i = 0; i < 2; i++) {
        g.body[i] = i;
        g.x[i] = dice_vec(d);
        g.q[i] = dice_quat(d);
        g.v[i] = vec3_scale(2, dice_vec(d));
        g.w[i] = vec3_scale(2, dice_vec(d));
    }
    if (bound)
        rig_stop(&g, 1);
    vec3 at = dice_vec(d), both[2] = {at, at};
    rig_join(&g, both, dice_quat(d));
    return g;
}

/* The rig after t seconds of its velocities. */
static inline Rig rig_after(const Rig *g, real t)
{
    Rig r = *g;
    for (int i = 0; i < 2; i++) {
        r.x[i] = vec3_mad(g->x[i], t, g->v[i]);
        r.q[i] = quat_mul(quat_exp(vec3_scale(t, g->w[i])), g->q[i]);
    }
    return r;
}

static inline JointEnd rig_end(const Rig *g, int i)
{
    quat f = quat_mul(g->q[i], g->frame[i]);
    vec3 r = quat_rotate(g->q[i], g->anchor[i]);
    return (JointEnd){.body = g->body[i], .x = g->x[i], .v = g->v[i], .w = g->w[i], .r = r, .p = vec3_add(g->x[i], r),
                      .axis = quat_rotate(f, (vec3){1, 0, 0}), .u = quat_rotate(f, (vec3){0, 1, 0}),
                      .n = quat_rotate(f, (vec3){0, 0, 1})};
}

/* Moves one end against the other, so that nothing vanishes by accident. */
static inline void rig_disturb(Rig *g, Dice *d, real by)
{
    g->x[0] = vec3_mad(g->x[0], by, dice_vec(d));
    g->q[0] = quat_mul(quat_exp(vec3_scale(by, dice_vec(d))), g->q[0]);
}

static inline real difference(const real f[4], real t) { return (8 * (f[2] - f[1]) - (f[3] - f[0])) / (12 * t); }

static const real ticks[4] = {-2 * TICK, -TICK, TICK, 2 * TICK};

#endif
