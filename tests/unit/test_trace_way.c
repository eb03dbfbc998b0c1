/* tests/unit/test_trace_way.c - the traced way as a whole: which accuracy means what, what a group that cannot be traced gets instead,
 * and that results depend on neither threads nor place.
 */
#include "save_fixture.h"

#include "solve/plan.h"
#include "world/world.h"

/* ---- accuracy ---- */

TEST(the_accuracy_number_grows_as_the_tolerance_shrinks)
{
    int last = 0;
    for (real e = 0; e <= 12; e += 0.01) {
        int a = accuracy_for(pow(10, -e));
        CHECK(a >= last && a >= 1 && a <= ACCURACY_FINEST);
        CHECK(pow(10, -a / 16.0) <= pow(10, -e) * (1 + 1e-9) || a == ACCURACY_FINEST);     /* never coarser than asked for */
        CHECK(a == 1 || pow(10, -(a - 1) / 16.0) > pow(10, -e) * (1 - 1e-9));              /* and no finer than it must be */
        last = a;
    }
    CHECK_INT(accuracy_for(1e-1), 16);
    CHECK_INT(accuracy_for(1e-4), 64);
    CHECK_INT(accuracy_for(1e-12), ACCURACY_FINEST);
    CHECK_INT(accuracy_for(1e-30), ACCURACY_FINEST);
    CHECK_INT(accuracy_for(5), 1);
}

TEST(an_accuracy_number_has_its_power_of_ten)
{
    for (int a = 0; a <= ACCURACY_FINEST; a++)
        CHECK_NEAR(accuracy_tolerance(a) / pow(10, -a / 16.0), 1, 1e-15);
}

TEST(a_plan_is_the_coarsest_that_keeps_the_tolerance)
{
    const AccuracyPlan *last = accuracy_plan(0);
    CHECK(last == &accuracy_plans[0]);
    for (int a = 1; a <= ACCURACY_FINEST; a++) {
        const AccuracyPlan *p = accuracy_plan(a);
        real tolerance = pow(10, -a / 16.0);
        CHECK(p == last || p == last + 1);
        CHECK(p->tolerance <= tolerance * (1 + 1e-9) || !p[1].name);
        CHECK(p == accuracy_plans || p[-1].tolerance > tolerance * (1 + 1e-9));
        last = p;
    }
    CHECK(!last[1].name);
    CHECK_TEXT(accuracy_plan(accuracy_for(1.01e-4))->name, "play");
    CHECK_TEXT(accuracy_plan(accuracy_for(0.99e-4))->name, "study");
}

TEST(a_plans_name_stands_for_its_tolerance)
{
    for (const AccuracyPlan *p = accuracy_plans; p->name; p++) {
        CHECK_INT(accuracy_find(p->name), accuracy_for(p->tolerance));
        CHECK(accuracy_plan(accuracy_find(p->name)) == p);
        if (p[1].name) {            /* ordered: each gives more of everything */
            CHECK(p[1].tolerance < p->tolerance && p[1].substeps >= p->substeps && p[1].trace_bodies >= p->trace_bodies);
            CHECK(p[1].trace_rows >= p->trace_rows && p[1].trace_total >= p->trace_total && p[1].trace_work >= p->trace_work);
        }
    }
    CHECK_INT(accuracy_find("best"), 0);
    CHECK_INT(accuracy_find(""), 0);
}

TEST(the_local_error_falls_with_the_accuracy_within_its_bounds)
{
    real last = INFINITY;
    for (int a = 0; a <= ACCURACY_FINEST; a++) {
        real e = accuracy_local(a), want = 0.01 * pow(10, -a / 16.0);
        CHECK(e <= last && e >= 1e-13 && e <= 1e-6);
        if (want > 1e-13 && want < 1e-6)
            CHECK_NEAR(e / want, 1, 1e-12);
        last = e;
    }
}

static dig_status ask(dig_world *w, dig_body b, const char *plan, real tolerance)
{
    return dig_dig_accuracy(w, dig_of(w, b), plan, tolerance);
}

static const char *plan_of(dig_world *w, dig_body b)
{
    dig_dig_state s;
    fail_unless(w, dig_dig_get(w, dig_of(w, b), &s), "dig");
    return s.plan;
}

