/* solve/keep.c - a group as it was, for ways that may find half way that they cannot do it. */
#include "solve/group.h"

/* All copies lie in one block: the next one is at `to`. */
static void *copy(unsigned char **to, const void *from, size_t bytes)
{
    void *at = *to;
    if (bytes > 0)              /* there may be none, and nowhere to take them from */
        memcpy(at, from, bytes);
    *to += (bytes + ARENA_ALIGN - 1) & ~(size_t)(ARENA_ALIGN - 1);
    return at;
}

static void put_back(void *to, const void *from, size_t bytes)
{
    if (bytes > 0)
        memcpy(to, from, bytes);
}

#define SIZE(field, count) ((size_t)(count) * sizeof *g->field + ARENA_ALIGN)
#define KEEP(field, count) (k->field = copy(&to, g->field, (size_t)(count) * sizeof *g->field))
#define BACK(field, count) put_back(g->field, k->field, (size_t)(count) * sizeof *g->field)

bool group_keep_in(const Group *g, GroupKept *k)
{
    int bodies = g->body_count;
    size_t bytes = SIZE(pos, bodies) + SIZE(vel, bodies) + SIZE(mass, bodies) + SIZE(member, bodies)
        + SIZE(pairs, g->pair_count) + SIZE(contacts, g->contact_count) + SIZE(places, g->place_count) + SIZE(joints, g->joint_count)
        + SIZE(apart, g->apart ? g->moving_count : 0) + SIZE(start_pos, bodies) + SIZE(start_vel, bodies) + SIZE(been, bodies)
        + SIZE(contact_rest, g->contact_count)
        + SIZE(acted, g->contact_count) + SIZE(impacts, g->impact_count)
        + SIZE(rubs, g->rubs ? g->pair_count : 0);
    if (bytes > k->bytes) {
        k->block = arena_alloc(g->arena, bytes);
        k->bytes = k->block ? bytes : 0;
    }
    unsigned char *to = k->block;
    if (!to)
        return false;
    k->scalars = *g;
    KEEP(pos, bodies);
    KEEP(vel, bodies);
    KEEP(mass, bodies);
    KEEP(member, bodies);
    KEEP(start_pos, bodies);
    KEEP(start_vel, bodies);
    KEEP(been, bodies);
    KEEP(contact_rest, g->contact_count);
    KEEP(acted, g->contact_count);
    KEEP(impacts, g->impact_count);
    KEEP(rubs, g->rubs ? g->pair_count : 0);
    KEEP(pairs, g->pair_count);
    KEEP(contacts, g->contact_count);
    KEEP(places, g->place_count);
    KEEP(joints, g->joint_count);
    KEEP(apart, g->apart ? g->moving_count : 0);
    return true;
}

bool group_keep(const Group *g, GroupKept *k)
{
    k->block = NULL;
    k->bytes = 0;
    return group_keep_in(g, k);
}

void group_put_back(Group *g, const GroupKept *k)
{
    int evaluations = g->evaluations, refused = g->refused, kind_turns = g->kind_turns;
    BACK(pos, g->body_count);
    BACK(vel, g->body_count);
    BACK(mass, g->body_count);
    BACK(member, g->body_count);
    BACK(pairs, g->pair_count);
    BACK(contacts, g->contact_count);
    BACK(places, g->place_count);
    BACK(joints, g->joint_count);
    BACK(apart, g->apart ? g->moving_count : 0);
    BACK(start_pos, g->body_count);
    BACK(start_vel, g->body_count);
    BACK(been, g->body_count);
    BACK(contact_rest, g->contact_count);
    BACK(acted, g->contact_count);
    BACK(impacts, k->scalars.impact_count);
    BACK(rubs, g->rubs ? g->pair_count : 0);
    *g = k->scalars;
    g->evaluations = evaluations;
    g->kind_turns = kind_turns;
    g->refused = refused;
}

bool group_deep(const Group *g)
{
    for (int i = 0; i < g->contact_count; i++)
        for (int k = 0; g->contacts[i].live && k < g->contacts[i].manifold.count; k++)
            if (g->contacts[i].manifold.points[k].gap < 0)
                return true;
    return false;
}

bool group_joints_broken(const Group *g)
{
    for (int i = 0; i < g->moving_count; i++) {
        const Body *b = &g->world->bodies.data[g->member[i].slot];
        const BodyRest *rest = body_rest(g->world, b);
        if (b->collided || (b->rests && (vec3_length2(rest->hit_v) > 0 || vec3_length2(rest->hit_w) > 0)))
            return true;
    }
    for (int i = 0; i < g->joint_count; i++) {
        bool fresh = true;
        for (int k = 0; k < JOINT_SLOTS && fresh; k++)
            fresh = g->joints[i].force[k] == 0;
        if (fresh)
            return true;
    }
    return false;
}
