/* trace/pendulum.c - one body on one hinge that hangs on what stands still, by a power series.
 *
 * A door, a pendulum or a see-saw has one freedom, the angle f about an axis that stays where it is, and one moment of inertia J about it.
 * Under a force F that is the same everywhere, a torque T about the axis, friction among it, and a spring k with a damper c,
 *
 *     J f'' = A cos f + B sin f + T - k (f + f0) - c f',    A = u . (r x F),  B = u . ((u x r) x F),
 *
 * u the axis and r what the centre of mass is off it at f = 0. With x = cos f and y = sin f, x' = -y f' and y' = x f', the terms of each
 * series give the next ones of the others (Moore, Interval Analysis, 1966, section 11.2): as many as double precision can tell, at less
 * than one evaluation by rows. A motor, a stop that may be reached, friction that may hold, and anything near are handed on as gathered.
 */
#include "math/pair.h"
#include "trace/trace.h"

#define STOPS   1e-6            /* rad: nearer a stop may press */
#define ENOUGH  1e-17           /* of a radian: terms that follow two smaller ones are no part of the sum */

static bool has_motor(const Drive *d) { return !isnan(d->motor.speed) && d->motor.most > 0; }

static bool suits(const Group *g)
{
    if (!hang_suits(g))
        return false;
    const JointView *j = &g->joints[0].view;
    return j->type->driven && j->type->angular && !has_motor(j->params);
}

typedef struct Pendulum {
    Hang hang;
    vec3 axis, along, across, beyond;   /* r: along the axis, off it, and that turned by a quarter, m */
    vec3 hinge;                 /* m      what both anchors are to be at */
    vec3 force, torque;         /* N, N m */
    real inertia;               /* kg m^2 about the axis */
    real spin;                  /* rad/s */
    const Drive *drive;         /* NULL: it is loose */
    real off, friction;         /* rad, N m  of the spring at the start; with its sign, of what turns on */
    real turned;                /* rad    since the start */
    real least, most;           /* rad    no farther does it turn before a stop; NaN: none is there */
    real low, high;             /* rad    between these it stayed */
    real way;                   /* rad    it went, to and fro */
    bool turns_back;            /*        in the step, or it may */
    real end_spin;              /* rad/s */
    real damped;                /* J      lost in the damper */
    vec3 mean;                  /* m      of r, over the step */
    vec3 first, last;           /* kg m^2  see along_axis: at the start, and the end of the step */
} Pendulum;

static vec3 arm(const Pendulum *p, real c, real s) { return vec3_add(p->along, vec3_mad(vec3_scale(c, p->across), s, p->beyond)); }

/* kg m^2  Of the body as it lies: times its spin, its angular momentum about its centre of mass. */
static vec3 along_axis(const Group *g, vec3 axis)
{
    return quat_rotate(g->pos[0].q, mat3_mul_vec(*g->member[0].inertia, quat_unrotate(g->pos[0].q, axis)));
}

/* Is its axis where that of the hinge is, and does it turn about it? */
static bool look(Group *g, Pendulum *p)
{
    const JointView *j = &g->joints[0].view;
    const Member *m = &g->member[0];
    Hang *hang = &p->hang;
    if (!hang_look(g, hang) || !hang_holds(hang))
        return false;
    vec3 r = vec3_neg(hang->own->r), u = hang->other->axis, w = hang->before.w;
    p->axis = u;
    p->hinge = hang->other->p;
    p->spin = vec3_dot(u, w);
    if (m->outer * vec3_distance(hang->own->axis, u) > hang->least || m->outer * vec3_length(vec3_mad(w, -p->spin, u)) > hang->slowest)
        return false;
    p->along = vec3_scale(vec3_dot(u, r), u);
    p->across = vec3_sub(r, p->along);
    p->beyond = vec3_cross(u, p->across);
    p->first = along_axis(g, u);
    p->inertia = vec3_dot(u, p->first) + m->mass * vec3_length2(p->across);
    p->force = m->force;
    p->torque = m->torque;
    p->drive = drive_acts(j->params) ? j->params : NULL;
    return true;
}

