/* geom/cast.c - a ray, a capped cylinder and an arc: what a moving ball meets, from the coarsest answer to the true one. */
#include "geom/cast.h"
#include "geom/pair.h"

/* A ball of its own: a point core. */
static vec3 ball_support(const Shape *s, vec3 direction)
{
    (void)s;
    (void)direction;
    return vec3_zero();
}

static box3 ball_bounds(const Shape *s, pose at)
{
    return box3_grow((box3){at.p, at.p}, s->round);
}

static const ShapeType ball_type = {
    .name    = "ball",
    .doc     = "What a cast moves.",
    .convex  = true,
    .support = ball_support,
    .bounds  = ball_bounds,
};

bool cast_ray(const Shape *s, pose at, vec3 from, vec3 velocity, real time, CastHit *hit)
{
    real speed = vec3_length(velocity);
    RayHit found;
    if (!(speed > 0))
        return false;
    Ray ray = {pose_unpoint(at, from), quat_unrotate(at.q, vec3_unit(velocity)), speed * time};
    if (!s->type->ray(s, &ray, &found) || !(found.distance <= ray.length))
        return false;
    *hit = (CastHit){real_min(found.distance / speed, time), pose_point(at, found.point), quat_rotate(at.q, found.normal)};
    return true;
}

bool cast_capped_cylinder(const Shape *s, pose at, vec3 from, real radius, vec3 velocity, real time, CastHit *hit)
{
    return cast_arc(s, at, from, radius, velocity, vec3_zero(), time, hit);
}

bool cast_arc(const Shape *s, pose at, vec3 from, real radius, vec3 velocity, vec3 acceleration, real time, CastHit *hit)
{
    Shape ball = {.type = &ball_type, .round = radius, .inner = radius, .outer = radius};
    Motion still = {.start = at}, flight = {.start = {from, quat_identity()}, .v = velocity, .a = acceleration};
    vec3 normal, point;

    bool inside = shape_distance(s, at, &ball, flight.start, 0, NULL, NULL, NULL) <= 0;
    real t = inside ? 0 : time_of_impact(s, &still, &ball, &flight, 0, time, NULL);
    if (!(t <= time))
        return false;
    shape_distance(s, at, &ball, motion_at(&flight, t), INFINITY, &normal, &point, NULL);
    *hit = (CastHit){t, point, normal};
    return true;
}

real bisect_impact(real (*gap)(void *context, real t), void *context, real lo, real hi, int count)
{
    for (int i = 0; i < count; i++) {
        real middle = 0.5 * (lo + hi);
        if (gap(context, middle) > 0)
            lo = middle;
        else
            hi = middle;
    }
    return 0.5 * (lo + hi);
}
