/* geom/toi.c - when two moving shapes meet: conservative advancement (Mirtich 1996) along the normal between them, closed by
 * bracketing on the true gap.
 *
 * While both shapes move for h seconds, no gap along the unit normal n closes by more than
 *     c1 h + c2 h^2 / 2 + min(s h, 2 (Ra + Rb)),    c1 = -n.(vb - va), c2 = -n.(ab - aa), s = |n x wa| Ra + |n x wb| Rb,
 * with R the radius of each core about its centre of mass: a point at r moves along n at n.(w x r) = (n x w).r.
 *
 * Where shapes turn, supports say more. Let n turn along at the rate W, with neither of them or with one, and c lie between the centres
 * of mass. At first the gap along n grows by n.v + (W x n).c, and a point at r gets nearer by r.(n x (w - W)): after h seconds the points
 * of a core are no farther along n than its support in the direction n + h n x (w - W) and what the second derivatives may add. Two
 * stones of an arch that hinge on an edge are so followed in 3 steps, where each alone turns its corners far into the other's side.
 *
 * And along a normal that stands still, supports at both ends of an arc say what lies between: a rod that whirls before a wall needs two gaps. */
#include "geom/cast.h"
#include "geom/pair.h"

#define TOLERANCE   1e-10       /* of the size */
#define SURE_STEPS  64          /* conservative steps before parts of the core are stepped over instead */
#define ALL_STEPS   20000
#define SMALL_TURN  0.1         /* rad  in less than this a gap that has begun to close crosses the target once */
#define SLICES      64          /* parts of a path over a surface */

pose motion_at(const Motion *m, real t)
{
    vec3 arm = quat_rotate(m->start.q, m->centre), moved = vec3_mad(vec3_scale(t, m->v), 0.5 * t * t, m->a);
    if (!(vec3_length2(m->w) > 0))
        return (pose){vec3_add(m->start.p, moved), m->start.q};
    quat turn = quat_exp(vec3_scale(t, m->w));
    vec3 swing = vec3_sub(arm, quat_rotate(turn, arm));
    return (pose){vec3_add(m->start.p, vec3_add(moved, swing)), quat_unit(quat_mul(turn, m->start.q))};
}

vec3 motion_velocity(const Motion *m, vec3 at, real t)
{
    vec3 c = pose_point(m->start, m->centre);
    vec3 x = vec3_add(vec3_mad(c, t, m->v), vec3_scale(0.5 * t * t, m->a));
    return vec3_add(vec3_mad(m->v, t, m->a), vec3_cross(m->w, vec3_sub(at, x)));
}

Motion motion_from(const Motion *m, real t)
{
    Motion later = *m;
    later.start = motion_at(m, t);
    later.v = vec3_mad(m->v, t, m->a);
    return later;
}

typedef struct Flight {
    const Shape  *a, *b;
    const Motion *ma, *mb;
    real target, time, size;
    real reach_a, reach_b;      /* m  of the cores about the centres of mass */
    real spin_a, spin_b;        /* rad/s  of their turns, what moves their surfaces */
    real turns;                 /* rad/s  of the faster one                        */
    vec3 v, acceleration;       /* of b against a */
    vec3 axis;                  /* where the last normal was, for GJK */
    int  count;                 /* gaps computed */
} Flight;

typedef struct Moment {
    real t, gap, rate;          /* gap - target; rate: how fast it closes at the nearest points */
    vec3 normal;
    pose a, b;
} Moment;

static vec3 velocity_of(const Motion *m, pose at, real t, vec3 point)
{
    vec3 centre = pose_point(at, m->centre);
    return vec3_add(vec3_mad(m->v, t, m->a), vec3_cross(m->w, vec3_sub(point, centre)));
}

