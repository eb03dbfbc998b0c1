/* geom/gjk.c - distance of two convex cores (Gilbert, Johnson & Keerthi 1988): the point of the difference a - b nearest to the origin. */
#include "geom/gjk.h"

#define GJK_ROUNDS 160
#define TOUCHING   1e-9     /* of the size: below it the difference of the nearest points has too few digits for a direction */
#define FLAT       1e-13    /* of the size: height of a tetrahedron without a volume */
#define NOTHING    1e-15    /* of the size: below it a distance is rounding */

typedef struct Simplex {
    int  count;
    vec3 w[4], a[4], b[4];      /* w = a - b */
    real weight[4];
    real reach2;                /* largest |w|^2 so far */
} Simplex;

/* The best point of a simplex found so far: its corners, weights and squared distance. */
typedef struct Nearest {
    int  count, corner[4];
    real weight[4];
    vec3 v;
    real v2;
} Nearest;

static void keep_nearer(Nearest *best, int count, const int *corner, const real *weight, vec3 v)
{
    real v2 = vec3_length2(v);
    if (!(v2 < best->v2))
        return;
    best->count = count;
    for (int i = 0; i < count; i++) {
        best->corner[i] = corner[i];
        best->weight[i] = weight[i];
    }
    best->v = v;
    best->v2 = v2;
}

static void try_corner(const Simplex *s, int i, Nearest *best)
{
    real one = 1;
    keep_nearer(best, 1, &i, &one, s->w[i]);
}

static void try_edge(const Simplex *s, int i, int j, Nearest *best)
{
    vec3 e = vec3_sub(s->w[j], s->w[i]);
    real e2 = vec3_length2(e), t = e2 > 0 ? -vec3_dot(s->w[i], e) / e2 : 0;
    if (!(t > 0)) {
        try_corner(s, i, best);
    } else if (!(t < 1)) {
        try_corner(s, j, best);
    } else {
        int  corner[2] = {i, j};
        real weight[2] = {1 - t, t};
        /* from the nearer end, for the digits */
        vec3 v = t < 0.5 ? vec3_mad(s->w[i], t, e) : vec3_mad(s->w[j], t - 1, e);
        keep_nearer(best, 2, corner, weight, v);
    }
}

static void try_edges(const Simplex *s, int i, int j, int k, Nearest *best)
{
    try_edge(s, i, j, best);
    try_edge(s, j, k, best);
    try_edge(s, k, i, best);
}

/* Barycentric weights by areas about the foot of the origin; the edges when the foot is outside. */
static void try_triangle(const Simplex *s, int i, int j, int k, Nearest *best)
{
    vec3 p = s->w[i], q = s->w[j], r = s->w[k];
    vec3 n = vec3_cross(vec3_sub(q, p), vec3_sub(r, p));
    real n2 = vec3_length2(n), scale = vec3_length2(vec3_sub(q, p)) * vec3_length2(vec3_sub(r, p));

    if (!(n2 > 1e-26 * scale)) {                /* no area to speak of */
        try_edges(s, i, j, k, best);
        return;
    }
    real u = vec3_dot(n, vec3_cross(q, r)), v = vec3_dot(n, vec3_cross(r, p)), w = vec3_dot(n, vec3_cross(p, q));
    if (u > 0 && v > 0 && w > 0) {
        real sum = u + v + w;
        int  corner[3] = {i, j, k};
        real weight[3] = {u / sum, v / sum, w / sum};
        /* along the normal: the weighted sum of far corners would lose digits */
        real along = (vec3_dot(n, p) + vec3_dot(n, q) + vec3_dot(n, r)) / (3 * n2);
        keep_nearer(best, 3, corner, weight, vec3_scale(along, n));
        return;
    }
    try_edges(s, i, j, k, best);
}

/* True when the origin lies inside the tetrahedron. */
static bool try_tetrahedron(const Simplex *s, Nearest *best)
{
    static const int face[4][4] = {{0, 1, 2, 3}, {0, 3, 1, 2}, {0, 2, 3, 1}, {1, 3, 2, 0}};     /* fourth: the opposite corner */
    bool inside = true;
    for (int f = 0; f < 4; f++) {
        const int *c = face[f];
        vec3 p = s->w[c[0]], n = vec3_cross(vec3_sub(s->w[c[1]], p), vec3_sub(s->w[c[2]], p));
        real opposite = vec3_dot(n, vec3_sub(s->w[c[3]], p)), origin = -vec3_dot(n, p);
        bool flat = opposite * opposite <= FLAT * FLAT * vec3_length2(n) * s->reach2;       /* its sign is rounding */
        if (!flat && opposite * origin > 0)
            continue;
        inside = false;
        try_triangle(s, c[0], c[1], c[2], best);
    }
    return inside;
}

