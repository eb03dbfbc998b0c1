/* tests/unit/test_chain.c - jointed groups of crowds: joints hold, energy never rises, momentum stays.
 *
 * The way is for worlds of more than a thousand awake bodies, so every world here has sixty chains of twenty links. They collide
 * with nothing.
 * Not in RENDER=0: physics alone. */
#include "physics_fixture.h"

#include <stdlib.h>

#define STEP   (1.0 / 60)
#define CHAINS 60
#define LINKS  20
#define LENGTH 0.2              /* m    of a link of a kilogramme */
#define STEPS  (SANITIZED ? 100 : 1000)

static const dig_body nobody = {0, 0};

/* A square rod from p to q. */
static dig_body throw_rod(dig_world *w, vec3 p, vec3 q, vec3 velocity)
{
    vec3 d = vec3_sub(q, p);
    real length = vec3_length(d);
    dig_box_def box = {{length, 0.02, 0.02}};
    dig_body_def def = body_with(look(0, 0), vec3_scale(0.5, vec3_add(p, q)), quat_between((vec3){1, 0, 0}, vec3_scale(1 / length, d)));
    def.mass = 1;
    def.velocity = velocity;
    def.collides = false;
    return add_body(w, def, "box", &box);
}

static dig_body add_rod(dig_world *w, vec3 p, vec3 q) { return throw_rod(w, p, q, vec3_zero()); }

static dig_world *open_crowd(bool gravity, int threads)
{
    dig_world_def def = dig_world_defaults();
    def.gravity = (vec3){0, gravity ? -GRAVITY : 0, 0};
    def.step = STEP;
    def.threads = threads;
    def.sleeping = false;
    return open_with(def);
}

/* A chain along d from a point of the world. Returns the last link. */
static dig_body hang(dig_world *w, const char *type, vec3 from, vec3 d, int links)
{
    dig_body last = nobody;
    for (int i = 0; i < links; i++) {
        vec3 p = vec3_mad(from, LENGTH * i, d);
        dig_body b = add_rod(w, p, vec3_mad(p, LENGTH, d));
        join_bodies(w, type, b, last, p, (vec3){0, 0, 1});
        last = b;
    }
    return last;
}

/* Of kinds that differ in direction, so that each falls otherwise. */
static void hang_all(dig_world *w)
{
    for (int i = 0; i < CHAINS; i++) {
        real turn = 0.1 * i;
        hang(w, "ball", (vec3){i, 0, 0}, (vec3){cos(turn), sin(turn), 0}, LINKS);
    }
}

/* On the tip of each link hang three others, as long as there are any. */
static void hang_trees(dig_world *w)
{
    for (int i = 0; i < CHAINS; i++) {
        dig_body link[LINKS];
        vec3 tip[LINKS];
        for (int n = 0; n < LINKS; n++) {
            int parent = (n - 1) / 3;
            real turn = 0.1 * i + 2.1 * n;
            vec3 p = n > 0 ? tip[parent] : (vec3){i, 0, 0};
            tip[n] = vec3_mad(p, LENGTH, (vec3){cos(turn), 0.8 * sin(turn), 0.6 * sin(turn)});
            link[n] = add_rod(w, p, tip[n]);
            join_bodies(w, "ball", link[n], n > 0 ? link[parent] : nobody, p, (vec3){0, 0, 1});
        }
    }
}

/* They count as swept, but nothing was: the way has Newton iterations, not sweeps. */
static void check_taken(const dig_world *w)
{
    dig_stats s = dig_world_stats(w);
    if (s.swept != CHAINS || s.iterations != 0)
        fail_msg("%d groups, %d sweeps: %s", s.swept, s.iterations, s.gave_up_why);
}

/* Falls, cracks and swings for a quarter of a minute. */
static void check_fall(void build(dig_world *), real error)
{
    dig_world *w = open_crowd(true, 1);
    build(w);
    const real scale = CHAINS * LINKS * GRAVITY * LENGTH * LINKS;
    real last = dig_world_energy(w).total;
    for (int i = 0; i < STEPS; i++) {
        step(w, 1);
        real e = dig_world_energy(w).total;
        if (!(e <= last + 1e-7 * scale))
            fail_msg("step %d: energy rises by %g of its scale", i, (e - last) / scale);
        CHECK(dig_world_stats(w).joint_error < error);
        check_taken(w);
        last = e;
    }
    check_world(w);
    dig_world_close(w);
}

TEST(chains_hold_together_and_energy_never_rises) { check_fall(hang_all, 3e-5); }
TEST(trees_hold_together_and_energy_never_rises) { check_fall(hang_trees, 3e-5); }

/* ---- statics ---- */

/* Link k from the middle of a chain that hangs from both ends carries (k + 1/2) of its weight: tan(slope) = (k + 1/2) m g / H. */
static real span_of(real pull)
{
    real sum = 0;
    for (int k = 0; k < LINKS / 2; k++)
        sum += 2 * LENGTH * cos(atan((k + 0.5) * GRAVITY / pull));
    return sum;
}

static real pull_for(real span)
{
    real low = 1e-3, high = 1e5;
    for (int i = 0; i < 200; i++) {
        real mid = 0.5 * (low + high);
        *(span_of(mid) < span ? &low : &high) = mid;
    }
    return low;
}

