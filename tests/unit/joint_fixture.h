/* tests/unit/joint_fixture.h - two moving bodies with a joint between them, for tests of rows.
 *
 * Differences are of fourth order: d(f)/dt = (8 (f(t) - f(-t)) - (f(2t) - f(-2t))) / 12 t, off by about t^4.
 */
#ifndef DIG_JOINT_FIXTURE_H
#define DIG_JOINT_FIXTURE_H

#include "base/param.h"
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

/* ---- joints of the types in the list ---- */

/* A joint under test: a rig, parameters and memory. */
typedef struct Joint {
    Rig  rig;
    const JointType *type;
    real params[48];
    real memory[JOINT_MEMORY];
    const JointView *other[2];
} Joint;

static inline const JointType *type_of(const char *name)
{
    for (int i = 0; joint_types[i]; i++)
        if (strcmp(joint_types[i]->name, name) == 0)
            return joint_types[i];
    fail_msg("no joint type '%s'", name);
    return NULL;
}

static inline void *field(Joint *t, const char *path)
{
    size_t offset;
    if (!param_find_path(t->type->params, path, &offset))
        fail_msg("%s has no parameter '%s'", t->type->name, path);
    return (char *)t->params + offset;
}

static inline void set(Joint *t, const char *path, real x) { memcpy(field(t, path), &x, sizeof x); }

static inline void set_range(Joint *t, const char *path, real lo, real hi)
{
    real r[2] = {lo, hi};
    memcpy(field(t, path), r, sizeof r);
}

static inline bool has(const JointType *type, const char *name) { return param_find(type->params, name) != NULL; }

static inline JointView view_of(Joint *t, const Rig *g)
{
    return (JointView){.params = t->params, .a = rig_end(g, 0), .b = rig_end(g, 1), .memory = t->memory,
                       .other = {t->other[0], t->other[1]}, .type = t->type};
}

static inline dig_status check(Joint *t, char *why, size_t capacity)
{
    JointView now = view_of(t, &t->rig);
    return t->type->check ? t->type->check(t->params, &now, why, capacity) : DIG_OK;
}

static inline int rows_of(Joint *t, const Rig *g, Row rows[JOINT_SLOTS])
{
    RowList list = {rows, 0, JOINT_SLOTS};
    JointView j = view_of(t, g);
    t->type->rows(&j, &list);
    return list.count;
}

static inline real coordinate_at(Joint *t, const Rig *g)
{
    JointView j = view_of(t, g);
    return t->type->coordinate(&j);
}

static inline real speed_of(Joint *t)
{
    JointView j = view_of(t, &t->rig);
    return t->type->speed(&j);
}

static inline const Row *row_of(const Row *rows, int count, RowKind kind)
{
    for (int i = 0; i < count; i++)
        if (rows[i].kind == kind)
            return &rows[i];
    return NULL;
}

/* Types with two anchors get their ends half a metre apart, as a bare joint of that kind would be used. */
static inline Joint joint_make(const char *name, Dice *d, bool bound)
{
    Joint t = {.type = type_of(name), .rig = rig_make(d, bound)};
    param_defaults(t.type->params, t.params);
    if (t.type->two_anchors) {
        vec3 at[2] = {dice_vec(d), dice_vec(d)};
        at[1] = vec3_mad(at[0], 0.5, vec3_unit(vec3_sub(at[1], at[0])));
        rig_join(&t.rig, at, dice_quat(d));
    }
    if (has(t.type, "stiffness"))
        set(&t, "stiffness", 30);
    if (has(t.type, "modulus")) {
        set(&t, "length", 0.5);
        set(&t, "width", 0.2);
        set(&t, "height", 0.1);
        set(&t, "modulus", 3e4);
    }
    if (strcmp(name, "motor") == 0)
        set(&t, "speed", 2);
    char why[200] = "";
    if (!t.type->couples && check(&t, why, sizeof why) != DIG_OK)
        fail_msg("%s: %s", name, why);
    return t;
}

/* A body at the origin and the world, the joint at the origin with axis z. */
static inline Joint simple(const char *name)
{
    Joint t = {.type = type_of(name)};
    Rig *g = &t.rig;
    *g = (Rig){.body = {0, -1}, .q = {quat_identity(), quat_identity()}};
    vec3 at[2] = {vec3_zero(), vec3_zero()};
    rig_join(g, at, quat_between((vec3){1, 0, 0}, (vec3){0, 0, 1}));
    param_defaults(t.type->params, t.params);
    return t;
}

/* Its limits, springs, motors and friction are switched on. */
static inline void switch_on(Joint *t)
{
    const JointType *type = t->type;
    if (has(type, "limits"))
        set_range(t, "limits", -0.4, 0.3);
    if (has(type, "twist"))
        set_range(t, "twist", -0.4, 0.3);
    if (has(type, "swing"))
        set(t, "swing", 0.5);
    if (has(type, "friction"))
        set(t, "friction", 3);
    if (has(type, "spring"))
        set(t, "spring.stiffness", 40);
    if (has(type, "motor"))
        set(t, "motor.speed", 2);
}

static inline void check_refused(Joint *t, const char *want)
{
    char why[200] = "";
    CHECK_INT(check(t, why, sizeof why), DIG_E_ARG);
    if (!strstr(why, want))
        fail_msg("%s: \"%s\" lacks \"%s\"", t->type->name, why, want);
}

#endif
