/* test_cast - the ray, the capped cylinder and the arc: where they agree, and what only the arc meets. */
#include "collide_fixture.h"

#include "geom/cast.h"

/* Thrown from the origin at 45 degrees, back at y = 0 after 2 v / g; a bar across the path at the top of the arc. */
TEST(only_the_arc_meets_a_bar_that_the_straight_line_misses)
{
    real g = 9.81, v = 10, time = 2 * v / g, top = v * v / (2 * g), radius = 0.05, half = 0.01;
    Shape bar = fixture_box(2 * half, 2 * half, 2);
    pose at = at_point(v * v / g, top, 0);
    vec3 velocity = {v, v, 0}, straight = {v, 0, 0};        /* the line from start to end runs along x */
    CastHit hit;
    CHECK(!cast_ray(&bar, at, vec3_zero(), straight, time, &hit));
    CHECK(!cast_capped_cylinder(&bar, at, vec3_zero(), radius, straight, time, &hit));
    CHECK(cast_arc(&bar, at, vec3_zero(), radius, velocity, (vec3){0, -g, 0}, time, &hit));

    /* the ball touches the bar's upright side x = X - half where |y - top| <= half: there x = X - half - radius */
    real want = (v * v / g - half - radius) / v;
    real y = v * want - 0.5 * g * want * want;
    CHECK(fabs(y - top) < half);
    CHECK_NEAR(hit.t, want, 1e-12);
    CHECK_NEAR(hit.normal.x, -1, 1e-12);
    CHECK_NEAR(hit.point.y, y, 1e-12);
    shape_free(&bar);
}

TEST(a_bullet_meets_a_thin_plate_by_all_three)
{
    Shape plate = fixture_box(0.005, 1, 1);
    pose at = {{2, 0, 0}, quat_identity()};
    real radius = 0.004, face = 2 - 0.0025;
    vec3 v = {300, 0, 0};
    CastHit hit;
    CHECK(cast_ray(&plate, at, vec3_zero(), v, 1.0 / 60, &hit));
    CHECK_NEAR(hit.t, face / 300, 1e-15);
    CHECK_NEAR(hit.point.x, face, 1e-12);
    CHECK_NEAR(hit.normal.x, -1, 1e-15);
    CHECK(cast_capped_cylinder(&plate, at, vec3_zero(), radius, v, 1.0 / 60, &hit));
    CHECK_NEAR(hit.t, (face - radius) / 300, 1e-15);
    CHECK(cast_arc(&plate, at, vec3_zero(), radius, v, (vec3){0, -9.81, 0}, 1.0 / 60, &hit));
    CHECK_NEAR(hit.t, (face - radius) / 300, 1e-15);
    CHECK(!cast_ray(&plate, at, vec3_zero(), v, 0.9 * face / 300, &hit));
    CHECK(!cast_arc(&plate, at, vec3_zero(), radius, (vec3){-300, 0, 0}, vec3_zero(), 1.0 / 60, &hit));
    shape_free(&plate);
}

/* Passing beside an edge: the ray misses by less than the radius, so only the swept ball meets it. */
TEST(the_capped_cylinder_meets_what_the_ray_misses)
{
    Shape box = fixture_box(1, 1, 1), sphere = fixture_sphere(0.5);
    CastHit hit;
    vec3 from = {-3, 0.53, 0}, v = {2, 0, 0};
    CHECK(!cast_ray(&box, pose_identity(), from, v, 10, &hit));
    CHECK(!cast_ray(&sphere, pose_identity(), from, v, 10, &hit));
    CHECK(cast_capped_cylinder(&box, pose_identity(), from, 0.05, v, 10, &hit));
    CHECK_NEAR(hit.t, (2.5 - 0.04) / 2, 1e-12);             /* centre 0.03 above the edge, so 0.04 before it */
    CHECK_NEAR(hit.normal.y, 0.6, 1e-10);
    CHECK(cast_capped_cylinder(&sphere, pose_identity(), from, 0.05, v, 10, &hit));
    CHECK_NEAR(hit.t, (3 - sqrt(0.55 * 0.55 - 0.53 * 0.53)) / 2, 1e-10);
    shape_free(&box);
    shape_free(&sphere);
}

TEST(a_cast_that_starts_inside_hits_at_once)
{
    Shape box = fixture_box(1, 1, 1);
    CastHit hit;
    CHECK(cast_arc(&box, pose_identity(), (vec3){0.4, 0, 0}, 0.05, (vec3){1, 0, 0}, vec3_zero(), 1, &hit));
    CHECK_NEAR(hit.t, 0, 0);
    CHECK_NEAR(hit.normal.x, 1, 1e-12);
    shape_free(&box);
}

TEST(casts_meet_planes_hulls_and_height_fields)
{
    real heights[9] = {0};
    Shape plane = fixture_plane((vec3){0, 1, 0}, 0), hull = fixture_box_hull(2, 2, 2);
    Shape field = fixture_make("heightfield", &(dig_heightfield_def){.heights = heights, .columns = 3, .rows = 3, .size = {4, 0, 4}});
    const Shape *all[3] = {&plane, &hull, &field};
    for (int i = 0; i < 3; i++) {
        CastHit hit;
        vec3 from = {0.3, 3, 0.2}, v = {0, -4, 0};
        pose at = at_point(0, i == 1 ? -1 : 0, 0);
        CHECK(cast_ray(all[i], at, from, v, 2, &hit));
        CHECK_NEAR(hit.t, 0.75, 1e-14);
        CHECK(cast_capped_cylinder(all[i], at, from, 0.2, v, 2, &hit));
        CHECK_NEAR(hit.t, 0.7, 1e-13);
        CHECK(cast_arc(all[i], at, from, 0.2, v, (vec3){0, -10, 0}, 2, &hit));
        CHECK_NEAR(hit.t, (sqrt(16 + 56) - 4) / 10, 1e-13);
        CHECK_NEAR(hit.normal.y, 1, 1e-13);
    }
    shape_free(&plane);
    shape_free(&hull);
    shape_free(&field);
}

typedef struct Fall { real h0, r, g; } Fall;

static real fall_gap(void *context, real t)
{
    const Fall *f = context;
    return f->h0 - 0.5 * f->g * t * t - f->r;
}

TEST(twenty_bisections_leave_a_millionth_of_the_step)
{
    Fall f = {.h0 = 2, .r = 0.5, .g = 9.81};
    real want = sqrt(2 * (f.h0 - f.r) / f.g), h = 1.0 / 60, lo = floor(want / h) * h;
    real t = bisect_impact(fall_gap, &f, lo, lo + h, 20);
    CHECK(fabs(t - want) > 0);                              /* bisection is not exact */
    CHECK_NEAR(t, want, h * 0x1p-20);
    CHECK_NEAR(bisect_impact(fall_gap, &f, 0, 1, 10), want, 0x1p-10);
}

int main(void)
{
    RUN_TESTS(unit_test(only_the_arc_meets_a_bar_that_the_straight_line_misses), unit_test(a_bullet_meets_a_thin_plate_by_all_three),
              unit_test(the_capped_cylinder_meets_what_the_ray_misses), unit_test(a_cast_that_starts_inside_hits_at_once),
              unit_test(casts_meet_planes_hulls_and_height_fields), unit_test(twenty_bisections_leave_a_millionth_of_the_step));
}
