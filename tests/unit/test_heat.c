/* tests/unit/test_heat.c - the kernels of heat: contact conductance (T9), who takes what friction makes, the area of a contact. */
#include "check.h"

#include "effect/heat.h"

static const HeatWorld usual = {HEAT_AMBIENT, 0, 1e5, 1e8};

TEST(pressure_conducts)
{
    real once = heat_contact(&usual, 45, 45, 10, 0.01);
    CHECK_NEAR(once, 1.25 * 45 * 1e5 * 0.01 * pow(1e3 / 1e8, 0.95), 1e-12 * once);
    CHECK_NEAR(heat_contact(&usual, 45, 45, 20, 0.01) / once, 1.931873, 1e-6);
    CHECK_NEAR(heat_contact(&usual, 45, 45, 10, 0.005) / once, 0.965936, 1e-6);
    CHECK_NEAR(heat_contact(&usual, 90, 45, 10, 0.01) / once, 4.0 / 3, 1e-12);      /* harmonic mean */
    CHECK_NEAR(heat_contact(&usual, 0, 45, 10, 0.01), 0, 0);
    CHECK_NEAR(heat_contact(&usual, 0, 0, 10, 0.01), 0, 0);
    CHECK_NEAR(heat_contact(&usual, 45, 45, 0, 0.01), 0, 0);
    CHECK_NEAR(heat_contact(&usual, 45, 45, -1, 0.01), 0, 0);
    CHECK_NEAR(heat_contact(&usual, 45, 45, 10, 0), 0, 0);
}

TEST(rubbing_heats_both)
{
    CHECK_NEAR(heat_share(100, 300), 0.25, 1e-15);
    CHECK_NEAR(heat_share(100, 300) + heat_share(300, 100), 1, 1e-15);
    CHECK_NEAR(heat_share(0, 0), 0.5, 0);
    CHECK_NEAR(heat_share(5, 0), 1, 0);
}

TEST(contacts_have_areas)
{
    Manifold m = {.normal = {0, 1, 0}, .count = 4, .points = {{.a = {0, 0, 0}}, {.a = {0, 0, 0.2}}, {.a = {0.3, 0, 0.2}}, {.a = {0.3, 0, 0}}}};
    CHECK_NEAR(heat_area(&m), 0.06, 1e-15);
    m.normal = (vec3){0, -1, 0};
    CHECK_NEAR(heat_area(&m), 0.06, 1e-15);
    m.count = 2;
    CHECK_NEAR(heat_area(&m), 0.2 * 1e-3, 1e-15);
    m.count = 1;
    CHECK_NEAR(heat_area(&m), 1e-6, 1e-18);
    m.count = 0;
    CHECK_NEAR(heat_area(&m), 1e-6, 1e-18);
}

int main(void)
{
    RUN_TESTS(unit_test(pressure_conducts), unit_test(rubbing_heats_both), unit_test(contacts_have_areas));
}
