/* test_hidden - contacts at what fixed shapes hide of each other: found, replaced, and never where something is deep. */
#include "collide_fixture.h"

#define FLUSH 2e-3      /* as manifold.h promises */

static const box3 everywhere = {{-10, -10, -10}, {10, 10, 10}};

static Beside beside(const Shape *s, vec3 at) { return (Beside){s, {at, quat_identity()}, everywhere}; }

/* The contact of a fixed shape with a box, both with and without the one beside; returns whether it was changed. */
static bool meet(const Shape *fixed, vec3 at, const Shape *box, pose box_at, const Beside *by, Manifold *plain, Manifold *seen)
{
    pose p = {at, quat_identity()};
    plain->count = 0;
    manifold_collide(fixed, p, box, box_at, 0.1, NULL, plain, NULL, 1);
    *seen = *plain;
    return manifold_uncover(fixed, p, box, box_at, 0.1, &(Neighbours){by, &(int){0}, 1}, seen);
}

TEST(over_a_flush_seam_every_normal_is_the_floors)
{
    Shape tile[2] = {fixture_box(1, 0.2, 1), fixture_box_hull(1, 0.2, 1)}, box = fixture_box(0.2, 0.1, 0.2);
    int replaced = 0;
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 400; i++) {
            pose at = {{-0.2 + 0.001 * i, 0.05 - 1e-6 * (i % 3), 0.1}, quat_exp((vec3){0, 0.2 * (i % 4), 0})};
            Beside left = beside(&tile[k], (vec3){-0.5, -0.1, 0}), right = beside(&tile[k], (vec3){0.5, -0.1, 0});
            Manifold plain, seen;
            for (int side = 0; side < 2; side++) {
                replaced += meet(&tile[k], (vec3){side ? 0.5 : -0.5, -0.1, 0}, &box, at, side ? &left : &right, &plain, &seen);
                for (int j = 0; j < seen.count; j++) {
                    CHECK_NEAR(vec3_distance(seen.normal, (vec3){0, 1, 0}), 0, 1e-12);
                    CHECK_NEAR(seen.points[j].gap, -1e-6 * (i % 3), 1e-12);
                }
            }
        }
    CHECK(replaced > 100);
    shape_free(&tile[0]);
    shape_free(&tile[1]);
    shape_free(&box);
}

TEST(a_step_is_met_as_it_was)
{
    Shape tile = fixture_box(1, 0.2, 1), box = fixture_box(0.2, 0.1, 0.2);
    for (int i = 0; i < 100; i++) {
        pose at = {{-0.15 + 0.0006 * i, 0.05, 0.1}, quat_exp((vec3){0, 0.2 * (i % 4), i % 5 == 0 ? -0.1 : 0})};
        Beside left = beside(&tile, (vec3){-0.5, -0.1, 0});
        Manifold plain, seen;
        CHECK(!meet(&tile, (vec3){0.5, -0.09, 0}, &box, at, &left, &plain, &seen));
        CHECK_INT(seen.count, plain.count);
    }
    shape_free(&tile);
    shape_free(&box);
}

/* Fixed boxes that cross anyhow: only what hardly overlaps may lose its contact or get another. */
TEST(nothing_deep_is_hidden)
{
    Random r = {7};
    int changed = 0;
    for (int i = 0; i < 4000; i++) {
        Shape fixed = fixture_box(random_between(&r, 0.2, 1), random_between(&r, 0.2, 1), random_between(&r, 0.2, 1));
        Shape other = fixture_box(random_between(&r, 0.2, 1), random_between(&r, 0.2, 1), random_between(&r, 0.2, 1));
        Shape box = fixture_box(0.2, 0.1, 0.3);
        pose at = {random_vec3(&r, 0.6), random_turn(&r)};
        Beside by = {&other, {random_vec3(&r, 0.5), random_turn(&r)}, everywhere};
        Manifold plain, seen;
        if (meet(&fixed, vec3_zero(), &box, at, &by, &plain, &seen)) {
            real gap = shape_distance(&fixed, pose_identity(), &box, at, INFINITY, NULL, NULL, NULL);
            changed++;
            CHECK(gap >= -FLUSH * real_min(fixed.outer, box.outer) * (1 + 1e-9));
        }
        shape_free(&fixed);
        shape_free(&other);
        shape_free(&box);
    }
    CHECK(changed > 0);
}

/* Thin plates that cross: a ball just over one is not taken for something deep behind its other face. */
TEST(nothing_is_pulled_through)
{
    Random r = {11};
    Shape plate = fixture_box(0.5, 0.02, 0.9), ball = fixture_sphere(0.045);
    for (int i = 0; i < 20000; i++) {
        pose at = {{random_between(&r, -0.2, 0.2), 0.055 + random_between(&r, -1e-6, 1e-2), random_between(&r, -0.4, 0.4)}, quat_identity()};
        Beside by = {&plate, {random_vec3(&r, 0.3), random_turn(&r)}, everywhere};
        Manifold plain, seen;
        meet(&plate, vec3_zero(), &ball, at, &by, &plain, &seen);
        for (int k = 0; k < seen.count; k++)
            CHECK(seen.points[k].gap > -0.09);
    }
    shape_free(&plate);
    shape_free(&ball);
}

int main(void)
{
    RUN_TESTS(unit_test(over_a_flush_seam_every_normal_is_the_floors), unit_test(a_step_is_met_as_it_was), unit_test(nothing_deep_is_hidden),
              unit_test(nothing_is_pulled_through));
}