/* The number itself is not public: the world's records have it. */
static int number_of(const dig_world *w, dig_body b) { return (int)graph_user(w->graph, dig_of(w, b).id); }

TEST(a_number_asked_for_a_dig_is_its_accuracy)
{
    dig_world *w = open_world(1.0 / 60, "sketch", true);
    dig_body b = add_ball(w, look(0, 0), 0.5, 1, (vec3){0, 2, 0}, vec3_zero());
    CHECK_TEXT(plan_of(w, b), "sketch");
    CHECK_INT(ask(w, b, NULL, 3e-6), DIG_OK);
    CHECK_TEXT(plan_of(w, b), "study");
    CHECK_INT(number_of(w, b), 89);             /* 16 log10(1 / 3e-6) = 88.4, upwards */
    CHECK_INT(ask(w, b, "play", 0), DIG_OK);
    CHECK_INT(number_of(w, b), 64);
    static const real bad[] = {0, -1e-3, 2, NAN, INFINITY};
    for (int i = 0; i < 5; i++)
        CHECK_INT(ask(w, b, NULL, bad[i]), DIG_E_ARG);
    CHECK_INT(ask(w, b, "perfect", 0), DIG_E_ARG);
    CHECK(strstr(dig_error(w), "perfect") != NULL);
    CHECK_INT(number_of(w, b), 64);
    CHECK_INT(dig_world_set_accuracy(w, NULL, 1e-9), DIG_OK);
    CHECK_TEXT(dig_world_accuracy(w), "reference");
    CHECK_TEXT(plan_of(w, b), "reference");     /* the finer of the world's and the DIG's */
    dig_world_close(w);
}

TEST(the_finer_accuracy_wins_when_digs_merge_and_stays_when_they_split)
{
    dig_world *w = open_world(1.0 / 60, "sketch", false);
    dig_body a = add_ball(w, look(0, 0), 0.5, 1, vec3_zero(), vec3_zero());
    dig_body b = add_ball(w, look(0, 0), 0.5, 1, (vec3){2, 0, 0}, vec3_zero());
    dig_body c = add_ball(w, look(0, 0), 0.5, 1, (vec3){4, 0, 0}, vec3_zero());
    CHECK_INT(ask(w, a, NULL, 2e-5), DIG_OK);
    CHECK_INT(ask(w, b, NULL, 1e-8), DIG_OK);
    dig_body ends[2][2] = {{a, b}, {b, c}};
    dig_joint joints[2];
    for (int i = 0; i < 2; i++) {
        dig_joint_def d = dig_joint_defaults();
        d.type = "weld";
        d.a = ends[i][0];
        d.b = ends[i][1];
        d.at = (vec3){1 + 2 * i, 0, 0};
        fail_unless(w, dig_joint_create(w, &d, &joints[i]), "weld");
    }
    step(w, 2);
    CHECK_INT(dig_of(w, a).id, dig_of(w, c).id);
    CHECK_INT(number_of(w, a), 128);
    CHECK_TEXT(plan_of(w, c), "reference");
    for (int i = 0; i < 2; i++)
        fail_unless(w, dig_joint_remove(w, joints[i]), "remove");
    step(w, 2);
    CHECK(dig_of(w, a).id != dig_of(w, b).id && dig_of(w, b).id != dig_of(w, c).id);
    CHECK_INT(number_of(w, a), 128);            /* the parts of a DIG stay as accurate as the whole was */
    CHECK_INT(number_of(w, b), 128);
    CHECK_INT(number_of(w, c), 128);
    check_world(w);
    dig_world_close(w);
}

