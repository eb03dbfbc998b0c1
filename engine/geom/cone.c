/* geom/cone.c - the cone along y, apex up; its origin is its centre of mass, a quarter of the height above the base. */
#include "geom/shape_build.h"
#include "geom/wet.h"

static const dig_param cone_params[] = {
    SHAPE_LENGTH("radius", "radius of the base", dig_cone_def, radius),
    SHAPE_LENGTH("height", "height along y from base to apex", dig_cone_def, height),
    {0}
};

static const ConeData *data_of(const Shape *s) { return s->data; }

static dig_status cone_make(const void *def, Shape *s, char *why, size_t capacity)
{
    const dig_cone_def *given = def;
    real r = given->radius, h = given->height, slant = sqrt(r * r + h * h);
    ConeData *d = shape_alloc(s, sizeof *d);
    (void)why;
    (void)capacity;
    if (!d)
        return DIG_E_MEMORY;
    *d = (ConeData){r, h, -0.25 * h, 0.75 * h, slant};
    s->inner = real_min(0.25 * h, d->apex * r / slant);     /* to the base; to the side */
    s->outer = real_max(d->apex, sqrt(r * r + d->base * d->base));
    return DIG_OK;
}

static vec3 cone_support(const Shape *s, vec3 direction)
{
    const ConeData *d = data_of(s);
    real n = sqrt(direction.x * direction.x + direction.z * direction.z);
    if (direction.y * d->height >= n * d->radius)
        return (vec3){0, d->apex, 0};
    real k = n > 0 ? d->radius / n : 0;
    return (vec3){k * direction.x, d->base, k * direction.z};
}

/* The apex and the disc of the base, which reaches r sqrt(1 - u_i^2) along axis i when u is the axis of the cone. */
static box3 cone_bounds(const Shape *s, pose at)
{
    const ConeData *d = data_of(s);
    vec3 u = quat_rotate(at.q, (vec3){0, 1, 0});
    vec3 e = vec3_scale(d->radius, (vec3){sqrt(u.y * u.y + u.z * u.z), sqrt(u.z * u.z + u.x * u.x), sqrt(u.x * u.x + u.y * u.y)});
    vec3 base = vec3_mad(at.p, d->base, u), apex = vec3_mad(at.p, d->apex, u);
    return (box3){vec3_min(apex, vec3_sub(base, e)), vec3_max(apex, vec3_add(base, e))};
}

static real cone_area(const Shape *s)
{
    const ConeData *d = data_of(s);
    return DIG_PI * d->radius * (d->radius + d->slant);
}

static void cone_mass(const Shape *s, MassProps *out)
{
    real r = data_of(s)->radius, h = data_of(s)->height;
    real volume = DIG_PI * r * r * h / 3, across = volume * (0.15 * r * r + 0.0375 * h * h);
    *out = (MassProps){.volume = volume, .inertia = mat3_diagonal((vec3){across, 0.3 * volume * r * r, across})};
}

static void cone_wet(const Shape *s, vec3 normal, real offset, Wet *sum)
{
    const ConeData *d = data_of(s);
    real k = d->radius / d->height;
    wet_lathe(sum, &(Lathe){.y0 = d->base, .y1 = d->apex, .r0 = k * d->apex, .slope = -k}, normal, offset);
}

/* The ellipse of the base, and, where the apex stands out, the tangents from it: stretched across, those of a circle. */
static real cone_shadow(const Shape *s, vec3 direction)
{
    const ConeData *d = data_of(s);
    real a = d->radius, b = a * real_min(1, fabs(direction.y)), out = d->height * sqrt(real_max(0, 1 - direction.y * direction.y));
    return out <= b ? DIG_PI * a * b : a * b * (DIG_PI - acos(b / out)) + a * sqrt((out - b) * (out + b));
}

static bool cone_contains(const Shape *s, vec3 p)
{
    const ConeData *d = data_of(s);
    real r = (d->apex - p.y) * d->radius / d->height;       /* radius at this height */
    return p.y >= d->base && p.y <= d->apex && p.x * p.x + p.z * p.z <= r * r;
}

