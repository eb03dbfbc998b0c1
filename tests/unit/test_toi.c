/* test_toi - times of impact against closed forms, dense sampling, and speeds that would tunnel. */
#include "collide_fixture.h"

static Motion motion(pose start, vec3 v, vec3 w, vec3 a) { return (Motion){.start = start, .v = v, .w = w, .a = a}; }
static Motion still(pose at) { return (Motion){.start = at}; }

static real gap_at(const Shape *a, const Motion *ma, const Shape *b, const Motion *mb, real t)
{
    return shape_distance(a, motion_at(ma, t), b, motion_at(mb, t), INFINITY, NULL, NULL, NULL);
}

TEST(free_fall_of_a_sphere_takes_the_root_of_2h_over_g)
{
    Shape plane = fixture_plane((vec3){0, 1, 0}, 0), box = fixture_box(20, 2, 20), ball = fixture_sphere(0.5);
    real g = 9.81;
    for (int i = 1; i < 40; i++) {
        real height = 0.5 + 0.37 * i, want = sqrt(2 * (height - 0.5) / g);
        Motion floor = still(at_point(0, 0, 0)), deep = still(at_point(0, -1, 0));
        Motion fall = motion(at_point(0.3, height, 0.2), vec3_zero(), (vec3){0, 0, 3}, (vec3){0, -g, 0});
        int count;
        CHECK_NEAR(time_of_impact(&plane, &floor, &ball, &fall, 0, 10, &count), want, 1e-12 * want);
        CHECK(count <= 3);
        CHECK_NEAR(time_of_impact(&ball, &fall, &plane, &floor, 0, 10, NULL), want, 1e-12 * want);
        CHECK_NEAR(time_of_impact(&box, &deep, &ball, &fall, 0, 10, NULL), want, 1e-12 * want);
        CHECK(isinf(time_of_impact(&plane, &floor, &ball, &fall, 0, 0.999 * want, NULL)));
        CHECK_NEAR(time_of_impact(&plane, &floor, &ball, &fall, 0.1, 10, NULL), sqrt(2 * (height - 0.6) / g), 1e-12);
    }
    shape_free(&plane);
    shape_free(&box);
    shape_free(&ball);
}

TEST(a_thrown_ball_that_does_not_reach_the_ceiling_meets_nothing)
{
    Shape ceiling = fixture_box(10, 1, 10), ball = fixture_sphere(0.1);
    Motion top = still(at_point(0, 5.5, 0));
    real g = 10;                                        /* rises to v^2 / 2g: the gap of 4.9 m needs sqrt(98) m/s */
    Motion low = motion(at_point(0, 0, 0), (vec3){0, sqrt(98) - 1e-9, 0}, vec3_zero(), (vec3){0, -g, 0});
    Motion high = low;
    high.v.y = sqrt(98) + 1e-6;
    CHECK(isinf(time_of_impact(&ceiling, &top, &ball, &low, 0, 5, NULL)));
    real want = (high.v.y - sqrt(high.v.y * high.v.y - 98)) / g;
    CHECK_NEAR(time_of_impact(&ceiling, &top, &ball, &high, 0, 5, NULL), want, 1e-9);
    shape_free(&ceiling);
    shape_free(&ball);
}

/* A rod turning about its middle next to a ball: its end of radius r at distance L / 2 meets the plane x = d when
 * (L / 2) cos(angle) = d - r. */
TEST(a_turning_rod_meets_a_wall_when_its_end_gets_there)
{
    Shape rod = fixture_capsule(0.02, 1), wall = fixture_plane((vec3){-1, 0, 0}, -0.4);     /* solid at x >= 0.4 */
    for (int i = 0; i < 6; i++) {
        real w = (real[]){0.1, 1, 10, 100, 600, 600}[i];
        Motion at = still(pose_identity());
        Motion turning = motion(pose_identity(), vec3_zero(), (vec3){0, 0, i == 5 ? w : -w}, vec3_zero());   /* starts along y */
        real want = (DIG_PI / 2 - acos(0.38 / 0.5)) / w;
        CHECK_NEAR(time_of_impact(&wall, &at, &rod, &turning, 0, 100 / w, NULL), want, 1e-9 * want);
    }
    shape_free(&rod);
    shape_free(&wall);
}

