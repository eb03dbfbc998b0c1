/* geom/pair.h - what manifold_collide, shape_distance and time_of_impact share: kinds of shapes, exact gaps, the building of
 * manifolds, the pieces of meshes. For these files only.
 *
 * Everything is computed in the frame of shape a, about its origin, so that results depend on the relative pose alone.
 *
 * Floor: geom.
 */
#ifndef DIG_PAIR_H
#define DIG_PAIR_H

#include "geom/gjk.h"
#include "geom/manifold.h"

/* Kinds that have exact pairs of their own. Any convex type not named is KIND_CONVEX; one whose core is a point is a ball. */
typedef enum ShapeKind {
    KIND_BALL, KIND_CAPSULE, KIND_BOX, KIND_CYLINDER, KIND_CONE, KIND_TRIANGLE, KIND_CONVEX, KIND_PLANE, KIND_SURFACE
} ShapeKind;

ShapeKind shape_kind(const Shape *s);

typedef struct Pair {
    const Shape *a, *b;
    ShapeKind    kind_a, kind_b;
    pose         at;            /* of a, world                        */
    mat3         axes;          /* columns: axes of a, world          */
    ConvexPair   c;             /* in the frame of a                  */
    real         grain;         /* m  the smaller shape: what is small in a contact is so against it */
    real         reach;
} Pair;

Pair pair_make(const Shape *a, pose pa, const Shape *b, pose pb);
/* Planes stand still, and so do surfaces, but for meshes that are closed: planes meet these as they would meet their hulls. */
static inline bool kinds_meet(const Shape *a, ShapeKind kind_a, const Shape *b, ShapeKind kind_b)
{
    return kind_a < KIND_PLANE || kind_b < KIND_PLANE || (kind_a != kind_b && (a->type->support || b->type->support));
}
/* A surface by its pieces; what planes meet is one. */
static inline bool in_pieces(ShapeKind surface, ShapeKind other) { return surface == KIND_SURFACE && other != KIND_PLANE; }
/* Surface a narrowed to one of its pieces. */
Pair pair_with_piece(const Pair *p, const Shape *triangle, vec3 origin);
Pair pair_swapped(const Pair *p);

/* Lengths within a contact that are the same: a part of the smaller shape, but never below rounding. */
static inline real pair_same(const Pair *p, real part) { return real_max(part * p->grain, 1e-13 * p->c.size); }

static inline vec3 pair_direction(const Pair *p, vec3 local) { return mat3_mul_vec(p->axes, local); }
static inline vec3 pair_point(const Pair *p, vec3 local) { return vec3_add(p->at.p, mat3_mul_vec(p->axes, local)); }

/* ---- gaps (distance.c, point.c) ---- */

/* Gap of the surfaces, rounding included, and the nearest surface points, in the frame of a. Not for KIND_SURFACE. enough and
 * axis as in convex_gap. */
void pair_gap(const Pair *p, real enough, vec3 *axis, ConvexGap *out);

/* Gap of a point to the core of a convex shape, in closed form; normal out of the core. False: this kind has no closed form. */
bool point_gap(const Shape *s, ShapeKind kind, vec3 point, real *gap, vec3 *normal, vec3 *on);

/* Nearest points of the segments p0 p1 and q0 q1 as fractions along them. */
void segment_nearest(vec3 p0, vec3 p1, vec3 q0, vec3 q1, real *s, real *t);

/* ---- building manifolds (manifold_build.c), all in the frame of a ---- */

#define CONTACT_CANDIDATES 40

typedef struct Candidate { vec3 on_a, on_b; real gap; uint32_t feature; } Candidate;

typedef struct Contacts {
    vec3      normal;           /* from a to b */
    int       count;
    Candidate at[CONTACT_CANDIDATES];   /* in order around the contact area */
} Contacts;

/* Adds a candidate unless its gap exceeds reach or there is no room. */
void contacts_add(Contacts *c, real reach, vec3 on_a, vec3 on_b, uint32_t feature);

/* Picks the deepest and the three others that span the largest area, and writes them in world axes. Returns 1, or 0 when empty. */
int contacts_finish(const Pair *p, Contacts *c, Manifold *out);

/* One point. */
int contacts_single(const Pair *p, const ConvexGap *g, Manifold *out);

/* ---- pairs (manifold_convex.c, manifold_box.c) ---- */

/* From the gap and its normal to up to four points, by clipping the faces that look at each other. */
int collide_faces(const Pair *p, const ConvexGap *g, Manifold *out);
int collide_convex(const Pair *p, ManifoldCache *cache, Manifold *out);
int collide_boxes(const Pair *p, ManifoldCache *cache, Manifold *out);

/* Separation by the 15 axes of two boxes: the greatest (of the faces; of the edges), < 0 where they overlap. For tests too. */
real box_separation(const Pair *p);

/* ---- pieces of meshes and height fields (surface.c) ---- */

Shape triangle_shape(const vec3 corners[3]);

/* One piece of a surface as a convex shape: corners relative to `origin`, so that far pieces keep their digits. */
typedef struct SurfacePiece { uint32_t number; vec3 origin, corners[3]; } SurfacePiece;

/* Calls visit for every piece whose bounds meet box (in the frame of the surface), each once, in a fixed order; stops when it
 * returns false. */
typedef bool PieceVisit(void *context, const SurfacePiece *piece);
void surface_visit(const Shape *s, box3 box, PieceVisit *visit, void *context);

/* Bounds of b in the frame of a. */
box3 pair_bounds_b(const Pair *p);

/* Manifolds of surface a with convex b. */
int collide_surface(const Pair *p, Manifold *out, uint32_t *piece, int capacity);

#endif
