/* geom/manifold_build.c - from contact candidates to a manifold: which four to keep, and into world axes. */
#include "geom/pair.h"

/* Ties within these are decided by order alone, so that rounding never changes which points are kept. */
#define SAME_GAP  1e-10     /* of the smaller shape */
#define SAME_AREA 1e-6      /* relative */

void contacts_add(Contacts *c, real reach, vec3 on_a, vec3 on_b, uint32_t feature)
{
    real gap = vec3_dot(vec3_sub(on_b, on_a), c->normal);
    if (c->count < CONTACT_CANDIDATES && gap <= reach)
        c->at[c->count++] = (Candidate){on_a, on_b, gap, feature};
}

static int deepest_of(const Contacts *c, real same)
{
    real least = INFINITY;
    for (int i = 0; i < c->count; i++)
        least = real_min(least, c->at[i].gap);
    for (int i = 0; i < c->count; i++)
        if (c->at[i].gap <= least + same)
            return i;
    return 0;
}

/* Twice the area of the triangle i j k across the normal. */
static real area(const Contacts *c, int i, int j, int k)
{
    vec3 p = c->at[i].on_b;
    return fabs(vec3_dot(c->normal, vec3_cross(vec3_sub(c->at[j].on_b, p), vec3_sub(c->at[k].on_b, p))));
}

/* The point strictly between `from` and `to` (cyclic) farthest from their line; -1 when there is none. */
static int widest_between(const Contacts *c, int from, int to, real *most)
{
    int best = -1;
    *most = 0;
    for (int k = (from + 1) % c->count; k != to; k = (k + 1) % c->count) {
        real x = area(c, from, to, k);
        if (best < 0 || x > *most * (1 + SAME_AREA)) {
            best = k;
            *most = x;
        }
    }
    return best;
}

/* Largest quadrilateral with a corner at `first`: its diagonal through `first` splits it into two triangles that are chosen
 * each for itself. Candidates lie in order around a convex area. */
static void choose_four(const Contacts *c, int first, int chosen[4])
{
    real most = -1;
    for (int step = 2; step + 1 < c->count; step++) {
        int across = (first + step) % c->count;
        real one, two;
        int left = widest_between(c, first, across, &one), right = widest_between(c, across, first, &two);
        if (one + two > most * (1 + SAME_AREA)) {
            most = one + two;
            chosen[0] = first;
            chosen[1] = left;
            chosen[2] = across;
            chosen[3] = right;
        }
    }
}

int contacts_finish(const Pair *p, Contacts *c, Manifold *out)
{
    int chosen[MANIFOLD_POINTS] = {0, 1, 2, 3};
    if (c->count == 0)
        return 0;
    if (c->count > MANIFOLD_POINTS)
        choose_four(c, deepest_of(c, pair_same(p, SAME_GAP)), chosen);

    out->normal = pair_direction(p, c->normal);
    out->count = int_min(c->count, MANIFOLD_POINTS);
    for (int i = 0; i < out->count; i++) {
        const Candidate *from = &c->at[chosen[i]];
        out->points[i] = (ManifoldPoint){pair_point(p, from->on_a), pair_point(p, from->on_b), from->gap, from->feature};
    }
    return 1;
}

int contacts_single(const Pair *p, const ConvexGap *g, Manifold *out)
{
    out->normal = pair_direction(p, g->normal);
    out->count = 1;
    out->points[0] = (ManifoldPoint){pair_point(p, g->on_a), pair_point(p, g->on_b), g->gap, 0};
    return 1;
}

void manifold_mirror(Manifold *m)
{
    m->normal = vec3_neg(m->normal);
    for (int i = 0; i < m->count; i++) {
        vec3 a = m->points[i].a;
        m->points[i].a = m->points[i].b;
        m->points[i].b = a;
    }
}
