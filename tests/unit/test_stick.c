/* tests/unit/test_stick.c - blows that are solved directly are solutions of what sweeps solve. */
#include "base/rng.h"
#include "physics_fixture.h"
#include "solve/direction.h"

enum { BODIES = 5, POINTS = 8, SEEDS = 400, SWEEPS = 100000 };

typedef struct Blow {
    Group    g;
    Vel      vel[BODIES + 1];
    Mass     mass[BODIES];
    PointRow points[POINTS];
    bool     on[POINTS];
    uint64_t seed;
} Blow;

static real draw(Blow *b, real lo, real hi) { return lo + (hi - lo) * rng_real(&b->seed); }

static vec3 draw3(Blow *b, real most) { return (vec3){draw(b, -most, most), draw(b, -most, most), draw(b, -most, most)}; }

/* Points of bodies that are drawn, of which the last one does not move; one in eight is not on. */
static Blow blow(uint64_t seed, real friction)
{
    Blow b = {.seed = seed};
    int count = 1 + (int)(seed % POINTS);
    for (int i = 0; i < BODIES - 1; i++) {
        real m = draw(&b, 0.5, 5);
        b.vel[i] = (Vel){draw3(&b, 2), draw3(&b, 2)};
        b.mass[i] = (Mass){1 / m, mat3_diagonal((vec3){draw(&b, 5, 20) / m, draw(&b, 5, 20) / m, draw(&b, 5, 20) / m})};
    }
    b.g = (Group){.body_count = BODIES, .moving_count = BODIES - 1, .point_count = count, .patches = true};
    for (int i = 0; i < count; i++) {
        PointRow *r = &b.points[i];
        int other = (int)draw(&b, 0, BODIES);
        *r = (PointRow){.a = i % (BODIES - 1), .b = other == i % (BODIES - 1) ? BODIES - 1 : other, .contact = i};
        Group g = b.g;
        g.mass = b.mass;
        point_row_set(&g, r, vec3_unit(draw3(&b, 1)), vec3_zero(), draw3(&b, 0.5), draw3(&b, 0.5));
        r->target = draw(&b, -0.1, 1);
        r->friction = r->friction_dynamic = friction;
        b.on[i] = draw(&b, 0, 8) > 1;
    }
    return b;
}

static bool strike(Blow *b)
{
    b->g.vel = b->vel;
    b->g.mass = b->mass;
    b->g.points = b->points;
    return stick(&b->g, b->on, 0, b->g.point_count, 1e-12);
}

/* Cones hold, points that press neither part nor slip, none is driven in, and velocities changed by the impulses alone. */
static void check_solves(Blow *b, const Blow *start)
{
    Blow again = *start;
    again.g.vel = again.vel;
    again.g.mass = again.mass;
    for (int i = 0; i < b->g.point_count; i++) {
        const PointRow *r = &b->points[i];
        real rate = dir_rate(&b->g, &r->n, r->a, r->b), slip = hypot(dir_rate(&b->g, &r->t[0], r->a, r->b), dir_rate(&b->g, &r->t[1], r->a, r->b));
        CHECK(r->jn >= 0);
        CHECK(hypot(r->jt[0], r->jt[1]) <= r->friction * r->jn);
        CHECK(b->on[i] || r->jn == 0);
        CHECK(!b->on[i] || rate >= r->target - 1e-11);
        if (r->jn > 0) {
            CHECK_NEAR(rate, r->target, 1e-11);
            if (r->friction > 0)
                CHECK_NEAR(slip, 0, 1e-11);
        }
        dir_apply(&again.g, &r->n, r->a, r->b, r->jn);
        dir_apply(&again.g, &r->t[0], r->a, r->b, r->jt[0]);
        dir_apply(&again.g, &r->t[1], r->a, r->b, r->jt[1]);
    }
    for (int i = 0; i < BODIES; i++) {
        CHECK_NEAR(vec3_distance(again.vel[i].v, b->vel[i].v), 0, 1e-12);
        CHECK_NEAR(vec3_distance(again.vel[i].w, b->vel[i].w), 0, 1e-12);
    }
}