TEST(accuracies_survive_save_and_load)
{
    char path[300];
    dig_world_def def = dig_world_defaults();
    def.tolerance = 3e-8;
    dig_world *w = open_with(def);
    add_floor(w, look(0.5, 0));
    add_ball(w, look(0.5, 0.5), 0.3, 1, (vec3){0, 1, 0}, (vec3){1, 0, 0});
    dig_body b = add_box(w, look(0.5, 0), (vec3){1, 1, 1}, 1, (vec3){4, 0.5, 0}, quat_identity());
    dig_text name = {"crate"};
    fail_unless(w, dig_body_set(w, b, "name", &name), "name");
    CHECK_INT(ask(w, b, NULL, 5e-10), DIG_OK);
    step(w, 20);
    save_to(w, scratch_path(path, sizeof path, "accuracy.world"));
    dig_world *v = load_from(path);
    remove(path);
    CHECK_INT(v->accuracy, accuracy_for(3e-8));
    dig_body c = dig_body_find(v, "crate");
    CHECK_INT(number_of(w, b), accuracy_for(5e-10));
    CHECK_INT(number_of(v, c), accuracy_for(5e-10));
    CHECK_TEXT(plan_of(v, c), "reference");
    for (int i = 0; i < 60; i++) {              /* and what they lead to */
        CHECK(dig_world_checksum(w) == dig_world_checksum(v));
        step(w, 1);
        step(v, 1);
    }
    dig_world_close(w);
    dig_world_close(v);
}

/* ---- what cannot be traced ---- */

static void add_spring(dig_world *w, dig_body a, vec3 at_a, vec3 at_b, real stiffness)
{
    const dig_schema *schema = dig_schema_find("joint", "spring");
    real params[48];
    CHECK(schema->size <= sizeof params);
    dig_schema_defaults(schema, params);
    for (const dig_param *p = schema->rows; p->name; p++) {
        void *to = (char *)params + p->offset;
        if (strcmp(p->name, "at_a") == 0)
            memcpy(to, &at_a, sizeof at_a);
        else if (strcmp(p->name, "at_b") == 0)
            memcpy(to, &at_b, sizeof at_b);
        else if (strcmp(p->name, "stiffness") == 0)
            memcpy(to, &stiffness, sizeof stiffness);
    }
    dig_joint_def d = dig_joint_defaults();
    d.type = "spring";
    d.a = a;
    d.data = params;
    dig_joint j;
    fail_unless(w, dig_joint_create(w, &d, &j), "spring");
}

/* why: NULL where the way after it hands the group on as well, so that its reason is the last */
typedef struct Case { const char *name, *why; void (*fill)(dig_world *w); } Case;

/* 1e9 N/m on 1 kg: 5000 oscillations a second. */
static void stiff_spring(dig_world *w)
{
    add_floor(w, look(0.5, 0));
    dig_body b = add_box(w, look(0.5, 0), (vec3){1, 1, 1}, 1, (vec3){0, 0.5, 0}, quat_identity());
    add_spring(w, b, (vec3){0, 1, 0}, (vec3){1, 3, 0.2}, 1e9);
    fail_unless(w, dig_body_hit(w, b, (vec3){0.5, 0, 0.2}, vec3_zero(), false), "hit");
}

static void overlapping(dig_world *w)
{
    add_floor(w, look(0.5, 0));
    add_box(w, look(0.5, 0), (vec3){1, 1, 1}, 1, (vec3){0, 0.49, 0}, quat_identity());
    add_ball(w, look(0.5, 0), 0.3, 1, (vec3){0.2, 1.2, 0.1}, vec3_zero());
}

/* 6 planks across 6 others: more rows than play allows. */
static void many_contacts(dig_world *w)
{
    add_floor(w, look(0.5, 0));
    for (int i = 0; i < 12; i++) {
        bool upper = i >= 6;
        real at = i % 6 - 2.5;
        add_box(w, look(0.5, 0), (vec3){upper ? 6 : 0.5, 0.2, upper ? 0.5 : 6}, 1, (vec3){upper ? 0 : at, upper ? 0.3 : 0.1, upper ? at : 0}, quat_identity());
    }
}

static const Case cases[] = {
    {"stiff spring", NULL, stiff_spring},
    {"overlap", "bodies that overlap", overlapping},
    {"many contacts", "more rows than its budget", many_contacts},
};
enum { CASES = sizeof cases / sizeof *cases };

static dig_world *open_case(const Case *c)
{
    dig_world_def def = dig_world_defaults();
    def.sleeping = false;
    dig_world *w = open_with(def);
    c->fill(w);
    return w;
}

