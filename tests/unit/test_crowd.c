/* tests/unit/test_crowd.c - the way for crowds, against closed forms, and the same bits on all instructions and threads.
 * Not in RENDER=0: physics alone. */
#include "base/rng.h"
#include "crowd/system.h"
#include "math/reg3.h"
#include "physics_fixture.h"

#include <stdlib.h>

#define STEP (1.0 / 60)
#define ROWS 10                 /* of a pyramid: 55 boxes, more than the plan's crowd */

static const Look rough = {0.5, NAN, 0, 0};

/* Boxes of a metre and a tonne. Returns how many. */
static int add_pyramid(dig_world *w, dig_body *b)
{
    int n = 0;
    for (int i = 0; i < ROWS; i++)
        for (int j = 0; j < ROWS - i; j++)
            b[n++] = add_box(w, rough, (vec3){1, 1, 1}, 1000, (vec3){(j - 0.5 * (ROWS - i - 1)) * 1.1, 0.5 + i, 0}, quat_identity());
    return n;
}

/* Else what is many and lies calm is solved at once (crowd/calm.c). */
static void stay_a_crowd(dig_world *w)
{
    for (int i = 0; i < w->bodies.count; i++)
        w->bodies.data[i].trace_wait = w->bodies.data[i].trace_pause = UINT16_MAX;
}

/* The links of the lowest row to the floor carry all of it. */
static void check_pyramid(dig_world *w, const dig_body *b, int n, dig_body floor, real off)
{
    CHECK_INT(n, ROWS * (ROWS + 1) / 2);
    real sum = 0;
    dig_link list[16];
    for (int i = 0; i < ROWS; i++) {
        int links = dig_links_of(w, b[i], list, 16);
        for (int k = 0; k < links; k++)
            if (list[k].a.slot == floor.slot || list[k].b.slot == floor.slot)
                sum += fabs(list[k].effort.y);
    }
    CHECK_NEAR(sum, n * 1000 * GRAVITY, 0.01 * n * 1000 * GRAVITY);
    for (int i = 0; i < n; i++)
        CHECK(vec3_length(state_of(w, b[i]).velocity) < 0.02);
    CHECK_NEAR(state_of(w, b[n - 1]).position.y, ROWS - 0.5, off);
    check_world(w);
}

/* Returns how many are awake after four seconds. */
static int pyramid_of_a_crowd(bool sleeping, int passes)
{
    dig_world_def def = dig_world_defaults();
    def.step = STEP;
    def.sleeping = sleeping;
    dig_world *w = open_with(def);
    dig_body b[64], floor = add_floor(w, rough);
    int n = add_pyramid(w, b);
    stay_a_crowd(w);
    step(w, 20);
    CHECK_INT(dig_world_stats(w).iterations, passes);
    CHECK(dig_world_stats(w).penetration < 5e-3);
    step(w, 220);
    check_pyramid(w, b, n, floor, 5e-3 * ROWS);
    int awake = (int)dig_world_stats(w).awake;
    dig_world_close(w);
    return awake;
}

TEST(a_pyramid_rests_and_the_floor_carries_its_weight)
{
    CHECK_INT(pyramid_of_a_crowd(false, 4), ROWS * (ROWS + 1) / 2);     /* passes: the sweep would take hundreds */
}

/* Where it can sleep it is worth more of them: four let it creep on. */
TEST(a_pyramid_falls_asleep_as_a_crowd) { CHECK_INT(pyramid_of_a_crowd(true, 128), 0); }

TEST(a_pyramid_that_lies_calm_is_solved_once_and_sleeps)
{
    dig_world *w = open_world(STEP, NULL, true);
    dig_body b[64], floor = add_floor(w, rough);
    int n = add_pyramid(w, b);
    step(w, 1);
    CHECK(dig_world_stats(w).factors > 0);
    step(w, 1);
    CHECK_INT(dig_world_stats(w).factors, 0);
    step(w, 238);
    check_pyramid(w, b, n, floor, 1e-6);
    CHECK_INT(dig_world_stats(w).awake, 0);
    dig_world_close(w);
}

static const Look smooth = {0, NAN, 0, 0};

static void set_motion(dig_world *w, real speed, real spin)
{
    for (int i = 1; i <= 60; i++) {
        w->bodies.data[i].v.x = speed;
        w->bodies.data[i].w.y = spin;
    }
}

