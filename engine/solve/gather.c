/* solve/gather.c - the world's records become compact copies; solve/commit.c takes them back. */
#include "base/sort.h"
#include "solve/direction.h"
#include "solve/group.h"

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

/* Local index of a body slot: moving members first, then what stands still. */
static int local_of(const Group *g, uint32_t slot)
{
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
    m->inertia = &b->inertia;
    m->inv_inertia = &b->inv_inertia;
    if (inert == 1)
        return;
    DIG_ASSERT(g->inertias);
    g->inertias[i] = mat3_scale(inert, b->inertia);
    g->inertias[g->body_count + i] = mat3_scale(1 / inert, b->inv_inertia);
    m->inertia = &g->inertias[i];
    m->inv_inertia = &g->inertias[g->body_count + i];
}

static void gather_body(Group *g, int i, uint32_t slot, bool awake)
{
    Member *m = &g->member[i];
    memset(m, 0, sizeof *m);
    m->slot = slot;
    g->push_work[i] = 0;
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
    m->centre = b->centre;
    m->outer = b->outer;
    m->rim = b->rim;
    m->travel = b->travel;
    if (m->moves)
        m->im = b->inv_mass / inert;
    if (m->dormant)
        g->vel[i] = (Vel){vec3_zero(), vec3_zero()};
}

/* A joint counts once: at its first dynamic body. */
static bool counts_at(const World *w, uint32_t joint, uint32_t body)
{
    const JointRec *r = &w->joints.data[joint];
    return r->b != body || r->a == NONE || w->bodies.data[r->a].kind != DIG_DYNAMIC;
}

/* Joints that were made one after the other mostly are at neighbours, too. */
static void fetch_joint(const World *w, uint32_t joint)
{
    if (joint + JOINTS_AHEAD < (uint32_t)w->joints.count)
        fetch_soon(&w->joints.data[joint + JOINTS_AHEAD], offsetof(JointRec, force));
}

/* Members of the DIGs, ascending; their joints are counted. */
static dig_status list_moving(Group *g, int *joints)
{
    const World *w = g->world;
    int n = 0;
    for (int d = 0; d < g->dig_count; d++)
        n += graph_fellows(w->graph, g->leads[d]);
    uint32_t *slots = arena_alloc(g->arena, (size_t)n * sizeof *slots);
    if (!slots)
        return DIG_E_MEMORY;
    g->slots = slots;
    g->moving_count = n;
    n = 0;
    for (int d = 0; d < g->dig_count; d++)
        for (uint32_t m = g->leads[d]; m != NONE; m = graph_next(w->graph, m)) {
            slots[n++] = m;
            for (uint32_t j = w->bodies.data[m].joint_first; j != NONE; j = joint_next(w, j, m)) {
                fetch_joint(w, j);
                *joints += counts_at(w, j, m);
            }
        }
    return sort_u32(slots, n, g->arena);
}

/* The last one noted is mostly the same: the ground. */
static void note_still(uint32_t *still, int *count, uint32_t body)
{
    if (*count == 0 || still[*count - 1] != body)
        still[(*count)++] = body;
}

/* What stands still and may be met or holds a joint, ascending: NONE, the world itself, comes last. */
static dig_status list_still(Group *g, const uint32_t *pairs, int pair_count, int joints)
{
    const World *w = g->world;
    int n = 0, unique = 0;
    g->body_count = g->moving_count;
    if (pair_count + joints == 0)
        return DIG_OK;
    uint32_t *still = arena_alloc(g->arena, (size_t)(2 * pair_count + joints) * sizeof *still);
    if (!still)
        return DIG_E_MEMORY;
    for (int i = 0; i < pair_count; i++) {
        const Pair *p = &w->pairs.data[pairs[i]];
        if (i + FETCH_AHEAD < pair_count)
            fetch_soon(&w->pairs.data[pairs[i + FETCH_AHEAD]], offsetof(Pair, next));
        if (!p->dynamic_a)
            note_still(still, &n, p->body_a);
        if (!p->dynamic_b)
            note_still(still, &n, p->body_b);
    }
    for (int i = 0; i < g->moving_count && joints > 0; i++)
        for (uint32_t j = w->bodies.data[g->slots[i]].joint_first; j != NONE; j = joint_next(w, j, g->slots[i])) {
            const JointRec *r = &w->joints.data[j];
            uint32_t other = r->a == g->slots[i] ? r->b : r->a;
            if (other != NONE && w->bodies.data[other].kind != DIG_DYNAMIC)
                note_still(still, &n, other);
        }
    DIG_TRY(sort_u32(still, n, g->arena));
    for (int i = 0; i < n; i++)
        if (i == 0 || still[i] != still[i - 1])
            still[unique++] = still[i];
    arena_shrink(g->arena, still, (size_t)unique * sizeof *still);
    g->still = still;
    g->body_count += unique;
    return DIG_OK;
}

