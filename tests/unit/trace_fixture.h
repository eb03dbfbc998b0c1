/* tests/unit/trace_fixture.h - a group built by hand, for tests of the traced way's parts: bodies, a joint to the world, points that
 * touch. Gravity and pushes are its only forces.
 */
#ifndef DIG_TRACE_FIXTURE_H
#define DIG_TRACE_FIXTURE_H

#include "base/param.h"
#include "base/rng.h"
#include "check.h"
#include "geom/mass.h"
#include "solve/plan.h"
#include "trace/trace.h"

enum { HAND_BODIES = 8, HAND_POINTS = 8, HAND_PUSHES = 2 };

typedef struct Hand {
    Group  g;
    Tracer t;
    Arena  arena;
    Pos    pos[HAND_BODIES];
    Vel    vel[HAND_BODIES], shift[HAND_BODIES], start_vel[HAND_BODIES];
    Been   been[HAND_BODIES];
    Mass   mass[HAND_BODIES];
    Member member[HAND_BODIES];
    mat3   inertia[HAND_BODIES], inv_inertia[HAND_BODIES];
    GroupPair pairs[1];
    GroupContact contacts[2];
    ContactRest contact_rest[2];
    Acted  acted[2];
    Impact impacts[1];
    GroupJoint joints[1];
    GroupPush pushes[HAND_PUSHES];
    real   params[48];
} Hand;

/* ---- random numbers ---- */

typedef struct Dice { uint64_t state; } Dice;

/* In [-1, 1). */
static inline real dice(Dice *d) { return 2 * rng_real(&d->state) - 1; }
static inline real dice_in(Dice *d, real lo, real hi) { return lo + (hi - lo) * rng_real(&d->state); }

static inline vec3 dice_vec(Dice *d)
{
    real x = dice(d), y = dice(d);
    return (vec3){x, y, dice(d)};
}

static inline vec3 dice_unit(Dice *d)
{
    vec3 v = dice_vec(d);
    while (vec3_length(v) < 0.1 || vec3_length(v) > 1)
        v = dice_vec(d);
    return vec3_unit(v);
}

static inline quat dice_quat(Dice *d) { return quat_exp(vec3_scale(3, dice_vec(d))); }

/* ---- differences of fourth order, off by about TICK^4 ---- */

#define TICK 1e-4               /* s */
static const real ticks[4] = {-2 * TICK, -TICK, TICK, 2 * TICK};
static inline real difference(const real f[4]) { return (8 * (f[2] - f[1]) - (f[3] - f[0])) / (12 * TICK); }

/* ---- the group ---- */

static inline dig_status hand_stage(Group *g, int stage)
{
    for (int i = 0; stage == STAGE_FORCE && i < g->moving_count; i++)
        g->member[i].force = vec3_scale(g->member[i].mass, g->gravity);
    for (int i = 0; stage == STAGE_FORCE && i < g->push_count; i++) {
        const GroupPush *p = &g->pushes[i];
        Member *m = &g->member[p->body];
        m->force = vec3_add(m->force, p->force);
        m->torque = vec3_add(m->torque, vec3_add(p->torque, vec3_cross(quat_rotate(g->pos[p->body].q, p->at), p->force)));
    }
    return DIG_OK;
}

/* bodies of which the first `moving` move; all at the origin, of mass 1 kg and inertia 1 kg m^2 */
static inline void hand_open(Hand *h, int moving, int bodies)
{
    memset(h, 0, sizeof *h);
    Group *g = &h->g;
    g->plan = accuracy_plan(accuracy_find("study"));
    g->tolerance = 1e-9;
    g->arena = &h->arena;
    g->stage = hand_stage;
    g->culprit = -1;
    g->pos = h->pos;
    g->vel = h->vel;
    g->shift = h->shift;
    g->mass = h->mass;
    g->member = h->member;
    g->start_vel = h->start_vel;
    g->been = h->been;
    g->pairs = h->pairs;
    g->contacts = h->contacts;
    g->contact_rest = h->contact_rest;
    g->acted = h->acted;
    g->impacts = h->impacts;
    g->joints = h->joints;
    g->pushes = h->pushes;
    g->moving_count = moving;
    g->body_count = bodies;
    for (int i = 0; i < bodies; i++) {
        h->pos[i].q = quat_identity();
        h->inertia[i] = h->inv_inertia[i] = mat3_identity();
        h->member[i] = (Member){.slot = (uint32_t)i, .moves = i < moving, .mass = 1, .im = i < moving ? 1 : 0, .gravity_scale = 1, .outer = 1,
                                .inertia = &h->inertia[i], .inv_inertia = &h->inv_inertia[i]};
        h->mass[i].im = i < moving ? 1 : 0;
        group_refresh_mass(g, i);
    }
}

static inline void hand_mass(Hand *h, int body, real mass, vec3 inertia)
{
    Member *m = &h->member[body];
    m->mass = mass;
    h->inertia[body] = mat3_diagonal(inertia);
    h->inv_inertia[body] = mat3_diagonal((vec3){1 / inertia.x, 1 / inertia.y, 1 / inertia.z});
    h->mass[body].im = m->im = 1 / mass;
    group_refresh_mass(&h->g, body);
}

/* After bodies, contacts and joints are there. */
static inline void hand_trace(Hand *h)
{
    Tracer *t = &h->t;
    *t = (Tracer){.g = &h->g, .end = 1, .size = 1, .pace = 1, .tolerance = 1e-9, .gap_zero = 1e-10, .gap_deep = 1e-6, .speed_zero = 1e-9, .slip_zero = 1e-7};
    CHECK_INT(trace_reserve(t), DIG_OK);
    for (int i = 0; i < h->g.body_count; i++)
        t->mover_start[i] = h->pos[i];
    trace_store(t, t->y);
}

static inline void hand_close(Hand *h) { arena_close(&h->arena); }

/* The pose after t seconds of constant velocities. */
static inline Pos pos_after(Pos p, Vel v, real t)
{
    return (Pos){vec3_mad(p.x, t, v.v), quat_mul(quat_exp(vec3_scale(t, v.w)), p.q)};
}

/* rad  between two orientations */
static inline real angle_between(quat a, quat b)
{
    quat d = quat_mul(a, quat_conjugate(b));
    return 2 * atan2(sqrt(d.x * d.x + d.y * d.y + d.z * d.z), fabs(d.w));
}

#endif
