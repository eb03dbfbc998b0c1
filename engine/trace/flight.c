/* trace/flight.c - free flight: a body that nothing holds and nothing meets in this step.
 *
 * Where there is something near, that is seen from how far the two can get, and of balls from how far they do; else it is handed on.
 * The centre of mass follows its parabola exactly. The angular momentum L does not change, and the orientation obeys
 * q' = q w / 2 with w = I^-1 R^T L in body axes: a power series, with as many terms as the group's tolerance needs, or what it
 * sums up to where that would be many parts (tumble.c). A round body turns evenly; one that is round about an axis does so about L, and
 * about its axis besides.
 */
#include "trace/trace.h"

#define FEW   4                 /* bodies, or pairs: of more, some meet */
#define CLEAR 1e-4              /* of the size: what stays so far apart does not touch */

/* Are all pairs of things that did not touch, nor were struck? */
static bool apart(const Group *g)
{
    return !g->crowd && g->may_trace && g->moving_count <= FEW && trace_untouched(g, FEW);
}

#define CLOSED 1e-12            /* of the size: what touches by no more overlap has nothing to heal */

/* Does nothing move, whether it touches or not? Where no force acts either, nothing will. */
static bool lies_still(const Group *g)
{
    if (g->fall > 0 || g->crowd || !g->may_trace || g->moving_count > FEW || g->pair_count > FEW)
        return false;
    for (int i = 0; i < g->body_count; i++)
        if (!vec3_is_zero(g->vel[i].v) || !vec3_is_zero(g->vel[i].w))
            return false;
    for (int i = 0; i < g->pair_count; i++)
        if (g->pairs[i].fresh)
            return false;
    for (int i = 0; i < g->contact_count; i++)
        for (int k = 0; k < g->contacts[i].manifold.count; k++)
            if (g->contacts[i].manifold.points[k].gap < -CLOSED * g->pairs[g->contacts[i].pair].size)
                return false;
    return true;
}

static bool unforced(const Group *g)
{
    for (int i = 0; i < g->moving_count; i++)
        if (!vec3_is_zero(g->member[i].force) || !vec3_is_zero(g->member[i].torque))
            return false;
    return true;
}

static bool suits(const Group *g)
{
    if (g->joint_count > 0 || g->push_count > 0 || g->world->region_count > 0 || g->varies || g->decay_friction)
        return false;
    for (int i = 0; i < g->moving_count; i++)
        if (!g->member[i].moves || g->member[i].integrator != DIG_AUTO)
            return false;
    return g->pair_count == 0 || apart(g) || lies_still(g);
}

/* m/s^2 */
static vec3 fall_of(const Group *g, int body) { return vec3_scale(g->mass[body].im, g->member[body].force); }

static bool is_ball(const Group *g, int body, const Shape *s)
{
    return g->member[body].moves && s->outer == s->round && s->outer == g->member[body].outer;
}

/* A plane between the two, across the line on which they are nearest, parts them as long as they move along it by less than they have. */
static bool stays_clear(const Group *g, const GroupPair *q, real h)
{
    const GroupManifold *m = &g->contacts[q->contact].manifold;
    const Vel *va = &g->vel[q->a], *vb = &g->vel[q->b];
    bool ball_a = is_ball(g, q->a, &q->on_a->shape), ball_b = is_ball(g, q->b, &q->on_b->shape);
    if (m->count != 1 || !(ball_a || ball_b) || !(ball_a || !g->member[q->a].moves) || !(ball_b || !g->member[q->b].moves))
        return false;
    if ((!ball_a && g->member[q->a].kinematic && g->member[q->a].moved) || (!ball_b && g->member[q->b].kinematic && g->member[q->b].moved))
        return false;
    vec3 a = vec3_sub(ball_b ? fall_of(g, q->b) : vec3_zero(), ball_a ? fall_of(g, q->a) : vec3_zero());
    real gap = m->points[0].gap, rate = vec3_dot(m->normal, vec3_sub(vb->v, va->v)), acc = vec3_dot(m->normal, a);
    real turn = acc > 0 ? real_clamp(-rate / acc, 0, h) : 0, least = CLEAR * q->size;
    return gap > least && gap + h * (rate + 0.5 * h * acc) > least && gap + turn * (rate + 0.5 * turn * acc) > least;
}

