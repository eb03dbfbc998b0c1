/* trace/top.c - one body on one ball joint that hangs on what stands still, by power series.
 *
 * A top, a gyroscope, a bob on a rod: it turns about a point that stays where it is. In body axes, with the angular momentum L about that
 * point, the force F and the torque T, which are the same everywhere, and r from the point to the centre of mass,
 *
 *     L' = L x w + r x F + T,    F' = F x w,    T' = T x w,    q' = q w / 2,    w = I^-1 L,
 *
 * I the inertia about the point: products of two throughout, so that the terms of the series of each follow from those before (Moore,
 * Interval Analysis, 1966, section 11.2). As many as double precision can tell. Stops and friction of the joint, and anything near, are
 * handed on as gathered.
 */
#include "trace/trace.h"

#define ENOUGH 1e-17            /* of what they are added to: terms that follow two smaller ones are no part of the sum */
#define KEPT   1e-9             /* of the energy of motion: by more the series does not err */

static bool suits(const Group *g)
{
    if (!hang_suits(g))
        return false;
    const JointView *j = &g->joints[0].view;
    return joint_plain(j->type, j->params);
}

typedef struct Top {
    Hang hang;
    vec3 point, arm;            /* m  what both anchors are to be at; r, body axes */
    mat3 inertia, inverse;      /* kg m^2, and 1 over it  about the point, body axes */
} Top;

static void look(const Group *g, const Hang *hang, Top *t)
{
    const GroupJoint *j = &g->joints[0];
    const Member *m = &g->member[0];
    t->hang = *hang;
    t->point = hang->other->p;
    t->arm = vec3_neg(hang->is_a ? j->ra : j->rb);
    mat3 off = mat3_sub(mat3_scale(vec3_length2(t->arm), mat3_identity()), mat3_outer(t->arm, t->arm));
    t->inertia = mat3_add(*m->inertia, mat3_scale(m->mass, off));
    t->inverse = mat3_inverse(t->inertia);
}

/* What changes in the step, body axes: N m s, N, N m; to where it has turned; and rad, it turned by no more. */
typedef struct Turning { vec3 l, f, t; quat q; real way; } Turning;

static real size_of(quat a) { return real_max(real_max(fabs(a.x), fabs(a.y)), real_max(fabs(a.z), fabs(a.w))); }

/* One part of the step, of h seconds. False: the series do not end. */
static bool turn(const Top *top, real h, Turning *now)
{
    vec3 l[SERIES_TERMS], f[SERIES_TERMS], t[SERIES_TERMS], w[SERIES_TERMS];
    quat q[SERIES_TERMS];
    const bool twisted = !vec3_is_zero(now->t);
    const real small = ENOUGH * (vec3_length(now->l) + h * (vec3_length(top->arm) * vec3_length(now->f) + vec3_length(now->t)));
    l[0] = now->l;
    f[0] = now->f;
    t[0] = now->t;
    q[0] = quat_identity();
    quat turned = q[0];
    for (int k = 0; k + 1 < SERIES_TERMS; k++) {
        w[k] = mat3_mul_vec(top->inverse, l[k]);
        vec3 grow = vec3_add(vec3_cross(top->arm, f[k]), t[k]), sway = vec3_zero(), twist = vec3_zero();
        quat spin = {0, 0, 0, 0};
        for (int i = 0; i <= k; i++) {
            grow = vec3_add(grow, vec3_cross(l[i], w[k - i]));
            sway = vec3_add(sway, vec3_cross(f[i], w[k - i]));
            spin = quat_add(spin, quat_mul_pure(q[i], w[k - i]));
        }
        for (int i = 0; i <= k && twisted; i++)
            twist = vec3_add(twist, vec3_cross(t[i], w[k - i]));
        real each = h / (k + 1), half = 0.5 * each;
        l[k + 1] = vec3_scale(each, grow);
        f[k + 1] = vec3_scale(each, sway);
        t[k + 1] = vec3_scale(each, twist);
        q[k + 1] = (quat){half * spin.x, half * spin.y, half * spin.z, half * spin.w};
        now->l = vec3_add(now->l, l[k + 1]);
        now->f = vec3_add(now->f, f[k + 1]);
        now->t = vec3_add(now->t, t[k + 1]);
        turned = quat_add(turned, q[k + 1]);
        bool least = vec3_length(l[k + 1]) + vec3_length(l[k]) <= small && size_of(q[k + 1]) + size_of(q[k]) <= ENOUGH;
        if (k + 1 >= SERIES_LEAST && least) {
            now->q = quat_unit(quat_mul(now->q, turned));
            return true;
        }
    }
    return false;
}

static real norm(mat3 m) { return sqrt(vec3_length2(m.r0) + vec3_length2(m.r1) + vec3_length2(m.r2)); }

