/* tests/unit/test_rest.c - rest: no overlap, exact zeros, sleep that costs nothing, waking in time, piles, movers, steady memory,
 * the same bits for any number of threads. "Row" and "B.." as in test_laws.c.
 * Not in RENDER=0: physics alone. */
#include "physics_fixture.h"
#include "step/step.h"
#include "world/world.h"

static int sleepers(const dig_world *w)
{
    dig_stats s = dig_world_stats(w);
    int dynamic = 0;
    dig_body b[512];
    int n = dig_bodies(w, b, 512);
    for (int i = 0; i < n && i < 512; i++)
        dynamic += state_of(w, b[i]).kind == DIG_DYNAMIC;
    return dynamic - s.awake;
}

/* Row 65. Whatever is dropped ends less than a millimetre deep in what it lies on. */
TEST(penetration_at_rest_is_below_a_millimetre)
{
    const real steps[] = {1.0 / 30, 1.0 / 60, 1.0 / 240};
    for (int i = 0; i < 3; i++) {
        dig_world *w = open_world(steps[i], NULL, true);
        add_floor(w, look(0.6, 0.2));
        for (int k = 0; k < 12; k++) {
            vec3 at = {0.4 * (k % 3), 1 + 0.6 * k, 0.3 * (k % 2)};
            if (k % 2)
                add_box(w, look(0.6, 0.2), (vec3){0.5, 0.3, 0.4}, 10, at, quat_exp((vec3){0.3 * k, 0.1 * k, 0}));
            else
                add_ball(w, look(0.6, 0.2), 0.25, 8, at, vec3_zero());
        }
        while (dig_world_time(w) < 6)
            step(w, 1);
        real worst = 0;
        for (int k = 0; k < 30; k++) {
            step(w, 1);
            worst = real_max(worst, dig_world_stats(w).penetration);
        }
        CHECK(worst < 1e-3);
        check_world(w);
        dig_world_close(w);
    }
}

/* Row 75. A bouncing ball makes finitely many bounces, then is at rest: exactly zero, constraint mode, asleep; a hit wakes it at once. */
TEST(bounces_end_in_exact_rest_and_a_hit_wakes_in_the_same_step)
{
    dig_world *w = open_world(1.0 / 60, NULL, true);
    add_floor(w, look(0.5, 0.5));
    dig_body b = add_ball(w, look(0.5, 0.5), 0.1, 1, (vec3){0, 1.1, 0}, vec3_zero());
    int impacts = 0;
    bool floor_seen = false;
    for (int i = 0; i < 240; i++) {
        step(w, 1);
        impacts += count_events(w, DIG_EVENT_IMPACT);
        floor_seen = floor_seen || debug_of(w, b).floor;
        if (i > 120)
            CHECK(state_of(w, b).velocity.y == 0);
    }
    CHECK(impacts >= 4 && impacts <= 40);
    CHECK(floor_seen);
    CHECK(!state_of(w, b).awake);
    CHECK_INT(state_of(w, b).mode, DIG_RESTING);
    dig_stats s = dig_world_stats(w);
    CHECK_INT(s.groups, 0);
    CHECK_INT(s.iterations, 0);
    CHECK_INT(s.awake, 0);
    CHECK(dig_body_hit(w, b, (vec3){0, 2, 0}, vec3_zero(), false) == DIG_OK);
    CHECK(state_of(w, b).awake);
    real y = state_of(w, b).position.y;
    step(w, 1);
    CHECK_INT(state_of(w, b).mode, DIG_MOVING);
    CHECK_NEAR(state_of(w, b).position.y - y, 2.0 / 60 - 0.5 * GRAVITY / 3600, 1e-9);
    CHECK(!debug_of(w, b).floor);
    dig_world_close(w);
}

