/* conserve/way.c - when the energy-momentum way takes a group, how it cuts the step, and what it reports. */
#include "conserve/conserve.h"
#include "conserve/system.h"

#define LEVELS 10               /* halvings of a part of the step                              */
#define EASY 8                  /* iterations; two such steps in a row, and the next are longer */
#define SPIN_MOST 0.5           /* rad of one step, of what carries the energy                 */
#define CARE 200                /* iterations, after which a frame step no longer heeds that   */
#define COMPOSED_LEVEL 1        /* halvings for the spin, past which single steps are cheaper  */
#define COMPOSED_MOST 64        /* parts of a step                                             */

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
static int budget_of(const Group *g)
{
    return (int)real_clamp(400000.0 / (g->moving_count + g->joint_count + 20), 1000, 20000) + 100 * parts_of(g->plan);
}

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
    return p->gap < closing * time + vec3_length(g->gravity) * time * time + 1e-4 * g->pairs[c->pair].size;
}

static bool any_closes(const Group *g, real time)
{
    for (int i = 0; i < g->contact_count; i++) {
        const GroupContact *c = &g->contacts[i];
        if (!g->member[c->a].moves && !g->member[c->b].moves)
            continue;
        for (int k = 0; c->live && k < c->manifold.count; k++)
            if (may_close(g, c, &c->manifold.points[k], time))
                return true;
    }
    return false;
}

static bool any_deep(const Group *g)
{
    for (int i = 0; i < g->contact_count; i++)
        for (int k = 0; g->contacts[i].live && k < g->contacts[i].manifold.count; k++)
            if (g->contacts[i].manifold.points[k].gap < 0)
                return true;
    return false;
}

static bool suits(const Group *g)
{
    if (!g->may_trace)          /* thousands of small mechanisms are swept */
        return false;
    if (g->joint_count == 0 || g->planar || any_deep(g))
        return false;
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves && g->member[i].integrator != DIG_AUTO)
            return false;
    for (int i = 0; i < g->contact_count; i++)
        for (int k = 0; g->contacts[i].live && k < g->contacts[i].manifold.count; k++)
            if (g->contacts[i].memory[k].normal > 0)
                return false;           /* it carried load a step ago */
    return parts_understood(g);
}

/* ---- the group as it was ---- */

typedef struct Saved {
    Group g;
    Pos *pos; Vel *vel; Mass *mass; Member *member; real *work;
    GroupJoint *joints;
    GroupContact *contacts;
    GroupPair *pairs;
} Saved;

static void *copy_of(Arena *arena, const void *from, int count, size_t size)
{
    void *p = arena_alloc(arena, (size_t)(count + 1) * size);
    if (p && count > 0)
        memcpy(p, from, (size_t)count * size);
    return p;
}

static dig_status save(const Group *g, Saved *s)
{
    s->g = *g;
    s->pos = copy_of(g->arena, g->pos, g->body_count, sizeof *g->pos);
    s->vel = copy_of(g->arena, g->vel, g->body_count, sizeof *g->vel);
    s->mass = copy_of(g->arena, g->mass, g->body_count, sizeof *g->mass);
    s->member = copy_of(g->arena, g->member, g->body_count, sizeof *g->member);
    s->work = copy_of(g->arena, g->push_work, g->body_count, sizeof *g->push_work);
    s->joints = copy_of(g->arena, g->joints, g->joint_count, sizeof *g->joints);
    s->contacts = copy_of(g->arena, g->contacts, g->contact_count, sizeof *g->contacts);
    s->pairs = copy_of(g->arena, g->pairs, g->pair_count, sizeof *g->pairs);
    return s->pos && s->vel && s->mass && s->member && s->work && s->joints && s->contacts && s->pairs ? DIG_OK : DIG_E_MEMORY;
}

static void put_back(void *to, const void *from, int count, size_t size)
{
    if (count > 0)
        memcpy(to, from, (size_t)count * size);
}

/* What it cost stays in the report. */
static void go_back(Group *g, const Saved *s)
{
    int evaluations = g->evaluations, refused = g->refused;
    put_back(g->pos, s->pos, g->body_count, sizeof *g->pos);
    put_back(g->vel, s->vel, g->body_count, sizeof *g->vel);
    put_back(g->mass, s->mass, g->body_count, sizeof *g->mass);
    put_back(g->member, s->member, g->body_count, sizeof *g->member);
    put_back(g->push_work, s->work, g->body_count, sizeof *g->push_work);
    put_back(g->joints, s->joints, g->joint_count, sizeof *g->joints);
    put_back(g->contacts, s->contacts, g->contact_count, sizeof *g->contacts);
    put_back(g->pairs, s->pairs, g->pair_count, sizeof *g->pairs);
    *g = s->g;
    g->evaluations = evaluations;
    g->refused = refused;
}

/* why: what was tried in vain; NULL: nothing was tried, the group is not for this way. */
static dig_status hand_on(Group *g, const Saved *s, const char *why)
{
    go_back(g, s);
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
        real spin = vec3_dot(w, mat3_mul_vec(m->inertia, w)), w2 = vec3_length2(w);
        if (!m->moves)
            continue;
        sum += spin * w2;
        energy += spin + m->mass * vec3_length2(g->vel[i].v);
    }
    return energy > 0 ? sqrt(sum / energy) : 0;
}