TEST(fast_spheres_never_pass_a_thin_wall)
{
    Shape wall = fixture_box(0.02, 4, 4), ball = fixture_sphere(0.01);
    Random r = {5};
    Motion stands = still((pose){{0, 0, 0}, quat_axis_angle((vec3){0, 1, 0}, 0.2)});
    vec3 n = quat_rotate(stands.start.q, (vec3){1, 0, 0});
    for (int i = 0; i < 500; i++) {
        real speed = random_between(&r, 500, 2000);
        vec3 from = {-random_between(&r, 1, 10), random_between(&r, -1, 1), random_between(&r, -1, 1)};
        vec3 to = {0, random_between(&r, -1, 1), random_between(&r, -1, 1)};
        vec3 v = vec3_scale(speed, vec3_unit(vec3_sub(to, from)));
        Motion flies = motion((pose){from, quat_identity()}, v, random_vec3(&r, 600), vec3_zero());
        real want = (-0.02 - vec3_dot(n, from)) / vec3_dot(n, v);      /* centre 2 cm before the middle plane */
        CHECK_NEAR(time_of_impact(&wall, &stands, &ball, &flies, 0, 1.0 / 30, NULL), want, 1e-12);
    }
    shape_free(&wall);
    shape_free(&ball);
}

/* The first crossing found by sampling, at steps far below the time in which anything can cross. */
static real sampled_impact(const Shape *a, const Motion *ma, const Shape *b, const Motion *mb, real time, int samples)
{
    for (int i = 1; i <= samples; i++)
        if (gap_at(a, ma, b, mb, time * i / samples) <= 0)
            return time * i / samples;
    return INFINITY;
}

TEST(spinning_rods_are_never_missed)
{
    Shape rod = fixture_box(1, 0.03, 0.03), ball = fixture_sphere(0.03), post = fixture_cylinder(0.02, 1);
    Random r = {6};
    int met = 0;
    for (int i = 0; i < 150; i++) {
        real time = 1.0 / 60;
        const Shape *target = i % 2 ? &ball : &post;
        Motion spins = motion((pose){vec3_zero(), random_turn(&r)}, random_vec3(&r, 5), vec3_scale(600, random_direction(&r)), vec3_zero());
        Motion waits = still((pose){vec3_scale(random_between(&r, 0.1, 0.6), random_direction(&r)), random_turn(&r)});
        if (gap_at(&rod, &spins, target, &waits, 0) < 0.001)
            continue;
        int count;
        real sampled = sampled_impact(&rod, &spins, target, &waits, time, 2000);      /* the end moves 2.5 mm a sample */
        real got = time_of_impact(&rod, &spins, target, &waits, 0, time, &count);
        CHECK(got <= sampled);
        if (got < INFINITY) {
            CHECK_NEAR(gap_at(&rod, &spins, target, &waits, got), 0, 1e-10 * 0.03);
            CHECK_NEAR(gap_at(target, &waits, &rod, &spins, got), 0, 1e-10 * 0.03);
            met++;
        }
    }
    CHECK(met > 30);
    shape_free(&rod);
    shape_free(&ball);
    shape_free(&post);
}

static Shape any_shape(Random *r, int kind)
{
    vec3 points[12];
    switch (kind) {
    case 0: return fixture_sphere(random_between(r, 0.1, 0.5));
    case 1: return fixture_box(random_between(r, 0.2, 1), random_between(r, 0.2, 1), random_between(r, 0.2, 1));
    case 2: return fixture_capsule(random_between(r, 0.1, 0.3), random_between(r, 0.2, 1));
    case 3: return fixture_cylinder(random_between(r, 0.1, 0.5), random_between(r, 0.2, 1));
    default:
        for (int i = 0; i < 12; i++)
            points[i] = random_vec3(r, 0.5);
        return fixture_hull(points, 12);
    }
}