static real swept(Blow *b)
{
    real worst = 1;
    b->g.vel = b->vel;
    b->g.mass = b->mass;
    b->g.points = b->points;
    for (int k = 0; k < SWEEPS && worst > 1e-14; k++) {
        worst = 0;
        for (int i = 0; i < b->g.point_count; i++)
            if (b->on[i])
                worst = real_max(worst, relax_points(&b->g, i, 1));
    }
    return worst;
}

/* Without friction the velocities after a blow are unique. */
TEST(blows_without_friction_end_as_sweeps_end_them)
{
    int solved = 0, approach = 0;
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        Blow start = blow(seed, 0), b = start, sweep = start;
        bool any = false;
        int on = 0;
        for (int i = 0; i < start.g.point_count; i++) {
            const PointRow *r = &start.points[i];
            on += start.on[i];
            any = any || (start.on[i] && dir_rate_between(&r->n, &start.vel[r->a], &start.vel[r->b]) < r->target);
        }
        approach += any && on > 1;      /* one alone is left to sweeps */
        if (!strike(&b))
            continue;
        solved++;
        check_solves(&b, &start);
        if (swept(&sweep) > 1e-13)
            continue;
        for (int i = 0; i < BODIES; i++) {
            CHECK_NEAR(vec3_distance(sweep.vel[i].v, b.vel[i].v), 0, 1e-8);
            CHECK_NEAR(vec3_distance(sweep.vel[i].w, b.vel[i].w), 0, 1e-8);
        }
    }
    CHECK(approach > SEEDS / 2);
    CHECK(solved > approach * 9 / 10);
}

TEST(blows_that_stick_are_solved_and_others_left_as_they_were)
{
    int solved = 0, left = 0;
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        Blow start = blow(seed, 1.5), b = start;
        if (strike(&b)) {
            solved++;
            check_solves(&b, &start);
        } else {
            left++;
            CHECK(memcmp(b.vel, start.vel, sizeof b.vel) == 0);
            CHECK(memcmp(b.points, start.points, sizeof b.points) == 0);
        }
    }
    CHECK(solved > SEEDS / 10);
    CHECK(left > SEEDS / 10);
}

/* The four corners of a cube that comes down flat repeat each other: alike to the bit, so that it does not turn. */
TEST(a_cube_that_comes_down_flat_does_not_turn)
{
    Blow b = {.g = {.body_count = 2, .moving_count = 1, .point_count = 4, .patches = true}};
    b.g.mass = b.mass;
    b.mass[0] = (Mass){1, mat3_diagonal((vec3){6, 6, 6})};
    b.vel[0].v = (vec3){0, -3.1, 0};
    for (int i = 0; i < 4; i++) {
        b.points[i] = (PointRow){.a = 1, .b = 0, .target = 0.9 * 3.1, .friction = 0.5, .friction_dynamic = 0.5};
        b.on[i] = true;
        point_row_set(&b.g, &b.points[i], (vec3){0, 1, 0}, (vec3){i < 2 ? 0.5 : -0.5, 0, i % 3 ? 0.5 : -0.5}, vec3_zero(), (vec3){0, 0.5, 0});
    }
    CHECK(strike(&b));
    CHECK_NEAR(b.vel[0].v.y, 0.9 * 3.1, 1e-14);
    CHECK(vec3_length(b.vel[0].w) == 0);
    for (int i = 0; i < 4; i++)
        CHECK(b.points[i].jn == b.points[0].jn && b.points[i].jt[0] == 0 && b.points[i].jt[1] == 0);
}

int main(void)
{
    RUN_TESTS(unit_test(blows_without_friction_end_as_sweeps_end_them),
               unit_test(blows_that_stick_are_solved_and_others_left_as_they_were),
               unit_test(a_cube_that_comes_down_flat_does_not_turn));
}
