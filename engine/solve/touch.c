/* solve/touch.c - contacts of the present positions: manifolds, and what their points remember. */
#include "base/clock.h"
#include "solve/group.h"

#define PIECES 16
#define LONG_TOUCH 64           /* pairs: fewer are done before anything interrupts, and the wall clock will do */

/* What is kept of a contact when its points are found anew. */
typedef struct Before {
    int         count;
    bool        live;
    uint32_t    piece;
    vec3        rolling;
    uint32_t    feature[MANIFOLD_POINTS];
    PointMemory memory[MANIFOLD_POINTS];
} Before;

static void note_before(const GroupContact *c, Before *old)
{
    old->count = c->manifold.count;
    old->live = c->live;
    old->piece = c->piece;
    for (int k = 0; k < old->count; k++) {
        old->feature[k] = c->manifold.points[k].feature;
        old->memory[k] = contact_memory(c)[k];
    }
}

/* Keeps the forces of points that are still the same features. */
static void keep_memory(GroupContact *c, const Before *old)
{
    for (int i = 0; i < c->manifold.count; i++) {
        contact_memory(c)[i] = (PointMemory){.held = 0};
        if (c->manifold.count == 1 && old->count == 1) {       /* a ball rolls over an edge: another feature, the same contact */
            contact_memory(c)[0] = old->memory[0];
            return;
        }
        for (int k = 0; k < old->count; k++)
            if (old->feature[k] == c->manifold.points[i].feature) {
                contact_memory(c)[i] = old->memory[k];
                break;
            }
    }
}

static void put_points(Group *g, GroupContact *c, const Manifold *found)
{
    c->manifold.normal = found->normal;
    c->manifold.count = found->count > 0 && group_has_room(g, c) ? int_min(found->count, c->manifold.room) : 0;
    c->live = c->manifold.count > 0;
    for (int k = 0; k < c->manifold.count; k++)
        c->manifold.points[k] = found->points[k];
}

/* A plane has no rim: it does not spin either. */
static real rim_speed(const Vel *v, const Member *m)
{
    real spin = vec3_length(v->w);
    return spin > 0 && isfinite(m->outer) ? spin * m->outer : 0;
}

/* The farthest the two solids can close on each other in `time`: what contacts must look ahead for. */
static real pair_reach(const Group *g, const GroupPair *q, real time)
{
    const Vel *a = &g->vel[q->a], *b = &g->vel[q->b];
    real closing = vec3_length(vec3_sub(b->v, a->v)) + rim_speed(a, &g->member[q->a]) + rim_speed(b, &g->member[q->b]);
    const Member *x = &g->member[q->a], *y = &g->member[q->b];
    return closing * time + real_max(x->pull, y->pull) * time * time + group_thrown(g, q->a, time) + group_thrown(g, q->b, time) + 0.01 * q->size;
}

/* A mesh pair has one contact per touching piece; each keeps the memory of its piece. */
static void touch_pieces(Group *g, GroupPair *q, const Manifold *found, const uint32_t *pieces, int count)
{
    static const Before none = {.count = 0};
    Before old[PIECES];
    int contacts = int_min(q->contacts, PIECES);
    for (int i = 0; i < contacts; i++) {
        note_before(&g->contacts[q->contact + i], &old[i]);
        old[i].rolling = contact_rolling(g, &g->contacts[q->contact + i]);
    }
    for (int i = 0; i < contacts; i++) {
        GroupContact *c = &g->contacts[q->contact + i];
        c->live = false;
        c->manifold.count = 0;
        if (i >= count)
            continue;
        c->piece = pieces[i];
        put_points(g, c, &found[i]);
        vec3 rolling = vec3_zero();
        keep_memory(c, &none);
        for (int k = 0; k < contacts; k++)
            if (old[k].live && old[k].piece == pieces[i]) {
                keep_memory(c, &old[k]);
                rolling = old[k].rolling;
                break;
            }
        if (g->contact_rest)
            contact_rest_of(g, c)->rolling = rolling;
    }
}

/* Finds the points anew. False: what was found is hidden, and there may be something nearer than the pair's reach without a point. */
static bool touch_again(Group *g, GroupPair *q, GroupContact *c, pose pa, pose pb, bool apart)
{
    Manifold found;
    Before old;
    bool hidden = false;
    note_before(c, &old);
    found.normal = c->manifold.normal;
    found.count = 0;
    if (!apart) {
        manifold_of_parts(&q->on_a->shape, pa, &q->on_b->shape, pb, q->reach, q->covered, q->hint, &found);
        hidden = seam_uncover(g, q, pa, pb, &found);
    }
    put_points(g, c, &found);
    keep_memory(c, &old);
    return !hidden;
}

