/* tests/unit/test_mass.c - masses of compounds and polyhedra against closed forms and against each other. */
#include <stdlib.h>

#include "check.h"
#include "geom/mass.h"

static void check_mat3(mat3 got, mat3 want, real tolerance)
{
    CHECK_NEAR(got.r0.x, want.r0.x, tolerance);
    CHECK_NEAR(got.r0.y, want.r0.y, tolerance);
    CHECK_NEAR(got.r0.z, want.r0.z, tolerance);
    CHECK_NEAR(got.r1.x, want.r1.x, tolerance);
    CHECK_NEAR(got.r1.y, want.r1.y, tolerance);
    CHECK_NEAR(got.r1.z, want.r1.z, tolerance);
    CHECK_NEAR(got.r2.x, want.r2.x, tolerance);
    CHECK_NEAR(got.r2.y, want.r2.y, tolerance);
    CHECK_NEAR(got.r2.z, want.r2.z, tolerance);
}

static void check_vec3(vec3 got, vec3 want, real tolerance)
{
    CHECK_NEAR(got.x, want.x, tolerance);
    CHECK_NEAR(got.y, want.y, tolerance);
    CHECK_NEAR(got.z, want.z, tolerance);
}

/* Closed form of a block of density 1. */
static MassProps block(real x, real y, real z)
{
    real m = x * y * z;
    vec3 moments = {m * (y * y + z * z) / 12, m * (z * z + x * x) / 12, m * (x * x + y * y) / 12};
    return (MassProps){.volume = m, .inertia = mat3_diagonal(moments)};
}

/* A block between two corners as 12 triangles. */
static void block_surface(vec3 low, vec3 high, vec3 vertices[8], uint32_t triangles[36])
{
    static const uint32_t faces[36] = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                                       2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
    for (int i = 0; i < 8; i++)
        vertices[i] = (vec3){i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z};
    memcpy(triangles, faces, sizeof faces);
}

TEST(two_half_boxes_are_one_box)
{
    MassProps half = block(0.5, 2, 3), whole = block(1, 2, 3), sum = {0};
    pose left = pose_identity(), right = pose_identity();
    left.p.x = 9.75;
    right.p.x = 10.25;
    mass_add(&sum, &half, 700, left);
    mass_add(&sum, &half, 700, right);

    CHECK_NEAR(sum.mass, 4200, 1e-9);
    check_vec3(sum.centre, (vec3){10, 0, 0}, 1e-14);
    check_mat3(sum.inertia, mat3_scale(700, whole.inertia), 1e-9);
}

/* 4 kg of density 2 at x = 0 and 12 kg of density 6 at x = 1, cubes of 2 m^3: centre at 0.75, and the reduced mass
 * 4 * 12 / 16 = 3 kg carries the distance of 1 m. */
TEST(unlike_densities_meet_at_the_lever_point)
{
    real side = cbrt(2), own = 2 * side * side / 6;
    MassProps cube = block(side, side, side), sum = {0};
    pose at = pose_identity();
    mass_add(&sum, &cube, 2, at);
    at.p.x = 1;
    mass_add(&sum, &cube, 6, at);
    CHECK_NEAR(sum.mass, 16, 1e-13);
    check_vec3(sum.centre, (vec3){0.75, 0, 0}, 1e-14);
    check_mat3(sum.inertia, mat3_diagonal((vec3){8 * own, 8 * own + 3, 8 * own + 3}), 1e-13);
}

TEST(a_quarter_turn_swaps_the_moments)
{
    MassProps b = block(1, 2, 4);
    quat about_z = quat_axis_angle((vec3){0, 0, 1}, DIG_PI / 2);
    mat3 turned = inertia_turn(b.inertia, about_z);
    check_mat3(turned, block(2, 1, 4).inertia, 1e-14);
}

/* A rod along x turned by 45 degrees about z: I_xx = I_yy = half, I_xy = -half of the moment across. */
TEST(a_diagonal_rod_has_products_of_inertia)
{
    mat3 rod = mat3_diagonal((vec3){0, 12, 12});
    mat3 got = inertia_turn(rod, quat_axis_angle((vec3){0, 0, 1}, DIG_PI / 4));
    check_mat3(got, (mat3){{6, -6, 0}, {-6, 6, 0}, {0, 0, 12}}, 1e-14);
}

TEST(a_turned_and_moved_box_is_where_its_pose_puts_it)
{
    MassProps b = block(1, 2, 4), sum = {0};
    b.centre = (vec3){0, 1, 0};
    pose at = {{5, 0, 0}, quat_axis_angle((vec3){0, 0, 1}, DIG_PI / 2)};
    mass_add(&sum, &b, 1, at);
    check_vec3(sum.centre, (vec3){4, 0, 0}, 1e-14);
    check_mat3(sum.inertia, block(2, 1, 4).inertia, 1e-14);
}

TEST(the_order_of_parts_does_not_matter)
{
    MassProps parts[3] = {block(1, 2, 3), block(0.1, 0.2, 0.3), block(2, 0.5, 1)}, forward = {0}, backward = {0};
    pose at[3] = {{{1, 2, 3}, quat_exp((vec3){0.3, 0.2, 0.1})}, {{-4, 0, 1}, quat_exp((vec3){1, -2, 0})},
                  {{0, 9, 0}, quat_exp((vec3){0, 0, 2})}};
    for (int i = 0; i < 3; i++)
        mass_add(&forward, &parts[i], 1 + i, at[i]);
    for (int i = 2; i >= 0; i--)
        mass_add(&backward, &parts[i], 1 + i, at[i]);
    CHECK_NEAR(forward.mass, backward.mass, 1e-14);
    check_vec3(forward.centre, backward.centre, 1e-14);
    check_mat3(forward.inertia, backward.inertia, 1e-11);
}