static void gather_share(void *context, int thread, int threads)
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
    DIG_TRY(list_moving(g, joints));
    DIG_TRY(list_still(g, pairs, pair_count, *joints));
    size_t total = (size_t)g->body_count;
    g->pos = arena_alloc(g->arena, total * sizeof *g->pos);
    g->vel = arena_alloc(g->arena, (total + 1) * sizeof *g->vel);        /* a spare one after the last, for fours.c */
    g->member = arena_alloc(g->arena, total * sizeof *g->member);
    g->push_work = arena_alloc(g->arena, total * sizeof *g->push_work);
    g->inertias = w->region_count > 0 ? arena_alloc(g->arena, 2 * total * sizeof *g->inertias) : NULL;
    if (!g->pos || !g->vel || !g->member || !g->push_work || (w->region_count > 0 && !g->inertias))
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

static void weigh_share(void *context, int thread, int threads)
{
    Group *g = context;
    for (int i = team_first(g->body_count, thread, threads), end = team_end(g->body_count, thread, threads); i < end; i++) {
        g->mass[i] = (Mass){g->member[i].im, mat3_zero()};
        g->shift[i] = (Vel){vec3_zero(), vec3_zero()};
    }
}

dig_status group_weigh(Group *g)
{
    g->mass = arena_alloc(g->arena, (size_t)g->body_count * sizeof *g->mass);
    g->shift = arena_alloc(g->arena, (size_t)(g->body_count + 1) * sizeof *g->shift);        /* takes turns with vel */
    if (!g->mass || !g->shift)
        return DIG_E_MEMORY;
    team_deal(g->team, weigh_share, g);
    return DIG_OK;
}

static real pair_size(const Shape *a, const Shape *b)
{
    real size = real_min(isfinite(a->outer) ? a->outer : INFINITY, isfinite(b->outer) ? b->outer : INFINITY);
    return isfinite(size) ? size : 1;
}

typedef struct Near {           /* a pair that may be gathered                     */
    uint32_t slot;
    int a, b;                   /* local bodies                                    */
    int contact, contacts;      /* of the group; 0: left out                       */
    uint32_t first;             /* of the world's contacts                         */
    int place;                  /* first of its room; by find_near, how much it takes */
    float slack;                /* m  of one that is left out, see Left            */
} Near;

typedef struct Span {           /* m  of a body, unless something strikes it */
    real wide;                  /*    within this of its centre of mass is all that it is, and gets to in the step */
    real far;                   /*    its travel, and so far it gets at most in the step */
} Span;

typedef struct Nearby {
    Group *g;
    const uint32_t *pairs; int count;   /* of the world, that may be gathered */
    Near  *near;
    Span  *span;                /* [body_count of g] NULL: all are gathered */
    int    first, taken;        /* of g's pairs: near[0] becomes the first of so many */
    real  *places;              /* room for their points and hints */
} Nearby;

#define POINT_PLACE ((int)(sizeof(ContactPoint) / sizeof(real)))        /* of the group's places */
#define HINT_PLACE  ((int)(sizeof(ManifoldCache) / sizeof(real)))
_Static_assert(sizeof(ManifoldPoint) + sizeof(PointMemory) == sizeof(ContactPoint) && sizeof(ContactPoint) % sizeof(real) == 0 &&
               sizeof(ManifoldCache) % sizeof(real) == 0, "points, memories and hints lie close together in reals");

#define SHARED_LEAST 512         /* pairs: fewer are not worth a team */
#define RUBS 16                 /* of two kinds of surfaces each */
typedef struct KnownRub { Surface a, b; Rub rub; } KnownRub;
typedef struct KnownRubs { bool known[RUBS]; KnownRub of[RUBS]; } KnownRubs;   /* only what is known is written */

