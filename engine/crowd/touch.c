/* crowd/touch.c - contacts of the present poses, once a step.
 *
 * A manifold of three or four points whose two sides have hardly moved against each other is not made anew: its points, carried along
 * with their bodies at the end of the last step, still face each other. That they belong to the present poses is told by a sign
 * of the poses, kept where the pair has its hint.
 */
#include "crowd/system.h"

#define CARRIED 0x63617272u     /* kind of a hint that holds a sign; no shape pair has this one   */
#define SLID    2e-3            /* of the size: points that have slid farther are found anew      */
#define TILTED  4e-3            /* of the size: so are manifolds whose gaps differ by more        */
#define STAYS   2e-3            /* of the size: so far may bodies of fewer points go till then    */
#define FARTHER 0.05            /* of the size: so much farther is looked for what is near        */
#define LOOKS   0.01            /* of the size: what contacts look ahead for in any case          */

/* Three numbers that are the same as long as neither body moves. */
static vec3 sign_of(const Group *g, const GroupPair *q)
{
    const Pos *a = &g->pos[q->a], *b = &g->pos[q->b];
    vec3 turns = {0.5 * a->q.x + 0.25 * b->q.x, 0.5 * a->q.y + 0.25 * b->q.y, 0.5 * a->q.z + 0.25 * b->q.z};
    return vec3_add(turns, vec3_mad(b->x, 0.75, a->x));
}

void crowd_sign(const Group *g, GroupPair *q)
{
    vec3 s = sign_of(g, q);
    q->cache = (ManifoldCache){.kind = CARRIED, .axis = {s.x, s.y, s.z}};
}

static bool keeps(const Group *g, GroupPair *q)
{
    if (q->fresh || q->cache.kind != CARRIED)
        return false;
    GroupContact *c = &g->contacts[q->contact];
    vec3 s = sign_of(g, q), n = c->manifold.normal;
    if (c->manifold.count < 3 || s.x != q->cache.axis[0] || s.y != q->cache.axis[1] || s.z != q->cache.axis[2])
        return false;
    real low = INFINITY, high = -INFINITY, slid = 0;
    for (int k = 0; k < c->manifold.count; k++) {
        ManifoldPoint *p = &c->manifold.points[k];
        vec3 d = vec3_sub(p->b, p->a);
        p->gap = vec3_dot(d, n);
        low = real_min(low, p->gap);
        high = real_max(high, p->gap);
        slid = real_max(slid, vec3_length2(vec3_mad(d, -p->gap, n)));
    }
    return slid < SLID * SLID * q->size * q->size && high - low < TILTED * q->size && high < SLID * q->size;
}

/* Of one or two points, or none: as long as its bodies have moved so little since they were found that the normal is still right. */
static bool stays(const Group *g, const GroupPair *q)
{
    GroupContact *c = &g->contacts[q->contact];
    real travel = g->member[q->a].travel + g->member[q->b].travel;
    if (q->fresh || c->manifold.count == 0 || travel > q->until)
        return false;
    for (int k = 0; k < c->manifold.count; k++) {
        ManifoldPoint *p = &c->manifold.points[k];
        p->gap = vec3_dot(vec3_sub(p->b, p->a), c->manifold.normal);
    }
    return true;
}

/* Finds the contact, and for how long that will do. */
static void find(Group *g, GroupPair *q, real time)
{
    GroupContact *c = &g->contacts[q->contact];
    real travel = g->member[q->a].travel + g->member[q->b].travel, room = group_touch_convex(g, q, time, FARTHER * q->size);
    if (!c->live)
        q->until = travel + room - LOOKS * q->size;
    else if (c->manifold.count < 3 && !(q->sa->round > 0 && q->sb->round > 0 && c->room == 1))
        q->until = travel + STAYS * q->size;
}

typedef struct Touching { Group *g; real time; } Touching;

static void touch_pair(Group *g, GroupPair *q, real time)
{
    if (q->contacts != 1)
        group_touch_pair(g, q, time);
    else if (!keeps(g, q) && !stays(g, q))
        find(g, q, time);
}

static void touch_share(void *context, int thread, int threads)
{
    const Touching *t = context;
    for (int i = team_first(t->g->pair_count, thread, threads), end = team_end(t->g->pair_count, thread, threads); i < end; i++)
        touch_pair(t->g, &t->g->pairs[i], t->time);
}

void crowd_touch(Group *g, real time)
{
    Touching t = {g, time};
    team_run(g->team, touch_share, &t);
}