/* rad/s  No faster does it turn, nor does what it follows change. */
static real fastest(const Top *t, const Member *m, vec3 spin, real h)
{
    real push = norm(mat3_mul(t->inverse, mat3_skew(t->arm))) * vec3_length(m->force) + norm(t->inverse) * vec3_length(m->torque);
    return real_max(vec3_length(spin) + h * push, sqrt(2 * push));
}

static bool swing(const Top *top, const Member *m, real h, Turning *now)
{
    real rate = fastest(top, m, top->hang.before.w, h);
    int parts = hang_parts(rate * h);
    if (parts == 0)
        return false;
    real spin = vec3_length(top->hang.before.w), part = h / parts;
    for (int i = 0; i < parts; i++) {
        if (!turn(top, part, now))
            return false;
        real next = vec3_length(mat3_mul_vec(top->inverse, now->l));
        now->way += part * real_max(spin, next);
        spin = next;
    }
    return true;
}

static real kinetic(const Top *t, vec3 w) { return 0.5 * vec3_dot(w, mat3_mul_vec(t->inertia, w)); }

/* To where it has turned. Where places are rounded its energy stays, if it is forces alone that turn it: as the next step will find it, for
 * |q| is 1 within rounding only, and that bias would add up. */
static void move(Group *g, const Top *top, const Turning *now)
{
    const Member *m = &g->member[0];
    vec3 from = g->pos[0].x, before = quat_unrotate(g->pos[0].q, top->hang.before.w), r = quat_rotate(now->q, top->arm);
    vec3 w = quat_rotate(now->q, mat3_mul_vec(top->inverse, now->l));
    g->pos[0] = (Pos){vec3_add(top->point, r), now->q};
    real wanted = kinetic(top, before) + vec3_dot(m->force, vec3_sub(g->pos[0].x, from)), found = kinetic(top, quat_unrotate(now->q, w));
    if (vec3_is_zero(m->torque) && found > 0 && fabs(wanted - found) <= KEPT * found)
        w = vec3_mad(w, 0.5 * (wanted - found) / found, w);
    g->vel[0] = (Vel){vec3_cross(w, r), w};
}

/* N  Of the joint on the body, at the end of the step. */
static vec3 force_now(const Group *g, const Top *top)
{
    const Member *m = &g->member[0];
    quat q = g->pos[0].q;
    vec3 w = quat_unrotate(q, g->vel[0].w), l = mat3_mul_vec(top->inertia, w), r = vec3_sub(g->pos[0].x, top->point);
    vec3 turning = vec3_add(vec3_cross(l, w), quat_unrotate(q, vec3_add(vec3_cross(r, m->force), m->torque)));
    vec3 alpha = quat_rotate(q, mat3_mul_vec(top->inverse, turning));
    vec3 acc = vec3_add(vec3_cross(alpha, r), vec3_cross(g->vel[0].w, g->vel[0].v));
    return vec3_mad(vec3_neg(m->force), m->mass, acc);
}

/* N m s  About the centre of mass, world axes. */
static vec3 own_momentum(const Member *m, quat q, vec3 w) { return quat_rotate(q, mat3_mul_vec(*m->inertia, quat_unrotate(q, w))); }

static void book(Group *g, const Top *top, quat before, real h)
{
    GroupJoint *j = &g->joints[0];
    const Member *m = &g->member[0];
    Row rows[JOINT_SLOTS];
    vec3 force = force_now(g, top);
    for (int i = 0, count = hang_rows(g, rows); i < count; i++)
        j->force[rows[i].slot] = (top->hang.is_a ? 1 : -1) * vec3_dot(rows[i].lin[0], force);
    vec3 turned = vec3_sub(own_momentum(m, g->pos[0].q, g->vel[0].w), own_momentum(m, before, top->hang.before.w));
    hang_book_impulses(g, &top->hang, hang_impulse(g, &top->hang, h), vec3_mad(turned, -h, m->torque), vec3_zero());
}

static bool follow(Group *g, real h)
{
    const Member *m = &g->member[0];
    Hang hang;
    Top top;
    if (!hang_look(g, &hang) || !hang_holds(&hang))
        return false;
    look(g, &hang, &top);
    quat q = g->pos[0].q;
    Turning now = {mat3_mul_vec(top.inertia, quat_unrotate(q, hang.before.w)), quat_unrotate(q, m->force), quat_unrotate(q, m->torque), q, 0};
    if (!swing(&top, m, h, &now) || !hang_apart(g, h, now.way * (vec3_length(top.arm) + m->outer)))
        return false;
    move(g, &top, &now);
    book(g, &top, q, h);
    return true;
}

static dig_status advance(Group *g, real dt) { return hang_advance(g, dt, follow); }

const Way way_top = {.name = "top", .tally = WAY_TRACED, .suits = suits, .advance = advance};
