/* trace/happen.c - what happens within a step, and when: events and the roots of their functions.
 *
 * The kinds are frozen while a step is tried, so that every function is smooth, beyond its event too. An event's root is
 * found on the dense output; then the step is made anew with that length, and its length corrected until the function itself
 * is zero.
 */
#include "base/bracket.h"
#include "math/pair.h"
#include "trace/trace.h"

#define NOTHING     1e-12       /* of the least force that counts: rounding is more */
#define BELOW       1e-9        /* of the scale: force and acceleration tests, as in kinds.c    */
#define SUDDEN      1e-6        /* of the frame: what begins to slip and stops within less did not slip */
#define PASSES      60
#define SMOOTH_PASSES 8         /* of these: a smooth function needs no more */
#define CORRECTIONS 6
static const real samples[] = {0.25, 0.5, 0.75, 1};

/* Where the kind is known the compiler leaves the one case. */
INLINE real value_of(const Tracer *t, const Event *e)
{
    switch (e->kind) {
    case EVENT_CLOSE: return e->gate->gap;
    case EVENT_OPEN: return e->gate->force;
    case EVENT_PRESS: return e->gate->acc;
    case EVENT_YIELD: return e->hold ? e->hold->most - fabs(e->hold->force) : cone_hold(e->cone, e->normal->force) - vec3_length(e->cone->force);
    case EVENT_HALT: return e->hold ? e->hold->side * (e->hold->target - e->hold->rate) : vec3_dot(e->cone->u, e->cone->from);
    case EVENT_GRIP: return vec3_dot(e->cone->acc, e->cone->d);
    case EVENT_BREAK: return e->bond->strength - trace_load_on(t, e->bond->joint);
    default: return 0;
    }
}

static bool needs_forces(EventKind k) { return k != EVENT_CLOSE && k != EVENT_HALT; }

/* Where the bodies of a point are at a part of the tried step, of which nothing else is looked at. many: of all points of its contact */
static void place_both(const Tracer *t, const Touching *c, real part, bool many, Pos *a, Pos *b)
{
    *a = trace_place(t, c->a, part, many || feature_turns(&c->feature, false));
    *b = trace_place(t, c->b, part, many || feature_turns(&c->feature, true));
}

/* m  The gap there. */
static real gap_at(const Tracer *t, const Touching *c, real part)
{
    Pos a, b;
    place_both(t, c, part, false, &a, &b);
    return feature_gap(&c->feature, &a, &b);
}

/* The event's function at a part of the tried step. */
static real value_at(Tracer *t, const Event *e, real part)
{
    if (e->touch)
        return gap_at(t, e->touch, part);
    trace_dense(t, part, t->y2);
    trace_load(t, t->y2, t->t + part * t->h);
    trace_kinematics(t);
    if (needs_forces(e->kind)) {
        t->g->evaluations++;
        trace_follow(t);        /* else friction would point as at the end of the step: forces would jump where slips are slow */
        if (!trace_accelerate(t))
            return NAN;
    }
    return value_of(t, e);
}

#define TOLD 1e-10              /* of what pressed, or holds: the step made anew up to where that ends finds it no better */

/* What of an event's function is as good as none. Rows that repeat others may share their load to 1e-9 of it, no better: what has not come to an end
 * after so many passes finds nothing below that. */
static real rounding_of(const Tracer *t, const Event *e, int pass)
{
    bool slip = e->kind == EVENT_HALT && e->cone, yields = e->kind == EVENT_YIELD && e->cone;
    real least = pass > SMOOTH_PASSES && t->sys.redundant && (e->kind == EVENT_OPEN || yields) ? BELOW * t->gate_most : 0;
    if (e->kind == EVENT_OPEN)
        return real_max(least, real_max(NOTHING * t->gate_least, TOLD * e->gate->force0));
    if (yields)
        return real_max(least, TOLD * cone_hold(e->cone, e->normal->force));
    return e->kind == EVENT_CLOSE ? 1e-15 * t->size : slip ? 1e-15 * t->size * t->pace : 0;
}