/* Composed parts: the local error of the fourth order goes with the fifth power of the angle turned. 0.16 rad at "play", 0.04 at
 * "study", 0.01 at "reference". What is larger than a traced group takes no more than there are substeps: a long chain that cracks
 * like a whip would ask for many, and is beyond prediction then. */
static int composed_parts(const Group *g, real dt)
{
    real angle = 2.5 * pow(g->tolerance, 0.2), most = g->moving_count > g->plan->trace_bodies ? g->plan->substeps : COMPOSED_MOST;
    return (int)real_clamp(ceil(turning_rate(g) * dt / angle), ceil(sqrt(parts_of(g->plan))), most);
}

static real fastest_spin(const Group *g)
{
    real w = 0;
    for (int i = 0; i < g->moving_count; i++)
        w = real_max(w, vec3_length2(g->vel[i].w));
    return sqrt(w);
}

/* What was given or hit, or jointed anew, may break the joints' velocities; the rule would mirror that for ever. */
static bool wants_cleaning(const Group *g)
{
    for (int i = 0; i < g->moving_count; i++) {
        const Body *b = &g->world->bodies.data[g->member[i].slot];
        if (vec3_length2(b->hit_v) > 0 || vec3_length2(b->hit_w) > 0 || b->collided)
            return true;
    }
    for (int i = 0; i < g->joint_count; i++) {
        bool fresh = true;
        for (int k = 0; k < JOINT_SLOTS; k++)
            fresh = fresh && g->joints[i].force[k] == 0;
        if (fresh)
            return true;
    }
    return false;
}

static dig_status part(System *s, real h, bool composed, bool *done)
{
    *done = true;
    for (int i = 0; *done && i < (composed ? STAGES : 1); i++) {
        s->h = composed ? stages[i] * h : h;
        DIG_TRY(step_single(s, done));
    }
    return DIG_OK;
}

typedef struct Run { int at, total, level, easy; bool composed; const char *why; } Run;

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
    bool done;
    g->t = dt * r->at / r->total;
    DIG_TRY(part(s, dt * width / r->total, r->composed, &done));
    if (!done) {
        g->refused++;
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
    else if (fastest_spin(g) * g->h > 0.5 && !step_watch(g, false))
        r->why = "conserve: a joint met its stop";
    if (r->why)
        return DIG_OK;
    r->easy = g->evaluations - before <= EASY * (r->composed ? STAGES : 1) ? r->easy + 1 : 0;
    if (r->level > 0 && r->easy >= 2 && r->at % (2 * width) == 0) {
        r->level--;
        r->easy = 0;
    }
    return g->stage(g, STAGE_FLOW);
}

/* From the start of the frame to its end; *why: it could not. */
static dig_status run(Group *g, real dt, int parts, bool composed, System *s, const char **why)
{
    Run r = {.total = parts << LEVELS, .composed = composed};
    *why = NULL;
    DIG_TRY(step_open(s, g));
    s->precise = composed;
    if (!step_place(s))
        r.why = "conserve: no poses obey the joints";
    else if (wants_cleaning(g) && !step_clean(s))
        r.why = "conserve: no velocities obey the joints";
    while (r.at < r.total && !g->woke && !r.why)
        DIG_TRY(next_part(s, &r, dt));
    *why = r.why;
    return DIG_OK;
}

/* Backward steps and dampers do not go together. */
static bool may_compose(const Group *g)
{
    if (g->world->region_count > 0)
        return false;
    for (int i = 0; i < g->joint_count; i++) {
        Row rows[JOINT_SLOTS];
        RowList list = {rows, 0, JOINT_SLOTS};
        g->joints[i].view.type->rows(&g->joints[i].view, &list);
        for (int k = 0; k < list.count; k++)
            if (rows[k].kind == ROW_SOFT && rows[k].damping > 0)
                return false;
    }
    return true;
}

static dig_status advance(Group *g, real dt)
{
    Saved saved;
    System s;
    const char *why;
    DIG_TRY(save(g, &saved));
    group_touch(g, 2 * dt, true);
    if (any_closes(g, dt))
        return hand_on(g, &saved, NULL);                /* something may touch */
    for (int i = 0; i < g->joint_count; i++)
        group_joint_view(g, i);
    bool composed = is_small(g) && may_compose(g);
    int parts = composed ? composed_parts(g, dt) : is_small(g) ? g->plan->substeps : parts_of(g->plan);
    DIG_TRY(run(g, dt, parts, composed, &s, &why));
    if (why && composed) {
        go_back(g, &saved);                             /* single steps then */
        DIG_TRY(run(g, dt, parts_of(g->plan), false, &s, &why));
    }
    if (why)
        return hand_on(g, &saved, why);
    if (g->woke)
        return DIG_OK;
    if (!step_watch(g, true))
        return hand_on(g, &saved, "conserve: a joint met its stop");
    group_touch(g, dt / g->plan->substeps, true);
    if (any_deep(g))
        return hand_on(g, &saved, "conserve: bodies met");
    step_remember(&s);
    DIG_TRY(g->stage(g, STAGE_SETTLE));
    return g->status;
}

const Way way_conserve = {.name = "conserve", .tally = WAY_CONSERVED, .suits = suits, .advance = advance};
