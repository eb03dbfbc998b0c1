/* tests/unit/test_wet.c - the part of a solid below a plane and the area it shows, against closed forms and against each other. */
#include <stdlib.h>

#include "check.h"
#include "geom/wet.h"

static Shape make(const char *type, const void *def)
{
    Shape s;
    char why[200] = "";
    if (shape_make(type, def, &s, why, sizeof why) != DIG_OK)
        fail_msg("%s", why);
    return s;
}

static real shadow(const Shape *s, vec3 direction) { return s->type->shadow(s, direction); }

static vec3 unit(real x, real y, real z) { return vec3_unit((vec3){x, y, z}); }

static const vec3 directions[] = {{0, 1, 0}, {0, -1, 0}, {1, 0, 0}, {0, 0, 1}, {1, 2, 3}, {-3, 0.2, 1}, {1e-7, 1, 0}, {1, 1e-9, 0}, {1, -1, 1}, {0, 1, -1}};
#define DIRECTIONS (sizeof directions / sizeof *directions)

/* What is below and what is above make the whole, volume and moment; and all of it wet is the whole. */
static void check_parts(const Shape *s, real tolerance)
{
    MassProps whole;
    s->type->mass(s, &whole);
    vec3 moment = vec3_scale(whole.volume, whole.centre);
    for (size_t i = 0; i < DIRECTIONS; i++)
        for (int k = -20; k <= 20; k++) {
            vec3 n = vec3_unit(directions[i]);
            real at = 0.0512 * k * s->outer;
            Wet below = shape_wet(s, n, at), above = shape_wet(s, vec3_neg(n), -at);
            CHECK_NEAR((below.volume + above.volume) / whole.volume, 1, tolerance);
            CHECK_NEAR(vec3_distance(vec3_add(below.moment, above.moment), moment) / (whole.volume * s->outer), 0, tolerance);
        }
}

/* Along the normal, volume grows by the area of the cut, and the moment by the height of the cut times that. */
static void check_growth(const Shape *s, real tolerance)
{
    MassProps whole;
    s->type->mass(s, &whole);
    for (size_t i = 0; i < DIRECTIONS; i++)
        for (int k = -9; k <= 9; k++) {
            vec3 n = vec3_unit(directions[i]);
            real at = 0.0973 * k * s->outer, h = 1e-4 * s->outer;
            Wet low = shape_wet(s, n, at - h), high = shape_wet(s, n, at + h);
            real grown = high.volume - low.volume, lifted = vec3_dot(n, vec3_sub(high.moment, low.moment));
            CHECK(grown >= -1e-13 * whole.volume);
            CHECK_NEAR((lifted - at * grown) / (whole.volume * s->outer), 0, tolerance);
        }
}

TEST(a_cap_of_a_ball_has_its_volume_and_centre)
{
    Shape s = make("sphere", &(dig_sphere_def){0.5});
    vec3 n = unit(1, 2, -2);
    real h = 0.2, volume = DIG_PI * h * h * (3 * 0.5 - h) / 3, down = 3 * (1 - h) * (1 - h) / (4 * (1.5 - h));
    Wet w = shape_wet(&s, n, h - 0.5);
    CHECK_NEAR(w.volume, volume, 1e-16);
    CHECK_NEAR(vec3_distance(w.moment, vec3_scale(-volume * down, n)), 0, 1e-16);
    check_parts(&s, 1e-14);
    check_growth(&s, 1e-9);
    shape_free(&s);
}

/* Upright: a slab. On its edge, half under: a triangle. Through three edges of a corner: a tetrahedron. */
TEST(a_box_is_cut_exactly)
{
    Shape s = make("box", &(dig_box_def){{2, 1, 4}});
    Wet slab = shape_wet(&s, (vec3){0, 1, 0}, 0.2);
    CHECK_NEAR(slab.volume, 2 * 0.7 * 4, 1e-14);
    CHECK_NEAR(slab.moment.y, slab.volume * (-0.5 + 0.35), 1e-14);
    Wet corner = shape_wet(&s, unit(1, 1, 1), (-1 - 0.5 - 2 + 0.3) / sqrt(3));
    CHECK_NEAR(corner.volume, 0.3 * 0.3 * 0.3 / 6, 1e-15);
    CHECK_NEAR(corner.moment.x / corner.volume, -1 + 0.3 / 4, 1e-12);
    CHECK_NEAR(corner.moment.z / corner.volume, -2 + 0.3 / 4, 1e-12);
    check_parts(&s, 1e-14);
    check_growth(&s, 1e-9);
    shape_free(&s);
}

/* Lying: a segment times the length. Upright: a slice. */
TEST(a_cylinder_is_cut_exactly)
{
    real r = 0.3, L = 2, t = 1.1;      /* half the angle of the wet segment */
    Shape s = make("cylinder", &(dig_cylinder_def){r, L});
    Wet lying = shape_wet(&s, (vec3){0.6, 0, 0.8}, -r * cos(t));
    CHECK_NEAR(lying.volume, L * r * r * (t - sin(t) * cos(t)), 1e-14);
    CHECK_NEAR(lying.moment.x, -0.6 * L * 2 / 3 * pow(r * sin(t), 3), 1e-14);
    CHECK_NEAR(shape_wet(&s, (vec3){0, 1, 0}, 0.4).volume, DIG_PI * r * r * 1.4, 1e-14);
    Wet hoof = shape_wet(&s, unit(1, 0.3, 0), unit(1, 0.3, 0).y * -1);     /* through a diameter of the bottom: 2/3 r^2 h, h = r / 0.3 */
    CHECK_NEAR(hoof.volume, 2.0 / 3 * r * r * (r / 0.3), 1e-12);
    check_parts(&s, 1e-12);
    check_growth(&s, 1e-8);
    shape_free(&s);
}

