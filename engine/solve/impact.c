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
#define WORK          40000.0   /* rows times sweeps */
#define WORK_PAUSED   8000.0    /* the same of a heap that a mover stirs (toil.c) */
#define FEW_POINTS 24           /* with more of them, as well as a substep's rows is good enough */

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
            if (vec3_dot(c->manifold.normal, vec3_sub(vb, va)) + squeeze_of(g, i).rate < -0.1 * g->close_speed)
                return true;
        }
    }
    return false;
}

/* m/s or rad/s  What the fastest joint runs into its stop with. After build_rows(). */
static real stop_approach(const Group *g)
{
    real approach = 0;
    for (int i = 0; i < g->row_count && g->strikes_stops; i++) {
        const JointRow *r = &g->rows[i];
        if (r->row.kind == ROW_LIMIT && r->k > 0)
            approach = real_max(approach, -joint_row_rate(g, &r->row));
    }
    return approach;
}

/* ahead: with stops that the substep gets to; else those at hand */
static void build_rows(Group *g, bool ahead)
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
            r->friction = q->rub->friction;
            r->friction_dynamic = q->rub->friction_dynamic;
        }
    }
    group_build_joints(g, false);
    for (int i = 0; i < g->row_count; i++) {
        JointRow *r = &g->rows[i];
        bool stop = r->row.kind == ROW_LIMIT && (ahead || r->row.error <= 1e-9);
        r->p = 0;
        r->bias = ahead && stop ? r->bias : 0;
        r->gamma = 0;
        if (r->row.kind != ROW_HARD && !stop)
            r->k = 0;           /* springs, motors and dry friction have no time to act */
    }
}

real group_kinetic_of(const Group *g, int body)
{
    const Member *m = &g->member[body];
    if (!m->moves)
        return 0;
    vec3 w = quat_unrotate(g->pos[body].q, g->vel[body].w);
    return 0.5 * m->mass * vec3_length2(g->vel[body].v) + 0.5 * vec3_dot(w, mat3_mul_vec(*m->inertia, w));
}

real group_kinetic(const Group *g)
{
    real sum = 0;
    for (int i = 0; i < g->moving_count; i++)
        sum += group_kinetic_of(g, i);
    return sum;
}

#define EVENTS_LEAST 4
#define EVENTS_PAIRS 4000       /* times pairs */

/* Each impact that is located cuts the step in two, and all is solved in both: what they cost together grows with the pairs squared. Where
 * these are more than the plan has impacts, that is more than their order in a heap is worth. */
