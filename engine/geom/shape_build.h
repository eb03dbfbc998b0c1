/* geom/shape_build.h - what the shape types share when they are made, drawn and hit by rays. For the files of shape types only.
 *
 * Floor: geom.
 */
#ifndef DIG_SHAPE_BUILD_H
#define DIG_SHAPE_BUILD_H

#include "geom/shape.h"

/* The row of a length that must be given. */
#define SHAPE_LENGTH(key, what, def, field)                                                                 \
    {.name = key, .kind = DIG_REAL, .unit = "m", .doc = what, .fallback = NAN, .min = SHAPE_LENGTH_MIN,      \
     .max = SHAPE_LENGTH_MAX, .offset = offsetof(def, field), .required = true}

/* Zeroed data of the shape with one reference, or NULL. shape_make gives it back when the type's make fails later. */
void *shape_alloc(Shape *s, size_t bytes);

/* Writes the sentence and returns the status. */
dig_status shape_fail(dig_status status, char *why, size_t capacity, const char *format, ...) DIG_PRINTF(4, 5);

/* Fills a hit at distance t along the ray; false when that is beyond its length. */
bool shape_hit(const Ray *ray, real t, vec3 normal, RayHit *hit);

/* First root t >= 0 of a t^2 + 2 b t + c = 0 and the other one; false when there is none. Keeps its digits when roots differ much. */
bool shape_quadratic(real a, real b, real c, real *t0, real *t1);

/* A ray prepared for many triangles. */
typedef struct TriangleRay { vec3 from, along, shear; int x, y, z; } TriangleRay;

TriangleRay shape_triangle_ray(const Ray *ray);
/* Distance at which the ray crosses the triangle, from either side. Neighbours leave no gap between them. */
bool shape_ray_triangle(const TriangleRay *ray, const vec3 corners[3], real *t);
/* Does the ray pass the box before `length`? */
bool shape_ray_box(const Ray *ray, box3 box, real length, real *enter);

static inline real shape_triangle_area(const vec3 c[3])
{
    return 0.5 * vec3_length(vec3_cross(vec3_sub(c[1], c[0]), vec3_sub(c[2], c[0])));
}

/* What `data` of a height field points to. */
typedef struct HeightfieldData {
    int  columns, rows;
    real x0, z0;            /* m  corner of the grid        */
    real dx, dz;            /* m  size of a cell            */
    real low, high;         /* m  range of the heights, which follow [rows * columns] */
} HeightfieldData;
static inline const real *heightfield_heights(const HeightfieldData *d) { return (const real *)(const void *)(d + 1); }

/* ---- drawing ---- */

dig_status shape_mesh_open(ShapeMesh *m, int vertex_count, int index_count, bool smooth);
void       shape_mesh_vertex(ShapeMesh *m, int i, vec3 p);
void       shape_mesh_normal(ShapeMesh *m, int i, vec3 n);
void       shape_mesh_triangle(ShapeMesh *m, int i, uint32_t a, uint32_t b, uint32_t c);

#define SHAPE_SEGMENTS 24       /* around the axis of a solid of revolution */

/* One ring of a solid of revolution about y: radius, height, and the normal there (outward, upward). */
typedef struct ShapeRing { real radius, y, out, up; } ShapeRing;

/* Rings from the bottom to the top; two rings at the same place make a sharp edge. */
dig_status shape_mesh_revolve(ShapeMesh *m, const ShapeRing *rings, int ring_count);

#endif
