/* test_collide - manifolds: closed forms, resting contacts, features, symmetry, agreement of independent ways. */
#include "collide_fixture.h"

#include "geom/pair.h"

static int collide(const Shape *a, pose pa, const Shape *b, pose pb, real reach, Manifold *m)
{
    uint32_t piece;
    return manifold_collide(a, pa, b, pb, reach, NULL, m, &piece, 1);
}

static void check_direction(vec3 got, vec3 want, real tolerance)
{
    CHECK_NEAR(got.x, want.x, tolerance);
    CHECK_NEAR(got.y, want.y, tolerance);
    CHECK_NEAR(got.z, want.z, tolerance);
}

TEST(spheres_touch_on_the_line_of_centres)
{
    Shape a = fixture_sphere(0.5), b = fixture_sphere(0.25);
    Manifold m;
    CHECK_INT(collide(&a, at_point(1, 2, 3), &b, at_point(1.3, 2.4, 3), 0.1, &m), 1);     /* centres 0.5 apart */
    CHECK_INT(m.count, 1);
    CHECK_NEAR(m.points[0].gap, 0.5 - 0.75, 1e-15);
    check_direction(m.normal, (vec3){0.6, 0.8, 0}, 1e-15);
    check_direction(m.points[0].a, (vec3){1.3, 2.4, 3}, 1e-14);
    CHECK_INT(collide(&a, at_point(0, 0, 0), &b, at_point(0, 0.86, 0), 0.1, &m), 0);
    CHECK_INT(collide(&a, at_point(0, 0, 0), &b, at_point(0, 0.84, 0), 0.1, &m), 1);
    CHECK_NEAR(m.points[0].gap, 0.09, 1e-15);
    shape_free(&a);
    shape_free(&b);
}

/* Resting on the top of a box, and on its edge at 45 degrees. */
TEST(a_sphere_meets_a_box_at_face_edge_and_from_inside)
{
    Shape box = fixture_box(2, 2, 2), ball = fixture_sphere(0.5);
    Manifold m;
    CHECK_INT(collide(&box, at_point(0, 0, 0), &ball, at_point(0.3, 1.5, 0.2), 0, &m), 1);
    CHECK_NEAR(m.points[0].gap, 0, 1e-16);
    check_direction(m.normal, (vec3){0, 1, 0}, 0);
    CHECK_INT(collide(&box, at_point(0, 0, 0), &ball, at_point(1.3, 1.4, 0), 0, &m), 1);
    CHECK_NEAR(m.points[0].gap, 0, 1e-15);
    check_direction(m.normal, (vec3){0.6, 0.8, 0}, 1e-15);
    CHECK_INT(collide(&box, at_point(0, 0, 0), &ball, at_point(0.9, 0, 0), 0, &m), 1);
    CHECK_NEAR(m.points[0].gap, -0.6, 1e-15);
    check_direction(m.normal, (vec3){1, 0, 0}, 0);
    shape_free(&box);
    shape_free(&ball);
}

static real point_cone(real rho, real y, real radius, real height)      /* distance to the solid cone, base at y = 0, by sampling */
{
    real least = INFINITY;
    for (int i = 0; i <= 20000; i++) {
        real t = i / 20000.0;
        least = real_min(least, hypot(rho - radius * t, y - height * (1 - t)));
        least = real_min(least, hypot(rho - radius * t, y));
    }
    return least;
}

TEST(spheres_near_cones_and_cylinders_have_sampled_distances)
{
    Random r = {3};
    for (int i = 0; i < 200; i++) {
        real radius = random_between(&r, 0.2, 1), height = random_between(&r, 0.2, 2);
        Shape cone = fixture_cone(radius, height), cylinder = fixture_cylinder(radius, height), ball = fixture_sphere(0.1);
        real angle = random_between(&r, -DIG_PI, DIG_PI), rho = random_between(&r, 0, 2), y = random_between(&r, -2, 2);
        pose at = {{rho * cos(angle), y, rho * sin(angle)}, quat_identity()};
        real got = shape_distance(&cone, pose_identity(), &ball, at, INFINITY, NULL, NULL, NULL);
        if (got > -0.1)
            CHECK_NEAR(got, point_cone(rho, y + 0.25 * height, radius, height) - 0.1, 2e-7);
        real side = real_max(rho - radius, 0), end = real_max(fabs(y) - 0.5 * height, 0);
        got = shape_distance(&cylinder, pose_identity(), &ball, at, INFINITY, NULL, NULL, NULL);
        if (side > 0 || end > 0)
            CHECK_NEAR(got, hypot(side, end) - 0.1, 1e-15);
        else
            CHECK_NEAR(got, real_max(rho - radius, fabs(y) - 0.5 * height) - 0.1, 1e-15);
        shape_free(&cone);
        shape_free(&cylinder);
        shape_free(&ball);
    }
}

