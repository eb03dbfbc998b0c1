/* tests/unit/test_random_stacks.c - random piles that are knocked, and a room full of bodies: nothing becomes immaterial, nothing
 * is lost, no label is wrong.
 *
 * DIGBOX_FULL=1 (`make soak`) knocks 10 000 piles and runs the room for the full 100 000 frames; under sanitizers an eighth is done.
 * Not in RENDER=0: physics alone. */
#define _POSIX_C_SOURCE 200809L
#include "base/rng.h"
#include "physics_fixture.h"

#include <pthread.h>
#include <stdlib.h>

static real uniform(uint64_t *rng, real lo, real hi) { return lo + (hi - lo) * rng_real(rng); }

/* ---- row 89 ---------------------------------------------------------------------------------- */

typedef struct Tally { int64_t runs, steps, immaterial, lost, labels; real deepest; } Tally;

/* Overlap of a pile at the end of a step: more than this share of the smallest size is more than a blow presses in. */
#define IMMATERIAL 0.1

static void look_at(dig_world *w, const dig_body *b, int n, real smallest, Tally *t)
{
    dig_body list[8];
    if (dig_bodies(w, list, 8) != n + 1)
        t->lost++;
    for (int i = 0; i < n; i++) {
        dig_body_state s;
        if (dig_body_get(w, b[i], &s) != DIG_OK || !vec3_finite(s.position) || !vec3_finite(s.velocity)) {
            t->lost++;
            continue;
        }
        if (s.centre.y < 0 || fabs(s.centre.x) > 100 || fabs(s.centre.z) > 100)
            t->immaterial++;                /* below the floor, or shot away */
    }
    real deep = dig_world_stats(w).penetration / smallest;
    t->deepest = real_max(t->deepest, deep);
    if (deep > IMMATERIAL)
        t->immaterial++;
    if (dig_world_check(w) != DIG_OK) {
        t->labels++;
        printf("at t = %g s: %s\n", dig_world_time(w), dig_error(w));
    }
}

static vec3 direction(uint64_t *rng)
{
    vec3 d = {uniform(rng, -1, 1), uniform(rng, -0.3, 0.6), uniform(rng, -1, 1)};
    return vec3_unit(d);
}

static void random_run(uint64_t seed, Tally *t)
{
    uint64_t rng = seed * 0x9E3779B97F4A7C15u + 1;
    static const real steps[] = {1.0 / 30, 1.0 / 60, 1.0 / 120};
    real h = steps[(int)uniform(&rng, 0, 3)];
    dig_world *w = open_world(h, uniform(&rng, 0, 1) < 0.9 ? "sketch" : "play", true);
    Look l = {uniform(&rng, 0, 1), NAN, 0, uniform(&rng, 0, 1) < 0.5 ? 0 : uniform(&rng, 0, 0.9)};
    add_floor(w, l);
    int n = 3 + (int)uniform(&rng, 0, 4), count = 40 + (int)uniform(&rng, 0, 51);
    dig_body b[6];
    real y = 0, smallest = INFINITY, gap = uniform(&rng, 0, 1) < 0.5 ? 0 : uniform(&rng, 0, 0.5);
    for (int i = 0; i < n; i++) {
        vec3 at = {uniform(&rng, -0.1, 0.1), 0, uniform(&rng, -0.1, 0.1)};
        if (uniform(&rng, 0, 1) < 0.5) {
            real r = uniform(&rng, 0.1, 0.5);
            at.y = y + gap + r;
            b[i] = add_ball(w, l, r, uniform(&rng, 0.2, 20), at, vec3_zero());
            y = at.y + r;
            smallest = real_min(smallest, 2 * r);
        } else {
            vec3 size = {uniform(&rng, 0.2, 1.2), uniform(&rng, 0.1, 1), uniform(&rng, 0.2, 1.2)};
            quat q = quat_exp((vec3){0, uniform(&rng, 0, 3), 0});
            at.y = y + gap + 0.5 * size.y;
            b[i] = add_box(w, l, size, uniform(&rng, 0.2, 20), at, q);
            y = at.y + 0.5 * size.y;
            smallest = real_min(smallest, real_min(size.x, real_min(size.y, size.z)));
        }
    }
    int knock = (int)uniform(&rng, 5, 25), struck = (int)uniform(&rng, 0, n);
    for (int i = 0; i < count; i++) {
        if (i == knock) {
            real mass = state_of(w, b[struck]).mass;
            vec3 at = vec3_add(state_of(w, b[struck]).centre, vec3_scale(0.1, direction(&rng)));
            dig_body_hit(w, b[struck], vec3_scale(mass * uniform(&rng, 0.5, 15), direction(&rng)), at, true);
        }
        if (dig_world_step(w) != DIG_OK) {
            printf("run %llu: %s\n", (unsigned long long)seed, dig_error(w));
            t->lost++;
            break;
        }
        t->steps++;
        if (i % 8 == 7 || i == count - 1) {
            Tally before = *t;
            look_at(w, b, n, smallest, t);
            if (t->immaterial + t->lost + t->labels > before.immaterial + before.lost + before.labels)
                printf("run %llu, step %d of %d, h = %g: immaterial %d, lost %d, labels %d, depth %.3g of the smallest size\n",
                       (unsigned long long)seed, i, count, h, t->immaterial > before.immaterial, t->lost > before.lost,
                       t->labels > before.labels, dig_world_stats(w).penetration / smallest);
        }
    }
    t->runs++;
    dig_world_close(w);
}