static Moment moment_at(Flight *f, real t)
{
    pose pa = motion_at(f->ma, t), pb = motion_at(f->mb, t);
    Pair p = pair_make(f->a, pa, f->b, pb);
    ConvexGap g;
    pair_gap(&p, INFINITY, &f->axis, &g);
    Moment m = {.t = t, .gap = g.gap - f->target, .normal = pair_direction(&p, g.normal), .a = pa, .b = pb};
    vec3 va = velocity_of(f->ma, pa, t, pair_point(&p, g.on_a)), vb = velocity_of(f->mb, pb, t, pair_point(&p, g.on_b));
    m.rate = -vec3_dot(m.normal, vec3_sub(vb, va));
    f->count++;
    return m;
}

/* Smallest h > 0 with a h^2 + b h = d, d > 0. */
static real first_root(real a, real b, real d)
{
    real disc = b * b + 4 * a * d;
    if (!(d > 0))
        return 0;
    if (a == 0)
        return b > 0 ? d / b : INFINITY;
    if (a < 0 && (!(b > 0) || disc < 0))
        return INFINITY;
    return b > 0 ? 2 * d / (b + sqrt(disc)) : (sqrt(disc) - b) / (2 * a);
}

static real core_reach(const Shape *s, vec3 centre)
{
    return s->outer < INFINITY ? s->outer - s->round + vec3_length(centre) : 0;
}

/* m  How far a core reaches along d from its centre of mass. */
static real reach_along(const Shape *s, const Motion *m, quat q, vec3 d)
{
    vec3 local = quat_unrotate(q, d);
    return vec3_dot(local, vec3_sub(s->type->support(s, local), m->centre));
}

/* m  By how much more a core may ever reach along d, however it turns. */
static real may_reach(const Shape *s, const Motion *m, quat q, vec3 d, real radius)
{
    if (!(vec3_length2(m->w) > 0))
        return 0;
    return s->type->convex ? real_max(0, radius - reach_along(s, m, q, d)) : 2 * radius;
}

/* The longest step in which the gap certainly stays above the target. */
static real safe_step(const Flight *f, const Moment *m)
{
    vec3 n = m->normal;
    real c1 = -vec3_dot(n, vec3_mad(f->v, m->t, f->acceleration)), c2 = -0.5 * vec3_dot(n, f->acceleration);
    real turning = real_min(f->spin_a, vec3_length(vec3_cross(n, f->ma->w))) * f->reach_a;
    turning += real_min(f->spin_b, vec3_length(vec3_cross(n, f->mb->w))) * f->reach_b;
    real h = first_root(c2, c1 + turning, m->gap);
    if (!(turning > 0) || m->t + h > f->time)
        return h;
    real most = may_reach(f->a, f->ma, m->a.q, n, f->reach_a) + may_reach(f->b, f->mb, m->b.q, vec3_neg(n), f->reach_b);
    return real_max(h, first_root(c2, c1, m->gap - most));
}

/* A bound of the gap along a normal n that turns at the rate `turn`, from a moment on. */
typedef struct Bound {
    const Flight *f;
    const Moment *m;
    vec3 n, turn;
    real rate, bend;            /* m/s, m/s^2  of the bound, but for what the supports say */
} Bound;

/* m/s^2  How fast the turn of a core may change the rate of its points along n. */
static real core_bend(const Bound *b, const Motion *m, real radius)
{
    if (vec3_equal(m->w, b->turn))
        return 0;
    real w = vec3_length(m->w), turn = vec3_length(b->turn), along = vec3_length(vec3_cross(b->n, b->turn));
    real across = turn > 0 ? w : vec3_length(vec3_cross(b->n, m->w));           /* of w to the normal, wherever that turns */
    return radius * (along * (turn + 2 * w) + across * w);
}

static Bound bound_of(const Flight *f, const Moment *m, vec3 turn)
{
    Bound b = {.f = f, .m = m, .n = m->normal, .turn = turn};
    vec3 c = vec3_sub(pose_point(m->b, f->mb->centre), pose_point(m->a, f->ma->centre)), v = vec3_mad(f->v, m->t, f->acceleration);
    vec3 change = vec3_cross(turn, b.n);
    real time = f->time - m->t, a = vec3_length(f->acceleration), fastest = vec3_length(v) + a * time;
    real farthest = vec3_length(c) + fastest * time, along = vec3_length(change);
    b.rate = vec3_dot(b.n, v) + vec3_dot(change, c);
    b.bend = real_min(0, vec3_dot(b.n, f->acceleration)) - along * (vec3_length(turn) * farthest + 2 * fastest + time * a);
    b.bend -= core_bend(&b, f->ma, f->reach_a) + core_bend(&b, f->mb, f->reach_b);
    return b;
}

