/* geom/refine.c - the last digits of the gap between shapes with rims and round sides, where a polytope closes in by halves only.
 *
 * The gap is the greatest of -h(n), h(n) = n . s(n) the distance of the origin from the support plane of the difference a - b
 * across n, s(n) the support point. Near it the surface is a flat patch (a face, or two lines that cross), a patch curved one way
 * (a rim and a line), or curved both ways (two rims): each is tried, and kept where h comes out smaller. */
#include "geom/gjk.h"

#define ARC        0.3          /* rad  how far along a line the normal may still be off */
#define ARC_FIRST  1e-6         /* rad  ... and mostly is not */
#define SETTLED    1e-7         /* rad  a normal that moved less is not refined again: what is left is its square */
#define ROUNDS     4            /* the line on a cone's side turns with the normal */
#define DIFFERENCE 1e-5         /* rad  step of difference quotients */
#define FACING     1e-9         /* of the size: nearest points that miss each other by more are settled anew ... */
#define CORNER     1e-12        /* of the size: support points this near are the same corner */
#define NEXT_TO    1000         /* of what they miss: points of rims as near to them as this ... */
#define ROUND_SPOT 1e-4         /* of the size: ... and this are where they should be */
#define AS_GOOD    1e-15        /* of the size: how much worse an exact normal of a feature may seem by rounding */

static vec3 support(const ConvexPair *p, vec3 n, ConvexGap *g)
{
    g->normal = n;
    g->on_a = convex_support_a(p, n);
    g->on_b = convex_support_b(p, vec3_neg(n));
    vec3 w = vec3_sub(g->on_a, g->on_b);
    g->gap = -vec3_dot(n, w);
    return w;
}

static bool try_normal(const ConvexPair *p, vec3 n, ConvexGap *best)
{
    ConvexGap g;
    n = vec3_unit_or(n, vec3_zero());
    if (vec3_dot(n, best->normal) < 0)
        n = vec3_neg(n);
    if (!(vec3_length2(n) > 0))
        return false;
    support(p, n, &g);
    if (!(g.gap >= best->gap - AS_GOOD * p->size))
        return false;
    *best = g;
    return true;
}

/* Face of a core towards d, in the frame of a: its normal, and the edge of it that lies farthest out. */
static void feature_of(const ConvexPair *p, bool of_a, vec3 d, vec3 *normal, vec3 *edge)
{
    vec3 c[16];
    uint32_t feature;
    const Shape *s = of_a ? p->a : p->b;
    int count = s->type->face(s, of_a ? d : mat3_mul_vec(p->back, d), c, &feature);
    real most = -INFINITY;
    *normal = *edge = vec3_zero();
    for (int i = 0; i < count && !of_a; i++)
        c[i] = mat3_mul_vec(p->turn, c[i]);
    for (int i = 1; i + 1 < count; i++)
        *normal = vec3_add(*normal, vec3_cross(vec3_sub(c[i], c[0]), vec3_sub(c[i + 1], c[0])));
    for (int i = 0; i < count && count > 1; i++) {
        vec3 from = c[i], to = c[(i + 1) % count];
        if (vec3_dot(d, vec3_add(from, to)) > most) {
            most = vec3_dot(d, vec3_add(from, to));
            *edge = vec3_sub(to, from);
        }
    }
}

typedef struct Arc { const ConvexPair *p; vec3 n, t; } Arc;

/* h' at the normal turned by x along the arc: the component of its support point along the arc. */
static real slope_at(const Arc *arc, real x, ConvexGap *g)
{
    real c = cos(x), s = sin(x);
    vec3 w = support(arc->p, vec3_add(vec3_scale(c, arc->n), vec3_scale(s, arc->t)), g);
    return vec3_dot(w, vec3_sub(vec3_scale(c, arc->t), vec3_scale(s, arc->n)));
}

/* Least h among the normals across the line e. */
static void along_arc(const ConvexPair *p, vec3 e, ConvexGap *best)
{
    Arc arc = {.p = p};
    ConvexGap g;
    if (!(vec3_length2(e) > 0))
        return;
    arc.n = vec3_unit_or(vec3_mad(best->normal, -vec3_dot(best->normal, e) / vec3_length2(e), e), vec3_zero());
    arc.t = vec3_unit_or(vec3_cross(e, arc.n), vec3_zero());
    if (!(vec3_dot(arc.n, best->normal) > 1 - ARC * ARC))
        return;
    real reach = ARC_FIRST, lo, hi, flo, fhi;
    do {                                        /* the normal is nearly right as a rule */
        lo = -reach;
        hi = reach;
        flo = slope_at(&arc, lo, &g);
        fhi = slope_at(&arc, hi, &g);
        reach *= 50;
    } while (!(flo < 0 && fhi > 0) && reach < ARC);
    if (!(flo < 0 && fhi > 0))
        return;
    int side = 0;
    for (int round = 0; round < 40 && hi - lo > 1e-16; round++) {       /* Illinois: see close_in in toi.c */
        real x = round % 8 == 7 ? 0.5 * (lo + hi) : (lo * fhi - hi * flo) / (fhi - flo), f = slope_at(&arc, x, &g);
        if (fabs(f) < 1e-16 * p->size)
            break;
        if (f < 0) {
            lo = x;
            flo = f;
            fhi = side < 0 ? 0.5 * fhi : fhi;
            side = -1;
        } else {
            hi = x;
            fhi = f;
            flo = side > 0 ? 0.5 * flo : flo;
            side = 1;
        }
    }
    try_normal(p, g.normal, best);
}