/* Of a pair that has no memory: mostly others have had the same two surfaces before it. */
static Rub rub_as_before(const World *w, const Solid *a, const Solid *b, KnownRubs *known)
{
    unsigned i = (unsigned)(3 * a->surface.material + b->surface.material) % RUBS;
    KnownRub *k = &known->of[i];
    if (!known->known[i] || memcmp(&k->a, &a->surface, sizeof k->a) != 0 || memcmp(&k->b, &b->surface, sizeof k->b) != 0)
        *k = (KnownRub){a->surface, b->surface, surface_pair(w, &a->surface, &b->surface)};
    known->known[i] = true;
    return k->rub;
}

static void gather_pair(Group *g, GroupPair *q, const Near *n, KnownRubs *known)
{
    const World *w = g->world;
    const Pair *p = &w->pairs.data[n->slot];
    const Solid *a = &w->solids.data[p->solid_a], *b = &w->solids.data[p->solid_b];
    q->slot = n->slot;
    q->a = n->a;
    q->b = n->b;
    q->on_a = a;
    q->on_b = b;
    const PairMemory *m = p->memory == NONE ? NULL : &w->memories.data[p->memory];
    Rub rub = m ? m->rub : rub_as_before(w, a, b, known);
    q->memory = p->memory;
    if (q->hint)
        *q->hint = m ? m->cache : (ManifoldCache){.kind = 0};
    q->covered = (Covered){0, 0};
    q->reach = 0;
    q->until = g->crowd ? p->until : -1;
    q->meets = false;
    q->friction = rub.friction;
    q->friction_dynamic = rub.friction_dynamic;
    q->rolling = rub.rolling;
    q->restitution = rub.restitution;
    q->size = pair_size(&q->on_a->shape, &q->on_b->shape);
    q->fresh = p->fresh;
    q->was_touching = p->touching;
    q->both_moved = g->member[q->a].moved && g->member[q->b].moved;
    q->struck = false;
    q->strike_first = q->strike = 0;
    q->speed = q->struck_time = q->struck_impulse = 0;
}

/* Only what there is. Points beyond the count stay unwritten. */
static void gather_contact(const World *w, const GroupPair *q, int pair, uint32_t slot, real *places, GroupContact *to)
{
    static const Contact none = {.idle = true, .more = NONE};
    const Contact *from = slot == NONE ? &none : &w->contacts.data[slot];
    to->pair = pair;
    to->a = q->a;
    to->b = q->b;
    to->slot = slot;
    to->piece = from->piece;
    to->idle = from->idle;
    to->manifold.wide = from->more != NONE;
    to->live = from->count > 0;
    to->manifold.slides = from->sliding;
    to->rolling = from->idle ? vec3_zero() : from->rolling;
    to->impulse = to->point_sum = vec3_zero();
    to->last = to->point_weight = to->lost = 0;
    to->manifold.normal = from->normal;
    to->manifold.count = int_min(from->count, to->manifold.room);
    to->manifold.points = (ManifoldPoint *)(void *)places;
    for (int k = 0; k < to->manifold.count; k++) {
        const ContactPoint *p = contact_point_seen(w, from, k);
        to->manifold.points[k] = p->at;
        contact_memory(to)[k] = p->memory;
    }
}

/* m  No point of the body gets farther in the step, unless something strikes it. */
static real way_of(const Group *g, int body)
{
    const Member *m = &g->member[body];
    const Vel *v = &g->vel[body];
    real dt = g->world->def.step, spin = m->rim > 0 && vec3_length2(v->w) > 0 ? vec3_length(v->w) * m->rim : 0;
    return dt * (vec3_length(v->v) + spin + m->pull * dt);
}

static void find_spans(void *context, int thread, int threads)
{
    const Nearby *n = context;
    const Group *g = n->g;
    for (int i = team_first(g->body_count, thread, threads), end = team_end(g->body_count, thread, threads); i < end; i++) {
        const Member *m = &g->member[i];
        real way = m->slot == NONE ? 0 : way_of(g, i);         /* NONE: the world itself */
        n->span[i] = m->slot == NONE ? (Span){INFINITY, 0} : (Span){1.01 * m->outer + way, m->travel + way};
    }
}

/* m  So much farther the two may get, together, than by themselves, before they could meet. */
static real slack_of(const Nearby *n, const Pair *p, int a, int b)
{
    const Group *g = n->g;
    const Span *x = &n->span[a], *y = &n->span[b];
    real reach = x->wide + y->wide, room = p->until - x->far - y->far;
    if (!p->fresh && room > 0)
        return room;            /* crowd/touch.c has seen that there is so much between them */
    real apart2 = vec3_length2(vec3_sub(g->pos[b].x, g->pos[a].x));
    return apart2 > reach * reach ? sqrt(apart2) - reach : 0;
}