TEST(tumbling_shapes_meet_at_the_target_and_not_before)
{
    Random r = {7};
    int met = 0, most = 0;
    for (int i = 0; i < 600; i++) {
        Shape a = any_shape(&r, i % 5), b = any_shape(&r, (i / 5) % 5);
        Motion ma = motion((pose){vec3_zero(), random_turn(&r)}, random_vec3(&r, 1), random_vec3(&r, 6), (vec3){0, -9.81, 0});
        vec3 away = vec3_scale(random_between(&r, 2, 3), random_direction(&r));
        Motion mb = motion((pose){away, random_turn(&r)}, vec3_mad(random_vec3(&r, 1), -4, away), random_vec3(&r, 6), (vec3){0, 0, 0});
        ma.centre = random_vec3(&r, 0.1);
        real target = random_between(&r, 0, 0.01), time = 1;
        int count;
        if (gap_at(&a, &ma, &b, &mb, 0) > 0.05) {
            real t = time_of_impact(&a, &ma, &b, &mb, target, time, &count), end = real_min(t, time);
            for (int k = 0; k < 300; k++)
                CHECK(gap_at(&a, &ma, &b, &mb, end * k / 300) > target - 1e-11);
            if (t <= time) {
                CHECK_NEAR(gap_at(&a, &ma, &b, &mb, t), target, 1e-11);
                met++;
            }
            most = count > most ? count : most;
        }
        shape_free(&a);
        shape_free(&b);
    }
    CHECK(met > 200);
    CHECK(most < 60);
}

/* Two stones of an arch open about the edge that they share, a hundredth of a millionth apart there: what far corners do in the fixed
 * direction between them is no approach. */
TEST(what_hinges_on_an_edge_takes_few_gaps)
{
    Shape stone = fixture_box(0.2, 0.1, 0.4);
    for (int i = 0; i < 20; i++) {
        real w = 0.02 + 0.02 * i;
        Motion a = motion(at_point(0, 0, 0), vec3_cross((vec3){0, 0, w}, (vec3){0.1, -0.05, 0}), (vec3){0, 0, w}, vec3_zero());
        Motion b = motion(at_point(0, 0.1 + 1e-8, 0), vec3_cross((vec3){0, 0, -w}, (vec3){0.1, 0.05, 0}), (vec3){0, 0, -w}, vec3_zero());
        a.v = vec3_neg(a.v);
        b.v = vec3_neg(b.v);
        int count;
        CHECK(isinf(time_of_impact(&stone, &a, &stone, &b, 0, 1.0 / 240, &count)));
        CHECK(count <= 12);
    }
    shape_free(&stone);
}

/* Its supports along the wall's normal say all; 14 gaps on the way to the wall before, and 79 where an end has just left it. */
TEST(a_rod_that_whirls_before_a_wall_takes_few_gaps)
{
    Shape rod = fixture_box(0.04, 1, 0.04), wall = fixture_box(0.02, 80, 80);
    Motion stands = still(at_point(0.01, 0, 0));
    for (int i = 0; i < 40; i++) {
        Motion flies = motion((pose){{-0.7 - 0.01 * i, 0, 0}, quat_identity()}, (vec3){60, 0, 0}, (vec3){0, 0, 600}, vec3_zero());
        int count;
        real t = time_of_impact(&wall, &stands, &rod, &flies, 0, 1.0 / 60, &count);
        CHECK(count <= 4);
        CHECK_NEAR(gap_at(&wall, &stands, &rod, &flies, t), 0, 1e-12);
        CHECK(sampled_impact(&wall, &stands, &rod, &flies, t * (1 - 1e-6), 2000) == INFINITY);
    }
    for (int i = 0; i < 40; i++) {          /* an end that points at the wall, and turns away */
        real w = 20 + 10 * i;
        quat q = quat_axis_angle((vec3){0, 0, 1}, 0.001 * i - 0.5 * 3.141592653589793);
        vec3 arm = quat_rotate(q, (vec3){0.02, 0.5, 0});
        Motion leaves = motion((pose){{-arm.x - 2e-10, 0, 0}, q}, (vec3){-0.025 * w, 0, 0}, (vec3){0, 0, w}, vec3_zero());
        int count;
        CHECK(gap_at(&wall, &stands, &rod, &leaves, 0) > 0);
        time_of_impact(&wall, &stands, &rod, &leaves, 0, 1.0 / 60, &count);
        CHECK(count <= 4);
    }
    shape_free(&rod);
    shape_free(&wall);
}

