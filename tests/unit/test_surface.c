/* test_surface - contacts with meshes and height fields: no ghosts at inner edges, real edges, the deepest kept. */
#include "collide_fixture.h"

#include <stdlib.h>

enum { N = 17, MANY = 64 };

/* N x N vertices half a metre apart about the origin, at height(x, z); alternating diagonals. */
static Shape mesh_of(real (*height)(real x, real z))
{
    vec3 vertices[N * N];
    int64_t triangles[(N - 1) * (N - 1) * 6];
    int count = 0;
    for (int i = 0; i < N * N; i++) {
        real x = 0.5 * (i % N) - 4, z = 0.5 * (i / N) - 4;
        vertices[i] = (vec3){x, height(x, z), z};
    }
    for (int z = 0; z + 1 < N; z++)
        for (int x = 0; x + 1 < N; x++) {
            int64_t c = z * N + x + 1;
            int64_t one[6] = {c, c + N, c + 1, c + 1, c + N, c + N + 1}, two[6] = {c, c + N, c + N + 1, c, c + N + 1, c + 1};
            memcpy(triangles + count, (x + z) % 2 ? one : two, sizeof one);
            count += 6;
        }
    return fixture_make("mesh", &(dig_mesh_def){{vertices, N * N}, {triangles, count}});
}

static Shape field_of(real (*height)(real x, real z))
{
    real heights[N * N];
    for (int i = 0; i < N * N; i++)
        heights[i] = height(0.5 * (i % N) - 4, 0.5 * (i / N) - 4);
    return fixture_make("heightfield", &(dig_heightfield_def){.heights = heights, .columns = N, .rows = N, .size = {8, 0, 8}});
}

/* A box of triangles, its faces cut into n x n squares. */
static Shape box_of_triangles(real x, real y, real z, int n)
{
    static vec3 v[6 * 25];
    static int64_t t[6 * 16 * 6];
    const vec3 half = {0.5 * x, 0.5 * y, 0.5 * z};
    int count = 0, at = 0;
    for (int f = 0; f < 6; f++) {
        real side = f % 2 ? 1 : -1;
        for (int i = 0; i <= n; i++)
            for (int j = 0; j <= n; j++) {
                real a = side * (2.0 * i / n - 1), b = 2.0 * j / n - 1, c[3];
                c[f / 2] = side;
                c[(f / 2 + 1) % 3] = a;
                c[(f / 2 + 2) % 3] = b;
                v[count++] = (vec3){c[0] * half.x, c[1] * half.y, c[2] * half.z};
            }
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) {
                int64_t c = f * (n + 1) * (n + 1) + i * (n + 1) + j + 1;
                const int64_t six[6] = {c, c + n + 1, c + n + 2, c, c + n + 2, c + 1};
                memcpy(t + at, six, sizeof six);
                at += 6;
            }
    }
    return fixture_make("mesh", &(dig_mesh_def){{v, count}, {t, at}});
}

static real flat(real x, real z) { return 0 * x * z; }
static real ramp(real x, real z) { return 0.2 * x + 0 * z; }
static real valley(real x, real z) { return fabs(x) + 0 * z; }
static real ridge(real x, real z) { return -fabs(x) + 0 * z; }

static void check_only_normal(const Manifold *m, int count, vec3 want, real tolerance)
{
    for (int i = 0; i < count; i++)
        CHECK_NEAR(vec3_distance(m[i].normal, want), 0, tolerance);
}

static real deepest_of(const Manifold *m, int count)
{
    real least = INFINITY;
    for (int i = 0; i < count; i++)
        least = real_min(least, deepest_gap(&m[i]));
    return least;
}

static void slide(const Shape *ground, const Shape *body, real height, quat turn, vec3 n, real reach, real want)
{
    Manifold m[MANY];
    uint32_t piece[MANY];
    for (int i = 0; i < 400; i++) {
        vec3 p = {-1.5 + 0.0075 * i, 0, 0.3 + 0.0011 * i};
        p.y = (height - n.x * p.x) / n.y;               /* height along the normal above the plane through the origin */
        int count = manifold_collide(ground, pose_identity(), body, (pose){p, turn}, reach, NULL, m, piece, MANY);
        CHECK(count > 0);
        check_only_normal(m, count, n, 1e-9);
        CHECK_NEAR(deepest_of(m, count), want, 1e-12);
        count = manifold_collide(body, (pose){p, turn}, ground, pose_identity(), reach, NULL, m, piece, MANY);
        check_only_normal(m, count, vec3_neg(n), 1e-9);
    }
}

