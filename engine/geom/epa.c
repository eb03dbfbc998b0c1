/* geom/epa.c - depth of two overlapping convex cores: a polytope inside the difference a - b, grown at its face nearest to the
 * origin until that face lies on the surface (van den Bergen 2001). Distances of faces are signed, so that the same loop
 * settles shapes that only just touch; convex_gap refines what it finds for round shapes. */
#include "geom/gjk.h"

#define EPA_CORNERS 72
#define EPA_FACES   (2 * EPA_CORNERS)
#define EPA_EDGES   96
#define FLAT        1e-12       /* of the size: thinner differences have no volume */
#define ON_SURFACE  1e-13       /* of the size: a face that moves out by less is final */
#define ROUND_ENOUGH 1e-9       /* of the size: the same where convex_refine takes over */
#define COPLANAR    0.999999    /* cosine: triangles of one flat patch, whatever rounding does to slivers */

typedef struct EpaFace {
    vec3 normal;                /* unit, outward */
    real offset;                /* m  normal . x on the face */
    int  c[3];                  /* corners, counter-clockwise from outside; c[0] < 0 = unused */
} EpaFace;

typedef struct Polytope {
    const ConvexPair *pair;
    int     corner_count, face_count;
    vec3    w[EPA_CORNERS], a[EPA_CORNERS], b[EPA_CORNERS];
    EpaFace face[EPA_FACES];
    int     edge_count, edge[EPA_EDGES][2];     /* of the hole left by faces that are seen from the new corner */
} Polytope;

/* Not all of it: the arrays are large, and filled as they are used. */
static void open_polytope(Polytope *t, const ConvexPair *pair)
{
    t->pair = pair;
    t->corner_count = t->face_count = t->edge_count = 0;
}

static int add_corner(Polytope *t, vec3 d)
{
    int i = t->corner_count++;
    t->a[i] = convex_support_a(t->pair, d);
    t->b[i] = convex_support_b(t->pair, vec3_neg(d));
    t->w[i] = vec3_sub(t->a[i], t->b[i]);
    return i;
}

static bool add_face(Polytope *t, int i, int j, int k)
{
    vec3 e = vec3_sub(t->w[j], t->w[i]), f = vec3_sub(t->w[k], t->w[i]), n = vec3_cross(e, f);
    if (t->face_count == EPA_FACES || !(vec3_length2(n) > 1e-28 * vec3_length2(e) * vec3_length2(f)))
        return false;
    n = vec3_unit(n);
    real offset = (vec3_dot(n, t->w[i]) + vec3_dot(n, t->w[j]) + vec3_dot(n, t->w[k])) / 3;
    t->face[t->face_count++] = (EpaFace){n, offset, {i, j, k}};
    return true;
}

/* The support along d and against it; returns the width between them. */
static real add_width(Polytope *t, vec3 d)
{
    int i = add_corner(t, d), j = add_corner(t, vec3_neg(d));
    return vec3_distance(t->w[i], t->w[j]);
}

static void swap_corners(Polytope *t, int i, int j)
{
    vec3 w = t->w[i], a = t->a[i], b = t->b[i];
    t->w[i] = t->w[j];
    t->a[i] = t->a[j];
    t->b[i] = t->b[j];
    t->w[j] = w;
    t->a[j] = a;
    t->b[j] = b;
}

/* The longest of the widths along the axes (and the hint) becomes corners 0 and 1. */
static real widest_pair(Polytope *t, vec3 hint)
{
    const vec3 axes[4] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, hint};
    real widest = 0;
    for (int i = 0; i < 4; i++) {
        if (!(vec3_length2(axes[i]) > 0))
            continue;
        int first = t->corner_count;
        real width = add_width(t, axes[i]);
        if (width > widest) {
            widest = width;
            swap_corners(t, 0, first);
            swap_corners(t, 1, first + 1);
        }
    }
    return widest;
}

/* Corner 2: the one farthest from the line through 0 and 1, among those known and the supports across it. */
static real farthest_from_line(Polytope *t)
{
    vec3 u = vec3_unit(vec3_sub(t->w[1], t->w[0])), s, r;
    vec3_basis(u, &s, &r);
    add_width(t, s);
    add_width(t, r);
    real most = -1;
    int which = 2;
    for (int i = 2; i < t->corner_count; i++) {
        real far_off = vec3_length(vec3_cross(u, vec3_sub(t->w[i], t->w[0])));
        if (far_off > most * (1 + 1e-9)) {
            most = far_off;
            which = i;
        }
    }
    swap_corners(t, 2, which);
    return most;
}