#define NARROW 1e-12            /* of the step: of forces that are rounding no more is told of when they end */

/* False position with a bisection every eighth pass; f(lo) > 0 >= f(hi). */
static real root_of(Tracer *t, const Event *e, real lo, real flo, real hi, real fhi)
{
    Bracket b = {lo, hi, flo, fhi, 0};
    real narrow = needs_forces(e->kind) && e->kind != EVENT_BREAK ? NARROW : 0;
    for (int pass = 1; pass <= PASSES && b.hi - b.lo > real_max(4e-16 * b.hi, narrow); pass++) {
        real x = pass % 8 == 0 ? 0.5 * (b.lo + b.hi) : b.lo + (b.hi - b.lo) * b.at_lo / (b.at_lo - b.at_hi);
        if (!(x > b.lo && x < b.hi))
            x = 0.5 * (b.lo + b.hi);
        real f = value_at(t, e, x);
        if (!isfinite(f))
            return b.hi;
        bracket_put(&b, x, f);
        if (fabs(f) <= rounding_of(t, e, pass))
            return x;
    }
    return b.hi;
}

static void earlier(Event *first, const Event *e)
{
    if (e->at < first->at || first->kind == EVENT_NONE)
        *first = *e;
}

/* ---- gates ---- */

/* An open gate meets at the first sign change after its gap was positive. */
static void find_closing(Tracer *t, Gate *g, const Touching *touch, const real gaps[4], Event *first)
{
    Event e = {.kind = EVENT_CLOSE, .gate = g, .touch = touch};
    int k = 0;
    while (k < 4 && gaps[k] > 0)
        k++;
    if (k == 4)
        return;
    real hi = samples[k], fhi = gaps[k], lo = k > 0 ? samples[k - 1] : 0, flo = k > 0 ? gaps[k - 1] : g->gap0;
    /* from touch, leaving: half of the predicted flight is certainly in the air */
    if (k == 0 && g->gap0 <= t->gap_zero && g->rate0 > 0)
        flo = 0;
    real flight = g->acc0 < 0 ? -g->rate0 / g->acc0 / t->h : 0;
    for (real x = flight > 0 && flight < hi ? flight : 0.5 * hi; k == 0 && flo <= 0 && x > 1e-12; x *= 0.5) {
        real f = value_at(t, &e, x);
        if (f > 0) {
            lo = x;
            flo = f;
        } else {
            hi = x;
            fhi = f;
        }
    }
    if (!(flo > 0)) {
        if (gaps[3] < -t->gap_zero)
            earlier(first, &(Event){.kind = EVENT_SHORTER, .at = 0});
        return;
    }
    e.at = root_of(t, &e, lo, flo, hi, fhi);
    earlier(first, &e);
}

/* s  When a gap that is not negative will be none, under a constant acceleration; after it was none, if it is now. INFINITY: never. */
static real meets(real gap, real rate, real acc)
{
    real d = rate * rate - 2 * acc * gap;
    if (d < 0 || !(rate < 0 || acc < 0))
        return INFINITY;
    return rate < 0 ? 2 * gap / (sqrt(d) - rate) : (rate + sqrt(d)) / -acc;
}

#define PAST (1 + 1.0 / 512)    /* times the time to where it will meet */
#define FORESEEN 0.25           /* rad: what turns farther gets there at another time */

static real fastest_turn(const Tracer *t, const Touching *c) { return real_max(vec3_length(t->g->vel[c->a].w), vec3_length(t->g->vel[c->b].w)); }

