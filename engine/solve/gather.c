/* solve/gather.c - the world's records become compact copies; solve/commit.c takes them back. */
#include "base/sort.h"
#include "solve/direction.h"
#include "solve/gather.h"

#include "world/joint.h"
#include "world/region.h"

static int find_slot(const uint32_t *slots, int count, uint32_t slot)
{
    int lo = 0, hi = count;
    if (count > 0 && slot - slots[0] < (uint32_t)count && slots[slot - slots[0]] == slot)
        return (int)(slot - slots[0]);      /* most slots of a group follow each other */
    while (lo < hi) {
        int mid = (lo + hi) / 2;
        if (slots[mid] < slot)
            lo = mid + 1;
        else
            hi = mid;
    }
    return lo < count && slots[lo] == slot ? lo : -1;
}

int local_of(const Group *g, uint32_t slot)
{
    if (slot == NONE)           /* the world itself comes last */
        return g->body_count - 1;
    int i = find_slot(g->slots, g->moving_count, slot);
    if (i >= 0)
        return i;
    i = find_slot(g->still, g->body_count - g->moving_count, slot);
    DIG_ASSERT(i >= 0);
    return g->moving_count + i;
}

/* Of what moves. */
static inline __attribute__((always_inline)) mat3 inverse_inertia(const Group *g, int i)
{
    const Member *m = &g->member[i];
    if (m->round)
        return *m->inv_inertia;
    mat3 r = quat_matrix(g->pos[i].q);
    mat3 ii = mat3_mul(mat3_mul(r, *m->inv_inertia), mat3_transpose(r));
    if (g->planar) {
        real k = g->planar == 1 ? ii.r0.x : g->planar == 2 ? ii.r1.y : ii.r2.z;
        ii = mat3_diagonal((vec3){g->planar == 1 ? k : 0, g->planar == 2 ? k : 0, g->planar == 3 ? k : 0});
    }
    return ii;
}

mat3 group_inverse_inertia(const Group *g, int i) { return g->member[i].moves ? inverse_inertia(g, i) : mat3_zero(); }

void group_refresh_mass(Group *g, int i)
{
    if (g->member[i].moves)
        g->mass[i].ii = inverse_inertia(g, i);
}

/* A body woken by what is about to strike it was at rest: waking makes its mode moving, and leaves its velocity zero. */
static bool body_moving(const Body *b) { return b->mode == DIG_MOVING && (vec3_length2(b->v) > 0 || vec3_length2(b->w) > 0); }

static void take_inertia(Group *g, int i, const Body *b, real inert)
{
    Member *m = &g->member[i];
    const Inertia *own = body_inertia(b);
    m->inertia = &own->of;
    m->inv_inertia = &own->inverse;
    if (inert == 1)
        return;
    DIG_ASSERT(g->inertias);
    g->inertias[i] = mat3_scale(inert, own->of);
    g->inertias[g->body_count + i] = mat3_scale(1 / inert, own->inverse);
    m->inertia = &g->inertias[i];
    m->inv_inertia = &g->inertias[g->body_count + i];
}

static void gather_body(Group *g, int i, uint32_t slot, bool awake)
{
    Member *m = &g->member[i];
    memset(m, 0, sizeof *m);
    m->slot = slot;
    if (slot == NONE) {
        static const mat3 none = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
        m->inertia = m->inv_inertia = &none;
        g->pos[i] = (Pos){vec3_zero(), quat_identity()};
        g->vel[i] = (Vel){vec3_zero(), vec3_zero()};
        return;
    }
    const Body *b = &g->world->bodies.data[slot];
    g->pos[i] = (Pos){b->x, b->q};
    g->vel[i] = (Vel){b->v, b->w};
    if (b->kind == DIG_DYNAMIC)
        dir_mask(g, &g->vel[i].v, &g->vel[i].w);        /* what was given along the dead axis does not count */
    m->kinematic = b->kind == DIG_KINEMATIC;
    m->dormant = b->kind == DIG_DYNAMIC && !awake;
    m->moves = b->kind == DIG_DYNAMIC && awake;
    m->moved = body_moving(b);
    m->round = b->round_inertia && !g->planar;
    real inert = body_inertness(b);
    m->mass = inert * b->mass;
    m->gravity_scale = b->gravity_scale / inert;        /* its weight stays */
    m->pull = m->moves ? b->pull : 0;
    m->integrator = b->integrator;
    m->fresh = b->euler;
    take_inertia(g, i, b, inert);
    m->outer = b->outer;
    m->rim = b->rim;
    m->travel = b->travel;
    if (m->moves)
        m->im = b->inv_mass / inert;
    if (m->dormant)
        g->vel[i] = (Vel){vec3_zero(), vec3_zero()};
}