/* Row 75. A sleeper that is struck takes part in the very step of the blow, at the speed that the blow gives. */
TEST(struck_sleeper_moves_within_the_same_step)
{
    dig_world *w = open_world(1.0 / 60, NULL, true);
    add_floor(w, look(0, 0));
    dig_body a = add_ball(w, look(0, 1), 0.5, 1, (vec3){0, 0.5, 0}, vec3_zero());
    step(w, 60);
    CHECK(!state_of(w, a).awake);
    dig_body b = add_ball(w, look(0, 1), 0.5, 1, (vec3){-1.5, 0.5, 0}, (vec3){2, 0, 0});
    for (int i = 0; i < 60 && !state_of(w, a).awake; i++)
        step(w, 1);
    CHECK(count_events(w, DIG_EVENT_WOKE) >= 1);
    CHECK_NEAR(dig_world_time(w), 1.25, 1.0 / 60 + 1e-9);
    CHECK_NEAR(state_of(w, a).velocity.x, 2, 1e-9);
    CHECK_NEAR(state_of(w, b).velocity.x, 0, 1e-9);
    CHECK_NEAR(state_of(w, a).position.x, 2 * (dig_world_time(w) - 1.25), 1e-6);
    dig_world_close(w);
}

/* ---- row 86: DIGs of 3 to 100 bodies -------------------------------------------------- */

/* n bodies side by side or, as in the founding document's last test, on top of each other. */
static void make_row(dig_world *w, bool boxes, bool stacked, int n, dig_body *b)
{
    for (int i = 0; i < n; i++) {
        vec3 at = stacked ? (vec3){0, 0.5 + i, 0} : (vec3){i, 0.5, 0};
        b[i] = boxes ? add_box(w, look(0.5, 0), (vec3){1, 1, 1}, 1, at, quat_identity())
                     : add_ball(w, look(0.5, 0), 0.5, 1, at, vec3_zero());
    }
}

static void hit_a_row(bool boxes, bool stacked, int n)
{
    dig_world *w = open_world(1.0 / 60, NULL, true);
    add_floor(w, look(0.5, 0));
    dig_body b[100];
    make_row(w, boxes, stacked, n, b);
    dig_dig_state dig = {.size = 0};
    for (int i = 0; i < 60 && dig.size < n; i++) {      /* a hundred boxes need some steps to find their forces */
        step(w, 1);
        CHECK(dig_dig_get(w, dig_of(w, b[0]), &dig) == DIG_OK);
    }
    if (dig.size != n)
        fail_msg("%d %s, %s: a DIG of %d", n, boxes ? "boxes" : "balls", stacked ? "stacked" : "in a row", dig.size);
    for (int i = 1; i < n; i++)
        CHECK_INT(dig_of(w, b[i]).id, dig_of(w, b[0]).id);
    dig_body striker = add_ball(w, look(0.5, 0), 0.3, 2, (vec3){-0.81, stacked ? 0.5 + n / 2 : 0.5, 0}, (vec3){3, 0, 0});
    static dig_message messages[4096];
    int told[100] = {0}, count = 0, hits = 0;
    for (int i = 0; i < 3 && hits == 0; i++) {
        step(w, 1);
        count = dig_messages(w, messages, 4096);
        const dig_event *e;
        int events = dig_events(w, &e);
        for (int k = 0; k < events; k++)
            hits += e[k].kind == DIG_EVENT_IMPACT && (e[k].a.slot == striker.slot || e[k].b.slot == striker.slot);
    }
    if (hits < 1)
        fail_msg("%d %s, %s: no hit", n, boxes ? "boxes" : "balls", stacked ? "stacked" : "in a row");
    for (int k = 0; k < count; k++)
        for (int i = 0; i < n; i++)
            told[i] += messages[k].to.slot == b[i].slot && messages[k].from.slot == striker.slot &&
                       strcmp(messages[k].kind, "collision") == 0;
    for (int i = 0; i < n; i++)
        if (told[i] != hits)
            fail_msg("%s %d of %d was told %d times of %d hits", boxes ? "box" : "ball", i, n, told[i], hits);
    CHECK(stacked || hits == 1);            /* a ball at half height is struck again when it is squeezed out */
    check_world(w);
    step(w, 30);
    check_world(w);
    dig_world_close(w);
}