/* Worlds share nothing: the runs are dealt out to threads. */
#define THREADS 2

typedef struct Share { int64_t first, end; Tally tally; } Share;

static void *run_share(void *arg)
{
    Share *s = arg;
    for (int64_t i = s->first; i < s->end; i++)
        random_run((uint64_t)i + 1, &s->tally);
    return NULL;
}

TEST(random_stacks_that_are_knocked_keep_everything)
{
    const int64_t runs = getenv("DIGBOX_FULL") ? 10000 : SANITIZED ? 200 : 1500;
    Share shares[THREADS];
    pthread_t threads[THREADS];
    Tally t = {0};
    for (int i = 0; i < THREADS; i++) {
        shares[i] = (Share){.first = runs * i / THREADS, .end = runs * (i + 1) / THREADS};
        CHECK(pthread_create(&threads[i], NULL, run_share, &shares[i]) == 0);
    }
    for (int i = 0; i < THREADS; i++) {
        pthread_join(threads[i], NULL);
        const Tally *s = &shares[i].tally;
        t.runs += s->runs;
        t.steps += s->steps;
        t.immaterial += s->immaterial;
        t.lost += s->lost;
        t.labels += s->labels;
        t.deepest = real_max(t.deepest, s->deepest);
    }
    printf("%lld runs, %lld steps: %lld immaterial, %lld lost, %lld label errors; deepest overlap %.2e of the smallest size\n",
           (long long)t.runs, (long long)t.steps, (long long)t.immaterial, (long long)t.lost, (long long)t.labels, t.deepest);
    CHECK_INT(t.runs, runs);
    CHECK_INT(t.immaterial, 0);
    CHECK_INT(t.lost, 0);
    CHECK_INT(t.labels, 0);
}

/* ---- row 79 ----------------------------------------------------------------------------------- */

static const vec3 room_size = {8, 6, 8};

