/* test_distance - signed distances: closed forms, needles and far shapes, GJK and EPA against separating axes. */
#include "collide_fixture.h"

#include "geom/pair.h"

static real distance(const Shape *a, pose pa, const Shape *b, pose pb)
{
    return shape_distance(a, pa, b, pb, INFINITY, NULL, NULL, NULL);
}

/* Apart no axis separates by more than the distance; overlapping boxes are as deep as the best axis says (Gottschalk 1996). */
TEST(boxes_agree_with_their_separating_axes)
{
    Random r = {1};
    int apart = 0, overlapping = 0;
    for (int i = 0; i < 20000; i++) {
        Shape a = fixture_box(random_between(&r, 0.2, 2), random_between(&r, 0.2, 2), random_between(&r, 0.2, 2));
        Shape b = fixture_box(random_between(&r, 0.2, 2), random_between(&r, 0.2, 2), random_between(&r, 0.2, 2));
        pose pa = {random_vec3(&r, 1), random_turn(&r)}, pb = {random_vec3(&r, 1.5), random_turn(&r)};
        Pair p = pair_make(&a, pa, &b, pb);
        vec3 n, on_a, on_b;
        real axes = box_separation(&p), d = shape_distance(&a, pa, &b, pb, INFINITY, &n, &on_a, &on_b);
        CHECK_NEAR(distance(&b, pb, &a, pa), d, 1e-13);
        CHECK_NEAR(vec3_dot(vec3_sub(on_b, on_a), n), d, 1e-13);
        if (d > 0) {
            CHECK(axes > -1e-13 && axes <= d + 1e-13);
            CHECK_NEAR(vec3_distance(on_a, on_b), d, 1e-13);
            CHECK(a.type->contains(&a, vec3_scale(1 - 1e-12, pose_unpoint(pa, on_a))));
            CHECK(b.type->contains(&b, vec3_scale(1 - 1e-12, pose_unpoint(pb, on_b))));
            apart++;
        } else {
            CHECK_NEAR(d, axes, 1e-13);
            overlapping++;
        }
        shape_free(&a);
        shape_free(&b);
    }
    CHECK(apart > 5000 && overlapping > 5000);
}

static bool looks_along(mat3 axes, vec3 n, real within)
{
    vec3 local = vec3_abs(mat3_mul_vec(mat3_transpose(axes), n));
    return vec3_largest(local) > 1 - within;
}

/* Where two edges cross, the normal of the step before is enough: nothing is searched for, and the gap is the exact one. */
TEST(crossing_edges_are_found_from_the_last_normal)
{
    Random r = {3};
    int crossing[2] = {0, 0}, settled[2] = {0, 0};
    for (int i = 0; i < 20000; i++) {
        Shape a = fixture_box(random_between(&r, 0.5, 1), random_between(&r, 0.5, 1), random_between(&r, 0.5, 1));
        Shape b = i % 2 ? fixture_box(random_between(&r, 0.5, 1), random_between(&r, 0.5, 1), random_between(&r, 0.5, 1))
                        : fixture_capsule(0.1, random_between(&r, 0.5, 1));
        Pair p = pair_make(&a, (pose){random_vec3(&r, 1), random_turn(&r)}, &b, (pose){random_vec3(&r, 1.2), random_turn(&r)});
        ConvexGap exact, got;
        vec3 none = vec3_zero();
        convex_gap(&p.c, INFINITY, &none, &exact);
        vec3 guess = vec3_unit(vec3_add(exact.normal, random_vec3(&r, 3e-3)));
        bool found = patch_gap(&p.c, guess, INFINITY, &got), near = fabs(exact.gap) < 0.1;
        if (found) {
            CHECK_NEAR(got.gap, exact.gap, 1e-12);
            CHECK_NEAR(vec3_dot(vec3_sub(got.on_b, got.on_a), got.normal), got.gap, 1e-12);
        }
        bool edge_of_b = i % 2 ? !looks_along(p.c.turn, exact.normal, 0.01) : fabs(vec3_dot(p.c.back.r1, exact.normal)) < 1e-9;
        if (near && edge_of_b && !looks_along(mat3_identity(), exact.normal, 0.01)) {
            crossing[i % 2]++;
            settled[i % 2] += found;
        }
        shape_free(&a);
        shape_free(&b);
    }
    for (int k = 0; k < 2; k++)
        CHECK(crossing[k] > 200 && settled[k] > 0.9 * crossing[k]);
}

