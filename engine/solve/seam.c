/* solve/seam.c - which fixed solids lie beside each other where something moves: there a contact with one of them may be at a part of its
 * surface that the other covers (geom/manifold_hidden.c).
 *
 * What covers a place that a body touches is near the body, too, and makes a pair with it: so the pairs of each moving solid tell all of
 * its fixed neighbours. Nothing is kept from step to step, and a group with less than two fixed solids is not looked at any further. */
#include "solve/gather.h"

#include <stdlib.h>

#define FLUSH 2e-3              /* of its outer radius: what is no farther from a fixed solid is beside it, and what stands out of a fixed plane
                                 * by no more is flush with it */

/* A pair of something that moves with something fixed. */
typedef struct Meeting {
    const Solid *mover, *fixed;
    int   wall;                 /* its number in the group's `walled` */
    box3  box;                  /* m  about the fixed one; of planes, infinite */
} Meeting;

static bool is_fixed(const Group *g, int body)
{
    return body >= g->moving_count && (g->member[body].slot == NONE || g->world->bodies.data[g->member[body].slot].kind == DIG_STATIC);
}

/* Is a body, or the world itself, nothing but planes? The world's own are the walls of its room. */
static bool all_plane(const World *w, uint32_t body)
{
    const Body *b = body == NONE ? NULL : &w->bodies.data[body];
    return !b || (b->shape_count == 1 && w->solids.data[b->shape_first].form->shape.type == &shape_plane);
}

/* Are there two fixed solids at all? */
static bool two_fixed(const Group *g)
{
    int count = 0;
    for (int i = g->moving_count; i < g->body_count && count < 2; i++)
        if (is_fixed(g, i))
            count += g->member[i].slot == NONE ? 1 : int_min(2, g->world->bodies.data[g->member[i].slot].shape_count);
    return count >= 2;
}

/* Planes are not beside each other. */
static bool planes_only(const Group *g)
{
    bool planes = true;
    for (int i = g->moving_count; i < g->body_count && planes; i++)
        planes = !is_fixed(g, i) || all_plane(g->world, g->member[i].slot);
    return planes;
}

/* The body of a pair that moves, where the other is fixed; else -1. */
static int mover_of(const Group *g, const GroupPair *q)
{
    return q->a < g->moving_count ? (is_fixed(g, q->b) ? q->a : -1) : q->b < g->moving_count && is_fixed(g, q->a) ? q->b : -1;
}

