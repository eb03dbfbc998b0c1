/* trace/bounce.c - a series of bounces in closed form.
 *
 * A body that bounces on a plane with restitution e does so without end before it comes to rest: after a blow that left it at the
 * speed r, against the acceleration a, its flights take 2 r/a, 2 r e/a, 2 r e^2/a, ... and are over at T = 2 r / (a (1 - e)).
 * Where bounces are short against the step they are not located one by one. The state after any number k of them is known:
 *
 *     t_k = T (1 - e^k),   speed r e^k,   impulse P_k = m r (1 + e) (1 - e^k) / (1 - e),
 *
 * sliding friction takes mu P along the slip, and what it does to place and orientation are the integrals of P over the flights, sums
 * of powers of e. With k without bound that is rest, at its time.
 *
 * Only for what is that simple: one body, on a plane that does not turn, under constant forces; a ball, or something that neither
 * turns nor slips with friction; and a slip that lasts. All else is followed blow by blow.
 */
#include "trace/trace.h"

#define WORTH 3                 /* bounces: fewer are as well located                              */
#define TURN  0.3               /* rad: farther a ball whose spin changes is not turned at once            */
#define STILL 1e-11             /* of the blow: a slip or a turn that its solve left over is none  */

typedef struct Series {
    const Touching *touch;      /* one of its points                              */
    vec3 out;                   /* away from the plane                            */
    vec3 mover;                 /* m/s    velocity of the plane                   */
    vec3 along;                 /* m/s^2  of the free acceleration along the plane */
    vec3 d;                     /*        direction of the slip                   */
    real e, r, a, last;         /* 1, m/s, m/s^2, s                               */
    real slip, friction, mobility, mass;        /* m/s, 1, 1/kg, kg               */
    bool ball;
} Series;

static bool plane_and_point(const Touching *c, bool on_b) { return c->feature.kind == (on_b ? PLANE_POINT : POINT_PLANE); }

/* Do the points that touch leave a plane at one speed, and nothing else come near in `time`? */
static bool one_contact(const Tracer *t, Series *s, real time)
{
    const Group *g = t->g;
    real reach = time * (vec3_length(g->vel[0].v) + vec3_length(t->acc0[0]) * time);
    s->touch = NULL;
    for (int i = 0; i < t->touch_count; i++) {
        const Touching *c = &t->touch[i];
        const Member *other = &g->member[c->a == 0 ? c->b : c->a];
        if (c->gate.gap > t->gap_zero) {
            if (other->kinematic || c->gate.gap <= reach)
                return false;
            continue;
        }
        if (!s->touch)
            s->touch = c;
        if (c->contact != s->touch->contact || !plane_and_point(c, c->b == 0) || c->roll.axes || other->dormant)
            return false;
        if (fabs(c->gate.rate - s->touch->gate.rate) > 1e-9 * fabs(c->gate.rate))
            return false;
    }
    return s->touch && s->touch->gate.rate > t->g->close_speed;
}

/* A ball may turn and slip; anything else may not. */
static bool simple_slip(const Tracer *t, Series *s)
{
    const Group *g = t->g;
    const Touching *c = s->touch;
    bool b = c->b == 0;
    vec3 centre = b ? c->feature.pb : c->feature.pa, u = vec3_scale(b ? 1 : -1, c->slip.u);
    real rim = g->member[0].outer * vec3_length(g->vel[0].w);
    real still = STILL * s->r + 1e-3 * t->tolerance * t->pace + 8e-15 * (vec3_length(g->vel[0].v) + rim);
    s->ball = g->member[0].round && vec3_length(centre) <= 1e-14 * t->size;
    s->slip = vec3_length(u);
    s->d = vec3_zero();
    s->mobility = 0;
    if ((!s->ball && rim > still) || vec3_length(t->torque0[0]) > 0)
        return false;
    s->friction = c->slip.axes ? c->slip.moving : 0;
    if (!(s->friction > 0))
        return true;
    if (vec3_length(s->along) > 1e-14 * s->a || (!s->ball && s->slip > still))
        return false;
    if (s->slip <= still)
        s->slip = s->friction = 0;
    else
        s->d = vec3_scale(1 / s->slip, u);
    vec3 arm = vec3_sub(c->k.at, g->pos[0].x), turn = vec3_cross(arm, s->d);
    s->mobility = g->mass[0].im + vec3_dot(turn, mat3_mul_vec(g->mass[0].ii, turn));
    return true;
}