/* Sixty boxes of size, 0.2 size, size (m) side by side that slide at a speed (m/s) without friction. */
static dig_world *sliding(real size, real speed)
{
    dig_world *w = open_world(STEP, NULL, true);
    add_floor(w, smooth);
    for (int i = 0; i < 60; i++)
        add_box(w, smooth, (vec3){size, 0.2 * size, size}, 100, (vec3){1.01 * size * i, 0.1 * size, 0}, quat_identity());
    set_motion(w, speed, 0);
    stay_a_crowd(w);
    return w;
}

/* Balls that spin about what is up, rad/s. */
static dig_world *spinning(real spin)
{
    dig_world *w = open_world(STEP, NULL, true);
    add_floor(w, smooth);
    for (int i = 0; i < 60; i++)
        add_ball(w, smooth, 0.1, 1, (vec3){0.202 * i, 0.1, 0}, vec3_zero());
    set_motion(w, 0, spin);
    stay_a_crowd(w);
    return w;
}

static void check_awake(dig_world *w, int steps, int want)
{
    step(w, steps);
    CHECK_INT(dig_world_stats(w).awake, want);
    dig_world_close(w);
}

/* The bound is 2.5 % of the farthest point in half a second, 5 mm at most. */
TEST(one_of_a_crowd_sleeps_by_how_far_it_gets)
{
    check_awake(sliding(1, 9.5e-3), 60, 0);
    check_awake(sliding(1, 10.5e-3), 60, 60);
    check_awake(sliding(0.1, 3.4e-3), 60, 0);
    check_awake(sliding(0.1, 3.8e-3), 60, 60);
    check_awake(spinning(0.045), 60, 0);
    check_awake(spinning(0.055), 60, 60);
}

/* A whole turn a step gets nowhere. */
TEST(what_spins_in_a_crowd_does_not_sleep) { check_awake(spinning(2 * DIG_PI / STEP), 60, 60); }

/* There and back is a way, too, when what woke it made it turn round. */
TEST(who_is_woken_in_a_crowd_is_looked_at_anew)
{
    dig_world *w = sliding(0.1, 3.4e-3);
    step(w, 27);
    for (int i = 1; i <= 60; i++)
        w->bodies.data[i].still = 0;
    set_motion(w, -6e-3, 0);
    check_awake(w, 32, 60);
}

/* Sixty boxes side by side, in reach of each other, on a slope of which the tangent is `share` of the friction coefficient. */
static real speed_on_slope(real share, real seconds, bool sleeping)
{
    real angle = atan(share * rough.friction), sum = 0;
    dig_world_def def = dig_world_defaults();
    def.step = STEP;
    def.sleeping = sleeping;
    def.gravity = (vec3){GRAVITY * sin(angle), -GRAVITY * cos(angle), 0};
    dig_world *w = open_with(def);
    dig_body b[60];
    add_floor(w, rough);
    for (int i = 0; i < 60; i++)
        b[i] = add_box(w, rough, (vec3){1, 0.2, 1}, 100, (vec3){1.01 * i, 0.1, 0}, quat_identity());
    stay_a_crowd(w);
    step(w, (int)(seconds / STEP + 0.5));
    CHECK_INT(dig_world_stats(w).groups, 1);
    CHECK(sleeping || dig_world_stats(w).iterations == 4);
    for (int i = 0; i < 60; i++)
        sum += state_of(w, b[i]).velocity.x / 60;
    dig_world_close(w);
    return sum;
}

/* Below the threshold nothing moves; above it a = g cos (tan - mu). */
TEST(friction_holds_up_to_its_coefficient)
{
    CHECK_NEAR(speed_on_slope(0.99, 1, false), 0, 1e-4);
    real a = 0.01 * rough.friction * GRAVITY * cos(atan(1.01 * rough.friction));
    CHECK_NEAR(speed_on_slope(1.01, 1, false), a, 0.2 * a);     /* a fifth of a hundredth of the friction */
    a = rough.friction * GRAVITY * cos(atan(2 * rough.friction));
    CHECK_NEAR(speed_on_slope(2, 1, false), a, 0.002 * a);
}

/* By 3.8 mm in the first half second, at 15 mm/s then. */
TEST(what_gathers_speed_in_a_crowd_does_not_sleep)
{
    real share = 1.0068, a = (share - 1) * rough.friction * GRAVITY * cos(atan(share * rough.friction));
    CHECK_NEAR(speed_on_slope(share, 2, true), 2 * a, 0.25 * 2 * a);
}

