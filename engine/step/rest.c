/* step/rest.c - who comes to rest, and which DIGs fall asleep.
 *
 * Rest is a mode, not a small speed: a body whose contacts or joints have held
 * it still for two steps gets exactly zero velocity (constraint mode of the
 * founding document). A DIG all of whose members are slow for half a second
 * sleeps and costs nothing until something disturbs it. In a crowd, whose
 * solver trembles, it is the way of half a second that is looked at: of 1500
 * boxes that lay in a heap, 200 to 300 were faster than 2 mm/s at some step of
 * it, and two to seven got anywhere by it.
 */
#include "step/step.h"
#include "world/joint.h"

/* m/s; solver noise of a body at rest is far below, real motion passes it within a step or two. What is damped hard creeps for
 * seconds, and stays off its end by its way in them: finer accuracies rest at lower speeds. */
#define REST_SPEED 1e-6
#define REST_PART 1e-2          /* 1/s  of the tolerance */
#define SWING_SPEED 1e-8        /* m/s: what only joints hold swings, and is this slow for two steps at the end alone */
/* m/s: slower than this for SLEEP_TIME, and a DIG sleeps */
#define SLEEP_SPEED 2e-3

#define DRIFT_PART 0.025        /* 1  of the size: one of a crowd that gets no farther in SLEEP_TIME is slow   */
#define DRIFT_MOST 5e-3         /* m  however large it is; of small ones, the way at SLEEP_SPEED is left to all */
#define AWAKE_SPEED 1e-2        /* m/s  and no member may be as fast as this at the moment when all fall asleep: what gathers speed, or spins, goes on */

/* m/s  By the time where it is. */
static real speed_of(const Body *b) { return (vec3_length(b->v) + vec3_length(b->w) * b->outer) / b->rate; }

/* What it touches or is joined to. */
typedef struct Ties { bool any, fixed; } Ties;         /* fixed: something that no impulse moves */

static void tie(const World *w, uint32_t other, Ties *t)
{
    t->any = true;
    t->fixed = t->fixed || other == NONE || w->bodies.data[other].kind != DIG_DYNAMIC;
}

static Ties ties_of(const World *w, uint32_t slot)
{
    const Body *b = &w->bodies.data[slot];
    Ties t = {false, false};
    for (uint32_t j = b->joint_first; j != NONE && !t.fixed; j = joint_next(w, j, slot))
        tie(w, w->joints.data[j].a == slot ? w->joints.data[j].b : w->joints.data[j].a, &t);
    for (uint32_t s = b->shape_first; s != NONE; s = w->solids.data[s].next)
        for (uint32_t l = w->solids.data[s].pair_first; l != NONE && !t.fixed; l = w->pairs.data[l / 2].next[l % 2]) {
            const Pair *p = &w->pairs.data[l / 2];
            if (p->touching)
                tie(w, l % 2 ? p->body_a : p->body_b, &t);
        }
    return t;
}

typedef struct Anchor { uint32_t lead; bool held; } Anchor;    /* what was found of the DIG asked for last */

/* Does something hold it up? A DIG that holds on to nothing else floats: it keeps its momentum, slow as it may be. */
static bool is_held(const World *w, uint32_t slot, Anchor *known)
{
    const Body *b = &w->bodies.data[slot];
    Ties own = ties_of(w, slot);
    if (!own.any || own.fixed || (vec3_is_zero(b->v) && vec3_is_zero(b->w)))
        return own.any;
    uint32_t lead = graph_lead(w->graph, slot);
    if (known->lead != lead) {
        *known = (Anchor){lead, false};
        for (uint32_t m = lead; m != NONE && !known->held; m = graph_next(w->graph, m))
            known->held = ties_of(w, m).fixed;
    }
    return known->held;
}

/* What little it moved by is lost: J. */
static real stop(Body *b)
{
    vec3 spin = quat_unrotate(b->q, b->w);
    real lost = 0.5 * body_inertness(b) * (b->mass * vec3_length2(b->v) + vec3_dot(spin, mat3_mul_vec(body_inertia(b)->of, spin)));
    b->v = b->w = vec3_zero();
    return lost;
}

static bool touches(const World *w, const Body *b)
{
    for (uint32_t s = b->shape_first; s != NONE; s = w->solids.data[s].next)
        for (uint32_t l = w->solids.data[s].pair_first; l != NONE; l = w->pairs.data[l / 2].next[l % 2])
            if (w->pairs.data[l / 2].touching)
                return true;
    return false;
}

static bool creeps(const World *w, uint32_t slot, real speed)
{
    int accuracy = int_max(w->accuracy, (int)graph_user_of(w->graph, graph_lead(w->graph, slot)));
    return speed >= REST_PART * accuracy_tolerance(accuracy) || (speed >= SWING_SPEED && !touches(w, &w->bodies.data[slot]));
}

/* s  For how long it has been slow. Healing moves what has no velocity: who is being moved out of an overlap is not still. */
static real still_for(World *w, Body *b, real speed, real dt)
{
    if (!b->crowded)
        return speed < SLEEP_SPEED && vec3_distance(b->x, b->prev_x) < SLEEP_SPEED * dt * b->rate ? b->still + dt : 0;
    Drift *d = body_drift(w, b);
    real way = vec3_length(d->way) + vec3_length(d->turn) * b->outer;
    bool slow = way < real_clamp(DRIFT_PART * b->outer, SLEEP_SPEED * SLEEP_TIME, DRIFT_MOST) * b->rate;
    real still = slow ? b->still + dt : 0;
    if (floor(still / SLEEP_TIME) > floor(b->still / SLEEP_TIME))      /* a creep gets to any place in time */
        *d = (Drift){vec3_zero(), vec3_zero()};
    return still;
}