static bool is_series(const Tracer *t, Series *s)
{
    const Group *g = t->g;
    if (g->moving_count != 1 || !g->member[0].moves || g->joint_count > 0 || g->planar || !one_contact(t, s, t->end - t->t))
        return false;
    const Touching *c = s->touch;
    int base = c->b == 0 ? c->a : c->b;
    if (g->member[base].kinematic && vec3_length(g->vel[base].w) > 0)
        return false;
    s->out = vec3_scale(c->b == 0 ? 1 : -1, c->k.n);
    s->mover = g->member[base].kinematic ? g->vel[base].v : vec3_zero();
    s->mass = g->member[0].mass;
    s->r = c->gate.rate;
    s->a = -vec3_dot(t->acc0[0], s->out);
    s->along = vec3_mad(t->acc0[0], s->a, s->out);
    s->e = g->pairs[g->contacts[c->contact].pair].rub->restitution;
    if (!(s->a > 0 && s->e > 0 && s->e < 1))
        return false;
    s->last = 2 * s->r / (s->a * (1 - s->e));
    return simple_slip(t, s);
}

/* How many bounces from now end within `time`; INFINITY: all. A slip that a blow would end is left to that blow. */
static real count_bounces(const Series *s, real time)
{
    real k = s->last <= time ? INFINITY : floor(log1p(-time / s->last) / log(s->e));
    real each = s->friction * s->mobility * s->mass * s->r * (1 + s->e), all = each / (1 - s->e);      /* slip taken by the first, by all */
    if (s->friction > 0 && s->slip < all * (1 - 1e-12))
        k = real_min(k, floor(log1p(-s->slip / all) / log(s->e)));
    while (isfinite(k) && k > 0 && s->last * (1 - pow(s->e, k)) > time)
        k--;
    return k;
}

/* x + x^2 + ... + x^(k-1), given x^k */
static real powers(real x, real xk) { return (x - xk) / (1 - x); }

static void jump(Tracer *t, const Series *s, real k, real *h, real *impulse)
{
    Group *g = t->g;
    real e = s->e, ek = isfinite(k) ? pow(e, k) : 0, whole = s->mass * s->r * (1 + e) / (1 - e), time = s->last * (1 - ek);
    real g1 = powers(e, ek), g2 = powers(e * e, ek * ek), g3 = powers(e * e * e, ek * ek * ek), p = whole * (1 - ek);
    real sum = whole * s->last * (1 - e) * (g1 - g2);           /* of P over time, and of P t */
    real c1 = 2 * (1 - e), c2 = 1 - e * e, moment = 0.5 * whole * s->last * s->last * (c1 * g1 - (c1 + c2) * g2 + c2 * g3);
    vec3 v = vec3_sub(g->vel[0].v, s->mover), side = vec3_mad(v, -vec3_dot(v, s->out), s->out), w = g->vel[0].w;
    vec3 arm = vec3_sub(s->touch->k.at, g->pos[0].x);
    vec3 push = vec3_scale(-s->friction, s->d), spin = mat3_mul_vec(g->mass[0].ii, vec3_cross(arm, push));  /* per impulse */
    vec3 x = vec3_mad(g->pos[0].x, time, vec3_add(s->mover, side));
    g->pos[0].x = vec3_mad(vec3_mad(x, 0.5 * time * time, s->along), sum / s->mass, push);
    g->vel[0].v = vec3_add(s->mover, vec3_mad(vec3_mad(side, time, s->along), s->r * ek, s->out));
    g->vel[0].v = vec3_mad(g->vel[0].v, p / s->mass, push);
    if (s->ball) {              /* Magnus, two terms */
        vec3 turn = vec3_mad(vec3_scale(time, w), sum, spin);
        turn = vec3_mad(turn, 0.5 * (2 * moment - time * sum), vec3_cross(spin, w));
        g->pos[0].q = quat_unit(quat_mul(quat_exp(turn), g->pos[0].q));
        g->vel[0].w = vec3_mad(w, p, spin);
    }
    *h = time;
    *impulse = p;
}