typedef struct Momentum { vec3 p, l; real scale; } Momentum;

static Momentum momentum_of(const dig_world *w, const dig_body *b, int n)
{
    Momentum m = {vec3_zero(), vec3_zero(), 0};
    for (int i = 0; i < n; i++) {
        dig_body_state s = state_of(w, b[i]);
        dig_body_debug d = debug_of(w, b[i]);
        vec3 p = vec3_scale(s.mass, s.velocity);
        m.p = vec3_add(m.p, p);
        m.l = vec3_add(m.l, vec3_add(d.ang_mom, vec3_cross(s.centre, p)));
        m.scale += vec3_length(p);
    }
    return m;
}

/* What a row takes from one body it gives to the other: both momenta of a cloud that falls together stay, to single precision. */
TEST(a_cloud_that_collides_keeps_its_momenta)
{
    dig_world *w = open_world(STEP, NULL, false);
    dig_body b[64];
    uint64_t rng = 7;
    for (int i = 0; i < 64; i++) {
        vec3 at = {i % 4 - 1.5, i / 4 % 4 - 1.5, i / 16 - 1.5};
        vec3 v = vec3_mad((vec3){rng_real(&rng), rng_real(&rng), rng_real(&rng)}, -1.0, at);
        b[i] = add_ball(w, rough, 0.45, 100, at, v);
    }
    Momentum before = momentum_of(w, b, 64);
    step(w, 60);
    CHECK_INT(dig_world_stats(w).swept > 0, 1);
    Momentum after = momentum_of(w, b, 64);
    CHECK(vec3_distance(after.p, before.p) < 1e-6 * before.scale);
    CHECK(vec3_distance(after.l, before.l) < 1e-3 * before.scale);      /* friction acts across the gap of a closing pair */
    dig_world_close(w);
}

/* Two layers of boxes face each other across 2 cm and close on each other so slowly that nobody looks at them for many steps. */
TEST(what_is_not_looked_at_meets_in_time)
{
    dig_world *w = open_world(STEP, NULL, false);
    dig_body b[98];
    for (int i = 0; i < 98; i++) {
        real side = i < 49 ? -1 : 1;
        b[i] = add_box(w, rough, (vec3){1, 1, 1}, 1000, (vec3){i % 7 * 1.01, side * 0.51, i / 7 % 7 * 1.01}, quat_identity());
        vec3 v = {0, -0.02 * side, 0};
        CHECK_INT(dig_body_teleport(w, b[i], NULL, NULL, &v, NULL), DIG_OK);
    }
    step(w, 90);
    CHECK_INT(dig_world_stats(w).swept, 1);
    for (int i = 0; i < 49; i++) {
        real gap = state_of(w, b[i + 49]).position.y - state_of(w, b[i]).position.y - 1;
        CHECK(gap > -1e-3 && gap < 3e-3);
        CHECK(fabs(state_of(w, b[i]).velocity.y) < 1e-3);
    }
    dig_world_close(w);
}

/* Columns of ten balls that fall together, 5 cm apart: the upper ones come down within the step in which the lowest is stopped. Then
 * they stand, and the lowest carries nine. */
TEST(columns_that_land_do_not_sink_into_each_other)
{
    dig_world *w = open_world(STEP, NULL, true);
    dig_body b[60];
    add_floor(w, rough);
    for (int i = 0; i < 60; i++)
        b[i] = add_ball(w, rough, 0.5, 100, (vec3){1.0005 * (i % 6), 1.5 + 1.05 * (i / 6), 0}, vec3_zero());
    real deepest = 0;
    int64_t swept = 0;
    for (int i = 0; i < 90; i++) {
        step(w, 1);
        deepest = real_max(deepest, dig_world_stats(w).penetration);
        swept += dig_world_stats(w).swept;
    }
    CHECK(swept > 0);
    CHECK(deepest < 3e-3);
    CHECK(dig_world_stats(w).penetration < 2e-4);
    CHECK_NEAR(state_of(w, b[59]).position.y, 9.5, 1e-3);
    dig_world_close(w);
}

/* ---- the same bits ---- */