/* m  By how much more it may reach along n after h seconds. */
static real turned_out(const Bound *b, const Shape *s, const Motion *m, quat q, vec3 n, real h)
{
    vec3 lean = vec3_cross(n, vec3_sub(m->w, b->turn));
    if (!(vec3_length2(lean) > 0))
        return 0;
    return s->type->convex ? reach_along(s, m, q, vec3_mad(n, h, lean)) - reach_along(s, m, q, n) : INFINITY;
}

/* m  The gap h seconds later is no less. Concave in h. */
static real least_gap(const Bound *b, real h)
{
    const Flight *f = b->f;
    return b->m->gap + h * b->rate + 0.5 * h * h * b->bend - turned_out(b, f->a, f->ma, b->m->a.q, b->n, h) -
           turned_out(b, f->b, f->mb, b->m->b.q, vec3_neg(b->n), h);
}

#define CHORDS 3
#define FAR_TURN 1.0            /* rad  bounds of what turns farther say little: the chord to there would be short */

/* s  The bound stays above 0 for so long: all the time that is left, or what chords, which it is never below, tell. */
static real sure_step(const Flight *f, const Moment *m, vec3 turn)
{
    Bound b = bound_of(f, m, turn);
    real rest = f->time - m->t, end = real_min(rest, FAR_TURN / real_max(f->turns, 1e-300)), h = 0, gap = m->gap, last = least_gap(&b, end);
    if (last > 0)
        return end < rest ? end : INFINITY;
    for (int i = 0; i < CHORDS && last > -INFINITY && gap > 0; i++) {
        real next = h + (end - h) * gap / (gap - last);
        gap = least_gap(&b, next);
        h = gap >= 0 ? next : h;
    }
    return h;
}

/* ---- along one normal: arcs ---- */

#define ARC   1.0               /* rad  of one; less than pi                               */
#define LEAST_ARC 1e-6          /* of that                                                 */
#define ARCS  32
#define LOOKS 16                /* at the course of the gap in one                         */
#define TRIES 4                 /* lengths in which its second derivative is bounded       */
#define QUICK 0.05              /* rad  what turns less in the time that is left needs none of this */
#define SHORT 0.125             /* of that time: a step is short                           */

/* m  A core reaches no farther along a direction than this in h seconds of an arc: cosine cos w h + sine sin w h + still. */
typedef struct Wave { real w, cosine, sine, still; } Wave;

/* Seen from the core the direction goes along an arc, e = [e0 sin(x1 - x) + e1 sin x] / sin x1, and a support is sublinear: no more than the same
 * of those at both ends. Exact where one corner is the farthest in all of it. The part of e along the spin stands still: what it has
 * too much of in that sum is taken off by the reach. */
static Wave wave_of(const Shape *s, const Motion *m, quat q, vec3 d, real reach, real length)
{
    real w = vec3_length(m->w), now = reach_along(s, m, q, d), x1 = w * length;
    if (!(x1 > 0))
        return (Wave){0, 0, 0, now};
    real then = reach_along(s, m, quat_mul(quat_exp(vec3_scale(length, m->w)), q), d), still = fabs(vec3_dot(d, m->w)) / w * reach;
    return (Wave){w, now + still, (then - now * cos(x1)) / sin(x1) + still * tan(0.5 * x1), -still};
}

/* m  The gap in h seconds of the arc is no less than gap + h rate + h^2 bend / 2 less both waves. */
typedef struct Course { real gap, rate, bend; Wave wave[2]; real third, enough; } Course;        /* m/s^3: bound of its third derivative */

