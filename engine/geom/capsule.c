/* geom/capsule.c - the capsule: a segment along y with a rounding radius. */
#include "geom/shape_build.h"
#include "geom/wet.h"

#define CAPSULE_RINGS 6     /* from equator to pole, for drawing */

static const dig_param capsule_params[] = {
    SHAPE_LENGTH("radius", "radius of the round ends", dig_capsule_def, radius),
    SHAPE_LENGTH("length", "length of the straight part along y", dig_capsule_def, length),
    {0}
};

static const CapsuleData *data_of(const Shape *s) { return s->data; }

static dig_status capsule_make(const void *def, Shape *s, char *why, size_t capacity)
{
    const dig_capsule_def *given = def;
    CapsuleData *d = shape_alloc(s, sizeof *d);
    (void)why;
    (void)capacity;
    if (!d)
        return DIG_E_MEMORY;
    *d = (CapsuleData){given->radius, 0.5 * given->length};
    s->round = s->inner = s->rolling = d->radius;
    s->outer = d->half + d->radius;
    return DIG_OK;
}

static vec3 capsule_support(const Shape *s, vec3 direction)
{
    real h = data_of(s)->half;
    return (vec3){0, direction.y < 0 ? -h : h, 0};
}

static box3 capsule_bounds(const Shape *s, pose at)
{
    vec3 end = vec3_abs(quat_rotate(at.q, (vec3){0, data_of(s)->half, 0}));
    return box3_grow((box3){vec3_sub(at.p, end), vec3_add(at.p, end)}, s->round);
}

/* A cylinder, and two half balls whose centres of mass lie 3r/8 beyond its ends. */
static real capsule_area(const Shape *s)
{
    const CapsuleData *d = s->data;
    return 4 * DIG_PI * d->radius * (d->radius + d->half);
}

static void capsule_mass(const Shape *s, MassProps *out)
{
    real r = data_of(s)->radius, L = 2 * data_of(s)->half;
    real tube = DIG_PI * r * r * L, ball = 4.0 / 3 * DIG_PI * r * r * r;
    real along  = tube * r * r / 2 + ball * 0.4 * r * r;
    real across = tube * (r * r / 4 + L * L / 12) + ball * (0.4 * r * r + L * L / 4 + 0.375 * L * r);
    *out = (MassProps){.volume = tube + ball, .inertia = mat3_diagonal((vec3){across, along, across})};
}

static void capsule_wet(const Shape *s, vec3 normal, real offset, Wet *sum)
{
    real r = data_of(s)->radius, half = data_of(s)->half;
    const Lathe tube = {.y0 = -half, .y1 = half, .r0 = r}, low = {.y0 = -half - r, .y1 = -half, .ball = r, .middle = -half},
                high = {.y0 = half, .y1 = half + r, .ball = r, .middle = half};
    wet_lathe(sum, &low, normal, offset);
    wet_lathe(sum, &tube, normal, offset);
    wet_lathe(sum, &high, normal, offset);
}

static real capsule_shadow(const Shape *s, vec3 direction)
{
    real r = data_of(s)->radius;
    return DIG_PI * r * r + 4 * r * data_of(s)->half * sqrt(real_max(0, 1 - direction.y * direction.y));
}

static bool capsule_contains(const Shape *s, vec3 p)
{
    const CapsuleData *d = data_of(s);
    real y = p.y - real_clamp(p.y, -d->half, d->half);
    return p.x * p.x + y * y + p.z * p.z <= d->radius * d->radius;
}

/* The first of the entries into the straight side and into the two balls: parts of a convex union whose other entries lie inside. */
static bool capsule_ray(const Shape *s, const Ray *ray, RayHit *hit)
{
    real r = data_of(s)->radius, half = data_of(s)->half, best = INFINITY, t0, t1;
    if (capsule_contains(s, ray->from))
        return false;

    real middle = -vec3_dot(ray->from, ray->along);     /* from next to the origin, for the digits */
    vec3 o = vec3_mad(ray->from, middle, ray->along), d = ray->along;
    if (shape_quadratic(d.x * d.x + d.z * d.z, o.x * d.x + o.z * d.z, o.x * o.x + o.z * o.z - r * r, &t0, &t1) &&
        fabs(o.y + t0 * d.y) <= half && middle + t0 >= 0)
        best = t0;
    for (int end = -1; end <= 1; end += 2) {
        vec3 e = {o.x, o.y - end * half, o.z};
        if (shape_quadratic(1, vec3_dot(e, d), vec3_length2(e) - r * r, &t0, &t1) && middle + t0 >= 0)
            best = real_min(best, t0);
    }
    if (!isfinite(best))
        return false;
    vec3 p = vec3_mad(o, best, d);
    p.y -= real_clamp(p.y, -half, half);
    return shape_hit(ray, middle + best, vec3_unit(p), hit);
}

static dig_status capsule_mesh(const Shape *s, ShapeMesh *out)
{
    real r = data_of(s)->radius, half = data_of(s)->half;
    ShapeRing rings[2 * (CAPSULE_RINGS + 1)];
    for (int i = 0; i <= CAPSULE_RINGS; i++) {
        real angle = 0.5 * DIG_PI * i / CAPSULE_RINGS;
        real c = i == CAPSULE_RINGS ? 0 : cos(angle), u = sin(angle);
        rings[CAPSULE_RINGS - i]     = (ShapeRing){r * c, -half - r * u, c, -u};
        rings[CAPSULE_RINGS + 1 + i] = (ShapeRing){r * c, half + r * u, c, u};
    }
    return shape_mesh_revolve(out, rings, 2 * (CAPSULE_RINGS + 1));
}

/* The segment where it lies flat to within 0.01 rad, else the end that points there. */
static int capsule_face(const Shape *s, vec3 direction, vec3 corners[16], uint32_t *feature)
{
    real h = data_of(s)->half;
    if (fabs(direction.y) > 1e-2 * vec3_length(direction)) {
        corners[0] = (vec3){0, direction.y < 0 ? -h : h, 0};
        *feature = direction.y < 0 ? 0 : 1;
        return 1;
    }
    corners[0] = (vec3){0, -h, 0};
    corners[1] = (vec3){0, h, 0};
    *feature = 2;
    return 2;
}

const ShapeType shape_capsule = {
    .name     = "capsule",
    .doc      = "A cylinder along y with half balls as ends, about its origin.",
    .params   = capsule_params,
    .def_size = sizeof(dig_capsule_def),
    .solid    = true,
    .convex   = true,
    .make     = capsule_make,
    .support  = capsule_support,
    .bounds   = capsule_bounds,
    .mass     = capsule_mass,
    .wet      = capsule_wet,
    .shadow   = capsule_shadow,
    .drag     = 0.6,
    .area     = capsule_area,
    .ray      = capsule_ray,
    .contains = capsule_contains,
    .mesh     = capsule_mesh,
    .face     = capsule_face,
};
