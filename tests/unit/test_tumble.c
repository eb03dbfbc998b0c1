/* tests/unit/test_tumble.c - free bodies that turn far, in closed form.
 *
 * References: q' = q w / 2 in long double with steps so small that their error is below the digits asked for; the rotor of the
 * acceptance suite, A09, from Jacobi's elliptic functions.
 */
#include "trace_fixture.h"

#include "physics_fixture.h"

typedef long double wide;

/* w = I^-1 R^T L, and q w / 2 */
static void rate(const wide *d, const wide *momentum, const wide *q, wide *out)
{
    wide x = q[0], y = q[1], z = q[2], w = q[3];
    const wide r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                          {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                          {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
    wide o[3];
    for (int i = 0; i < 3; i++)
        o[i] = d[i] * (r[0][i] * momentum[0] + r[1][i] * momentum[1] + r[2][i] * momentum[2]) / 2;
    out[0] = w * o[0] + y * o[2] - z * o[1];
    out[1] = w * o[1] + z * o[0] - x * o[2];
    out[2] = w * o[2] + x * o[1] - y * o[0];
    out[3] = -x * o[0] - y * o[1] - z * o[2];
}

/* Classical Runge-Kutta; inverse: 1 / (kg m^2) */
static quat followed(vec3 inverse, quat from, vec3 momentum, real time, int steps)
{
    static const wide at[4] = {0, 0.5L, 0.5L, 1}, weight[4] = {1 / 6.0L, 1 / 3.0L, 1 / 3.0L, 1 / 6.0L};
    const wide d[3] = {inverse.x, inverse.y, inverse.z}, l[3] = {momentum.x, momentum.y, momentum.z}, h = (wide)time / steps;
    wide q[4] = {from.x, from.y, from.z, from.w};
    for (int s = 0; s < steps; s++) {
        wide k[4] = {0, 0, 0, 0}, sum[4] = {0, 0, 0, 0}, norm = 0;
        for (int i = 0; i < 4; i++) {
            wide y[4];
            for (int n = 0; n < 4; n++)
                y[n] = q[n] + h * at[i] * k[n];
            rate(d, l, y, k);
            for (int n = 0; n < 4; n++)
                sum[n] += weight[i] * k[n];
        }
        for (int n = 0; n < 4; n++) {
            q[n] += h * sum[n];
            norm += q[n] * q[n];
        }
        for (int n = 0; n < 4; n++)
            q[n] /= sqrtl(norm);
    }
    return (quat){(real)q[0], (real)q[1], (real)q[2], (real)q[3]};
}

static bool turn_on(vec3 inverse, quat *q, vec3 momentum, real h)
{
    mat3 m = {{inverse.x, 0, 0}, {0, inverse.y, 0}, {0, 0, inverse.z}};
    return tumble(&m, q, momentum, h);
}

static real part(uint32_t *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return 2 * ((real)(*seed >> 8) / 16777216) - 1;
}

static vec3 some(uint32_t *seed) { return (vec3){part(seed), part(seed), part(seed)}; }

/* Boxes of all proportions, in all orders of their axes, that turn about any or nearly about one. */
TEST(what_tumbles_is_where_small_steps_take_it)
{
    uint32_t seed = 7;
    for (int i = 0; i < 60; i++) {
        real spread = i % 3 == 0 ? 0.05 : 1, time = i % 2 ? 12 : 0.6;
        vec3 s = some(&seed), near = vec3_scale(i % 4 == 1 ? 1e-3 : 1, some(&seed));
        real a = pow(8, spread * s.x), b = pow(8, spread * s.y), c = pow(8, spread * s.z);
        vec3 inverse = {1 / (b + c), 1 / (c + a), 1 / (a + b)}, body = i % 4 == 1 ? vec3_add(near, (vec3){i % 3 == 0, i % 3 == 1, i % 3 == 2}) : near;
        quat q = quat_exp(vec3_scale(3, some(&seed)));
        body = vec3_scale(1 / vec3_length(vec3_mul(inverse, body)), body);              /* 1 rad/s */
        vec3 l = quat_rotate(q, body);
        quat got = q;
        CHECK(turn_on(inverse, &got, l, time));
        CHECK_NEAR(quat_norm2(got), 1, 1e-15);
        CHECK_NEAR(angle_between(got, followed(inverse, q, l, time, i % 2 ? 12000 : 2000)), 0, 1e-10);
    }
}

TEST(a_rotor_that_tumbles_has_the_digits_of_the_elliptic_functions)
{
    const quat want10 = {.w = 0.04708551769268645, .x = -0.33976629267684835, .y = -0.04007006820467736, .z = -0.93847547118628223};
    const quat want100 = {.w = 0.47774288782843050, .x = -0.07104353449489409, .y = 0.87211101831220062, .z = 0.07833850314041581};
    const vec3 inertia = {0.4 / 12, 1.04 / 12, 1.36 / 12}, spin = {0.1, 5, 0.1};
    const vec3 inverse = {1 / inertia.x, 1 / inertia.y, 1 / inertia.z}, l = vec3_mul(inertia, spin);
    quat q = quat_identity();
    CHECK(turn_on(inverse, &q, l, 10));
    CHECK_NEAR(angle_between(q, want10), 0, 1e-10);
    q = quat_identity();
    CHECK(turn_on(inverse, &q, l, 100));
    CHECK_NEAR(angle_between(q, want100), 0, 1e-9);
}

/* The axes themselves, and what only rounding parts from the separatrix: the first is a turn, the second is not for it. */
TEST(what_turns_about_an_axis_does_so_and_a_separatrix_is_left_alone)
{
    const vec3 inverse = {1, 0.5, 0.4};
    for (int i = 0; i < 3; i++) {
        vec3 l = {i == 0, i == 1, i == 2};
        quat q = quat_identity();
        bool turned = turn_on(inverse, &q, l, 7);
        CHECK(turned == (i != 1));
        CHECK_NEAR(angle_between(q, turned ? quat_exp(vec3_scale(7, vec3_mul(inverse, l))) : quat_identity()), 0, 1e-14);
    }
    quat q = quat_identity();
    CHECK(!turn_on(inverse, &q, (vec3){sqrt(0.1), 0, sqrt(0.5)}, 7));
    CHECK(!turn_on(inverse, &q, (vec3){INFINITY, 0, 1}, 7));
}

/* 3000 to 60,000 rad at once, whole periods of which are taken together, as in sixty-four goes. */
TEST(what_tumbles_very_far_is_where_many_turns_take_it)
{
    uint32_t seed = 11;
    for (int i = 0; i < 40; i++) {
        vec3 s = some(&seed), inverse = {1 / (1 + 0.5 * s.x), 1 / (2 + 0.3 * s.y), 1 / (3.5 + s.z)}, l = some(&seed);
        quat q = quat_exp(vec3_scale(3, some(&seed))), at_once = q, little = q;
        real time = i % 2 ? 6e4 : 3e3;
        l = vec3_scale(1 / vec3_length(vec3_mul(inverse, quat_unrotate(q, l))), l);     /* 1 rad/s */
        CHECK(turn_on(inverse, &at_once, l, time));
        for (int k = 0; k < 64; k++)
            CHECK(turn_on(inverse, &little, l, time / 64));
        CHECK_NEAR(angle_between(at_once, little), 0, 1e-14 * time);
    }
}

/* Of axes that lie anywhere, and of two that are the same. */
TEST(what_has_other_axes_tumbles_as_about_its_own)
{
    uint32_t seed = 5;
    for (int i = 0; i < 20; i++) {
        vec3 inverse = {1, i % 4 == 0 ? 1 : 0.5, 0.3}, l = some(&seed);
        quat own = quat_exp(vec3_scale(3, some(&seed))), from = quat_exp(vec3_scale(3, some(&seed)));
        mat3 axes = quat_matrix(own), d = {{inverse.x, 0, 0}, {0, inverse.y, 0}, {0, 0, inverse.z}};
        mat3 inertia = mat3_mul(axes, mat3_mul(d, mat3_transpose(axes)));
        quat got = from, want = quat_mul(from, own);
        CHECK(tumble_far(&inertia, &got, l, 100));
        if (i % 4 == 0)
            want = tumble_about(&d, want, l, 100, 2);
        else
            CHECK(turn_on(inverse, &want, l, 100));
        CHECK_NEAR(angle_between(got, quat_mul(want, quat_conjugate(own))), 0, 1e-11);
    }
}

int main(void)
{
    RUN_TESTS(unit_test(what_tumbles_very_far_is_where_many_turns_take_it), unit_test(what_has_other_axes_tumbles_as_about_its_own),
              unit_test(what_tumbles_is_where_small_steps_take_it),
              unit_test(a_rotor_that_tumbles_has_the_digits_of_the_elliptic_functions),
              unit_test(what_turns_about_an_axis_does_so_and_a_separatrix_is_left_alone));
}