/* Of a step over a blow all beyond that is in vain, and a short one may have forces that are constant. */
real trace_aim(const Tracer *t, real h)
{
    if (trace_steady(t, h))
        return h;
    for (int i = 0; i < t->touch_count; i++) {
        const Touching *c = &t->touch[i];
        if (c->gate.closed || c->gate.presses || !(c->gate.gap >= -t->gap_zero))
            continue;
        real at = meets(real_max(c->gate.gap, 0), c->gate.rate, trace_gap_acceleration(t, c));
        if (at > 0 && PAST * at < h && at * fastest_turn(t, c) < FORESEEN)
            h = PAST * at;
    }
    return h;
}

/* Under constant accelerations the gap of what does not turn, or of a ball, over a fixed plane follows a parabola: where that meets, and whether,
 * its rates at both ends of the step tell. False: they do not. */
static bool on_parabola(Tracer *t, Gate *g, const Touching *c, Event *first)
{
    const Feature *f = &c->feature;
    bool plane_a = f->kind == PLANE_POINT, follows = t->probed && f->fixed && !feature_turns(f, plane_a) && g->gap0 >= -t->gap_zero;
    if (!follows || (g->gap > 0 && g->rate0 < 0 && g->rate > 0))
        return false;
    if (g->gap > 0)
        return true;
    Event e = {.kind = EVENT_CLOSE, .gate = g, .touch = c};
    e.at = meets(real_max(g->gap0, 0), g->rate0, (g->rate - g->rate0) / t->h) / t->h;
    if (!(e.at > 0 && e.at <= 1 && fabs(value_at(t, &e, e.at)) <= rounding_of(t, &e, 1)))
        return false;
    earlier(first, &e);
    return true;
}

typedef struct Watch { Gate *gate; const Touching *touch; real gaps[4]; } Watch;       /* touch: NULL of a stop */

/* Points of a contact follow each other, and have the same two bodies. */
static void sample_touches(const Tracer *t, Watch *w, int count, int s)
{
    Pos a, b;
    for (int i = 0; i < count; i++) {
        const Touching *c = w[i].touch;
        bool same = i > 0 && w[i - 1].touch->contact == c->contact, more = i + 1 < count && w[i + 1].touch->contact == c->contact;
        if (!same)
            place_both(t, c, samples[s], more, &a, &b);
        w[i].gaps[s] = feature_gap(&c->feature, &a, &b);
    }
}

/* Could it have met within the step, by its rates at both ends? */
static bool watched(const Tracer *t, const Gate *g)
{
    real reach = 2 * t->h * real_max(fabs(g->rate0), fabs(g->rate)) + t->h * t->h * fabs(g->acc0);
    return !g->closed && isfinite(g->gap) && (g->gap <= 0 || g->gap0 <= reach || g->gap <= reach);
}

static int list_watched(Tracer *t, Watch *w, int *touches, Event *first)
{
    int n = 0;
    for (int i = 0; i < t->touch_count; i++)
        if (watched(t, &t->touch[i].gate) && !on_parabola(t, &t->touch[i].gate, &t->touch[i], first))
            w[n++] = (Watch){.gate = &t->touch[i].gate, .touch = &t->touch[i]};
    *touches = n;
    for (int i = 0; i < t->stop_count; i++)
        if (watched(t, &t->stops[i].gate))
            w[n++] = (Watch){.gate = &t->stops[i].gate};
    return n;
}

static void scan_gaps(Tracer *t, Event *first)
{
    Watch w[WATCHED];
    if (t->known != t->y1) {        /* forces and turns were looked for elsewhere in the step: gaps there are not those of its end */
        trace_load(t, t->y1, t->t + t->h);
        trace_kinematics(t);
    }
    int touches, n = list_watched(t, w, &touches, first);
    for (int i = 0; i < n; i++)
        w[i].gaps[3] = w[i].gate->gap;
    for (int s = 0; s < 3; s++)
        sample_touches(t, w, touches, s);
    for (int s = 0; s < 3 && n > touches; s++) {
        trace_dense(t, samples[s], t->y2);
        trace_load(t, t->y2, t->t + samples[s] * t->h);
        trace_kinematics(t);
        for (int i = touches; i < n; i++)
            w[i].gaps[s] = w[i].gate->gap;
    }
    if (n > 0 && !t->probed)
        t->known = NULL;        /* there the end is made a unit once more */
    for (int i = 0; i < n && !(first->kind == EVENT_SHORTER && first->at <= 0); i++)        /* none comes before that */
        find_closing(t, w[i].gate, w[i].touch, w[i].gaps, first);
}

