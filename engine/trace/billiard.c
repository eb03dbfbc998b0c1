/* trace/billiard.c - many balls that bounce without friction: from blow to blow, each at its exact time.
 *
 * Balls that all fall alike move against each other in straight lines, so the time of the next blow of two of them is the root of a
 * quadratic, and so is that of a ball and a plane (Alder & Wainwright 1959: event-driven molecular dynamics). Each ball is moved only
 * when it is struck; a blow is one pair's, so that a row of touching balls hands it on as a cradle does, and blows of one
 * instant are the shared solver's (solve/impact.c), so that a symmetric break stays symmetric. Nothing is integrated: energy and
 * momentum stay to rounding. Groups small enough are traced instead; those with friction or that come to rest are for
 * the ways after this one.
 */
#include "trace/trace.h"

#define LIVELY       0.5        /* restitution: balls that bounce less come to rest                    */
#define WORK         20000000   /* blows times pairs of a frame                                        */
#define HOP          1e-3       /* of the frame: what hops no longer comes to rest                     */
#define INSTANT      1e-12      /* of the frame: blows no farther apart are at once                     */
#define BOUNCE_LEAST 1e-13      /* of the size: bounces lower than this are over, as in trace.c        */

typedef struct Billiard {
    Group *g;
    vec3   fall;                /* m/s^2  of all balls         */
    real  *at;                  /* s      each body's own time */
    real  *when;                /* s      each pair's next blow */
    int   *first, *pairs;       /* of each body                */
    bool   rests;               /* one of them comes to rest on a plane */
} Billiard;

static bool is_ball(const Group *g, int body, const Shape *s, pose at)
{
    const Member *m = &g->member[body];
    return m->moves && m->round && s->type == &shape_sphere && vec3_equal(at.p, vec3_zero());
}

static bool is_wall(const Group *g, int body, const Shape *s) { return !g->member[body].moves && s->type == &shape_plane; }

static bool suits(const Group *g)
{
    if (g->moving_count <= 1 || g->crowd || g->plan->substeps < 4 || g->trace_wait > 0 || g->planar || g->own || g->decay_friction)
        return false;
    if (g->joint_count > 0 || g->push_count > 0 || g->world->region_count > 0 || g->varies || g->pair_count == 0)
        return false;
    for (int i = 0; i < g->body_count; i++)
        if (i < g->moving_count ? !g->member[i].moves || g->member[i].integrator != DIG_AUTO : g->member[i].kinematic)
            return false;
    for (int i = 0; i < g->pair_count; i++) {
        const GroupPair *q = &g->pairs[i];
        bool a = is_ball(g, q->a, &q->on_a->shape, pair_local(q, false)), b = is_ball(g, q->b, &q->on_b->shape, pair_local(q, true));
        if (!(a && b) && !(a && is_wall(g, q->b, &q->on_b->shape)) && !(b && is_wall(g, q->a, &q->on_a->shape)))
            return false;
        if (q->rub->friction > 0 || q->rub->rolling > 0 || q->rub->restitution < LIVELY || q->contacts != 1)
            return false;
        const GroupContact *c = &g->contacts[q->contact];
        if (!(a && b) && c->manifold.count > 0 && contact_memory(c)[0].held > 0)    /* it rests there */
            return false;
    }
    return true;
}

/* ---- when ---- */

static vec3 fall_of(const Billiard *b, int body) { return b->g->member[body].moves ? b->fall : vec3_zero(); }

static vec3 place_of(const Billiard *b, int body, real time)
{
    real h = time - b->at[body];
    return vec3_mad(vec3_mad(b->g->pos[body].x, h, b->g->vel[body].v), 0.5 * h * h, fall_of(b, body));
}

static vec3 velocity_of(const Billiard *b, int body, real time)
{
    return vec3_mad(b->g->vel[body].v, time - b->at[body], fall_of(b, body));
}

/* s from now until |r + v t| is `reach`; what overlaps and approaches strikes at once. */
static real meet_ball(vec3 r, vec3 v, real reach)
{
    real b = vec3_dot(r, v), c = vec3_length2(r) - reach * reach, v2 = vec3_length2(v), d = b * b - v2 * c;
    if (!(b < 0) || d < 0)
        return INFINITY;
    return c > 0 ? c / (sqrt(d) - b) : 0;
}

/* s from now until gap + rate t + acc t^2 / 2 falls to zero. */
static real meet_wall(real gap, real rate, real acc)
{
    if (gap <= 0)
        return rate < 0 ? 0 : acc < 0 ? -2 * rate / acc : INFINITY;
    real d = rate * rate - 2 * acc * gap;
    if (d < 0 || (rate >= 0 && acc >= 0))
        return INFINITY;
    return rate < 0 ? 2 * gap / (sqrt(d) - rate) : (rate + sqrt(d)) / -acc;
}