TEST(each_member_of_a_struck_dig_is_told_once)
{
    const int sizes[] = {3, 4, 10, 30, 100};
    for (int i = 0; i < 5; i++) {
        hit_a_row(false, false, sizes[i]);
        hit_a_row(true, false, sizes[i]);
        hit_a_row(false, true, sizes[i]);
        hit_a_row(true, true, sizes[i]);
    }
}

/* ---- overlaps, stacks ------------------------------------------------------------------ */

/* B08. Eight unit boxes nearly in one place move apart; nothing is launched, whatever the step. */
TEST(deep_overlaps_part_without_launching)
{
    const real steps[] = {1.0 / 30, 1.0 / 60, 1.0 / 1000};
    for (int i = 0; i < 3; i++) {
        dig_world *w = open_world(steps[i], NULL, true);
        add_floor(w, look(0.5, 0));
        dig_body b[8];
        for (int k = 0; k < 8; k++)
            b[k] = add_box(w, look(0.5, 0), (vec3){1, 1, 1}, 1, (vec3){0.05 * (k & 1), 0.6 + 0.05 * (k >> 2), 0.05 * (k >> 1 & 1)},
                           quat_identity());
        real fastest = 0, lowest = 1;
        real end = SANITIZED || i == 2 ? 2 : 10;
        while (dig_world_time(w) < end) {
            step(w, 1);
            for (int k = 0; k < 8; k++) {
                dig_body_state s = state_of(w, b[k]);
                fastest = real_max(fastest, vec3_length(s.velocity));
                lowest = real_min(lowest, s.low.y);
            }
        }
        printf("dt %g: v_max %.3f m/s, overlap at the end %.2e m, lowest point %.2e m\n", steps[i], fastest,
               dig_world_stats(w).penetration, lowest);
        CHECK(fastest < 3);
        CHECK(lowest > -0.5);
        if (end > 2) {
            CHECK(dig_world_stats(w).penetration < 1e-3);
            for (int k = 0; k < 8; k++)
                CHECK(state_of(w, b[k]).low.y > -1e-3);
        }
        check_world(w);
        dig_world_close(w);
    }
}

/* A17 (a), B02 small. Ten boxes stand, and each carries what is above it. */
TEST(stack_of_ten_stands_and_carries_its_weight)
{
    const real steps[] = {1.0 / 30, 1.0 / 60, 1.0 / 1000};
    for (int i = 0; i < 3; i++) {
        dig_world_def def = dig_world_defaults();
        def.gravity = (vec3){0, -GRAVITY, 0};
        def.step = steps[i];
        def.sleeping = false;
        dig_world *w = open_with(def);
        add_floor(w, look(0.6, 0));
        dig_body b[10];
        for (int k = 0; k < 10; k++)
            b[k] = add_box(w, look(0.6, 0), (vec3){1, 1, 1}, 1, (vec3){0, 0.5 + k, 0}, quat_identity());
        real end = SANITIZED || i == 2 ? 1 : 8;
        while (dig_world_time(w) < end)
            step(w, 1);
        for (int k = 0; k < 10; k++) {
            dig_body_state s = state_of(w, b[k]);
            CHECK_NEAR(s.position.y, 0.5 + k, 1e-9);
            CHECK_NEAR(hypot(s.position.x, s.position.z), 0, 1e-4);
            CHECK_NEAR(vec3_length(s.velocity), 0, 1e-6);
            dig_link links[4];
            int n = dig_links_of(w, b[k], links, 4);
            real up = 0;
            for (int m = 0; m < n; m++) {
                real side = links[m].b.slot == b[k].slot ? 1 : -1;
                up = real_max(up, side * links[m].effort.y);
            }
            CHECK_NEAR(up, (10 - k) * GRAVITY, 1e-6);
        }
        check_world(w);
        dig_world_close(w);
    }
}