static bool same_features(const Manifold *a, const Manifold *b)
{
    for (int i = 0; i < a->count; i++)
        if (a->points[i].feature != b->points[i].feature)
            return false;
    return a->count == b->count;
}

/* Flush, overhanging and turned stacks: the normal is exactly the face's and the same four points stay through rounding. */
TEST(a_box_resting_on_a_box_keeps_its_normal_and_points)
{
    Shape low = fixture_box(1, 1, 1), high = fixture_box(1, 1, 1), hull = fixture_box_hull(1, 1, 1);
    Random r = {4};
    for (int i = 0; i < 100; i++) {
        quat turn = i % 2 ? quat_axis_angle((vec3){0, 1, 0}, random_between(&r, 0, 1.5)) : quat_identity();
        pose at = {{i % 3 ? random_between(&r, -0.6, 0.6) : 0, 1, i % 3 ? random_between(&r, -0.6, 0.6) : 0}, turn};
        Manifold first, m;
        for (int k = 0; k < 2; k++) {
            const Shape *top = k ? &hull : &high;
            CHECK_INT(collide(&low, pose_identity(), top, at, 0.01, &first), 1);
            CHECK_INT(first.count, 4);
            check_direction(first.normal, (vec3){0, 1, 0}, 1e-15);
            for (int step = 0; step < 50; step++) {
                pose shaken = at;
                shaken.p = vec3_add(at.p, vec3_mul((vec3){1e-11, 1e-13, 1e-11}, random_vec3(&r, 1)));
                shaken.q = quat_mul(quat_exp(random_vec3(&r, 1e-13)), at.q);
                CHECK_INT(collide(&low, pose_identity(), top, shaken, 0.01, &m), 1);
                CHECK(same_features(&first, &m));
                check_direction(m.normal, (vec3){0, 1, 0}, 2e-13);
                for (int n = 0; n < m.count; n++)
                    CHECK_NEAR(m.points[n].gap, 0, 5e-13);
            }
        }
    }
    shape_free(&low);
    shape_free(&high);
    shape_free(&hull);
}

/* Edges that cross at a small angle separate as well as the faces, but their cross product has few digits. */
TEST(a_slightly_turned_box_rests_on_the_face_not_on_edges)
{
    Shape low = fixture_box(1, 1, 1), high = fixture_box(1, 1, 1);
    for (real angle = 1e-7; angle < 0.1; angle *= 1.3) {
        Manifold m;
        CHECK_INT(collide(&low, pose_identity(), &high, (pose){{0.1, 1, 0.2}, quat_axis_angle((vec3){0, 1, 0}, angle)}, 0.01, &m), 1);
        check_direction(m.normal, (vec3){0, 1, 0}, 1e-16);
        CHECK_INT(m.count, 4);
    }
    shape_free(&low);
    shape_free(&high);
}

TEST(a_hovering_box_gets_its_four_corners)
{
    Shape floor = fixture_box(10, 1, 10), box = fixture_box(1, 2, 3), plane = fixture_plane((vec3){0, 1, 0}, 0.5);
    pose at = {{0.3, 1.5 + 0.004, 0.1}, quat_axis_angle((vec3){0, 1, 0}, 0.7)};
    Manifold m;
    for (int k = 0; k < 2; k++) {
        CHECK_INT(collide(k ? &plane : &floor, pose_identity(), &box, at, 0.01, &m), 1);
        CHECK_INT(m.count, 4);
        check_direction(m.normal, (vec3){0, 1, 0}, 0);
        for (int i = 0; i < 4; i++) {
            CHECK_NEAR(m.points[i].gap, 0.004, 1e-15);
            vec3 local = pose_unpoint(at, m.points[i].b);
            CHECK_NEAR(fabs(local.x), 0.5, 1e-14);
            CHECK_NEAR(fabs(local.z), 1.5, 1e-14);
            CHECK_NEAR(local.y, -1, 1e-14);
            CHECK_NEAR(m.points[i].a.y, 0.5, 1e-15);
        }
        at.p.y = 1.52;
        CHECK_INT(collide(k ? &plane : &floor, pose_identity(), &box, at, 0.01, &m), 0);
        at.p.y = 1.504;
    }
    shape_free(&floor);
    shape_free(&box);
    shape_free(&plane);
}