TEST(sliding_over_flat_triangles_shows_only_the_planes_normal)
{
    vec3 up = {0, 1, 0}, out = vec3_unit((vec3){-0.2, 1, 0});
    quat along = quat_between(up, out);
    Shape ground[4] = {mesh_of(flat), field_of(flat), mesh_of(ramp), field_of(ramp)};
    Shape ball = fixture_sphere(0.3), box = fixture_box(0.7, 0.4, 0.9);
    Shape capsule = fixture_capsule(0.2, 0.8), cylinder = fixture_cylinder(0.3, 0.5);
    quat lying = quat_axis_angle((vec3){0, 0, 1}, DIG_PI / 2), turned = quat_axis_angle(up, 0.4);
    for (int k = 0; k < 4; k++) {
        vec3 n = k < 2 ? up : out;
        quat q = k < 2 ? quat_identity() : along;
        for (int sunk = 0; sunk < 3; sunk++) {
            real gap = (real[]){0.004, 0, -0.01}[sunk];
            slide(&ground[k], &ball, 0.3 + gap, quat_identity(), n, 0.02, gap);
            slide(&ground[k], &box, 0.2 + gap, quat_mul(q, turned), n, 0.02, gap);
            slide(&ground[k], &capsule, 0.2 + gap, quat_mul(q, quat_mul(turned, lying)), n, 0.02, gap);
            slide(&ground[k], &cylinder, 0.25 + gap, q, n, 0.02, gap);
            slide(&ground[k], &cylinder, 0.3 + gap, quat_mul(q, quat_mul(turned, lying)), n, 0.02, gap);
        }
    }
    for (int k = 0; k < 4; k++)
        shape_free(&ground[k]);
    shape_free(&ball);
    shape_free(&box);
    shape_free(&capsule);
    shape_free(&cylinder);
}

/* The points under a box are its four corners, whatever the triangles: their hull is its lower face. */
TEST(a_box_on_many_triangles_stands_on_its_corners)
{
    Shape ground = mesh_of(flat), box = fixture_box(1.3, 1, 0.9);
    pose at = {{0.17, 0.5, -0.23}, quat_axis_angle((vec3){0, 1, 0}, 0.3)};
    Manifold m[MANY];
    uint32_t piece[MANY];
    int count = manifold_collide(&ground, pose_identity(), &box, at, 0.01, NULL, m, piece, MANY), found = 0;
    for (int c = 0; c < 4; c++) {
        vec3 corner = pose_point(at, (vec3){c & 1 ? 0.65 : -0.65, -0.5, c & 2 ? 0.45 : -0.45});
        for (int i = 0; i < count; i++)
            for (int k = 0; k < m[i].count; k++)
                found += vec3_distance(m[i].points[k].b, corner) < 1e-12;
    }
    CHECK_INT(found, 4);
    for (int i = 0; i < count; i++)             /* no point twice */
        for (int k = 0; k < m[i].count; k++)
            for (int j = 0; j < count; j++)
                for (int l = 0; l < m[j].count; l++)
                    CHECK((i == j && k == l) || vec3_distance(m[i].points[k].b, m[j].points[l].b) > 1e-9);
    shape_free(&ground);
    shape_free(&box);
}

TEST(a_ball_in_a_valley_touches_both_sides)
{
    Shape ground[2] = {mesh_of(valley), field_of(valley)}, ball = fixture_sphere(0.5);
    for (int k = 0; k < 2; k++) {
        Manifold m[MANY];
        uint32_t piece[MANY];
        int count = manifold_collide(&ground[k], pose_identity(), &ball, at_point(0, 0.5 * sqrt(2.0), 0.1), 0.01, NULL, m, piece, MANY);
        CHECK_INT(count, 2);
        for (int i = 0; i < count; i++) {
            CHECK_NEAR(m[i].points[0].gap, 0, 1e-15);
            CHECK_NEAR(fabs(m[i].normal.x), sqrt(0.5), 1e-15);
            CHECK_NEAR(m[i].normal.y, sqrt(0.5), 1e-15);
        }
        CHECK(m[0].normal.x * m[1].normal.x < 0);
        shape_free(&ground[k]);
    }
    shape_free(&ball);
}

