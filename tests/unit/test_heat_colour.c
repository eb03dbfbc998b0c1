/* tests/unit/test_heat_colour.c - what temperatures look like: the glow of black bodies, and false colours with their scale. */
#include "check.h"

#include "render/heat.h"

/* Row 47: what is hot is seen to glow from the Draper point on, first red, then yellower and brighter. */
TEST(hot_bodies_glow)
{
    float dull[3], red[3], white[3];
    CHECK_NEAR(heat_glow(300, dull), 0, 0);
    CHECK_NEAR(heat_glow(HEAT_DRAPER, dull), 0, 0);
    CHECK_NEAR(heat_glow(NAN, dull), 0, 0);
    real some = heat_glow(HEAT_DRAPER + 1, dull), more = heat_glow(1000, red), most = heat_glow(2500, white);
    CHECK(some > 0 && more > some && most > more && most <= heat_glow(1e7, white));
    CHECK_NEAR(red[0], 1, 0);
    CHECK(dull[1] < red[1] && red[2] < red[1]);
    /* Planck: the ratio of two wavelengths is (a / b)^5 (e^(c2 / b T) - 1) / (e^(c2 / a T) - 1) */
    CHECK_NEAR(red[1], pow(0.612 / 0.549, 5) * expm1(14387.77 / 612) / expm1(14387.77 / 549), 1e-6);
    heat_glow(6500, white);
    CHECK(white[1] > 0.8 && white[2] > 0.7);        /* daylight */
}

TEST(false_colours_rise)
{
    float a[3], b[3];
    real before = -1;
    for (int i = 0; i <= 20; i++) {
        heat_colour(i / 20.0, a);
        real light = 0.2126 * (real)a[0] + 0.7152 * (real)a[1] + 0.0722 * (real)a[2];
        CHECK(light > before);
        before = light;
    }
    heat_colour(-3, a);
    heat_colour(0, b);
    CHECK_NEAR(a[0], b[0], 0);
    heat_colour(7, a);
    heat_colour(1, b);
    CHECK_NEAR(a[1], b[1], 0);
}

TEST(the_scale_ends_at_whole_fifties)
{
    ViewItem items[3] = {{.temperature = 293}, {.temperature = 0}, {.temperature = 812}};
    View v = {.items = items, .item_count = 3};
    HeatScale s = heat_scale(&v);
    CHECK(s.on);
    CHECK_NEAR(s.low, 250, 0);
    CHECK_NEAR(s.high, 850, 0);
    v.item_count = 0;
    CHECK(!heat_scale(&v).on);
    items[0].temperature = 300;
    v.item_count = 1;
    s = heat_scale(&v);
    CHECK_NEAR(s.low, 300, 0);
    CHECK_NEAR(s.high, 350, 0);
}

int main(void)
{
    RUN_TESTS(unit_test(hot_bodies_glow), unit_test(false_colours_rise), unit_test(the_scale_ends_at_whole_fifties));
}