static real quad_area(const Manifold *m)        /* points in order around */
{
    vec3 d = vec3_sub(m->points[2].b, m->points[0].b), e = vec3_sub(m->points[3].b, m->points[1].b);
    return 0.5 * fabs(vec3_dot(m->normal, vec3_cross(d, e)));
}

/* Two unit squares turned by 45 degrees overlap in a regular octagon of inradius 1/2; the largest quadrilateral on four of its
 * corners is the square on every second one, of half diagonal 1 / (2 cos(pi/8)). */
TEST(four_of_eight_points_span_the_largest_area)
{
    Shape low = fixture_box(1, 1, 1), high = fixture_box(1, 1, 1);
    pose at = {{0, 1, 0}, quat_axis_angle((vec3){0, 1, 0}, DIG_PI / 4)};
    real corner = 0.5 / cos(DIG_PI / 8);
    Manifold m;
    CHECK_INT(collide(&low, pose_identity(), &high, at, 0.01, &m), 1);
    CHECK_INT(m.count, 4);
    CHECK_NEAR(quad_area(&m), 2 * corner * corner, 1e-14);
    shape_free(&low);
    shape_free(&high);
}

TEST(the_deepest_point_is_always_kept)
{
    Shape low = fixture_box(1, 1, 1), high = fixture_box(1, 1, 1);
    Random r = {6};
    for (int i = 0; i < 2000; i++) {
        vec3 tilt = vec3_scale(random_between(&r, 0, 0.05), random_direction(&r));
        pose at = {{0, 1, 0}, quat_mul(quat_exp(tilt), quat_axis_angle((vec3){0, 1, 0}, random_between(&r, 0.3, 1.2)))};
        Manifold m;
        CHECK_INT(collide(&low, pose_identity(), &high, at, 0.2, &m), 1);
        Pair p = pair_make(&low, pose_identity(), &high, at);
        real depth = box_separation(&p);
        CHECK(depth < 1e-12);
        CHECK_NEAR(deepest_gap(&m), depth, 1e-8);       /* faces are preferred to edges by 1e-6 of the size */
    }
    shape_free(&low);
    shape_free(&high);
}

TEST(crossed_edges_touch_in_one_point)
{
    Shape a = fixture_box(1, 1, 1), b = fixture_box(1, 1, 1);
    pose pa = {{0, 0, 0}, quat_axis_angle((vec3){0, 0, 1}, DIG_PI / 4)};                /* an edge along z on top   */
    pose pb = {{0, sqrt(2.0) - 0.01, 0}, quat_axis_angle((vec3){1, 0, 0}, DIG_PI / 4)}; /* an edge along x below    */
    Manifold m;
    CHECK_INT(collide(&a, pa, &b, pb, 0, &m), 1);
    CHECK_INT(m.count, 1);
    CHECK_NEAR(m.points[0].gap, -0.01, 1e-15);
    check_direction(m.normal, (vec3){0, 1, 0}, 1e-15);
    check_direction(m.points[0].a, (vec3){0, sqrt(0.5), 0}, 1e-15);
    shape_free(&a);
    shape_free(&b);
}

TEST(a_lying_capsule_has_two_points_and_a_steep_one_has_one)
{
    Shape floor = fixture_box(10, 1, 10), plane = fixture_plane((vec3){0, 1, 0}, 0.5), capsule = fixture_capsule(0.25, 1);
    pose lying = {{0, 0.75, 0}, quat_axis_angle((vec3){0, 0, 1}, DIG_PI / 2)}, steep = {{0, 1.2, 0}, quat_axis_angle((vec3){0, 0, 1}, 0.3)};
    Manifold m;
    for (int k = 0; k < 2; k++) {
        CHECK_INT(collide(k ? &plane : &floor, pose_identity(), &capsule, lying, 0.01, &m), 1);
        CHECK_INT(m.count, 2);
        for (int i = 0; i < 2; i++) {
            CHECK_NEAR(m.points[i].gap, 0, 1e-15);
            CHECK_NEAR(fabs(m.points[i].b.x), 0.5, 1e-15);
        }
        CHECK_INT(collide(k ? &plane : &floor, pose_identity(), &capsule, steep, 0.1, &m), 1);
        CHECK_INT(m.count, 1);
        CHECK_NEAR(m.points[0].gap, 1.2 - 0.5 * cos(0.3) - 0.75, 1e-15);
    }
    shape_free(&floor);
    shape_free(&plane);
    shape_free(&capsule);
}

