/* tests/unit/test_medium.c - the mean force of drag over a substep, against closed forms. */
#include "check.h"
#include "solve/medium.h"

static const vec3 none = {0, 0, 0};

/* One substep after the other; returns the velocity against the medium. */
static vec3 run(vec3 u, vec3 a, real k, real c, real h, int steps)
{
    for (int i = 0; i < steps; i++)
        u = vec3_mad(u, h, vec3_add(a, medium_slowing(u, a, k, c, h)));
    return u;
}

/* u0 / (1 + k u0 t) and u0 e^(-c t), in any number of substeps. */
TEST(coasting_is_exact_for_any_step)
{
    for (int n = 1; n <= 1000; n *= 10) {
        for (real k = 1e-6; k < 1e7; k *= 100)
            CHECK_NEAR(run((vec3){0, 0, 30}, none, k, 0, 2.0 / n, n).z, 30 / (1 + k * 30 * 2), 1e-12);
        for (real c = 1e-6; c < 1e7; c *= 100)
            CHECK_NEAR(run((vec3){3, 0, 0}, none, 0, c, 2.0 / n, n).x, 3 * exp(-2 * c), 1e-12);
    }
}

/* v = vt tanh(g t / vt); and thrown up at u, it turns after vt / g atan(u / vt). */
TEST(falling_follows_the_hyperbolic_tangent_for_any_step)
{
    const real g = 9.81, k = 0.05, vt = sqrt(g / k);
    for (int n = 1; n <= 1024; n *= 4) {
        CHECK_NEAR(run(none, (vec3){0, -g, 0}, k, 0, 3.0 / n, n).y, -vt * tanh(g * 3 / vt), 1e-12);
        real up = vt / g * atan(20 / vt);
        CHECK_NEAR(run((vec3){0, 20, 0}, (vec3){0, -g, 0}, k, 0, 3.0 / n, n).y, -vt * tanh(g * (3 - up) / vt), 1e-12);
    }
}

TEST(terminal_speed_is_kept_exactly_and_never_passed)
{
    for (real k = 1e-6; k < 1e9; k *= 10)
        for (real h = 1e-5; h < 2; h *= 10) {
            real vt = sqrt(9.81 / k);
            vec3 a = {0, -9.81, 0};
            CHECK_NEAR(run((vec3){0, -vt, 0}, a, k, 0, h, 100).y / vt, -1, 1e-10);
            vec3 u = none;
            for (int i = 0; i < 200; i++) {
                vec3 next = run(u, a, k, 0, h, 1);
                CHECK(next.y >= -vt * (1 + 1e-10) && next.y <= u.y * (1 - 1e-10));
                u = next;
            }
        }
    real both = (-0.3 + sqrt(0.09 + 4 * 0.05 * 9.81)) / (2 * 0.05);        /* c u + k u^2 = g */
    CHECK_NEAR(run((vec3){0, -both, 0}, (vec3){0, -9.81, 0}, 0.05, 0.3, 1.0 / 240, 50).y, -both, 1e-5);
}

/* A feather in a gale: after one long step it goes with the wind, and not faster. */
TEST(a_light_body_does_not_overshoot_the_wind)
{
    for (real k = 1; k < 1e12; k *= 10) {
        vec3 u = run((vec3){-40, 0, 0}, (vec3){0, -9.81, 0}, k, 0, 1.0 / 60, 1);
        CHECK(u.x <= 0 && u.x > -40 / (1 + 0.9 * k * 40 / 60));
    }
}

/* Slanted: the sizes of errors at two steps tell the order, two. */
TEST(a_throw_converges_with_the_square_of_the_step)
{
    vec3 u = {12, 9, 0}, a = {0, -9.81, 0}, fine = run(u, a, 0.03, 0, 2.0 / 65536, 65536);
    real before = vec3_distance(run(u, a, 0.03, 0, 2.0 / 120, 120), fine), error = vec3_distance(run(u, a, 0.03, 0, 2.0 / 240, 240), fine);
    CHECK(error < 3e-4);
    CHECK_NEAR(before / error, 4, 0.25);
}

/* What other ways use as the force of this instant. */
TEST(over_no_time_it_is_the_plain_law)
{
    vec3 u = {3, -4, 12}, s = medium_slowing(u, (vec3){1, -9.81, 2}, 0.7, 0.2, 1e-14);
    CHECK_NEAR(vec3_distance(s, vec3_scale(-(0.2 + 0.7 * 13), u)), 0, 2e-11);
    CHECK_NEAR(vec3_length(medium_slowing(none, (vec3){0, -9.81, 0}, 0.7, 0.2, 1e-14)), 0, 1e-12);
}

int main(void)
{
    RUN_TESTS(unit_test(coasting_is_exact_for_any_step), unit_test(falling_follows_the_hyperbolic_tangent_for_any_step),
              unit_test(terminal_speed_is_kept_exactly_and_never_passed), unit_test(a_light_body_does_not_overshoot_the_wind),
              unit_test(a_throw_converges_with_the_square_of_the_step), unit_test(over_no_time_it_is_the_plain_law));
}