static void book(Tracer *t, const Series *s, const Touching *c, real p, vec3 moved, real h, real kinetic, bool rests)
{
    Group *g = t->g;
    GroupContact *to = &g->contacts[c->contact];
    GroupPair *q = &g->pairs[to->pair];
    vec3 j = vec3_scale(p, vec3_mad(s->out, -s->friction, s->d));
    vec3 at = s->ball ? c->k.at : vec3_mad(g->pos[0].x, vec3_dot(vec3_sub(c->k.at, g->pos[0].x), s->out), s->out);
    Acted *acted = contact_acted(g, to);
    acted->impulse = vec3_mad(acted->impulse, c->b == 0 ? 1 : -1, j);
    acted->point_sum = vec3_mad(acted->point_sum, p, at);
    acted->point_weight += p;
    acted->last = t->t;
    Impact *impact = group_impact(g, q);
    impact->impulse += p;
    if (impact->last > 0 && impact->last <= g->strike_count)        /* told as one with the blow that they follow */
        g->strikes[impact->last - 1].impulse += p;
    if (rests)
        impact->time = t->t;                                /* when the contact that lasts begins */
    real given = vec3_dot(j, s->mover), forces = s->mass * vec3_dot(t->acc0[0], moved);
    for (int i = 0; i < g->push_count; i++) {
        real work = vec3_dot(g->pushes[i].force, moved);
        group_book_push(g, &g->pushes[i], work);
    }
    group_book_apart(g, 0, moved, vec3_zero(), h);
    g->work_in += given;
    real lost = kinetic + forces + given - group_kinetic(g);
    g->lost += lost;
    contact_rest_of(g, to)->lost += lost;
}

/* The forces at the far end are what they were. */
static bool same_forces(Tracer *t, vec3 acc, real h)
{
    trace_kinematics(t);
    return vec3_distance(t->acc0[0], acc) * h <= 0.1 * t->tolerance * t->pace && !(vec3_length(t->torque0[0]) > 0);
}

bool trace_bounce(Tracer *t)
{
    Group *g = t->g;
    Series s = {.touch = NULL};
    if (!is_series(t, &s))
        return true;
    real time = (t->end - t->t) * (1 - 1e-12), spin = vec3_length(g->vel[0].w);
    if (s.friction > 0 && spin > 0)
        time = real_min(time, TURN / spin);
    real k = count_bounces(&s, time), h, impulse, kinetic = group_kinetic(g), begin = t->t;
    if (!(k >= WORTH))
        return true;
    Touching c = *s.touch;
    s.touch = &c;
    Pos pos = g->pos[0];
    Vel vel = g->vel[0];
    vec3 acc = t->acc0[0];
    jump(t, &s, k, &h, &impulse);
    vec3 moved = vec3_sub(g->pos[0].x, pos.x);
    t->t = begin + h;
    trace_store(t, t->y);
    trace_load(t, t->y, t->t);
    bool fine = trace_touch(t, false) && same_forces(t, acc, h), there = false;
    for (int i = 0; i < t->touch_count && fine; i++)
        there = there || (t->touch[i].contact == c.contact && fabs(t->touch[i].gate.gap) <= 2 * t->gap_zero);
    if (fine && there) {
        book(t, &s, &c, impulse, moved, h, kinetic, isinf(k));
        g->events++;
        return true;
    }
    t->t = begin;                   /* it left the plane, or the forces changed on the way */
    g->pos[0] = pos;
    g->vel[0] = vel;
    trace_store(t, t->y);
    trace_load(t, t->y, t->t);
    if (t->fault)
        return false;
    bool found = trace_touch(t, false);
    trace_kinematics(t);
    return found;
}