/* After a blow at `now`. */
static void foresee(Billiard *b, int pair, real now)
{
    const Group *g = b->g;
    const GroupPair *q = &g->pairs[pair];
    bool wall_a = is_wall(g, q->a, &q->on_a->shape);
    int ball = wall_a ? q->b : q->a;
    const Shape *s = wall_a ? &q->on_b->shape : &q->on_a->shape;
    if (!wall_a && !is_wall(g, q->b, &q->on_b->shape)) {
        vec3 r = vec3_sub(place_of(b, q->b, now), place_of(b, q->a, now)), v = vec3_sub(velocity_of(b, q->b, now), velocity_of(b, q->a, now));
        b->when[pair] = now + meet_ball(r, v, q->on_a->shape.outer + q->on_b->shape.outer);
        return;
    }
    pose plane = group_shape_pose(g, wall_a ? q->a : q->b, pair_local(q, !wall_a));
    vec3 x = place_of(b, ball, now), n, pa, pb;
    real gap = shape_distance(wall_a ? &q->on_a->shape : &q->on_b->shape, plane, s, (pose){x, quat_identity()}, INFINITY, &n, &pa, &pb);
    real rate = vec3_dot(n, velocity_of(b, ball, now)), acc = vec3_dot(n, b->fall);
    if (gap <= g->touch * q->size && acc < 0 && fabs(rate) < -HOP * g->h * acc)
        b->rests = true;
    b->when[pair] = now + meet_wall(gap, rate, acc);
}

static void foresee_all(Billiard *b, int body, real now)
{
    if (!b->g->member[body].moves)
        return;
    for (int k = b->first[body]; k < b->first[body + 1]; k++)
        foresee(b, b->pairs[k], now);
}

/* ---- blows ---- */

static void move_to(Billiard *b, int body, real time)
{
    b->g->pos[body].x = place_of(b, body, time);
    b->g->vel[body].v = velocity_of(b, body, time);
    b->at[body] = time;
}

static void strike(Billiard *b, int pair, real time)
{
    Group *g = b->g;
    GroupPair *q = &g->pairs[pair];
    GroupContact *c = &g->contacts[q->contact];
    move_to(b, q->a, time);
    move_to(b, q->b, time);
    g->t = time;
    group_touch_pair(g, q, g->h);
    vec3 n = c->manifold.normal;
    real rate = c->live ? vec3_dot(n, vec3_sub(g->vel[q->b].v, g->vel[q->a].v)) : 0, im = g->mass[q->a].im + g->mass[q->b].im;
    if (rate < 0) {
        real e = -rate * q->rub->restitution > g->close_speed ? q->rub->restitution : 0, j = -(1 + e) * rate / im, lost = 0.5 * (1 - e * e) * rate * rate / im;
        g->vel[q->a].v = vec3_mad(g->vel[q->a].v, -j * g->mass[q->a].im, n);
        g->vel[q->b].v = vec3_mad(g->vel[q->b].v, j * g->mass[q->b].im, n);
        Acted *acted = contact_acted(g, c);
        acted->impulse = vec3_mad(acted->impulse, j, n);
        acted->point_sum = vec3_mad(acted->point_sum, j, c->manifold.points[0].a);
        acted->point_weight += j;
        acted->last = time;
        contact_rest_of(g, c)->lost += lost;
        g->lost += lost;
        group_note_blow(g, q->a);
        group_note_blow(g, q->b);
        strike_report(g, &(PointRow){.contact = q->contact, .jn = j}, -rate);
        g->located++;
        g->events++;
    }
    foresee_all(b, q->a, time);
    foresee_all(b, q->b, time);
    if (!(rate < 0))            /* rounding only: they pass */
        b->when[pair] = INFINITY;
}

/* Blows of one instant: all that touches and approaches is struck together. */
static void strike_all(Billiard *b, real time)
{
    Group *g = b->g;
    int before = g->strike_count;
    for (int i = 0; i < g->moving_count; i++)
        move_to(b, i, time);
    g->t = time;
    group_touch(g, g->h, true);
    impacts(g);
    g->located++;
    g->events += g->strike_count - before;
    for (int i = 0; i < g->pair_count; i++) {
        foresee(b, i, time);
        if (!(b->when[i] > time))           /* rounding only: they pass */
            b->when[i] = INFINITY;
    }
}

static int next_blow(const Billiard *b, int *ties)
{
    int next = 0;
    for (int i = 1; i < b->g->pair_count; i++)
        if (b->when[i] < b->when[next])
            next = i;
    *ties = 0;
    for (int i = 0; i < b->g->pair_count; i++)
        *ties += b->when[i] <= b->when[next] + INSTANT * b->g->h;
    return next;
}

