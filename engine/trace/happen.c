/* trace/happen.c - what happens within a step, and when: events and the roots of their functions.
 *
 * The kinds are frozen while a step is tried, so that every function is smooth, beyond its event too. An event's root is
 * found on the dense output; then the step is made anew with that length, and its length corrected until the function itself
 * is zero.
 */
#include "trace/trace.h"

#define BELOW       1e-9        /* of the scale: force and acceleration tests, as in kinds.c    */
#define PASSES      60
#define CORRECTIONS 6
static const real samples[] = {0.25, 0.5, 0.75, 1};

static real value_of(const Event *e)
{
    switch (e->kind) {
    case EVENT_CLOSE: return e->gate->gap;
    case EVENT_OPEN: return e->gate->force;
    case EVENT_PRESS: return e->gate->acc;
    case EVENT_YIELD: return e->hold ? e->hold->most - fabs(e->hold->force) : e->cone->still * e->normal->force - vec3_length(e->cone->force);
    case EVENT_HALT: return e->hold ? e->hold->side * (e->hold->target - e->hold->rate) : vec3_dot(e->cone->u, e->cone->from);
    case EVENT_GRIP: return vec3_dot(e->cone->acc, e->cone->d);
    default: return 0;
    }
}

static bool needs_forces(EventKind k) { return k == EVENT_OPEN || k == EVENT_PRESS || k == EVENT_YIELD || k == EVENT_GRIP; }

/* The event's function at a part of the tried step. */
static real value_at(Tracer *t, const Event *e, real part)
{
    trace_dense(t, part, t->y2);
    trace_load(t, t->y2, t->t + part * t->h);
    trace_kinematics(t);
    if (needs_forces(e->kind)) {
        t->g->evaluations++;
        if (!trace_accelerate(t))
            return NAN;
    }
    return value_of(e);
}

/* Illinois false position with a bisection every eighth pass; f(lo) > 0 >= f(hi). */
static real root_of(Tracer *t, const Event *e, real lo, real flo, real hi, real fhi)
{
    real enough = e->kind == EVENT_CLOSE ? 1e-15 * t->size : 0;
    int side = 0;
    for (int pass = 1; pass <= PASSES && hi - lo > 4e-16 * hi; pass++) {
        real x = pass % 8 == 0 ? 0.5 * (lo + hi) : lo + (hi - lo) * flo / (flo - fhi);
        if (!(x > lo && x < hi))
            x = 0.5 * (lo + hi);
        real f = value_at(t, e, x);
        if (!isfinite(f))
            return hi;
        if (f > 0) {
            lo = x;
            flo = f;
            fhi *= side == 1 ? 0.5 : 1;
            side = 1;
        } else {
            hi = x;
            fhi = f;
            flo *= side == -1 ? 0.5 : 1;
            side = -1;
        }
        if (fabs(f) <= enough)
            return x;
    }
    return hi;
}

static void earlier(Event *first, const Event *e)
{
    if (e->at < first->at || first->kind == EVENT_NONE)
        *first = *e;
}

/* ---- gates ---- */