static Course course_of(const Flight *f, real t, vec3 n, real length)
{
    pose a = motion_at(f->ma, t), b = motion_at(f->mb, t);
    vec3 apart = vec3_sub(pose_point(b, f->mb->centre), pose_point(a, f->ma->centre));
    Course c = {.gap = vec3_dot(n, apart) - f->a->round - f->b->round - f->target, .rate = vec3_dot(n, vec3_mad(f->v, t, f->acceleration)),
                .bend = vec3_dot(n, f->acceleration), .enough = 0.5 * TOLERANCE * f->size,
                .wave = {wave_of(f->a, f->ma, a.q, n, f->reach_a, length), wave_of(f->b, f->mb, b.q, vec3_neg(n), f->reach_b, length)}};
    for (int i = 0; i < 2; i++) {
        const Wave *w = &c.wave[i];
        c.third += w->w * w->w * w->w * hypot(w->cosine, w->sine);
    }
    return c;
}

/* gap, and its first two derivatives */
static void course_at(const Course *c, real h, real at[3])
{
    at[0] = c->gap + h * (c->rate + 0.5 * h * c->bend);
    at[1] = c->rate + h * c->bend;
    at[2] = c->bend;
    for (int i = 0; i < 2; i++) {
        const Wave *w = &c->wave[i];
        real cosine = cos(w->w * h), sine = sin(w->w * h), turned = w->cosine * cosine + w->sine * sine;
        at[0] -= turned + w->still;
        at[1] -= w->w * (w->sine * cosine - w->cosine * sine);
        at[2] += w->w * w->w * turned;
    }
}

/* s  It stays open for so long: length, or nearly until it closes. */
static real open_for(const Course *c, real length)
{
    real h = 0, at[3];
    for (int i = 0; i < LOOKS; i++) {
        real left = length - h, best = 0;
        course_at(c, h, at);
        if (!(at[0] > c->enough))
            return h;
        for (int k = 0; k < TRIES && best < left; k++, left *= 0.25)
            best = real_max(best, real_min(left, first_root(-0.5 * (at[2] - left * c->third), -at[1], at[0])));
        if (!(best < length - h))
            return length;
        h += best;
    }
    return h;
}

/* s  The two stay apart along the normal of the moment for so long. Where another corner becomes the farthest, shorter arcs tell more. */
static real arc_step(const Flight *f, const Moment *m)
{
    real end = f->time - m->t, most = ARC / f->turns, arc = most, h = 0;
    for (int i = 0; i < ARCS && arc > LEAST_ARC * most; i++) {
        real length = real_min(arc, end - h);
        Course c = course_of(f, m->t + h, m->normal, length);
        real open = open_for(&c, length);
        h += open;
        if (!(open > 0))
            break;
        if (!(h < end * (1 - 1e-12)))
            return INFINITY;
        arc = open < length ? arc / 8 : real_min(4 * arc, most);
    }
    return h;
}

/* safe_step, and where that is not enough, what the supports are sure of. */
static real longest_step(const Flight *f, const Moment *m)
{
    real h = safe_step(f, m), end = f->time - m->t;
    const vec3 turns[3] = {vec3_zero(), f->ma->w, f->mb->w};
    bool leans = vec3_length2(f->ma->w) * f->reach_a + vec3_length2(f->mb->w) * f->reach_b > 0;
    if (leans && h <= end && f->turns * end > QUICK && f->a->type->convex && f->b->type->convex) {
        h = real_max(h, arc_step(f, m));
        if (h > SHORT * end)
            return h;
    }
    for (int i = 0; i < 3 && leans && h <= end; i++)
        if (i == 0 || vec3_length2(turns[i]) > 0)
            h = real_max(h, sure_step(f, m, turns[i]));
    return h;
}

