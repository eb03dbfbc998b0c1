/* conserve/way.c - when the energy-momentum way takes a group, how it cuts the step, and what it reports. */
#include "conserve/conserve.h"
#include "conserve/system.h"
#include "solve/momentum.h"

#define EASY 8                  /* iterations; two such steps in a row, and the next are longer */
#define SPIN_MOST 0.5           /* rad of one step, of what carries the energy                 */
#define CARE 200                /* iterations, after which a frame step no longer heeds that   */
#define COMPOSED_LEVEL 1        /* halvings for the spin, past which single steps are cheaper  */
#define COMPOSED_MOST 64        /* parts of a step                                             */
#define LEAST_MOST 7            /* of the parts that the tolerance alone asks for              */
#define CREEPS 10               /* decay of a damped motion within the step, from which it creeps */
#define EXTRAPOLATED_MOST 4     /* parts of a step, over its substeps                          */

/* A part of the step made of five steps, one of them backward: fourth order from a symmetric rule of second order, and every
 * conserved quantity stays conserved. Suzuki 1990, Phys. Lett. A 146, 319: 1 / (4 - 4^(1/3)) and 1 - 4 of that. */
#define STAGES 5
#define FORWARD 0.41449077179437573714
#define BACKWARD (-0.65796308717750294856)
static const real stages[STAGES] = {FORWARD, FORWARD, BACKWARD, FORWARD, FORWARD};

/* Single steps at the four plans: 1, 1, 4, 16. */
static int parts_of(const AccuracyPlan *plan) { return int_max(1, plan->substeps / 4); }

/* As many bodies as have their impacts located may cost more. */
static bool is_small(const Group *g) { return g->plan->substeps >= 4 && g->moving_count <= g->plan->events_bodies; }

/* Iterations that one step may take before the group is handed on: counted in joints and bodies, as that is their cost. */
static int budget_of(const Group *g) { return rough_budget(g) + 100 * parts_of(g->plan); }

/* ---- contacts: nothing may touch ---- */

static vec3 point_velocity(const Group *g, int body, vec3 at)
{
    return vec3_add(g->vel[body].v, vec3_cross(g->vel[body].w, vec3_sub(at, g->pos[body].x)));
}

/* Could the point close in the time? Speeds may double. */
static bool may_close(const Group *g, const GroupContact *c, const ManifoldPoint *p, real time)
{
    vec3 v = vec3_sub(point_velocity(g, c->b, p->b), point_velocity(g, c->a, p->a));
    real closing = real_max(0, -vec3_dot(c->manifold.normal, v)) + vec3_length(v);
    real thrown = group_thrown(g, c->a, time) + group_thrown(g, c->b, time);
    return p->gap < closing * time + g->fall * time * time + thrown + 1e-4 * g->pairs[c->pair].size;
}

/* m/s  No point of `other` gets nearer to the body faster: its speed as seen from there, where what turns with the body stands still. */
static real approach(const Group *g, int body, int other)
{
    const Vel *v = &g->vel[body], *u = &g->vel[other];
    real turns = vec3_distance(u->w, v->w), rim = g->member[other].outer;
    if (turns > 0 && !isfinite(rim))
        return INFINITY;
    vec3 centre = vec3_sub(u->v, point_velocity(g, body, g->pos[other].x));
    return vec3_length(centre) + (turns > 0 ? turns * rim : 0);
}

/* m  Across such a gap the two may meet. Nearest points are nearest now: those of an arm may be at its pivot, and what its end will strike
 * elsewhere. What goes less far than both are thick is found to have met at the end. */
static real comes_round(const Group *g, const GroupContact *c, real time)
{
    const GroupPair *q = &g->pairs[c->pair];
    real thrown = group_thrown(g, c->a, time) + group_thrown(g, c->b, time);
    real way = real_min(approach(g, c->a, c->b), approach(g, c->b, c->a)) * time + g->fall * time * time + thrown;
    return way > q->on_a->shape.inner + q->on_b->shape.inner ? way : -INFINITY;
}

static bool any_closes(const Group *g, real time)
{
    for (int i = 0; i < g->contact_count; i++) {
        const GroupContact *c = &g->contacts[i];
        if (!g->member[c->a].moves && !g->member[c->b].moves)
            continue;
        real round = c->live ? comes_round(g, c, time) : -INFINITY;
        for (int k = 0; c->live && k < c->manifold.count; k++)
            if (may_close(g, c, &c->manifold.points[k], time) || c->manifold.points[k].gap < round)
                return true;
    }
    return false;
}

