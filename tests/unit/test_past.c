/* tests/unit/test_past.c - what was before a moment: the points of trails, the rows of energies, and that neither depends on how it was fed. */
#include "check.h"

#include <stdlib.h>
#include <string.h>

#include "view/past.h"

static const real step = 1.0 / 120;      /* s: a point every 4 steps */

static vec3 place(uint64_t n) { return (vec3){(real)n, 2, 0}; }

static dig_energy energy(uint64_t n) { return (dig_energy){.kinetic = (real)n, .potential = 2, .elastic = 3, .heat = 4, .lost = 5}; }

static void feed(Past *p, uint64_t from, uint64_t to)
{
    for (uint64_t n = from; n <= to; n++) {
        dig_energy e = energy(n);
        past_energy(p, n, &e);
        past_begin(p, n);
        CHECK_INT(past_point(p, 1, 7, place(n)), DIG_OK);
    }
}

static real point(const ViewPast *v, int trail, int i) { return v->trails[3 * (trail * v->trail_length + i)]; }

TEST(a_trail_has_the_last_second_and_now)
{
    Past p;
    ViewPast v;
    past_open(&p, 0, step);
    feed(&p, 0, 202);
    CHECK_INT(past_show(&p, &v), DIG_OK);
    CHECK_INT(v.trail_count, 2);
    CHECK_INT(v.trail_length, PAST_POINTS);
    CHECK_NEAR(point(&v, 1, PAST_POINTS - 1), 202, 0);      /* now, half a stride after the point before it */
    CHECK_NEAR(v.head, 0.5, 0);
    for (int i = 0; i < PAST_POINTS - 1; i++)
        CHECK_NEAR(point(&v, 1, i), 200 - 4.0 * (PAST_POINTS - 2 - i), 0);
    CHECK(isnan(point(&v, 0, 5)));                    /* nothing is in slot 0 */
    feed(&p, 203, 204);
    CHECK_INT(past_show(&p, &v), DIG_OK);
    CHECK_NEAR(v.head, 1, 0);
    CHECK_NEAR(point(&v, 1, PAST_POINTS - 2), 200, 0);
    past_close(&p);
}

TEST(it_begins_where_it_was_told_to)
{
    Past p;
    ViewPast v;
    past_open(&p, 100, step);
    feed(&p, 90, 109);
    CHECK_INT(past_show(&p, &v), DIG_OK);
    CHECK_NEAR(point(&v, 1, PAST_POINTS - 4), 100, 0);
    CHECK(isnan(point(&v, 1, PAST_POINTS - 5)));
    CHECK_INT(v.energy_count, 9);
    CHECK_NEAR(v.energies[0], step, 1e-15);
    CHECK_NEAR(v.energies[1], 101, 0);
    CHECK_NEAR(v.energies[4], 9, 0);                        /* heat and what is lost */
    CHECK_NEAR(v.begin, 100 * step, 1e-15);
    past_close(&p);
}

TEST(another_body_in_the_slot_has_a_trail_of_its_own)
{
    Past p;
    ViewPast v;
    past_open(&p, 0, step);
    feed(&p, 0, 40);
    for (uint64_t n = 41; n <= 50; n++) {
        past_begin(&p, n);
        CHECK_INT(past_point(&p, 1, 8, place(n)), DIG_OK);
    }
    CHECK_INT(past_show(&p, &v), DIG_OK);
    CHECK_NEAR(point(&v, 1, PAST_POINTS - 3), 44, 0);
    CHECK(isnan(point(&v, 1, PAST_POINTS - 4)));
    past_begin(&p, 51);                                     /* it is gone: no trail */
    CHECK_INT(past_show(&p, &v), DIG_OK);
    CHECK_INT(v.trail_count, 0);
    past_close(&p);
}

TEST(a_world_that_goes_back_begins_anew)
{
    Past p;
    ViewPast v;
    past_open(&p, 0, step);
    feed(&p, 0, 100);
    past_begin(&p, 50);
    feed(&p, 51, 60);
    CHECK_INT(past_show(&p, &v), DIG_OK);
    CHECK_INT(v.energy_count, 10);
    CHECK_NEAR(point(&v, 1, PAST_POINTS - 3), 52, 0);
    CHECK(isnan(point(&v, 1, PAST_POINTS - 4)));
    past_close(&p);
}

/* The rows at a step are the same whether each step before it was seen or the past began to be read there, as a replay's may. */
TEST(rows_depend_on_the_step_alone)
{
    static const int lengths[] = {1, 2, 511, 512, 513, 1024, 1025, 5000};
    Past all;
    past_open(&all, 3, step);
    uint64_t at = 3;
    for (size_t k = 0; k < sizeof lengths / sizeof *lengths; k++) {
        uint64_t n = 3 + (uint64_t)lengths[k], stride = 1;
        ViewPast v;
        feed(&all, at, n);
        at = n + 1;
        while ((n - 3) / stride >= PAST_ROWS)
            stride *= 2;
        CHECK_INT(past_show(&all, &v), DIG_OK);
        CHECK_INT(v.energy_count, (int)((n - 3) / stride + ((n - 3) % stride != 0)));
        for (int i = 0; i < v.energy_count; i++) {
            real want = i == v.energy_count - 1 ? (real)n : 3 + (real)(i + 1) * (real)stride;
            CHECK_NEAR(v.energies[i * (1 + PAST_ENERGIES) + 1], want, 0);
        }
    }
    past_close(&all);
}

/* Points that are not asked for make no difference. */
TEST(only_wanted_points_are_needed)
{
    Past whole, some;
    ViewPast a, b;
    past_open(&whole, 0, step);
    past_open(&some, 0, step);
    feed(&whole, 0, 300);
    int fed = 0;
    for (uint64_t n = 0; n <= 300; n++)
        if (past_wants_points(&some, n, 300)) {
            feed(&some, n, n);
            fed++;
        }
    CHECK(fed < 40);
    CHECK_INT(past_show(&whole, &a), DIG_OK);
    CHECK_INT(past_show(&some, &b), DIG_OK);
    CHECK_NEAR(b.head, a.head, 0);
    for (int i = 0; i < PAST_POINTS; i++)
        CHECK_NEAR(point(&b, 1, i), point(&a, 1, i), 0);
    past_close(&whole);
    past_close(&some);
}

int main(void)
{
    RUN_TESTS(unit_test(a_trail_has_the_last_second_and_now),
              unit_test(it_begins_where_it_was_told_to),
              unit_test(another_body_in_the_slot_has_a_trail_of_its_own),
              unit_test(a_world_that_goes_back_begins_anew),
              unit_test(rows_depend_on_the_step_alone),
              unit_test(only_wanted_points_are_needed));
}