/* Reduces the simplex to the corners that carry the nearest point; false when the origin is inside. */
static bool reduce(Simplex *s, vec3 *v)
{
    Nearest best = {.v2 = INFINITY};
    if (s->count == 1)
        try_corner(s, 0, &best);
    else if (s->count == 2)
        try_edge(s, 0, 1, &best);
    else if (s->count == 3)
        try_triangle(s, 0, 1, 2, &best);
    else if (try_tetrahedron(s, &best))
        return false;

    Simplex old = *s;
    s->count = best.count;
    for (int i = 0; i < best.count; i++) {
        s->w[i] = old.w[best.corner[i]];
        s->a[i] = old.a[best.corner[i]];
        s->b[i] = old.b[best.corner[i]];
        s->weight[i] = best.weight[i];
    }
    *v = best.v;
    return true;
}

static bool has_corner(const Simplex *s, vec3 w)
{
    for (int i = 0; i < s->count; i++)
        if (vec3_equal(s->w[i], w))
            return true;
    return false;
}

static void add_corner(Simplex *s, vec3 a, vec3 b)
{
    int i = s->count++;
    s->a[i] = a;
    s->b[i] = b;
    s->w[i] = vec3_sub(a, b);
    s->weight[i] = 1;
    s->reach2 = real_max(s->reach2, vec3_length2(s->w[i]));
}

static void fill(const Simplex *s, vec3 v, ConvexGap *out)
{
    real length = vec3_length(v);
    out->gap = length;
    out->normal = vec3_scale(-1 / length, v);
    out->on_a = out->on_b = vec3_zero();
    for (int i = 0; i < s->count; i++) {
        out->on_a = vec3_mad(out->on_a, s->weight[i], s->a[i]);
        out->on_b = vec3_mad(out->on_b, s->weight[i], s->b[i]);
    }
    if (s->count != 3)
        return;
    /* the normal of a triangle keeps its digits however near the origin is, if only the triangle is larger than the distance */
    vec3 e = vec3_sub(s->w[1], s->w[0]), f = vec3_sub(s->w[2], s->w[0]), n = vec3_cross(e, f);
    real longest2 = real_max(vec3_length2(vec3_sub(e, f)), real_max(vec3_length2(e), vec3_length2(f)));
    if (vec3_length2(n) > longest2 * length * length)
        out->normal = vec3_unit(vec3_dot(n, v) > 0 ? vec3_neg(n) : n);
}

bool gjk_distance(const ConvexPair *p, real enough, vec3 start, ConvexGap *out)
{
    Simplex s = {.count = 0};
    vec3 v = vec3_length2(start) > 0 ? vec3_neg(start) : vec3_neg(convex_way(p));
    if (!(vec3_length2(v) > 0))
        v = (vec3){1, 0, 0};
    add_corner(&s, convex_support_a(p, vec3_neg(v)), convex_support_b(p, v));
    v = s.w[0];
    real v2 = vec3_length2(v), size2 = p->size * p->size, proven = 0;

    for (int round = 0; round < GJK_ROUNDS && v2 > NOTHING * NOTHING * size2; round++) {
        vec3 a = convex_support_a(p, vec3_neg(v)), b = convex_support_b(p, v), w = vec3_sub(a, b);
        real below = vec3_dot(v, w), length = sqrt(v2);         /* below / |v| bounds the distance from below */
        if (below > enough * length) {
            fill(&s, v, out);
            out->gap = below / length;
            return true;
        }
        proven = real_max(proven, below / length);
        if (v2 - below <= 1e-15 * v2 || has_corner(&s, w))
            break;
        Simplex before = s;
        vec3 next = v;
        add_corner(&s, a, b);
        bool apart = reduce(&s, &next);
        if (!apart && proven < TOUCHING * p->size) {
            out->gap = 0;
            return false;
        }
        real next2 = vec3_length2(next);
        if (!apart || !(next2 < v2)) {          /* rounding has the last word: small corners far off may seem to enclose the origin */
            s = before;
            break;
        }
        v = next;
        v2 = next2;
    }
    if (v2 <= TOUCHING * TOUCHING * size2) {
        out->gap = proven;
        return false;
    }
    fill(&s, v, out);
    return true;
}

static void search_gap(const ConvexPair *p, real enough, vec3 guess, ConvexGap *out)
{
    bool apart = gjk_distance(p, enough, guess, out), exact = false;
    real distance = out->gap;
    if (apart && distance > enough)
        return;
    if (!apart)
        exact = epa_depth(p, guess, out);
    if (!exact && convex_is_round(p))
        convex_refine(p, out);
    /* beside an edge, planes of faces are nearer than the edge itself */
    if (!apart && out->gap > 0)
        out->gap = real_max(out->gap, distance);
}

void convex_gap(const ConvexPair *p, real enough, vec3 *axis, ConvexGap *out)
{
    vec3 guess = axis && vec3_finite(*axis) ? *axis : vec3_zero();
    if (!patch_gap(p, guess, enough, out))
        search_gap(p, enough, guess, out);
    if (axis)
        *axis = out->normal;
}
