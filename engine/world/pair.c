/* world/pair.c - pairs of solids that may touch, their contacts, and which bodies touch.
 *
 * A pair lives while the fat boxes of its solids overlap. With a mesh it owns a fixed number of contacts from its birth. Two convex
 * solids have one, from when there is something to remember until there is nothing (solve/gather.c): most of their pairs are near each
 * other and never touch.
 */
#include "world/world.h"

dig_status contact_take(World *w, uint32_t *slot)
{
    DIG_TRY(world_slot(w, &w->contacts, &w->free_contacts, slot));
    w->contacts.data[*slot].next = w->contacts.data[*slot].more = NONE;
    dig_status room = contacts_rest(w);
    if (room == DIG_OK)
        w->contacts.data[*slot].rests = false;
    else
        slot_give(w, &w->free_contacts, *slot);
    return room;
}

dig_status contacts_rest(World *w)
{
    DIG_TRY(list_reserve(&w->contact_rest, w->contacts.capacity, &w->allocations));
    w->contact_rest.count = w->contacts.count;
    return DIG_OK;
}

dig_status contact_widen(World *w, Contact *c)
{
    return c->more == NONE ? world_slot(w, &w->more, &w->free_more, &c->more) : DIG_OK;
}

void contact_give(World *w, uint32_t slot)
{
    if (w->contacts.data[slot].more != NONE)
        slot_give(w, &w->free_more, w->contacts.data[slot].more);
    slot_give(w, &w->free_contacts, slot);
}

/* Triangles of a mesh or height field that one convex solid may touch at once. */
#define MESH_CONTACTS 16

static Rub rub_of(const World *w, const Pair *p)
{
    return surface_pair(w, &w->solids.data[p->solid_a].form->surface, &w->solids.data[p->solid_b].form->surface);
}

Rub pair_rub(const World *w, const Pair *p) { return p->memory == NONE ? rub_of(w, p) : w->memories.data[p->memory].rub; }

dig_status pair_remember(World *w, Pair *p)
{
    uint32_t slot;
    DIG_TRY(world_slot(w, &w->memories, &w->free_memories, &slot));
    w->memories.data[slot].rub = rub_of(w, p);
    p->memory = slot;
    return DIG_OK;
}

void pair_forget(World *w, Pair *p)
{
    slot_give(w, &w->free_memories, p->memory);
    p->memory = NONE;
}

void pair_sort(const World *w, Pair *p)
{
    Rub rub = pair_rub(w, p);
    p->smooth = !(rub.friction > 0);
    p->bounces = rub.restitution > 0;
    const ShapeType *a = w->solids.data[p->solid_a].form->shape.type, *b = w->solids.data[p->solid_b].form->shape.type;
    p->dynamic_a = body_dynamic(w, p->body_a);
    p->dynamic_b = body_dynamic(w, p->body_b);
    p->pieces = a->pieces || b->pieces;
    p->round = a == &shape_sphere || b == &shape_sphere;
}

static void link_in(World *w, uint32_t pair, uint32_t side, uint32_t solid)
{
    Pair *p = &w->pairs.data[pair];
    Solid *s = &w->solids.data[solid];
    p->next[side] = s->pair_first;
    p->prev[side] = NONE;
    if (s->pair_first != NONE)
        w->pairs.data[s->pair_first / 2].prev[s->pair_first % 2] = 2 * pair + side;
    s->pair_first = 2 * pair + side;
}


void pair_attach(World *w, uint32_t pair)
{
    link_in(w, pair, 0, w->pairs.data[pair].solid_a);
    link_in(w, pair, 1, w->pairs.data[pair].solid_b);
}

static void link_out(World *w, uint32_t pair, uint32_t side, uint32_t solid)
{
    const Pair *p = &w->pairs.data[pair];
    uint32_t next = p->next[side], prev = p->prev[side];
    if (prev == NONE)
        w->solids.data[solid].pair_first = next;
    else
        w->pairs.data[prev / 2].next[prev % 2] = next;
    if (next != NONE)
        w->pairs.data[next / 2].prev[next % 2] = prev;
}

static bool is_pair(const void *world, uint32_t pair, MapKey key)
{
    const Pair *p = &((const World *)world)->pairs.data[pair];
    return p->solid_a == key.a && p->solid_b == key.b;
}