/* Returns the energy lost by it, J. */
static real settle(World *w, uint32_t slot, real dt, Anchor *known)
{
    Body *b = &w->bodies.data[slot];
    real speed = speed_of(b);
    b->still = still_for(w, b, speed, dt);
    if (speed < REST_SPEED && b->still >= 2 * dt && is_held(w, slot, known)) {
        if (speed > 0 && creeps(w, slot, speed))
            return 0;
        b->mode = DIG_RESTING;
        return stop(b);
    }
    if (speed >= REST_SPEED)
        b->mode = DIG_MOVING;
    return 0;
}

static bool is_on_its_way(const Body *b) { return b->kind == DIG_KINEMATIC && (vec3_length2(b->v) > 0 || vec3_length2(b->w) > 0); }

/* By a joint: asleep, it would stay behind, for nothing tells it. */
static bool is_towed(const World *w, uint32_t slot)
{
    for (uint32_t j = w->bodies.data[slot].joint_first; j != NONE; j = joint_next(w, j, slot)) {
        uint32_t other = w->joints.data[j].a == slot ? w->joints.data[j].b : w->joints.data[j].a;
        if (other != NONE && is_on_its_way(&w->bodies.data[other]))
            return true;
    }
    return false;
}

/* Would the mover wake it at once? (groups.c) */
static bool is_carried(const World *w, const Body *b)
{
    for (uint32_t s = b->shape_first; s != NONE; s = w->solids.data[s].next)
        for (uint32_t l = w->solids.data[s].pair_first; l != NONE; l = w->pairs.data[l / 2].next[l % 2]) {
            const Pair *p = &w->pairs.data[l / 2];
            const Solid *other = &w->solids.data[l % 2 ? p->solid_a : p->solid_b];
            const Body *o = other->body == NONE ? NULL : &w->bodies.data[other->body];
            if (o && is_on_its_way(o) && box3_overlap(w->solids.data[s].reach, other->reach))
                return true;
        }
    return false;
}

/* A member that a mover carries or tows, or that nothing holds, keeps its DIG awake. */
static bool may_sleep(const World *w, uint32_t lead)
{
    for (uint32_t m = lead; m != NONE; m = graph_next(w->graph, m))      /* mostly one of them says no at once */
        if (w->bodies.data[m].still < SLEEP_TIME || speed_of(&w->bodies.data[m]) >= AWAKE_SPEED)
            return false;
    Anchor known = {NONE, false};
    for (uint32_t m = lead; m != NONE; m = graph_next(w->graph, m)) {
        if (!is_held(w, m, &known) || is_carried(w, &w->bodies.data[m]) || is_towed(w, m))
            return false;
    }
    return true;
}

static void fall_asleep(World *w, uint32_t lead)
{
    for (uint32_t m = lead; m != NONE; m = graph_next(w->graph, m)) {
        Body *b = &w->bodies.data[m];
        b->awake = false;
        b->mode = DIG_RESTING;
        w->ledger.lost += stop(b);
        b->force = b->torque = vec3_zero();
        event_post(w, DIG_EVENT_SLEPT, m, NONE);
    }
}

#define SHARED_LEAST 256        /* bodies: fewer are not worth a team */

typedef struct Resting { World *w; real dt, *lost; } Resting;       /* [awake] J; NULL: it goes to the ledger at once */

/* Of another body nothing is asked that changes here. */
INLINE void rest_share(void *context, int thread, int threads)
{
    const Resting *r = context;
    World *w = r->w;
    Anchor known = {NONE, false};
    for (int i = team_first(w->awake.count, thread, threads), end = team_end(w->awake.count, thread, threads); i < end; i++) {
        uint32_t slot = w->awake.data[i];
        if (i + FETCH_AHEAD < w->awake.count)
            fetch_soon(&w->bodies.data[w->awake.data[i + FETCH_AHEAD]], offsetof(Body, inertia));
        real lost = w->bodies.data[slot].kind == DIG_DYNAMIC ? settle(w, slot, r->dt, &known) : 0;
        if (r->lost)
            r->lost[i] = lost;
        else
            w->ledger.lost += lost;
    }
}

/* What they lose is added in their order, for any number of threads. Where there is no memory for that, one thread does it all. */
static void settle_all(World *w, real dt)
{
    Resting r = {.w = w, .dt = dt};
    Team *team = w->awake.count < SHARED_LEAST ? NULL : workers_team(w->workers);
    r.lost = team ? arena_alloc(&w->scratch, (size_t)w->awake.count * sizeof *r.lost) : NULL;
    team_deal(r.lost ? team : NULL, rest_share, &r);
    for (int i = 0; i < w->awake.count && r.lost; i++)
        w->ledger.lost += r.lost[i];
}

void rest(World *w, real dt)
{
    settle_all(w, dt);
    if (!w->def.sleeping)
        return;
    for (int i = 0; i < w->awake.count; i++) {
        uint32_t slot = w->awake.data[i];
        const Body *b = &w->bodies.data[slot];
        /* asked once per DIG: at its first member */
        if (b->kind == DIG_DYNAMIC && b->awake && b->still >= SLEEP_TIME && graph_lead(w->graph, slot) == slot && may_sleep(w, slot))
            fall_asleep(w, slot);
    }
}
