/* trace/through.c - does anything pass through anything within a tried step, unseen?
 *
 * Features are frozen, and the gap of a corner says nothing of the face beside it: what is fast may come in through a face and be out
 * again at the end of the step. So pairs that move by more than their thickness are followed by conservative advancement, along the
 * parabolas and the spins of the step. What they meet before the first event asks for a shorter step: from near by the right feature
 * is found, and its gap says when.
 */
#include "trace/trace.h"

#define NEAR  1e-6      /* of the step: an event this soon after is the meeting itself  */
#define SHORT 0.9       /* of the way to the meeting: so far the next step goes         */
#define LEAST 0.05      /* of the step: shorter ones are for the event's own search     */

static vec3 shift_of(const Tracer *t, int body)
{
    const Group *g = t->g;
    if (g->member[body].moves)
        return vec3_sub(t->y1[body].x, t->y[body].x);
    return g->member[body].kinematic ? vec3_scale(t->h, g->vel[body].v) : vec3_zero();
}

/* m  The farthest that a point of a body moves by its turn. */
static real turn_of(const Tracer *t, int body)
{
    const Member *m = &t->g->member[body];
    return m->moves || m->kinematic ? m->rim * real_min(2, t->h * vec3_length(t->g->vel[body].w)) : 0;
}

static Motion motion_of(const Tracer *t, int body, pose local)
{
    const Group *g = t->g;
    Motion r = {.start = group_shape_pose(g, body, local), .centre = pose_unpoint(local, vec3_zero())};
    if (!g->member[body].moves && !g->member[body].kinematic)
        return r;
    r.v = g->vel[body].v;
    r.w = g->vel[body].w;
    if (g->member[body].moves)
        r.a = vec3_scale(2 / (t->h * t->h), vec3_mad(shift_of(t, body), -t->h, r.v));
    return r;
}

#define HIDDEN 0.01     /* of the size: what is in others that are fixed, too, may stick out by as little, and no farther along */

/* Spins are those of the state that was loaded last: about the same all through the step. */
static bool fast(const Tracer *t, const GroupPair *q)
{
    const Shape *a = &q->on_a->shape, *b = &q->on_b->shape;
    real thick = seam_near(t->g, q) ? HIDDEN * q->size : a->inner + b->inner;
    return isfinite(thick) && vec3_distance(shift_of(t, q->a), shift_of(t, q->b)) + turn_of(t, q->a) + turn_of(t, q->b) > thick;
}

/* s  When a point that touches, and that nothing presses, will be off by so much. INFINITY: it stays. */
static real leaves_at(const Tracer *t, const Gate *gate, real off)
{
    real way = off - gate->gap0, d = gate->rate0 * gate->rate0 + 2 * gate->acc0 * way;
    if (gate->presses || gate->rate0 < -t->g->close_speed || !(d > 0) || !(gate->rate0 + sqrt(d) > 0))
        return INFINITY;
    return 2 * way / (gate->rate0 + sqrt(d));
}

/* s  When all points of a pair that touch have parted: what whirls may then come in with its other end, of which they know nothing. 0: none
 * touches. INFINITY: some point stays. */
static real parted_at(const Tracer *t, const GroupPair *q)
{
    real last = 0;
    for (int i = 0; i < t->touch_count; i++) {
        const Touching *c = &t->touch[i];
        bool of_pair = c->contact >= q->contact && c->contact < q->contact + q->contacts;
        if (of_pair && (c->gate.closed || c->gate.presses || c->gate.gap0 <= t->gap_zero))
            last = real_max(last, leaves_at(t, &c->gate, 2 * t->gap_zero));
    }
    return last;
}

/* s  INFINITY: they do not meet between `from` and `until`. */
static real meeting(const Tracer *t, const GroupPair *q, real from, real until)
{
    const Shape *a = &q->on_a->shape, *b = &q->on_b->shape;
    Motion ma = motion_of(t, q->a, pair_local(q, false)), mb = motion_of(t, q->b, pair_local(q, true));
    Motion la = motion_from(&ma, from), lb = motion_from(&mb, from);
    real when = from + time_of_impact(a, &la, b, &lb, 0, until - from, NULL);
    if (!(when < until))
        return INFINITY;
    vec3 n, pa, pb;
    real gap = shape_distance(a, motion_at(&ma, when), b, motion_at(&mb, when), INFINITY, &n, &pa, &pb);
    Manifold there = {.normal = n, .count = 1, .points = {{.a = pa, .b = pb, .gap = gap}}};
    if (seam_hides(t->g, q, motion_at(&ma, when), motion_at(&mb, when), &there))
        return INFINITY;
    bool meets = vec3_dot(n, vec3_sub(motion_velocity(&mb, pb, when), motion_velocity(&ma, pa, when))) < -t->g->close_speed;
    return meets && !manifold_covered(a, motion_at(&ma, when), b, motion_at(&mb, when), q->covered, n) ? when : INFINITY;
}

real trace_unseen(Tracer *t, const Event *e)
{
    const Group *g = t->g;
    real until = (e->kind == EVENT_NONE ? 1 : e->at - NEAR) * t->h, first = INFINITY;
    bool loaded = false;
    for (int i = 0; i < g->pair_count && until > 0; i++) {
        const GroupPair *q = &g->pairs[i];
        if (!fast(t, q))
            continue;
        real from = parted_at(t, q);
        if (!(from < until))
            continue;
        if (!loaded)
            trace_load(t, t->y, t->t);
        loaded = true;
        first = real_min(first, meeting(t, q, from, until));
    }
    return first < INFINITY ? real_max(LEAST, SHORT * first / t->h) : 1;
}
