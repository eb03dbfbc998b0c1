/* geom/plane.c - the half space: solid where normal . x <= offset. */
#include "geom/shape_build.h"

#define PLANE_FAR  1e30     /* m  stands for infinity in bounds */
#define PLANE_DRAW 100.0    /* m  half side of the square that is drawn */

static const dig_param plane_params[] = {
    {.name = "normal", .kind = DIG_DIR, .unit = "", .doc = "direction that points out of the solid", .fallback = NAN, .min = -1e5,
     .max = 1e5, .offset = offsetof(dig_plane_def, normal), .required = true},
    {.name = "offset", .kind = DIG_REAL, .unit = "m", .doc = "distance of the surface from the origin along the normal", .fallback = 0,
     .min = -SHAPE_LENGTH_MAX, .max = SHAPE_LENGTH_MAX, .offset = offsetof(dig_plane_def, offset)},
    {0}
};

static const PlaneData *data_of(const Shape *s) { return s->data; }

static dig_status plane_make(const void *def, Shape *s, char *why, size_t capacity)
{
    const dig_plane_def *given = def;
    vec3 n = vec3_unit_or(given->normal, vec3_zero());
    if (!(vec3_length2(n) > 0))
        return shape_fail(DIG_E_ARG, why, capacity, "plane normal = {0, 0, 0}, must have a direction");
    PlaneData *d = shape_alloc(s, sizeof *d);
    if (!d)
        return DIG_E_MEMORY;
    *d = (PlaneData){n, given->offset};
    s->inner = s->outer = INFINITY;
    return DIG_OK;
}

/* Endless, except that a plane exactly across an axis ends there: bodies above a level floor do not meet its bounds. */
static box3 plane_bounds(const Shape *s, pose at)
{
    vec3 n = quat_rotate(at.q, data_of(s)->normal);
    real surface = data_of(s)->offset + vec3_dot(n, at.p);
    box3 b = {{-PLANE_FAR, -PLANE_FAR, -PLANE_FAR}, {PLANE_FAR, PLANE_FAR, PLANE_FAR}};

    if (n.y == 0 && n.z == 0)
        *(n.x > 0 ? &b.high.x : &b.low.x) = n.x > 0 ? surface : -surface;
    else if (n.z == 0 && n.x == 0)
        *(n.y > 0 ? &b.high.y : &b.low.y) = n.y > 0 ? surface : -surface;
    else if (n.x == 0 && n.y == 0)
        *(n.z > 0 ? &b.high.z : &b.low.z) = n.z > 0 ? surface : -surface;
    return b;
}

static bool plane_contains(const Shape *s, vec3 p)
{
    return vec3_dot(data_of(s)->normal, p) <= data_of(s)->offset;
}

static bool plane_ray(const Shape *s, const Ray *ray, RayHit *hit)
{
    const PlaneData *d = data_of(s);
    real above = vec3_dot(d->normal, ray->from) - d->offset, sinks = -vec3_dot(d->normal, ray->along);
    return above > 0 && sinks > 0 && shape_hit(ray, above / sinks, d->normal, hit);
}

static dig_status plane_mesh(const Shape *s, ShapeMesh *out)
{
    static const real su[4] = {1, -1, -1, 1}, sv[4] = {1, 1, -1, -1};
    const PlaneData *d = data_of(s);
    vec3 u, v;
    vec3_basis(d->normal, &u, &v);
    DIG_TRY(shape_mesh_open(out, 4, 6, true));
    for (int k = 0; k < 4; k++) {
        vec3 p = vec3_scale(d->offset, d->normal);
        shape_mesh_vertex(out, k, vec3_mad(vec3_mad(p, PLANE_DRAW * su[k], u), PLANE_DRAW * sv[k], v));
        shape_mesh_normal(out, k, d->normal);
    }
    shape_mesh_triangle(out, 0, 0, 1, 2);
    shape_mesh_triangle(out, 1, 0, 2, 3);
    return DIG_OK;
}

const ShapeType shape_plane = {
    .name     = "plane",
    .doc      = "Everything below a plane; always static.",
    .params   = plane_params,
    .def_size = sizeof(dig_plane_def),
    .make     = plane_make,
    .bounds   = plane_bounds,
    .ray      = plane_ray,
    .contains = plane_contains,
    .mesh     = plane_mesh,
};