/* Most pairs of a crowd are near each other without a contact, and get none in this step: they are left out, until something strikes one
 * of their bodies. */
static void find_near(void *context, int thread, int threads)
{
    const Nearby *n = context;
    const Group *g = n->g;
    const World *w = g->world;
    for (int i = team_first(n->count, thread, threads), end = team_end(n->count, thread, threads); i < end; i++) {
        const Pair *p = &w->pairs.data[n->pairs[i]];
        if (i + FETCH_AHEAD < n->count)
            fetch_soon(&w->pairs.data[n->pairs[i + FETCH_AHEAD]], sizeof(Pair));
        Near *near = &n->near[i];
        *near = (Near){.slot = n->pairs[i], .a = local_of(g, p->body_a), .b = local_of(g, p->body_b), .first = p->contact, .contacts = 1};
        for (uint32_t c = p->pieces ? w->contacts.data[p->contact].next : NONE; c != NONE; c = w->contacts.data[c].next)
            near->contacts++;
        near->place = p->round ? near->contacts * POINT_PLACE : near->contacts * MANIFOLD_POINTS * POINT_PLACE + HINT_PLACE;
        if (n->span && p->contact == NONE && !p->touching)
            near->slack = (float)slack_of(n, p, near->a, near->b);
        if (near->slack > 0)
            near->contacts = 0;
    }
}

/* Of the pairs that come after number i: the next ones but some, and of the next ones what they name. */
static void fetch_near(const Group *g, const Near *near, int count, int i)
{
    const World *w = g->world;
    if (i + 2 * FETCH_AHEAD < count)
        fetch_soon(&w->pairs.data[near[i + 2 * FETCH_AHEAD].slot], sizeof(Pair));
    if (i + FETCH_AHEAD >= count)
        return;
    fetch_more(w, near[i + FETCH_AHEAD / 2].first);
    const Near *n = &near[i + FETCH_AHEAD];
    const Pair *p = &w->pairs.data[n->slot];
    size_t bytes = (p->memory == NONE ? offsetof(Solid, colour) : offsetof(Solid, centre)) - offsetof(Solid, shape);
    fetch_soon(&w->solids.data[p->solid_a].shape, bytes);
    fetch_soon(&w->solids.data[p->solid_b].shape, bytes);
    fetch_soon(&g->member[n->a], offsetof(Member, pull));
    fetch_soon(&g->member[n->b], offsetof(Member, pull));
    if (p->memory != NONE)
        fetch_soon(&w->memories.data[p->memory], sizeof(PairMemory));
    if (n->first != NONE)
        fetch_soon(&w->contacts.data[n->first], sizeof(Contact));
}

/* The pair's contacts, and its hint after what they have room for. */
static void gather_pair_contacts(const Nearby *n, const Near *near, GroupPair *q, int pair)
{
    Group *g = n->g;
    const World *w = g->world;
    uint32_t c = near->first;
    for (int k = 0; k < near->contacts; k++) {
        GroupContact *to = &g->contacts[q->contact + k];
        to->manifold.room = q->hint ? MANIFOLD_POINTS : 1;
        gather_contact(w, q, pair, c, n->places + near->place + k * to->manifold.room * POINT_PLACE, to);
        c = c == NONE ? NONE : w->contacts.data[c].next;
    }
}

static void gather_near(void *context, int thread, int threads)
{
    const Nearby *n = context;
    Group *g = n->g;
    KnownRubs known;
    memset(known.known, 0, sizeof known.known);
    for (int i = team_first(n->taken, thread, threads), end = team_end(n->taken, thread, threads); i < end; i++) {
        const Near *near = &n->near[i];
        GroupPair *q = &g->pairs[n->first + i];
        fetch_near(g, n->near, n->taken, i);
        bool round = g->world->pairs.data[near->slot].round;
        q->hint = round ? NULL : (ManifoldCache *)(void *)(n->places + near->place + near->contacts * MANIFOLD_POINTS * POINT_PLACE);
        gather_pair(g, q, near, &known);
        q->contact = near->contact;
        q->contacts = near->contacts;
        gather_pair_contacts(n, near, q, n->first + i);
    }
}

