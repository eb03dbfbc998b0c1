/* solve/fused.c - what welds make one thing does not touch itself.
 *
 * Two bodies that a joint holds together do not touch each other, unless it says so. Neither do those that a chain of welds holds: they
 * cannot move against each other, so that all a contact could do is to contradict the welds. It did: rows of contacts hold where bodies
 * are, those of joints where they will be half a substep on, and by what lies between the two both pushed without end, along arms
 * that were not the same. A square of four cubes with three welds stopped spinning within a second.
 *
 * A weld that can break is none of these. A wall that is bolted brick to brick bears its weight by what lies on each other, too, and a
 * bolt that had to bear all of it would break. */
#include "solve/group.h"
#include "base/forest.h"
#include "world/joint.h"

static bool holds_for_good(const Group *g, const GroupJoint *j)
{
    const JointType *t = j->view.type;
    return t->fuses && !t->elastic && !(j->breaks_at > 0) && !g->world->joints.data[j->slot].collides;
}

/* All that is held by the world is one thing, too: the last number is the world's. */
static int end_of(const Group *g, int body) { return body < 0 ? g->body_count : body; }

dig_status fuse(Group *g, int pair_count)
{
    bool any = false;
    for (int i = 0; i < g->joint_count && !any; i++)
        any = holds_for_good(g, &g->joints[i]);
    if (!any || pair_count == 0)
        return DIG_OK;
    g->thing = arena_alloc(g->arena, (size_t)(g->body_count + 1) * sizeof *g->thing);
    g->over = arena_alloc(g->arena, (size_t)pair_count * sizeof *g->over);
    if (!g->thing || !g->over)
        return DIG_E_MEMORY;
    for (int i = 0; i <= g->body_count; i++)
        g->thing[i] = i;
    for (int i = 0; i < g->joint_count; i++)
        if (holds_for_good(g, &g->joints[i]))
            forest_unite(g->thing, end_of(g, g->joints[i].a), end_of(g, g->joints[i].b));
    for (int i = 0; i <= g->body_count; i++)
        g->thing[i] = g->thing[g->thing[i]];        /* a root is lower, and done */
    return DIG_OK;
}

bool fused(Group *g, uint32_t pair, int a, int b)
{
    const World *w = g->world;
    const Pair *p = &w->pairs.data[pair];
    if (!g->thing || g->thing[a] != g->thing[b] || joint_asks_contact(w, p->body_a, p->body_b))
        return false;
    if (p->touching)
        g->over[g->over_count++] = pair;
    return true;
}
