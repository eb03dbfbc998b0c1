/* geom/cylinder.c - the cylinder along y about its origin. */
#include "geom/shape_build.h"
#include "geom/wet.h"

static const dig_param cylinder_params[] = {
    SHAPE_LENGTH("radius", "radius", dig_cylinder_def, radius),
    SHAPE_LENGTH("height", "height along y", dig_cylinder_def, height),
    {0}
};

static const CylinderData *data_of(const Shape *s) { return s->data; }

static dig_status cylinder_make(const void *def, Shape *s, char *why, size_t capacity)
{
    const dig_cylinder_def *given = def;
    CylinderData *d = shape_alloc(s, sizeof *d);
    (void)why;
    (void)capacity;
    if (!d)
        return DIG_E_MEMORY;
    *d = (CylinderData){given->radius, 0.5 * given->height};
    s->inner   = real_min(d->radius, d->half);
    s->outer   = sqrt(d->radius * d->radius + d->half * d->half);
    s->rolling = d->radius;
    return DIG_OK;
}

static vec3 cylinder_support(const Shape *s, vec3 direction)
{
    const CylinderData *d = data_of(s);
    real n = sqrt(direction.x * direction.x + direction.z * direction.z);
    real k = n > 0 ? d->radius / n : 0;
    return (vec3){k * direction.x, direction.y < 0 ? -d->half : d->half, k * direction.z};
}

/* A disc of radius r with unit normal u reaches r sqrt(1 - u_i^2) along axis i. */
static box3 cylinder_bounds(const Shape *s, pose at)
{
    const CylinderData *d = data_of(s);
    vec3 u = quat_rotate(at.q, (vec3){0, 1, 0});
    vec3 disc = {sqrt(u.y * u.y + u.z * u.z), sqrt(u.z * u.z + u.x * u.x), sqrt(u.x * u.x + u.y * u.y)};
    vec3 e = vec3_mad(vec3_scale(d->half, vec3_abs(u)), d->radius, disc);
    return (box3){vec3_sub(at.p, e), vec3_add(at.p, e)};
}

static real cylinder_area(const Shape *s)
{
    real r = data_of(s)->radius, h = 2 * data_of(s)->half;
    return 2 * DIG_PI * r * (r + h);
}

static void cylinder_mass(const Shape *s, MassProps *out)
{
    real r = data_of(s)->radius, h = 2 * data_of(s)->half;
    real volume = DIG_PI * r * r * h, across = volume * (3 * r * r + h * h) / 12;
    *out = (MassProps){.volume = volume, .inertia = mat3_diagonal((vec3){across, volume * r * r / 2, across})};
}

static void cylinder_wet(const Shape *s, vec3 normal, real offset, Wet *sum)
{
    real half = data_of(s)->half;
    wet_lathe(sum, &(Lathe){.y0 = -half, .y1 = half, .r0 = data_of(s)->radius}, normal, offset);
}

static real cylinder_shadow(const Shape *s, vec3 direction)
{
    real r = data_of(s)->radius;
    return DIG_PI * r * r * fabs(direction.y) + 4 * r * data_of(s)->half * sqrt(real_max(0, 1 - direction.y * direction.y));
}

static bool cylinder_contains(const Shape *s, vec3 p)
{
    const CylinderData *d = data_of(s);
    return fabs(p.y) <= d->half && p.x * p.x + p.z * p.z <= d->radius * d->radius;
}

/* The line is inside while it is inside the endless cylinder and between the end planes. */
static bool cylinder_ray(const Shape *s, const Ray *ray, RayHit *hit)
{
    real r = data_of(s)->radius, half = data_of(s)->half;
    real middle = -vec3_dot(ray->from, ray->along);     /* from next to the origin, for the digits */
    vec3 o = vec3_mad(ray->from, middle, ray->along), d = ray->along;
    real a = d.x * d.x + d.z * d.z, c = o.x * o.x + o.z * o.z - r * r;
    real enter = -INFINITY, leave = INFINITY;
    bool by_side = false;

    if (cylinder_contains(s, ray->from))
        return false;
    if (a > 0) {
        if (!shape_quadratic(a, o.x * d.x + o.z * d.z, c, &enter, &leave))
            return false;
        by_side = true;
    } else if (c > 0) {
        return false;
    }
    if (d.y == 0) {
        if (fabs(o.y) > half)
            return false;
    } else {
        real near_end = d.y > 0 ? -half : half, t = (near_end - o.y) / d.y;
        if (t > enter) {
            enter = t;
            by_side = false;
        }
        leave = real_min(leave, (-near_end - o.y) / d.y);
    }
    if (!(enter <= leave))
        return false;
    vec3 p = vec3_mad(o, enter, d);
    vec3 normal = by_side ? vec3_unit((vec3){p.x, 0, p.z}) : (vec3){0, d.y > 0 ? -1 : 1, 0};
    return shape_hit(ray, middle + enter, normal, hit);
}

static dig_status cylinder_mesh(const Shape *s, ShapeMesh *out)
{
    real r = data_of(s)->radius, h = data_of(s)->half;
    const ShapeRing rings[6] = {{0, -h, 0, -1}, {r, -h, 0, -1}, {r, -h, 1, 0}, {r, h, 1, 0}, {r, h, 0, 1}, {0, h, 0, 1}};
    return shape_mesh_revolve(out, rings, 6);
}

/* An end disc as eight rim points fixed in the body, or the side line under the direction. */
static int cylinder_face(const Shape *s, vec3 direction, vec3 corners[16], uint32_t *feature)
{
    static const real C[8] = {1, 0.70710678118654752, 0, -0.70710678118654752, -1, -0.70710678118654752, 0, 0.70710678118654752};
    real r = data_of(s)->radius, h = data_of(s)->half;
    real n = sqrt(direction.x * direction.x + direction.z * direction.z);

    if (fabs(direction.y) < n) {
        real x = r * direction.x / n, z = r * direction.z / n;
        corners[0] = (vec3){x, -h, z};
        corners[1] = (vec3){x, h, z};
        *feature = 2;
        return 2;
    }
    bool top = direction.y > 0;
    for (int k = 0; k < 8; k++) {               /* z to x is counter-clockwise about +y */
        int i = top ? k : (8 - k) % 8;
        corners[k] = (vec3){r * C[(i + 6) % 8], top ? h : -h, r * C[i]};
    }
    *feature = top ? 1 : 0;
    return 8;
}

const ShapeType shape_cylinder = {
    .name     = "cylinder",
    .doc      = "A cylinder along y about its origin.",
    .params   = cylinder_params,
    .def_size = sizeof(dig_cylinder_def),
    .solid    = true,
    .convex   = true,
    .make     = cylinder_make,
    .support  = cylinder_support,
    .bounds   = cylinder_bounds,
    .mass     = cylinder_mass,
    .wet      = cylinder_wet,
    .shadow   = cylinder_shadow,
    .drag     = 0.82,       /* a long one, end on; side on, 0.6 to 1.2 as it gets longer */
    .area     = cylinder_area,
    .ray      = cylinder_ray,
    .contains = cylinder_contains,
    .mesh     = cylinder_mesh,
    .face     = cylinder_face,
};