/* Each pair that is taken gets its place among the group's; returns how many points they need room for. */
static int place_near(Group *g, Near *near, int count)
{
    int places = 0;
    for (int i = 0; i < count; i++) {
        int needed = near[i].place;
        near[i].contact = g->contact_count;
        near[i].place = places;
        g->contact_count += near[i].contacts;
        places += needed;
    }
    g->pair_count += count;
    return places;
}

/* Those that are taken move to the front, the others to g->left. */
static dig_status choose_near(Nearby *n)
{
    Group *g = n->g;
    g->left = arena_alloc(g->arena, (size_t)(n->span ? n->count : 0) * sizeof *g->left);
    if (!g->left)
        return DIG_E_MEMORY;
    for (int i = 0; i < n->count; i++)
        fuse_near(g, n->near[i].a, n->near[i].b);
    for (int i = 0; i < n->count; i++) {
        const Near *near = &n->near[i];
        if (fused(g, near->slot, near->a, near->b))
            continue;
        if (near->contacts > 0)
            n->near[n->taken++] = *near;
        else
            g->left[g->left_count++] = (Left){near->slot, near->a, near->b, near->slack, near->place};
    }
    g->left_end = g->left_count;
    arena_shrink(g->arena, g->left, (size_t)g->left_count * sizeof *g->left);
    return DIG_OK;
}

/* All pairs that are left out may yet come in, and each has one contact. None is where a region has laws of its own for pairs, nor where a
 * body was thrown into one that nothing known had brought it to. */
static dig_status gather_pairs(Group *g, const uint32_t *pairs, int pair_count)
{
    Nearby n = {.g = g, .pairs = pairs, .count = pair_count};
    if (pair_count == 0)
        return DIG_OK;
    bool leaves = g->crowd && g->world->region_count == 0 && !g->again;
    n.span = leaves ? arena_alloc(g->arena, (size_t)g->body_count * sizeof *n.span) : NULL;
    n.near = arena_alloc(g->arena, (size_t)pair_count * sizeof *n.near);
    if (!n.near || (leaves && !n.span))
        return DIG_E_MEMORY;
    if (leaves)
        team_deal(g->team, find_spans, &n);
    team_deal(g->team, find_near, &n);
    DIG_TRY(choose_near(&n));
    g->place_count = place_near(g, n.near, n.taken);
    size_t most = (size_t)(g->pair_count + g->left_count), contacts = (size_t)(g->contact_count + g->left_count);
    g->pairs = arena_alloc(g->arena, most * sizeof *g->pairs);
    g->contacts = arena_alloc(g->arena, contacts * sizeof *g->contacts);
    g->places = n.places = arena_alloc(g->arena, (size_t)g->place_count * sizeof *g->places);
    if (!g->pairs || !g->contacts || !g->places)
        return DIG_E_MEMORY;
    team_deal(g->team, gather_near, &n);
    spare_add(&g->spare, n.near, (size_t)pair_count * sizeof *n.near);
    if (leaves)
        spare_add(&g->spare, n.span, (size_t)g->body_count * sizeof *n.span);
    return DIG_OK;
}

typedef struct Taking {         /* of those that are left out                       */
    Group *g;
    const real *stop; real dt;
    Near *near;                 /* a share's are where it begins to look in g->left */
    int *taken;                 /* of each share                                    */
} Taking;

/* Those that may meet if each body gets so much farther than by itself. */
static void take_share(void *context, int thread, int threads)
{
    const Taking *t = context;
    Group *g = t->g;
    int first = team_first(g->left_end, thread, threads), taken = 0;
    for (int i = first, end = team_end(g->left_end, thread, threads); i < end; i++) {
        Left *l = &g->left[i];
        if (l->places < 0 || (real)l->slack > t->dt * (t->stop[l->a] + t->stop[l->b]))
            continue;
        t->near[first + taken++] = (Near){.slot = l->slot, .a = l->a, .b = l->b, .contacts = 1, .first = NONE, .place = l->places};
        l->places = -1;         /* it was taken, and stays where it is until no more will be */
    }
    t->taken[thread] = taken;
}

/* They become near[0] and those after it, in their order; returns how many. */
static int take_left(Taking *t)
{
    Group *g = t->g;
    Team *team = g->left_end < SHARED_LEAST ? NULL : g->team;
    int shares = team_shares(team), count = 0;
    team_deal(team, take_share, t);
    for (int i = 0; i < shares; count += t->taken[i++])
        memmove(t->near + count, t->near + team_first(g->left_end, i, shares), (size_t)t->taken[i] * sizeof *t->near);
    g->left_count -= count;
    return count;
}