static bool suits(const Group *g)
{
    if (!g->may_trace)          /* thousands of small mechanisms are swept */
        return false;
    if (g->joint_count == 0 || g->planar || group_deep(g))
        return false;
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves && g->member[i].integrator != DIG_AUTO)
            return false;
    for (int i = 0; i < g->contact_count; i++)
        for (int k = 0; g->contacts[i].live && k < g->contacts[i].manifold.count; k++)
            if (contact_memory(&g->contacts[i])[k].normal > 0)
                return false;           /* it carried load a step ago */
    return parts_understood(g);
}

/* why: what was tried in vain; NULL: nothing was tried, the group is not for this way. */
static dig_status hand_on(Group *g, const GroupKept *s, const char *why)
{
    group_put_back(g, s);
    g->handed_on = true;
    g->conserve_failed = why != NULL;
    if (why)
        g->gave_up = why;
    return DIG_OK;
}

/* ---- one frame step ---- */

/* rad/s  Rates of turn, weighed with the energy they carry: a flywheel counts, a flailing link of little mass does not. */
static real turning_rate(const Group *g)
{
    real sum = 0, energy = 0;
    for (int i = 0; i < g->moving_count; i++) {
        const Member *m = &g->member[i];
        vec3 w = quat_unrotate(g->pos[i].q, g->vel[i].w);
        real spin = vec3_dot(w, mat3_mul_vec(*m->inertia, w)), w2 = vec3_length2(w);
        if (!m->moves)
            continue;
        sum += spin * w2;
        energy += spin + m->mass * vec3_length2(g->vel[i].v);
    }
    return energy > 0 ? sqrt(sum / energy) : 0;
}

/* Composed parts: the local error of the fourth order goes with the fifth power of the angle turned. 0.16 rad at "play", 0.04 at
 * "study", 0.01 at "reference". Slow mechanisms err by their loops rather than by what they turn: at least 2 parts at "study", and as many
 * more as the fourth order asks for (Bricard's mechanism: 4.2e-10 m there, 2.8e-12 m with 7). Past 7 it gets worse where bars pass a
 * straight position: rounding of 1e-16 m leaves the branch open within its root, 1e-8 m, which a shorter step makes a larger velocity.
 * What is larger than a traced group takes no more than there are substeps: a long chain that cracks
 * like a whip would ask for many, and is beyond prediction then. */
static int composed_parts(const Group *g, real dt)
{
    real angle = 2.5 * pow(g->tolerance, 0.2), most = g->moving_count > g->plan->trace_bodies ? g->plan->substeps : COMPOSED_MOST;
    real least = real_min(ceil(2 * pow(1e-9 / g->tolerance, 0.25)), LEAST_MOST);
    return (int)real_clamp(ceil(turning_rate(g) * dt / angle), least, most);
}

static dig_status part(System *s, real h, bool composed, bool *done)
{
    *done = true;
    s->pulls = 0;
    s->since = 0;
    for (int i = 0; *done && i < (composed ? STAGES : 1); i++) {
        s->h = composed ? stages[i] * h : h;
        DIG_TRY(step_single(s, done));
    }
    s->g->substeps += *done;            /* one step of the fourth order, as the stages of an explicit one are no steps */
    return DIG_OK;
}

typedef struct Run { int at, total, level, easy; bool composed, breaks, extrapolated, cut; const char *why; } Run;     /* cut: a step of it was refused */

/* The equations of the joints there are now, and how exactly they are solved. */
static dig_status open_run(System *s, Group *g, const Run *r)
{
    DIG_TRY(step_open(s, g));
    s->precise = r->composed;
    s->lends = !r->extrapolated;
    return DIG_OK;
}

/* The joint most over its limit after a part of the step lets go at its start, where that was kept (else now): *undone, the part is to be done again
 * without it, so that what it bore is on others, or on none, before the next is judged. The equations of the rest are others. */
static dig_status part_joints(System *s, Run *r, real dt, bool kept, bool *undone)
{
    Group *g = s->g;
    real share;
    int worst = group_overloaded(g, dt, &share);
    if (worst < 0)
        return DIG_OK;
    *undone = kept;
    if (kept) {
        group_back_before(g);
        r->at -= 1 << (LEVELS - r->level);
        r->easy = 0;
    }
    for (int i = 0; i < g->joint_count; i++)
        group_joint_view(g, i);
    step_remember(s);
    group_part(g, worst, share);
    if (!parts_understood(g))
        r->why = "conserve: a joint met its stop";
    return r->why ? DIG_OK : open_run(s, g, r);
}