/* Moved apart by its depth along the normal, a pair just touches. */
TEST(moving_by_the_depth_makes_contact_end)
{
    Random r = {2};
    for (int i = 0; i < 3000; i++) {
        vec3 points[2][16];
        for (int k = 0; k < 32; k++)
            points[k / 16][k % 16] = random_vec3(&r, 0.7);
        Shape a = fixture_hull(points[0], 16), b = i % 2 ? fixture_hull(points[1], 16) : fixture_cylinder(random_between(&r, 0.3, 0.8), 1);
        pose pa = {vec3_zero(), random_turn(&r)}, pb = {random_vec3(&r, 0.4), random_turn(&r)};
        vec3 n;
        real d = shape_distance(&a, pa, &b, pb, INFINITY, &n, NULL, NULL);
        if (d < 0) {
            pb.p = vec3_mad(pb.p, -d, n);
            CHECK_NEAR(distance(&a, pa, &b, pb), 0, i % 2 ? 1e-12 : 1e-8);     /* round sides: to 1e-9 of the size */
        }
        shape_free(&a);
        shape_free(&b);
    }
}

TEST(capsules_and_spheres_have_segment_distances)
{
    Random r = {3};
    for (int i = 0; i < 2000; i++) {
        Shape a = fixture_capsule(0.1, random_between(&r, 0.1, 2)), b = fixture_capsule(0.2, random_between(&r, 0.1, 2));
        pose pa = {random_vec3(&r, 1), random_turn(&r)}, pb = {random_vec3(&r, 1.5), random_turn(&r)};
        vec3 ha = quat_rotate(pa.q, (vec3){0, ((const CapsuleData *)a.data)->half, 0});
        vec3 hb = quat_rotate(pb.q, (vec3){0, ((const CapsuleData *)b.data)->half, 0});
        real least = INFINITY;
        for (int s = 0; s <= 400; s++) {            /* nearest point of the second segment to points along the first */
            vec3 p = vec3_mad(pa.p, s / 200.0 - 1, ha);
            real t = real_clamp(vec3_dot(vec3_sub(p, pb.p), hb) / vec3_length2(hb), -1, 1);
            least = real_min(least, vec3_distance(p, vec3_mad(pb.p, t, hb)));
        }
        real d = distance(&a, pa, &b, pb) + 0.3;
        CHECK(d <= least + 1e-12);
        CHECK_NEAR(d * d, least * least, 2 * 0.005 * 0.005 + 1e-12);        /* samples lie 5 mm apart: off by half of it at most */
        shape_free(&a);
        shape_free(&b);
    }
}