/* The zero in [lo, hi], lo.gap > 0 >= hi.gap: regula falsi, Illinois variant (Dowell & Jarratt 1971), halving when that is slow. */
static real close_in(Flight *f, Moment lo, Moment hi)
{
    real flo = lo.gap, fhi = hi.gap, width = hi.t - lo.t;
    int side = 0;
    for (int round = 0; round < 120; round++) {
        real t = round % 4 == 3 && hi.t - lo.t > 0.5 * width ? 0.5 * (lo.t + hi.t) : (lo.t * fhi - hi.t * flo) / (fhi - flo);
        if (round % 4 == 3)
            width = hi.t - lo.t;
        if (!(t > lo.t && t < hi.t))
            t = 0.5 * (lo.t + hi.t);
        if (!(t > lo.t && t < hi.t))
            break;
        Moment m = moment_at(f, t);
        if (fabs(m.gap) <= 1e-15 * f->size)
            return t;
        if (m.gap > 0) {
            fhi = side > 0 ? 0.5 * fhi : fhi;
            side = 1;
            lo = m;
            flo = m.gap;
        } else {
            flo = side < 0 ? 0.5 * flo : flo;
            side = -1;
            hi = m;
            fhi = m.gap;
        }
        if (fabs(m.gap) <= 1e-13 * f->size)
            return t;
    }
    return fabs(lo.gap) < fabs(hi.gap) ? lo.t : hi.t;
}

/* Within the tolerance already: one more Newton step costs little and often reaches rounding. */
static real finish(Flight *f, Moment m)
{
    if (fabs(m.gap) > 1e-14 * f->size && m.rate > 0) {
        Moment next = moment_at(f, real_clamp(m.t + m.gap / m.rate, 0, f->time));
        if (fabs(next.gap) < fabs(m.gap))
            return next.t;
    }
    return m.t;
}

/* At or below the target at the start: 0 when the gap closes further, else INFINITY. */
static real from_below(Flight *f, const Moment *m)
{
    real turning = vec3_length(f->ma->w) * f->reach_a + vec3_length(f->mb->w) * f->reach_b;
    real speed = vec3_length(f->v) + turning, still = 1e-12 * speed;
    if (m->rate > still)
        return 0;
    if (turning > 0) {                          /* flat on a face, other corners may come down while the nearest point rises */
        real dt = real_min(f->time, 1e-4 * f->size / speed);
        if (moment_at(f, dt).gap < m->gap - 1e-6 * speed * dt)
            return 0;
    }
    return m->rate >= -still && vec3_dot(m->normal, f->acceleration) < 0 ? 0 : INFINITY;
}

/* Where the gap closes now, a Newton step shows its far side; what lies between is closed in on. INFINITY: not yet. */
static real try_bracket(Flight *f, const Moment *m)
{
    real turn = vec3_length(f->ma->w) + vec3_length(f->mb->w);
    if (!(m->rate > 0))
        return INFINITY;
    real step = 1.01 * m->gap / m->rate;
    if (!(step * turn < SMALL_TURN) || m->t + step > f->time)
        return INFINITY;
    Moment next = moment_at(f, m->t + step);
    if (next.gap > 0)
        return INFINITY;
    return close_in(f, *m, next);
}

/* Half of this and no ball inside either shape is stepped over. */
static real core_step(const Flight *f)
{
    real ball = (f->a->inner < INFINITY ? f->a->inner : 0) + (f->b->inner < INFINITY ? f->b->inner : 0);
    real turning = vec3_length(f->ma->w) * f->reach_a + vec3_length(f->mb->w) * f->reach_b;
    real speed = vec3_length(f->v) + vec3_length(f->acceleration) * f->time + turning;
    return speed > 0 ? 0.25 * ball / speed : f->time;
}

static real advance(Flight *f)
{
    Moment m = moment_at(f, 0);
    real tolerance = TOLERANCE * f->size;
    if (m.gap <= tolerance)
        return from_below(f, &m);

    for (int step = 0; step < ALL_STEPS; step++) {
        real h = longest_step(f, &m);
        if (!(h >= 0))
            return INFINITY;                    /* a motion that is not finite meets nothing */
        if (m.t + h > f->time * (1 + 1e-14))
            return INFINITY;
        if (step >= SURE_STEPS)
            h = real_max(h, core_step(f));
        Moment before = m;
        m = moment_at(f, real_min(m.t + h, f->time));
        if (fabs(m.gap) <= tolerance)
            return finish(f, m);
        if (m.gap < 0)
            return close_in(f, before, m);
        if (m.t >= f->time)
            return INFINITY;
        if (step % 3 == 2) {
            real t = try_bracket(f, &m);
            if (t < INFINITY)
                return t;
        }
    }
    return INFINITY;
}