static void fill_flat(const Polytope *t, vec3 normal, ConvexGap *out)
{
    out->normal = normal;
    out->on_a = t->a[0];
    out->on_b = t->b[0];
    out->gap = -vec3_dot(normal, t->w[0]);
}

/* Four corners that span a volume; false: the difference is flat and out holds the answer. */
static bool first_polytope(Polytope *t, vec3 hint, ConvexGap *out)
{
    real size = t->pair->size;
    real width = widest_pair(t, hint);
    if (!(width > FLAT * size)) {
        fill_flat(t, vec3_unit_or(convex_way(t->pair), (vec3){0, 1, 0}), out);
        return false;
    }
    vec3 u = vec3_unit(vec3_sub(t->w[1], t->w[0])), side, other;
    if (!(farthest_from_line(t) > FLAT * size)) {
        vec3_basis(u, &side, &other);
        fill_flat(t, side, out);
        return false;
    }
    vec3 n = vec3_unit(vec3_cross(vec3_sub(t->w[1], t->w[0]), vec3_sub(t->w[2], t->w[0])));
    t->corner_count = 3;
    add_width(t, n);
    real up = vec3_dot(n, vec3_sub(t->w[3], t->w[0])), down = -vec3_dot(n, vec3_sub(t->w[4], t->w[0]));
    if (!(real_max(up, down) > FLAT * size)) {
        fill_flat(t, vec3_dot(n, convex_way(t->pair)) < 0 ? vec3_neg(n) : n, out);
        return false;
    }
    t->corner_count = 4;
    if (up >= down) {                           /* corner 3 above the triangle 0 1 2: seen from below it runs 0 2 1 */
        return add_face(t, 0, 2, 1) && add_face(t, 0, 1, 3) && add_face(t, 1, 2, 3) && add_face(t, 2, 0, 3);
    }
    swap_corners(t, 3, 4);                      /* it was corner 4: the spare ones still hold their points */
    return add_face(t, 0, 1, 2) && add_face(t, 0, 3, 1) && add_face(t, 1, 3, 2) && add_face(t, 2, 3, 0);
}

/* Adds an edge of the hole; an edge met the other way round lies inside the hole and goes. */
static bool add_edge(Polytope *t, int i, int j)
{
    for (int k = 0; k < t->edge_count; k++)
        if (t->edge[k][0] == j && t->edge[k][1] == i) {
            t->edge_count--;
            t->edge[k][0] = t->edge[t->edge_count][0];
            t->edge[k][1] = t->edge[t->edge_count][1];
            return true;
        }
    if (t->edge_count == EPA_EDGES)
        return false;
    t->edge[t->edge_count][0] = i;
    t->edge[t->edge_count][1] = j;
    t->edge_count++;
    return true;
}

/* Replaces all faces that the corner sees by a fan about it. Faces it lies in go too: fans over them would be slivers. */
static bool expand(Polytope *t, int corner)
{
    real level = -ON_SURFACE * t->pair->size;
    int kept = 0;
    t->edge_count = 0;
    for (int f = 0; f < t->face_count; f++) {
        EpaFace *face = &t->face[f];
        if (vec3_dot(face->normal, t->w[corner]) - face->offset > level) {
            for (int k = 0; k < 3; k++)
                if (!add_edge(t, face->c[k], face->c[(k + 1) % 3]))
                    return false;
        } else {
            t->face[kept++] = *face;
        }
    }
    t->face_count = kept;
    for (int k = 0; k < t->edge_count; k++)
        if (!add_face(t, t->edge[k][0], t->edge[k][1], corner))
            return false;
    return t->edge_count >= 3;
}

static EpaFace nearest_face(const Polytope *t)
{
    int best = 0;
    for (int f = 1; f < t->face_count; f++)
        if (t->face[f].offset < t->face[best].offset)
            best = f;
    return t->face[best];
}