/* A barrel's turn about its own axis moves its surface along itself. */
TEST(what_rolls_beside_another_takes_one_gap)
{
    Shape barrel = fixture_cylinder(0.3, 1), capsule = fixture_capsule(0.3, 1);
    for (int i = 0; i < 20; i++) {
        Motion a = motion(at_point(0, 0, 0), vec3_zero(), (vec3){0, 40, 0}, vec3_zero());
        Motion b = motion(at_point(0.6 + 1e-8, 0, 0), (vec3){0, 1, 0}, (vec3){0, -5 * i, 0}, vec3_zero());
        int count;
        CHECK(isinf(time_of_impact(&barrel, &a, i % 2 ? &barrel : &capsule, &b, 0, 1.0 / 60, &count)));
        CHECK_INT(count, 1);
    }
    shape_free(&barrel);
    shape_free(&capsule);
}

/* And one that tumbles while it spins fast meets where the gaps say so. */
TEST(what_spins_about_its_own_axis_meets_at_the_target)
{
    Random r = {11};
    int met = 0;
    Shape barrel = fixture_cylinder(0.3, 1), capsule = fixture_capsule(0.3, 1);
    for (int i = 0; i < 60; i++) {
        const Shape *a = i % 2 ? &barrel : &capsule;
        Motion ma = motion((pose){vec3_zero(), random_turn(&r)}, random_vec3(&r, 1), vec3_zero(), vec3_zero()), mb = ma;
        ma.w = vec3_add(vec3_scale(40, quat_rotate(ma.start.q, (vec3){0, 1, 0})), random_vec3(&r, 4));
        mb.start = (pose){vec3_scale(2, random_direction(&r)), random_turn(&r)};
        mb.v = vec3_mad(random_vec3(&r, 1), -3, mb.start.p);
        mb.w = random_vec3(&r, 4);
        if (!(gap_at(a, &ma, &barrel, &mb, 0) > 0.05))
            continue;
        real t = time_of_impact(a, &ma, &barrel, &mb, 0, 1, NULL), end = real_min(t, 1);
        for (int k = 0; k < 300; k++)
            CHECK(gap_at(a, &ma, &barrel, &mb, end * k / 300) > -1e-11);
        if (t <= 1)
            CHECK_NEAR(gap_at(a, &ma, &barrel, &mb, t), 0, 1e-11);
        met += t <= 1;
    }
    CHECK(met > 20);
    shape_free(&barrel);
    shape_free(&capsule);
}

TEST(what_starts_at_the_target_counts_only_when_it_approaches)
{
    Shape floor = fixture_box(10, 2, 10), box = fixture_box(1, 1, 1);
    Motion ground = still(at_point(0, -1, 0)), m = motion(at_point(0, 0.5, 0), (vec3){0, 1, 0}, vec3_zero(), vec3_zero());
    CHECK(isinf(time_of_impact(&floor, &ground, &box, &m, 0, 1, NULL)));
    m.v.y = -1;
    CHECK_NEAR(time_of_impact(&floor, &ground, &box, &m, 0, 1, NULL), 0, 0);
    m.start.p.y = 0.4;
    CHECK_NEAR(time_of_impact(&floor, &ground, &box, &m, 0, 1, NULL), 0, 0);
    m.v.y = 1;
    CHECK(isinf(time_of_impact(&floor, &ground, &box, &m, 0, 1, NULL)));
    m = motion(at_point(0, 0.5, 0), (vec3){0, 0.1, 0}, (vec3){0, 0, 5}, vec3_zero());      /* rises slowly, one side comes down */
    CHECK_NEAR(time_of_impact(&floor, &ground, &box, &m, 0, 1, NULL), 0, 0);
    shape_free(&floor);
    shape_free(&box);
}