TEST(parallel_capsules_touch_along_a_line)
{
    Shape a = fixture_capsule(0.25, 1), b = fixture_capsule(0.25, 2);
    Manifold m;
    CHECK_INT(collide(&a, pose_identity(), &b, at_point(0.5, 0.3, 0), 0.01, &m), 1);
    CHECK_INT(m.count, 2);
    CHECK_NEAR(m.points[0].gap, 0, 1e-15);
    CHECK_NEAR(fabs(m.points[0].a.y - m.points[1].a.y), 1, 1e-15);
    shape_free(&a);
    shape_free(&b);
}

/* Standing, lying and tilted on a floor that is a plane, a box, and the general path. */
TEST(cylinders_stand_lie_and_lean_on_floors)
{
    Shape floor[2] = {fixture_box(6, 1, 6), fixture_plane((vec3){0, 1, 0}, 0.5)}, cylinder = fixture_cylinder(0.5, 2);
    Manifold m;
    for (int k = 0; k < 2; k++) {
        CHECK_INT(collide(&floor[k], pose_identity(), &cylinder, at_point(0, 1.5, 0), 0.01, &m), 1);
        CHECK_INT(m.count, 4);
        CHECK_NEAR(quad_area(&m), 0.5, 1e-12);              /* the square in a circle of radius 1/2 */
        CHECK_NEAR(deepest_gap(&m), 0, 1e-15);
        pose lying = {{0, 1, 0}, quat_axis_angle((vec3){0, 0, 1}, DIG_PI / 2)};
        CHECK_INT(collide(&floor[k], pose_identity(), &cylinder, lying, 0.01, &m), 1);
        CHECK_INT(m.count, 2);
        CHECK_NEAR(fabs(m.points[0].b.x - m.points[1].b.x), 2, 1e-12);
        for (int i = 1; i < 15; i++) {                      /* lowest point: -cos(angle) h/2 - sin(angle) r */
            real angle = 0.1 * i;
            vec3 axis = {cos(0.37 * i), 0, sin(0.37 * i)};
            pose lean = {{0, 1.5 + 0.01, 0}, quat_axis_angle(axis, angle)};
            real low = 1.51 - cos(angle) - 0.5 * sin(angle) - 0.5;
            CHECK_INT(collide(&floor[k], pose_identity(), &cylinder, lean, real_max(low + 0.01, 0), &m), 1);
            CHECK_NEAR(deepest_gap(&m), low, 1e-12);
            check_direction(m.normal, (vec3){0, 1, 0}, 1e-12);
        }
    }
    shape_free(&floor[0]);
    shape_free(&floor[1]);
    shape_free(&cylinder);
}

/* ---- properties of all pairs ---- */

enum { KINDS = 7, PLANE = 6 };

static Shape random_shape(Random *r, int kind)
{
    real x = random_between(r, 0.2, 1), y = random_between(r, 0.2, 2);
    vec3 points[20];
    switch (kind) {
    case 0: return fixture_sphere(x);
    case 1: return fixture_box(2 * x, y, random_between(r, 0.2, 2));
    case 2: return fixture_capsule(0.5 * x, y);
    case 3: return fixture_cylinder(x, y);
    case 4: return fixture_cone(x, y);
    case PLANE: return fixture_plane(random_direction(r), random_between(r, -1, 1));
    default:
        for (int i = 0; i < 20; i++)
            points[i] = random_vec3(r, 0.8);
        return fixture_hull(points, 20);
    }
}

static bool is_round(int kind) { return kind == 3 || kind == 4; }