static uint64_t towers(int threads)
{
    dig_world_def def = dig_world_defaults();
    def.step = STEP;
    def.threads = threads;
    dig_world *w = open_with(def);
    add_floor(w, rough);
    for (int t = 0; t < 100; t++)
        for (int i = 0; i < 10; i++)
            add_box(w, rough, (vec3){1, 1, 1}, 1000, (vec3){3.0 * (t % 10), 0.5 + 1.001 * i, 3.0 * (t / 10)}, quat_identity());
    step(w, 30);
    CHECK(dig_world_stats(w).penetration < 5e-3);
    uint64_t sum = dig_world_checksum(w);
    dig_world_close(w);
    return sum;
}

/* Layers of balls and boxes that fall on each other: one group, which all threads advance together. */
static uint64_t heap(int threads, Width width)
{
    dig_world_def def = dig_world_defaults();
    uint64_t rng = 5;
    def.step = STEP;
    def.threads = threads;
    dig_world *w = open_with(def);
    w->width = width;
    Look bouncy = {0.5, NAN, 0.3, 0.01};
    add_floor(w, rough);
    for (int i = 0; i < 240; i++) {
        vec3 at = {i % 6 * 0.9 + 0.1 * rng_real(&rng), 0.5 + i / 36 * 0.95, i / 6 % 6 * 0.9};
        if (i % 2)
            add_ball(w, bouncy, 0.5, 100, at, vec3_zero());
        else
            add_box(w, rough, (vec3){0.8, 0.8, 0.8}, 100, at, quat_identity());
    }
    step(w, 60);
    CHECK_INT(dig_world_stats(w).groups, 1);
    CHECK(dig_world_stats(w).iterations >= 4 && dig_world_stats(w).iterations <= 4 * PASSES_MOST);
    check_world(w);
    uint64_t sum = dig_world_checksum(w);
    dig_world_close(w);
    return sum;
}

static real highest_gap(dig_world *w, Contact *c)
{
    real high = -INFINITY;
    for (int k = 0; k < c->count; k++)
        high = real_max(high, contact_point(w, c, k)->at.gap);
    return high;
}

/* Boxes that lie on each other anyhow: where a corner is too high to keep a manifold by how it slides and tilts, it is kept for as long as
 * its bodies go nowhere, like one of two points. */
TEST(a_manifold_with_a_high_corner_is_kept_while_its_bodies_stay)
{
    dig_world_def def = dig_world_defaults();
    uint64_t rng = 7;
    int tilted = 0, kept = 0;
    def.step = STEP;
    dig_world *w = open_with(def);
    add_floor(w, rough);
    for (int i = 0; i < 120; i++) {
        quat turn = quat_unit((quat){rng_real(&rng) - 0.5, rng_real(&rng) - 0.5, rng_real(&rng) - 0.5, 0.2});
        add_box(w, rough, (vec3){1, 1, 1}, 1000, (vec3){i % 4 * 1.1, 1 + i / 16 * 1.7, i / 4 % 4 * 1.1}, turn);
    }
    step(w, 150);
    for (int i = 0; i < w->pairs.count; i++) {
        const Pair *p = &w->pairs.data[i];
        if (!p->alive || p->contact == NONE || w->contacts.data[p->contact].count < 3 || highest_gap(w, &w->contacts.data[p->contact]) < 4e-3)
            continue;
        tilted++;
        kept += p->until > 0;
    }
    CHECK(tilted > 10 && kept > 0.8 * tilted);
    dig_world_close(w);
}

TEST(any_number_of_threads_gives_the_same_bits)
{
    CHECK(towers(1) == towers(2));
    uint64_t alone = heap(1, WIDTH_ANY);
    CHECK(heap(2, WIDTH_ANY) == alone);
    CHECK(heap(3, WIDTH_ANY) == alone);
}

static bool same_bits(vec3 a, vec3 b) { return memcmp(&a, &b, sizeof a) == 0; }

TEST(a_vector_in_a_register_is_computed_like_one_in_three)
{
    uint64_t rng = 3;
    for (int i = 0; i < 1000; i++) {
        real n[16];
        for (int k = 0; k < 16; k++)
            n[k] = ldexp(rng_real(&rng) - 0.5, (int)(20 * rng_real(&rng)));
        const vec3 a = {n[0], n[1], n[2]}, b = {n[3], n[4], n[5]};
        const mat3 m = {{n[6], n[7], n[8]}, {n[9], n[10], n[11]}, {n[12], n[13], n[14]}};
        const reg3 ra = reg3_of(a), rb = reg3_load((const vec3 *)(const void *)&n[3]);
        const reg33 rm = reg33_of(&m);
        vec3 room[2] = {a, a};
        reg3_store(room, rb);
        CHECK(same_bits(reg3_get(reg3_cross(ra, rb)), vec3_cross(a, b)));
        CHECK(same_bits(reg3_get(reg33_by(&rm, ra)), mat3_mul_vec(m, a)));
        CHECK(same_bits(reg3_get(ra + reg3_all(n[15]) * rb), vec3_mad(a, n[15], b)));
        CHECK(reg3_dot(ra, rb) == vec3_dot(a, b) && reg3_length2(ra) == vec3_length2(a));
        CHECK(same_bits(room[0], b) && room[1].y == a.y && room[1].z == a.z);
        CHECK(rb[3] == 0);              /* no integer behind it, read as a subnormal number */
    }
}

