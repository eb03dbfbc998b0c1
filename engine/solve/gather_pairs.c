/* solve/gather_pairs.c - pairs of a group and their contacts, copied from the world's: those that may meet, and later those that a blow brings
 * together. Lists are made in shares and put together in their order: the same for any number of threads. */
#include "solve/gather.h"

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
    atomic_bool rolls;          /* there is one that has rolling resistance */
    atomic_bool failed;         /* there was no memory         */
} Nearby;

#define HINT_PLACE  ((int)(sizeof(ManifoldCache) / sizeof(real)))
_Static_assert(sizeof(ManifoldPoint) + sizeof(PointMemory) == sizeof(ContactPoint) && sizeof(ContactPoint) % sizeof(real) == 0 &&
               sizeof(ManifoldCache) % sizeof(real) == 0, "points, memories and hints lie close together in reals");

#define RUBS 16                 /* of two kinds of surfaces each */
#define RUBS_ROOM 8             /* that are taken from the arena at once */
typedef struct KnownRub { const Form *a, *b; const Rub *rub; } KnownRub;
typedef struct KnownRubs { bool known[RUBS]; KnownRub of[RUBS]; Rub *room; int left; } KnownRubs;      /* of a share; only what is known is written */

/* Threads of a team have one arena, of which they seldom ask for more. */
static void begin_taking(Group *g)
{
    while (atomic_flag_test_and_set_explicit(&g->taking, memory_order_acquire)) {
    }
}

static void end_taking(Group *g) { atomic_flag_clear_explicit(&g->taking, memory_order_release); }

static Rub *rub_room(Nearby *n, KnownRubs *known)
{
    if (known->left == 0) {
        begin_taking(n->g);
        known->room = arena_alloc(n->g->lasting, RUBS_ROOM * sizeof *known->room);
        end_taking(n->g);
        known->left = known->room ? RUBS_ROOM : 0;
    }
    return known->left > 0 ? &known->room[RUBS_ROOM - known->left--] : NULL;
}

static bool same_surface(const Form *a, const Form *b) { return a == b || surface_same(&a->surface, &b->surface); }

/* Mostly others have had the same two surfaces before. m: NULL, or what is kept of the pair; a pointer to that would not outlive the commit. */
static const Rub *rub_as_before(Nearby *n, const Form *a, const Form *b, const PairMemory *m, KnownRubs *known)
{
    static const Rub none;
    unsigned i = (unsigned)(3 * a->surface.material + b->surface.material) % RUBS;
    KnownRub *k = &known->of[i];
    if (known->known[i] && same_surface(k->a, a) && same_surface(k->b, b))
        return k->rub;
    Rub *rub = rub_room(n, known);
    if (!rub) {
        atomic_store_explicit(&n->failed, true, memory_order_relaxed);
        return &none;
    }
    *rub = m ? m->rub : surface_pair(n->g->world, &a->surface, &b->surface);
    *k = (KnownRub){a, b, rub};
    known->known[i] = true;
    return rub;
}