/* rad/s^2  What turns it, about the axis, over its inertia: see above. */
typedef struct Equation { real a, b, t, k, c; } Equation;

static Equation law_of(const Pendulum *p)
{
    const vec3 u = p->axis;
    real each = 1 / p->inertia;
    Equation l = {.a = each * vec3_dot(u, vec3_cross(p->across, p->force)), .b = each * vec3_dot(u, vec3_cross(p->beyond, p->force)),
                  .t = each * vec3_dot(u, p->torque)};
    if (p->drive) {
        l.k = each * p->drive->spring.stiffness;
        l.c = each * p->drive->spring.damping;
        l.t -= each * p->friction + l.k * p->off;
    }
    return l;
}

/* Of one part of the step: angle, its rate in radians a part, its cosine and sine, and their means; of its rate squared, the mean. */
typedef struct Turn { real angle, spin; pair cs, mean; real square; } Turn;

static real largest(pair x) { return real_max(fabs(x[0]), fabs(x[1])); }

static real mean_square(const real *g, int count)
{
    real sum = 0;
    for (int i = 0; i < count; i++)
        for (int k = 0; k < count; k++)
            sum += g[i] * g[k] / (i + k + 1);
    return sum;
}

/* The term of order k of g times cs: that of each, in the order of g, two at a time. */
INLINE pair product_term(const real *g, const pair *cs, int k)
{
    pair sum = {0, 0};
    int i = 0;
    for (; i + 1 < k; i += 2) {
        sum += g[i] * cs[k - 1 - i];
        sum += g[i + 1] * cs[k - 2 - i];
    }
    if (i < k)
        sum += g[i] * cs[k - 1 - i];
    return sum;
}

/* From angle 0, time in parts. False: the series does not end. */
static bool turn(const Equation *law, real start, Turn *out)
{
    const Equation l = *law;
    real g[SERIES_TERMS];              /* of f' */
    pair cs[SERIES_TERMS];             /* of the cosine and the sine */
    g[0] = start;
    cs[0] = (pair){1, 0};
    pair at = cs[0], mean = cs[0];
    real angle = start, spin = start;
    bool drives = l.c > 0 || l.k > 0;
    for (int k = 1; k < SERIES_TERMS; k++) {
        pair sum = product_term(g, cs, k);
        real each = 1.0 / k;
        cs[k] = (pair){-each * sum[1], each * sum[0]};
        real push = l.a * cs[k - 1][0] + l.b * cs[k - 1][1];
        if (drives)
            push -= l.c * g[k - 1];
        if (k == 1)
            push += l.t;
        else if (drives)
            push += -l.k / (k - 1) * g[k - 2];
        g[k] = each * push;
        at += cs[k];
        mean += cs[k] / (k + 1);
        angle += g[k] / (k + 1);
        spin += g[k];
        if (k >= SERIES_LEAST && real_max(real_max(largest(cs[k]), largest(cs[k - 1])), real_max(fabs(g[k]), fabs(g[k - 1]))) < ENOUGH) {
            *out = (Turn){angle, spin, at, mean, l.c > 0 ? mean_square(g, k) : 0};
            return true;
        }
    }
    return false;
}

/* rad/s  The rate that keeps the energy where places are rounded; of what loses none. */
static real kept_spin(const Pendulum *p, vec3 moved, real spin)
{
    real work = vec3_dot(p->force, moved) + p->turned * vec3_dot(p->axis, p->torque);
    if (p->drive)
        work -= p->drive->spring.stiffness * p->turned * (p->off + 0.5 * p->turned);
    real square = p->spin * p->spin + 2 * work / p->inertia;
    return square > 0.25 * spin * spin ? copysign(sqrt(square), spin) : spin;
}

