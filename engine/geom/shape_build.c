/* geom/shape_build.c - what the shape types share when they are made, drawn and hit by rays. */
#include <stdio.h>
#include <stdlib.h>

#include "geom/shape_build.h"

dig_status shape_fail(dig_status status, char *why, size_t capacity, const char *format, ...)
{
    if (why && capacity > 0) {
        va_list args;
        va_start(args, format);
        vsnprintf(why, capacity, format, args);
        va_end(args);
    }
    return status;
}

/* ---- rays ---- */

bool shape_hit(const Ray *ray, real t, vec3 normal, RayHit *hit)
{
    if (!(t >= 0 && t <= ray->length))
        return false;
    *hit = (RayHit){vec3_mad(ray->from, t, ray->along), normal, t};
    return true;
}

/* With q = -(b + sign(b) sqrt(b^2 - a c)) the roots are q / a and c / q: no subtraction of near equal numbers. */
bool shape_quadratic(real a, real b, real c, real *t0, real *t1)
{
    real disc = b * b - a * c;
    if (!(disc >= 0))
        return false;
    real q = b > 0 ? -(b + sqrt(disc)) : sqrt(disc) - b;
    if (a == 0 && q == 0)
        return false;
    real u = a != 0 ? q / a : c / q;
    real v = q != 0 ? c / q : u;
    *t0 = real_min(u, v);
    *t1 = real_max(u, v);
    return true;
}

/* The ray is sheared onto the z axis of a frame whose z is its largest component: the point-in-triangle test becomes three
 * 2D cross products that come out exactly opposite for the two triangles of an edge.
 *
 * Source: Woop, Benthin & Wald, Watertight ray/triangle intersection, JCGT 2(1), 2013. */
TriangleRay shape_triangle_ray(const Ray *ray)
{
    vec3 size = vec3_abs(ray->along);
    int  z = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    int  x = (z + 1) % 3, y = (z + 2) % 3;

    if (vec3_at(ray->along, z) < 0) {           /* keeps the winding */
        int swap = x;
        x = y;
        y = swap;
    }
    real s = 1 / vec3_at(ray->along, z);
    return (TriangleRay){ray->from, ray->along, {s * vec3_at(ray->along, x), s * vec3_at(ray->along, y), s}, x, y, z};
}

bool shape_ray_triangle(const TriangleRay *ray, const vec3 corners[3], real *t)
{
    real x[3], y[3], z[3];
    for (int i = 0; i < 3; i++) {
        vec3 v = vec3_sub(corners[i], ray->from);
        z[i] = vec3_at(v, ray->z);
        x[i] = vec3_at(v, ray->x) - ray->shear.x * z[i];
        y[i] = vec3_at(v, ray->y) - ray->shear.y * z[i];
    }
    real u = x[2] * y[1] - y[2] * x[1];
    real v = x[0] * y[2] - y[0] * x[2];
    real w = x[1] * y[0] - y[1] * x[0];
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0))
        return false;
    real det = u + v + w;
    if (det == 0)
        return false;
    *t = ray->shear.z * (u * z[0] + v * z[1] + w * z[2]) / det;
    return *t >= 0;
}

bool shape_ray_box(const Ray *ray, box3 box, real length, real *enter)
{
    real lo = 0, hi = length;
    for (int i = 0; i < 3; i++) {
        real o = vec3_at(ray->from, i), d = vec3_at(ray->along, i);
        real a = vec3_at(box.low, i) - o, b = vec3_at(box.high, i) - o;
        if (d == 0) {
            if (a > 0 || b < 0)
                return false;
            continue;
        }
        real t0 = a / d, t1 = b / d;
        lo = real_max(lo, real_min(t0, t1));
        hi = real_min(hi, real_max(t0, t1));
    }
    *enter = lo;
    return lo <= hi * (1 + 1e-15);              /* three roundings: Ize, Robust BVH ray traversal, JCGT 2(2), 2013 */
}

/* ---- drawing ---- */

dig_status shape_mesh_open(ShapeMesh *m, int vertex_count, int index_count, bool smooth)
{
    size_t coordinates = 3 * (size_t)vertex_count * sizeof(float);
    *m = (ShapeMesh){.vertex_count = vertex_count, .index_count = index_count};
    m->vertices = malloc(coordinates);
    m->normals  = smooth ? malloc(coordinates) : NULL;
    m->indices  = malloc((size_t)index_count * sizeof *m->indices);
    if (m->vertices && m->indices && (m->normals || !smooth))
        return DIG_OK;
    free(m->vertices);
    free(m->normals);
    free(m->indices);
    *m = (ShapeMesh){0};
    return DIG_E_MEMORY;
}

static void put(float *to, vec3 v)
{
    to[0] = (float)v.x;
    to[1] = (float)v.y;
    to[2] = (float)v.z;
}

void shape_mesh_vertex(ShapeMesh *m, int i, vec3 p) { put(m->vertices + 3 * (size_t)i, p); }
void shape_mesh_normal(ShapeMesh *m, int i, vec3 n) { put(m->normals + 3 * (size_t)i, n); }

void shape_mesh_triangle(ShapeMesh *m, int i, uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t *to = m->indices + 3 * (size_t)i;
    to[0] = a;
    to[1] = b;
    to[2] = c;
}

/* Number of triangles a segment of the band between two rings needs: none at a sharp edge, one at a pole. */
static int band_triangles(ShapeRing low, ShapeRing high)
{
    if (low.radius == high.radius && low.y == high.y)
        return 0;
    return (low.radius > 0) + (high.radius > 0);
}

dig_status shape_mesh_revolve(ShapeMesh *m, const ShapeRing *rings, int ring_count)
{
    int triangles = 0;
    for (int j = 0; j + 1 < ring_count; j++)
        triangles += SHAPE_SEGMENTS * band_triangles(rings[j], rings[j + 1]);
    DIG_TRY(shape_mesh_open(m, ring_count * SHAPE_SEGMENTS, 3 * triangles, true));

    for (int j = 0; j < ring_count; j++) {
        ShapeRing r = rings[j];
        for (int k = 0; k < SHAPE_SEGMENTS; k++) {
            real c = cos(2 * DIG_PI * k / SHAPE_SEGMENTS), s = sin(2 * DIG_PI * k / SHAPE_SEGMENTS);
            shape_mesh_vertex(m, j * SHAPE_SEGMENTS + k, (vec3){r.radius * c, r.y, r.radius * s});
            shape_mesh_normal(m, j * SHAPE_SEGMENTS + k, (vec3){r.out * c, r.up, r.out * s});
        }
    }

    int at = 0;
    for (int j = 0; j + 1 < ring_count; j++) {
        if (band_triangles(rings[j], rings[j + 1]) == 0)
            continue;
        for (int k = 0; k < SHAPE_SEGMENTS; k++) {
            uint32_t low = (uint32_t)(j * SHAPE_SEGMENTS + k), low2 = (uint32_t)(j * SHAPE_SEGMENTS + (k + 1) % SHAPE_SEGMENTS);
            uint32_t high = low + SHAPE_SEGMENTS, high2 = low2 + SHAPE_SEGMENTS;
            if (rings[j + 1].radius > 0)
                shape_mesh_triangle(m, at++, low, high, high2);
            if (rings[j].radius > 0)
                shape_mesh_triangle(m, at++, low, high2, low2);
        }
    }
    return DIG_OK;
}