/* Joints that were made one after the other mostly are at neighbours, too. */
static void fetch_joint(const World *w, uint32_t joint)
{
    if (joint + JOINTS_AHEAD < (uint32_t)w->joints.count)
        fetch_soon(&w->joints.data[joint + JOINTS_AHEAD], offsetof(JointRec, force));
}

static uint32_t across(const JointRec *r, uint32_t body) { return r->a == body ? r->b : r->a; }

/* Is that a body that stands still? */
static bool held_by(const World *w, uint32_t other) { return other != NONE && w->bodies.data[other].kind != DIG_DYNAMIC; }

/* A joint counts once: at its first dynamic body. held: the other one stands still. */
static bool counts_at(const JointRec *r, uint32_t body, bool held) { return r->a == body || r->a == NONE || held; }

/* How many joints members have, and how many ends of these are at bodies that stand still. */
typedef struct Joined { int joints, held; } Joined;

static void count_joints(const World *w, uint32_t body, Joined *n)
{
    for (uint32_t j = w->bodies.data[body].joint_first; j != NONE; j = joint_next(w, j, body)) {
        const JointRec *r = &w->joints.data[j];
        fetch_joint(w, j);
        bool held = held_by(w, across(r, body));
        n->joints += counts_at(r, body, held);
        n->held += held;
    }
}

/* Members of the DIGs, ascending; their joints are counted. */
static dig_status list_moving(Group *g, Joined *joined)
{
    const World *w = g->world;
    int n = 0;
    bool any = w->joints.count > w->free_joints.count;          /* else no body is asked for its own */
    for (int d = 0; d < g->dig_count; d++)
        n += graph_fellows(w->graph, g->leads[d]);
    uint32_t *slots = arena_alloc(g->lasting, (size_t)n * sizeof *slots);
    if (!slots)
        return DIG_E_MEMORY;
    g->slots = slots;
    g->moving_count = n;
    n = 0;
    for (int d = 0; d < g->dig_count; d++)
        for (uint32_t m = g->leads[d]; m != NONE; m = graph_next(w->graph, m)) {
            slots[n++] = m;
            if (any)
                count_joints(w, m, joined);
        }
    return sort_u32(slots, n, g->lasting);
}

/* The last one noted is mostly the same: the ground. */
static void note_still(uint32_t *still, int *count, uint32_t body)
{
    if (*count == 0 || still[*count - 1] != body)
        still[(*count)++] = body;
}

typedef struct Standing { const World *w; const uint32_t *pairs; int count; uint32_t *still; int *found; } Standing;     /* found: by each share */

/* A share's begin at twice its first pair. */
INLINE void still_share(void *context, int thread, int threads)
{
    const Standing *s = context;
    int first = team_first(s->count, thread, threads);
    uint32_t *still = s->still + 2 * first;
    int n = 0;
    for (int i = first, end = team_end(s->count, thread, threads); i < end; i++) {
        const Pair *p = &s->w->pairs.data[s->pairs[i]];
        if (i + FETCH_AHEAD < s->count)
            fetch_soon(&s->w->pairs.data[s->pairs[i + FETCH_AHEAD]], offsetof(Pair, next));
        if (!p->dynamic_a)
            note_still(still, &n, p->body_a);
        if (!p->dynamic_b)
            note_still(still, &n, p->body_b);
    }
    s->found[thread] = n;
}

/* In the order of the pairs; returns how many. */
static int list_met(Standing *s, Team *team)
{
    int shares = team_shares(team), n;
    team_deal(team, still_share, s);
    n = s->found[0];            /* those of the first share are where they should be */
    for (int i = 1; i < shares; n += s->found[i++])
        memmove(s->still + n, s->still + 2 * team_first(s->count, i, shares), (size_t)s->found[i] * sizeof *s->still);
    return n;
}

/* What stands still and may be met or holds a joint, ascending: NONE, the world itself, comes last. */
static dig_status list_still(Group *g, const uint32_t *pairs, int pair_count, int held)
{
    const World *w = g->world;
    int unique = 0;
    g->body_count = g->moving_count;
    if (pair_count + held == 0)
        return DIG_OK;
    Team *team = pair_count < SHARED_LEAST ? NULL : g->team;
    Standing s = {w, pairs, pair_count, NULL, arena_alloc(g->lasting, (size_t)team_shares(team) * sizeof *s.found)};
    uint32_t *still = s.still = arena_alloc(g->lasting, (size_t)(2 * pair_count + held) * sizeof *still);
    if (!still || !s.found)
        return DIG_E_MEMORY;
    int n = list_met(&s, team);
    for (int i = 0; i < g->moving_count && held > 0; i++)       /* until all are found */
        for (uint32_t j = w->bodies.data[g->slots[i]].joint_first; j != NONE; j = joint_next(w, j, g->slots[i])) {
            uint32_t other = across(&w->joints.data[j], g->slots[i]);
            if (!held_by(w, other))
                continue;
            note_still(still, &n, other);
            held--;
        }
    DIG_TRY(sort_u32(still, n, g->lasting));
    for (int i = 0; i < n; i++)
        if (i == 0 || still[i] != still[i - 1])
            still[unique++] = still[i];
    arena_shrink(g->lasting, still, (size_t)unique * sizeof *still);
    g->still = still;
    g->body_count += unique;
    return DIG_OK;
}