dig_status group_gather_struck(Group *g, const real *stop, real dt)
{
    Nearby n = {.g = g, .first = g->pair_count};
    if (g->left_count == 0)
        return DIG_OK;
    Taking t = {g, stop, dt, NULL, arena_alloc(g->arena, (size_t)team_shares(g->team) * sizeof *t.taken)};
    t.near = n.near = arena_alloc(g->arena, (size_t)g->left_end * sizeof *n.near);
    if (!n.near || !t.taken)
        return DIG_E_MEMORY;
    n.taken = take_left(&t);
    arena_shrink(g->arena, n.near, (size_t)n.taken * sizeof *n.near);
    if (n.taken == 0)
        return DIG_OK;
    n.places = arena_alloc(g->arena, (size_t)place_near(g, n.near, n.taken) * sizeof *n.places);
    if (!n.places)
        return DIG_E_MEMORY;
    team_deal(n.taken < SHARED_LEAST ? NULL : g->team, gather_near, &n);
    spare_add(&g->spare, n.near, (size_t)n.taken * sizeof *n.near);
    group_leave_out(g, n.first);
    return seams(g, n.first);
}

void group_close_left(Group *g)
{
    int kept = 0;
    for (int i = 0; i < g->left_end && g->left_count < g->left_end; i++)
        if (g->left[i].places >= 0)
            g->left[kept++] = g->left[i];
    g->left_end = g->left_count;
    spare_add(&g->spare, g->pairs + g->pair_count, (size_t)g->left_count * sizeof *g->pairs);
    spare_add(&g->spare, g->contacts + g->contact_count, (size_t)g->left_count * sizeof *g->contacts);
}

void group_leave_out(Group *g, int first)
{
    for (int i = first; i < g->pair_count && !(g->laws >> LAW_FRICTION & 1); i++)
        g->pairs[i].friction = g->pairs[i].friction_dynamic = 0;
    for (int i = first; i < g->pair_count && !(g->laws >> LAW_ROLLING & 1); i++)
        g->pairs[i].rolling = 0;
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
    j->broken = false;
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
    g->joints = arena_alloc(g->arena, (size_t)joints * sizeof *g->joints);
    if (!g->joints)
        return DIG_E_MEMORY;
    for (int i = 0; i < g->moving_count; i++) {
        uint32_t body = g->member[i].slot;
        for (uint32_t s = w->bodies.data[body].joint_first; s != NONE && !g->member[i].dormant; s = joint_next(w, s, body))
            if (counts_at(w, s, body))
                gather_joint(g, &g->joints[count++], s);
    }
    arena_shrink(g->arena, g->joints, (size_t)count * sizeof *g->joints);
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
        j->view.passing = j->view.followed = false;
    }
    return DIG_OK;
}

/* The share of this step during which a push acts scales its force: its impulse is exact. */
static dig_status gather_pushes(Group *g, real dt)
{
    const World *w = g->world;
    if (w->pushes.count == 0)
        return DIG_OK;
    g->pushes = arena_alloc(g->arena, (size_t)w->pushes.count * sizeof *g->pushes);
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

dig_status group_gather(Group *g, const World *w, const uint32_t *leads, int dig_count, const uint32_t *pairs, int pair_count, Arena *arena)
{
    g->world = w;
    g->arena = arena;
    g->leads = leads;
    g->dig_count = dig_count;
    g->gravity = w->def.gravity;
    g->fall = vec3_length(g->gravity);
    g->planar = normal_of(w->def.plane.s);
    g->decay_friction = w->def.friction_law.s[0] == 'd';        /* "decay", not "coulomb" */
    g->touch = 1e-7;
    g->culprit = -1;
    int joints = 0;                 /* ends of joints at members */
    DIG_TRY(gather_bodies(g, pairs, pair_count, &joints));
    DIG_TRY(gather_joints(g, joints));
    DIG_TRY(fuse(g, pair_count));
    DIG_TRY(gather_pairs(g, pairs, pair_count));
    for (int i = g->moving_count; i < g->body_count; i++)
        g->driven = g->driven || (g->member[i].kinematic && g->member[i].moved);
    toil_gather(g);
    cover(g);
    DIG_TRY(seams(g, 0));
    return gather_pushes(g, w->def.step);
}