/* Turns that have the law of the step in another place. */
static Equation law_at(const Equation *l, real c, real s, real turned, real part)
{
    real each = part * part;
    return (Equation){each * (l->a * c + l->b * s), each * (l->b * c - l->a * s), each * (l->t - l->k * turned), each * l->k, part * l->c};
}

/* rad/s  No faster does it become, nor does what it follows change. */
static real fastest(const Equation *l, real spin, real h)
{
    real push = hypot(l->a, l->b), swing2 = 2 * push + l->k;
    return real_max(fabs(spin) + h * (push + fabs(l->t)), sqrt(swing2)) + l->c;
}

/* False: not in so few parts. */
static bool swing(Pendulum *p, const Equation *law, real h)
{
    real rate = fastest(law, p->spin, h);
    int parts = hang_parts(rate * h);
    if (parts == 0)
        return false;
    real part = h / parts, spin = p->spin * part, c = 1, s = 0;
    vec3 sum = vec3_zero();
    for (int i = 0; i < parts; i++) {
        Turn one;
        Equation now = law_at(law, c, s, p->turned, part);
        if (!turn(&now, spin, &one))
            return false;
        sum = vec3_add(sum, arm(p, c * one.mean[0] - s * one.mean[1], s * one.mean[0] + c * one.mean[1]));
        bool back = !(one.spin * spin > 0);
        real beyond = back ? fabs(spin) : 0, next = p->turned + one.angle;
        p->low = real_min(p->low, real_min(p->turned, next) - beyond);
        p->high = real_max(p->high, real_max(p->turned, next) + beyond);
        p->way += back ? fabs(spin) + fabs(one.spin) : fabs(one.angle);
        p->turned = next;
        p->turns_back = p->turns_back || back;
        p->damped += p->inertia * law->c / part * one.square;
        spin = one.spin;
        real turned = c * one.cs[0] - s * one.cs[1];
        s = s * one.cs[0] + c * one.cs[1];
        c = turned;
    }
    p->mean = vec3_scale(1.0 / parts, sum);
    p->end_spin = spin / part;
    return true;
}

/* Is there a law for the step, as far as its start tells? Friction is against the motion; a stop is out of reach, or may press. */
static bool drives(Pendulum *p, const JointView *j)
{
    const Drive *d = p->drive;
    real side = p->hang.is_a ? 1 : -1, angle = j->type->coordinate(j), one = side * (d->limits[0] - angle), other = side * (d->limits[1] - angle);
    p->least = fmin(one, other);                /* NaN: no stop there */
    p->most = fmax(one, other);
    if (p->least > -STOPS || p->most < STOPS || (d->friction > 0 && p->spin == 0))
        return false;
    p->off = d->spring.stiffness > 0 ? side * (angle - d->spring.rest) : 0;
    p->friction = d->friction > 0 ? copysign(d->friction, p->spin) : 0;
    return true;
}

/* ... and as its way tells? */
static bool drove(const Pendulum *p)
{
    return !(p->friction != 0 && p->turns_back) && !(p->low < p->least + STOPS) && !(p->high > p->most - STOPS);
}

#define ARC 0.25                /* rad, between places that are noted */

/* What came back was elsewhere in between. */
static void note_turns(Group *g, const Pendulum *p)
{
    int count = (int)ceil((p->high - p->low) / ARC);
    for (int i = 0; i <= count && p->turns_back; i++) {
        real turned = p->low + (p->high - p->low) * i / int_max(1, count);
        group_note_swing(g, 0, vec3_add(p->hinge, arm(p, cos(turned), sin(turned))), turned);
    }
}

