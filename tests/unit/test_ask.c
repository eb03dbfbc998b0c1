/* test_ask.c - exploratory questions in random worlds: asking changes nothing; what is said to move moves, what is said to be held
 * is held, when it is done. DIGBOX_FULL=1: as many scenes as the project promises (10,000 questions, 1000 done).
 */
#include "physics_fixture.h"

#include "base/rng.h"

#include <stdlib.h>

static bool full(void) { return getenv("DIGBOX_FULL") != NULL; }

static real between(uint64_t *seed, real low, real high) { return low + (high - low) * rng_real(seed); }

/* A floor, some boxes and balls on it, close enough to touch, some of them joined to each other or bolted to a wall. */
typedef struct Scene { dig_world *w; dig_body body[12]; int count; } Scene;

static dig_body add_solid(Scene *s, uint64_t *seed, vec3 at)
{
    dig_body_def def = dig_body_defaults();
    bool ball = rng_real(seed) < 0.3;
    dig_sphere_def sphere = {0.5};
    dig_box_def box = {{1, 1, 1}};
    dig_shape_def shape = {ball ? "sphere" : "box", ball ? (const void *)&sphere : (const void *)&box, {{0, 0, 0}, {0, 0, 0, 1}}, {""}, {-1, -1, -1}, 0, NULL};
    def.at = at;
    def.mass = exp(between(seed, log(0.5), log(50)));
    def.friction = between(seed, 0.05, 0.8);
    def.shapes = &shape;
    def.shape_count = 1;
    dig_body b;
    CHECK_INT(dig_body_create(s->w, &def, &b), DIG_OK);
    return b;
}

static void bolt(dig_world *w, dig_body a, dig_body b)
{
    dig_joint_def def = dig_joint_defaults();
    dig_joint j;
    def.type = "bolt";
    def.a = a;
    def.b = b;
    CHECK_INT(dig_joint_create(w, &def, &j), DIG_OK);
}

static void build(Scene *s, uint64_t number)
{
    uint64_t seed = number * 7919 + 17;
    char why[256];
    dig_world_def def = dig_world_defaults();
    CHECK_INT(dig_world_open(&def, &s->w, why, sizeof why), DIG_OK);
    dig_body_def ground = dig_body_defaults();
    dig_plane_def plane = {{0, 1, 0}, 0};
    dig_shape_def shape = {"plane", &plane, {{0, 0, 0}, {0, 0, 0, 1}}, {""}, {-1, -1, -1}, 0, NULL};
    ground.fixed = true;
    ground.friction = 0.5;
    ground.shapes = &shape;
    ground.shape_count = 1;
    dig_body floor;
    CHECK_INT(dig_body_create(s->w, &ground, &floor), DIG_OK);
    s->count = 1 + (int)between(&seed, 0, 5);
    for (int i = 0; i < s->count; i++) {
        bool on_top = i > 0 && rng_real(&seed) < 0.3;
        s->body[i] = add_solid(s, &seed, (vec3){1.001 * (on_top ? i - 1 : i), on_top ? 1.501 : 0.501, 0});
        if (rng_real(&seed) < 0.15)
            bolt(s->w, s->body[i], i > 0 && rng_real(&seed) < 0.5 ? s->body[i - 1] : floor);
    }
    for (int i = 0; i < 60; i++)
        CHECK_INT(dig_world_step(s->w), DIG_OK);
}

static dig_question random_question(const Scene *s, uint64_t *seed)
{
    dig_question q = dig_question_defaults();
    q.body = s->body[(int)between(seed, 0, s->count - 1e-9)];
    real turn = between(seed, 0, 6.28318);
    q.along = rng_real(seed) < 0.2 ? (vec3){0, 1, 0} : (vec3){cos(turn), 0, sin(turn)};
    q.by = between(seed, 0.005, 0.3);
    q.with = rng_real(seed) < 0.2 ? (real)NAN : exp(between(seed, log(0.5), log(800)));
    q.within = 2;
    return q;
}