/* Barycentric weights of the point of a face nearest to the foot of the origin on its plane; returns the squared distance of the two. */
static real foot_weights(const Polytope *t, const EpaFace *face, real weight[3])
{
    const vec3 foot = vec3_scale(face->offset, face->normal);
    vec3 d[3];
    real sum = 0, least = INFINITY;
    bool inside = true;
    for (int k = 0; k < 3; k++)
        d[k] = vec3_sub(t->w[face->c[k]], foot);
    for (int k = 0; k < 3; k++) {
        weight[k] = vec3_dot(face->normal, vec3_cross(d[(k + 1) % 3], d[(k + 2) % 3]));
        inside = inside && weight[k] >= 0;
        sum += weight[k];
    }
    if (inside && sum > 0) {
        for (int k = 0; k < 3; k++)
            weight[k] /= sum;
        return 0;
    }
    for (int k = 0; k < 3; k++) {
        int next = (k + 1) % 3;
        vec3 e = vec3_sub(d[next], d[k]);
        real along = real_clamp(-vec3_dot(d[k], e) / vec3_length2(e), 0, 1), far = vec3_length2(vec3_mad(d[k], along, e));
        if (far < least) {
            least = far;
            weight[k] = 1 - along;
            weight[next] = along;
            weight[(k + 2) % 3] = 0;
        }
    }
    return least;
}

/* The face that is nearest to the origin may be one of several triangles of the same flat patch: the foot of the origin lies on one of
 * them, or, when the origin is outside, next to it. */
static void fill(const Polytope *t, const EpaFace *face, real same, ConvexGap *out)
{
    real weight[3], trial[3];
    const int *c = face->c;
    real least = foot_weights(t, face, weight);
    for (int f = 0; f < t->face_count && least > 0; f++) {
        const EpaFace *other = &t->face[f];
        if (!(other->offset <= face->offset + same) || !(vec3_dot(other->normal, face->normal) > COPLANAR))
            continue;
        real far = foot_weights(t, other, trial);
        if (far < least) {
            least = far;
            c = other->c;
            memcpy(weight, trial, sizeof weight);
        }
    }
    out->gap = -face->offset;
    out->normal = face->normal;
    out->on_a = out->on_b = vec3_zero();
    for (int k = 0; k < 3; k++) {
        out->on_a = vec3_mad(out->on_a, weight[k], t->a[c[k]]);
        out->on_b = vec3_mad(out->on_b, weight[k], t->b[c[k]]);
    }
}

static bool grow(Polytope *t, ConvexGap *out)
{
    real size = t->pair->size, enough = (convex_is_round(t->pair) ? ROUND_ENOUGH : ON_SURFACE) * size;
    EpaFace best = nearest_face(t);
    bool exact = false;
    while (t->corner_count < EPA_CORNERS) {
        EpaFace next = nearest_face(t);
        if (best.offset > 0 && next.offset < best.offset - 1e-9 * size)     /* from inside it only ever grows: rounding broke it */
            break;
        best = next;
        int i = add_corner(t, best.normal);
        real out_by = vec3_dot(best.normal, t->w[i]) - best.offset;
        exact = out_by <= ON_SURFACE * size;
        if (out_by <= enough || !expand(t, i))
            break;
    }
    fill(t, &best, enough, out);
    return exact;
}

bool epa_depth(const ConvexPair *p, vec3 hint, ConvexGap *out)
{
    Polytope t;
    open_polytope(&t, p);
    *out = (ConvexGap){.normal = {0, 1, 0}};
    return !first_polytope(&t, hint, out) || grow(&t, out);
}

/* A pyramid over the patch. */
bool epa_from_patch(const ConvexPair *p, const Patch *patch, ConvexGap *out)
{
    Polytope t;
    ConvexGap found;
    int n = patch->count;
    open_polytope(&t, p);
    for (int i = 0; i < n; i++) {
        t.corner_count++;
        t.w[i] = patch->w[i];
        t.a[i] = patch->a[i];
        t.b[i] = patch->b[i];
    }
    int apex = add_corner(&t, vec3_neg(patch->normal));
    if (!(patch->offset - vec3_dot(patch->normal, t.w[apex]) > FLAT * p->size))
        return false;
    for (int i = 1; i + 1 < n; i++) {
        if (!add_face(&t, 0, i, i + 1))
            return false;
        t.face[t.face_count - 1].normal = patch->normal;       /* the face's own: more exact than from the corners */
        t.face[t.face_count - 1].offset = patch->offset;
    }
    for (int i = 0; i < n; i++)
        if (!add_face(&t, (i + 1) % n, i, apex))
            return false;
    if (!grow(&t, &found))
        return false;
    if (!(vec3_dot(found.normal, patch->normal) > 0.5) || found.gap > -patch->offset + ON_SURFACE * p->size)
        *out = found;                           /* nearer another way; else out holds the foot on the patch already */
    return true;
}