static void check_points(const Manifold *m, real reach)
{
    CHECK(m->count >= 1 && m->count <= MANIFOLD_POINTS);
    CHECK_NEAR(vec3_length(m->normal), 1, 1e-14);
    for (int i = 0; i < m->count; i++) {
        const ManifoldPoint *p = &m->points[i];
        CHECK(p->gap <= reach);
        CHECK_NEAR(vec3_dot(vec3_sub(p->b, p->a), m->normal), p->gap, 1e-13);
        for (int k = 0; k < i; k++)
            CHECK(m->points[k].feature != p->feature);
    }
}

static void check_mirror(const Manifold *m, const Manifold *other, real tolerance)
{
    CHECK_NEAR(deepest_gap(other), deepest_gap(m), tolerance);
    if (tolerance < 1e-11) {
        CHECK_INT(other->count, m->count);
        CHECK_NEAR(vec3_dot(other->normal, m->normal), -1, 1e-9);
    }
}

static void try_pair(Random *r, int ka, int kb)
{
    Shape a = random_shape(r, ka), b = random_shape(r, kb);
    pose pa = {random_vec3(r, 1), random_turn(r)}, pb = {random_vec3(r, 1.5), random_turn(r)};
    pose move = {random_vec3(r, 3), random_turn(r)};
    real reach = random_between(r, 0, 0.4), tolerance = is_round(ka) || is_round(kb) ? 1e-6 : 1e-13;
    Manifold m, mirrored, moved;

    real d = shape_distance(&a, pa, &b, pb, INFINITY, NULL, NULL, NULL);
    int touch = collide(&a, pa, &b, pb, reach, &m);
    CHECK_INT(touch, d <= reach);
    CHECK_INT(collide(&b, pb, &a, pa, reach, &mirrored), touch);
    CHECK_INT(collide(&a, pose_mul(move, pa), &b, pose_mul(move, pb), reach, &moved), touch);
    if (touch) {
        check_points(&m, reach);
        check_mirror(&m, &mirrored, tolerance);
        CHECK_NEAR(deepest_gap(&moved), deepest_gap(&m), tolerance);
        if (!(ka == 1 && kb == 1 && d > 0))         /* boxes apart: along the face's normal instead of the shortest way */
            CHECK_NEAR(deepest_gap(&m), d, ka == 1 && kb == 1 ? 1e-8 : real_max(tolerance, 1e-8));
    }
    shape_free(&a);
    shape_free(&b);
}

TEST(all_pairs_mirror_and_move_with_the_frame_and_reach_the_distance)
{
    Random r = {11};
    for (int ka = 0; ka < KINDS; ka++)
        for (int kb = 0; kb < KINDS; kb++)
            for (int i = 0; i < 300 && !(ka == PLANE && kb == PLANE); i++)
                try_pair(&r, ka, kb);
}

TEST(any_cache_gives_the_same_contact)
{
    Random r = {12};
    for (int i = 0; i < 500; i++) {
        Shape a = random_shape(&r, 5), b = random_shape(&r, 5);
        pose pa = {random_vec3(&r, 1), random_turn(&r)}, pb = {random_vec3(&r, 1.2), random_turn(&r)};
        Manifold want, got;
        ManifoldCache cache = {.kind = (uint32_t)i % 9, .axis = {random_between(&r, -9, 9), i % 7 ? 1 : NAN, i % 5 ? 0 : INFINITY}};
        int touch = collide(&a, pa, &b, pb, 0.1, &want);
        for (int k = 0; k < 3; k++) {
            uint32_t piece;
            CHECK_INT(manifold_collide(&a, pa, &b, pb, 0.1, &cache, &got, &piece, 1), touch);
            if (touch)
                CHECK_NEAR(deepest_gap(&got), deepest_gap(&want), 1e-13);
        }
        shape_free(&a);
        shape_free(&b);
    }
}

