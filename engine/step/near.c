/* step/near.c - who is near whom: solids whose boxes were made anew ask the tree, all of them at once.
 *
 * All boxes have moved before the first one asks. What meets what is then found by all threads, which change nothing, and noted by
 * one, in the order of the list: the same pairs in the same order, however many threads there are.
 */
#include "step/step.h"

#define SHARE 32                /* solids that a thread asks for in a row */
#define BLOCK 124               /* numbers, an even count of them */
#define MADE_LEAST 64           /* pairs: fewer are not worth a team */

typedef struct NearBlock { struct NearBlock *next; int count; uint32_t item[BLOCK]; } NearBlock;
typedef struct NearList { NearBlock *first, *last; } NearList;
/* Of a share: pairs that are over; two solids each that are new ones, and of these the number of the first among all. */
typedef struct Found { NearList parted, met; int first; bool failed; } Found;

/* Who has a pair with the one that asks: a hash set without removal, of 1 << bits slots. */
typedef struct Known { uint32_t *slot; int bits; } Known;

typedef struct Ask { const World *w; uint32_t solid; Known known; Arena *arena; Found *found; } Ask;

#define KNOWN_LEAST 7           /* bits */
#define SPREAD 2654435769u      /* Knuth's multiplier, 2^32 over the golden ratio */

static bool note(Ask *a, NearList *l, uint32_t item)
{
    if (!l->last || l->last->count == BLOCK) {
        NearBlock *b = arena_alloc(a->arena, sizeof *b);
        if (!b) {
            a->found->failed = true;
            return false;
        }
        b->next = NULL;
        b->count = 0;
        *(l->last ? &l->last->next : &l->first) = b;
        l->last = b;
    }
    l->last->item[l->last->count++] = item;
    return true;
}

static uint32_t known_place(const Known *k, uint32_t solid)
{
    uint32_t last = ((uint32_t)1 << k->bits) - 1, i = solid * SPREAD >> (32 - k->bits);
    while (k->slot[i] != NONE && k->slot[i] != solid)
        i = (i + 1) & last;
    return i;
}

static bool known_open(Known *k, uint32_t count, Arena *arena)
{
    int bits = int_max(k->bits, KNOWN_LEAST);
    while ((uint32_t)1 << bits < 2 * count)
        bits++;
    if (bits > k->bits) {
        k->slot = arena_alloc(arena, sizeof *k->slot << bits);
        k->bits = bits;
    }
    if (k->slot)
        memset(k->slot, 0xff, sizeof *k->slot << bits);
    return k->slot != NULL;
}

/* Have the fat boxes parted, or are the two no longer to touch? */
static bool parted(const World *w, const Solid *s, uint32_t other)
{
    const Solid *o = &w->solids.data[other];
    bool near = o->leaf < 0 ? s->leaf >= 0 && plane_near(w, other, tree_box(&w->tree, s->leaf))
                            : s->leaf >= 0 && box3_overlap(tree_box(&w->tree, s->leaf), tree_box(&w->tree, o->leaf));
    return !near || !bodies_may_touch(w, s, o);
}

/* Of two that ask, the lower one says what is found. */
static bool says(const World *w, uint32_t solid, uint32_t other) { return !w->solids.data[other].asks || solid < other; }

/* Those of its pairs that are over are noted, and all of them known. */
static bool look_at_pairs(Ask *a)
{
    const World *w = a->w;
    uint32_t first = w->solids.data[a->solid].pair_first, count = 0;
    for (uint32_t l = first; l != NONE; l = w->pairs.data[l / 2].next[l % 2])
        count++;
    if (!known_open(&a->known, count, a->arena))
        return false;
    for (uint32_t l = first; l != NONE; l = w->pairs.data[l / 2].next[l % 2]) {
        const Pair *p = &w->pairs.data[l / 2];
        uint32_t other = l % 2 ? p->solid_a : p->solid_b;
        a->known.slot[known_place(&a->known, other)] = other;
        if (says(w, a->solid, other) && parted(w, &w->solids.data[a->solid], other) && !note(a, &a->found->parted, l / 2))
            return false;
    }
    return true;
}

static bool meets(void *context, uint32_t other)
{
    Ask *a = context;
    if (other == a->solid || a->known.slot[known_place(&a->known, other)] == other || !says(a->w, a->solid, other) ||
        !bodies_may_touch(a->w, &a->w->solids.data[a->solid], &a->w->solids.data[other]))
        return true;
    return note(a, &a->found->met, a->solid) && note(a, &a->found->met, other);
}

typedef struct Asking { const World *w; Found *found; } Asking;         /* found: by each share of w->asking */

/* The pairs of solids lie anywhere in memory, each tells where the next one is: all of these lists at once are through in the time of one. */
static void fetch_pairs(const World *w, const uint32_t *solid, int count)
{
    uint32_t at[SHARE];
    int left = 0;
    for (int i = 0; i < count; i++)
        if (w->solids.data[solid[i]].pair_first != NONE)
            at[left++] = w->solids.data[solid[i]].pair_first;
    while (left > 0) {
        int n = 0;
        for (int i = 0; i < left; i++) {
            const Pair *p = &w->pairs.data[at[i] / 2];
            uint32_t next = p->next[at[i] % 2];
            fetch_soon(&w->solids.data[at[i] % 2 ? p->solid_a : p->solid_b], sizeof(Solid));
            if (next != NONE)
                at[n++] = next;
        }
        left = n;
    }
}

