/* tests/unit/collide_fixture.h - shapes, poses and random numbers for the tests of contacts, distances and casts. */
#ifndef DIG_COLLIDE_FIXTURE_H
#define DIG_COLLIDE_FIXTURE_H

#include "base/rng.h"
#include "check.h"
#include "geom/manifold.h"

static inline Shape fixture_make(const char *type, const void *def)
{
    Shape s;
    char why[256] = "";
    if (shape_make(type, def, &s, why, sizeof why) != DIG_OK)
        fail_msg("%s: %s", type, why);
    return s;
}

static inline Shape fixture_sphere(real radius) { return fixture_make("sphere", &(dig_sphere_def){radius}); }
static inline Shape fixture_box(real x, real y, real z) { return fixture_make("box", &(dig_box_def){{x, y, z}}); }
static inline Shape fixture_capsule(real radius, real length) { return fixture_make("capsule", &(dig_capsule_def){radius, length}); }
static inline Shape fixture_cylinder(real radius, real height) { return fixture_make("cylinder", &(dig_cylinder_def){radius, height}); }
static inline Shape fixture_cone(real radius, real height) { return fixture_make("cone", &(dig_cone_def){radius, height}); }
static inline Shape fixture_plane(vec3 normal, real offset) { return fixture_make("plane", &(dig_plane_def){normal, offset}); }
static inline Shape fixture_hull(const vec3 *points, int count)
{
    return fixture_make("hull", &(dig_hull_def){.points = {points, count}});
}

/* A hull of the box's corners: the same solid by the general path. */
static inline Shape fixture_box_hull(real x, real y, real z)
{
    vec3 c[8];
    for (int i = 0; i < 8; i++)
        c[i] = (vec3){(i & 1 ? 0.5 : -0.5) * x, (i & 2 ? 0.5 : -0.5) * y, (i & 4 ? 0.5 : -0.5) * z};
    return fixture_hull(c, 8);
}

typedef struct Random { uint64_t state; } Random;

static inline real random_unit(Random *r) { return rng_real(&r->state); }
static inline real random_between(Random *r, real low, real high) { return low + (high - low) * random_unit(r); }

static inline vec3 random_vec3(Random *r, real half)
{
    real x = random_between(r, -half, half), y = random_between(r, -half, half), z = random_between(r, -half, half);
    return (vec3){x, y, z};
}

static inline vec3 random_direction(Random *r)
{
    for (;;) {
        vec3 v = random_vec3(r, 1);
        real n = vec3_length2(v);
        if (n > 0.01 && n < 1)
            return vec3_unit(v);
    }
}

static inline quat random_turn(Random *r)
{
    vec3 axis = random_direction(r);
    return quat_axis_angle(axis, random_between(r, -DIG_PI, DIG_PI));
}

static inline pose at_point(real x, real y, real z) { return (pose){{x, y, z}, {0, 0, 0, 1}}; }

static inline real deepest_gap(const Manifold *m)
{
    real least = INFINITY;
    for (int i = 0; i < m->count; i++)
        least = real_min(least, m->points[i].gap);
    return least;
}

#endif