bool pair_find(const World *w, uint32_t solid_a, uint32_t solid_b, uint32_t *pair)
{
    MapKey key = {solid_a < solid_b ? solid_a : solid_b, solid_a < solid_b ? solid_b : solid_a, 0};
    return index_find(&w->pair_index, key, is_pair, w, pair);
}

dig_status pair_enter(World *w, uint32_t pair)
{
    const Pair *p = &w->pairs.data[pair];
    return index_add(&w->pair_index, (MapKey){p->solid_a, p->solid_b, 0}, pair);
}

/* All that a new pair needs, or nothing. */
static dig_status take_room(World *w, MapKey key, uint32_t *slot, uint32_t *contact, int want)
{
    DIG_TRY(list_reserve(&w->near, w->near.count + 1, &w->allocations));
    DIG_TRY(world_slot(w, &w->pairs, &w->free_pairs, slot));
    int got = 0;
    dig_status status = DIG_OK;
    while (status == DIG_OK && got < want) {
        status = contact_take(w, &contact[got]);
        got += status == DIG_OK;
    }
    if (status == DIG_OK)
        status = index_add(&w->pair_index, key, *slot);
    if (status == DIG_OK)
        return DIG_OK;
    while (got > 0)
        contact_give(w, contact[--got]);
    slot_give(w, &w->free_pairs, *slot);
    return status;
}

Pair pair_new(const World *w, uint32_t solid_a, uint32_t solid_b)
{
    uint32_t low = solid_a < solid_b ? solid_a : solid_b, high = solid_a < solid_b ? solid_b : solid_a;
    Pair pair = {.alive = true, .solid_a = low, .solid_b = high, .body_a = w->solids.data[low].body, .body_b = w->solids.data[high].body,
                 .memory = NONE, .listed = true, .fresh = true, .until = -1};
    pair_sort(w, &pair);
    return pair;
}

dig_status pair_add_made(World *w, const Pair *made)
{
    uint32_t slot, contact[MESH_CONTACTS];
    int want = made->pieces ? MESH_CONTACTS : 0;
    DIG_TRY(take_room(w, (MapKey){made->solid_a, made->solid_b, 0}, &slot, contact, want));
    for (int i = 0; i < want; i++)
        w->contacts.data[contact[i]].next = i + 1 < want ? contact[i + 1] : NONE;
    w->pairs.data[slot] = *made;
    w->pairs.data[slot].contact = want > 0 ? contact[0] : NONE;
    w->tally.smooth += made->smooth;
    w->near.data[w->near.count++] = slot;
    pair_attach(w, slot);
    return DIG_OK;
}

dig_status pair_add(World *w, uint32_t solid_a, uint32_t solid_b)
{
    Pair made = pair_new(w, solid_a, solid_b);
    return pair_add_made(w, &made);
}

/* A touching pair that goes ends its share of the touch. */
static void leave_touch(World *w, const Pair *p)
{
    uint8_t wall = w->solids.data[p->solid_a].wall | w->solids.data[p->solid_b].wall;
    Touch *t = touch_find(w, p->body_a, p->body_b, wall);
    if (!t || t->pairs == 0)
        return;
    touch_count(w, t, -1);
    if (t->pairs == 0 && !t->brief && w->brief.count < w->brief.capacity) {     /* there is room for every touch */
        t->brief = true;
        w->brief.data[w->brief.count++] = (uint32_t)(t - w->touches.data);
    }
}

bool pair_between(const World *w, uint32_t body_a, uint32_t body_b, uint32_t *pair)
{
    const Body *a = &w->bodies.data[body_a], *b = &w->bodies.data[body_b];
    if (a->shape_count != 1 || b->shape_count != 1)
        return false;
    uint32_t x = a->shape_first, y = b->shape_first;
    if (!pair_find(w, x, y, pair))
        *pair = NONE;
    return true;
}

void pair_remove(World *w, uint32_t pair)
{
    Pair *p = &w->pairs.data[pair];
    for (uint32_t c = p->contact; c != NONE;) {
        uint32_t next = w->contacts.data[c].next;
        contact_give(w, c);
        c = next;
    }
    if (p->memory != NONE)
        pair_forget(w, p);
    if (p->touching)
        leave_touch(w, p);
    link_out(w, pair, 0, p->solid_a);
    link_out(w, pair, 1, p->solid_b);
    index_remove(&w->pair_index, (MapKey){p->solid_a, p->solid_b, 0}, pair);
    p->alive = false;
    w->tally.smooth -= p->smooth;
    slot_give(w, &w->free_pairs, pair);
}

