/* solve/fused.c - what welds make one thing does not touch itself.
 *
 * Two bodies that a joint holds together do not touch each other, unless it says so. Neither do those that a chain of welds holds: they
 * cannot move against each other, so that all a contact could do is to contradict the welds. It did: rows of contacts hold where bodies
 * are, those of joints where they will be half a substep on, and by what lies between the two both pushed without end, along arms
 * that were not the same. A square of four cubes with three welds stopped spinning within a second.
 *
 * A weld that can break counts only while its thing flies, with nothing near it, held or pushed by nothing. A wall that is bolted brick to
 * brick bears its weight by what lies on each other, too, and a bolt that had to bear all of it would break. There rows of contacts are
 * those of the middle of the substep, too, as soon as it turns (effect/contact.c). */
#include "solve/group.h"
#include "base/forest.h"
#include "world/joint.h"

#include <stdlib.h>

static bool holds(const Group *g, const GroupJoint *j)
{
    const JointType *t = j->view.type;
    return t->fuses && !t->elastic && !g->world->joints.data[j->slot].collides;
}

/* All that is held by the world is one thing, too: the last number is the world's. */
static int end_of(const Group *g, int body) { return body < 0 ? g->body_count : body; }

/* The lowest body of each one's thing. */
static int *find_things(const Group *g, bool breakable)
{
    int *root = arena_alloc(g->lasting, (size_t)(g->body_count + 1) * sizeof *root);
    for (int i = 0; root && i <= g->body_count; i++)
        root[i] = i;
    for (int i = 0; root && i < g->joint_count; i++)
        if (holds(g, &g->joints[i]) && (breakable || !(g->joints[i].breaks_at > 0)))
            forest_unite(root, end_of(g, g->joints[i].a), end_of(g, g->joints[i].b));
    for (int i = 0; root && i <= g->body_count; i++)
        root[i] = root[root[i]];                /* lower, and done */
    return root;
}

static int compare_slot(const void *key, const void *slot)
{
    uint32_t a = *(const uint32_t *)key, b = *(const uint32_t *)slot;
    return a < b ? -1 : a > b;
}

static void tie(const Things *t, int a, int b)
{
    if (t->whole[a] != t->whole[b])
        t->tied[t->whole[a]] = t->tied[t->whole[b]] = true;
}

static void find_tied(const Group *g)
{
    const World *w = g->world;
    const Things *t = g->things;
    for (int i = 0; i <= g->body_count; i++)
        if (i == g->body_count || !g->member[i].moves)
            t->tied[t->whole[i]] = true;
    for (int i = 0; i < g->joint_count; i++)
        tie(t, end_of(g, g->joints[i].a), end_of(g, g->joints[i].b));
    for (int i = 0; i < w->pushes.count; i++) {
        const uint32_t *at = bsearch(&w->pushes.data[i].body, g->slots, (size_t)g->moving_count, sizeof *g->slots, compare_slot);
        if (at)
            t->tied[t->whole[at - g->slots]] = true;
    }
}

dig_status fuse(Group *g, int pair_count)
{
    bool any = false;
    for (int i = 0; i < g->joint_count && !any; i++)
        any = holds(g, &g->joints[i]);
    if (!any || pair_count == 0)
        return DIG_OK;
    g->things = arena_alloc(g->lasting, sizeof *g->things);
    g->over = arena_alloc(g->lasting, (size_t)pair_count * sizeof *g->over);
    if (!g->things || !g->over)
        return DIG_E_MEMORY;
    *g->things = (Things){find_things(g, false), find_things(g, true), arena_zero(g->lasting, (size_t)(g->body_count + 1) * sizeof(bool))};
    if (!g->things->firm || !g->things->whole || !g->things->tied)
        return DIG_E_MEMORY;
    find_tied(g);
    return DIG_OK;
}

void fuse_near(Group *g, int a, int b)
{
    if (g->things)
        tie(g->things, a, b);
}

bool fused(Group *g, uint32_t pair, int a, int b)
{
    const World *w = g->world;
    const Pair *p = &w->pairs.data[pair];
    const Things *t = g->things;
    bool one = t && (t->firm[a] == t->firm[b] || (t->whole[a] == t->whole[b] && !t->tied[t->whole[a]]));
    if (!one || joint_asks_contact(w, p->body_a, p->body_b))
        return false;
    if (p->touching)
        g->over[g->over_count++] = pair;
    return true;
}
