/* geom/point.c - gap of a point to the core of a shape, in closed form: what makes contacts of spheres exact. */
#include "geom/pair.h"

static bool outside(vec3 from_core, vec3 inward_guess, real *gap, vec3 *normal)
{
    *gap = vec3_length(from_core);
    *normal = vec3_unit_or(from_core, inward_guess);
    return true;
}

static bool box_point(const Shape *s, vec3 p, real *gap, vec3 *normal, vec3 *on)
{
    vec3 h = ((const BoxData *)s->data)->half, d = vec3_sub(vec3_abs(p), h);
    vec3 clamped = {real_clamp(p.x, -h.x, h.x), real_clamp(p.y, -h.y, h.y), real_clamp(p.z, -h.z, h.z)};
    *on = clamped;
    if (vec3_largest(d) > 0)
        return outside(vec3_sub(p, clamped), vec3_zero(), gap, normal);

    *gap = vec3_largest(d);                     /* the nearest face from inside */
    *normal = vec3_zero();
    if (d.x >= d.y && d.x >= d.z) {
        normal->x = p.x < 0 ? -1 : 1;
        on->x = normal->x * h.x;
    } else if (d.y >= d.z) {
        normal->y = p.y < 0 ? -1 : 1;
        on->y = normal->y * h.y;
    } else {
        normal->z = p.z < 0 ? -1 : 1;
        on->z = normal->z * h.z;
    }
    return true;
}

static bool capsule_point(const Shape *s, vec3 p, real *gap, vec3 *normal, vec3 *on)
{
    real h = ((const CapsuleData *)s->data)->half;
    *on = (vec3){0, real_clamp(p.y, -h, h), 0};
    return outside(vec3_sub(p, *on), (vec3){1, 0, 0}, gap, normal);
}

/* Solids of revolution about y: the plane half (rho, y) through the point. */
static vec3 radial_of(vec3 p)
{
    return vec3_unit_or((vec3){p.x, 0, p.z}, (vec3){1, 0, 0});
}

static vec3 from_half_plane(vec3 radial, real rho, real y)
{
    return (vec3){rho * radial.x, y, rho * radial.z};
}

static bool cylinder_point(const Shape *s, vec3 p, real *gap, vec3 *normal, vec3 *on)
{
    const CylinderData *c = s->data;
    vec3 radial = radial_of(p);
    real rho = sqrt(p.x * p.x + p.z * p.z), side = rho - c->radius, end = fabs(p.y) - c->half, up = p.y < 0 ? -1 : 1;

    if (side > 0 && end > 0) {
        *gap = sqrt(side * side + end * end);
        *normal = from_half_plane(radial, side / *gap, up * end / *gap);
        *on = from_half_plane(radial, c->radius, up * c->half);
    } else if (side >= end) {
        *gap = side;
        *normal = radial;
        *on = from_half_plane(radial, c->radius, p.y);
    } else {
        *gap = end;
        *normal = (vec3){0, up, 0};
        *on = (vec3){p.x, up * c->half, p.z};
    }
    return true;
}

static bool cone_point(const Shape *s, vec3 p, real *gap, vec3 *normal, vec3 *on)
{
    const ConeData *c = s->data;
    vec3 radial = radial_of(p);
    real rho = sqrt(p.x * p.x + p.z * p.z), down = c->apex - p.y;
    real side = (rho * c->height - down * c->radius) / c->slant;        /* above the side, along its normal */
    real along = (rho * c->radius + down * c->height) / c->slant;       /* from the apex along the side     */
    real base = c->base - p.y;                                          /* below the base                   */
    real foot = real_clamp(along, 0, c->slant);
    real side_rho = foot * c->radius / c->slant, side_y = c->apex - foot * c->height / c->slant;
    real base_rho = real_min(rho, c->radius);

    if (side <= 0 && base <= 0) {
        bool by_side = side >= base;
        *gap = by_side ? side : base;
        *normal = by_side ? from_half_plane(radial, c->height / c->slant, c->radius / c->slant) : (vec3){0, -1, 0};
        *on = vec3_mad(p, -*gap, *normal);
        return true;
    }
    real to_side = hypot(rho - side_rho, p.y - side_y), to_base = hypot(rho - base_rho, p.y - c->base);
    if (side > 0 && to_side <= to_base) {
        real x = rho - side_rho, y = p.y - side_y;
        *on = from_half_plane(radial, side_rho, side_y);
        bool plain = (along >= 0 && along <= c->slant) || !(to_side > 0);       /* on the side itself the normal is its own */
        *gap = plain ? side : to_side;
        *normal = plain ? from_half_plane(radial, c->height / c->slant, c->radius / c->slant)
                        : from_half_plane(radial, x / to_side, y / to_side);
        return true;
    }
    *gap = to_base;
    *on = from_half_plane(radial, base_rho, c->base);
    *normal = to_base > 0 ? from_half_plane(radial, (rho - base_rho) / to_base, -base / to_base) : (vec3){0, -1, 0};
    return true;
}

/* Nearest point of a triangle: the foot of the point where it lies inside, else the nearest of the edges. */
static bool triangle_point(const Shape *s, vec3 p, real *gap, vec3 *normal, vec3 *on)
{
    const vec3 *c = s->data;
    vec3 n = vec3_unit_or(vec3_cross(vec3_sub(c[1], c[0]), vec3_sub(c[2], c[0])), (vec3){0, 1, 0});
    bool above_all = true;
    real least = INFINITY;
    for (int i = 0; i < 3; i++) {
        vec3 e = vec3_sub(c[(i + 1) % 3], c[i]), d = vec3_sub(p, c[i]);
        real e2 = vec3_length2(e), t = e2 > 0 ? real_clamp(vec3_dot(d, e) / e2, 0, 1) : 0;
        above_all = above_all && vec3_dot(vec3_cross(n, e), d) >= 0;
        vec3 q = vec3_mad(c[i], t, e);
        real far_off = vec3_length2(vec3_sub(p, q));
        if (far_off < least) {
            least = far_off;
            *on = q;
        }
    }
    if (above_all) {
        real high = vec3_dot(n, vec3_sub(p, c[0]));
        *on = vec3_mad(p, -high, n);
        *gap = fabs(high);
        *normal = high < 0 ? vec3_neg(n) : n;
        return true;
    }
    return outside(vec3_sub(p, *on), n, gap, normal);
}

bool point_gap(const Shape *s, ShapeKind kind, vec3 point, real *gap, vec3 *normal, vec3 *on)
{
    static bool (*const closed_form[])(const Shape *, vec3, real *, vec3 *, vec3 *) = {
        [KIND_CAPSULE]  = capsule_point,
        [KIND_BOX]      = box_point,
        [KIND_CYLINDER] = cylinder_point,
        [KIND_CONE]     = cone_point,
        [KIND_TRIANGLE] = triangle_point,
        [KIND_SURFACE]  = NULL,
    };
    if (kind == KIND_BALL) {
        *on = vec3_zero();
        return outside(point, (vec3){0, 1, 0}, gap, normal);
    }
    return closed_form[kind] && closed_form[kind](s, point, gap, normal, on);
}