static void ask_share(void *context, int share, Scratch scratch)
{
    const Asking *all = context;
    const World *w = all->w;
    Ask a = {.w = w, .arena = scratch.step, .found = &all->found[share]};
    fetch_pairs(w, w->asking.data + SHARE * share, int_min(SHARE, w->asking.count - SHARE * share));
    for (int i = SHARE * share; i < w->asking.count && i < SHARE * (share + 1) && !a.found->failed; i++) {
        a.solid = w->asking.data[i];
        const Solid *s = &w->solids.data[a.solid];
        if (!look_at_pairs(&a))
            a.found->failed = true;
        else if (s->leaf >= 0)
            tree_query(&w->tree, tree_box(&w->tree, s->leaf), meets, &a);
    }
}

typedef struct Making { const World *w; const Found *found; Pair *made; } Making;

/* What surfaces and bodies make of a new pair is asked by all threads, for these lie far apart. */
static void make_share(void *context, int share, Scratch scratch)
{
    const Making *m = context;
    Pair *to = m->made + m->found[share].first;
    (void)scratch;
    for (const NearBlock *b = m->found[share].met.first; b; b = b->next)
        for (int k = 0; k < b->count; k += 2)
            *to++ = pair_new(m->w, b->item[k], b->item[k + 1]);
}

/* Pairs that are over go, then new ones come, in the order of the shares. */
static dig_status note_all(World *w, Found *found, int shares)
{
    int count = 0;
    for (int i = 0; i < shares; i++) {
        for (const NearBlock *b = found[i].parted.first; b; b = b->next)
            for (int k = 0; k < b->count; k++)
                pair_remove(w, b->item[k]);
        found[i].first = count;
        for (const NearBlock *b = found[i].met.first; b; b = b->next)
            count += b->count / 2;
    }
    if (count == 0)
        return DIG_OK;
    Making m = {w, found, arena_alloc(&w->scratch, (size_t)count * sizeof *m.made)};
    if (!m.made)
        return DIG_E_MEMORY;
    workers_run(count < MADE_LEAST ? NULL : w->workers, world_scratch(w), make_share, &m, shares);
    for (int i = 0; i < count; i++)
        DIG_TRY(pair_add_made(w, &m.made[i]));
    return DIG_OK;
}

/* Planes are in no tree: they are compared with the boxes directly. */
static real plane_above(const World *w, uint32_t plane, box3 box)
{
    const Solid *p = &w->solids.data[plane];
    pose at = solid_pose(w, p);
    const PlaneData *def = p->form->shape.data;
    vec3 n = quat_rotate(at.q, def->normal);
    vec3 lowest = {n.x > 0 ? box.low.x : box.high.x, n.y > 0 ? box.low.y : box.high.y, n.z > 0 ? box.low.z : box.high.z};
    return vec3_dot(n, vec3_sub(lowest, at.p)) - def->offset;
}

bool plane_near(const World *w, uint32_t plane, box3 box) { return plane_above(w, plane, box) <= 0; }

/* Is that the first pair of the solid? This is seen at once, and is so for most that lie on a plane. */
static bool is_first(const World *w, const Solid *s, uint32_t plane)
{
    const Pair *p = s->pair_first == NONE ? NULL : &w->pairs.data[s->pair_first / 2];
    return p && (s->pair_first % 2 ? p->solid_a : p->solid_b) == plane;
}

static bool is_new(const World *w, uint32_t solid, uint32_t plane)
{
    const Solid *s = &w->solids.data[solid];
    uint32_t pair;
    return plane != solid && s->leaf >= 0 && !is_first(w, s, plane) && plane_near(w, plane, s->reach) &&
           bodies_may_touch(w, s, &w->solids.data[plane]) && !pair_find(w, solid, plane, &pair);
}

bool plane_new(const World *w, uint32_t solid)
{
    for (int i = 0; i < w->unbounded.count; i++)
        if (is_new(w, solid, w->unbounded.data[i]))
            return true;
    return false;
}

/* m  So much each face of its reach may move until plane_new may be true: a corner gets 3^(1/2) times as far. */
real plane_room(const World *w, uint32_t solid)
{
    real room = INFINITY;
    for (int i = 0; i < w->unbounded.count; i++) {
        uint32_t plane = w->unbounded.data[i];
        if (plane == solid || is_first(w, &w->solids.data[solid], plane))
            continue;
        real above = plane_above(w, plane, w->solids.data[solid].reach);
        if (above > 0)
            room = real_min(room, above / 1.74);
        else if (is_new(w, solid, plane))
            return 0;
    }
    return room;
}

dig_status ask_planes(World *w, uint32_t solid)
{
    for (int i = 0; i < w->unbounded.count; i++)
        if (is_new(w, solid, w->unbounded.data[i]))
            DIG_TRY(pair_add(w, solid, w->unbounded.data[i]));
    return DIG_OK;
}

static dig_status ask_listed(World *w)
{
    int shares = (w->asking.count + SHARE - 1) / SHARE;
    Asking a = {w, arena_zero(&w->scratch, (size_t)shares * sizeof *a.found)};
    if (!a.found)
        return DIG_E_MEMORY;
    workers_run(w->workers, world_scratch(w), ask_share, &a, shares);
    for (int i = 0; i < shares; i++)
        if (a.found[i].failed)
            return DIG_E_MEMORY;
    DIG_TRY(note_all(w, a.found, shares));
    for (int i = 0; i < w->asking.count; i++)
        DIG_TRY(ask_planes(w, w->asking.data[i]));
    for (int i = 0; i < w->asking.count; i++)
        w->solids.data[w->asking.data[i]].asks = false;
    w->asking.count = 0;
    return DIG_OK;
}

dig_status ask_all(World *w) { return w->asking.count > 0 ? ask_listed(w) : DIG_OK; }
