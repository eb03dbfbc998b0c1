/* world/compact.c - pairs, memories and contacts are put in the order of bodies, without gaps.
 *
 * A new pair takes a slot that happens to be free. When a pile has been poured, pairs that follow each other are of bodies anywhere in it,
 * and every loop over them has to fetch both from memory; when a swarm has come to rest, many slots are free. So where many pairs are out
 * of order or gone, all move: those that a solid has with earlier ones come one after the other, and what is theirs gets their order, too.
 * Rows are made in that order, so it decides bits. It depends on the state alone, and a world of few pairs keeps its own.
 */
#include "world/world.h"

#define MOVES_LEAST 4096        /* records: fewer are left where they are */
#define LOOKS_EVERY 16          /* steps */
#define ASTRAY      16          /* one in so many pairs out of order is too much */

static bool many_free(int count, int unused) { return count >= MOVES_LEAST && unused > count / 3; }

/* Of the pairs that a step goes through: have many a later solid that should come before that of the pair before them? */
static bool disordered(const World *w)
{
    uint32_t before = 0;
    int astray = 0;
    if (w->near.count < MOVES_LEAST || w->steps % LOOKS_EVERY != 0)
        return false;
    for (int i = 0; i < w->near.count; i++) {
        const Pair *p = &w->pairs.data[w->near.data[i]];
        astray += p->alive && p->solid_b < before;
        before = p->alive ? p->solid_b : before;
    }
    return astray > w->near.count / ASTRAY;
}

static uint32_t moved_side(const uint32_t *to, uint32_t side) { return side == NONE ? NONE : 2 * to[side / 2] + side % 2; }

/* What there is of pairs by number, but for the index: their lists, those of their solids, the near ones. */
static void renumber_pairs(World *w, const uint32_t *to, int count)
{
    int n = 0;
    for (int i = 0; i < count; i++)
        for (int k = 0; k < 2; k++) {
            w->pairs.data[i].next[k] = moved_side(to, w->pairs.data[i].next[k]);
            w->pairs.data[i].prev[k] = moved_side(to, w->pairs.data[i].prev[k]);
        }
    for (int i = 0; i < w->solids.count; i++)
        if (w->solids.data[i].alive)
            w->solids.data[i].pair_first = moved_side(to, w->solids.data[i].pair_first);
    for (int i = 0; i < w->near.count; i++)
        if (to[w->near.data[i]] != NONE)
            w->near.data[n++] = to[w->near.data[i]];
    w->near.count = n;
}

/* to[pair]: its number when the pairs of each solid with earlier ones follow each other; NONE = it is gone. Returns how many there are. */
static int number_pairs(const World *w, uint32_t *to)
{
    int count = 0;
    memset(to, 0xff, (size_t)w->pairs.count * sizeof *to);
    for (int i = 0; i < w->solids.count; i++)
        for (uint32_t l = w->solids.data[i].alive ? w->solids.data[i].pair_first : NONE; l != NONE; l = w->pairs.data[l / 2].next[l % 2])
            if (l % 2 == 1)     /* once, as the later of its two */
                to[l / 2] = (uint32_t)count++;
    return count;
}

static dig_status move_pairs(World *w)
{
    ArenaMark mark = arena_mark(&w->scratch);
    uint32_t *to = arena_alloc(&w->scratch, (size_t)w->pairs.count * sizeof *to);
    Pair *old = arena_alloc(&w->scratch, (size_t)w->pairs.count * sizeof *old);
    if (!to || !old) {
        arena_rewind(&w->scratch, mark);
        return world_fail(w, DIG_E_MEMORY, "not enough memory for %d pairs", w->pairs.count);
    }
    memcpy(old, w->pairs.data, (size_t)w->pairs.count * sizeof *old);
    int count = number_pairs(w, to);
    for (int i = 0; i < w->pairs.count; i++)
        if (to[i] != NONE)
            w->pairs.data[to[i]] = old[i];
    renumber_pairs(w, to, count);
    w->pairs.count = count;
    w->free_pairs.count = 0;
    list_trim(&w->pairs, count + count / 8);
    list_trim(&w->free_pairs, w->pairs.capacity);
    list_trim(&w->near, w->near.count + w->near.count / 8);
    index_renumber(&w->pair_index, to, &w->scratch);
    arena_rewind(&w->scratch, mark);
    return DIG_OK;
}