static real trough(real x, real z) { return 0.2 * fabs(x) + 0 * z; }

/* On one side, its foot on the other still beyond the crease: that other plane is known, at the distance that is left. */
TEST(a_ball_that_comes_to_a_crease_knows_both_sides)
{
    Shape ground[2] = {mesh_of(trough), field_of(trough)}, ball = fixture_sphere(0.05);
    const real tilt = atan(0.2);
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 50; i++) {
            Manifold m[MANY];
            uint32_t piece[MANY];
            const real along = 0.022 + 0.001 * i;       /* m  from the crease, on the side x > 0; its foot is over the other up to 0.0208 */
            vec3 at = {along * cos(tilt) - 0.05 * sin(tilt), along * sin(tilt) + 0.05 * cos(tilt), -1.2 + 0.05 * i};
            int count = manifold_collide(&ground[k], pose_identity(), &ball, (pose){at, quat_identity()}, 0.08, NULL, m, piece, MANY), far = 0;
            for (int j = 0; j < count; j++) {
                real gap = m[j].normal.x < 0 ? 0 : along * sin(2 * tilt) - 0.05 * (1 - cos(2 * tilt));
                CHECK_NEAR(m[j].points[0].gap, gap, 1e-15);
                far += m[j].normal.x > 0;
            }
            CHECK(count > far && far >= 1);
        }
    for (int k = 0; k < 2; k++)
        shape_free(&ground[k]);
    shape_free(&ball);
}

TEST(a_ridge_is_met_across_its_edge_once)
{
    Shape ground[2] = {mesh_of(ridge), field_of(ridge)}, ball = fixture_sphere(0.5), box = fixture_box(2, 1, 0.3);
    for (int k = 0; k < 2; k++) {
        Manifold m[MANY];
        uint32_t piece[MANY];
        pose over = at_point(0.1, 0.49, 0.1);
        int count = manifold_collide(&ground[k], pose_identity(), &ball, over, 0.001, NULL, m, piece, MANY);
        CHECK_INT(count, 1);
        CHECK_NEAR(m[0].points[0].gap, hypot(0.1, 0.49) - 0.5, 1e-15);
        check_only_normal(m, 1, vec3_unit((vec3){0.1, 0.49, 0}), 1e-14);

        count = manifold_collide(&ground[k], pose_identity(), &box, at_point(0.2, 0.5, 0.1), 0.001, NULL, m, piece, MANY);
        CHECK(count >= 1);
        check_only_normal(m, count, (vec3){0, 1, 0}, 1e-12);
        CHECK_NEAR(deepest_of(m, count), 0, 1e-15);
        shape_free(&ground[k]);
    }
    shape_free(&ball);
    shape_free(&box);
}

/* The rim of an open mesh has no neighbours: it is met from the side too. */
TEST(the_rim_of_an_open_mesh_is_real)
{
    Shape ground = mesh_of(flat), ball = fixture_sphere(0.3);
    Manifold m[MANY];
    uint32_t piece[MANY];
    int count = manifold_collide(&ground, pose_identity(), &ball, at_point(4.29, 0.02, 0.13), 0.02, NULL, m, piece, MANY);
    CHECK_INT(count, 1);
    check_only_normal(m, 1, vec3_unit((vec3){0.29, 0.02, 0}), 1e-12);
    CHECK_NEAR(m[0].points[0].gap, hypot(0.29, 0.02) - 0.3, 1e-14);
    /* and its underside pushes down */
    count = manifold_collide(&ground, pose_identity(), &ball, at_point(0.1, -0.31, 0.13), 0.02, NULL, m, piece, MANY);
    CHECK_INT(count, 1);
    check_only_normal(m, 1, (vec3){0, -1, 0}, 1e-12);
    shape_free(&ground);
    shape_free(&ball);
}

static real brink(real x, real z) { return x > 0 ? -2 * x : 0 * z; }
static real brow(real x, real z) { return -brink(x, z); }