/* The same world with the traced way put off. */
static void never_trace(dig_world *w)
{
    for (int i = 0; i < w->bodies.count; i++)
        w->bodies.data[i].trace_wait = 2;
}

static void check_same_bits(const char *name, const dig_world *w, const dig_world *v)
{
    dig_body all[32], same[32];
    int n = dig_bodies(w, all, 32);
    CHECK_INT(dig_bodies(v, same, 32), n);
    for (int i = 0; i < n; i++) {
        dig_body_state a = state_of(w, all[i]), b = state_of(v, same[i]);
        if (memcmp(&a.position, &b.position, sizeof a.position) != 0 || memcmp(&a.rotation, &b.rotation, sizeof a.rotation) != 0
            || memcmp(&a.velocity, &b.velocity, sizeof a.velocity) != 0 || memcmp(&a.spin, &b.spin, sizeof a.spin) != 0
            || memcmp(&a.force, &b.force, sizeof a.force) != 0 || memcmp(&a.torque, &b.torque, sizeof a.torque) != 0
            || a.mode != b.mode || a.work_received != b.work_received || a.awake != b.awake)
            fail_msg("%s: body %d differs after %g s: v = (%.17g, %.17g, %.17g), want (%.17g, %.17g, %.17g)", name, i, dig_world_time(w),
                     a.velocity.x, a.velocity.y, a.velocity.z, b.velocity.x, b.velocity.y, b.velocity.z);
    }
    dig_joint joints[4], twins[4];
    n = dig_joints(w, joints, 4);
    CHECK_INT(dig_joints(v, twins, 4), n);
    for (int i = 0; i < n; i++) {
        dig_joint_state a, b;
        CHECK_INT(dig_joint_get(w, joints[i], &a), DIG_OK);
        CHECK_INT(dig_joint_get(v, twins[i], &b), DIG_OK);
        if (!vec3_equal(a.force, b.force) || !vec3_equal(a.torque, b.torque) || a.angle != b.angle)
            fail_msg("%s: joint %d differs after %g s: force (%.17g, %.17g, %.17g), want (%.17g, %.17g, %.17g)", name, i, dig_world_time(w),
                     a.force.x, a.force.y, a.force.z, b.force.x, b.force.y, b.force.z);
    }
    dig_energy e = dig_world_energy(w), f = dig_world_energy(v);
    CHECK_NEAR(e.total, f.total, 0);
    CHECK_NEAR(e.lost, f.lost, 0);
    CHECK_NEAR(e.work_in, f.work_in, 0);
    const dig_event *p, *q;
    int events = dig_events(w, &p);
    CHECK_INT(events, dig_events(v, &q));
    for (int i = 0; i < events; i++)
        CHECK(p[i].kind == q[i].kind && p[i].time == q[i].time && p[i].impulse == q[i].impulse);
}

TEST(what_is_handed_on_goes_on_as_if_it_had_never_been_tried)
{
    for (int c = 0; c < CASES; c++) {
        dig_world *w = open_case(&cases[c]), *v = open_case(&cases[c]);
        uint64_t tried = 0;
        for (int i = 0; i < 17; i++) {          /* the try and the 16 steps after it */
            uint64_t before = dig_world_stats(w).gave_up;
            never_trace(v);
            step(w, 1);
            step(v, 1);
            dig_stats s = dig_world_stats(w);
            tried += s.gave_up - before;
            CHECK_INT(s.traced, 0);
            check_same_bits(cases[c].name, w, v);
            if (cases[c].why)
                CHECK_INT(dig_world_stats(v).gave_up, 0);
            if (cases[c].why && i == 0)
                CHECK_TEXT(s.gave_up_why, cases[c].why);
        }
        CHECK(tried >= 1 && (tried == 1 || !cases[c].why));
        check_world(w);
        dig_world_close(w);
        dig_world_close(v);
    }
}

/* ---- handed on in the middle of a motion ---- */

static void dropped_boxes(dig_world *w)
{
    add_floor(w, look(0.5, 0.2));
    for (int i = 0; i < 4; i++)
        add_box(w, look(0.5, 0.2), (vec3){0.5, 0.3, 0.4}, 2, (vec3){0.05 * i, 0.2 + 0.4 * i, 0.02 * i}, quat_exp((vec3){0, 0.4 * i, 0}));
}

