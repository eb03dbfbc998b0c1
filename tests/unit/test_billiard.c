/* tests/unit/test_billiard.c - crowds of balls that bounce without friction: each blow at its time, energy and momentum to rounding,
 * and what comes to rest is left to other ways.
 */
#include "physics_fixture.h"

enum { SIDE = 4, BALLS = SIDE * SIDE * SIDE };

/* Off a lattice by a part of `off`, from a generator of its own (Park & Miller 1988). */
static real noise(uint64_t *seed, real off)
{
    *seed = *seed * 48271 % 2147483647;
    return off * (2 * (real)*seed / 2147483647 - 1);
}

static void add_lattice(dig_world *w, real restitution, real height, real off, real heavy, dig_body balls[BALLS])
{
    uint64_t seed = 42;
    for (int i = 0; i < BALLS; i++) {
        real x = noise(&seed, off), y = noise(&seed, off), z = noise(&seed, off);
        vec3 at = {0.21 * (i % SIDE) + x, height + 0.21 * (i / (SIDE * SIDE)) + y, 0.21 * (i / SIDE % SIDE) + z};
        balls[i] = add_ball(w, look(0, restitution), 0.1, i % 3 == 0 ? heavy : 1, at, vec3_zero());
    }
}

static real nearest(const dig_world *w, const dig_body balls[BALLS])
{
    real least = INFINITY;
    for (int i = 0; i < BALLS; i++) {
        vec3 a = state_of(w, balls[i]).position;
        least = real_min(least, a.y - 0.1);
        for (int k = 0; k < i; k++)
            least = real_min(least, vec3_distance(a, state_of(w, balls[k]).position) - 0.2);
    }
    return least;
}

TEST(elastic_balls_that_fall_on_a_floor_keep_their_energy_and_never_overlap)
{
    dig_body balls[BALLS];
    dig_world *w = open_world(1.0 / 60, "play", true);
    add_floor(w, look(0, 1));
    add_lattice(w, 1, 0.6, 1e-3, 1, balls);
    real start = dig_world_energy(w).total;
    int together = 0;
    for (int i = 0; i < 120; i++) {
        step(w, 1);
        CHECK_NEAR(dig_world_energy(w).total / start, 1, 1e-12);
        CHECK(nearest(w, balls) > -1e-9);
        together += dig_world_stats(w).groups == 1 && dig_world_stats(w).traced == 1;
    }
    CHECK(together > 20);
    CHECK(dig_world_stats(w).events > 200);
    dig_world_close(w);
}

/* The first ball of mass 1 that reaches the floor does so when its fall says. */
TEST(blows_are_reported_at_their_times)
{
    dig_body balls[BALLS];
    dig_world *w = open_world(1.0 / 60, "play", true);
    add_floor(w, look(0, 1));
    add_lattice(w, 1, 0.6, 0, 10, balls);
    real due = sqrt(2 * 0.5 / GRAVITY), first = INFINITY;
    for (int i = 0; i < 30; i++) {
        step(w, 1);
        const dig_event *e;
        int count = dig_events(w, &e);
        for (int k = 0; k < count; k++)
            if (e[k].kind == DIG_EVENT_IMPACT)
                first = real_min(first, e[k].time);
    }
    CHECK_NEAR(first, due, 1e-9);
    dig_world_close(w);
}

TEST(without_gravity_momentum_stays_and_a_symmetric_start_stays_symmetric)
{
    dig_body balls[BALLS];
    dig_world *w = open_world(1.0 / 60, "play", false);
    uint64_t seed = 7;
    for (int i = 0; i < BALLS; i++) {           /* i and its mirror image in x, one after the other */
        vec3 at = {0, 0, 0}, v = {0, 0, 0};
        int k = i / 2;
        if (i % 2 == 0)
            seed += 1000;
        uint64_t s = seed;
        at = (vec3){0.12 + 0.25 * (k % 4) + noise(&s, 0.01), 0.25 * (k / 4 % 4) + noise(&s, 0.01), 0.25 * (k / 16) + noise(&s, 0.01)};
        v = (vec3){noise(&s, 2), noise(&s, 2), noise(&s, 2)};
        if (i % 2) {
            at.x = -at.x;
            v.x = -v.x;
        }
        balls[i] = add_ball(w, look(0, 1), 0.1, 1, at, v);
    }
    vec3 p = dig_world_momentum(w);
    for (int i = 0; i < 30; i++)
        step(w, 1);
    CHECK(vec3_distance(dig_world_momentum(w), p) < 1e-12);
    CHECK(dig_world_stats(w).events > 20);
    for (int i = 0; i < BALLS; i += 2) {
        vec3 a = state_of(w, balls[i]).position, b = state_of(w, balls[i + 1]).position;
        CHECK_NEAR(vec3_distance(a, (vec3){-b.x, b.y, b.z}), 0, 1e-6);
    }
    dig_world_close(w);
}

TEST(what_bounces_less_loses_what_the_ledger_says_and_comes_to_rest_on_the_floor)
{
    dig_body balls[BALLS];
    dig_world *w = open_world(1.0 / 60, "play", true);
    add_floor(w, look(0, 0.6));
    add_lattice(w, 0.6, 0.3, 1e-3, 10, balls);
    real start = dig_world_energy(w).total;
    for (int i = 0; i < 30; i++) {
        step(w, 1);
        dig_energy e = dig_world_energy(w);
        CHECK_NEAR((e.total + e.lost) / start, 1, 0.02);
    }
    for (int i = 0; i < 600; i++)
        step(w, 1);
    for (int i = 0; i < BALLS; i++)
        CHECK(state_of(w, balls[i]).position.y > 0.0999);
    CHECK(dig_world_energy(w).lost > 0.3 * start);
    dig_world_close(w);
}

int main(void)
{
    RUN_TESTS(unit_test(elastic_balls_that_fall_on_a_floor_keep_their_energy_and_never_overlap), unit_test(blows_are_reported_at_their_times),
              unit_test(without_gravity_momentum_stays_and_a_symmetric_start_stays_symmetric),
              unit_test(what_bounces_less_loses_what_the_ledger_says_and_comes_to_rest_on_the_floor));
}