/* Does nothing meet? What was found near is then left behind: the next step looks anew. */
static bool keeps_apart(Group *g, real h)
{
    bool apart = true;
    for (int i = 0; i < g->pair_count; i++) {
        group_touch_pair(g, &g->pairs[i], h);
        apart = apart && !g->pairs[i].hidden && (!g->contacts[g->pairs[i].contact].live || stays_clear(g, &g->pairs[i], h));
    }
    g->looked = true;
    if (apart)
        trace_leave_pairs(g);
    return apart;
}

#define ORDERS 24               /* most terms of the series */
#define LEAST  4
#define PART   0.5              /* rad: so far a part may turn at most, whichever axis it turns about */
#define MOST_PARTS 1000
#define ENOUGH 1e-2             /* of the tolerance: a term bounded by this is the last. Those that follow are smaller by its size and more. */

static inline quat scale(real s, quat a) { return (quat){s * a.x, s * a.y, s * a.z, s * a.w}; }

/* The turn of a part of length h, as a power series in the time of the part. In body axes L' = L x w and w = I^-1 L: the terms of L give
 * those of u = h w / 2, and these the next ones of p' = p u and of L' = 2 L x u. */
static quat turn(const Member *m, quat q, vec3 momentum, real h, int terms)
{
    vec3 l[ORDERS], u[ORDERS];
    quat p[ORDERS], sum = quat_identity();
    l[0] = quat_unrotate(q, momentum);
    for (int k = 0;; k++) {
        real next = 1.0 / (k + 1);
        u[k] = vec3_scale(0.5 * h, mat3_mul_vec(*m->inv_inertia, l[k]));
        quat term = {u[k].x, u[k].y, u[k].z, 0};                    /* the first of p is 1 */
        for (int i = 0; i < k; i++)
            term = quat_add(term, quat_mul_pure(p[i], u[k - 1 - i]));
        p[k] = scale(next, term);
        sum = quat_add(sum, p[k]);
        if (k + 1 == terms)
            break;
        vec3 grow = vec3_zero();
        for (int i = 0; i <= k; i++)
            grow = vec3_add(grow, vec3_cross(l[i], u[k - i]));
        l[k + 1] = vec3_scale(2 * next, grow);
    }
    return quat_unit(quat_mul(q, sum));
}

/* What a turn keeps bounds how fast it can become. */
typedef struct Bounds {
    real spin;                  /* rad/s  of the body, about any axis                 */
    real sway;                  /* rad/s  of w in body axes: at the rate of its elliptic functions */
    real safe;                  /* rad/s  of the spin, by which parts are cut         */
} Bounds;

/* w . L is kept, too: no axis lets a body turn faster than it would with all of it about one that has the sum of all three. And |L| is:
 * 1 / I between its least a and its most b has (1 / I - a) (1 / I - b) <= 0, so that w.w <= (a + b) w.L - a b L.L. A slender body that
 * tumbles cannot spin about its length. Series of as few terms as with the first bound go with half a radian of the second's times the root
 * of three. Of inertia off its principal axes only the first is known, and that w sways no faster than twice that. */
static Bounds bounds_of(const mat3 *i, vec3 w, vec3 l)
{
    real sum = i->r0.x + i->r1.y + i->r2.z, kept = real_max(0, vec3_dot(w, l)), all = sqrt(kept * sum);
    if (!tumble_principal(i))
        return (Bounds){all, 2 * all, all};
    real a = real_min(i->r0.x, real_min(i->r1.y, i->r2.z)), b = real_max(i->r0.x, real_max(i->r1.y, i->r2.z)), mid = sum - a - b;
    real l2 = vec3_length2(l), spin = sqrt(real_max(0, (a + b) * kept - a * b * l2));
    real sway2 = real_max((mid - a) * (b * l2 - kept), (b - mid) * (kept - a * l2));
    return (Bounds){spin, sqrt(real_max(0, sway2)), real_min(all, sqrt(3) * spin)};
}