/* The next part from r->at on. A single step that fails is halved; after two easy ones the next is longer. */
static dig_status next_part(System *s, Run *r, real dt)
{
    Group *g = s->g;
    bool heed = g->evaluations < CARE * parts_of(g->plan) * (r->composed ? STAGES : 1);
    while (heed && r->level < LEVELS && turning_rate(g) * (dt * (1 << (LEVELS - r->level)) / r->total) > SPIN_MOST)
        r->level++;
    if (r->composed && r->level > COMPOSED_LEVEL) {
        r->why = "conserve: too fast a turn";
        return DIG_OK;
    }
    int width = 1 << (LEVELS - r->level), before = g->evaluations;
    bool done, undone = false, kept = r->breaks && group_may_part(g);
    g->t = dt * r->at / r->total;
    if (kept && !group_keep_before(g))
        return DIG_E_MEMORY;
    DIG_TRY(part(s, dt * width / r->total, r->composed, &done));
    if (!done) {
        g->refused++;
        r->cut = true;
        r->easy = 0;
        r->level++;
        if (r->composed || r->level > LEVELS)
            r->why = "conserve: no solution at the shortest step";
        return DIG_OK;
    }
    r->at += width;
    g->t = dt * r->at / r->total;
    g->h = dt * width / r->total;
    if (g->evaluations > budget_of(g))
        r->why = "conserve: too many iterations";
    else if (step_fastest_spin(g) * g->h > 0.5 && !step_watch(g, false))
        r->why = "conserve: a joint met its stop";
    if (r->breaks && !r->why)
        DIG_TRY(part_joints(s, r, dt, kept, &undone));
    if (r->why || undone)
        return DIG_OK;
    if (r->cut && !r->composed && !r->extrapolated)
        DIG_TRY(step_settle(s));        /* what lies across the joints grows from step to step, and is what has no solution */
    r->easy = g->evaluations - before <= EASY * (r->composed ? STAGES : 1) ? r->easy + 1 : 0;
    if (r->level > 0 && r->easy >= 2 && r->at % (2 * width) == 0) {
        r->level--;
        r->easy = 0;
    }
    return DIG_OK;
}

static Run run_of(int parts, bool composed, bool breaks) { return (Run){.total = parts << LEVELS, .composed = composed, .breaks = breaks}; }

/* From the start of the frame to its end; *why: it could not. */
static dig_status run(Group *g, real dt, Run r, System *s, const char **why)
{
    *why = NULL;
    DIG_TRY(open_run(s, g, &r));
    s->unplaced = !step_place(s);
    if (s->unplaced)
        r.why = "conserve: no poses obey the joints";
    else if (group_joints_broken(g) && !step_clean(s))         /* the rule would mirror that for ever */
        r.why = "conserve: no velocities obey the joints";
    while (r.at < r.total && !g->woke && !r.why)
        DIG_TRY(next_part(s, &r, dt));
    *why = r.why;
    return DIG_OK;
}

/* Composed: nothing is lost; backward steps and dampers do not go together. Extrapolated: what dampers hold back so much that its speed
 * is gone within the step creeps, and the error of single steps is a series in the square of their length however long they are. */
typedef enum Kind { SINGLE, COMPOSED, EXTRAPOLATED } Kind;

static Kind kind_of(const Group *g, real dt)
{
    Kind kind = COMPOSED;
    if (!is_small(g) || g->world->region_count > 0 || g->varies)
        return SINGLE;
    for (int i = 0; i < g->joint_count; i++) {
        Row rows[JOINT_SLOTS];
        RowList list = {rows, 0, JOINT_SLOTS};
        g->joints[i].view.type->rows(&g->joints[i].view, &list);
        for (int k = 0; k < list.count; k++) {
            if (rows[k].kind != ROW_SOFT || !(rows[k].damping > 0))
                continue;
            real mobility = 0;
            for (int m = 0; m < rows[k].count; m++)
                mobility += group_row_mobility(g, &rows[k], m);
            if (rows[k].damping < dt * rows[k].stiffness || rows[k].damping * mobility * dt < CREEPS)
                return SINGLE;
            kind = EXTRAPOLATED;
        }
    }
    return kind;
}

static real largest(const Group *g)
{
    real size = 0;
    for (int i = 0; i < g->moving_count; i++)
        size = real_max(size, g->member[i].outer);
    return size;
}

/* 2 steps, 4, 8, ... until their extrapolation tells that its error is within the tolerance: then nothing was given up. Odd numbers
 * would part with the others: what a step overshoots the next takes back. */
static dig_status extrapolate(Group *g, real dt, const GroupKept *from, System *s, const char **why)
{
    Romberg table;
    real most = g->tolerance * largest(g);
    DIG_TRY(romberg_open(&table, g));
    for (int parts = 2; parts <= EXTRAPOLATED_MOST * g->plan->substeps && table.rows < ROMBERG_ROWS && table.error > most; parts *= 2) {
        if (table.rows > 0)
            group_put_back(g, from);
        Run r = run_of(parts, false, false);
        r.extrapolated = true;
        DIG_TRY(run(g, dt, r, s, why));
        if (*why || g->woke)
            return DIG_OK;
        romberg_enter(&table, g, from);
    }
    romberg_take(&table, g, from);
    if (table.error <= most)
        g->gave_up = NULL;
    else if (!g->gave_up)
        g->gave_up = "conserve: an error above its tolerance";
    return DIG_OK;
}