static bool meeting_of(const Group *g, int wall, Meeting *m)
{
    static const box3 everywhere = {{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};
    const GroupPair *q = &g->pairs[g->walled[wall]];
    bool a = q->a >= g->moving_count;
    const Pair *p = &g->world->pairs.data[q->slot];
    const Solid *on_a = &g->world->solids.data[p->solid_a], *on_b = &g->world->solids.data[p->solid_b];
    *m = (Meeting){.mover = a ? on_b : on_a, .fixed = a ? on_a : on_b, .wall = wall};
    if (!m->fixed->form->shape.type->convex && m->fixed->form->shape.type != &shape_plane)
        return false;
    real margin = FLUSH * m->fixed->form->shape.outer;
    m->box = m->fixed->leaf < 0 ? everywhere : box3_grow(tree_box(&g->world->tree, m->fixed->leaf), margin);
    return true;
}

typedef struct Walls { const Group *g; int first, *pairs, *found; } Walls;      /* from this pair on; found: by each share */

/* A share's begin where it begins to look. */
static void wall_share(void *context, int thread, int threads)
{
    const Walls *x = context;
    int count = x->g->pair_count - x->first, from = team_first(count, thread, threads), n = 0;
    for (int i = from, end = team_end(count, thread, threads); i < end; i++)
        if (mover_of(x->g, &x->g->pairs[x->first + i]) >= 0)
            x->pairs[from + n++] = x->first + i;
    x->found[thread] = n;
}

/* Those of the pairs from `first` on that are with something fixed come after the ones that were known. */
static dig_status list_walled(Group *g, int first)
{
    int count = g->pair_count - first, known = g->walled_count;
    Team *team = count < SHARED_LEAST ? NULL : g->team;
    int shares = team_shares(team);
    Walls x = {.g = g, .first = first, .found = arena_alloc(g->lasting, (size_t)shares * sizeof *x.found)};
    int *all = arena_alloc(g->lasting, (size_t)(known + count) * sizeof *all);
    if (!x.found || !all)
        return DIG_E_MEMORY;
    x.pairs = all + known;
    team_deal(team, wall_share, &x);
    for (int i = 0; i < shares; g->walled_count += x.found[i++])
        memmove(all + g->walled_count, x.pairs + team_first(count, i, shares), (size_t)x.found[i] * sizeof *all);
    if (g->walled_count == known) {
        arena_shrink(g->lasting, all, 0);
        return DIG_OK;
    }
    arena_shrink(g->lasting, all, (size_t)g->walled_count * sizeof *all);
    if (known > 0)
        memcpy(all, g->walled, (size_t)known * sizeof *all);
    g->walled = all;
    return DIG_OK;
}

/* Of bodies that meet two fixed solids or more; -1: out of memory. */
static int list_meetings(const Group *g, Meeting **list)
{
    uint8_t *met = arena_alloc(g->lasting, (size_t)g->moving_count);
    int count = 0;
    *list = arena_alloc(g->lasting, (size_t)g->walled_count * sizeof **list);
    if (!met || !*list)
        return -1;
    memset(met, 0, (size_t)g->moving_count);
    for (int i = 0; i < g->walled_count; i++) {
        int mover = mover_of(g, &g->pairs[g->walled[i]]);
        met[mover] = (uint8_t)int_min(2, met[mover] + 1);
    }
    for (int i = 0; i < g->walled_count; i++)
        if (met[mover_of(g, &g->pairs[g->walled[i]])] > 1)
            count += meeting_of(g, i, *list + count);
    return count;
}

/* Those of one mover together, and of these from left to right; what is beside what does not depend on more. */
static int compare_meetings(const void *a, const void *b)
{
    const Meeting *x = a, *y = b;
    if (x->mover != y->mover)
        return x->mover < y->mover ? -1 : 1;
    if (x->box.low.x != y->box.low.x)
        return x->box.low.x < y->box.low.x ? -1 : 1;
    return x->wall - y->wall;
}

static bool is_plane(const Meeting *m) { return m->fixed->form->shape.type == &shape_plane; }

/* Is the whole solid in the plane's, but for so little that the two are flush? */
static bool sunk(const World *w, const Solid *plane, const Solid *s)
{
    const PlaneData *d = plane->form->shape.data;
    pose at = solid_pose(w, plane), of = solid_pose(w, s);
    vec3 n = quat_rotate(at.q, d->normal), highest = pose_point(of, s->form->shape.type->support(&s->form->shape, quat_unrotate(of.q, n)));
    return vec3_dot(n, vec3_sub(highest, at.p)) + s->form->shape.round - d->offset <= FLUSH * s->form->shape.outer;
}

static bool beside(const World *w, const Meeting *x, const Meeting *y)
{
    if (is_plane(x) || is_plane(y))
        return is_plane(x) != is_plane(y) && (is_plane(x) ? sunk(w, x->fixed, y->fixed) : sunk(w, y->fixed, x->fixed));
    return box3_overlap(x->box, y->box);
}

/* Of meetings from..end of one mover: counts, or writes, what is beside what. */
static int link_run(Group *g, const Meeting *m, int from, int end, bool write)
{
    int links = 0;
    for (int i = from; i < end; i++)
        for (int k = i + 1; k < end && m[k].box.low.x <= m[i].box.high.x; k++) {
            if (!beside(g->world, &m[i], &m[k]))
                continue;
            links += 2;
            Seams *x = &g->seams[m[i].wall], *y = &g->seams[m[k].wall];
            if (write) {
                g->beside_which[x->first + x->count] = k;
                g->beside_which[y->first + y->count] = i;
            }
            x->count++;
            y->count++;
        }
    return links;
}

static int link_all(Group *g, const Meeting *m, int count, bool write)
{
    int links = 0;
    for (int from = 0, end; from < count; from = end) {
        for (end = from + 1; end < count && m[end].mover == m[from].mover; end++);
        links += link_run(g, m, from, end, write);
    }
    return links;
}

static dig_status link_meetings(Group *g, const Meeting *m, int count)
{
    g->seams = arena_zero(g->lasting, (size_t)g->walled_count * sizeof *g->seams);
    if (!g->seams)
        return DIG_E_MEMORY;
    int links = link_all(g, m, count, false);
    g->beside_which = arena_alloc(g->lasting, (size_t)links * sizeof *g->beside_which);
    g->beside = arena_alloc(g->lasting, (size_t)count * sizeof *g->beside);
    if (!g->beside_which || !g->beside)
        return DIG_E_MEMORY;
    for (int i = 0; i < count && links > 0; i++)
        g->beside[i] = (Beside){&m[i].fixed->form->shape, solid_pose(g->world, m[i].fixed), m[i].box};
    for (int i = 0, first = 0; i < g->walled_count; i++) {
        int own = g->seams[i].count;
        g->pairs[g->walled[i]].seamed = own > 0;
        g->seams[i] = (Seams){first, 0};
        first += own;
    }
    link_all(g, m, count, true);
    return DIG_OK;
}

dig_status seams(Group *g, int first)
{
    int known = g->walled_count;
    if (!two_fixed(g) || planes_only(g))
        return DIG_OK;
    DIG_TRY(list_walled(g, first));
    if (g->walled_count == known || g->pair_count < 2)
        return DIG_OK;
    Meeting *m;
    int count = list_meetings(g, &m);
    if (count < 2)
        return count < 0 ? DIG_E_MEMORY : DIG_OK;
    qsort(m, (size_t)count, sizeof *m, compare_meetings);
    dig_status status = link_meetings(g, m, count);
    spare_add(&g->spare, m, (size_t)count * sizeof *m);
    return status;
}

static int compare_pairs(const void *a, const void *b) { return *(const int *)a - *(const int *)b; }

static Neighbours neighbours_of(const Group *g, const GroupPair *q)
{
    if (!q->seamed)
        return (Neighbours){0};
    int pair = (int)(q - g->pairs);
    const int *wall = bsearch(&pair, g->walled, (size_t)g->walled_count, sizeof *g->walled, compare_pairs);
    const Seams *s = &g->seams[wall - g->walled];
    return (Neighbours){g->beside, g->beside_which + s->first, s->count};
}

bool seam_near(const Group *g, const GroupPair *q) { return neighbours_of(g, q).count > 0; }

bool seam_uncover(const Group *g, const GroupPair *q, pose pa, pose pb, Manifold *m)
{
    Neighbours by = neighbours_of(g, q);
    if (by.count == 0)
        return false;
    if (q->a >= g->moving_count)
        return manifold_uncover(&q->on_a->shape, pa, &q->on_b->shape, pb, q->reach, &by, m);
    manifold_mirror(m);
    bool changed = manifold_uncover(&q->on_b->shape, pb, &q->on_a->shape, pa, q->reach, &by, m);
    manifold_mirror(m);
    return changed;
}

bool seam_hides(const Group *g, const GroupPair *q, pose pa, pose pb, const Manifold *m)
{
    Neighbours by = neighbours_of(g, q);
    if (by.count == 0)
        return false;
    if (q->a >= g->moving_count)
        return manifold_hidden(&q->on_a->shape, pa, &q->on_b->shape, pb, &by, m);
    Manifold mirrored = *m;
    manifold_mirror(&mirrored);
    return manifold_hidden(&q->on_b->shape, pb, &q->on_a->shape, pa, &by, &mirrored);
}