/* A rod that tips over the brink of a plateau has its middle below the plateau's plane, beside it: it has not gone through. The same from below. */
TEST(what_tips_over_an_edge_of_an_open_mesh_is_on_its_side)
{
    Shape ground[2] = {mesh_of(brink), mesh_of(brow)}, rod[2] = {fixture_capsule(0.05, 2), fixture_box(0.1, 2, 0.1)};
    Manifold m[MANY];
    uint32_t piece[MANY];
    for (int k = 0; k < 2; k++)
        for (int r = 0; r < 2; r++)
            for (int i = 1; i < 9; i++) {
                real tilt = 0.12 * i, side = k ? -1 : 1, gap = i % 2 ? 1e-9 : -1e-4, beyond = 0.1 * i;
                vec3 along = {cos(tilt), -side * sin(tilt), 0}, n = {sin(tilt), side * cos(tilt), 0};
                pose at = {vec3_mad(vec3_scale(beyond, along), 0.05 + gap, n), quat_axis_angle((vec3){0, 0, 1}, atan2(-along.x, along.y))};
                at.p.z = 0.13;
                int count = manifold_collide(&ground[k], pose_identity(), &rod[r], at, 0.01, NULL, m, piece, MANY);
                CHECK(count > 0);
                for (int j = 0; j < count; j++)
                    CHECK(vec3_dot(m[j].normal, n) > 0.5);      /* of a slope, or between them; not into the ground */
                CHECK_NEAR(deepest_of(m, count), gap, 1e-9);
            }
    for (int k = 0; k < 2; k++) {
        shape_free(&ground[k]);
        shape_free(&rod[k]);
    }
}

/* Beyond a rim nothing is below or above: a rod that hangs over it is on the side on which it touches. */
TEST(what_tips_over_a_rim_of_an_open_mesh_is_where_it_touches)
{
    Shape ground = mesh_of(flat), rod[2] = {fixture_capsule(0.05, 2), fixture_box(0.1, 2, 0.1)};
    Manifold m[MANY];
    uint32_t piece[MANY];
    for (int i = 0; i < 32; i++) {
        real tilt = 0.12 * (1 + i / 4), side = i & 1 ? -1 : 1, gap = i & 4 ? 1e-9 : -1e-4, beyond = 0.1 * (1 + i / 4);
        vec3 along = {cos(tilt), -side * sin(tilt), 0}, n = {sin(tilt), side * cos(tilt), 0};
        vec3 middle = vec3_add((vec3){4, 0, 0.13}, vec3_mad(vec3_scale(beyond, along), 0.05 + gap, n));
        int count = manifold_collide(&ground, pose_identity(), &rod[i / 2 % 2],
                                     (pose){middle, quat_axis_angle((vec3){0, 0, 1}, atan2(-along.x, along.y))}, 0.01, NULL, m, piece, MANY);
        CHECK(count > 0);
        for (int j = 0; j < count; j++)
            CHECK(vec3_dot(m[j].normal, n) > 0.5);
        CHECK_NEAR(deepest_of(m, count), gap, 1e-9);
    }
    shape_free(&ground);
    shape_free(&rod[0]);
    shape_free(&rod[1]);
}

/* The corners of a hull lie about any origin: on its lower face, above its upper one, or far beside it. Which side of an open mesh it is on is told
 * by where the hull is. */
TEST(a_hull_meets_an_open_mesh_wherever_its_origin_is)
{
    Shape ground = mesh_of(flat), closed = box_of_triangles(3, 3, 3, 1);
    Manifold m[MANY];
    uint32_t piece[MANY];
    const vec3 off[] = {{0, 0, 0}, {0, 0.2, 0}, {0, 0.3, 0}, {0, -0.2, 0}, {0, -0.3, 0}, {1, 0.5, -1}, {3, -7, 2}};
    for (size_t k = 0; k < sizeof off / sizeof *off; k++) {
        vec3 corner[8];
        for (int i = 0; i < 8; i++)
            corner[i] = vec3_add(off[k], (vec3){i & 1 ? 0.2 : -0.2, i & 2 ? 0.2 : -0.2, i & 4 ? 0.2 : -0.2});
        Shape hull = fixture_hull(corner, 8);
        for (int i = 0; i < 8; i++) {
            real gap = (real[]){0.01, 1e-9, 0, -1e-3}[i % 4], side = i < 4 ? 1 : -1;
            pose at = {vec3_sub((vec3){0.3, side * (0.2 + gap), 0.1}, off[k]), quat_identity()};
            int count = manifold_collide(&ground, pose_identity(), &hull, at, 0.02, NULL, m, piece, MANY);
            CHECK(count > 0);
            check_only_normal(m, count, (vec3){0, side, 0}, 1e-9);
            CHECK_NEAR(deepest_of(m, count), gap, 1e-12);
        }
        pose inside = {vec3_neg(off[k]), quat_identity()};
        CHECK_NEAR(shape_distance(&closed, pose_identity(), &hull, inside, INFINITY, NULL, NULL, NULL), -(1.3 + 2 * 0.2), 1e-12);
        shape_free(&hull);
    }
    shape_free(&ground);
    shape_free(&closed);
}