/* ---- forces and speeds, at the end of the step ---- */

typedef struct Violated { Event e; int contact; real start, end; } Violated;     /* contact: -1 of a joint */

INLINE void note(const Tracer *t, Violated *list, int *n, Event e, int contact, real below)
{
    real end = value_of(t, &e);
    if (end < -below)
        list[(*n)++] = (Violated){e, contact, NAN, end};
}

static int list_violated(Tracer *t, Violated *v)
{
    int n = 0;
    real force_zero = BELOW * t->gate_most, acc_zero = BELOW * (t->g->fall + t->size * t->pace * t->pace);
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        if (c->gate.presses)
            note(t, v, &n, (Event){.kind = EVENT_OPEN, .gate = &c->gate}, c->contact, force_zero);
        else if (c->gate.closed)
            note(t, v, &n, (Event){.kind = EVENT_PRESS, .gate = &c->gate}, c->contact, acc_zero);
        Cone *both[2] = {&c->slip, &c->roll};
        for (int k = 0; k < 2 && c->gate.presses; k++) {
            if (!both[k]->axes)
                continue;
            Event e = {.kind = both[k]->grip == GRIP_STICK ? EVENT_YIELD : both[k]->grip == GRIP_SLIP ? EVENT_HALT : EVENT_GRIP,
                       .cone = both[k], .normal = &c->gate};
            real unit = k ? t->size : 1;
            note(t, v, &n, e, c->contact, e.kind == EVENT_YIELD ? force_zero * unit : e.kind == EVENT_GRIP ? acc_zero / unit : 0);
        }
    }
    for (int i = 0; i < t->stop_count; i++) {
        Gate *g = &t->stops[i].gate;
        if (g->presses)
            note(t, v, &n, (Event){.kind = EVENT_OPEN, .gate = g}, -1, force_zero);
        else if (g->closed)
            note(t, v, &n, (Event){.kind = EVENT_PRESS, .gate = g}, -1, acc_zero);
    }
    for (int i = 0; i < t->hold_count; i++) {
        Hold *h = &t->holds[i];
        note(t, v, &n, (Event){.kind = h->side ? EVENT_HALT : EVENT_YIELD, .hold = h}, -1, h->side ? 0 : BELOW * h->most);
    }
    return n;
}

/* A slip that turned round through a side has not stopped. */
static void finish_halt(Tracer *t, Event *e)
{
    if (e->kind != EVENT_HALT || !e->cone)
        return;
    value_at(t, e, e->at);
    if (vec3_length(e->cone->u) > t->slip_zero)
        *e = (Event){.kind = EVENT_SHORTER, .at = 0};
}

/* A slip that begins in this step may end in it, too: its speed is none at the start, and its end is not there. Returns its speed at
 * a sample before the first turn, or sets the step to be shorter. */
static real leave_rest(Tracer *t, Event *e, real *from)
{
    for (int s = 2; s >= 0; s--) {
        real speed = value_at(t, e, samples[s]);
        if (speed > 0) {
            *from = samples[s];
            return speed;
        }
    }
    if (t->h > SUDDEN * t->end)
        e->kind = EVENT_SHORTER;
    return 0;
}

/* What touched and did not press, as the corner that a block rocks over after its blow, may have lifted off by its turn when something begins to
 * push it back: it is open then, and closes when it gets there. */
static bool lifted_off(Tracer *t, const Event *e)
{
    if (e->kind != EVENT_PRESS || !(e->at > 0) || !(value_at(t, &(Event){.kind = EVENT_CLOSE, .gate = e->gate}, e->at) > t->gap_zero))
        return false;
    e->gate->closed = false;
    return true;
}