TEST(sleeping_stack_costs_nothing_and_wakes_whole)
{
    dig_world *w = open_world(1.0 / 60, NULL, true);
    add_floor(w, look(0.6, 0));
    dig_body b[10];
    for (int k = 0; k < 10; k++)
        b[k] = add_box(w, look(0.6, 0), (vec3){1, 1, 1}, 1, (vec3){0, 0.5 + k, 0}, quat_identity());
    step(w, 120);
    CHECK_INT(sleepers(w), 10);
    step(w, 60);
    dig_stats s = dig_world_stats(w);
    CHECK_INT(s.groups, 0);
    CHECK_INT(s.iterations, 0);
    CHECK_INT(s.awake, 0);
    /* picking the lowest from under the pile wakes exactly that DIG, at once */
    CHECK(dig_body_remove(w, b[0]) == DIG_OK);
    CHECK_INT(sleepers(w), 0);
    step(w, 1);
    CHECK(state_of(w, b[1]).velocity.y < -0.1);
    check_world(w);
    dig_world_close(w);
}

/* Pairs that may meet in the last step. */
static int met(const dig_world *w)
{
    int n = 0;
    for (int i = 0; i < w->pairs.count; i++)
        n += w->pairs.data[i].alive && w->pairs.data[i].listed && pair_met(w, &w->pairs.data[i]);
    return n;
}

/* What turns in place reaches nothing by that, and a sleeper is only where it is: of a ball that rolls by at 4 m/s, boxes 5 cm beside its way
 * are no business. */
TEST(sleepers_beside_the_way_of_a_ball_are_not_looked_at)
{
    dig_world *w = open_world(1.0 / 60, NULL, true);
    add_floor(w, look(0.5, 0));
    for (int i = 0; i < 6; i++)
        add_box(w, look(0, 0), (vec3){1, 1, 1}, 10, (vec3){2 + 1.5 * i, 0.5, i % 2 ? 0.75 : -0.75}, quat_identity());
    step(w, 120);
    CHECK_INT(sleepers(w), 6);
    dig_body b = add_ball(w, look(0.5, 0), 0.2, 1, (vec3){0, 0.2, 0}, (vec3){4, 0, 0});
    CHECK(dig_body_teleport(w, b, NULL, NULL, &(vec3){4, 0, 0}, &(vec3){0, 0, -20}) == DIG_OK);
    for (int i = 0; i < 120; i++) {
        step(w, 1);
        CHECK_INT(met(w), 1);                  /* with the floor */
    }
    CHECK_NEAR(state_of(w, b).position.x, 8, 1e-9);
    CHECK_INT(sleepers(w), 6);
    dig_world_close(w);
}

/* ---- movers ---------------------------------------------------------------------------- */

/* B19 without the squeeze: a kinematic wall pushes a box ahead of itself at its own speed, awake or asleep before. */
TEST(kinematic_pusher_moves_what_is_in_its_way)
{
    dig_world *w = open_world(1.0 / 60, NULL, true);
    add_floor(w, look(0.5, 0));
    dig_body box = add_box(w, look(0.5, 0), (vec3){1, 1, 1}, 5, (vec3){0, 0.5, 0}, quat_identity());
    step(w, 60);
    CHECK(!state_of(w, box).awake);
    dig_body_def d = body_with(look(0.5, 0), (vec3){-2, 1, 0}, quat_identity());
    d.kinematic = true;
    d.velocity = (vec3){0.5, 0, 0};
    dig_body wall = add_body(w, d, "box", &(dig_box_def){{1, 1.9, 3}});
    step(w, 360);
    /* faces meet at x = -0.5 after 2 s: then together at 0.5 m/s */
    CHECK_NEAR(state_of(w, wall).position.x, 1, 1e-9);
    CHECK_NEAR(state_of(w, box).position.x, 2, 1e-5);
    CHECK_NEAR(state_of(w, box).velocity.x, 0.5, 1e-6);
    CHECK_NEAR(state_of(w, box).position.y, 0.5, 1e-6);
    check_world(w);
    dig_world_close(w);
}

