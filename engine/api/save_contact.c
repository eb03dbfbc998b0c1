/* api/save_contact.c - the sections of pairs with their contacts, and of touches. */
#include "api/save.h"

#include <stdlib.h>

enum { PAIR_BYTES = 88, CONTACT_BYTES = 106, TOUCH_BYTES = 115 };       /* at least */
enum { CONTACTS_MAX = 64 };     /* of one pair; pair.c makes fewer */

/* ---- contacts ---- */

static void pack_point(Pack *p, ContactPoint *c)
{
    ManifoldPoint *point = &c->at;
    PointMemory *memory = &c->memory;
    pack_vec3(p, &point->a, 2 * SAVE_FAR, "point of a contact");
    pack_vec3(p, &point->b, 2 * SAVE_FAR, "point of a contact");
    pack_real_in(p, &point->gap, -4 * SAVE_FAR, 4 * SAVE_FAR, "gap of a contact");
    pack_u32(p, &point->feature);
    uint32_t again = point->feature;        /* its memory had a copy once, and has its place in the file */
    pack_u32(p, &again);
    pack_real_in(p, &memory->normal, -SAVE_STRONG, SAVE_STRONG, "force of a contact");
    pack_vec3(p, &memory->tangent, SAVE_STRONG, "friction of a contact");
    pack_enum(p, &memory->held, 256, "memory of a contact");
    real borne = (real)memory->borne;
    pack_real_in(p, &borne, 0, SAVE_STRONG, "borne force of a contact");
    memory->borne = (float)borne;
}

static void pack_contact(Pack *p, World *w, Contact *c)
{
    int count = c->count;
    pack_u32(p, &c->piece);
    pack_vec3(p, &c->normal, 1 + 1e-9, "normal of a contact");
    pack_enum(p, &count, MANIFOLD_POINTS + 1, "number of points of a contact");
    pack_check(p, count == 0 || fabs(vec3_length2(c->normal) - 1) < 1e-9, "the normal of a contact is no unit vector");
    if (p->reading && pack_good(p)) {
        c->count = (uint8_t)count;
        c->more = NONE;
        if (count > 1 && contact_widen(w, c) != DIG_OK)
            pack_fail_memory(p);
    }
    for (int i = 0; i < count && pack_good(p); i++)
        pack_point(p, contact_point(w, c, i));
    uint32_t slot = (uint32_t)(c - w->contacts.data);
    vec3 rolling = contact_rest(w, slot).rolling;
    pack_vec3(p, &rolling, SAVE_STRONG, "rolling friction of a contact");
    if (p->reading)
        contact_rest_set(w, slot, (ContactRest){rolling, 0});
    pack_vec3(p, &c->force, SAVE_STRONG, "force of a contact");
    pack_vec3(p, &c->point, SAVE_FAR, "place of a contact");
    pack_bool(p, &c->touching);
    uint8_t how = (uint8_t)(c->sliding | c->grips << 1);
    pack_small(p, &how, 4, "state of a contact");
    if (p->reading) {
        c->sliding = how & 1;
        c->grips = how >> 1;
    }
}

static uint8_t count_contacts(const World *w, const Pair *pair)
{
    uint8_t n = 0;
    for (uint32_t c = pair->contact; c != NONE; c = w->contacts.data[c].next)
        n++;
    return n;
}

/* The contacts of a pair follow it, in their order. `taken` marks those that are free or were met already. */
static void pack_contacts(Pack *p, World *w, Pair *pair, unsigned char *taken)
{
    uint8_t count = p->reading ? 0 : count_contacts(w, pair);
    uint32_t slot = p->reading ? 0 : pair->contact, *link = &pair->contact;
    pack_small(p, &count, CONTACTS_MAX + 1, "number of contacts of a pair");
    for (uint8_t i = 0; i < count; i++) {
        pack_index(p, &slot, (uint32_t)w->contacts.count, false, "contact of a pair");
        if (!pack_good(p) || !pack_check(p, !taken[slot], "a contact is in two places"))
            return;
        taken[slot] = 1;
        Contact *c = &w->contacts.data[slot];
        pack_contact(p, w, c);
        if (p->reading)
            *link = slot;
        link = &c->next;
        slot = p->reading ? 0 : c->next;
    }
    *link = NONE;
}

/* ---- pairs ---- */

static void pack_cache(Pack *p, ManifoldCache *c)
{
    pack_u32(p, &c->kind);
    pack_u32(p, &c->feature_a);
    pack_u32(p, &c->feature_b);
    for (int i = 0; i < 3; i++)
        pack_real_in(p, &c->axis[i], -1e100, 1e100, "axis of a pair");
}

