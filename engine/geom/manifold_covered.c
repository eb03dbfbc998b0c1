/* geom/manifold_covered.c - contacts of the parts of one thing, as if it were one body.
 *
 * A plank that bends is a row of boxes. Where two planks lie on each other end to end, a piece of one and the next but one of the
 * other are apart along the planks by what is between their end faces, nothing, and overlap across them by a little more: the axis
 * of least overlap lies along the planks, through faces that are no surface at all, for the next piece goes on there. This is the
 * ghost edge of meshes (manifold_surface.c) for boxes. A normal that leaves a part through such a face is none; the best of the
 * remaining faces' normals stands in for it, and only for what lies over that face: what is beside it is the neighbour's.
 *
 * So is what touches the edge between two covered faces: the neighbours there make an inner corner, and it lies in that. All that would
 * stand in is the normal along the edge, on which the two overlap by all their length. */
#include "geom/pair.h"

#define STEEP   0.5             /* cosine: a normal this near to a covered face's leaves through it */
#define DEEPER  0.5             /* of the smaller shape's inner radius: a way out that is so much longer than the one through the face is none */
#define A_BIAS  1e-7            /* of the smaller shape: of two faces that separate equally well the normal is a's */

typedef struct Faces { vec3 axis[3]; uint32_t covered; real sign; } Faces;      /* of one box, in the frame of a; sign: outwards along n */

/* Both boxes, or those of them that are. */
static int faces_of(const Pair *p, Covered covered, Faces out[2])
{
    int n = 0;
    if (p->kind_a == KIND_BOX)
        out[n++] = (Faces){{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, covered.a, 1};
    if (p->kind_b == KIND_BOX)
        out[n++] = (Faces){{p->c.back.r0, p->c.back.r1, p->c.back.r2}, covered.b, -1};
    return n;
}

/* n: from a to b, in the frame of a */
static bool leaves(const Faces *f, int count, vec3 n)
{
    for (int i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            real along = f[i].sign * vec3_dot(n, f[i].axis[k]);
            if (fabs(along) > STEEP && (f[i].covered & covered_face(k, along)))
                return true;
        }
    return false;
}

static real gap_along(const Pair *p, vec3 n)
{
    vec3 a = convex_support_a(&p->c, n), b = convex_support_b(&p->c, vec3_neg(n));
    return vec3_dot(n, vec3_sub(b, a)) - p->a->round - p->b->round;
}

/* The face normal that separates best of those that lead out. False: there is none. */
static bool best_normal(const Pair *p, const Faces *f, int count, vec3 *normal, real *gap)
{
    *gap = -INFINITY;
    for (int i = 0; i < count; i++)
        for (int k = 0; k < 6; k++) {
            vec3 n = vec3_scale(k < 3 ? f[i].sign : -f[i].sign, f[i].axis[k % 3]);
            real g = gap_along(p, n);
            if (g > *gap + pair_same(p, A_BIAS) && !leaves(f, count, n)) {
                *gap = g;
                *normal = n;
            }
        }
    return *gap > -INFINITY;
}

bool manifold_covered(const Shape *a, pose pa, const Shape *b, pose pb, Covered covered, vec3 normal)
{
    if (!(covered.a | covered.b))
        return false;
    Pair p = pair_make(a, pa, b, pb);
    Faces f[2];
    int count = faces_of(&p, covered, f);
    return leaves(f, count, mat3_mul_vec(mat3_transpose(p.axes), normal));
}

static real deepest(const Manifold *m)
{
    real gap = m->points[0].gap;
    for (int k = 1; k < m->count; k++)
        gap = real_min(gap, m->points[k].gap);
    return gap;
}

int manifold_of_parts(const Shape *a, pose pa, const Shape *b, pose pb, real reach, Covered covered, ManifoldCache *cache, Manifold *out)
{
    int found = manifold_collide(a, pa, b, pb, reach, cache, out, NULL, 1);
    if (found == 0 || !(covered.a | covered.b) || !a->type->convex || !b->type->convex || !manifold_covered(a, pa, b, pb, covered, out->normal))
        return found;
    Pair p = pair_make(a, pa, b, pb);
    p.reach = reach;
    Faces f[2];
    ConvexGap g = {.gap = INFINITY};
    real gap;
    if (!best_normal(&p, f, faces_of(&p, covered, f), &g.normal, &gap))
        return found;                           /* nothing leads out of what is covered all round */
    bool deep = deepest(out) - gap > DEEPER * real_min(a->inner, b->inner);     /* all of it lies in the corner of two neighbours, which it meets */
    out->count = 0;
    return gap <= reach && !deep ? collide_faces(&p, &g, out) : 0;
}
