/* solve/impact.c - what touches and approaches is struck, now.
 *
 * Elastic impacts go one pair of bodies at a time, the fastest approach first
 * (ties together), so that a row of balls hands its momentum on as Newton's
 * cradle does. When no elastic approach is left, all touching contacts are
 * closed in one simultaneous plastic solve. Friction is bounded by the whole
 * normal impulse, restitution included. Joints take part in every solve.
 */
#include "solve/direction.h"

/* An impact solve stops when the velocities change by less than this part of the approach speed. */
#define IMPACT_RESIDUAL 1e-12
#define IMPACT_SWEEPS 1000

static real touch_tolerance(const Group *g, const GroupContact *c) { return g->touch * g->pairs[c->pair].size; }

static bool any_approach(const Group *g)
{
    for (int i = 0; i < g->contact_count; i++) {
        const GroupContact *c = &g->contacts[i];
        for (int k = 0; c->live && k < c->manifold.count; k++) {
            if (c->manifold.points[k].gap > touch_tolerance(g, c))
                continue;
            vec3 at = c->manifold.points[k].a;
            vec3 va = vec3_add(g->vel[c->a].v, vec3_cross(g->vel[c->a].w, vec3_sub(at, g->pos[c->a].x)));
            vec3 vb = vec3_add(g->vel[c->b].v, vec3_cross(g->vel[c->b].w, vec3_sub(at, g->pos[c->b].x)));
            if (vec3_dot(c->manifold.normal, vec3_sub(vb, va)) < -0.1 * g->close_speed)
                return true;
        }
    }
    return false;
}

static void build_rows(Group *g)
{
    g->point_count = 0;
    g->roll_count = 0;
    for (int i = 0; i < g->contact_count; i++) {
        const GroupContact *c = &g->contacts[i];
        const GroupPair *q = &g->pairs[c->pair];
        for (int k = 0; c->live && k < c->manifold.count; k++) {
            if (c->manifold.points[k].gap > touch_tolerance(g, c))
                continue;
            PointRow *r = &g->points[g->point_count++];
            point_row_make(g, r, i, k);
            r->friction = q->friction;
            r->friction_dynamic = q->friction_dynamic;
        }
    }
    group_build_joints(g, false);
    for (int i = 0; i < g->row_count; i++) {
        JointRow *r = &g->rows[i];
        r->p = 0;
        r->bias = 0;
        r->gamma = 0;
        bool stops = r->row.kind == ROW_HARD || (r->row.kind == ROW_LIMIT && r->row.error <= 1e-9);
        if (!stops)
            r->k = 0;           /* springs, motors and dry friction have no time to act */
    }
}

real group_kinetic(const Group *g)
{
    real sum = 0;
    for (int i = 0; i < g->moving_count; i++) {
        const Member *m = &g->member[i];
        if (!m->moves)
            continue;
        vec3 w = quat_unrotate(g->pos[i].q, g->vel[i].w);
        sum += 0.5 * m->mass * vec3_length2(g->vel[i].v) + 0.5 * vec3_dot(w, mat3_mul_vec(m->inertia, w));
    }
    return sum;
}

/* m/s  No velocity change below this can be told from rounding. */
static real rounding_floor(const Group *g)
{
    real fastest = 0;
    for (int i = 0; i < g->body_count; i++) {
        real rim = isfinite(g->member[i].outer) ? vec3_length(g->vel[i].w) * g->member[i].outer : 0;
        fastest = real_max(fastest, vec3_length(g->vel[i].v) + rim);
    }
    return 1e-15 * fastest;
}

/* Counts bound the work: few rows are solved to rounding, many as well as a substep's. */
static int impact_sweeps(const Group *g) { return (int)real_clamp(40000.0 / (g->point_count + g->row_count + 1), 40, IMPACT_SWEEPS); }

/* Solves the chosen rows together with the joints; on[] marks them. */
static void solve_marked(Group *g, const bool *on, bool all, real speed)
{
    if (all) {
        relax(g, impact_sweeps(g), IMPACT_RESIDUAL * speed);
        return;
    }
    real enough = IMPACT_RESIDUAL * speed + rounding_floor(g);
    for (int sweep = impact_sweeps(g); sweep > 0; sweep--) {
        real worst = relax_joints(g);
        for (int i = 0; i < g->point_count; i++)
            if (on[i])
                worst = real_max(worst, relax_points(g, i, 1));
        g->sweeps++;
        if (worst <= enough)
            return;
    }
}

static void note_strike(Group *g, const PointRow *r, real speed)
{
    GroupContact *c = &g->contacts[r->contact];
    const ManifoldPoint *p = &c->manifold.points[r->point];
    vec3 impulse = vec3_add(vec3_scale(r->jn, c->manifold.normal), vec3_add(vec3_scale(r->jt[0], r->t[0].n), vec3_scale(r->jt[1], r->t[1].n)));
    c->impulse = vec3_add(c->impulse, impulse);
    c->point_sum = vec3_mad(c->point_sum, r->jn, p->a);
    c->point_weight += r->jn;
    if (!(r->jn > 0))
        return;
    c->last = g->t;
    if (speed > 0.1 * g->close_speed)
        c->memory[r->point].held = 0;   /* if it bounces, it flies; if not, the next substep holds it */
    g->member[c->a].collided = g->member[c->b].collided = true;
    for (int k = 0; k < 2; k++) {
        Member *m = &g->member[k ? c->b : c->a];
        if (m->dormant)
            m->pushed = g->woke = true;
        if (m->kinematic) {         /* a mover gives energy to what it strikes */
            int b = k ? c->b : c->a;
            vec3 v = vec3_add(g->vel[b].v, vec3_cross(g->vel[b].w, vec3_sub(p->a, g->pos[b].x)));
            g->work_in += (k ? -1 : 1) * vec3_dot(impulse, v);
            g->lost += (k ? -1 : 1) * vec3_dot(impulse, v);
        }
    }
    if (speed > 0.1 * g->close_speed)       /* else it only hands the blow on: no impact of its own to report */
        strike_report(g, r, speed);
}