int group_events(const Group *g)
{
    int pairs = g->pair_count + 1, events = g->plan->events, most = EVENTS_PAIRS / pairs;
    if (pairs > events)
        most = (int)((int64_t)most * events / pairs);
    return int_min(events, int_max(EVENTS_LEAST, most));
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
static int impact_sweeps(const Group *g)
{
    return (int)real_clamp((toil_pauses(g) ? WORK_PAUSED : WORK) / (g->point_count + g->row_count + 1), 40, IMPACT_SWEEPS);
}

/* Where something is heavy, what sweeps do not get to is solved at once. */
static void solve_all(Group *g, real residual)
{
    real worst = g->residual;
    g->residual = 0;
    if (!stick(g, NULL, 0, g->point_count, residual))
        relax(g, impact_sweeps(g), residual);
    if (g->residual > residual && group_top_heavy(g) && direct_wanted(g) > 0 && direct_solve(g, residual))
        g->residual = g->from_inside ? g->residual : residual;
    if (g->residual > VELOCITY_COARSE && g->row_count > 0)      /* a rod of 2 g between kilograms: 22,000 sweeps left 17 m/s */
        direct_rescue(g);
    g->residual = real_max(g->residual, worst);
}

/* Solves the chosen rows together with the joints; on[] marks them. */
static void solve_marked(Group *g, const bool *on, bool all, real speed)
{
    real aim = IMPACT_RESIDUAL * speed, enough = aim + rounding_floor(g);
    if (all) {                  /* the sweep's to the last: heaps of rods crept where they were not */
        solve_all(g, real_max(g->patches ? enough : aim, g->point_count > FEW_POINTS ? g->plan->residual : 0));
        return;
    }
    int first = 0, end = g->point_count;        /* of the few that are on, among many */
    while (first < end && !on[first])
        first++;
    while (end > first && !on[end - 1])
        end--;
    if (stick(g, on, first, end, enough))
        return;
    for (int sweep = impact_sweeps(g); sweep > 0; sweep--) {
        real worst = relax_joints(g);
        for (int i = first, n; i < end; i += n) {
            for (n = 1; g->patches && on[i] && i + n < end && on[i + n] && g->points[i + n].contact == g->points[i].contact; n++);
            if (on[i])
                worst = real_max(worst, relax_patch(g, i, n));
        }
        g->sweeps++;
        if (worst <= enough)
            return;
    }
}

/* m/s, rates of a point along its normal and tangents */
static void find_rates(const Group *g, const PointRow *r, real rate[3])
{
    rate[0] = dir_rate(g, &r->n, r->a, r->b);
    rate[1] = dir_rate(g, &r->t[0], r->a, r->b);
    rate[2] = dir_rate(g, &r->t[1], r->a, r->b);
}

/* What a blow takes is its impulse times the mean of the rates before and after: summed over points and joints that is exact. */
static void book_strike(Group *g, const PointRow *r, const real before[3])
{
    real after[3];
    find_rates(g, r, after);
    g->contact_rest[r->contact].lost -= 0.5 * (r->jn * (before[0] + after[0]) + r->jt[0] * (before[1] + after[1]) + r->jt[1] * (before[2] + after[2]));
}

/* Between its blows it goes straight on, or nearly so. */
void group_note_blow(Group *g, int body)
{
    group_note_swing(g, body, g->pos[body].x, 0);
    g->member[body].collided = true;
}

void group_note_swing(Group *g, int body, vec3 x, real turned)
{
    Member *m = &g->member[body];
    Been before = m->been ? g->been[body] : (Been){{x, x}, 0};
    g->been[body] = (Been){box3_union(before.places, (box3){x, x}), real_max(before.swung, fabs(turned))};
    m->been = true;
}

static void note_strike(Group *g, const PointRow *r, real speed)
{
    GroupContact *c = &g->contacts[r->contact];
    const ManifoldPoint *p = &c->manifold.points[r->point];
    vec3 impulse = vec3_add(vec3_scale(r->jn, c->manifold.normal), vec3_add(vec3_scale(r->jt[0], r->t[0].n), vec3_scale(r->jt[1], r->t[1].n)));
    Acted *acted = contact_acted(g, c);
    acted->impulse = vec3_add(acted->impulse, impulse);
    acted->point_sum = vec3_mad(acted->point_sum, r->jn, p->a);
    acted->point_weight += r->jn;
    if (!(r->jn > 0))
        return;
    acted->last = g->t;
    if (speed > 0.1 * g->close_speed)
        contact_memory(c)[r->point].held = 0;   /* if it bounces, it flies; if not, the next substep holds it */
    group_note_blow(g, c->a);
    group_note_blow(g, c->b);
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

/* Speeds of a mover, one a frame, stand for a smooth motion: what lay on it, or on what does, is not struck by what a frame of free fall makes
 * up for. */
static bool rides(const Group *g, const GroupContact *c, real speed)
{
    return g->driven && g->pairs[c->pair].was_touching && speed <= g->fall * g->world->def.step;
}

Impact *group_impact(Group *g, GroupPair *q)
{
    if (q->impact == 0) {
        g->impacts[g->impact_count] = (Impact){.time = 0};
        q->impact = ++g->impact_count;
    }
    return &g->impacts[q->impact - 1];
}

#define STRIKES_FIRST 4         /* most groups have none, and most of the others few */

/* Is there room for one more? */
static bool strike_room(Group *g)
{
    if (g->strike_count < g->strike_room)
        return true;
    int room = int_min(g->strike_room > 0 ? 4 * g->strike_room : STRIKES_FIRST, g->strikes_most);
    if (g->strike_count >= room)
        return false;
    Strike *more = arena_alloc(g->lasting, (size_t)room * sizeof *more);
    if (!more) {
        g->no_room = true;
        return false;
    }
    if (g->strike_count > 0)
        memcpy(more, g->strikes, (size_t)g->strike_count * sizeof *more);
    g->strikes = more;
    g->strike_room = room;
    return true;
}

/* An impact is remembered for events and messages. */
void strike_report(Group *g, const PointRow *r, real speed)
{
    const GroupContact *c = &g->contacts[r->contact];
    GroupPair *q = &g->pairs[c->pair];
    if (rides(g, c, speed))
        return;
    const ManifoldPoint *p = &c->manifold.points[r->point];
    Impact *impact = group_impact(g, q);
    if (!q->struck) {
        q->struck = true;
        impact->time = g->t;
        q->speed = speed;
    }
    q->speed = real_max(q->speed, speed);
    impact->impulse += r->jn;
    /* A blow that goes to and fro along a row of touching bodies within one instant is one impact of each pair; where
     * impacts are not located, all of a step's are. */
    Strike *last = impact->last > 0 && impact->last <= g->strike_count ? &g->strikes[impact->last - 1] : NULL;
    if (last && last->pair == c->pair && (last->time == g->t || !g->locate)) {
        last->impulse += r->jn;
    } else if (strike_room(g)) {
        g->strikes[g->strike_count++] = (Strike){g->t, c->pair, speed, r->jn, p->a, c->manifold.normal};
        impact->last = g->strike_count;
        impact->first = impact->first > 0 ? impact->first : impact->last;
    }
}

/* Sets targets for one solve; returns the fastest approach, m/s, and marks the rows. */
static real choose_elastic(Group *g, bool *on, const real *rate)
{
    real fastest = 0;
    for (int i = 0; i < g->point_count; i++) {
        real e = g->pairs[g->contacts[g->points[i].contact].pair].rub->restitution;
        if (-rate[i] * e > g->close_speed && -rate[i] > fastest)
            fastest = -rate[i];
    }
    for (int i = 0; i < g->point_count && fastest > 0; i++) {
        const PointRow *r = &g->points[i];
        real e = g->pairs[g->contacts[r->contact].pair].rub->restitution;
        bool tie = -rate[i] * e > g->close_speed && -rate[i] >= fastest * (1 - 1e-7);
        for (int k = 0; tie && k < g->point_count; k++)
            if (g->points[k].a == r->a && g->points[k].b == r->b)
                on[k] = true;
    }
    return fastest;
}

#define PRESSED 0.1             /* of the weight of the lighter body */
#define PRESSED_FREE 1e-4       /* of the fastest approach, by what it gives that body in a step, where nothing has weight */

/* Does a contact press by what counts? The balls of a cradle that hang side by side press each other by what their threads are off. */
bool contact_presses(const Group *g, const GroupContact *c, real approach)
{
    const GroupPair *q = &g->pairs[c->pair];
    const Member *a = &g->member[q->a], *b = &g->member[q->b];
    real mass = !a->moves ? b->mass : !b->moves ? a->mass : real_min(a->mass, b->mass), force = 0;
    for (int k = 0; k < c->manifold.count; k++)
        force += contact_memory(c)[k].normal;
    real least = g->fall > 0 ? PRESSED * g->fall : PRESSED_FREE * approach / g->world->def.step;
    return force >= least * mass;
}

/* A contact that already presses takes its share of a neighbour's blow at once, and does not bounce from it: a ball struck
 * sideways stays on its table, a table struck by a ball stays on its floor. */
static bool is_held(const Group *g, const PointRow *r, real rate, real approach)
{
    const GroupContact *c = &g->contacts[r->contact];
    bool held = false;      /* by any of its points: of the corners of a box that slides, three may bear all there is */
    for (int k = 0; k < c->manifold.count && !held; k++)
        held = contact_memory(c)[k].held > 0;
    return held && rate <= 0.1 * g->close_speed && contact_presses(g, c, approach);       /* and not leaving already */
}

/* ---- no blow makes energy ----
 *
 * Restitution by speeds (Newton's) can, where several contacts of a body share a blow with friction or with what is held. Then the
 * largest part of it is taken, between the plastic and the elastic outcome, that keeps the energy; both keep all bounds, and so
 * does what lies between them. */

typedef struct Outcome { Vel *vel; real *impulse; } Outcome;

static void keep_outcome(const Group *g, Outcome *o)
{
    memcpy(o->vel, g->vel, (size_t)g->moving_count * sizeof *o->vel);
    for (int i = 0; i < g->point_count; i++)
        memcpy(&o->impulse[3 * i], (real[]){g->points[i].jn, g->points[i].jt[0], g->points[i].jt[1]}, 3 * sizeof(real));
    for (int i = 0; i < g->row_count; i++)
        o->impulse[3 * g->point_count + i] = g->rows[i].p;
}

static real mix(real a, real b, real s) { return a + s * (b - a); }
static vec3 mix3(vec3 a, vec3 b, real s) { return vec3_mad(a, s, vec3_sub(b, a)); }

static void set_between(Group *g, const Outcome *a, const Outcome *b, real s)
{
    for (int i = 0; i < g->moving_count; i++)
        g->vel[i] = (Vel){mix3(a->vel[i].v, b->vel[i].v, s), mix3(a->vel[i].w, b->vel[i].w, s)};
    for (int i = 0; i < g->point_count; i++) {
        PointRow *r = &g->points[i];
        r->jn = mix(a->impulse[3 * i], b->impulse[3 * i], s);
        r->jt[0] = mix(a->impulse[3 * i + 1], b->impulse[3 * i + 1], s);
        r->jt[1] = mix(a->impulse[3 * i + 2], b->impulse[3 * i + 2], s);
    }
    for (int i = 0; i < g->row_count; i++)
        g->rows[i].p = mix(a->impulse[3 * g->point_count + i], b->impulse[3 * g->point_count + i], s);
}

/* The largest share of b over a that keeps the energy at `most`, J: along s it is a quadratic, e0 + f s + c s^2. */
static void set_capped(Group *g, const Outcome *a, const Outcome *b, real most)
{
    set_between(g, a, b, 0);
    real e0 = group_kinetic(g);
    set_between(g, a, b, 0.5);
    real half = group_kinetic(g);
    set_between(g, a, b, 1);
    real e1 = group_kinetic(g), c = 2 * (e1 + e0 - 2 * half), f = e1 - e0 - c, d = f * f + 4 * c * (most - e0);
    real s = c > 0 && d > 0 ? (sqrt(d) - f) / (2 * c) : 0;
    set_between(g, a, b, isfinite(s) ? real_clamp(s, 0, 1) : 0);
}

/* A mover may give energy. */
static bool struck_by_mover(const Group *g, const bool *on)
{
    for (int i = 0; i < g->point_count; i++)
        if (on[i] && (g->member[g->points[i].a].kinematic || g->member[g->points[i].b].kinematic))
            return true;
    for (int i = 0; i < g->row_count && g->strikes_stops; i++)
        if (g->rows[i].row.kind == ROW_LIMIT && g->rows[i].k > 0 && group_row_driven(g, &g->rows[i].row) < 0)
            return true;
    return false;
}

static bool outcome_open(Group *g, Outcome *o)
{
    o->vel = arena_alloc(g->arena, (size_t)(g->moving_count + 1) * sizeof *o->vel);
    o->impulse = arena_alloc(g->arena, (size_t)(3 * g->point_count + g->row_count + 1) * sizeof *o->impulse);
    return o->vel && o->impulse;
}

#define ENERGY_KEPT (1 + 1e-9)

/* The solve; then, had it made energy, the largest part of it that does not: between the plastic and the elastic outcome, and where
 * the plastic one makes energy too, because joints and mass ratios keep it from converging, between nothing and that. */
static void solve_capped(Group *g, const bool *on, bool all, real approach)
{
    ArenaMark mark = arena_mark(g->arena);
    Outcome start, elastic, plastic;
    if (!outcome_open(g, &start) || !outcome_open(g, &elastic) || !outcome_open(g, &plastic)) {
        g->status = DIG_E_MEMORY;
        return;
    }
    real before = group_kinetic(g);
    keep_outcome(g, &start);
    solve_marked(g, on, all, approach);
    if (!(group_kinetic(g) <= before * ENERGY_KEPT)) {
        keep_outcome(g, &elastic);
        set_between(g, &start, &start, 0);
        for (int i = 0; i < g->point_count; i++)
            g->points[i].target = -squeeze_of(g, g->points[i].contact).rate;
        solve_marked(g, on, all, approach);
        keep_outcome(g, &plastic);
        if (group_kinetic(g) <= before * ENERGY_KEPT)
            set_capped(g, &plastic, &elastic, before);
        else
            set_capped(g, &start, &plastic, before);
    }
    arena_rewind(g->arena, mark);
}

/* The solve of what a mover strikes. */
static void solve_driven(Group *g, const bool *on, bool all, real approach)
{
    ArenaMark mark = arena_mark(g->arena);
    bool levers = group_may_lever(g);
    Vel *before = levers ? group_velocities(g) : NULL;
    if (levers && !before)
        g->status = DIG_E_MEMORY;
    solve_marked(g, on, all, approach);
    if (before)
        group_ease_levers(g, before);
    arena_rewind(g->arena, mark);
}

/* One solve; true when something was left to do. rate: of the points, then all three of each. */
static bool strike_once(Group *g, bool *on, real *rate, bool allow_elastic)
{
    real approach = 0, (*before)[3] = (real (*)[3])(rate + g->point_count);
    for (int i = 0; i < g->point_count; i++) {
        PointRow *r = &g->points[i];
        find_rates(g, r, before[i]);
        rate[i] = before[i][0] + squeeze_of(g, r->contact).rate;
        r->jn = r->jt[0] = r->jt[1] = 0;
        r->slides = hypot(before[i][1], before[i][2]) > 0.1 * g->close_speed;
        on[i] = false;
        approach = real_max(approach, -rate[i]);
    }
    for (int i = 0; i < g->row_count; i++)
        g->rows[i].p = 0;
    approach = real_max(approach, stop_approach(g));
    if (approach <= 0.1 * g->close_speed)
        return false;
    bool elastic = allow_elastic && choose_elastic(g, on, rate) > 0;
    for (int i = 0; i < g->point_count; i++) {
        real e = elastic && on[i] ? g->pairs[g->contacts[g->points[i].contact].pair].rub->restitution : 0;
        g->points[i].target = (rate[i] < 0 ? -e * rate[i] : 0) - squeeze_of(g, g->points[i].contact).rate;
        if (!elastic || is_held(g, &g->points[i], rate[i], approach))
            on[i] = true;
    }
    if (struck_by_mover(g, on))
        solve_driven(g, on, !elastic, approach);
    else
        solve_capped(g, on, !elastic, approach);
    for (int i = 0; i < g->point_count; i++)
        if (on[i]) {
            book_strike(g, &g->points[i], before[i]);
            note_strike(g, &g->points[i], real_max(0, -rate[i]));
        }
    return elastic;
}

/* Joint impulses of an impact count in the joint's force, and driven ends give energy through them. */
static void note_joints(Group *g)
{
    for (int i = 0; i < g->block_count; i++) {
        GroupJoint *j = &g->joints[g->blocks[i].joint];
        for (int k = 0; k < g->blocks[i].count; k++) {
            const JointRow *r = &g->rows[g->blocks[i].first + k];
            real given = -r->p * group_row_driven(g, &r->row);
            g->work_in += given;
            g->lost += given;
            for (int m = 0; m < r->row.count; m++)
                if (r->row.body[m] == j->a && j->a >= 0) {
                    j->impulse = vec3_mad(j->impulse, r->p, r->row.lin[m]);
                    j->angular_impulse = vec3_mad(j->angular_impulse, r->p, r->row.ang[m]);
                }
        }
    }
}

/* Rows solved in one instant: what still bounces to and fro then, as stones between a mover and a wall that it is deep in, bounces no more.
 * Of the hard cases none takes 10,000; those stones took 2 million sweeps of 52 rows. */
#define BLOW_ROWS 300000

void impacts(Group *g)
{
    if (!g->strikes_stops && !any_approach(g))
        return;
    build_rows(g, false);
    ArenaMark mark = arena_mark(g->arena);
    bool *on = arena_alloc(g->arena, (size_t)(g->point_count + 1) * sizeof *on);
    real *rate = arena_alloc(g->arena, (size_t)(4 * g->point_count + 1) * sizeof *rate);
    if (!on || !rate) {
        g->status = DIG_E_MEMORY;
        return;
    }
    real before = group_kinetic(g);
    int most = 60 * int_max(4, g->point_count), last = g->sweeps + BLOW_ROWS / (g->point_count + g->row_count + 1);
    for (int i = 0; i < most && !g->woke; i++) {
        bool more = strike_once(g, on, rate, i < most - 1 && g->sweeps < last);
        note_joints(g);
        if (!more)
            break;
    }
    g->lost += before - group_kinetic(g);
    g->point_count = 0;
    arena_rewind(g->arena, mark);
}

/* A stop bounds the velocities at the end of a substep, and bodies are moved by the mean of those and its first: what ran into it at 20 rad/s
 * was half of that way past it. So it is struck at the start, down to what takes a joint no farther than to its stop; what is left of the
 * speed goes with the next substep. Plastic, and with what touches, which takes its share and does not bounce. */
void strike_stops(Group *g)
{
    build_rows(g, true);
    ArenaMark mark = arena_mark(g->arena);
    Outcome start, end;
    bool *on = arena_zero(g->arena, (size_t)(g->point_count + 1) * sizeof *on);
    real (*before)[3] = arena_alloc(g->arena, (size_t)(g->point_count + 1) * sizeof *before), had = group_kinetic(g);
    if (!on || !before || !outcome_open(g, &start) || !outcome_open(g, &end)) {
        g->status = DIG_E_MEMORY;
        return;
    }
    for (int i = 0; i < g->point_count; i++) {
        PointRow *r = &g->points[i];
        find_rates(g, r, before[i]);
        r->jn = r->jt[0] = r->jt[1] = 0;
        r->target = real_min(before[i][0], -squeeze_of(g, r->contact).rate);
        r->slides = hypot(before[i][1], before[i][2]) > 0.1 * g->close_speed;
        on[i] = true;
    }
    keep_outcome(g, &start);
    memcpy(g->start_vel, g->vel, (size_t)g->body_count * sizeof *g->vel);       /* what a rescue begins with */
    real worst = g->residual;
    g->residual = 0;
    relax(g, impact_sweeps(g), g->plan->residual);
    if (g->residual > VELOCITY_COARSE)
        direct_rescue(g);
    g->residual = real_max(g->residual, worst);
    g->strikes_stops = true;
    if (!struck_by_mover(g, on) && !(group_kinetic(g) <= had * ENERGY_KEPT)) {
        keep_outcome(g, &end);
        set_capped(g, &start, &end, had);
    }
    g->strikes_stops = false;
    for (int i = 0; i < g->point_count; i++) {
        book_strike(g, &g->points[i], before[i]);
        note_strike(g, &g->points[i], real_max(0, -before[i][0]));
    }
    note_joints(g);
    g->lost += had - group_kinetic(g);
    g->point_count = 0;
    arena_rewind(g->arena, mark);
}