#define LAST 1e-6               /* of the load on a contact as the step began: the last of it, see open_near in kinds.c */

/* N  The most that pressed a point of it at the start of the step. */
static real load_at_start(const Tracer *t, int contact)
{
    real most = 0;
    for (int i = 0; i < t->touch_count; i++)
        if (t->touch[i].contact == contact && t->touch[i].gate.presses)
            most = real_max(most, t->touch[i].gate.force0);
    return most;
}

/* Is it not yet so where another one is known to happen? Then its root, which takes a score of evaluations, is of no use. Where a contact lets go,
 * all its points do, and with the last of its force goes that of its friction: none of these comes before. contact: that of the first; -1: none */
static bool is_later(Tracer *t, const Violated *v, const Event *first, int contact)
{
    if (first->kind == EVENT_NONE || first->kind == EVENT_SHORTER || !needs_forces(v->e.kind))
        return false;
    bool same = first->kind == EVENT_OPEN && contact >= 0 && v->contact == contact && (v->e.kind == EVENT_OPEN || v->e.kind == EVENT_YIELD);
    return value_at(t, &v->e, first->at) > (same ? -LAST * load_at_start(t, contact) : 0);
}

/* Does it only get less that points the other way? What begins to slide may have a little speed left from before, too slow to count: gone within less
 * than this step, or in the next. That is not the end of the slip that begins. */
static bool is_left_over(const Violated *v) { return v->e.kind == EVENT_HALT && v->e.cone && v->start < v->end; }

/* The functions of all of them at the start of the step, by one evaluation. */
static void find_starts(Tracer *t, Violated *v, int n)
{
    bool forces = false;
    for (int i = 0; i < n; i++)
        forces = forces || needs_forces(v[i].e.kind);
    Event e = {.kind = forces ? EVENT_OPEN : EVENT_CLOSE, .gate = &(Gate){.gap = 0}};
    bool failed = n > 0 && !isfinite(value_at(t, &e, 0));
    for (int i = 0; i < n; i++)
        v[i].start = failed && needs_forces(v[i].e.kind) ? NAN : value_of(t, &v[i].e);
}

static void scan_forces(Tracer *t, Event *first)
{
    Violated v[3 * WATCHED];        /* a contact point has a gate and two cones */
    int n = list_violated(t, v), contact = -1;
    find_starts(t, v, n);
    for (int i = 0; i < n && !(first->kind != EVENT_NONE && first->at <= 0); i++) {         /* none comes before that */
        if (is_left_over(&v[i]) || is_later(t, &v[i], first, contact))
            continue;
        real from = 0, start = v[i].start;
        if (!(start > 0) && v[i].e.kind == EVENT_HALT && v[i].e.cone)
            start = leave_rest(t, &v[i].e, &from);
        v[i].e.at = start > 0 ? root_of(t, &v[i].e, from, start, 1, v[i].end) : 0;
        finish_halt(t, &v[i].e);
        if (lifted_off(t, &v[i].e))
            continue;
        earlier(first, &v[i].e);
        contact = first->at == v[i].e.at && first->gate == v[i].e.gate ? v[i].contact : contact;
    }
}

/* A slip that stops and turns back may have its old direction again at the end of the step. */
static void scan_turns(Tracer *t, Event *first)
{
    Event list[WATCHED];
    int n = 0;
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        real turn = 2 * t->h * vec3_length(c->slip.acc);
        if (c->gate.presses && c->slip.axes && c->slip.grip == GRIP_SLIP && vec3_length(c->slip.u) < turn)
            list[n++] = (Event){.kind = EVENT_HALT, .cone = &c->slip, .normal = &c->gate};
    }
    for (int i = 0; i < n; i++)
        for (int s = 0; s < 3; s++) {
            real end = value_at(t, &list[i], samples[s]), start;
            if (!(end < 0) || !((start = value_at(t, &list[i], s > 0 ? samples[s - 1] : 0)) > 0))
                continue;
            list[i].at = root_of(t, &list[i], s > 0 ? samples[s - 1] : 0, start, samples[s], end);
            finish_halt(t, &list[i]);
            earlier(first, &list[i]);
            break;
        }
}