/* A turntable whose edge is fast enough to strike what lies on it far away: the box of the ball's leaf has room for that, and lasts. */
TEST(leaves_of_what_a_fast_mover_carries_last_for_steps)
{
    dig_world *w = open_world(1.0 / 60, NULL, true);
    dig_body_def d = body_with(look(0.5, 0), (vec3){0, -0.1, 0}, quat_identity());
    d.kinematic = true;
    d.spin = (vec3){0, 3.5, 0};
    add_body(w, d, "box", &(dig_box_def){{6, 0.2, 6}});
    dig_body ball = add_ball(w, look(0.5, 0), 0.1, 1, (vec3){1, 0.1, 0}, (vec3){0, 0, 0.5});
    int32_t leaf = w->solids.data[w->bodies.data[ball.slot].shape_first].leaf;
    int moved = 0;
    for (int i = 0; i < 120; i++) {
        box3 before = tree_box(&w->tree, leaf), after;
        step(w, 1);
        after = tree_box(&w->tree, leaf);
        moved += !vec3_equal(before.low, after.low);
    }
    CHECK(moved > 0 && moved < 60);
    CHECK_NEAR(state_of(w, ball).position.y, 0.1, 1e-6);
    dig_world_close(w);
}

TEST(lift_carries_its_load_up_and_down)
{
    dig_world *w = open_world(1.0 / 60, NULL, true);
    dig_body_def d = body_with(look(0.5, 0), (vec3){0, -0.1, 0}, quat_identity());
    d.kinematic = true;
    dig_body lift = add_body(w, d, "box", &(dig_box_def){{3, 0.2, 3}});
    dig_body load[3];
    for (int i = 0; i < 3; i++)
        load[i] = add_box(w, look(0.5, 0), (vec3){0.5, 0.5, 0.5}, 2, (vec3){0, 0.25 + 0.5 * i, 0}, quat_identity());
    step(w, 60);
    CHECK(dig_body_move_to(w, lift, (vec3){0, 1.9, 0}, NULL, 4) == DIG_OK);
    step(w, 240);
    for (int i = 0; i < 3; i++)
        CHECK_NEAR(state_of(w, load[i]).position.y, 2.25 + 0.5 * i, 2e-3);
    CHECK(dig_body_move_to(w, lift, (vec3){0, -0.1, 0}, NULL, 4) == DIG_OK);
    step(w, 330);
    for (int i = 0; i < 3; i++) {
        CHECK_NEAR(state_of(w, load[i]).position.y, 0.25 + 0.5 * i, 1e-4);
        CHECK_NEAR(hypot(state_of(w, load[i]).position.x, state_of(w, load[i]).position.z), 0, 1e-4);
    }
    dig_world_close(w);
}

/* ---- B25 --------------------------------------------------------------------------------- */

/* Three spheres on one axis: the scene at which the founding document's engine failed. */
static void three_spheres(real e)
{
    dig_world *w = open_world(1.0 / 60, NULL, true);
    add_floor(w, look(0.5, e));
    dig_body b[3];
    for (int i = 0; i < 3; i++)
        b[i] = add_ball(w, look(0.5, e), 0.5, 1, (vec3){0, 1.5 * (i + 1), 0}, vec3_zero());
    real e0 = dig_world_energy(w).total, old = e0;
    for (int i = 0; i < 600; i++) {
        step(w, 1);
        CHECK(dig_world_stats(w).penetration < 1e-4);
        for (int k = 0; k < 3; k++) {
            dig_body_state s = state_of(w, b[k]);
            CHECK_NEAR(s.position.x, 0, 1e-12);
            CHECK_NEAR(s.position.z, 0, 1e-12);
            CHECK(s.position.y > 0.4999 + k * 0.9999);
        }
        real now = dig_world_energy(w).total;
        if (e == 1)
            CHECK_NEAR(now / e0, 1, 1e-9);
        else
            CHECK(now <= old + 1e-9 * e0);
        old = now;
    }
    if (e < 1)
        for (int k = 0; k < 3; k++) {
            CHECK_NEAR(state_of(w, b[k]).position.y, 0.5 + k, 1e-6);
            CHECK_NEAR(vec3_length(state_of(w, b[k]).velocity), 0, 0);
        }
    dig_world_close(w);
}