/* 1e8 m from the origin a double resolves 1.5e-8 m: the inertia must not lose more than that says. */
TEST(far_from_the_origin_no_inertia_is_lost)
{
    MassProps half = block(0.5, 2, 3), sum = {0};
    pose at = pose_identity();
    at.p.x = 1e8 - 0.25;
    mass_add(&sum, &half, 1, at);
    at.p.x = 1e8 + 0.25;
    mass_add(&sum, &half, 1, at);
    check_mat3(sum.inertia, block(1, 2, 3).inertia, 1e-7);
}

TEST(a_given_mass_scales_the_inertia)
{
    MassProps sum = {0};
    MassProps b = block(1, 2, 3);
    mass_scale(&sum, 10);
    CHECK(sum.mass == 0);
    mass_add(&sum, &b, 1000, pose_identity());
    mass_scale(&sum, 3);
    CHECK_NEAR(sum.mass, 3, 1e-15);
    check_mat3(sum.inertia, mat3_scale(0.5, b.inertia), 1e-13);
}

TEST(a_box_of_triangles_is_a_box)
{
    vec3 v[8];
    uint32_t t[36];
    MassProps got, want = block(1, 2, 3);
    block_surface((vec3){100, 200, 300}, (vec3){101, 202, 303}, v, t);
    mass_of_triangles(v, t, 12, &got);
    CHECK_NEAR(got.volume, 6, 1e-11);
    check_vec3(got.centre, (vec3){100.5, 201, 301.5}, 1e-12);
    check_mat3(got.inertia, want.inertia, 1e-11);

    for (int i = 0; i < 36; i += 3) {           /* inside out */
        uint32_t swap = t[i];
        t[i] = t[i + 1];
        t[i + 1] = swap;
    }
    mass_of_triangles(v, t, 12, &got);
    CHECK_NEAR(got.volume, -6, 1e-11);
}

/* Corner tetrahedron x + y + z <= 1: integral x^2 = 1/60, integral x y = 1/120, V = 1/6, centre 1/4. About the centre
 * I_xx = 2/60 - V (2/16) = 1/80 and I_xy = -(1/120 - V/16) = 1/480. */
TEST(the_corner_tetrahedron_has_its_closed_form)
{
    const vec3 v[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const uint32_t t[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    MassProps got;
    mass_of_triangles(v, t, 4, &got);
    CHECK_NEAR(got.volume, 1.0 / 6, 1e-16);
    check_vec3(got.centre, (vec3){0.25, 0.25, 0.25}, 1e-16);
    real a = 1.0 / 80, b = 1.0 / 480;
    check_mat3(got.inertia, (mat3){{a, b, b}, {b, a, b}, {b, b, a}}, 1e-16);
}

/* Latitudes and longitudes of a ball of radius 1, n bands: the error must fall with the square of the spacing. */
static MassProps faceted_ball(int n)
{
    int around = 2 * n, triangle = 0;
    vec3 *v = malloc((size_t)((n + 1) * around) * sizeof *v);
    uint32_t *t = malloc((size_t)(6 * n * around) * sizeof *t);
    MassProps m = {0};
    assert_non_null(v);
    assert_non_null(t);
    for (int j = 0; j <= n; j++)
        for (int k = 0; k < around; k++) {
            real a = DIG_PI * j / n, b = 2 * DIG_PI * k / around;
            v[j * around + k] = (vec3){sin(a) * cos(b), sin(a) * sin(b), cos(a)};
        }
    for (int j = 0; j < n; j++)
        for (int k = 0; k < around; k++, triangle += 2) {
            uint32_t p = (uint32_t)(j * around + k), q = (uint32_t)(j * around + (k + 1) % around), down = (uint32_t)around;
            const uint32_t two[6] = {p, p + down, q + down, p, q + down, q};
            memcpy(t + 3 * triangle, two, sizeof two);
        }
    mass_of_triangles(v, t, triangle, &m);
    free(v);
    free(t);
    return m;
}

TEST(a_faceted_ball_converges_to_the_ball)
{
    real volume = 4 * DIG_PI / 3, I = 8 * DIG_PI / 15, last_v = 0, last_i = 0;
    for (int n = 8; n <= 128; n *= 2) {
        MassProps m = faceted_ball(n);
        real ev = fabs(m.volume - volume), ei = fabs(m.inertia.r0.x - I);
        check_vec3(m.centre, vec3_zero(), 1e-14);
        if (n > 8) {
            CHECK_NEAR(last_v / ev, 4, 0.3);
            CHECK_NEAR(last_i / ei, 4, 0.3);
        }
        last_v = ev;
        last_i = ei;
    }
    CHECK_NEAR(last_v / volume, 0, 1e-3);
    CHECK_NEAR(last_i / I, 0, 1e-3);
}

int main(void)
{
    RUN_TESTS(unit_test(two_half_boxes_are_one_box), unit_test(unlike_densities_meet_at_the_lever_point),
              unit_test(a_quarter_turn_swaps_the_moments), unit_test(a_diagonal_rod_has_products_of_inertia),
              unit_test(a_turned_and_moved_box_is_where_its_pose_puts_it), unit_test(the_order_of_parts_does_not_matter),
              unit_test(far_from_the_origin_no_inertia_is_lost), unit_test(a_given_mass_scales_the_inertia),
              unit_test(a_box_of_triangles_is_a_box), unit_test(the_corner_tetrahedron_has_its_closed_form),
              unit_test(a_faceted_ball_converges_to_the_ball));
}