static void gather_pair(Nearby *nearby, GroupPair *q, const Near *n, KnownRubs *known)
{
    const Group *g = nearby->g;
    const World *w = g->world;
    const Pair *p = &w->pairs.data[n->slot];
    const Form *a = w->solids.data[p->solid_a].form, *b = w->solids.data[p->solid_b].form;
    q->slot = n->slot;
    q->a = n->a;
    q->b = n->b;
    q->on_a = a;
    q->on_b = b;
    const PairMemory *m = p->memory == NONE ? NULL : &w->memories.data[p->memory];
    q->rub = rub_as_before(nearby, a, b, m, known);
    q->memory = p->memory;
    if (q->hint)
        *q->hint = m ? m->cache : (ManifoldCache){.kind = 0};
    q->covered = (Covered){0, 0};
    q->reach = 0;
    q->until = g->crowd ? p->until : -1;
    q->size = pair_size(&q->on_a->shape, &q->on_b->shape);
    bool fresh = p->fresh, touching = p->touching, moved = g->member[n->a].moved && g->member[n->b].moved;
    q->struck = q->meets = q->touching = q->seamed = q->hidden = false;         /* side by side: one write for all */
    q->fresh = fresh;
    q->was_touching = touching;
    q->both_moved = moved;
    q->impact = 0;
    q->speed = 0;
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
    to->grips = from->grips;
    to->manifold.normal = from->normal;
    to->manifold.count = int_min(from->count, to->manifold.room);
    to->manifold.points = (ManifoldPoint *)(void *)places;      /* NULL: there is none to remember */
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
    return dt * (vec3_length(v->v) + spin + m->pull * dt) + group_thrown(g, body, dt);
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
INLINE void find_near(void *context, int thread, int threads)
{
    const Nearby *n = context;
    const Group *g = n->g;
    const World *w = g->world;
    bool sparse = g->sparse;
    for (int i = team_first(n->count, thread, threads), end = team_end(n->count, thread, threads); i < end; i++) {
        const Pair *p = &w->pairs.data[n->pairs[i]];
        if (i + FETCH_AHEAD < n->count)
            fetch_soon(&w->pairs.data[n->pairs[i + FETCH_AHEAD]], sizeof(Pair));
        Near *near = &n->near[i];
        *near = (Near){.slot = n->pairs[i], .a = local_of(g, p->body_a), .b = local_of(g, p->body_b), .first = p->contact, .contacts = 1};
        for (uint32_t c = p->pieces ? w->contacts.data[p->contact].next : NONE; c != NONE; c = w->contacts.data[c].next)
            near->contacts++;
        int points = sparse && p->contact == NONE ? 0 : near->contacts * POINT_PLACE;
        near->place = p->round ? points : points * MANIFOLD_POINTS + HINT_PLACE;
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
    fetch_soon(&w->solids.data[p->solid_a].form, sizeof(Form *));
    fetch_soon(&w->solids.data[p->solid_b].form, sizeof(Form *));
    fetch_soon(&g->member[n->a], offsetof(Member, pull));
    fetch_soon(&g->member[n->b], offsetof(Member, pull));
    if (p->memory != NONE)
        fetch_soon(&w->memories.data[p->memory], sizeof(PairMemory));
    if (n->first != NONE)
        fetch_soon(&w->contacts.data[n->first], sizeof(Contact));
}

/* The pair's contacts, whose room comes after its hint. */
static void gather_pair_contacts(const Nearby *n, const Near *near, GroupPair *q, int pair)
{
    Group *g = n->g;
    const World *w = g->world;
    uint32_t c = near->first;
    uint8_t room = q->hint ? MANIFOLD_POINTS : 1;
    real *places = g->sparse && c == NONE ? NULL : n->places + near->place + (q->hint ? HINT_PLACE : 0);
    for (int k = 0; k < near->contacts; k++, places = places ? places + room * POINT_PLACE : NULL) {
        GroupContact *to = &g->contacts[q->contact + k];
        to->manifold.room = room;
        gather_contact(w, q, pair, c, places, to);
        c = c == NONE ? NONE : w->contacts.data[c].next;
    }
}

INLINE void gather_near(void *context, int thread, int threads)
{
    Nearby *n = context;
    Group *g = n->g;
    KnownRubs known;
    memset(known.known, 0, sizeof known.known);
    known.left = 0;
    for (int i = team_first(n->taken, thread, threads), end = team_end(n->taken, thread, threads); i < end; i++) {
        const Near *near = &n->near[i];
        GroupPair *q = &g->pairs[n->first + i];
        fetch_near(g, n->near, n->taken, i);
        bool round = g->world->pairs.data[near->slot].round;
        q->hint = round ? NULL : (ManifoldCache *)(void *)(n->places + near->place);
        gather_pair(n, q, near, &known);
        if (q->rub->rolling > 0)
            atomic_store_explicit(&n->rolls, true, memory_order_relaxed);
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

typedef struct Sum { int taken, left, contacts, places; } Sum;         /* of the pairs of a share; then of all before it */
typedef struct Sorting { Nearby *n; Sum *sum; } Sorting;

#define FUSED (-1)              /* contacts: such a pair is no pair at all */

static void sum_share(void *context, int thread, int threads)
{
    const Sorting *x = context;
    Sum sum = {0, 0, 0, 0};
    for (int i = team_first(x->n->count, thread, threads), end = team_end(x->n->count, thread, threads); i < end; i++) {
        Near *near = &x->n->near[i];
        if (x->n->g->things && fused(x->n->g, near->slot, near->a, near->b))
            near->contacts = FUSED;
        if (near->contacts == FUSED)
            continue;
        if (near->contacts == 0) {
            sum.left++;
            continue;
        }
        sum.taken++;
        sum.contacts += near->contacts;
        sum.places += near->place;
    }
    x->sum[thread] = sum;
}

/* Those that are taken get their places among the group's, and move to the front of their share; the others go to g->left. */
static void sort_share(void *context, int thread, int threads)
{
    const Sorting *x = context;
    Near *taken = x->n->near + team_first(x->n->count, thread, threads);
    Sum at = x->sum[thread];
    for (int i = team_first(x->n->count, thread, threads), end = team_end(x->n->count, thread, threads); i < end; i++) {
        Near near = x->n->near[i];
        if (near.contacts == 0)
            x->n->g->left[at.left++] = (Left){near.slot, near.a, near.b, near.slack, near.place};
        if (near.contacts <= 0)
            continue;
        int needed = near.place;
        near.contact = at.contacts;
        near.place = at.places;
        at.contacts += near.contacts;
        at.places += needed;
        *taken++ = near;
    }
}

/* Parts the pairs into those that are taken, at the front of `near`, and g->left. Outside of crowds all are taken, but for what is fused. */
static dig_status choose_near(Nearby *n)
{
    Group *g = n->g;
    if (!n->span && !g->things) {
        n->taken = n->count;
        g->place_count = place_near(g, n->near, n->count);
        return DIG_OK;
    }
    Team *team = g->things || n->count < SHARED_LEAST ? NULL : g->team;     /* what is fused is listed as well */
    int shares = team_shares(team);
    Sorting x = {n, arena_alloc(g->lasting, (size_t)shares * sizeof *x.sum)};
    if (!x.sum)
        return DIG_E_MEMORY;
    for (int i = 0; i < n->count && g->things; i++)
        fuse_near(g, n->near[i].a, n->near[i].b);
    team_deal(team, sum_share, &x);
    Sum all = {0, 0, 0, 0};
    for (int i = 0; i < shares; i++) {
        Sum own = x.sum[i];
        x.sum[i] = all;
        all = (Sum){all.taken + own.taken, all.left + own.left, all.contacts + own.contacts, all.places + own.places};
    }
    g->left = arena_alloc(g->lasting, (size_t)all.left * sizeof *g->left);
    if (!g->left)
        return DIG_E_MEMORY;
    team_deal(team, sort_share, &x);
    for (int i = 1; i < shares; i++) {
        int end = i + 1 < shares ? x.sum[i + 1].taken : all.taken;
        memmove(n->near + x.sum[i].taken, n->near + team_first(n->count, i, shares), (size_t)(end - x.sum[i].taken) * sizeof *n->near);
    }
    n->taken = g->pair_count = all.taken;
    g->left_count = g->left_end = all.left;
    g->contact_count = all.contacts;
    g->place_count = all.places;
    return DIG_OK;
}

#define SPARSE_LEAST 1024        /* pairs: fewer fit a cache anyway */

/* All pairs that are left out may yet come in, and each has one contact. None is where a region has laws of its own for pairs, nor where a
 * body was thrown into one that nothing known had brought it to. */
dig_status gather_pairs(Group *g, const uint32_t *pairs, int pair_count)
{
    Nearby n = {.g = g, .pairs = pairs, .count = pair_count};
    if (pair_count == 0)
        return DIG_OK;
    bool leaves = g->crowd && g->world->region_count == 0 && !g->again;
    g->sparse = g->crowd && pair_count >= SPARSE_LEAST && group_is_most(g);
    n.span = leaves ? arena_alloc(g->lasting, (size_t)g->body_count * sizeof *n.span) : NULL;
    n.near = arena_alloc(g->lasting, (size_t)pair_count * sizeof *n.near);
    if (!n.near || (leaves && !n.span))
        return DIG_E_MEMORY;
    if (leaves)
        team_deal(g->team, find_spans, &n);
    team_deal(g->team, find_near, &n);
    DIG_TRY(choose_near(&n));
    size_t most = (size_t)(g->pair_count + g->left_count), contacts = (size_t)(g->contact_count + g->left_count);
    g->pairs = arena_alloc(g->lasting, most * sizeof *g->pairs);
    g->contacts = arena_alloc(g->lasting, contacts * sizeof *g->contacts);
    g->places = n.places = arena_alloc(g->lasting, (size_t)g->place_count * sizeof *g->places);
    if (!g->pairs || !g->contacts || !g->places)
        return DIG_E_MEMORY;
    team_deal(g->team, gather_near, &n);
    if (atomic_load(&n.failed))
        return DIG_E_MEMORY;
    g->pairs_roll = atomic_load(&n.rolls);
    spare_add(&g->spare, n.near, (size_t)pair_count * sizeof *n.near);
    if (leaves)
        spare_add(&g->spare, n.span, (size_t)g->body_count * sizeof *n.span);
    return g->world->region_count > 0 ? group_own_rubs(g, 0) : DIG_OK;
}

typedef struct Taking {         /* of those that are left out                       */
    Group *g;
    const real *stop; real dt;
    Near *near;                 /* a share's are where it begins to look in g->left */
    int *taken;                 /* of each share                                    */
} Taking;

/* Of a pair that was left out while contacts were sparse, and comes in now: see find_near. */
static int places_now(const Group *g, int places)
{
    if (g->sparse)
        return places;
    return places == 0 ? POINT_PLACE : places == HINT_PLACE ? MANIFOLD_POINTS * POINT_PLACE + HINT_PLACE : places;
}

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
        t->near[first + taken++] = (Near){.slot = l->slot, .a = l->a, .b = l->b, .contacts = 1, .first = NONE, .place = places_now(g, l->places)};
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

#define STRUCK_LEAST 64         /* pairs that come in: fewer are not worth a team */

dig_status group_gather_struck(Group *g, const real *stop, real dt)
{
    Nearby n = {.g = g, .first = g->pair_count};
    if (g->left_count == 0)
        return DIG_OK;
    int before = g->contact_count;
    Taking t = {g, stop, dt, NULL, arena_alloc(g->lasting, (size_t)team_shares(g->team) * sizeof *t.taken)};
    t.near = n.near = arena_alloc(g->lasting, (size_t)g->left_end * sizeof *n.near);
    if (!n.near || !t.taken)
        return DIG_E_MEMORY;
    n.taken = take_left(&t);
    arena_shrink(g->lasting, n.near, (size_t)n.taken * sizeof *n.near);
    if (n.taken == 0)
        return DIG_OK;
    n.places = arena_alloc(g->lasting, (size_t)place_near(g, n.near, n.taken) * sizeof *n.places);
    if (!n.places)
        return DIG_E_MEMORY;
    team_deal(n.taken < STRUCK_LEAST ? NULL : g->team, gather_near, &n);
    if (atomic_load(&n.failed))
        return DIG_E_MEMORY;
    g->pairs_roll = g->pairs_roll || atomic_load(&n.rolls);
    spare_add(&g->spare, n.near, (size_t)n.taken * sizeof *n.near);
    DIG_TRY(group_leave_out(g, n.first));
    if (g->acted)
        memset(g->acted + before, 0, (size_t)(g->contact_count - before) * sizeof *g->acted);
    if (g->contact_rest)        /* none of them has one in the world */
        memset(g->contact_rest + before, 0, (size_t)(g->contact_count - before) * sizeof *g->contact_rest);
    else if (g->pairs_roll)
        DIG_TRY(group_gather_rest(g));
    return seams(g, n.first);
}

dig_status group_gather_rest(Group *g)
{
    const World *w = g->world;
    g->contact_rest = arena_alloc(g->lasting, (size_t)(g->contact_count + g->left_count) * sizeof *g->contact_rest);
    for (int i = 0; i < g->contact_count && g->contact_rest; i++) {
        uint32_t slot = g->contacts[i].slot;
        bool any = slot != NONE && !g->contacts[i].idle && w->contacts.data[slot].rests;
        g->contact_rest[i] = (ContactRest){.rolling = any ? w->contact_rest.data[slot].rolling : vec3_zero()};
    }
    return g->contact_rest ? DIG_OK : DIG_E_MEMORY;
}

dig_status group_open_acted(Group *g)
{
    g->acted = arena_alloc(g->lasting, (size_t)(g->contact_count + g->left_count) * sizeof *g->acted);
    if (g->acted)
        memset(g->acted, 0, (size_t)g->contact_count * sizeof *g->acted);
    return g->acted ? DIG_OK : DIG_E_MEMORY;
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

#define ROOM_AT_ONCE 64         /* contacts, that a crowd takes room for from the arena */

bool group_take_room(Group *g, GroupContact *c)
{
    int needed = c->manifold.room * POINT_PLACE;
    begin_taking(g);
    if (g->room_left < needed) {
        g->room_left = ROOM_AT_ONCE * needed;
        g->room = arena_alloc(g->lasting, (size_t)g->room_left * sizeof *g->room);
        if (!g->room) {
            g->room_left = 0;
            g->no_room = true;
        }
    }
    if (g->room_left >= needed) {
        g->room_left -= needed;
        c->manifold.points = (ManifoldPoint *)(void *)(g->room + g->room_left);
    }
    end_taking(g);
    return c->manifold.points;
}

dig_status group_fill_out(Group *g)
{
    for (int i = 0; i < g->contact_count && g->sparse; i++)
        if (!group_has_room(g, &g->contacts[i]))
            return DIG_E_MEMORY;
    g->sparse = false;
    return DIG_OK;
}

dig_status group_own_rubs(Group *g, int first)
{
    if (!g->rubs) {
        g->rubs = arena_alloc(g->lasting, (size_t)(g->pair_count + g->left_count) * sizeof *g->rubs);
        first = 0;
    }
    for (int i = first; i < g->pair_count && g->rubs; i++) {
        g->rubs[i] = *g->pairs[i].rub;
        g->pairs[i].rub = &g->rubs[i];
    }
    return g->rubs ? DIG_OK : DIG_E_MEMORY;
}

dig_status group_leave_out(Group *g, int first)
{
    bool rubs = g->laws >> LAW_FRICTION & 1, rolls = !g->pairs_roll || g->laws >> LAW_ROLLING & 1;
    if ((rubs && rolls) || first == g->pair_count)
        return DIG_OK;
    DIG_TRY(group_own_rubs(g, first));
    for (int i = first; i < g->pair_count; i++) {
        Rub *own = &g->rubs[i];
        *own = (Rub){rubs ? own->friction : 0, rubs ? own->friction_dynamic : 0, rolls ? own->rolling : 0, own->restitution};
    }
    return DIG_OK;
}