TEST(a_cone_is_cut_exactly)
{
    Shape s = make("cone", &(dig_cone_def){0.5, 1.2});
    Wet low = shape_wet(&s, (vec3){0, 1, 0}, 0.3);      /* a frustum: 0.6 above the base the radius is half */
    CHECK_NEAR(low.volume, DIG_PI * 0.25 * 1.2 / 3 * (1 - 0.125), 1e-14);
    Wet half = shape_wet(&s, (vec3){1, 0, 0}, 0);
    CHECK_NEAR(half.volume, DIG_PI * 0.25 * 1.2 / 6, 1e-13);
    CHECK_NEAR(half.moment.x, -0.25 * 1.2 * 0.5 / 6, 1e-13);       /* 2/3 r^3 integrated: r^3 h / 6 */
    check_parts(&s, 1e-9);
    check_growth(&s, 1e-7);
    shape_free(&s);
}

TEST(a_capsule_is_cut_exactly)
{
    real r = 0.25, L = 0.8, ball = 4.0 / 3 * DIG_PI * r * r * r;
    Shape s = make("capsule", &(dig_capsule_def){r, L});
    CHECK_NEAR(shape_wet(&s, (vec3){0, 1, 0}, -0.4).volume, ball / 2, 1e-14);
    CHECK_NEAR(shape_wet(&s, (vec3){0, 1, 0}, 0.1).volume, ball / 2 + DIG_PI * r * r * 0.5, 1e-14);
    real h = 0.1, cap = DIG_PI * h * h * (3 * r - h) / 3, t = acos((r - h) / r);
    CHECK_NEAR(shape_wet(&s, (vec3){0, 0, 1}, h - r).volume, cap + L * r * r * (t - sin(t) * cos(t)), 1e-13);
    check_parts(&s, 1e-9);
    check_growth(&s, 1e-7);
    shape_free(&s);
}

/* A hull of the corners of a box is that box. */
TEST(a_hull_is_cut_as_the_box_it_is)
{
    vec3 p[8];
    for (int i = 0; i < 8; i++)
        p[i] = (vec3){i & 1 ? 1 : -1, i & 2 ? 0.5 : -0.5, i & 4 ? 2 : -2};
    Shape hull = make("hull", &(dig_hull_def){{p, 8}}), box = make("box", &(dig_box_def){{2, 1, 4}});
    for (size_t i = 0; i < DIRECTIONS; i++)
        for (int k = -10; k <= 10; k++) {
            vec3 n = vec3_unit(directions[i]);
            Wet a = shape_wet(&hull, n, 0.2 * k), b = shape_wet(&box, n, 0.2 * k);
            CHECK_NEAR(a.volume, b.volume, 1e-13);
            CHECK_NEAR(vec3_distance(a.moment, b.moment), 0, 1e-13);
            CHECK_NEAR(shadow(&hull, n), shadow(&box, n), 1e-13);
        }
    shape_free(&hull);
    shape_free(&box);
}

/* A convex body's mean shadow over all directions is a quarter of its surface (Cauchy). */
static real mean_shadow(const Shape *s)
{
    real sum = 0;
    int n = 2000, turns = 400;
    for (int i = 0; i < n; i++)
        for (int k = 0; k < turns; k++) {
            real y = -1 + (2 * i + 1.0) / n, r = sqrt(1 - y * y), a = 2 * DIG_PI * (k + 0.5) / turns;
            sum += shadow(s, (vec3){r * cos(a), y, r * sin(a)});
        }
    return sum / n / turns;
}

TEST(the_mean_shadow_is_a_quarter_of_the_surface)
{
    real r = 0.3, h = 0.8;
    Shape box = make("box", &(dig_box_def){{1, 2, 3}}), ball = make("sphere", &(dig_sphere_def){r});
    Shape tube = make("cylinder", &(dig_cylinder_def){r, h}), pill = make("capsule", &(dig_capsule_def){r, h}), cone = make("cone", &(dig_cone_def){r, h});
    CHECK_NEAR(mean_shadow(&box) / 5.5, 1, 1e-5);
    CHECK_NEAR(mean_shadow(&ball) / (DIG_PI * r * r), 1, 1e-10);
    CHECK_NEAR(mean_shadow(&tube) / (DIG_PI * r * (r + h) / 2), 1, 1e-5);
    CHECK_NEAR(mean_shadow(&pill) / (DIG_PI * r * (2 * r + h) / 2), 1, 1e-5);
    CHECK_NEAR(mean_shadow(&cone) / (DIG_PI * r * (r + sqrt(r * r + h * h)) / 4), 1, 1e-5);
    shape_free(&box);
    shape_free(&ball);
    shape_free(&tube);
    shape_free(&pill);
    shape_free(&cone);
}

int main(void)
{
    RUN_TESTS(unit_test(a_cap_of_a_ball_has_its_volume_and_centre), unit_test(a_box_is_cut_exactly), unit_test(a_cylinder_is_cut_exactly),
              unit_test(a_cone_is_cut_exactly), unit_test(a_capsule_is_cut_exactly), unit_test(a_hull_is_cut_as_the_box_it_is),
              unit_test(the_mean_shadow_is_a_quarter_of_the_surface));
}