/* A height field is solid below: what has sunk in is pushed up. */
TEST(what_sank_into_a_height_field_is_pushed_up)
{
    Shape ground = field_of(flat), ball = fixture_sphere(0.3), box = fixture_box(0.4, 0.6, 0.4);
    Manifold m[MANY];
    uint32_t piece[MANY];
    int count = manifold_collide(&ground, pose_identity(), &ball, at_point(0.1, -0.05, 0.13), 0.02, NULL, m, piece, MANY);
    CHECK(count >= 1);
    check_only_normal(m, count, (vec3){0, 1, 0}, 1e-12);
    CHECK_NEAR(deepest_of(m, count), -0.35, 1e-12);
    count = manifold_collide(&ground, pose_identity(), &box, at_point(0.1, -0.2, 0.13), 0.02, NULL, m, piece, MANY);
    CHECK(count >= 1);
    check_only_normal(m, count, (vec3){0, 1, 0}, 1e-12);
    CHECK_NEAR(deepest_of(m, count), -0.5, 1e-12);
    shape_free(&ground);
    shape_free(&ball);
    shape_free(&box);
}

/* A box leaning on one edge over a field: of many touching triangles the deepest stay. */
TEST(with_little_room_the_deepest_are_kept)
{
    Shape ground = mesh_of(flat), box = fixture_box(3, 1, 3);
    pose at = {{0.1, 0.5, 0.2}, quat_axis_angle(vec3_unit((vec3){1, 0, 0.3}), 0.02)};
    Manifold all[MANY], few[3];
    uint32_t piece[MANY], few_pieces[3];
    int count = manifold_collide(&ground, pose_identity(), &box, at, 0.2, NULL, all, piece, MANY);
    CHECK(count > 20);
    CHECK_INT(manifold_collide(&ground, pose_identity(), &box, at, 0.2, NULL, few, few_pieces, 3), 3);
    CHECK_NEAR(deepest_of(few, 3), deepest_of(all, count), 0);
    int deeper = 0;
    for (int i = 0; i < count; i++)
        deeper += deepest_gap(&all[i]) < deepest_of(few, 3) - 1e-12;
    CHECK_INT(deeper, 0);
    shape_free(&ground);
    shape_free(&box);
}

static real bumps(real x, real z) { return 0.2 * sin(2.1 * x) * cos(1.7 * z); }