INLINE void gather_share(void *context, int thread, int threads)
{
    Group *g = context;
    for (int i = team_first(g->body_count, thread, threads), end = team_end(g->body_count, thread, threads); i < end; i++) {
        bool moving = i < g->moving_count;
        if (i + BODIES_AHEAD < g->moving_count)
            fetch_soon(&g->world->bodies.data[g->slots[i + BODIES_AHEAD]], offsetof(Body, prev_x));
        uint32_t slot = moving ? g->slots[i] : g->still[i - g->moving_count];
        gather_body(g, i, slot, moving && g->world->bodies.data[slot].awake);
    }
}

static dig_status gather_bodies(Group *g, const uint32_t *pairs, int pair_count, int *joints)
{
    const World *w = g->world;
    Joined joined = {0, 0};
    DIG_TRY(list_moving(g, &joined));
    DIG_TRY(list_still(g, pairs, pair_count, joined.held));
    *joints = joined.joints;
    size_t total = (size_t)g->body_count;
    g->pos = arena_alloc(g->lasting, total * sizeof *g->pos);
    g->vel = arena_alloc(g->lasting, (total + 1) * sizeof *g->vel);        /* a spare one after the last, for fours.c */
    g->member = arena_alloc(g->lasting, total * sizeof *g->member);
    g->inertias = w->region_count > 0 ? arena_alloc(g->lasting, 2 * total * sizeof *g->inertias) : NULL;
    if (!g->pos || !g->vel || !g->member || (w->region_count > 0 && !g->inertias))
        return DIG_E_MEMORY;
    team_deal(g->team, gather_share, g);
    for (int i = 0; i < g->moving_count && w->region_count > 0; i++)
        g->fall = real_max(g->fall, region_fall(w, &w->bodies.data[g->slots[i]], g->pos[i].x));
    for (int i = 0; i < g->moving_count && (g->may_trace || g->calm); i++) {
        const Body *b = &w->bodies.data[g->slots[i]];
        if (!b->awake)
            continue;
        g->trace_wait = int_max(g->trace_wait, b->trace_wait);
        g->trace_step = b->trace_step > 0 && (g->trace_step == 0 || b->trace_step < g->trace_step) ? b->trace_step : g->trace_step;
    }
    return DIG_OK;
}

INLINE void weigh_share(void *context, int thread, int threads)
{
    Group *g = context;
    for (int i = team_first(g->body_count, thread, threads), end = team_end(g->body_count, thread, threads); i < end; i++) {
        g->mass[i] = (Mass){g->member[i].im, mat3_zero()};
        g->shift[i] = g->start_vel[i] = (Vel){vec3_zero(), vec3_zero()};
        g->start_pos[i] = (Pos){vec3_zero(), {0, 0, 0, 0}};
    }
}

dig_status group_weigh(Group *g)
{
    if (!g->contact_rest)
        DIG_TRY(group_gather_rest(g));
    if (!g->acted)
        DIG_TRY(group_open_acted(g));
    DIG_TRY(group_fill_out(g));
    g->mass = arena_alloc(g->arena, (size_t)g->body_count * sizeof *g->mass);
    g->shift = arena_alloc(g->arena, (size_t)(g->body_count + 1) * sizeof *g->shift);        /* takes turns with vel */
    g->start_pos = arena_alloc(g->arena, (size_t)g->body_count * sizeof *g->start_pos);
    g->start_vel = arena_alloc(g->arena, (size_t)g->body_count * sizeof *g->start_vel);
    g->couples = g->joint_count > 0 ? arena_zero(g->arena, (size_t)g->body_count * sizeof *g->couples) : NULL;
    g->been = arena_alloc(g->lasting, (size_t)g->body_count * sizeof *g->been);
    g->impacts = arena_alloc(g->lasting, (size_t)g->pair_count * sizeof *g->impacts);
    if (!g->mass || !g->shift || !g->start_pos || !g->start_vel || !g->been || !g->impacts || (g->joint_count > 0 && !g->couples))
        return DIG_E_MEMORY;
    team_deal(g->team, weigh_share, g);
    return DIG_OK;
}

static int joint_index(const Group *g, uint32_t slot)
{
    for (int i = 0; i < g->joint_count; i++)
        if (g->joints[i].slot == slot)
            return i;
    return -1;
}