static void move(Group *g, Pendulum *p)
{
    const GroupJoint *j = &g->joints[0];
    vec3 from = g->pos[0].x;
    note_turns(g, p);
    g->pos[0].q = quat_unit(quat_mul(quat_exp(vec3_scale(p->turned, p->axis)), g->pos[0].q));
    vec3 r = vec3_neg(quat_rotate(g->pos[0].q, p->hang.is_a ? j->ra : j->rb));
    g->pos[0].x = vec3_add(p->hinge, r);
    if (p->friction == 0 && !(p->damped > 0))
        p->end_spin = kept_spin(p, vec3_sub(g->pos[0].x, from), p->end_spin);
    p->last = along_axis(g, p->axis);
    g->vel[0].w = vec3_scale(p->end_spin, p->axis);
    g->vel[0].v = vec3_cross(g->vel[0].w, r);
}

/* N, N m  What the joint does to the body: its force, and its torque without that. */
typedef struct Load { vec3 force, couple; } Load;

/* At the end of the step. */
static Load load_now(const Group *g, const Pendulum *p)
{
    vec3 w = g->vel[0].w, r = vec3_sub(g->pos[0].x, p->hinge), turning = vec3_add(p->torque, vec3_cross(r, p->force));
    real alpha = vec3_dot(p->axis, turning) / p->inertia;
    vec3 acc = vec3_mad(vec3_cross(w, g->vel[0].v), alpha, vec3_cross(p->axis, r));
    vec3 force = vec3_mad(vec3_neg(p->force), g->member[0].mass, acc);
    vec3 torque = vec3_sub(vec3_add(vec3_scale(alpha, p->last), vec3_scale(p->end_spin, vec3_cross(w, p->last))), p->torque);
    return (Load){force, vec3_add(torque, vec3_cross(r, force))};
}

/* Of the step: what changed the momenta, less what acted besides. */
static void book_impulses(Group *g, const Pendulum *p, real h)
{
    vec3 impulse = hang_impulse(g, &p->hang, h), first = vec3_add(p->along, p->across), last = vec3_sub(g->pos[0].x, p->hinge);
    vec3 own = vec3_mad(vec3_mad(vec3_scale(p->end_spin, p->last), -p->spin, p->first), -h, p->torque);
    vec3 orbit = vec3_scale(g->member[0].mass, vec3_sub(vec3_cross(last, g->vel[0].v), vec3_cross(first, p->hang.before.v)));
    hang_book_impulses(g, &p->hang, impulse, own, vec3_mad(vec3_add(own, orbit), -h, vec3_cross(p->mean, p->force)));
}

static void book(Group *g, const Pendulum *p, real h)
{
    GroupJoint *j = &g->joints[0];
    Row rows[JOINT_SLOTS];
    real side = p->hang.is_a ? 1 : -1;
    j->memory[0] += side * p->turned;           /* more than half a turn is none too few */
    Load now = load_now(g, p);
    for (int i = 0, count = hang_rows(g, rows); i < count; i++) {
        const Row *r = &rows[i];
        if (r->kind == ROW_HARD)
            j->force[r->slot] = side * (r->angular ? vec3_dot(r->ang[0], now.couple) / vec3_length2(r->ang[0]) : vec3_dot(r->lin[0], now.force));
        else if (r->kind == ROW_SOFT)
            j->force[r->slot] = -(r->stiffness * r->error + side * r->damping * p->end_spin);
        else if (r->kind == ROW_DRY)
            j->force[r->slot] = -side * p->friction;
    }
    book_impulses(g, p, h);
    real lost = p->damped + p->friction * p->turned;
    j->lost += lost;
    g->lost += lost;
}

static bool follow(Group *g, real h)
{
    Pendulum p = {.turned = 0};
    if (!look(g, &p) || (p.drive && !drives(&p, &g->joints[0].view)))
        return false;
    Equation law = law_of(&p);
    if (!swing(&p, &law, h) || (p.drive && !drove(&p)) || !hang_apart(g, h, p.way * (vec3_length(p.across) + g->member[0].outer)))
        return false;
    move(g, &p);
    book(g, &p, h);
    return true;
}

static dig_status advance(Group *g, real dt) { return hang_advance(g, dt, follow); }

const Way way_pendulum = {.name = "pendulum", .tally = WAY_TRACED, .suits = suits, .advance = advance};