#define STANDS 1e-3             /* of how far its speed would have taken it */
#define TURNED 1.0              /* rad in the step: what turns farther may have come round */
#define WORKED 0.1              /* of the kinetic energy: forces that do so much may have turned it back */

/* Does it stand, by where it was, though it has speed? */
static bool stands(const Group *g, int i, const Pos *before, real dt)
{
    const Member *m = &g->member[i];
    real speed = vec3_length(g->vel[i].v) + m->outer * vec3_length(g->vel[i].w), turned = vec3_length(g->vel[i].w) * dt;
    quat turn = quat_mul(g->pos[i].q, quat_conjugate(before->q));
    real moved = vec3_distance(g->pos[i].x, before->x) + 2 * m->outer * vec3_length((vec3){turn.x, turn.y, turn.z});
    real work = dt * (fabs(vec3_dot(m->force, g->vel[i].v)) + fabs(vec3_dot(m->torque, g->vel[i].w)));
    return moved <= STANDS * dt * speed && turned < TURNED && work <= WORKED * group_kinetic_of(g, i);
}

/* Joints that let nothing move, by less than they are solved to, take a speed as one that they mirror in each single step, for ever: a door on hinges
 * whose axes are 0.1 mm apart. What stands has none. */
static void lock(Group *g, const GroupKept *from, real dt)
{
    real kinetic = group_kinetic(g);
    bool still = kinetic > 0;
    for (int i = 0; i < g->moving_count && still; i++)
        still = !g->member[i].moves || stands(g, i, &from->pos[i], dt);
    for (int i = 0; i < g->joint_count && still; i++) {
        Row rows[JOINT_SLOTS];
        RowList list = {rows, 0, JOINT_SLOTS};
        g->joints[i].view.type->rows(&g->joints[i].view, &list);
        for (int k = 0; k < list.count; k++)
            still = still && rows[k].kind != ROW_SOFT && rows[k].kind != ROW_MOTOR;
    }
    for (int i = 0; i < g->moving_count && still; i++)
        if (g->member[i].moves)
            g->vel[i] = (Vel){vec3_zero(), vec3_zero()};
    if (still) {
        g->lost += kinetic;
        g->gave_up = "conserve: joints that let nothing move";
    }
}

static dig_status advance(Group *g, real dt)
{
    GroupKept saved;
    System s;
    const char *why;
    if (!group_keep(g, &saved))
        return DIG_E_MEMORY;
    group_touch(g, 2 * dt, true);
    if (any_closes(g, dt))
        return hand_on(g, &saved, NULL);                /* something may touch */
    for (int i = 0; i < g->joint_count; i++)
        group_joint_view(g, i);
    Kind kind = kind_of(g, dt);
    int parts = kind == COMPOSED ? composed_parts(g, dt) : is_small(g) ? g->plan->substeps : parts_of(g->plan);
    if (kind == EXTRAPOLATED)
        DIG_TRY(extrapolate(g, dt, &saved, &s, &why));
    else
        DIG_TRY(run(g, dt, run_of(parts, kind == COMPOSED, false), &s, &why));
    if (why && kind != SINGLE) {
        group_put_back(g, &saved);                             /* single steps then */
        DIG_TRY(run(g, dt, run_of(parts_of(g->plan), false, false), &s, &why));
    }
    if (why && !s.unplaced) {           /* no solution, but there are poses */
        const char *vain;
        group_put_back(g, &saved);
        DIG_TRY(rough_run(g, dt, &s, &vain));
        if (!vain) {
            g->gave_up = why;
            why = NULL;
        }
    }
    real share;
    if (!why && !g->woke && group_overloaded(g, dt, &share) >= 0) {     /* when, and what then, is for short parts to find */
        group_put_back(g, &saved);
        g->breaks_found = true;
        DIG_TRY(run(g, dt, run_of(int_max(parts, g->plan->substeps), false, true), &s, &why));
    }
    if (why)
        return hand_on(g, &saved, why);
    if (g->woke)
        return DIG_OK;
    if (!step_watch(g, true))
        return hand_on(g, &saved, "conserve: a joint met its stop");
    group_touch(g, dt / g->plan->substeps, true);
    if (group_deep(g))
        return hand_on(g, &saved, "conserve: bodies met");
    step_remember(&s);
    if (kind != EXTRAPOLATED)
        DIG_TRY(step_settle(&s));
    lock(g, &saved, dt);
    DIG_TRY(group_hold_momenta(g, dt));
    DIG_TRY(g->stage(g, STAGE_SETTLE));
    return g->status;
}

const Way way_conserve = {.name = "conserve", .tally = WAY_CONSERVED, .suits = suits, .advance = advance, .inertias = true};