/* m  What is between two solids that are farther than `reach` from each other, at least; else, or if it is more than `most`, that. */
static real room_between(GroupPair *q, pose pa, pose pb, real most)
{
    Manifold found = {.count = 0};
    manifold_of_parts(&q->on_a->shape, pa, &q->on_b->shape, pb, most, q->covered, q->hint, &found);
    for (int k = 0; k < found.count; k++)
        most = real_min(most, found.points[k].gap);
    return most;
}

static bool is_ball(const Shape *s) { return s->outer == s->round && s->type->convex; }

static vec3 centre_of(const Group *g, int body, vec3 local)
{
    return vec3_is_zero(local) ? g->pos[body].x : vec3_add(g->pos[body].x, quat_rotate(g->pos[body].q, local));
}

/* Two balls, which most of a large crowd are: as manifold_collide finds it. */
static real touch_balls(Group *g, GroupPair *q, GroupContact *c, real reach)
{
    vec3 a = centre_of(g, q->a, q->on_a->arm), b = centre_of(g, q->b, q->on_b->arm), d = vec3_sub(b, a);
    real length = vec3_length(d), gap = length - q->on_a->shape.round - q->on_b->shape.round;
    c->live = gap <= reach && group_has_room(g, c);
    if (!c->live) {
        c->manifold.count = 0;
        return gap;
    }
    if (c->manifold.count != 1)
        *contact_memory(c) = (PointMemory){.held = 0};
    vec3 n = length > 0 ? vec3_scale(1 / length, d) : vec3_unit(d);
    c->manifold.normal = n;
    c->manifold.count = 1;
    c->manifold.points[0] = (ManifoldPoint){vec3_mad(a, q->on_a->shape.round, n), vec3_mad(b, -q->on_b->shape.round, n), gap, 0};
    return 0;
}

/* A ball and a plane: as manifold_collide finds it, without the ball's turn, of which nothing is seen. */
static real touch_plane(Group *g, GroupPair *q, GroupContact *c, real reach)
{
    bool on_a = q->on_a->shape.type == &shape_plane;
    const Form *ball = on_a ? q->on_b : q->on_a;
    const PlaneData *plane = (on_a ? q->on_a : q->on_b)->shape.data;
    pose at = group_shape_pose(g, on_a ? q->a : q->b, pair_local(q, !on_a));
    vec3 n = quat_rotate(at.q, plane->normal), low = vec3_mad(centre_of(g, on_a ? q->b : q->a, ball->arm), -ball->shape.round, n);
    real gap = vec3_dot(n, vec3_sub(low, at.p)) - plane->offset;
    c->live = gap <= reach && group_has_room(g, c);
    if (!c->live) {
        c->manifold.count = 0;
        return gap;
    }
    if (c->manifold.count != 1)
        *contact_memory(c) = (PointMemory){.held = 0};
    vec3 foot = vec3_mad(low, -gap, n);
    c->manifold.normal = on_a ? n : vec3_neg(n);
    c->manifold.count = 1;
    c->manifold.points[0] = on_a ? (ManifoldPoint){foot, low, gap, 0} : (ManifoldPoint){low, foot, gap, 0};
    return 0;
}

static bool is_ball_on_plane(const Group *g, const GroupPair *q)
{
    const Shape *a = &q->on_a->shape, *b = &q->on_b->shape;
    return ((a->type == &shape_plane && is_ball(b)) || (b->type == &shape_plane && is_ball(a))) && !seam_near(g, q);
}

static real touch_convex(Group *g, GroupPair *q, real reach, real farther)
{
    q->fresh = q->hidden = false;
    q->until = -1;
    q->reach = reach;
    if (is_ball(&q->on_a->shape) && is_ball(&q->on_b->shape))
        return touch_balls(g, q, &g->contacts[q->contact], reach);
    if (is_ball_on_plane(g, q))
        return touch_plane(g, q, &g->contacts[q->contact], reach);
    pose pa = group_shape_pose(g, q->a, pair_local(q, false)), pb = group_shape_pose(g, q->b, pair_local(q, true));
    GroupContact *c = &g->contacts[q->contact];
    real room = vec3_length(vec3_sub(pb.p, pa.p)) - q->on_a->shape.outer - q->on_b->shape.outer;     /* infinite outer: never apart */
    bool apart = room > reach;
    if (c->manifold.count == 0 && !apart && farther > 0) {
        room = room_between(q, pa, pb, reach + farther);
        apart = room > reach;
    }
    if (c->manifold.count == 0 && apart) {
        c->live = false;
        return room;
    }
    q->hidden = !touch_again(g, q, c, pa, pb, apart);
    return c->live || q->hidden ? 0 : real_max(room, reach);
}