/* Every pair has one in the file. */
static void pack_memory(Pack *p, PairMemory *k)
{
    pack_cache(p, &k->cache);
    pack_real_in(p, &k->rub.friction, 0, 1e6, "friction of a pair");
    pack_real_in(p, &k->rub.friction_dynamic, 0, 1e6, "friction_dynamic of a pair");
    pack_real_in(p, &k->rub.rolling, 0, 1e6, "rolling_friction of a pair");
    pack_real_in(p, &k->rub.restitution, 0, 1, "restitution of a pair");
}

/* A pair has a memory as long as it has a hint; one with pieces, from the start. What two surfaces make of each other is made anew, as it is of
 * pairs without: threads share it, so no pair can have one of its own. */
static void connect_memory(Pack *p, World *w, Pair *pair, const PairMemory *k)
{
    if (!pack_good(p) || (count_contacts(w, pair) < 2 && k->cache.kind == 0))
        return;
    if (pair_remember(w, pair) == DIG_OK)
        w->memories.data[pair->memory].cache = k->cache;
    else
        pack_fail_memory(p);
}

static void pack_pair(Pack *p, World *w, Pair *pair, unsigned char *taken)
{
    PairMemory memory = {.cache = {.kind = 0}};
    if (p->reading)
        pair->memory = NONE;
    else if (pair->memory != NONE)
        memory = w->memories.data[pair->memory];
    else
        memory.rub = pair_rub(w, pair);
    pair->alive = true;
    pack_index(p, &pair->solid_a, (uint32_t)w->solids.count, false, "first solid of a pair");
    pack_index(p, &pair->solid_b, (uint32_t)w->solids.count, false, "second solid of a pair");
    if (p->reading && pack_good(p))         /* what the two make of each other is asked of them below */
        pack_check(p, w->solids.data[pair->solid_a].alive && w->solids.data[pair->solid_b].alive, "a pair of shapes that are none");
    pack_real_in(p, &pair->until, -1, 4 * TRAVEL_MOST, "travel of a pair");
    pack_memory(p, &memory);
    pack_u32(p, &pair->next[0]);
    pack_u32(p, &pair->next[1]);
    pack_bool(p, &pair->touching);
    pack_bool(p, &pair->fresh);
    pack_contacts(p, w, pair, taken);
    if (p->reading)
        connect_memory(p, w, pair, &memory);
}

static bool all_taken(const World *w, const unsigned char *taken)
{
    for (int i = 0; i < w->contacts.count; i++)
        if (!taken[i])
            return false;
    return true;
}

void save_pairs(Pack *p, World *w)
{
    unsigned char *taken = SAVE_TABLE(p, w, &w->contacts, &w->free_contacts, CONTACT_BYTES, "contacts");
    if (p->reading && taken && contacts_rest(w) != DIG_OK)
        pack_fail_memory(p);
    unsigned char *unused = taken ? SAVE_TABLE(p, w, &w->pairs, &w->free_pairs, PAIR_BYTES, "pairs") : NULL;
    for (int i = 0; unused && i < w->pairs.count && pack_good(p); i++)
        if (!unused[i])
            pack_pair(p, w, &w->pairs.data[i], taken);
    pack_check(p, !unused || all_taken(w, taken), "a contact belongs to no pair");
    free(unused);
    free(taken);
}

/* ---- touches ---- */

static void pack_touch(Pack *p, const World *w, Touch *t)
{
    uint32_t pairs = (uint32_t)t->pairs;
    t->alive = true;
    pack_index(p, &t->body_a, (uint32_t)w->bodies.count, false, "first body of a touch");
    pack_index(p, &t->body_b, (uint32_t)w->bodies.count, true, "second body of a touch");
    pack_u32(p, &t->link);
    pack_index(p, &pairs, (uint32_t)w->pairs.count + 1, false, "pairs of a touch");
    t->pairs = (int)pairs;
    pack_small(p, &t->wall, 7, "wall of a touch");
    pack_bool(p, &t->brief);
    pack_bool(p, &t->bounced);
    pack_real_in(p, &t->began, -SAVE_LONG, SAVE_LONG, "beginning of a touch");
    for (int i = 0; i < 3; i++) {       /* place, normal, force: its contacts have them */
        vec3 none = vec3_zero();
        pack_vec3(p, &none, SAVE_STRONG, "place of a touch");
    }
    pack_real_in(p, &t->speed, -SAVE_FAST, SAVE_FAST, "speed of a touch");
    pack_real_in(p, &t->impulse, -SAVE_STRONG, SAVE_STRONG, "impulse of a touch");
}

void save_touches(Pack *p, World *w)
{
    unsigned char *unused = SAVE_TABLE(p, w, &w->touches, &w->free_touches, TOUCH_BYTES, "touches");
    for (int i = 0; unused && i < w->touches.count && pack_good(p); i++)
        if (!unused[i])
            pack_touch(p, w, &w->touches.data[i]);
    free(unused);
}