/* The distance to a surface is the least over all triangles, each taken as a hull of its own by brute force. */
TEST(distances_to_surfaces_equal_the_least_over_all_triangles)
{
    Shape ground = mesh_of(bumps), field = field_of(bumps), box = fixture_box(0.5, 0.3, 0.7), ball = fixture_sphere(0.25);
    Random r = {9};
    uint32_t *pieces = malloc(sizeof *pieces * 4 * N * N);
    int total = ground.type->pieces(&ground, (box3){{-9, -9, -9}, {9, 9, 9}}, pieces, 4 * N * N);
    for (int i = 0; i < 60; i++) {
        pose at = {{random_between(&r, -6, 6), random_between(&r, 0.7, 4), random_between(&r, -6, 6)}, random_turn(&r)};
        real least = INFINITY;
        for (int k = 0; k < total; k++) {       /* nearest point of a triangle to the centre, by its three edges and its plane */
            vec3 c[3];
            ground.type->piece(&ground, pieces[k], c);
            vec3 n = vec3_unit(vec3_cross(vec3_sub(c[1], c[0]), vec3_sub(c[2], c[0])));
            real high = vec3_dot(n, vec3_sub(at.p, c[0]));
            bool in = true;
            for (int e = 0; e < 3; e++) {
                vec3 u = vec3_sub(c[(e + 1) % 3], c[e]), d = vec3_sub(at.p, c[e]);
                in = in && vec3_dot(vec3_cross(n, u), d) >= 0;
                real t = real_clamp(vec3_dot(d, u) / vec3_length2(u), 0, 1);
                least = real_min(least, vec3_distance(at.p, vec3_mad(c[e], t, u)));
            }
            if (in)
                least = real_min(least, fabs(high));
        }
        CHECK_NEAR(shape_distance(&ground, pose_identity(), &ball, at, INFINITY, NULL, NULL, NULL), least - 0.25, 1e-13);
        vec3 n, on_a, on_b;
        real d = shape_distance(&box, at, &ground, pose_identity(), INFINITY, &n, &on_a, &on_b);
        if (d > 0)
            CHECK_NEAR(vec3_distance(on_a, on_b), d, 1e-13);
        CHECK_NEAR(d, shape_distance(&ground, pose_identity(), &box, at, INFINITY, NULL, NULL, NULL), 1e-13);
        CHECK(d <= least && d >= least - box.outer - 1e-12);
        CHECK(shape_distance(&box, at, &ground, pose_identity(), 0.1, NULL, NULL, NULL) > 0.1 || d <= 0.1);
        CHECK(fabs(d - shape_distance(&box, at, &field, pose_identity(), INFINITY, NULL, NULL, NULL)) < 0.1);  /* other diagonals */
    }
    free(pieces);
    shape_free(&ground);
    shape_free(&field);
    shape_free(&box);
    shape_free(&ball);
}

/* Taking ghosts away must not take the true nearest contact: its normal is one the surface has. */
TEST(the_nearest_contact_of_a_bumpy_surface_is_never_lost)
{
    Shape ground[2] = {mesh_of(bumps), field_of(bumps)};
    Shape body[4] = {fixture_sphere(0.25), fixture_box(0.5, 0.3, 0.7), fixture_capsule(0.1, 0.6), fixture_cylinder(0.2, 0.5)};
    Random r = {10};
    int near_by = 0;
    for (int i = 0; i < 4000; i++) {
        const Shape *g = &ground[i % 2], *b = &body[i / 2 % 4];
        pose at = {{random_between(&r, -3, 3), random_between(&r, 0.2, 0.8), random_between(&r, -3, 3)}, random_turn(&r)};
        real d = shape_distance(g, pose_identity(), b, at, INFINITY, NULL, NULL, NULL), reach = 0.1;
        Manifold m[MANY];
        uint32_t piece[MANY];
        if (!(d > 0 && fabs(d - reach) > 1e-9))
            continue;
        int count = manifold_collide(g, pose_identity(), b, at, reach, NULL, m, piece, MANY);
        if (d > reach) {
            CHECK_INT(count, 0);
            continue;
        }
        CHECK(count > 0);
        CHECK_NEAR(deepest_of(m, count), d, 1e-9);
        near_by++;
    }
    CHECK(near_by > 200);
    for (int i = 0; i < 4; i++)
        shape_free(&body[i]);
    shape_free(&ground[0]);
    shape_free(&ground[1]);
}

/* Planes meet a closed mesh as they meet its hull: gaps, deepest contacts, and what stands on its face stands on its four corners, however
 * many triangles that face has. */