/* An impact is remembered for events and messages. */
void strike_report(Group *g, const PointRow *r, real speed)
{
    const GroupContact *c = &g->contacts[r->contact];
    GroupPair *q = &g->pairs[c->pair];
    const ManifoldPoint *p = &c->manifold.points[r->point];
    if (!q->struck) {
        q->struck = true;
        q->struck_time = g->t;
        q->struck_speed = speed;
        q->struck_point = p->a;
        q->struck_normal = c->manifold.normal;
    }
    q->struck_speed = real_max(q->struck_speed, speed);
    q->struck_impulse += r->jn;
    /* A blow that goes to and fro along a row of touching bodies within one instant is one impact of each pair; where
     * impacts are not located, all of a step's are. */
    Strike *last = q->strike > 0 && q->strike <= g->strike_count ? &g->strikes[q->strike - 1] : NULL;
    if (last && last->pair == c->pair && (last->time == g->t || !g->locate)) {
        last->impulse += r->jn;
    } else if (g->strike_count < g->strike_capacity) {
        g->strikes[g->strike_count++] = (Strike){g->t, c->pair, speed, r->jn, p->a, c->manifold.normal};
        q->strike = g->strike_count;
    }
}

/* Sets targets for one solve; returns the fastest approach, m/s, and marks the rows. */
static real choose_elastic(Group *g, bool *on, const real *rate)
{
    real fastest = 0;
    for (int i = 0; i < g->point_count; i++) {
        real e = g->pairs[g->contacts[g->points[i].contact].pair].restitution;
        if (-rate[i] * e > g->close_speed && -rate[i] > fastest)
            fastest = -rate[i];
    }
    for (int i = 0; i < g->point_count && fastest > 0; i++) {
        const PointRow *r = &g->points[i];
        real e = g->pairs[g->contacts[r->contact].pair].restitution;
        bool tie = -rate[i] * e > g->close_speed && -rate[i] >= fastest * (1 - 1e-7);
        for (int k = 0; tie && k < g->point_count; k++)
            if (g->points[k].a == r->a && g->points[k].b == r->b)
                on[k] = true;
    }
    return fastest;
}

/* A contact that already presses takes its share of a neighbour's blow at once, and does not bounce from it: a ball struck
 * sideways stays on its table, a table struck by a ball stays on its floor. */
static bool is_held(const Group *g, const PointRow *r) { return g->contacts[r->contact].memory[r->point].held > 0; }

/* One solve; true when something was left to do. */
static bool strike_once(Group *g, bool *on, real *rate, bool allow_elastic)
{
    real approach = 0;
    for (int i = 0; i < g->point_count; i++) {
        PointRow *r = &g->points[i];
        rate[i] = dir_rate(g, &r->n, r->a, r->b);
        r->jn = r->jt[0] = r->jt[1] = 0;
        real slip = hypot(dir_rate(g, &r->t[0], r->a, r->b), dir_rate(g, &r->t[1], r->a, r->b));
        r->slides = slip > 0.1 * g->close_speed;
        on[i] = false;
        approach = real_max(approach, -rate[i]);
    }
    for (int i = 0; i < g->row_count; i++)
        g->rows[i].p = 0;
    if (approach <= 0.1 * g->close_speed)
        return false;
    bool elastic = allow_elastic && choose_elastic(g, on, rate) > 0;
    for (int i = 0; i < g->point_count; i++) {
        real e = elastic && on[i] ? g->pairs[g->contacts[g->points[i].contact].pair].restitution : 0;
        g->points[i].target = rate[i] < 0 ? -e * rate[i] : 0;
        if (!elastic || is_held(g, &g->points[i]))
            on[i] = true;
    }
    solve_marked(g, on, !elastic, approach);
    for (int i = 0; i < g->point_count; i++)
        if (on[i])
            note_strike(g, &g->points[i], real_max(0, -rate[i]));
    return elastic;
}

/* Joint impulses of an impact count in the joint's force. */
static void note_joints(Group *g)
{
    for (int i = 0; i < g->block_count; i++) {
        GroupJoint *j = &g->joints[g->blocks[i].joint];
        for (int k = 0; k < g->blocks[i].count; k++) {
            const JointRow *r = &g->rows[g->blocks[i].first + k];
            for (int m = 0; m < r->row.count; m++)
                if (r->row.body[m] == j->a && j->a >= 0) {
                    j->impulse = vec3_mad(j->impulse, r->p, r->row.lin[m]);
                    j->angular_impulse = vec3_mad(j->angular_impulse, r->p, r->row.ang[m]);
                }
        }
    }
}

void impacts(Group *g)
{
    if (!any_approach(g))
        return;
    build_rows(g);
    ArenaMark mark = arena_mark(g->arena);
    bool *on = arena_alloc(g->arena, (size_t)(g->point_count + 1) * sizeof *on);
    real *rate = arena_alloc(g->arena, (size_t)(g->point_count + 1) * sizeof *rate);
    if (!on || !rate) {
        g->status = DIG_E_MEMORY;
        return;
    }
    real before = group_kinetic(g);
    int most = 60 * int_max(4, g->point_count);
    for (int i = 0; i < most && !g->woke; i++) {
        bool more = strike_once(g, on, rate, i < most - 1);
        note_joints(g);
        if (!more)
            break;
    }
    g->lost += before - group_kinetic(g);
    g->point_count = 0;
    arena_rewind(g->arena, mark);
}