static dig_status move_memories(World *w)
{
    ArenaMark mark = arena_mark(&w->scratch);
    PairMemory *old = arena_alloc(&w->scratch, (size_t)w->memories.count * sizeof *old);
    if (!old)
        return world_fail(w, DIG_E_MEMORY, "not enough memory for %d memories", w->memories.count);
    memcpy(old, w->memories.data, (size_t)w->memories.count * sizeof *old);
    w->memories.count = w->free_memories.count = 0;
    for (int i = 0; i < w->pairs.count; i++) {
        Pair *p = &w->pairs.data[i];
        if (!p->alive || p->memory == NONE)
            continue;
        w->memories.data[w->memories.count] = old[p->memory];
        p->memory = (uint32_t)w->memories.count++;
    }
    arena_rewind(&w->scratch, mark);
    list_trim(&w->memories, w->memories.count + w->memories.count / 8);
    list_trim(&w->free_memories, w->memories.capacity);
    return DIG_OK;
}

/* Contacts of one pair, from the old places to the next free ones. */
static void move_list(World *w, Pair *p, const Contact *old, const ContactRest *old_rest, const MorePoints *old_more)
{
    uint32_t *link = &p->contact;
    for (uint32_t c = p->contact; c != NONE; c = old[c].next) {
        Contact *to = &w->contacts.data[w->contacts.count];
        *to = old[c];
        if (to->rests)
            w->contact_rest.data[w->contacts.count] = old_rest[c];
        if (to->more != NONE) {
            w->more.data[w->more.count] = old_more[to->more];
            to->more = (uint32_t)w->more.count++;
        }
        *link = (uint32_t)w->contacts.count++;
        link = &to->next;
    }
}

static dig_status move_contacts(World *w)
{
    ArenaMark mark = arena_mark(&w->scratch);
    Contact *old = arena_alloc(&w->scratch, (size_t)w->contacts.count * sizeof *old);
    ContactRest *old_rest = arena_alloc(&w->scratch, (size_t)w->contacts.count * sizeof *old_rest);
    MorePoints *old_more = arena_alloc(&w->scratch, (size_t)w->more.count * sizeof *old_more);
    if (!old || !old_rest || !old_more) {
        arena_rewind(&w->scratch, mark);
        return world_fail(w, DIG_E_MEMORY, "not enough memory for %d contacts", w->contacts.count);
    }
    memcpy(old, w->contacts.data, (size_t)w->contacts.count * sizeof *old);
    for (int i = 0; i < w->contacts.count; i++)
        if (old[i].rests)
            old_rest[i] = w->contact_rest.data[i];
    if (w->more.count > 0)
        memcpy(old_more, w->more.data, (size_t)w->more.count * sizeof *old_more);
    w->contacts.count = w->more.count = w->free_contacts.count = w->free_more.count = 0;
    for (int i = 0; i < w->pairs.count; i++)
        if (w->pairs.data[i].alive)
            move_list(w, &w->pairs.data[i], old, old_rest, old_more);
    arena_rewind(&w->scratch, mark);
    list_trim(&w->contacts, w->contacts.count + w->contacts.count / 8);
    w->contact_rest.count = w->contacts.count;
    list_trim(&w->contact_rest, w->contacts.capacity);
    list_trim(&w->more, w->more.count + w->more.count / 8);
    list_trim(&w->free_contacts, w->contacts.capacity);
    list_trim(&w->free_more, w->more.capacity);
    return DIG_OK;
}

dig_status world_compact(World *w)
{
    bool all = disordered(w) || many_free(w->pairs.count, w->free_pairs.count);
    if (all)
        DIG_TRY(move_pairs(w));
    if (w->memories.count > 0 && (all || many_free(w->memories.count, w->free_memories.count)))
        DIG_TRY(move_memories(w));
    bool contacts = w->contacts.count > 0 && (all || many_free(w->contacts.count, w->free_contacts.count));
    return contacts ? move_contacts(w) : DIG_OK;
}
