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

/* A peg touches each plank of a hole up to its corners, which the planks beside have; between these the plank is bare. */
TEST(walls_of_a_hole_are_met_as_they_are)
{
    Shape plank = fixture_box(0.1, 0.4, 0.3), end = fixture_box(0.1, 0.4, 0.1), peg = fixture_box(0.1, 0.4, 0.1);
    for (int i = 0; i < 40; i++) {
        real clearance = 1e-5 * (i % 8), rise = 1e-3 * (i / 8);
        Beside by[2];
        for (int k = 0; k < 2; k++)
            by[k] = beside(&end, (vec3){0, 0.2, k ? -0.1 : 0.1});
        pose at = {{clearance, 0.2 + rise, 0}, quat_identity()}, p = {{-0.1, 0.2, 0}, quat_identity()};
        Manifold plain = {.count = 0}, seen;
        manifold_collide(&plank, p, &peg, at, 0.1, NULL, &plain, NULL, 1);
        seen = plain;
        CHECK_INT(plain.count, 4);
        CHECK(!manifold_uncover(&plank, p, &peg, at, 0.1, &(Neighbours){by, (int[]){0, 1}, 2}, &seen));
    }
    shape_free(&plank);
    shape_free(&end);
    shape_free(&peg);
}

/* Nor does the front of a wall throw out a brick that touches the next but one along an edge. */
TEST(a_brick_in_a_wall_is_not_thrown_out)
{
    Shape brick = fixture_box(0.2, 0.1, 0.1);
    Beside by[3] = {beside(&brick, (vec3){-0.2, 0, 0}), beside(&brick, (vec3){0, -0.1, 0}), beside(&brick, (vec3){-0.2, 0.1, 0})};
    for (int i = 0; i < 20; i++) {
        pose at = {{1e-9 * (i % 4), 0, -1e-4 * i}, quat_identity()}, p = {{-0.2, -0.1, 0}, quat_identity()};
        Manifold seen = {.count = 0};
        manifold_collide(&brick, p, &brick, at, 0.1, NULL, &seen, NULL, 1);
        manifold_uncover(&brick, p, &brick, at, 0.1, &(Neighbours){by, (int[]){0, 1, 2}, 3}, &seen);
        for (int k = 0; k < seen.count; k++)
            CHECK(seen.points[k].gap > -1e-6);
    }
    shape_free(&brick);
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
    RUN_TESTS(unit_test(over_a_flush_seam_every_normal_is_the_floors), unit_test(a_step_is_met_as_it_was),
              unit_test(walls_of_a_hole_are_met_as_they_are), unit_test(a_brick_in_a_wall_is_not_thrown_out), unit_test(nothing_deep_is_hidden),
              unit_test(nothing_is_pulled_through));
}