/* Newton on the two components of s(n) across n, which vanish where h is least; derivatives by differences. */
static void both_ways(const ConvexPair *p, ConvexGap *best)
{
    for (int round = 0; round < 12; round++) {
        vec3 n = best->normal, s, r;
        ConvexGap g;
        vec3_basis(n, &s, &r);
        vec3 w = support(p, n, &g);
        vec3 ws = vec3_sub(support(p, vec3_unit(vec3_mad(n, DIFFERENCE, s)), &g), w);
        vec3 wr = vec3_sub(support(p, vec3_unit(vec3_mad(n, DIFFERENCE, r)), &g), w);
        /* turning n by (x, y) turns the tangents too: d(w . s) = dw . s - x (w . n) */
        real depth = vec3_dot(w, n);
        real a = vec3_dot(ws, s) / DIFFERENCE - depth, b = vec3_dot(wr, s) / DIFFERENCE;
        real c = vec3_dot(ws, r) / DIFFERENCE, d = vec3_dot(wr, r) / DIFFERENCE - depth;
        real f = vec3_dot(w, s), k = vec3_dot(w, r), det = a * d - b * c;
        if (!(a > 0 && det > 0))                /* not a least distance of a smooth patch */
            return;
        real x = (b * k - d * f) / det, y = (c * f - a * k) / det;
        if (!try_normal(p, vec3_mad(vec3_mad(n, x, s), y, r), best) || x * x + y * y < 1e-20)
            return;
    }
}

static bool has_rim(const ShapeType *t)
{
    return t->face && t != &shape_box && t != &shape_hull && t != &shape_capsule && t != &shape_sphere && t != &shape_triangle;
}

bool convex_is_round(const ConvexPair *p)
{
    const ShapeType *a = p->a->type, *b = p->b->type;
    return (has_rim(a) && b->face) || (has_rim(b) && a->face);
}

/* Is the support point `top` the nearest point itself, rather than somewhere on a flat patch or a line that `on` lies on too? It is at a
 * corner, and on a rim next to `on`. */
static bool is_spot(const Shape *s, real size, vec3 top, vec3 on, real miss)
{
    real apart = vec3_distance(top, on);
    return apart <= CORNER * size || (has_rim(s->type) && apart < real_min(NEXT_TO * miss, ROUND_SPOT * size));
}

/* Nearest points for the refined normal, from those (on_a, on_b) that were nearly right. They were right but for their distance from the
 * support planes; where they miss each other, corners and points of rims are more exact, and the other point faces them. */
static void settle_points(const ConvexPair *p, vec3 on_a, vec3 on_b, ConvexGap *g)
{
    vec3 n = g->normal, top_a = g->on_a, top_b = g->on_b;
    on_a = vec3_mad(on_a, vec3_dot(n, vec3_sub(top_a, on_a)), n);
    on_b = vec3_mad(on_b, vec3_dot(n, vec3_sub(top_b, on_b)), n);
    real miss = vec3_distance(on_b, vec3_mad(on_a, g->gap, n));
    bool misses = miss > FACING * p->size;
    bool spot_a = misses && is_spot(p->a, p->size, top_a, on_a, miss), spot_b = misses && is_spot(p->b, p->size, top_b, on_b, miss);
    if (spot_a && spot_b && vec3_distance(top_b, vec3_mad(top_a, g->gap, n)) > miss)
        spot_a = spot_b = false;                /* one of them is elsewhere on a line */
    g->on_a = spot_a ? top_a : spot_b ? vec3_mad(top_b, -g->gap, n) : on_a;
    g->on_b = spot_b ? top_b : spot_a ? vec3_mad(top_a, g->gap, n) : on_b;
}

void convex_refine(const ConvexPair *p, ConvexGap *g)
{
    vec3 face_a, face_b, edge_a, edge_b, on_a = g->on_a, on_b = g->on_b;
    support(p, g->normal, g);
    for (int round = 0; round < ROUNDS; round++) {
        vec3 before = g->normal;
        feature_of(p, true, g->normal, &face_a, &edge_a);
        feature_of(p, false, vec3_neg(g->normal), &face_b, &edge_b);
        both_ways(p, g);
        along_arc(p, edge_a, g);
        along_arc(p, edge_b, g);
        /* last, so that of equally good normals the exact ones stay */
        try_normal(p, vec3_cross(edge_a, edge_b), g);
        try_normal(p, face_b, g);
        try_normal(p, face_a, g);
        if (vec3_distance(before, g->normal) < SETTLED)
            break;
    }

    settle_points(p, on_a, on_b, g);
}