/* ---- joints that break ---- */

#define UNLOADED 0.1            /* of the strength: a load this small at both ends of a step did not get over it in between */
#define SETTLED  0.9            /* the same where accelerations are constant */
#define NEAR     0.8            /* of the strength: whether the peak of such a load is over it is looked at more closely */
#define PEAKS    6

/* The load may have its peak within the step: its three largest samples in a row are followed to the top of their parabola. */
static bool find_peak(Tracer *t, const Event *e, const real value[5], real *top)
{
    static const real at[5] = {0, 0.25, 0.5, 0.75, 1};
    int k = 1;
    for (int i = 2; i < 4; i++)
        k = value[i] < value[k] ? i : k;
    real x[3] = {at[k - 1], at[k], at[k + 1]}, f[3] = {value[k - 1], value[k], value[k + 1]};
    for (int pass = 0; pass < PEAKS && f[1] > 0 && f[1] < (1 - NEAR) * e->bond->strength; pass++) {
        real p = (x[1] - x[0]) * (f[1] - f[2]), q = (x[1] - x[2]) * (f[1] - f[0]);
        real y = x[1] - 0.5 * ((x[1] - x[0]) * p - (x[1] - x[2]) * q) / (p - q);
        if (!(y > x[0] && y < x[2]) || fabs(y - x[1]) < 1e-6)
            return false;
        real v = value_at(t, e, y);
        int side = y > x[1] ? 0 : 2;            /* the sample that is left behind, or the new one is the new bound */
        if (v < f[1]) {
            x[side] = x[1];
            f[side] = f[1];
            x[1] = y;
            f[1] = v;
        } else {
            x[2 - side] = y;
            f[2 - side] = v;
        }
    }
    *top = x[1];
    return f[1] <= 0;
}

static void find_break(Tracer *t, const Bond *b, Event *first)
{
    static const real at[5] = {0, 0.25, 0.5, 0.75, 1};
    Event e = {.kind = EVENT_BREAK, .bond = b};
    real value[5] = {[0] = b->strength - b->start, [4] = b->strength - b->end};
    if (value[0] < -BELOW * b->strength) {      /* at once; of several the one that is loaded the most */
        if (first->kind != EVENT_BREAK || first->at > 0 || first->bond->start / first->bond->strength < b->start / b->strength)
            *first = e;
        return;
    }
    real most = real_max(b->start, b->end) / b->strength, top;
    if (most < UNLOADED || (t->probed && most < SETTLED))
        return;
    int k = 1;
    for (; k < 4 && !((value[k] = value_at(t, &e, at[k])) <= 0); k++);
    if (k < 4 || value[4] < -BELOW * b->strength) {
        real lo = real_max(value[k - 1], 0);
        e.at = lo > 0 ? root_of(t, &e, at[k - 1], lo, at[k], value[k]) : at[k - 1];
    } else if (find_peak(t, &e, value, &top)) {
        e.at = root_of(t, &e, 0, value[0], top, value_at(t, &e, top));
    } else {
        return;
    }
    earlier(first, &e);
}

static void scan_breaks(Tracer *t, Event *first)
{
    int before = t->g->evaluations;
    for (int i = 0; i < t->bond_count; i++)
        find_break(t, &t->bonds[i], first);
    if (t->g->evaluations == before || first->kind != EVENT_NONE)
        return;
    trace_load(t, t->y1, t->t + t->h);          /* the step is accepted with the forces at its end */
    trace_kinematics(t);
    t->g->evaluations++;
    trace_follow(t);
    trace_accelerate(t);
}