static int fill_room(dig_world *w, dig_body *b)
{
    dig_room_def room = {.size = room_size, .at = {0, 0, 0}, .friction = 0.3, .restitution = 0.6};
    if (dig_room_set(w, &room) != DIG_OK)
        fail_msg("room: %s", dig_error(w));
    uint64_t rng = 7;
    for (int i = 0; i < 100; i++) {
        vec3 at = {-3.2 + 1.6 * (i % 5), 0.6 + 1.2 * (i / 25), -3.2 + 1.6 * (i / 5 % 5)};
        dig_body_def d = body_with(look(0.3, 0.6), at, quat_exp((vec3){uniform(&rng, 0, 3), uniform(&rng, 0, 3), 0}));
        d.velocity = vec3_scale(uniform(&rng, 0, 10), direction(&rng));
        d.spin = vec3_scale(uniform(&rng, 0, 5), direction(&rng));
        b[i] = i % 2 ? add_body(w, d, "sphere", &(dig_sphere_def){0.25}) : add_body(w, d, "box", &(dig_box_def){{0.5, 0.4, 0.3}});
    }
    return 100;
}

static int outside(const dig_world *w, const dig_body *b, int n)
{
    int count = 0;
    for (int i = 0; i < n; i++) {
        vec3 c = state_of(w, b[i]).centre;
        count += !(fabs(c.x) < 0.5 * room_size.x && fabs(c.z) < 0.5 * room_size.z && c.y > 0 && c.y < room_size.y);
    }
    return count;
}

/* A hundred bodies that are stirred again and again stay between six walls. */
TEST(nothing_escapes_from_a_closed_room)
{
    bool full = getenv("DIGBOX_FULL") != NULL;
    int frames = full ? 100000 : SANITIZED ? 100 : 2000;      /* 100 000 take about 300 s */
    dig_world *w = open_world(1.0 / 60, "sketch", true);
    dig_body b[100];
    int n = fill_room(w, b), events = 0;
    uint64_t rng = 3;
    for (int i = 0; i < frames; i++) {
        if (i % 60 == 59)                   /* as if the room were shaken */
            for (int k = 0; k < n; k++)
                dig_body_hit(w, b[k], vec3_scale(state_of(w, b[k]).mass * uniform(&rng, 0, 8), direction(&rng)), vec3_zero(), false);
        step(w, 1);
        events += count_events(w, DIG_EVENT_OUT_OF_WORLD);
        if (i % 10 == 9 && outside(w, b, n) > 0)
            fail_msg("frame %d: %d bodies are outside", i, outside(w, b, n));
    }
    CHECK_INT(events, 0);
    CHECK_INT(outside(w, b, n), 0);
    check_world(w);
    dig_world_close(w);
}

/* A wall is opened: who leaves is reported once, by name, and stays finite. */
TEST(opened_wall_lets_bodies_out_and_tells)
{
    dig_world *w = open_world(1.0 / 60, "sketch", true);
    dig_body b[100];
    int n = fill_room(w, b);
    step(w, 30);
    CHECK(dig_room_open(w, "+x", true) == DIG_OK);
    int told[100] = {0};
    for (int i = 0; i < 150; i++) {
        for (int k = 0; k < n; k++)
            if (i % 30 == 0)
                dig_body_hit(w, b[k], (vec3){4 * state_of(w, b[k]).mass, 0, 0}, vec3_zero(), false);
        step(w, 1);
        const dig_event *e;
        int count = dig_events(w, &e);
        for (int m = 0; m < count; m++)
            for (int k = 0; k < n; k++)
                told[k] += e[m].kind == DIG_EVENT_OUT_OF_WORLD && e[m].a.slot == b[k].slot;
    }
    int left = 0;
    for (int k = 0; k < n; k++) {
        dig_body_state s = state_of(w, b[k]);
        CHECK(vec3_finite(s.position) && vec3_finite(s.velocity));
        if (s.centre.x > 0.5 * room_size.x + 1e-9)
            CHECK_INT(told[k], 1);
        CHECK(told[k] <= 1);
        left += told[k];
    }
    CHECK(left > 20);
    check_world(w);
    dig_world_close(w);
}

int main(void)
{
    RUN_TESTS(unit_test(random_stacks_that_are_knocked_keep_everything),
              unit_test(nothing_escapes_from_a_closed_room),
              unit_test(opened_wall_lets_bodies_out_and_tells));
}