/* Rows, books and all: those that this machine has. */
TEST(a_heap_gives_the_same_bits_on_all_instructions)
{
    uint64_t plain = heap(1, WIDTH_PLAIN);
    for (Width width = WIDTH_AVX2; width <= widest(); width++)
        CHECK(heap(1, width) == plain);
}

#define BODIES 80
#define BATCHES 12

typedef struct Sample {
    Six       six[7][BODIES + 2];       /* the last is nobody */
    Batch     batch[BATCHES];
    _Alignas(ARENA_ALIGN) WideContact of[BATCHES];
    _Alignas(ARENA_ALIGN) WidePoint point[BATCHES][4];
    _Alignas(ARENA_ALIGN) WideArms  arms[BATCHES][4];
    _Alignas(ARENA_ALIGN) WideRub   rub[BATCHES];
    _Alignas(ARENA_ALIGN) WidePatch patch[BATCHES];
    _Alignas(ARENA_ALIGN) WideTwist twist[BATCHES];
    _Alignas(ARENA_ALIGN) WideRoll  roll[BATCHES];
    Phase     phase[BATCHES];
    float     worst[2][1];
} Sample;

static void fill(void *to, size_t bytes, uint64_t *rng)
{
    float *f = to;
    for (size_t i = 0; i < bytes / sizeof *f; i++)
        f[i] = (float)(2 * rng_real(rng) - 1);
}

static int lanes_in(const Batch *b) { return HALF * b->halves; }

/* Of a batch that has one half, the other holds 0. */
static void fill_lanes(const Batch *b, void *to, size_t bytes, uint64_t *rng)
{
    float *f = to;
    fill(to, bytes, rng);
    for (size_t i = 0; i < bytes / sizeof *f; i++)
        f[i] = (int)(i % LANES) < lanes_in(b) ? f[i] : 0;
}

/* Batches of numbers that mean nothing, but are rows: no body twice in one, masses positive. */
static void make_sample(Sample *s, Crowd *c)
{
    uint64_t rng = 99;
    memset(s, 0, sizeof *s);
    fill(s->six, sizeof s->six, &rng);
    for (int k = 0; k < 7; k++)
        s->six[k][BODIES] = s->six[k][BODIES + 1] = (Six){{0}};
    for (int i = 0; i < BATCHES; i++) {
        Batch *b = &s->batch[i];
        b->halves = 1 + (i % 3 > 0);
        fill_lanes(b, s->point[i], sizeof s->point[i], &rng);
        fill_lanes(b, s->arms[i], sizeof s->arms[i], &rng);
        fill_lanes(b, &s->rub[i], sizeof s->rub[i], &rng);
        fill_lanes(b, &s->patch[i], sizeof s->patch[i], &rng);
        fill_lanes(b, &s->twist[i], sizeof s->twist[i], &rng);
        fill_lanes(b, &s->roll[i], sizeof s->roll[i], &rng);
        b->of = &s->of[i];
        fill_lanes(b, b->of, sizeof *b->of, &rng);
        for (int k = 0; k < LANES; k++) {
            b->a[k] = k < lanes_in(b) ? (5 * k + i) % BODIES : BODIES;
            b->b[k] = k >= lanes_in(b) || i % 2 ? BODIES : (5 * k + i + 2) % BODIES;
            b->of->friction.at[k] = 0.5f;
            b->of->restitution.at[k] = 0.3f;
            b->of->care.at[k] = 1;
        }
        b->points = 1 + i % 4;
        b->fixed = i % 2;
        s->phase[i] = (Phase){.first = i, .count = 1};
        b->bounces = i % 3 == 0;
        b->driven = i % 5 == 0;
        b->point = s->point[i];
        b->round = i % 4 == 0 && !b->driven;
        b->arms = b->round ? NULL : s->arms[i];
        b->rub = i % 3 && b->round ? &s->rub[i] : NULL;
        b->patch = i % 3 && !b->round ? &s->patch[i] : NULL;
        b->twist = i % 3 && b->points > 1 ? &s->twist[i] : NULL;
        b->roll = i % 4 == 2 ? &s->roll[i] : NULL;
        for (int p = 0; p < 4; p++)
            for (int k = 0; k < lanes_in(b); k++)
                s->point[i][p].mass.at[k] = 1;
    }
    *c = (Crowd){.width = widest(), .dt = STEP, .substeps = 4, .h = (float)(STEP / 4), .bodies = BODIES, .push_most = 3, .bounce_least = 0.1f,
                 .vel = s->six[0], .move = s->six[1], .last = s->six[2], .push = s->six[3], .start = s->six[4],
                 .axes = {s->six[5], s->six[6]}, .batch = s->batch, .batches = BATCHES,
                 .phase = s->phase, .phases = BATCHES, .passes = 1, .passes_most = 2,
                 .worst = {s->worst[0], s->worst[1]}};
    for (int k = 0; k < 2 * BEARINGS; k++) {
        c->soft[0][k / 2][k % 2] = (Soft){9, 0.9f, 0.1f};
        c->soft[1][k / 2][k % 2] = (Soft){18, 0.95f, 0.05f};
    }
    memset(s->six[1], 0, sizeof s->six[1]);
}