/* Two needles 1e-4 thin and 100 m long cross at right angles 1 m apart; and as hulls. */
TEST(needles_and_plates_keep_their_digits)
{
    Shape along = fixture_box(100, 1e-4, 1e-4), across = fixture_box(1e-4, 1e-4, 100), needle = fixture_box_hull(100, 1e-4, 1e-4);
    Shape plate = fixture_box_hull(50, 1e-4, 50);
    CHECK_NEAR(distance(&along, pose_identity(), &across, at_point(3, 1, 2)), 1 - 1e-4, 1e-13);
    CHECK_NEAR(distance(&needle, pose_identity(), &across, at_point(3, 1, 2)), 1 - 1e-4, 1e-13);
    CHECK_NEAR(distance(&needle, pose_identity(), &plate, at_point(3, 0.5, 2)), 0.5 - 1e-4, 1e-13);
    CHECK_NEAR(distance(&plate, pose_identity(), &plate, at_point(3, 1e-4 + 1e-7, 2)), 1e-7, 1e-13);
    CHECK_NEAR(distance(&needle, pose_identity(), &plate, at_point(3, 0.9e-4, 2)), -1e-5, 1e-13);
    Random r = {4};
    for (int i = 0; i < 500; i++) {                     /* tilted needle over a plate: its lower end counts */
        real tilt = random_between(&r, -0.02, 0.02);
        quat q = quat_axis_angle((vec3){0, 0, 1}, tilt);
        real want = 3 - 0.5e-4 - 10 * sin(fabs(tilt)) - 0.5e-4 * cos(tilt);
        Shape short_needle = fixture_box_hull(20, 1e-4, 1e-4);
        CHECK_NEAR(distance(&plate, pose_identity(), &short_needle, (pose){{1, 3, 1}, q}), want, 1e-13);
        shape_free(&short_needle);
    }
    shape_free(&along);
    shape_free(&across);
    shape_free(&needle);
    shape_free(&plate);
}

TEST(far_shapes_have_exact_distances)
{
    Shape a = fixture_box_hull(1, 2, 3), b = fixture_cylinder(0.5, 1), c = fixture_cone(0.5, 1);
    CHECK_NEAR(distance(&a, pose_identity(), &a, at_point(3e4, 4e4, 0.5)), hypot(3e4 - 1, 4e4 - 2), 1e-12 * 5e4);
    CHECK_NEAR(distance(&a, pose_identity(), &b, at_point(1e5, 0, 0)), 1e5 - 1, 1e-12 * 1e5);
    CHECK_NEAR(distance(&b, pose_identity(), &c, at_point(0, 1e4, 0)), 1e4 - 0.75, 1e-12 * 1e4);
    shape_free(&a);
    shape_free(&b);
    shape_free(&c);
}

/* Gaps from 1e-3 down to rounding, on both sides of contact. */
TEST(small_gaps_and_depths_are_exact)
{
    Shape box = fixture_box(1, 1, 1), hull = fixture_box_hull(1, 1, 1), cylinder = fixture_cylinder(0.5, 1);
    Random r = {5};
    for (int i = 0; i < 400; i++) {
        real gap = pow(10, -random_between(&r, 3, 16)) * (i % 2 ? -1 : 1);
        quat turn = quat_axis_angle((vec3){0, 1, 0}, random_between(&r, 0, 3));
        pose over = {{random_between(&r, -0.4, 0.4), 1 + gap, random_between(&r, -0.4, 0.4)}, turn};
        vec3 n;
        CHECK_NEAR(shape_distance(&box, pose_identity(), &hull, over, INFINITY, &n, NULL, NULL), gap, 1e-15);
        CHECK_NEAR(n.y, 1, 1e-15);
        CHECK_NEAR(shape_distance(&box, pose_identity(), &cylinder, over, INFINITY, &n, NULL, NULL), gap, 1e-15);
        CHECK_NEAR(n.y, 1, 1e-12);
        pose edge = {{0, 0.5 + sqrt(0.5) + gap, 0}, quat_axis_angle((vec3){0, 0, 1}, DIG_PI / 4)};      /* an edge on the top face */
        CHECK_NEAR(shape_distance(&hull, pose_identity(), &box, edge, INFINITY, &n, NULL, NULL), gap, 1e-15);
        CHECK_NEAR(n.y, 1, 1e-9);
    }
    shape_free(&box);
    shape_free(&hull);
    shape_free(&cylinder);
}

TEST(enough_stops_early_but_never_lies)
{
    Random r = {6};
    Shape a = fixture_box_hull(1, 1, 1), b = fixture_cylinder(0.5, 1);
    for (int i = 0; i < 2000; i++) {
        pose pb = {random_vec3(&r, 3), random_turn(&r)};
        real exact = distance(&a, pose_identity(), &b, pb), enough = random_between(&r, 0, 2);
        real got = shape_distance(&a, pose_identity(), &b, pb, enough, NULL, NULL, NULL);
        if (exact > enough)
            CHECK(got > enough - 1e-12 && got <= exact + 1e-12);
        else
            CHECK_NEAR(got, exact, 1e-9);
    }
    shape_free(&a);
    shape_free(&b);
}