static void balls_in_a_cone(dig_world *w)
{
    Look l = look(0.6, 0);
    for (int i = 0; i < 6; i++)
        add_slope(w, l, vec3_unit((vec3){cos(1.0471975511965976 * i), 0.7, sin(1.0471975511965976 * i)}));
    for (int i = 0; i < 8; i++) {
        real r = 0.17 * (1 + 0.2 * i);
        add_ball(w, l, 0.2, 1, (vec3){r * cos(2.4 * i), 0.6 + 0.25 * i, r * sin(2.4 * i)}, vec3_zero());
    }
}

/* The same with two of the balls joined, and one pushed all the time. */
static void joined_balls_in_a_cone(dig_world *w)
{
    balls_in_a_cone(w);
    dig_body all[16];
    int n = dig_bodies(w, all, 16);
    dig_joint_def d = dig_joint_defaults();
    d.type = "ball";
    d.a = all[n - 8];
    d.b = all[n - 7];
    d.at = vec3_lerp(state_of(w, d.a).position, state_of(w, d.b).position, 0.5);
    dig_joint j;
    fail_unless(w, dig_joint_create(w, &d, &j), "joint");
    fail_unless(w, dig_body_push(w, d.b, (vec3){1, 0, 0.5}, vec3_zero(), false, 10), "push");
}

static void box_on_a_rim(dig_world *w)
{
    Look l = look(0.5, 0);
    dig_body_def d = body_with(l, (vec3){0, 0.5, 0}, quat_identity());
    d.fixed = true;
    dig_box_def table = {{2, 1, 2}};
    add_body(w, d, "box", &table);
    add_floor(w, l);
    add_box(w, l, (vec3){0.8, 0.4, 0.6}, 2, (vec3){0.9, 1.5, 0.3}, quat_mul(quat_exp((vec3){0, 0.4, 0}), quat_exp((vec3){0.15, 0, 0.3})));
}

/* In v, whose step is to come, puts off what w, whose step is done, has put off. */
static void put_off_alike(const dig_world *w, dig_world *v)
{
    for (int i = 0; i < w->bodies.count; i++)
        if (w->bodies.data[i].trace_wait > 0)
            v->bodies.data[i].trace_wait = 2;
}

/* Two worlds in step; when the one hands its group on, the other is kept from trying in that very step: the same state follows.
 * Half-way through a step there is more to put back than before one. */
TEST(a_step_given_up_half_way_leaves_nothing_behind)
{
    static const Case moving[] = {{"dropped boxes", NULL, dropped_boxes}, {"balls in a cone", NULL, balls_in_a_cone},
                                  {"box on a rim", NULL, box_on_a_rim}, {"joined balls in a cone", NULL, joined_balls_in_a_cone}};
    int handed_on = 0;
    for (int c = 0; c < 4; c++) {
        dig_world *w = open_case(&moving[c]), *v = open_case(&moving[c]);
        bool gave_up = false;
        for (int i = 0; i < 90 && !gave_up; i++) {
            step(w, 1);
            gave_up = dig_world_stats(w).gave_up > 0;
            if (gave_up)
                put_off_alike(w, v);
            step(v, 1);
            check_same_bits(moving[c].name, w, v);
        }
        handed_on += gave_up;
        dig_world_close(w);
        dig_world_close(v);
    }
    CHECK(handed_on >= 1);              /* the hardest of them, at least */
}

TEST(a_group_that_was_handed_on_is_not_tried_again_for_16_steps_then_32)
{
    const Case *many = &cases[CASES - 1];
    dig_world *w = open_case(many);
    int at[4] = {0}, count = 0;
    for (int i = 0; i < 130 && count < 4; i++) {
        uint64_t before = dig_world_stats(w).gave_up;
        step(w, 1);
        dig_stats s = dig_world_stats(w);
        CHECK_INT(s.traced, 0);
        if (s.gave_up > before) {
            CHECK_TEXT(s.gave_up_why, many->why);
            at[count++] = i;
        }
    }
    CHECK_INT(count, 4);
    CHECK_INT(at[0], 0);
    CHECK_INT(at[1], 17);               /* 16 steps between them */
    CHECK_INT(at[2], 17 + 33);
    CHECK_INT(at[3], 17 + 33 + 65);
    dig_world_close(w);
}