/* The elliptic functions of w have their nearest pole a quarter of a period, pi / 2 over their rate, from the real axis, or farther: the
 * terms of u = h w / 2 shrink by 2 sway h / pi, and those of p, by p' = p u, by (u + k sway) / (k + 1). By what is kept, not by the terms
 * themselves: all steps of a flight then have as many, and it errs by what the tolerance says instead of where it last had one too few. */
static int terms_of(Bounds b, real h, real enough)
{
    real u = 0.5 * b.spin * h, shrink = b.sway * h * (2 / DIG_PI), term = u;
    int terms = 1;
    while (terms < ORDERS && (terms < LEAST || term > enough)) {
        term *= (u + terms * shrink) / (terms + 1);
        terms++;
    }
    return terms;
}

void flight_turn(Group *g, int i, real h)
{
    const Member *m = &g->member[i];
    vec3 w = g->vel[i].w;
    if (m->round || g->planar) {
        g->pos[i].q = quat_unit(quat_mul(quat_exp(vec3_scale(h, w)), g->pos[i].q));
        return;
    }
    quat q = g->pos[i].q;
    vec3 l = quat_rotate(q, mat3_mul_vec(*m->inertia, quat_unrotate(q, w)));
    int axis = tumble_axis(m->inv_inertia);
    if (axis >= 0)
        q = tumble_about(m->inv_inertia, q, l, h, axis);
    else {
        Bounds bounds = bounds_of(m->inv_inertia, w, l);
        int parts = (int)real_clamp(ceil(bounds.safe * h / PART), 1, MOST_PARTS), terms = terms_of(bounds, h / parts, ENOUGH * g->tolerance);
        bool done = parts > 1 && tumble_principal(m->inv_inertia) && tumble(m->inv_inertia, &q, l, h);
        done = done || (parts == MOST_PARTS && tumble_far(m->inv_inertia, &q, l, h));
        for (int k = 0; k < parts && !done; k++)
            q = turn(m, q, l, h / parts, terms);
    }
    g->pos[i].q = q;
    w = quat_rotate(q, mat3_mul_vec(*m->inv_inertia, quat_unrotate(q, l)));
    /* refined once: |q| is 1 within rounding only, and that bias would add up to a drift of the angular momentum */
    vec3 off = vec3_sub(l, quat_rotate(q, mat3_mul_vec(*m->inertia, quat_unrotate(q, w))));
    g->vel[i].w = vec3_add(w, quat_rotate(q, mat3_mul_vec(*m->inv_inertia, quat_unrotate(q, off))));
}

static void fly(Group *g, int i, real h)
{
    vec3 a = fall_of(g, i), none = vec3_zero();
    dir_mask(g, &a, &none);
    g->pos[i].x = vec3_mad(vec3_mad(g->pos[i].x, h, g->vel[i].v), 0.5 * h * h, a);
    g->vel[i].v = vec3_mad(g->vel[i].v, h, a);
    flight_turn(g, i, h);
}

static dig_status advance(Group *g, real dt)
{
    real h = g->h;
    g->h = dt;
    DIG_TRY(group_forces(g));
    bool rests = g->pair_count > 0 && lies_still(g) && unforced(g);
    if (g->pair_count > 0 && !rests && (!apart(g) || !keeps_apart(g, dt))) {
        g->h = h;
        g->handed_on = true;
        return DIG_OK;
    }
    for (int i = 0; i < g->moving_count && !rests; i++)
        fly(g, i, dt);
    for (int i = 0; i < g->contact_count && rests; i++) {       /* nothing presses that did: its memory is of no use */
        for (int k = 0; k < g->contacts[i].manifold.room; k++)
            contact_memory(&g->contacts[i])[k] = (PointMemory){.normal = 0};
        for (int k = 0; k < g->contacts[i].manifold.count; k++)
            g->penetration = real_max(g->penetration, -g->contacts[i].manifold.points[k].gap);
    }
    g->evaluations = g->substeps = 1;
    g->t = dt;
    return g->stage(g, STAGE_SETTLE);
}

const Way way_flight = {.name = "flight", .tally = WAY_TRACED, .suits = suits, .advance = advance};