TEST(a_plane_meets_a_mesh_as_it_meets_its_hull)
{
    Shape floor = fixture_plane((vec3){0.1, 1, 0.2}, 0.3), box = fixture_box(0.5, 0.3, 0.7), mesh[2];
    Random r = {12};
    for (int k = 0; k < 2; k++) {
        mesh[k] = box_of_triangles(0.5, 0.3, 0.7, k ? 4 : 1);
        for (int i = 0; i < 400; i++) {
            pose at = {{random_between(&r, -3, 3), random_between(&r, -0.5, 1.5), random_between(&r, -3, 3)}, random_turn(&r)};
            Manifold one, other;
            vec3 on_a, on_b;
            real d = shape_distance(&floor, pose_identity(), &mesh[k], at, INFINITY, NULL, &on_a, &on_b);
            CHECK_NEAR(d, shape_distance(&floor, pose_identity(), &box, at, INFINITY, NULL, NULL, NULL), 1e-13);
            CHECK_NEAR(d, shape_distance(&mesh[k], at, &floor, pose_identity(), INFINITY, NULL, NULL, NULL), 1e-13);
            CHECK_NEAR(vec3_distance(on_a, on_b), fabs(d), 1e-13);
            int met = manifold_collide(&floor, pose_identity(), &mesh[k], at, 0.1, NULL, &one, NULL, 1);
            CHECK_INT(met, manifold_collide(&floor, pose_identity(), &box, at, 0.1, NULL, &other, NULL, 1));
            if (met) {
                CHECK_NEAR(deepest_gap(&one), d, 1e-13);
                CHECK_NEAR(vec3_distance(one.normal, other.normal), 0, 1e-15);
            }
        }
        pose flat = {{0, 0.45, 0}, quat_between((vec3){0, 1, 0}, vec3_unit((vec3){0.1, 1, 0.2}))};
        Manifold m;
        CHECK_INT(manifold_collide(&floor, pose_identity(), &mesh[k], flat, 0.1, NULL, &m, NULL, 1), 1);
        CHECK_INT(m.count, 4);
        for (int i = 0; i < 4; i++)             /* the corners, not what lies between them */
            CHECK_NEAR(vec3_distance(pose_unpoint(flat, m.points[i].b), (vec3){0, -0.15, 0}), hypot(0.25, 0.35), 1e-13);
        shape_free(&mesh[k]);
    }
    shape_free(&floor);
    shape_free(&box);
}

/* A plate 2 m wide under an edge or corner of a box of triangles also reaches 1 m behind the plane of the box's side. */
TEST(what_lies_under_an_edge_is_not_met_through_the_side)
{
    Shape plate = fixture_box(2, 0.02, 2), box = fixture_box(0.2, 0.1, 0.15);
    Random r = {7};
    for (int k = 0; k < 2; k++) {
        Shape mesh = box_of_triangles(0.2, 0.1, 0.15, k ? 4 : 1);
        for (int i = 0; i < 2000; i++) {
            real tilt = pow(10, random_between(&r, -7, -2));
            pose at = {{random_between(&r, -0.7, 0.7), 0, random_between(&r, -0.7, 0.7)},
                       quat_axis_angle(vec3_unit((vec3){random_between(&r, -1, 1), random_between(&r, -1, 1), random_between(&r, -1, 1)}), tilt)};
            box3 b = box.type->bounds(&box, at);
            at.p.y -= b.low.y - 0.01 + pow(10, random_between(&r, -8, -5));         /* sunk by that */
            Manifold m[MANY];
            uint32_t piece[MANY];
            int count = manifold_collide(&mesh, at, &plate, pose_identity(), 0.001, NULL, m, piece, MANY);
            CHECK(count > 0);
            CHECK_NEAR(deepest_of(m, count), 0, 1.1e-5);
        }
        shape_free(&mesh);
    }
    shape_free(&plate);
    shape_free(&box);
}

int main(void)
{
    RUN_TESTS(unit_test(sliding_over_flat_triangles_shows_only_the_planes_normal), unit_test(a_box_on_many_triangles_stands_on_its_corners),
              unit_test(a_ball_in_a_valley_touches_both_sides), unit_test(a_ridge_is_met_across_its_edge_once),
              unit_test(the_rim_of_an_open_mesh_is_real), unit_test(a_ball_that_comes_to_a_crease_knows_both_sides),
              unit_test(what_sank_into_a_height_field_is_pushed_up),
              unit_test(a_hull_meets_an_open_mesh_wherever_its_origin_is), unit_test(what_tips_over_an_edge_of_an_open_mesh_is_on_its_side),
              unit_test(what_tips_over_a_rim_of_an_open_mesh_is_where_it_touches),
              unit_test(with_little_room_the_deepest_are_kept), unit_test(distances_to_surfaces_equal_the_least_over_all_triangles),
              unit_test(the_nearest_contact_of_a_bumpy_surface_is_never_lost),
              unit_test(a_plane_meets_a_mesh_as_it_meets_its_hull), unit_test(what_lies_under_an_edge_is_not_met_through_the_side));
}