/* Range of x + v t + a t^2 / 2 for t in [0, time]. */
static void path_range(real x, real v, real a, real time, real *low, real *high)
{
    real end = x + (v + 0.5 * a * time) * time, turn = a != 0 ? -v / a : -1;
    *low = real_min(x, end);
    *high = real_max(x, end);
    if (turn > 0 && turn < time) {
        real top = x + 0.5 * v * turn;
        *low = real_min(*low, top);
        *high = real_max(*high, top);
    }
}

static box3 path_box(vec3 x, vec3 v, vec3 a, real time)
{
    box3 b;
    path_range(x.x, v.x, a.x, time, &b.low.x, &b.high.x);
    path_range(x.y, v.y, a.y, time, &b.low.y, &b.high.y);
    path_range(x.z, v.z, a.z, time, &b.low.z, &b.high.z);
    return b;
}

static vec3 centre_between(const Motion *ma, const Motion *mb)
{
    return vec3_sub(pose_point(mb->start, mb->centre), pose_point(ma->start, ma->centre));
}

/* Balls about the centres of mass that stay apart need no further look. */
static bool stays_far(const Flight *f)
{
    real sum = f->reach_a + f->a->round + f->reach_b + f->b->round + f->target;
    if (!(f->a->outer < INFINITY && f->b->outer < INFINITY))
        return false;
    box3 box = path_box(centre_between(f->ma, f->mb), f->v, f->acceleration, f->time);
    vec3 gap = vec3_max(vec3_max(box.low, vec3_neg(box.high)), vec3_zero());
    return vec3_length2(gap) > sum * sum * (1 + 1e-12);
}

static real scale_of(const Shape *s)
{
    return s->inner > 0 ? s->inner : s->outer > 0 ? s->outer : INFINITY;
}

/* What turns a shape about its own axis, on which its centre of mass lies, leaves its surface where it is: a barrel that rolls beside another
 * comes no nearer. The angle between that axis, y of the shape, and w does not change. */
static bool is_round(const Shape *s, const Motion *m)
{
    ShapeKind kind = shape_kind(s);
    return (kind == KIND_CYLINDER || kind == KIND_CAPSULE || kind == KIND_CONE) && m->centre.x == 0 && m->centre.z == 0;
}

static vec3 axis_of(const Motion *m) { return quat_rotate(m->start.q, (vec3){0, 1, 0}); }

static real surface_spin(const Shape *s, const Motion *m) { return vec3_length(is_round(s, m) ? vec3_cross(axis_of(m), m->w) : m->w); }

vec3 motion_sway(const Shape *s, const Motion *m, vec3 at, vec3 out)
{
    vec3 w = m->w, r = vec3_sub(vec3_mad(at, -s->round, out), pose_point(m->start, m->centre));
    if (is_round(s, m))
        w = vec3_mad(w, -vec3_dot(axis_of(m), w), axis_of(m));
    return vec3_cross(w, vec3_cross(w, r));
}

static real convex_impact(const Shape *a, const Motion *ma, const Shape *b, const Motion *mb, real target, real time, int *iterations)
{
    Flight f = {.a = a, .b = b, .ma = ma, .mb = mb, .target = target, .time = time, .size = real_min(scale_of(a), scale_of(b)),
                .reach_a = core_reach(a, ma->centre), .reach_b = core_reach(b, mb->centre),
                .spin_a = surface_spin(a, ma), .spin_b = surface_spin(b, mb), .turns = sqrt(real_max(vec3_length2(ma->w), vec3_length2(mb->w))),
                .v = vec3_sub(mb->v, ma->v), .acceleration = vec3_sub(mb->a, ma->a)};
    if (stays_far(&f))
        return INFINITY;
    real t = advance(&f);
    *iterations += f.count;
    return t;
}