/* Pieces of two planks that lie on each other, askew by one: apart along the planks by nothing, overlapping across them by 1 mm. */
TEST(a_face_that_the_next_part_covers_is_no_way_out)
{
    Shape a = fixture_box(1, 0.1, 0.2), b = fixture_box(1, 0.1, 0.2), ball = fixture_sphere(0.05);
    Covered both = {covered_face(0, 1), covered_face(0, -1)}, none = {0, 0};
    Manifold m;
    for (int i = 0; i < 3; i++) {
        real x = 1 - i * 5e-4, over = i * 5e-4;     /* m  the pieces reach over each other by 0, 0.5 and 1 mm */
        CHECK_INT(manifold_of_parts(&a, at_point(0, 0, 0), &b, at_point(x, 0.098, 0), 0.01, none, NULL, &m), 1);
        CHECK_NEAR(m.normal.x, 1, 1e-15);
        CHECK_INT(manifold_of_parts(&a, at_point(0, 0, 0), &b, at_point(x, 0.098, 0), 0.01, both, NULL, &m), 1);
        check_direction(m.normal, (vec3){0, 1, 0}, 1e-15);
        CHECK_NEAR(m.points[0].gap, -0.002, 1e-15);
        CHECK(m.points[0].a.x >= 0.5 - over - 1e-12 && m.points[0].a.x <= 0.5 + 1e-12);
    }
    CHECK_INT(manifold_of_parts(&a, at_point(0, 0, 0), &b, at_point(1.001, 0.098, 0), 0.01, both, NULL, &m), 0);     /* the next part's */
    /* from the other side, mirrored; a ball beside a covered face is none of its business */
    CHECK_INT(manifold_of_parts(&b, at_point(0.9995, 0.098, 0), &a, at_point(0, 0, 0), 0.01, (Covered){both.b, both.a}, NULL, &m), 1);
    check_direction(m.normal, (vec3){0, -1, 0}, 1e-15);
    CHECK_INT(manifold_of_parts(&a, at_point(0, 0, 0), &ball, at_point(0.54, 0, 0), 0.01, both, NULL, &m), 0);
    CHECK_INT(manifold_of_parts(&a, at_point(0, 0, 0), &ball, at_point(0.54, 0.06, 0), 0.01, both, NULL, &m), 0);
    CHECK_INT(manifold_of_parts(&a, at_point(0, 0, 0), &ball, at_point(0.4, 0.09, 0), 0.01, both, NULL, &m), 1);
    shape_free(&a);
    shape_free(&b);
    shape_free(&ball);
}

/* Three cubes welded to a corner, a fourth in it: it touches the edge of the middle one, between two covered faces. */
TEST(the_edge_in_an_inner_corner_meets_nothing)
{
    Shape a = fixture_box(0.2, 0.2, 0.2), b = fixture_box(0.2, 0.2, 0.2);
    Covered corner = {covered_face(0, 1) | covered_face(1, 1), 0}, none = {0, 0};
    Manifold m;
    for (int i = -1; i <= 1; i++)
        for (int k = -1; k <= 1; k++) {
            pose at = at_point(0.2 - 1e-6 * i, 0.2 - 1e-6 * k, 0);
            CHECK(manifold_of_parts(&a, at_point(0, 0, 0), &b, at, 0.01, none, NULL, &m) > 0);
            CHECK_INT(manifold_of_parts(&a, at_point(0, 0, 0), &b, at, 0.01, corner, NULL, &m), 0);
        }
    /* half in it, as no neighbour lets it: out along the edge, for want of a better way */
    CHECK(manifold_of_parts(&a, at_point(0, 0, 0), &b, at_point(0.1, 0.1, 0.08), 0.01, corner, NULL, &m) > 0);
    CHECK_NEAR(fabs(m.normal.z), 1, 1e-12);
    shape_free(&a);
    shape_free(&b);
}

int main(void)
{
    RUN_TESTS(unit_test(spheres_touch_on_the_line_of_centres), unit_test(a_sphere_meets_a_box_at_face_edge_and_from_inside),
              unit_test(spheres_near_cones_and_cylinders_have_sampled_distances),
              unit_test(a_box_resting_on_a_box_keeps_its_normal_and_points),
              unit_test(a_slightly_turned_box_rests_on_the_face_not_on_edges),
              unit_test(a_hovering_box_gets_its_four_corners), unit_test(four_of_eight_points_span_the_largest_area),
              unit_test(the_deepest_point_is_always_kept), unit_test(crossed_edges_touch_in_one_point),
              unit_test(a_lying_capsule_has_two_points_and_a_steep_one_has_one), unit_test(parallel_capsules_touch_along_a_line),
              unit_test(cylinders_stand_lie_and_lean_on_floors), unit_test(all_pairs_mirror_and_move_with_the_frame_and_reach_the_distance),
              unit_test(any_cache_gives_the_same_contact), unit_test(a_face_that_the_next_part_covers_is_no_way_out),
              unit_test(the_edge_in_an_inner_corner_meets_nothing));
}