/* A flat patch of triangles: the sphere comes down on it as on a plane, wherever it lands. */
TEST(spheres_fall_on_meshes_and_height_fields_as_on_planes)
{
    enum { N = 9 };
    vec3 vertices[N * N];
    int64_t triangles[(N - 1) * (N - 1) * 6];
    real heights[N * N] = {0};
    int count = 0;
    for (int i = 0; i < N * N; i++)
        vertices[i] = (vec3){i % N - 4, 0, i / N - 4};
    for (int z = 0; z + 1 < N; z++)
        for (int x = 0; x + 1 < N; x++) {
            int64_t c = z * N + x + 1;
            int64_t six[6] = {c, c + N, c + 1, c + 1, c + N, c + N + 1};
            memcpy(triangles + count, six, sizeof six);
            count += 6;
        }
    Shape mesh = fixture_make("mesh", &(dig_mesh_def){{vertices, N * N}, {triangles, count}});
    Shape field = fixture_make("heightfield", &(dig_heightfield_def){.heights = heights, .columns = N, .rows = N, .size = {8, 0, 8}});
    Shape ball = fixture_sphere(0.05);
    Random r = {8};
    for (int i = 0; i < 200; i++) {
        Motion ground = still((pose){{0, -2, 0}, quat_identity()});
        Motion fall = motion((pose){{random_between(&r, -1, 1), 1, random_between(&r, -1, 1)}, quat_identity()},
                             (vec3){random_between(&r, -20, 20), -random_between(&r, 50, 2000), random_between(&r, -20, 20)}, vec3_zero(),
                             (vec3){0, -9.81, 0});
        real v = -fall.v.y, d = 3 - 0.05, want = 2 * d / (v + sqrt(v * v + 2 * 9.81 * d));
        CHECK_NEAR(time_of_impact(&mesh, &ground, &ball, &fall, 0, 0.1, NULL), want, 1e-13);
        CHECK_NEAR(time_of_impact(&ball, &fall, &field, &ground, 0, 0.1, NULL), want, 1e-13);
    }
    shape_free(&mesh);
    shape_free(&field);
    shape_free(&ball);
}

TEST(a_mesh_falls_on_a_plane_as_its_hull_does)
{
    vec3 corner[4] = {{0, 0, 0}, {0.3, 0, 0}, {0, 0.4, 0}, {0, 0, 0.5}};
    const int64_t sides[12] = {1, 2, 4, 1, 3, 2, 1, 4, 3, 2, 3, 4};
    Shape mesh = fixture_make("mesh", &(dig_mesh_def){{corner, 4}, {sides, 12}}), hull = fixture_hull(corner, 4);
    Shape floor = fixture_plane((vec3){0, 1, 0}, 0);
    Motion ground = still(pose_identity());
    Random r = {11};
    for (int i = 0; i < 200; i++) {
        vec3 spin = {random_between(&r, -20, 20), random_between(&r, -20, 20), random_between(&r, -20, 20)};
        Motion fall = motion((pose){{0, 2, 0}, random_turn(&r)}, (vec3){0, -random_between(&r, 5, 1000), 0}, spin, (vec3){0, -9.81, 0});
        real t = time_of_impact(&mesh, &fall, &floor, &ground, 0, 0.5, NULL);
        CHECK(t < 0.5);
        CHECK_NEAR(t, time_of_impact(&floor, &ground, &hull, &fall, 0, 0.5, NULL), 1e-9 * t);
    }
    shape_free(&mesh);
    shape_free(&hull);
    shape_free(&floor);
}

TEST(far_shapes_cost_no_gap_at_all)
{
    Shape a = fixture_box(1, 1, 1), b = fixture_cylinder(0.5, 1);
    Motion ma = motion(at_point(0, 0, 0), (vec3){1, 0, 0}, (vec3){1, 2, 3}, (vec3){0, -9.81, 0});
    Motion mb = motion(at_point(0, 30, 0), (vec3){0, -5, 0}, (vec3){1, 2, 3}, vec3_zero());
    int count = -1;
    CHECK(isinf(time_of_impact(&a, &ma, &b, &mb, 0, 1.0 / 60, &count)));
    CHECK_INT(count, 0);
    shape_free(&a);
    shape_free(&b);
}

int main(void)
{
    RUN_TESTS(unit_test(free_fall_of_a_sphere_takes_the_root_of_2h_over_g),
              unit_test(a_thrown_ball_that_does_not_reach_the_ceiling_meets_nothing),
              unit_test(a_turning_rod_meets_a_wall_when_its_end_gets_there), unit_test(fast_spheres_never_pass_a_thin_wall),
              unit_test(spinning_rods_are_never_missed), unit_test(tumbling_shapes_meet_at_the_target_and_not_before),
              unit_test(what_hinges_on_an_edge_takes_few_gaps), unit_test(a_rod_that_whirls_before_a_wall_takes_few_gaps),
              unit_test(what_rolls_beside_another_takes_one_gap),
              unit_test(what_spins_about_its_own_axis_meets_at_the_target),
              unit_test(what_starts_at_the_target_counts_only_when_it_approaches),
              unit_test(spheres_fall_on_meshes_and_height_fields_as_on_planes),
              unit_test(a_mesh_falls_on_a_plane_as_its_hull_does), unit_test(far_shapes_cost_no_gap_at_all));
}