/* A cylinder's rim and side against a box by sampling its surface densely: the least support plane of all directions. */
TEST(round_depths_equal_the_least_support_distance)
{
    Random r = {7};
    for (int i = 0; i < 40; i++) {
        Shape a = fixture_cylinder(random_between(&r, 0.3, 0.8), random_between(&r, 0.3, 1.5));
        Shape b = i % 2 ? fixture_cone(random_between(&r, 0.3, 0.8), random_between(&r, 0.3, 1.5)) : fixture_box(1, 0.6, 0.8);
        pose pa = {vec3_zero(), random_turn(&r)}, pb = {random_vec3(&r, 0.7), random_turn(&r)};
        Pair p = pair_make(&a, pa, &b, pb);
        real d = distance(&a, pa, &b, pb), best = -INFINITY;
        for (int k = 0; k < 40000; k++) {           /* Fibonacci directions on the sphere */
            real y = 1 - (2 * k + 1) / 40000.0, rho = sqrt(1 - y * y), angle = 2.399963229728653 * k;
            vec3 n = {rho * cos(angle), y, rho * sin(angle)};
            best = real_max(best, vec3_dot(n, vec3_sub(convex_support_b(&p.c, vec3_neg(n)), convex_support_a(&p.c, n))));
        }
        CHECK(d >= best - 1e-12);
        CHECK_NEAR(d, best, 0.02);                  /* directions lie about 0.02 rad apart, supports up to 1 m across */
        shape_free(&a);
        shape_free(&b);
    }
}

/* The gap is the greatest distance of support planes: tilting the normal found must never show a greater one. */
TEST(no_tilted_support_plane_shows_less_depth)
{
    Random r = {8};
    int inexact = 0;
    for (int i = 0; i < 400; i++) {
        real most = -INFINITY;
        Shape a = fixture_cylinder(random_between(&r, 0.3, 0.8), random_between(&r, 0.3, 1.5));
        Shape b = i % 3 == 0   ? fixture_cone(random_between(&r, 0.3, 0.8), random_between(&r, 0.3, 1.5))
                  : i % 3 == 1 ? fixture_cylinder(random_between(&r, 0.3, 0.8), 0.2)
                               : fixture_box(1, 0.6, 0.8);
        pose pb = {random_vec3(&r, 1.2), random_turn(&r)};
        Pair p = pair_make(&a, pose_identity(), &b, pb);
        vec3 n;
        real d = shape_distance(&a, pose_identity(), &b, pb, INFINITY, &n, NULL, NULL);
        for (int k = 0; k < 200; k++) {
            vec3 m = vec3_unit(vec3_mad(n, pow(10, -random_between(&r, 2, 9)), random_direction(&r)));
            real shown = vec3_dot(m, vec3_sub(convex_support_b(&p.c, vec3_neg(m)), convex_support_a(&p.c, m)));
            most = real_max(most, shown);
        }
        CHECK(most <= d + 1e-8);
        inexact += most > d + 1e-13;
        shape_free(&a);
        shape_free(&b);
    }
    CHECK(inexact <= 2);                        /* two round sides, deep in each other, now and then keep 1e-9 of their size */
}

int main(void)
{
    RUN_TESTS(unit_test(boxes_agree_with_their_separating_axes), unit_test(crossing_edges_are_found_from_the_last_normal),
              unit_test(moving_by_the_depth_makes_contact_end),
              unit_test(capsules_and_spheres_have_segment_distances), unit_test(needles_and_plates_keep_their_digits),
              unit_test(far_shapes_have_exact_distances), unit_test(small_gaps_and_depths_are_exact),
              unit_test(enough_stops_early_but_never_lies),
              unit_test(round_depths_equal_the_least_support_distance), unit_test(no_tilted_support_plane_shows_less_depth));
}