/* From outside, the first crossing of the surface is the entry: the side between base and apex, or the base from below. */
static bool cone_ray(const Shape *s, const Ray *ray, RayHit *hit)
{
    const ConeData *c = data_of(s);
    real k = c->radius / c->height, best = INFINITY, t[2];
    real middle = -vec3_dot(ray->from, ray->along);         /* from next to the origin, for the digits */
    vec3 o = vec3_mad(ray->from, middle, ray->along), d = ray->along, normal = {0, -1, 0};
    real down = c->apex - o.y;                              /* x^2 + z^2 = k^2 (apex - y)^2 */

    if (cone_contains(s, ray->from))
        return false;
    if (d.y > 0) {
        real at = (c->base - o.y) / d.y;
        vec3 p = vec3_mad(o, at, d);
        if (middle + at >= 0 && p.x * p.x + p.z * p.z <= c->radius * c->radius)
            best = at;
    }
    if (shape_quadratic(d.x * d.x + d.z * d.z - k * k * d.y * d.y, o.x * d.x + o.z * d.z + k * k * d.y * down,
                        o.x * o.x + o.z * o.z - k * k * down * down, &t[0], &t[1]))
        for (int i = 0; i < 2; i++) {
            vec3 p = vec3_mad(o, t[i], d);
            if (!(p.y >= c->base && p.y <= c->apex && middle + t[i] >= 0 && t[i] < best))
                continue;
            vec3 side = vec3_unit_or((vec3){p.x, 0, p.z}, vec3_zero());     /* zero at the apex: straight up there */
            best   = t[i];
            normal = vec3_unit((vec3){side.x, k, side.z});
        }
    return isfinite(best) && shape_hit(ray, middle + best, normal, hit);
}

static dig_status cone_mesh(const Shape *s, ShapeMesh *out)
{
    const ConeData *d = data_of(s);
    real c = d->height / d->slant, u = d->radius / d->slant;
    const ShapeRing rings[4] = {{0, d->base, 0, -1}, {d->radius, d->base, 0, -1}, {d->radius, d->base, c, u}, {0, d->apex, c, u}};
    return shape_mesh_revolve(out, rings, 4);
}

/* The base as eight rim points fixed in the body, the side line under the direction, or the apex where the direction
 * leaves the side's normal by more than 0.01 rad towards it. */
static int cone_face(const Shape *s, vec3 direction, vec3 corners[16], uint32_t *feature)
{
    static const real C[8] = {1, 0.70710678118654752, 0, -0.70710678118654752, -1, -0.70710678118654752, 0, 0.70710678118654752};
    const ConeData *d = data_of(s);
    real n = sqrt(direction.x * direction.x + direction.z * direction.z), y = direction.y;
    real along_side = (n * d->height + y * d->radius) / d->slant;           /* direction . normal of the side */
    real past_side  = (y * d->height - n * d->radius) / d->slant;           /* direction . line from rim to apex */

    if (past_side > 1e-2 * sqrt(n * n + y * y)) {
        corners[0] = (vec3){0, d->apex, 0};
        *feature = 2;
        return 1;
    }
    if (along_side > -y && n > 0) {
        corners[0] = (vec3){d->radius * direction.x / n, d->base, d->radius * direction.z / n};
        corners[1] = (vec3){0, d->apex, 0};
        *feature = 1;
        return 2;
    }
    for (int k = 0; k < 8; k++)                 /* x to z is counter-clockwise about -y */
        corners[k] = (vec3){d->radius * C[k], d->base, d->radius * C[(k + 6) % 8]};
    *feature = 0;
    return 8;
}

const ShapeType shape_cone = {
    .name     = "cone",
    .doc      = "A cone along y, apex up; its origin is its centre of mass, a quarter of the height above the base.",
    .params   = cone_params,
    .def_size = sizeof(dig_cone_def),
    .solid    = true,
    .convex   = true,
    .make     = cone_make,
    .support  = cone_support,
    .bounds   = cone_bounds,
    .mass     = cone_mass,
    .wet      = cone_wet,
    .shadow   = cone_shadow,
    .drag     = 0.5,        /* apex on, 60 degrees wide */
    .area     = cone_area,
    .ray      = cone_ray,
    .contains = cone_contains,
    .mesh     = cone_mesh,
    .face     = cone_face,
};