/* An open gate meets at the first sign change after its gap was positive. */
static void find_closing(Tracer *t, Gate *g, const real gaps[4], Event *first)
{
    Event e = {.kind = EVENT_CLOSE, .gate = g};
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

typedef struct Watch { Gate *gate; real gaps[4]; } Watch;

/* Could it have met within the step, by its rates at both ends? */
static bool watched(const Tracer *t, const Gate *g)
{
    real reach = 2 * t->h * real_max(fabs(g->rate0), fabs(g->rate)) + t->h * t->h * fabs(g->acc0);
    return !g->closed && isfinite(g->gap) && (g->gap <= 0 || g->gap0 <= reach || g->gap <= reach);
}

static int list_watched(Tracer *t, Watch *w)
{
    int n = 0;
    for (int i = 0; i < t->touch_count; i++)
        if (watched(t, &t->touch[i].gate))
            w[n++].gate = &t->touch[i].gate;
    for (int i = 0; i < t->stop_count; i++)
        if (watched(t, &t->stops[i].gate))
            w[n++].gate = &t->stops[i].gate;
    return n;
}

static void scan_gaps(Tracer *t, Event *first)
{
    Watch w[WATCHED];
    int n = list_watched(t, w);
    for (int i = 0; i < n; i++)
        w[i].gaps[3] = w[i].gate->gap;
    for (int s = 0; s < 3 && n > 0; s++) {
        trace_dense(t, samples[s], t->y2);
        trace_load(t, t->y2, t->t + samples[s] * t->h);
        trace_kinematics(t);
        for (int i = 0; i < n; i++)
            w[i].gaps[s] = w[i].gate->gap;
    }
    for (int i = 0; i < n; i++)
        find_closing(t, w[i].gate, w[i].gaps, first);
}

/* ---- forces and speeds, at the end of the step ---- */

typedef struct Violated { Event e; real end; } Violated;

static void note(Violated *list, int *n, Event e, real below)
{
    real end = value_of(&e);
    if (end < -below)
        list[(*n)++] = (Violated){e, end};
}

static int list_violated(Tracer *t, Violated *v)
{
    int n = 0;
    real force_zero = BELOW * t->gate_most, acc_zero = BELOW * (vec3_length(t->g->gravity) + t->size * t->pace * t->pace);
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        if (c->gate.presses)
            note(v, &n, (Event){.kind = EVENT_OPEN, .gate = &c->gate}, force_zero);
        else if (c->gate.closed)
            note(v, &n, (Event){.kind = EVENT_PRESS, .gate = &c->gate}, acc_zero);
        Cone *both[2] = {&c->slip, &c->roll};
        for (int k = 0; k < 2 && c->gate.presses; k++) {
            if (!both[k]->axes)
                continue;
            Event e = {.kind = both[k]->grip == GRIP_STICK ? EVENT_YIELD : both[k]->grip == GRIP_SLIP ? EVENT_HALT : EVENT_GRIP,
                       .cone = both[k], .normal = &c->gate};
            real unit = k ? t->size : 1;
            note(v, &n, e, e.kind == EVENT_YIELD ? force_zero * unit : e.kind == EVENT_GRIP ? acc_zero / unit : 0);
        }
    }
    for (int i = 0; i < t->stop_count; i++) {
        Gate *g = &t->stops[i].gate;
        if (g->presses)
            note(v, &n, (Event){.kind = EVENT_OPEN, .gate = g}, force_zero);
        else if (g->closed)
            note(v, &n, (Event){.kind = EVENT_PRESS, .gate = g}, acc_zero);
    }
    for (int i = 0; i < t->hold_count; i++) {
        Hold *h = &t->holds[i];
        note(v, &n, (Event){.kind = h->side ? EVENT_HALT : EVENT_YIELD, .hold = h}, h->side ? 0 : BELOW * h->most);
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

static void scan_forces(Tracer *t, Event *first)
{
    Violated v[3 * WATCHED];        /* a contact point has a gate and two cones */
    int n = list_violated(t, v);
    for (int i = 0; i < n; i++) {
        real start = value_at(t, &v[i].e, 0);
        v[i].e.at = start > 0 ? root_of(t, &v[i].e, 0, start, 1, v[i].end) : 0;
        finish_halt(t, &v[i].e);
        earlier(first, &v[i].e);
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

Event trace_scan(Tracer *t)
{
    Event first = {.kind = EVENT_NONE};
    scan_forces(t, &first);         /* first: the forces at the end are still those of the last evaluation */
    scan_turns(t, &first);
    scan_gaps(t, &first);
    return first;
}

/* ---- cutting the step ---- */

bool trace_stop_at(Tracer *t, const Event *e)
{
    real whole = t->h, h = e->at * whole;
    if (t->probed) {                /* exact at any part */
        trace_dense(t, e->at, t->y1);
        t->h = h;
        trace_load(t, t->y1, t->t + h);
        return true;
    }
    real before = NAN, last = NAN;
    t->probe_wait = int_max(t->probe_wait, 1);
    for (int i = 0; i < CORRECTIONS; i++) {
        if (!(h > 0)) {
            memcpy(t->y1, t->y, (size_t)t->g->moving_count * sizeof *t->y);
            t->h = 0;
            trace_load(t, t->y1, t->t);
            return true;
        }
        if (!trace_rate(t, t->y, t->t, 0) || trace_try(t, h) == INFINITY)
            return false;
        real f = value_of(e);
        if (e->kind != EVENT_CLOSE || fabs(f) <= 1e-15 * t->size || f == last)
            break;
        real slope = isnan(last) ? (e->gate->rate != 0 ? e->gate->rate : -1) : (f - last) / (h - before);
        before = h;
        last = f;
        real next = h - f / slope;
        if (!(next > 0 && next <= whole) || fabs(next - h) < 1e-17)
            break;
        h = next;
    }
    return true;
}