/* ---- surfaces: the first of their pieces ---- */

typedef struct SurfaceFlight { const Motion *ma; const Shape *b; const Motion *mb; real target, first; int *iterations; } SurfaceFlight;

static bool take_piece(void *context, const SurfacePiece *piece)
{
    SurfaceFlight *s = context;
    Shape triangle = triangle_shape(piece->corners);
    Motion m = *s->ma;
    m.start.p = pose_point(m.start, piece->origin);
    m.centre = vec3_sub(m.centre, piece->origin);
    s->first = real_min(s->first, convex_impact(&triangle, &m, s->b, s->mb, s->target, s->first, s->iterations));
    return s->first > 0;
}

/* Where b goes in `time`, in the frame of the surface at its start; everything when the surface turns. */
static box3 swept_box(const Shape *a, const Motion *ma, const Shape *b, const Motion *mb, real target, real time)
{
    if (vec3_length2(ma->w) > 0)
        return a->type->bounds(a, pose_identity());
    quat back = quat_conjugate(ma->start.q);
    vec3 x = pose_unpoint(ma->start, pose_point(mb->start, mb->centre));
    vec3 v = quat_rotate(back, vec3_sub(mb->v, ma->v)), acceleration = quat_rotate(back, vec3_sub(mb->a, ma->a));
    return box3_grow(path_box(x, v, acceleration, time), core_reach(b, mb->centre) + b->round + target);
}

/* A long path is cut: a box about all of it would hold far too many pieces. */
static real surface_impact(const Shape *a, const Motion *ma, const Shape *b, const Motion *mb, real target, real time, int *iterations)
{
    real speed = vec3_length(vec3_sub(mb->v, ma->v)) + vec3_length(vec3_sub(mb->a, ma->a)) * time;
    real parts = ceil(speed * time / (4 * b->outer));
    int count = (int)real_clamp(parts, 1, SLICES);
    for (int i = 0; i < count; i++) {
        real t0 = time * i / count, t1 = time * (i + 1) / count;
        Motion la = motion_from(ma, t0), lb = motion_from(mb, t0);
        SurfaceFlight s = {&la, b, &lb, target, t1 - t0, iterations};
        box3 box = swept_box(a, &la, b, &lb, target, t1 - t0);
        real before = s.first = nextafter(s.first, INFINITY);
        surface_visit(a, box, take_piece, &s);
        if (s.first < before)
            return real_min(t0 + s.first, time);
    }
    return INFINITY;
}

real time_of_impact(const Shape *a, const Motion *ma, const Shape *b, const Motion *mb, real target, real time, int *iterations)
{
    int count = 0;
    int *counted = iterations ? iterations : &count;
    ShapeKind ka = shape_kind(a), kb = shape_kind(b);
    *counted = 0;
    if (!kinds_meet(a, ka, b, kb) || !(time >= 0))
        return INFINITY;
    if (in_pieces(ka, kb))
        return surface_impact(a, ma, b, mb, target, time, counted);
    if (in_pieces(kb, ka))
        return surface_impact(b, mb, a, ma, target, time, counted);
    return convex_impact(a, ma, b, mb, target, time, counted);
}

bool surface_crossed(const Shape *a, const Motion *ma, const Shape *b, const Motion *mb, real time)
{
    if (a->type->convex == b->type->convex)
        return false;
    if (a->type->convex)
        return surface_crossed(b, mb, a, ma, time);
    vec3 middle = shape_middle(b);
    vec3 from = pose_unpoint(ma->start, pose_point(mb->start, middle)), to = pose_unpoint(motion_at(ma, time), pose_point(motion_at(mb, time), middle));
    CastHit hit;
    return cast_ray(a, pose_identity(), from, vec3_sub(to, from), 1, &hit);
}
