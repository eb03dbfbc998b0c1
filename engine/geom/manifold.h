/* geom/manifold.h - where two shapes touch, or nearly do.
 *
 * Floor: geom.
 */
#ifndef DIG_MANIFOLD_H
#define DIG_MANIFOLD_H

#include "geom/shape.h"

#define MANIFOLD_POINTS 4

typedef struct ManifoldPoint {
    vec3     a, b;          /* m   surface points in world axes: on shape a, on shape b; gap = (b - a) . normal */
    real     gap;           /* m   < 0 where they overlap                                         */
    uint32_t feature;       /*     same number in the next step for the same pair of features     */
} ManifoldPoint;

typedef struct Manifold {
    vec3          normal;   /* unit, world, from a to b                     */
    int           count;    /* 0..MANIFOLD_POINTS; the deepest point is kept */
    ManifoldPoint points[MANIFOLD_POINTS];
} Manifold;

/* Hint kept between steps for one pair of shapes: any values are safe, zeroes mean none. */
typedef struct ManifoldCache { uint32_t kind, feature_a, feature_b; real axis[3]; } ManifoldCache;

/* The hint that a normal makes, from a to b in the axes of a. */
ManifoldCache manifold_hint(vec3 normal);

/* Contact of two shapes where the gap is at most `reach` (>= 0, m). At most `capacity` manifolds; a convex pair or a plane
 * gives at most one, a mesh or height field one per touching piece, with `piece[i]` its number (0 otherwise). Ghost contacts
 * at inner edges of meshes are removed. Returns the number of manifolds. Results depend on the relative pose only (the same
 * pair elsewhere gives the same digits up to rounding), swapping a and b mirrors them. cache and piece may be NULL.
 * Planes and surfaces do not meet each other. Open meshes are met from both sides, closed ones and height fields from outside.
 * Points of one manifold come in order around the contact area. They lie on the surfaces and face each other along the normal, to 1e-7
 * of the size; two exceptions, both above the deepest point or beside it: points of rounded shapes (capsules) may lie inside by what
 * they are higher than the deepest, and edges or lines that run side by side within 0.1 rad give the ends of their common stretch, each
 * on its own line. Corners nearer than 1e-9 of the size have a normal of the faces or edges about them, not that of the nearest
 * points; overlaps below 1e-9 of the smaller shape may come out as gaps as small. */
int manifold_collide(const Shape *a, pose pa, const Shape *b, pose pb, real reach, ManifoldCache *cache,
                     Manifold *out, uint32_t *piece, int capacity);

/* Faces of two boxes that are no surface: a neighbour in the same thing goes on there (two pieces of a plank). */
typedef struct Covered { uint8_t a, b; } Covered;               /* a bit each, see covered_face */

/* The face across axis 0..2 on the side of the sign of `along`. */
static inline uint8_t covered_face(int axis, real along) { return (uint8_t)(1u << (2 * axis + (along > 0 ? 1 : 0))); }

/* The same for parts of things: no normal leaves a part through a covered face. At most one manifold, for shapes that are convex
 * or planes. */
int manifold_of_parts(const Shape *a, pose pa, const Shape *b, pose pb, real reach, Covered covered, ManifoldCache *cache, Manifold *out);

/* Does this normal (unit, world, from a to b) leave one of them through a covered face? */
bool manifold_covered(const Shape *a, pose pa, const Shape *b, pose pb, Covered covered, vec3 normal);

/* A fixed shape beside others, and a box about it in world axes. */
typedef struct Beside { const Shape *shape; pose at; box3 box; } Beside;

/* Of these, those beside one fixed shape. */
typedef struct Neighbours { const Beside *all; const int *which; int count; } Neighbours;

/* Is this contact of a fixed shape with another at a part of its surface that others beside it cover? m: normal (unit, world) from the fixed
 * one to the other, points a on the fixed one. Both convex, but for those beside; else false. Steps and gaps between fixed shapes of up
 * to 2e-3 of the smaller shape of the two are none. */
bool manifold_hidden(const Shape *fixed, pose at, const Shape *other, pose other_at, const Neighbours *by, const Manifold *m);

/* The same; and a contact that is hidden becomes that with the nearest face that is not, or none. */
bool manifold_uncover(const Shape *fixed, pose at, const Shape *other, pose other_at, real reach, const Neighbours *by, Manifold *m);

/* Swaps a and b. */
void manifold_mirror(Manifold *m);

/* Signed distance of two shapes, exact where they are apart (to 1e-12 of their size); negative depth where they overlap.
 * normal (from a to b) and the two nearest points in world axes may be NULL. `enough`: may stop early once the distance is
 * known to exceed it (pass INFINITY for the exact value). */
real shape_distance(const Shape *a, pose pa, const Shape *b, pose pb, real enough, vec3 *normal, vec3 *on_a, vec3 *on_b);

/* A motion over time: p + v t + a t^2 / 2 for the centre of mass, which lies at `centre` in the shape's frame, turned by
 * exp(w t) in world axes. */
typedef struct Motion { pose start; vec3 centre; vec3 v, w, a; } Motion;

pose motion_at(const Motion *m, real t);
vec3 motion_velocity(const Motion *m, vec3 at, real t);         /* m/s  of its material that is at this place then */
Motion motion_from(const Motion *m, real t);                    /* the same motion, begun then */
/* m/s^2  How the turn bends the way of what is nearest at a point, at first, along the normal there: of a core's point, for rounding does not turn,
 * and what turns about the shape's own axis leaves its surface where it is. */
vec3 motion_sway(const Shape *s, const Motion *m, vec3 at, vec3 out);

/* First time in [0, time] at which the gap of the moving shapes falls to `target` (m): conservative advancement (Mirtich
 * 1996) closed by bracketing on the true gap, so that |gap - target| <= 1e-10 * size at the returned time. Returns time of
 * impact, or INFINITY when they stay apart. A pair that starts at or below the target and is separating returns INFINITY; one
 * that starts there and approaches returns 0. Never misses a crossing of convex cores, whatever the speed or spin. */
real time_of_impact(const Shape *a, const Motion *ma, const Shape *b, const Motion *mb, real target, real time, int *iterations);
/* Does the middle of one come through the other, a surface, on a straight line from its start to its end? */
bool surface_crossed(const Shape *a, const Motion *ma, const Shape *b, const Motion *mb, real time);

#endif