Event trace_scan(Tracer *t)
{
    Event first = {.kind = EVENT_NONE};
    for (int i = 0; i < t->bond_count; i++)
        t->bonds[i].end = trace_load_on(t, t->bonds[i].joint);
    scan_forces(t, &first);         /* first: the forces at the end are still those of the last evaluation */
    scan_turns(t, &first);
    scan_gaps(t, &first);
    scan_breaks(t, &first);
    return first;
}

/* ---- cutting the step ---- */

/* 1/s  How fast the event's function falls at the root that the dense output has. */
static real slope_at(Tracer *t, const Event *e)
{
    if (e->kind == EVENT_CLOSE)         /* at the end of what was just tried */
        return e->gate->rate != 0 ? e->gate->rate : -1;
    real back = real_min(1e-3, 0.5 * e->at);
    return (value_at(t, e, e->at) - value_at(t, e, e->at - back)) / (back * t->h);
}

/* Those located to the last digit: not by the dense output alone. */
static bool exact(EventKind k) { return k == EVENT_CLOSE || k == EVENT_BREAK; }

/* s  The dense output may be off by so much that a force is not quite gone at the end of the step made anew: its points would press on, and their
 * friction yield next. By so much longer the step ends just past that. */
static real time_to_let_go(const Event *e, real force, real h)
{
    real gone = e->kind == EVENT_OPEN ? e->gate->force0 - force : 0;
    return force > 0 && gone > 0 ? 2 * force * h / gone : 0;
}

#define NEARLY (1 - 1.0 / 128)  /* of the step: off its end the dense output is off by the square of what is left times its own error */

/* Of the cut step, in tolerances. Its end may be where a corner gives way to another: a stage of it then presses at a point that the step was not tried
 * with, and what came of that was believed. Where a slip ends, the last stage may be past that, by up to some thousands; all but what
 * meets or breaks may be so rough. */
#define ROUGH_MOST 1e4

real trace_stop_at(Tracer *t, const Event *e)
{
    real whole = t->h, h = e->at * whole;
    bool at_end = e->kind == EVENT_CLOSE && e->at >= NEARLY;
    if (t->probed || at_end) {      /* exact at any part, or there */
        trace_dense(t, e->at, t->probed ? t->y1 : t->y2);
        if (!t->probed)
            trace_cut(t, e->at);
        t->h = h;
        trace_load(t, t->y1, t->t + h);
        return 0;
    }
    real before = NAN, last = NAN, first_slope = e->kind == EVENT_BREAK && h > 0 ? slope_at(t, e) : NAN;
    real enough = e->kind == EVENT_BREAK ? 1e-14 * e->bond->strength : 1e-15 * t->size;
    t->probe_wait = int_max(t->probe_wait, 1);
    for (int i = 0; i < CORRECTIONS; i++) {
        if (!(h > 0)) {
            memcpy(t->y1, t->y, (size_t)t->g->moving_count * sizeof *t->y);
            t->h = 0;
            trace_load(t, t->y1, t->t);
            return 0;
        }
        real error = trace_try(t, h);
        if (!(error <= (exact(e->kind) ? 1 : ROUGH_MOST)))
            return error;
        real f = value_of(t, e);
        real more = time_to_let_go(e, f, h);
        if (more > 0 && h + more <= whole && !trace_stretch(t, more)) {
            h += more;
            continue;
        }
        if (!exact(e->kind) || fabs(f) <= enough || f == last)
            break;
        real slope = !isnan(last) ? (f - last) / (h - before) : !isnan(first_slope) ? first_slope : slope_at(t, e);
        before = h;
        last = f;
        real next = h - f / slope;
        if (!(next > 0 && next <= whole) || fabs(next - h) < 1e-17)
            break;
        if (e->kind == EVENT_CLOSE && trace_stretch(t, next - h))
            break;              /* nothing is left to correct */
        h = next;
    }
    return 0;
}