TEST(wide_rows_give_the_same_bits_on_all_instructions)
{
    Sample *s[WIDTH_AVX512 + 1];
    for (Width width = WIDTH_PLAIN; width <= widest(); width++) {
        Crowd c;
        Sample *x = s[width] = aligned_alloc(ARENA_ALIGN, sizeof *x);
        assert_non_null(x);
        make_sample(x, &c);
        c.width = width;
        Six before = x->six[0][3];
        wide_solve(&c);
        CHECK(memcmp(&before, &x->six[0][3], sizeof before) != 0);
        CHECK_INT(c.passes, 4 * 2);
        CHECK(memcmp(s[WIDTH_PLAIN]->six, x->six, sizeof x->six) == 0);
        CHECK(memcmp(s[WIDTH_PLAIN]->point, x->point, sizeof x->point) == 0);
        CHECK(memcmp(s[WIDTH_PLAIN]->arms, x->arms, sizeof x->arms) == 0);
        CHECK(memcmp(s[WIDTH_PLAIN]->rub, x->rub, sizeof x->rub) == 0);
        CHECK(memcmp(s[WIDTH_PLAIN]->patch, x->patch, sizeof x->patch) == 0);
        CHECK(memcmp(s[WIDTH_PLAIN]->twist, x->twist, sizeof x->twist) == 0);
        CHECK(memcmp(s[WIDTH_PLAIN]->roll, x->roll, sizeof x->roll) == 0);
    }
    for (Width width = WIDTH_PLAIN; width <= widest(); width++)
        free(s[width]);
}

/* Unit balls of many masses that meet in all directions: as round rows, or as such of any shape. */
static void make_balls(Sample *s, Crowd *c, bool round)
{
    make_sample(s, c);
    uint64_t rng = 7;
    for (int i = 0; i < BODIES; i++) {
        float root = (float)(0.5 + rng_real(&rng)), spin = root * sqrtf(2.5f);
        s->six[5][i] = (Six){{spin, 0, 0, 0, spin, 0, 0, 0}};
        s->six[6][i] = (Six){{spin, root}};
    }
    for (int i = 0; i < BATCHES; i++) {
        Batch *b = &s->batch[i];
        b->driven = false;
        b->roll = NULL;
        b->twist = NULL;
        b->points = 1;
        b->round = round;
        b->arms = round ? NULL : s->arms[i];
        memset(s->point[i], 0, sizeof s->point[i]);
        memset(s->arms[i], 0, sizeof s->arms[i]);
        memset(&s->patch[i], 0, sizeof s->patch[i]);
        memset(&s->rub[i], 0, sizeof s->rub[i]);
        b->rub = i % 3 && round ? &s->rub[i] : NULL;
        b->patch = i % 3 && !round ? &s->patch[i] : NULL;
        for (int k = 0; k < lanes_in(b); k++) {
            vec3 n = vec3_unit((vec3){rng_real(&rng) - 0.5, rng_real(&rng) - 0.5, rng_real(&rng) - 0.5}), t, u;
            vec3_basis(n, &t, &u);
            const real place[3] = {n.x, n.y, n.z}, across[3] = {t.x, t.y, t.z};
            for (int x = 0; x < 3; x++) {
                b->of->n[x].at[k] = (float)place[x];
                s->patch[i].t[x].at[k] = (float)across[x];
                s->arms[i][0].a[x].at[k] = (float)place[x];
                s->arms[i][0].b[x].at[k] = b->fixed ? 0 : -(float)place[x];
                s->rub[i].j[x].at[k] = (float)(0.02 * across[x]);
            }
            s->patch[i].j[0].at[k] = 0.02f;
            s->rub[i].a.at[k] = 1;
            s->rub[i].b.at[k] = b->fixed ? 0 : 1;
            s->point[i][0].mass.at[k] = 1;
            s->point[i][0].j.at[k] = 0.1f;
            s->point[i][0].gap.at[k] = (float)(0.02 * rng_real(&rng) - 0.01);
        }
    }
}