TEST(three_spheres_on_one_axis_come_to_rest)
{
    three_spheres(0);
    three_spheres(0.8);
}

TEST(three_elastic_spheres_on_one_axis_keep_their_energy) { three_spheres(1); }

/* ---- memory and threads ------------------------------------------------------------------- */

/* Many piles on one floor, each a DIG of its own. */
static void many_piles(dig_world *w, int piles)
{
    add_floor(w, look(0.6, 0.3));
    for (int i = 0; i < piles; i++)
        for (int k = 0; k < 4; k++) {
            vec3 at = {3.0 * (i % 8) + 0.03 * k, 0.6 + 1.05 * k, 3.0 * (i / 8) + 0.02 * k * (i % 3)};
            if ((i + k) % 3 == 0)
                add_ball(w, look(0.6, 0.3), 0.5, 3, at, vec3_zero());
            else
                add_box(w, look(0.6, 0.3), (vec3){1, 1, 1}, 5, at, quat_exp((vec3){0, 0.2 * i, 0.05 * k}));
        }
}

TEST(steady_state_allocates_nothing)
{
    dig_world *w = open_world(1.0 / 60, NULL, true);
    many_piles(w, 6);
    step(w, 300);
    uint64_t before = dig_world_stats(w).allocations;
    step(w, 200);                           /* at rest */
    CHECK_INT(dig_world_stats(w).allocations, before);
    dig_world_close(w);

    w = open_world(1.0 / 60, NULL, true);
    add_floor(w, look(0, 1));
    for (int i = 0; i < 20; i++)            /* for ever bouncing */
        add_ball(w, look(0, 1), 0.2, 1, (vec3){0.41 * i, 0.5 + 0.05 * i, 0}, vec3_zero());
    step(w, 400);
    before = dig_world_stats(w).allocations;
    step(w, 200);
    CHECK_INT(dig_world_stats(w).allocations, before);
    CHECK(dig_world_stats(w).awake == 20);
    dig_world_close(w);
}

static uint64_t run_piles(int threads, int steps)
{
    dig_world_def def = dig_world_defaults();
    def.gravity = (vec3){0, -GRAVITY, 0};
    def.threads = threads;
    dig_world *w = open_with(def);
    many_piles(w, 16);
    step(w, steps);
    uint64_t sum = dig_world_checksum(w);
    dig_world_close(w);
    return sum;
}

TEST(any_number_of_threads_gives_the_same_bits)
{
    int steps = SANITIZED ? 30 : 75;
    uint64_t one = run_piles(1, steps);
    CHECK(run_piles(1, steps) == one);
    CHECK(run_piles(2, steps) == one);
    CHECK(run_piles(4, steps) == one);
    CHECK(run_piles(4, steps) == one);
    CHECK(run_piles(1, steps - 1) != one);
}

int main(void)
{
    RUN_TESTS(unit_test(penetration_at_rest_is_below_a_millimetre),
              unit_test(bounces_end_in_exact_rest_and_a_hit_wakes_in_the_same_step),
              unit_test(struck_sleeper_moves_within_the_same_step),
              unit_test(each_member_of_a_struck_dig_is_told_once),
              unit_test(deep_overlaps_part_without_launching),
              unit_test(stack_of_ten_stands_and_carries_its_weight),
              unit_test(sleeping_stack_costs_nothing_and_wakes_whole),
              unit_test(sleepers_beside_the_way_of_a_ball_are_not_looked_at),
              unit_test(kinematic_pusher_moves_what_is_in_its_way),
              unit_test(leaves_of_what_a_fast_mover_carries_last_for_steps),
              unit_test(lift_carries_its_load_up_and_down),
              unit_test(three_spheres_on_one_axis_come_to_rest),
              unit_test(three_elastic_spheres_on_one_axis_keep_their_energy),
              unit_test(steady_state_allocates_nothing),
              unit_test(any_number_of_threads_gives_the_same_bits));
}