TEST(a_group_that_can_be_traced_again_is)
{
    dig_world *w = open_world(1.0 / 60, "play", true);
    overlapping(w);
    step(w, 1);
    CHECK_INT(dig_world_stats(w).gave_up, 1);
    step(w, 16);
    CHECK_INT(dig_world_stats(w).traced, 0);
    dig_body all[4];
    dig_bodies(w, all, 4);
    vec3 up = {0, 3, 0}, aside = {5, 3, 0}, still = vec3_zero();
    fail_unless(w, dig_body_teleport(w, all[1], &up, NULL, &still, &still), "teleport");
    fail_unless(w, dig_body_teleport(w, all[2], &aside, NULL, &still, &still), "teleport");
    step(w, 1);
    CHECK_INT(dig_world_stats(w).traced, dig_world_stats(w).groups);
    step(w, 1);                         /* apart, they are two groups */
    CHECK_INT(dig_world_stats(w).traced, 2);
    CHECK_INT(dig_world_stats(w).gave_up, 1);
    dig_world_close(w);
}

/* ---- the same bits with any number of threads ---- */

static dig_world *open_sites(int threads)
{
    dig_world_def def = dig_world_defaults();
    def.threads = threads;
    dig_world *w = open_with(def);
    Look l = look(0.4, 0.3);
    add_floor(w, l);
    for (int i = 0; i < 3; i++) {
        real z = 6 * i;
        dig_body_def d = body_with(l, (vec3){0, 0.5, z}, quat_identity());
        d.velocity = (vec3){3 + i, 0, 0.5};
        d.spin = (vec3){0, 4, 0};
        dig_box_def box = {{1, 1, 1}};
        add_body(w, d, "box", &box);
        add_ball(w, l, 0.4, 1, (vec3){-10, 1 + 0.2 * i, z}, (vec3){1, 0, 0});
        d.at = (vec3){-20, 1.2, z};
        d.rotation = quat_exp((vec3){0.3, 0.2, 1 + 0.3 * i});
        dig_capsule_def pill = {0.2, 0.8};
        add_body(w, d, "capsule", &pill);
        dig_body bob = add_ball(w, l, 0.2, 1, (vec3){-30, 3, z}, (vec3){0, 0, i});
        dig_joint_def j = dig_joint_defaults();
        j.type = "ball";
        j.a = bob;
        j.at = (vec3){-31, 3, z};
        dig_joint joint;
        fail_unless(w, dig_joint_create(w, &j, &joint), "ball joint");
        bob = add_ball(w, l, 0.2, 1, (vec3){-40, 2, z}, vec3_zero());
        add_spring(w, bob, (vec3){-40, 2, z}, (vec3){-40, 4, z + 0.5}, 100);
    }
    return w;
}

TEST(threads_do_not_change_a_bit_of_traced_groups)
{
    dig_world *w = open_sites(1), *v = open_sites(4);
    int most = 0;
    for (int i = 0; i < 300; i++) {
        step(w, 1);
        step(v, 1);
        if (dig_world_checksum(w) != dig_world_checksum(v))
            fail_msg("after %d steps: one thread %llx, four %llx", i + 1, (unsigned long long)dig_world_checksum(w),
                     (unsigned long long)dig_world_checksum(v));
        most = most > dig_world_stats(w).traced ? most : dig_world_stats(w).traced;
        CHECK_INT(dig_world_stats(w).traced, dig_world_stats(v).traced);
    }
    CHECK(most >= 12);
    dig_world_close(w);
    dig_world_close(v);
}

/* ---- the same motion elsewhere ---- */

static dig_body open_slide(dig_world **w, vec3 at)
{
    *w = open_world(1.0 / 60, "study", true);
    add_floor(*w, look(0.3, 0));
    dig_body_def d = body_with(look(0.3, 0), vec3_add(at, (vec3){0, 0.25, 0}), quat_exp((vec3){0, 0.4, 0}));
    d.mass = 2;
    d.velocity = (vec3){4, 0, 1};
    d.spin = (vec3){0, 3, 0};
    dig_box_def box = {{1, 0.5, 0.7}};
    return add_body(*w, d, "box", &box);
}