real group_touch_convex(Group *g, GroupPair *q, real time, real farther) { return touch_convex(g, q, pair_reach(g, q, time), farther); }

void group_touch_pair(Group *g, GroupPair *q, real time) { group_touch_within(g, q, pair_reach(g, q, time)); }

real group_touch_within(Group *g, GroupPair *q, real reach)
{
    if (q->contacts == 1)
        return touch_convex(g, q, reach, 0);
    pose pa = group_shape_pose(g, q->a, pair_local(q, false)), pb = group_shape_pose(g, q->b, pair_local(q, true));
    q->reach = reach;
    q->fresh = q->hidden = false;
    q->until = -1;
    Manifold found[PIECES];
    uint32_t pieces[PIECES];
    int count = manifold_collide(&q->on_a->shape, pa, &q->on_b->shape, pb, reach, q->hint, found, pieces, int_min(q->contacts, PIECES));
    touch_pieces(g, q, found, pieces, count);
    return 0;
}

static bool pair_moves(const Group *g, const GroupPair *q)
{
    return g->member[q->a].moves || g->member[q->b].moves || g->member[q->a].kinematic || g->member[q->b].kinematic;
}

bool group_outruns(const Group *g, real time)
{
    for (int i = 0; i < g->pair_count; i++)
        if (pair_moves(g, &g->pairs[i]) && pair_reach(g, &g->pairs[i], time) > g->pairs[i].reach)
            return true;
    return false;
}

#define FARTHER 0.02            /* of the smaller size: by so much more two solids may close on each other than was looked for */
#define MISSED  1e-3            /* the same: deeper than this they would overlap */

/* Would a point that got no row go this deep by the velocities that the solve has found? */
static bool goes_deep(const Group *g, const GroupPair *q, const GroupContact *c, real deep)
{
    const Vel *a = &g->vel[q->a], *b = &g->vel[q->b];
    for (int k = 0; c->live && k < c->manifold.count; k++) {
        const ManifoldPoint *p = &c->manifold.points[k];
        vec3 va = vec3_add(a->v, vec3_cross(a->w, vec3_sub(p->a, g->pos[q->a].x)));
        vec3 vb = vec3_add(b->v, vec3_cross(b->w, vec3_sub(p->b, g->pos[q->b].x)));
        real rate = vec3_dot(c->manifold.normal, vec3_sub(vb, va));
        if (rate < 0 && p->gap + g->h * rate < real_min(p->gap, 0) - deep)
            return true;
    }
    return false;
}

static bool overlaps(const Group *g, const GroupPair *q)
{
    for (int i = q->contact; i < q->contact + q->contacts; i++)
        for (int k = 0; g->contacts[i].live && k < g->contacts[i].manifold.count; k++)
            if (g->contacts[i].manifold.points[k].gap < -MISSED * q->size)
                return true;
    return false;
}

real group_thin(const GroupPair *q)
{
    return real_max(MISSED * q->size, real_min(q->on_a->shape.inner, q->on_b->shape.inner));
}

bool group_touch_missed(Group *g, real time, bool through)
{
    const bool all = !g->joints_direct;         /* meshes, too */
    bool any = false;
    for (int i = 0; i < g->pair_count; i++) {
        GroupPair *q = &g->pairs[i];
        if (q->meets || (q->contacts != 1 && !all) || (!g->member[q->a].moves && !g->member[q->b].moves))
            continue;
        if (all && g->unsolved && overlaps(g, q))     /* of what contradicts itself no velocity says who gets where */
            continue;
        if (pair_reach(g, q, time) > q->reach + FARTHER * q->size)
            group_touch_pair(g, q, time);
        for (int k = 0; k < q->contacts && !q->meets; k++)
            q->meets = goes_deep(g, q, &g->contacts[q->contact + k], through ? group_thin(q) : MISSED * q->size);
        any = any || q->meets;
    }
    return any;
}

void group_touch(Group *g, real time, bool all)
{
    real (*clock)(void) = g->pair_count > LONG_TOUCH ? cpu_us : wall_us;
    real start = g->timed ? clock() : 0;
    for (int i = 0; i < g->pair_count; i++)
        if (g->pairs[i].fresh || (all && pair_moves(g, &g->pairs[i])))
            group_touch_pair(g, &g->pairs[i], time);
    if (g->timed)
        g->touch_us += clock() - start;
}
