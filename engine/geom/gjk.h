/* geom/gjk.h - the gap between the cores of two convex shapes, by their support functions alone.
 *
 * Apart: distance by Gilbert, Johnson & Keerthi (1988). Touching or overlapping: depth by expanding a polytope
 * (van den Bergen 2001), which also gives the normal where the distance is too small to have a direction.
 *
 * Floor: geom.
 */
#ifndef DIG_GJK_H
#define DIG_GJK_H

#include "geom/shape.h"

/* Two convex shapes in the frame of the first: x_a = turn x_b + shift. */
typedef struct ConvexPair {
    const Shape *a, *b;
    mat3 turn, back;        /* back = transpose of turn */
    vec3 shift;
    real size;              /* m  coordinates stay below this: rounding errors are about 1e-16 of it */
} ConvexPair;

typedef struct ConvexGap {
    real gap;               /* m  of the cores; < 0: depth                                   */
    vec3 normal;            /* unit, from a to b, in the frame of a                          */
    vec3 on_a, on_b;        /* m  nearest points of the cores, in the frame of a             */
} ConvexGap;

static inline vec3 convex_point_b(const ConvexPair *p, vec3 local) { return vec3_add(mat3_mul_vec(p->turn, local), p->shift); }
static inline vec3 convex_support_a(const ConvexPair *p, vec3 d) { return p->a->type->support(p->a, d); }
static inline vec3 convex_support_b(const ConvexPair *p, vec3 d)
{
    return convex_point_b(p, p->b->type->support(p->b, mat3_mul_vec(p->back, d)));
}

/* From inside a to inside b: roughly the way that b lies. */
static inline vec3 convex_way(const ConvexPair *p)
{
    return vec3_sub(convex_point_b(p, shape_middle(p->b)), shape_middle(p->a));
}

/* Fills out. Gives up early once the gap is known to exceed `enough`: gap is then a lower bound above it. axis (may be
 * NULL): a guess of the normal to start from, zero = none; replaced by the normal found. */
void convex_gap(const ConvexPair *p, real enough, vec3 *axis, ConvexGap *out);

/* ---- the two parts, for tests ---- */

/* False when the cores touch or overlap: then only out->gap is filled, with what the distance certainly exceeds: 0 or next to it. */
bool gjk_distance(const ConvexPair *p, real enough, vec3 start, ConvexGap *out);

/* Nearest face of the difference of the cores, whether the origin is inside or (barely) outside. True when it is exact, not
 * one of many small faces on a round side. */
bool epa_depth(const ConvexPair *p, vec3 hint, ConvexGap *out);

#define PATCH_CORNERS 16

/* A flat patch of the difference's surface: three or more of its corners, counter-clockwise about the normal. */
typedef struct Patch { vec3 normal; real offset; int count; vec3 w[PATCH_CORNERS], a[PATCH_CORNERS], b[PATCH_CORNERS]; } Patch;

/* Tries the faces that look along the guess (zero: towards b), and the edges that cross there. False proves nothing; true: out is the exact gap. */
bool patch_gap(const ConvexPair *p, vec3 guess, real enough, ConvexGap *out);

/* As epa_depth, starting from the patch: at once done when that is the nearest. */
bool epa_from_patch(const ConvexPair *p, const Patch *patch, ConvexGap *out);

/* Shapes with rims and round sides: GJK and the polytope close in on them by parts only. */
bool convex_is_round(const ConvexPair *p);

/* From a gap that is nearly right to the exact one, for such shapes. */
void convex_refine(const ConvexPair *p, ConvexGap *g);

extern const ShapeType shape_triangle;  /* a piece of a mesh; data: vec3[3]. Not in shape_types: it is no body's shape */

#endif