TEST(asking_changes_nothing)
{
    int scenes = full() ? 1000 : 12, asked = 0;
    for (int i = 0; i < scenes; i++) {
        Scene s;
        build(&s, (uint64_t)i);
        uint64_t seed = (uint64_t)i + 1, before = dig_world_checksum(s.w);
        dig_stats was = dig_world_stats(s.w);
        for (int k = 0; k < 10; k++, asked++) {
            dig_question q = random_question(&s, &seed);
            dig_answer a;
            CHECK_INT(dig_ask(s.w, &q, &a), DIG_OK);
            CHECK(a.because[0] && a.chain_count > 0);
            CHECK(dig_world_checksum(s.w) == before);
        }
        dig_stats is = dig_world_stats(s.w);
        CHECK_INT(is.steps, was.steps);
        CHECK_INT(is.events, was.events);
        CHECK_INT(dig_world_check(s.w), DIG_OK);
        dig_world_close(s.w);
    }
    print_message("    %d questions\n", asked);
}

/* How far does it go when it is done? m */
static real done(const Scene *s, const dig_question *q)
{
    dig_body_state now;
    CHECK_INT(dig_body_get(s->w, q->body, &now), DIG_OK);
    vec3 start = now.centre, along = q->along;
    real best = 0;
    CHECK_INT(dig_body_push(s->w, q->body, vec3_scale(q->with, along), start, true, 1e6), DIG_OK);
    for (int i = 0; i < 120 && best < q->by; i++) {
        CHECK_INT(dig_world_step(s->w), DIG_OK);
        CHECK_INT(dig_body_get(s->w, q->body, &now), DIG_OK);
        best = real_max(best, vec3_dot(vec3_sub(now.centre, start), along));
    }
    return best;
}

TEST(what_is_said_is_what_happens)
{
    int scenes = full() ? 1000 : 40, wrong = 0, verdicts[5] = {0};
    for (int i = 0; i < scenes; i++) {
        Scene s;
        build(&s, 5000 + (uint64_t)i);
        uint64_t seed = (uint64_t)i + 1;
        dig_question q = random_question(&s, &seed);
        dig_answer a;
        q.with = isnan(q.with) ? 20 : q.with;
        CHECK_INT(dig_ask(s.w, &q, &a), DIG_OK);
        verdicts[a.verdict]++;
        real moved = done(&s, &q);
        bool far = moved >= 0.95 * a.moved - 1e-3, farther = moved > 1.05 * a.moved + 1e-3;
        bool agrees = a.verdict == DIG_FREE ? a.ok && far && a.moved >= q.by * (1 - 1e-9) : !a.ok && far && !farther;
        if (!agrees)
            print_message("    scene %d: with %g N %s, moved %g m, said %g m (%s)\n", i, q.with, dig_verdict_name(a.verdict), moved, a.moved,
                          a.because);
        wrong += !agrees;
        dig_world_close(s.w);
    }
    print_message("    %d of %d agree: %d free, %d blocked, %d need more\n", scenes - wrong, scenes, verdicts[DIG_FREE], verdicts[DIG_BLOCKED],
                  verdicts[DIG_NEEDS]);
    CHECK(wrong * 100 <= scenes);
    CHECK(verdicts[DIG_FREE] > 0 && verdicts[DIG_BLOCKED] > 0 && verdicts[DIG_NEEDS] > 0);
}

/* Below what it needs it stays, above it starts. */
TEST(what_it_needs_is_where_it_starts)
{
    int asked = 0;
    for (int i = 0; i < (full() ? 300 : 12); i++) {
        Scene s;
        build(&s, 9000 + (uint64_t)i);
        uint64_t seed = (uint64_t)i + 1;
        dig_question q = random_question(&s, &seed), less, more;
        dig_answer a, below, above;
        q.with = NAN;
        CHECK_INT(dig_ask(s.w, &q, &a), DIG_OK);
        if (a.verdict == DIG_NEEDS) {
            less = more = q;
            less.with = 0.97 * a.needs;
            more.with = 1.03 * a.needs;
            less.by = 0.05;             /* a gap may let it go a millimetre */
            more.by = 0.002;
            CHECK_INT(dig_ask(s.w, &less, &below), DIG_OK);
            CHECK_INT(dig_ask(s.w, &more, &above), DIG_OK);
            if (below.ok || above.moved < 1e-3)
                print_message("    scene %d needs %g N: with %g N %s (%s), with %g N %s (%s)\n", i, a.needs, less.with,
                              dig_verdict_name(below.verdict), below.because, more.with, dig_verdict_name(above.verdict), above.because);
            CHECK(!below.ok);
            CHECK(above.moved >= 1e-3);
            asked++;
        }
        dig_world_close(s.w);
    }
    CHECK(asked > 0);
}

int main(void)
{
    RUN_TESTS(unit_test(asking_changes_nothing), unit_test(what_is_said_is_what_happens), unit_test(what_it_needs_is_where_it_starts));
}