/* ---- a frame ---- */

static bool reserve(Billiard *b)
{
    Group *g = b->g;
    int n = g->body_count;
    b->at = arena_zero(g->arena, (size_t)n * sizeof *b->at);
    b->when = arena_alloc(g->arena, (size_t)g->pair_count * sizeof *b->when);
    b->first = arena_zero(g->arena, (size_t)(n + 2) * sizeof *b->first);
    b->pairs = arena_alloc(g->arena, 2 * (size_t)g->pair_count * sizeof *b->pairs);
    g->strikes_most = g->plan->events + g->pair_count;
    g->point_capacity = g->contact_count * MANIFOLD_POINTS;
    g->points = arena_alloc(g->arena, (size_t)g->point_capacity * sizeof *g->points);
    g->rolls = arena_alloc(g->arena, (size_t)g->contact_count * sizeof *g->rolls);
    if (!b->at || !b->when || !b->first || !b->pairs || !g->points || !g->rolls)
        return false;
    for (int i = 0; i < g->pair_count; i++) {
        b->first[g->pairs[i].a + 2]++;
        b->first[g->pairs[i].b + 2]++;
    }
    for (int i = 2; i <= n + 1; i++)
        b->first[i] += b->first[i - 1];
    for (int i = 0; i < g->pair_count; i++) {
        b->pairs[b->first[g->pairs[i].a + 1]++] = i;
        b->pairs[b->first[g->pairs[i].b + 1]++] = i;
    }
    return true;
}

static bool falls_alike(Billiard *b)
{
    const Group *g = b->g;
    b->fall = vec3_scale(g->mass[0].im, g->member[0].force);
    for (int i = 0; i < g->moving_count; i++)
        if (vec3_distance(vec3_scale(g->mass[i].im, g->member[i].force), b->fall) > 1e-14 * vec3_length(b->fall) || vec3_length2(g->member[i].torque) > 0)
            return false;
    return true;
}

/* Blow after blow; false: more of them than the frame may have. */
static bool play(Billiard *b, real dt)
{
    const Group *g = b->g;
    for (int i = 0; i < g->pair_count; i++)
        foresee(b, i, 0);
    for (int64_t left = WORK; left > 0 && !b->rests; left -= g->pair_count) {
        int ties, next = next_blow(b, &ties);
        if (!(b->when[next] < dt))
            return true;
        if (ties > 1)
            strike_all(b, b->when[next]);
        else
            strike(b, next, b->when[next]);
        if (g->status != DIG_OK || g->woke)
            return true;
    }
    return false;
}

static void end_frame(Billiard *b, real dt)
{
    Group *g = b->g;
    for (int i = 0; i < g->moving_count; i++) {
        move_to(b, i, dt);
        g->pos[i].q = quat_unit(quat_mul(quat_exp(vec3_scale(dt, g->vel[i].w)), g->pos[i].q));
    }
    g->t = dt;
    group_touch(g, dt, true);
    for (int i = 0; i < g->contact_count; i++) {
        GroupContact *c = &g->contacts[i];
        c->manifold.slides = false;
        g->contact_rest[i].rolling = vec3_zero();
        for (int k = 0; k < c->manifold.count; k++)
            contact_memory(c)[k] = (PointMemory){.held = 0};
        for (int k = 0; c->live && k < c->manifold.count; k++)
            g->penetration = real_max(g->penetration, -c->manifold.points[k].gap);
    }
}

static dig_status advance(Group *g, real dt)
{
    Billiard b = {.g = g};
    GroupKept start;
    real size = 0;
    if (!group_keep(g, &start) || !reserve(&b))
        return DIG_E_MEMORY;
    for (int i = 0; i < g->moving_count; i++)
        size = real_max(size, g->member[i].outer);
    g->close_speed = sqrt(2 * g->fall * BOUNCE_LEAST * size) + 1e-9 * size;
    g->touch = 1e-9;
    g->locate = true;
    g->h = dt;
    DIG_TRY(group_forces(g));
    bool alike = falls_alike(&b);
    if (!alike || !play(&b, dt)) {
        group_put_back(g, &start);
        g->handed_on = true;
        g->trace_failed = alike && !b.rests;
        g->gave_up = g->trace_failed ? "more blows than its budget" : NULL;
        return DIG_OK;
    }
    if (g->status != DIG_OK)
        return g->status;
    end_frame(&b, dt);
    g->trace_failed = false;            /* what the trace gave up is done, as exactly */
    g->gave_up = NULL;
    g->touch = 1e-7;
    g->substeps = g->evaluations = 1;
    return g->stage(g, STAGE_SETTLE);
}

const Way way_billiard = {.name = "billiard", .tally = WAY_TRACED, .suits = suits, .advance = advance, .inertias = true};