/* m  What the rows of the sample overlap by in the end, over what may stay. */
static real overlap_of(const Sample *s, real left)
{
    real sum = 0;
    for (int i = 0; i < BATCHES; i++)
        for (int k = 0; k < LANES; k++) {
            const Batch *b = &s->batch[i];
            const Six *x = &s->six[1][b->a[k]], *y = &s->six[1][b->b[k]];
            real gap = (real)s->point[i][0].gap.at[k];
            for (int n = 0; n < 3; n++)
                gap += (real)b->of->n[n].at[k] * ((real)b->of->rb.at[k] * (real)y->at[n] - (real)b->of->ra.at[k] * (real)x->at[n]);
            sum += real_max(0, -gap - left);
        }
    return sum;
}

TEST(what_is_deep_is_put_apart_in_place_alone)
{
    const real left = 2e-3;
    Sample *s[2];
    for (int i = 0; i < 2; i++) {
        Crowd c;
        s[i] = aligned_alloc(ARENA_ALIGN, sizeof **s);
        assert_non_null(s[i]);
        make_balls(s[i], &c, true);
        c.substeps = 1;
        c.separations = 32 * i;
        for (int k = 0; k < BATCHES; k++)
            for (int lane = 0; lane < LANES; lane++)
                s[i]->batch[k].of->care.at[lane] = (float)(SHALLOW * (real)c.h / left);
        wide_solve(&c);
    }
    CHECK(overlap_of(s[0], left) > 0.01);
    CHECK(overlap_of(s[1], left) < 0.01 * overlap_of(s[0], left));
    CHECK(memcmp(s[0]->six[0], s[1]->six[0], sizeof s[0]->six[0]) == 0);
    for (int i = 0; i < 2; i++)
        free(s[i]);
}

TEST(round_rows_do_to_balls_what_rows_of_any_shape_do)
{
    Sample *s[2];
    for (int i = 0; i < 2; i++) {
        Crowd c;
        s[i] = aligned_alloc(ARENA_ALIGN, sizeof **s);
        assert_non_null(s[i]);
        make_balls(s[i], &c, i == 1);
        c.substeps = 1;         /* gaps that this one closes are none, or by rounding none at all, for the next */
        wide_solve(&c);
        CHECK_INT(c.passes, 2);
    }
    real moved = 0;
    for (int i = 0; i < BODIES; i++)
        for (int k = 0; k < 6; k++) {
            CHECK_NEAR((real)s[1]->six[0][i].at[k], (real)s[0]->six[0][i].at[k], 2e-4);
            CHECK_NEAR((real)s[1]->six[1][i].at[k], (real)s[0]->six[1][i].at[k], 2e-6);
            moved = real_max(moved, fabs((real)s[1]->six[0][i].at[k]));
        }
    CHECK(moved > 0.1);
    for (int i = 0; i < BATCHES; i++)
        for (int k = 0; k < LANES; k++) {
            CHECK_NEAR((real)s[1]->point[i][0].sum.at[k], (real)s[0]->point[i][0].sum.at[k], 2e-4);
            vec3 whole = {(real)s[1]->rub[i].sum[0].at[k], (real)s[1]->rub[i].sum[1].at[k], (real)s[1]->rub[i].sum[2].at[k]};
            CHECK_NEAR(vec3_length(whole), hypot((real)s[0]->patch[i].sum[0].at[k], (real)s[0]->patch[i].sum[1].at[k]), 2e-4);
        }
    free(s[0]);
    free(s[1]);
}