TEST(a_sliding_spinning_box_does_the_same_a_kilometre_away)
{
    vec3 there = {1024, 0, -1024};
    dig_world *w, *v;
    dig_body a = open_slide(&w, vec3_zero()), b = open_slide(&v, there);
    real worst = 0;
    for (int i = 0; i < 60; i++) {
        step(w, 1);
        step(v, 1);
        CHECK_INT(dig_world_stats(w).traced, 1);
        CHECK_INT(dig_world_stats(v).traced, 1);
        dig_body_state s = state_of(w, a), t = state_of(v, b);
        worst = fmax(worst, vec3_distance(vec3_sub(t.position, there), s.position));
        worst = fmax(worst, vec3_distance(t.velocity, s.velocity));
        worst = fmax(worst, vec3_distance(quat_rotate(t.rotation, (vec3){1, 0, 0}), quat_rotate(s.rotation, (vec3){1, 0, 0})));
    }
    CHECK_NEAR(worst, 0, 1e-9);
    CHECK(vec3_length(state_of(w, a).position) > 1);
    dig_world_close(w);
    dig_world_close(v);
}

/* m  How far the farthest of a body's contact points is from its own nearest corner. */
static real off_corners(const dig_world *w, dig_body_state s, vec3 half)
{
    real worst = 0;
    for (int i = 0; i < w->contacts.count; i++)
        for (int k = 0; k < w->contacts.data[i].count; k++) {
            vec3 at = contact_point_seen(w, &w->contacts.data[i], k)->at.b, own = quat_unrotate(s.rotation, vec3_sub(at, s.position));
            worst = fmax(worst, vec3_distance(vec3_abs(own), half));
        }
    return worst;
}

/* It stops within a frame: its contacts are where it stopped, not where it was as the frame began. */
TEST(what_slides_to_rest_is_touched_where_it_lies)
{
    vec3 half = {0.2, 0.05, 0.2};
    for (real speed = 0.3; speed < 1; speed += 0.1) {
        dig_world *w = open_world(1.0 / 60, "play", true);
        add_floor(w, look(0.4, 0));
        dig_body b = add_box(w, look(0.4, 0), vec3_scale(2, half), 1, (vec3){0, half.y, 0}, quat_identity());
        fail_unless(w, dig_body_hit(w, b, (vec3){speed, 0, 0}, (vec3){0, half.y, 0}, false), "hit");
        for (int i = 0; i < 30; i++) {
            step(w, 1);
            CHECK_INT(w->contacts.count, 1);
            CHECK_INT(w->contacts.data[0].count, 4);
            CHECK_NEAR(off_corners(w, state_of(w, b), half), 0, 1e-12);
        }
        CHECK_NEAR(vec3_length(state_of(w, b).velocity), 0, 1e-12);
        dig_world_close(w);
    }
}

int main(void)
{
    RUN_TESTS(unit_test(the_accuracy_number_grows_as_the_tolerance_shrinks),
              unit_test(an_accuracy_number_has_its_power_of_ten),
              unit_test(a_plan_is_the_coarsest_that_keeps_the_tolerance),
              unit_test(a_plans_name_stands_for_its_tolerance),
              unit_test(the_local_error_falls_with_the_accuracy_within_its_bounds),
              unit_test(a_number_asked_for_a_dig_is_its_accuracy),
              unit_test(the_finer_accuracy_wins_when_digs_merge_and_stays_when_they_split),
              unit_test(accuracies_survive_save_and_load),
              unit_test(what_is_handed_on_goes_on_as_if_it_had_never_been_tried),
              unit_test(a_step_given_up_half_way_leaves_nothing_behind),
              unit_test(a_group_that_was_handed_on_is_not_tried_again_for_16_steps_then_32),
              unit_test(a_group_that_can_be_traced_again_is),
              unit_test(threads_do_not_change_a_bit_of_traced_groups),
              unit_test(a_sliding_spinning_box_does_the_same_a_kilometre_away),
              unit_test(what_slides_to_rest_is_touched_where_it_lies));
}