/* From x = -span / 2 to span / 2. Returns the joint at the left end. */
static dig_joint add_catenary(dig_world *w, real pull, real span, real z, dig_body *middle)
{
    vec3 p = {-0.5 * span, 0, z};
    dig_joint first = {0, 0};
    dig_body last = nobody;
    for (int i = 0; i < LINKS; i++) {
        real slope = atan((i - LINKS / 2 + 0.5) * GRAVITY / pull);
        vec3 q = vec3_mad(p, LENGTH, (vec3){cos(slope), sin(slope), 0});
        dig_body b = add_rod(w, p, q);
        dig_joint j = join_bodies(w, "ball", b, last, p, (vec3){0, 0, 1});
        if (i == 0)
            first = j;
        if (i == LINKS / 2)
            *middle = b;
        last = b;
        p = q;
    }
    join_bodies(w, "ball", last, nobody, p, (vec3){0, 0, 1});
    return first;
}

TEST(chains_between_two_points_hang_as_statics_says)
{
    const real span = 0.7 * LINKS * LENGTH, pull = pull_for(span), weight = LINKS * GRAVITY;
    dig_world *w = open_crowd(true, 1);
    dig_body middle[CHAINS];
    dig_joint left[CHAINS];
    vec3 before[CHAINS];
    for (int i = 0; i < CHAINS; i++) {
        left[i] = add_catenary(w, pull, span, i, &middle[i]);
        before[i] = state_of(w, middle[i]).position;
    }
    step(w, 300);
    check_taken(w);
    for (int i = 0; i < CHAINS; i++) {
        dig_joint_state s;
        CHECK(dig_joint_get(w, left[i], &s) == DIG_OK);
        CHECK_NEAR(vec3_distance(state_of(w, middle[i]).position, before[i]), 0, 1e-4 * LENGTH);
        CHECK_NEAR(-s.force.x, pull, 1e-3 * pull);
        CHECK_NEAR(s.force.y, 0.5 * weight, 1e-3 * weight);
    }
    dig_world_close(w);
}

/* ---- what is conserved ---- */

/* Angular momentum up to the weights of 0.51 and 0.49 and joints open by micrometres. */
TEST(free_chains_keep_momentum_and_angular_momentum)
{
    dig_world *w = open_crowd(false, 1);
    for (int i = 0; i < CHAINS; i++) {
        dig_body last = nobody;
        for (int k = 0; k < LINKS; k++) {
            vec3 p = {LENGTH * k, 2 * i, 0};
            dig_body b = throw_rod(w, p, (vec3){LENGTH * (k + 1), 2 * i, 0}, (vec3){0.3, 0.2 * k - 1, 0.1 * (k % 3)});
            if (k > 0)
                join_bodies(w, "ball", b, last, p, (vec3){0, 0, 1});
            last = b;
        }
    }
    vec3 p = dig_world_momentum(w), l = dig_world_angular_momentum(w);
    step(w, 1);
    real first = dig_world_energy(w).total, most = 0;
    for (int i = 0; i < (SANITIZED ? 50 : 300); i++) {
        step(w, 1);
        most = real_max(most, dig_world_energy(w).total);
        CHECK_NEAR(vec3_distance(dig_world_momentum(w), p) / vec3_length(p), 0, 1e-12);
        CHECK_NEAR(vec3_distance(dig_world_angular_momentum(w), l) / vec3_length(l), 0, 1e-3);
    }
    CHECK(most <= (1 + 1e-6) * first);
    CHECK(dig_world_energy(w).total < first);
    check_taken(w);
    dig_world_close(w);
}

/* ---- the choice ---- */

TEST(a_small_world_keeps_the_finer_ways)
{
    dig_world *w = open_crowd(true, 1);
    hang(w, "ball", vec3_zero(), (vec3){1, 0, 0}, LINKS);
    step(w, 30);
    CHECK_INT(dig_world_stats(w).conserved, 1);
    CHECK(dig_world_stats(w).joint_error < 1e-10);
    dig_world_close(w);
}

/* Four links in a ring among the chains. */
TEST(rings_are_swept)
{
    dig_world *w = open_crowd(true, 1);
    hang_all(w);
    const vec3 corner[4] = {{0, 9, 0}, {LENGTH, 9, 0}, {LENGTH, 9 + LENGTH, 0}, {0, 9 + LENGTH, 0}};
    dig_body b[4];
    for (int i = 0; i < 4; i++)
        b[i] = add_rod(w, corner[i], corner[(i + 1) % 4]);
    for (int i = 0; i < 4; i++)
        join_bodies(w, "ball", b[i], b[(i + 3) % 4], corner[i], (vec3){0, 0, 1});
    join_bodies(w, "ball", b[0], nobody, corner[0], (vec3){0, 0, 1});
    step(w, 10);
    CHECK_INT(dig_world_stats(w).swept, CHAINS + 1);
    CHECK(dig_world_stats(w).iterations > 0);
    CHECK(dig_world_stats(w).joint_error < 1e-4);
    dig_world_close(w);
}

static uint64_t fall(int threads)
{
    dig_world *w = open_crowd(true, threads);
    hang_all(w);
    step(w, 40);
    check_taken(w);
    uint64_t sum = dig_world_checksum(w);
    dig_world_close(w);
    return sum;
}

TEST(two_threads_give_the_same_bits) { CHECK(fall(1) == fall(2)); }

int main(void)
{
    RUN_TESTS(unit_test(chains_hold_together_and_energy_never_rises), unit_test(trees_hold_together_and_energy_never_rises),
              unit_test(chains_between_two_points_hang_as_statics_says), unit_test(free_chains_keep_momentum_and_angular_momentum),
              unit_test(a_small_world_keeps_the_finer_ways), unit_test(rings_are_swept), unit_test(two_threads_give_the_same_bits));
}