#define SWARM 12                /* balls along an edge of a cube: about 15,000 pairs */

TEST(room_for_pairs_and_contacts_is_given_back_when_most_are_over)
{
    dig_world *w = open_world(STEP, NULL, false);
    static dig_body b[SWARM * SWARM * SWARM];
    int n = 0;
    for (int i = 0; i < SWARM; i++)
        for (int j = 0; j < SWARM; j++)
            for (int k = 0; k < SWARM; k++)
                b[n++] = add_ball(w, rough, 0.25, 1, (vec3){0.4998 * i, 0.4998 * j, 0.4998 * k}, vec3_zero());
    step(w, 1);
    int before = w->pairs.count - w->free_pairs.count;
    CHECK(before > 8000 && w->contacts.count - w->free_contacts.count > 4096);
    for (int i = 8; i < n; i++) {
        vec3 far = {3.0 * i, 50, 0};
        dig_body_teleport(w, b[i], &far, NULL, NULL, NULL);
    }
    step(w, 2);
    CHECK(w->free_pairs.count == 0 && w->pairs.count > 4 && w->pairs.count < 100);
    CHECK(w->free_contacts.count == 0 && w->contacts.count < 100 && w->contacts.capacity < 200);
    check_world(w);
    CHECK(w->pairs.capacity < 200 && w->pair_index.size < 200);
    vec3 back = {0, 0, -0.5};
    dig_body_teleport(w, b[n - 1], &back, NULL, NULL, NULL);       /* into the index, and found in it */
    step(w, 5);
    CHECK(w->pairs.count > 5);
    check_world(w);
    dig_world_close(w);
}

/* Balls in a pit of four slopes, never asleep: once they lie, a step asks the allocator for nothing. */
TEST(a_pile_that_lies_is_stepped_without_the_allocator)
{
    dig_world_def def = dig_world_defaults();
    uint64_t rng = 8;
    def.step = STEP;
    def.sleeping = false;
    dig_world *w = open_with(def);
    for (int i = 0; i < 4; i++)
        add_slope(w, rough, vec3_unit((vec3){i == 0 ? 1 : i == 1 ? -1 : 0, 1, i == 2 ? 1 : i == 3 ? -1 : 0}));
    for (int i = 0; i < 200; i++)
        add_ball(w, rough, 0.25, 60, (vec3){i % 5 * 0.55 - 1.1, 3 + i / 25 * 0.55 + 0.1 * rng_real(&rng), i / 5 % 5 * 0.55 - 1.1}, vec3_zero());
    step(w, 300);
    dig_stats before = dig_world_stats(w);
    CHECK(before.contacts > 300 && before.awake == 200 && before.swept == 1);
    step(w, 300);
    CHECK_INT(dig_world_stats(w).allocations, before.allocations);
    dig_world_close(w);
}

int main(void)
{
    RUN_TESTS(unit_test(a_pyramid_rests_and_the_floor_carries_its_weight), unit_test(a_pyramid_that_lies_calm_is_solved_once_and_sleeps),
              unit_test(a_pyramid_falls_asleep_as_a_crowd), unit_test(one_of_a_crowd_sleeps_by_how_far_it_gets),
              unit_test(what_spins_in_a_crowd_does_not_sleep), unit_test(who_is_woken_in_a_crowd_is_looked_at_anew),
              unit_test(what_gathers_speed_in_a_crowd_does_not_sleep),
              unit_test(friction_holds_up_to_its_coefficient),
              unit_test(a_cloud_that_collides_keeps_its_momenta), unit_test(what_is_not_looked_at_meets_in_time),
              unit_test(columns_that_land_do_not_sink_into_each_other),
              unit_test(a_manifold_with_a_high_corner_is_kept_while_its_bodies_stay), unit_test(any_number_of_threads_gives_the_same_bits),
              unit_test(a_vector_in_a_register_is_computed_like_one_in_three), unit_test(a_heap_gives_the_same_bits_on_all_instructions),
              unit_test(wide_rows_give_the_same_bits_on_all_instructions), unit_test(what_is_deep_is_put_apart_in_place_alone),
              unit_test(round_rows_do_to_balls_what_rows_of_any_shape_do),
              unit_test(room_for_pairs_and_contacts_is_given_back_when_most_are_over),
              unit_test(a_pile_that_lies_is_stepped_without_the_allocator));
}