static void gather_joint(Group *g, GroupJoint *j, uint32_t slot)
{
    const JointRec *r = &g->world->joints.data[slot];
    j->slot = slot;
    j->ra = r->ra;
    j->rb = r->rb;
    j->fa = r->fa;
    j->fb = r->fb;
    j->breaks_at = r->breaks_at;
    j->broken = j->lags = j->looped = false;
    j->broke = j->overload = j->lost = 0;
    j->impulse = j->angular_impulse = vec3_zero();
    j->a = r->a == NONE ? -1 : local_of(g, r->a);
    j->b = r->b == NONE ? -1 : local_of(g, r->b);
    memcpy(j->memory, r->memory, sizeof j->memory);
    memcpy(j->force, r->impulse, sizeof j->force);
}

/* joints: as many at most. */
static dig_status gather_joints(Group *g, int joints)
{
    const World *w = g->world;
    int count = 0;
    if (joints == 0)
        return DIG_OK;
    g->joints = arena_alloc(g->lasting, (size_t)joints * sizeof *g->joints);
    if (!g->joints)
        return DIG_E_MEMORY;
    for (int i = 0; i < g->moving_count; i++) {
        uint32_t body = g->member[i].slot;
        for (uint32_t s = w->bodies.data[body].joint_first; s != NONE && !g->member[i].dormant; s = joint_next(w, s, body)) {
            const JointRec *of = &w->joints.data[s];
            if (counts_at(of, body, held_by(w, across(of, body))))
                gather_joint(g, &g->joints[count++], s);
        }
    }
    arena_shrink(g->lasting, g->joints, (size_t)count * sizeof *g->joints);
    g->joint_count = count;
    for (int i = 0; i < count; i++) {
        const JointRec *r = &w->joints.data[g->joints[i].slot];
        GroupJoint *j = &g->joints[i];
        for (int k = 0; k < 2; k++) {
            j->other[k] = r->other[k] == NONE ? -1 : joint_index(g, r->other[k]);
            j->view.other[k] = NULL;
        }
        j->view.type = r->type;
        j->view.params = r->params;
        j->view.breaks_at = r->breaks_at;
        j->view.memory = j->memory;
        j->view.passing = j->view.followed = j->view.swept = false;
        j->stores = joint_stores(&j->view);
    }
    return DIG_OK;
}

/* The share of this step during which a push acts scales its force: its impulse is exact. */
static dig_status gather_pushes(Group *g, real dt)
{
    const World *w = g->world;
    if (w->pushes.count == 0)
        return DIG_OK;
    g->pushes = arena_alloc(g->lasting, (size_t)w->pushes.count * sizeof *g->pushes);
    if (!g->pushes)
        return DIG_E_MEMORY;
    real now = world_time(w);
    for (int i = 0; i < w->pushes.count; i++) {
        const Push *p = &w->pushes.data[i];
        bool here = find_slot(g->slots, g->moving_count, p->body) >= 0;
        real share = (real_min(p->until, now + dt) - real_max(p->from, now)) / dt;
        if (!here || !(share > 1e-9))
            continue;
        share = real_min(share, 1);
        g->pushes[g->push_count++] = (GroupPush){local_of(g, p->body), vec3_scale(share, p->force), vec3_scale(share, p->torque), p->at, p->has_at, p->law};
    }
    return DIG_OK;
}

/* The axis across the plane in which a world lies: 1, 2 or 3; 0: in none. */
static int normal_of(const char *plane) { return plane[0] == '\0' ? 0 : plane[0] == 'y' ? 1 : plane[1] == 'z' ? 2 : 3; }

dig_status group_gather(Group *g, const World *w, const uint32_t *leads, int dig_count, const uint32_t *pairs, int pair_count, Arena *lasting,
                        Arena *arena)
{
    g->world = w;
    g->lasting = lasting;
    g->arena = arena;
    g->leads = leads;
    g->dig_count = dig_count;
    g->gravity = w->def.gravity;
    g->fall = vec3_length(g->gravity);
    g->planar = normal_of(w->def.plane.s);
    g->decay_friction = w->def.friction_law.s[0] == 'd';        /* "decay", not "coulomb" */
    g->touch = 1e-7;
    g->culprit = -1;
    int joints = 0;
    DIG_TRY(gather_bodies(g, pairs, pair_count, &joints));
    DIG_TRY(gather_joints(g, joints));
    DIG_TRY(fuse(g, pair_count));
    if (pair_count > 0 && !g->crowd)
        group_find_throws(g);
    DIG_TRY(gather_pairs(g, pairs, pair_count));
    for (int i = g->moving_count; i < g->body_count; i++) {
        g->movers = g->movers || g->member[i].kinematic;
        g->driven = g->driven || (g->member[i].kinematic && g->member[i].moved);
    }
    toil_gather(g);
    cover(g);
    DIG_TRY(seams(g, 0));
    return gather_pushes(g, w->def.step);
}