/* Contacts with a mesh stay its own. */
void pair_let_go(World *w, uint32_t pair)
{
    Pair *p = &w->pairs.data[pair];
    for (uint32_t c = p->contact; c != NONE;) {
        Contact *contact = &w->contacts.data[c];
        uint32_t next = contact->next;
        if (p->pieces) {
            *contact = (Contact){.next = next, .more = contact->more};
        } else {
            contact_give(w, c);
        }
        c = next;
    }
    p->contact = p->pieces ? p->contact : NONE;
    if (p->memory != NONE)
        pair_forget(w, p);
    if (p->touching)
        leave_touch(w, p);
    p->touching = false;
    p->until = -1;
    pair_stir(p);
}

void pairs_of_solid_remove(World *w, uint32_t solid)
{
    while (w->solids.data[solid].pair_first != NONE)
        pair_remove(w, w->solids.data[solid].pair_first / 2);
}

static void refresh_surfaces(World *w, Pair *p)
{
    if (p->memory != NONE)
        w->memories.data[p->memory].rub = rub_of(w, p);
    w->tally.smooth -= p->smooth;
    pair_sort(w, p);
    w->tally.smooth += p->smooth;
}

void all_pairs_refresh_surfaces(World *w)
{
    for (int i = 0; i < w->pairs.count; i++)
        if (w->pairs.data[i].alive)
            refresh_surfaces(w, &w->pairs.data[i]);
}

void pairs_refresh_surfaces(World *w, uint32_t body)
{
    for (uint32_t s = w->bodies.data[body].shape_first; s != NONE; s = w->solids.data[s].next)
        for (uint32_t l = w->solids.data[s].pair_first; l != NONE; l = w->pairs.data[l / 2].next[l % 2])
            refresh_surfaces(w, &w->pairs.data[l / 2]);
}

static bool is_touch(const void *world, uint32_t touch, MapKey key)
{
    const Touch *t = &((const World *)world)->touches.data[touch];
    return t->body_a == key.a && t->body_b == key.b && t->wall == key.c;
}

dig_status touch_enter(World *w, uint32_t touch)
{
    const Touch *t = &w->touches.data[touch];
    return index_add(&w->touch_index, (MapKey){t->body_a, t->body_b, t->wall}, touch);
}

dig_status touch_find_or_add(World *w, uint32_t a, uint32_t b, uint8_t wall, uint32_t *slot)
{
    if (a > b) {            /* NONE, the world, is the largest: it stays second */
        uint32_t t = a;
        a = b;
        b = t;
    }
    MapKey key = {a, b, wall};
    if (index_find(&w->touch_index, key, is_touch, w, slot))
        return DIG_OK;
    DIG_TRY(world_slot(w, &w->touches, &w->free_touches, slot));
    DIG_TRY(index_add(&w->touch_index, key, *slot));
    w->touches.data[*slot] = (Touch){.alive = true, .body_a = a, .body_b = b, .wall = wall, .link = NONE};
    return DIG_OK;
}

void touch_count(World *w, Touch *t, int more)
{
    w->tally.touching -= t->pairs > 0;
    t->pairs += more;
    w->tally.touching += t->pairs > 0;
}

Touch *touch_find(const World *w, uint32_t a, uint32_t b, uint8_t wall)
{
    uint32_t slot;
    MapKey key = {a < b ? a : b, a < b ? b : a, wall};
    return index_find(&w->touch_index, key, is_touch, w, &slot) ? &w->touches.data[slot] : NULL;
}

/* Its slot may be another touch's before the next regraph: it leaves the list of those that are over, too. */
void touch_remove(World *w, uint32_t slot)
{
    Touch *t = &w->touches.data[slot];
    int n = 0;
    for (int i = 0; t->brief && i < w->brief.count; i++)
        if (w->brief.data[i] != slot)
            w->brief.data[n++] = w->brief.data[i];
    w->brief.count = t->brief ? n : w->brief.count;
    index_remove(&w->touch_index, (MapKey){t->body_a, t->body_b, t->wall}, slot);
    touch_count(w, t, -t->pairs);
    t->alive = false;
    slot_give(w, &w->free_touches, slot);
}
