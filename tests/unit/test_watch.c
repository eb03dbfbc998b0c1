/* tests/unit/test_watch.c - the world watches itself: each fault is put in on purpose and must be named, with body and time; what is
 * no fault must not be.
 */
#include "physics_fixture.h"

#include "effect/effect.h"
#include "world/world.h"

#include <stdlib.h>

#define STEP (1.0 / 60)

/* ---- faults and tools ---- */

/* Changes a velocity where no ledger sees it, at the end of chosen steps. */
typedef struct Demon { uint32_t slot; uint64_t step[2]; vec3 kick[2]; } Demon;

static bool demon_wanted(const World *w, const Group *g)
{
    (void)w;
    (void)g;
    return true;
}

static dig_status demon_settle(const EffectSlot *e, Group *g)
{
    const Demon *d = *(Demon *const *)e->world;
    for (int i = 0; i < g->moving_count; i++)
        for (int k = 0; k < 2; k++)
            if (g->member[i].slot == d->slot && g->world->steps + 1 == d->step[k])
                g->vel[i].v = vec3_add(g->vel[i].v, d->kick[k]);
    return DIG_OK;
}

static const EffectType demon_effect = {.name = "demon", .law = "dv = kick", .cite = "none", .wanted = demon_wanted,
                                        .run = {[STAGE_SETTLE] = demon_settle}};

static void invite(dig_world *w, const Demon *d)
{
    const Demon **own = malloc(sizeof *own);        /* the test goes on changing it */
    CHECK(own);
    *own = d;
    w->effects[w->effect_count++] = (EffectSlot){.type = &demon_effect, .name = "demon", .on = true, .world = own, .world_size = sizeof *own};
}

static void dismiss(dig_world *w)
{
    free(w->effects[--w->effect_count].world);
    w->effects[w->effect_count].world = NULL;
}

static void set_name(dig_world *w, dig_body b, const char *name)
{
    dig_text text = {""};
    snprintf(text.s, sizeof text.s, "%s", name);
    CHECK_INT(dig_body_set(w, b, "name", &text), DIG_OK);
}

static dig_joint join(dig_world *w, const char *type, dig_body a, vec3 at, const char *row, real value)
{
    const dig_schema *schema = dig_schema_find("joint", type);
    real params[48];
    CHECK(schema && schema->size <= sizeof params);
    dig_schema_defaults(schema, params);
    for (const dig_param *p = schema->rows; p->name; p++) {
        if (row && strcmp(p->name, row) == 0)
            memcpy((char *)params + p->offset, &value, sizeof value);
        if (strcmp(p->name, "at_b") == 0)
            memcpy((char *)params + p->offset, &at, sizeof at);
    }
    dig_joint_def d = dig_joint_defaults();
    d.type = type;
    d.a = a;
    d.at = at;
    d.axis = (vec3){0, 0, 1};
    d.data = params;
    dig_joint j = {0, 0};
    if (dig_joint_create(w, &d, &j) != DIG_OK)
        fail_msg("%s: %s", type, dig_error(w));
    return j;
}

static dig_body add_mover(dig_world *w, Look l, vec3 size, vec3 at, vec3 velocity)
{
    dig_body_def d = body_with(l, at, quat_identity());
    d.kinematic = true;
    d.velocity = velocity;
    dig_box_def s = {size};
    return add_body(w, d, "box", &s);
}

static dig_body add_wall(dig_world *w, vec3 size, vec3 at)
{
    dig_body_def d = body_with(look(0.5, 0), at, quat_identity());
    d.fixed = true;
    dig_box_def s = {size};
    return add_body(w, d, "box", &s);
}

static void quiet(const char *what, const dig_world *w)
{
    dig_warning n;
    if (dig_warnings(w, &n, 1) > 0)
        fail_msg("%s: %s at t = %g s of '%s': %g, bound %g", what, dig_rule_get(n.rule)->name, n.time, n.name.s, n.value, n.bound);
}

/* The first warning of a rule, which must be there. */
static dig_warning warned(const dig_world *w, dig_rule rule)
{
    dig_warning list[DIG_WARNINGS];
    int count = dig_warnings(w, list, (int)DIG_WARNINGS);
    for (int i = 0; i < count; i++)
        if (list[i].rule == rule)
            return list[i];
    fail_msg("no warning of rule '%s' among %d until t = %g s", dig_rule_get(rule)->name, count, dig_world_time(w));
    return list[0];
}

/* ---- energy ---- */

/* Two balls in free flight; the demon of the second adds its kicks at the end of steps. */
static dig_world *two_balls(Demon *d, dig_body *other, int threads)
{
    dig_world_def def = dig_world_defaults();
    def.gravity = vec3_zero();
    def.step = STEP;
    def.threads = threads;
    dig_world *w = open_with(def);
    add_ball(w, look(0, 1), 0.1, 2, vec3_zero(), (vec3){1, 0, 0});
    *other = add_ball(w, look(0, 1), 0.1, 2, (vec3){0, 5, 0}, (vec3){1, 0, 0});
    set_name(w, *other, "possessed");
    d->slot = other->slot;
    invite(w, d);
    return w;
}

TEST(energy_from_nowhere_is_named_with_body_and_time)
{
    Demon d = {.step = {10, 0}, .kick = {{2, 0, 0}}};
    for (int threads = 1; threads <= 4; threads += 3) {
        dig_body b;
        dig_world *w = two_balls(&d, &b, threads);
        step(w, 11);
        quiet("too early", w);              /* one step is no alarm, nor are two */
        step(w, 20);
        dig_warning n = warned(w, DIG_RULE_ENERGY);
        CHECK_INT(dig_warnings(w, NULL, 0), 1);
        CHECK_TEXT(n.name.s, "possessed");
        CHECK_INT(n.body.slot, b.slot);
        CHECK_INT(n.dig, dig_of(w, b).id);
        CHECK_NEAR(n.time, 12 * STEP, 1e-12);
        CHECK_NEAR(n.value, 0.5 * 2 * (3 * 3 - 1), 1e-9);      /* J: 1 m/s became 3 */
        CHECK(n.bound < 0.05 * n.value);
        CHECK_INT(dig_world_stats(w).warnings, 1);
        dismiss(w);
        dig_world_close(w);
    }
}

TEST(what_is_taken_back_at_once_is_no_alarm)
{
    Demon d = {.step = {10, 11}, .kick = {{2, 0, 0}, {-2, 0, 0}}};
    dig_body b;
    dig_world *w = two_balls(&d, &b, 1);
    step(w, 60);
    quiet("a bad frame", w);
    dismiss(w);
    dig_world_close(w);
}

TEST(the_smallest_steps_of_a_rise_add_up)
{
    Demon d = {.step = {0, 0}, .kick = {{0.001, 0, 0}}};
    dig_body b;
    dig_world *w = two_balls(&d, &b, 1);
    int at = 0;
    for (int i = 1; i <= 200 && at == 0; i++) {
        d.step[0] = (uint64_t)i;            /* in every step a thousandth of the speed */
        step(w, 1);
        at = dig_warnings(w, NULL, 0) > 0 ? i : 0;
    }
    /* K grows by a fiftieth of 2 K, which is 4 % of it or 2 % of the speed, in 20 steps or one more; the third step tells. */
    CHECK(at >= 20 && at <= 26);
    CHECK_TEXT(warned(w, DIG_RULE_ENERGY).name.s, "possessed");
    dismiss(w);
    dig_world_close(w);
}

TEST(booked_work_is_no_rise)
{
    for (int gravity = 0; gravity < 2; gravity++) {
        dig_world *w = open_world(STEP, NULL, gravity);
        add_floor(w, look(0.4, 0.5));
        dig_body pushed = add_box(w, look(0.4, 0.5), (vec3){1, 1, 1}, 3, (vec3){0, 0.5, 0}, quat_identity());
        dig_body hit = add_ball(w, look(0.4, 1), 0.2, 1, (vec3){5, 2, 0}, vec3_zero());
        dig_body sprung = add_ball(w, look(0.4, 1), 0.2, 1, (vec3){10, 3, 0}, vec3_zero());
        dig_body carried = add_box(w, look(0.8, 0), (vec3){0.5, 0.5, 0.5}, 1, (vec3){20, 0.55, 0}, quat_identity());
        dig_body lift = add_mover(w, look(0.8, 0), (vec3){2, 0.2, 2}, (vec3){20, 0.2, 0}, (vec3){0.5, 1, 0});
        dig_joint spring = join(w, "spring", sprung, (vec3){10, 4, 0}, "stiffness", 200);
        real length = 0.2;
        CHECK_INT(dig_joint_set(w, spring, &(dig_setting){"length", &length}, 1), DIG_OK);         /* a loaded spring is let go */
        step(w, 5);
        CHECK_INT(dig_body_push(w, pushed, (vec3){40, 10, 0}, (vec3){0, 0.9, 0.1}, true, 1), DIG_OK);
        CHECK_INT(dig_body_hit(w, hit, (vec3){3, 4, 1}, vec3_zero(), false), DIG_OK);
        step(w, 60);
        CHECK_INT(dig_body_set_velocity(w, lift, (vec3){0, -2, 0}, vec3_zero()), DIG_OK);
        step(w, 20);
        CHECK_INT(dig_body_set_velocity(w, lift, (vec3){0, 6, 0}, vec3_zero()), DIG_OK);    /* throws what it carries */
        step(w, 100);
        CHECK(state_of(w, pushed).work_received > 10 && state_of(w, carried).position.y > 3);
        quiet(gravity ? "work under gravity" : "work", w);
        dig_world_close(w);
    }
}

/* ---- overlap ---- */

/* A ball of 1 m between walls 0.8 m apart. */
TEST(what_is_pinned_between_walls_is_named_before_it_sleeps)
{
    dig_world *w = open_world(STEP, NULL, true);
    add_wall(w, (vec3){1, 4, 4}, (vec3){-0.9, 0, 0});
    add_wall(w, (vec3){1, 4, 4}, (vec3){0.9, 0, 0});
    dig_body b = add_ball(w, look(0.5, 0), 0.5, 1, vec3_zero(), vec3_zero());
    set_name(w, b, "pinned");
    step(w, 20);
    quiet("too early", w);
    step(w, 60);
    dig_warning n = warned(w, DIG_RULE_OVERLAP);
    CHECK_TEXT(n.name.s, "pinned");
    CHECK_NEAR(n.time, 0.4, 0.15);
    CHECK(n.value > 0.05 && n.value < 0.21);            /* m: 0.1 on each side, or all on one */
    CHECK_TEXT(n.why, "with body #0");
    dig_world_close(w);
}

/* The middle of a room's floor was taken for the middle of the room. */
TEST(what_is_put_beyond_a_wall_is_told_so)
{
    dig_world *w = open_world(STEP, NULL, true);
    dig_room_def r = {.size = {4, 20, 4}, .at = {0, 10, 0}, .friction = 0.5};
    CHECK_INT(dig_room_set(w, &r), DIG_OK);
    add_box(w, look(0.5, 0), (vec3){1, 1, 1}, 1, (vec3){0, 0.5, 0}, quat_identity());
    step(w, 40);
    CHECK_TEXT(warned(w, DIG_RULE_OVERLAP).why, "its middle is beyond wall -y of the room");
    dig_world_close(w);
    w = open_world(STEP, NULL, true);
    add_floor(w, look(0.5, 0));
    add_box(w, look(0.5, 0), (vec3){1, 1, 1}, 1, (vec3){0, -5, 0}, quat_identity());
    step(w, 40);
    CHECK_TEXT(warned(w, DIG_RULE_OVERLAP).why, "its middle is beyond body #0");
    dig_world_close(w);
}

TEST(an_overlap_that_heals_is_no_alarm)
{
    dig_world *w = open_world(STEP, NULL, true);
    add_floor(w, look(0.5, 0));
    dig_body b = add_box(w, look(0.5, 0), (vec3){1, 1, 1}, 1, (vec3){0, 0.3, 0}, quat_identity());
    add_box(w, look(0.5, 0), (vec3){1, 1, 1}, 1, (vec3){0, 1.2, 0}, quat_identity());
    step(w, 120);
    CHECK_NEAR(state_of(w, b).position.y, 0.5, 1e-3);
    quiet("healing", w);
    dig_world_close(w);
}

/* ---- joints and the solver ---- */

/* Rods of 0.5 m to two points that are 2 m apart. */
TEST(joints_that_contradict_each_other_are_named)
{
    dig_world *w = open_world(STEP, NULL, true);
    dig_body b = add_ball(w, look(0, 0), 0.2, 1, vec3_zero(), vec3_zero());
    set_name(w, b, "torn");
    join(w, "distance", b, (vec3){-1, 0, 0}, "length", 0.5);
    join(w, "distance", b, (vec3){1, 0, 0}, "length", 0.5);
    step(w, 60);
    dig_warning n = warned(w, DIG_RULE_JOINT);
    CHECK_TEXT(n.name.s, "torn");
    CHECK_TEXT(n.why, "distance");
    CHECK_NEAR(n.time, 0.4, 0.15);
    CHECK(n.value > 0.3);                               /* m: at least 0.5 at one of them */
    dig_world_close(w);
}

/* Two movers that come nearer to each other than the ball between them is wide: no velocity of it fits both. */
TEST(a_residual_that_does_not_fall_is_named)
{
    dig_world *w = open_world(STEP, NULL, true);
    add_floor(w, look(0, 0));
    add_mover(w, look(0, 0), (vec3){1, 4, 4}, (vec3){-1.1, 2, 0}, (vec3){0.2, 0, 0});
    add_mover(w, look(0, 0), (vec3){1, 4, 4}, (vec3){1.1, 2, 0}, (vec3){-0.2, 0, 0});
    dig_body b = add_box(w, look(0, 0), (vec3){1, 1, 1}, 1, (vec3){0, 0.5, 0}, quat_identity());
    set_name(w, b, "crushed");
    step(w, 28);                            /* they touch after 0.5 s */
    quiet("too early", w);
    step(w, 62);
    dig_warning n = warned(w, DIG_RULE_RESIDUAL);
    CHECK_TEXT(n.name.s, "crushed");
    CHECK_NEAR(n.time, 0.9, 0.15);
    CHECK(n.value > n.bound && n.value < 1);            /* m/s: of 0.4 */
    CHECK_TEXT(warned(w, DIG_RULE_OVERLAP).name.s, "crushed");
    dig_world_close(w);
}

/* ---- budget ---- */

/* A box on the floor and a spring that has it oscillate at 5000 turns a second and more: too much to be followed. */
static dig_world *stiff_spring(const char *plan, real stiffness)
{
    dig_world_def def = dig_world_defaults();
    def.sleeping = false;
    snprintf(def.accuracy.s, sizeof def.accuracy.s, "%s", plan);
    dig_world *w = open_with(def);
    add_floor(w, look(0.5, 0));
    dig_body b = add_box(w, look(0.5, 0), (vec3){1, 1, 1}, 1, (vec3){0, 0.5, 0}, quat_identity());
    set_name(w, b, "shaken");
    join(w, "spring", b, (vec3){1, 3, 0.2}, "stiffness", stiffness);
    CHECK_INT(dig_body_hit(w, b, (vec3){0.5, 0, 0.2}, vec3_zero(), false), DIG_OK);
    return w;
}

TEST(a_dig_over_the_budget_of_what_was_asked_for_is_named)
{
    dig_world *w = stiff_spring("study", 1e11);
    for (int i = 0; i < 200 && dig_warnings(w, NULL, 0) == 0; i++)
        step(w, 1);
    dig_warning n = warned(w, DIG_RULE_BUDGET);
    CHECK_NEAR(n.time, (1 + 2 + 3 + 5 + 9 + 17 + 33) * STEP, 1e-9);     /* the first past a second, after pauses of 1, 2, 4, ... 32 steps */
    CHECK_TEXT(n.name.s, "shaken");
    CHECK_TEXT(n.why, dig_world_stats(w).gave_up_why);
    CHECK_INT(n.dig, dig_of(w, n.body).id);
    dig_world_close(w);
}

TEST(at_the_default_sweeping_is_no_alarm)
{
    dig_world *w = stiff_spring("play", 1e9);
    step(w, 300);
    CHECK(dig_world_stats(w).gave_up >= 4);
    quiet("a stiff spring", w);
    dig_world_close(w);
}

/* ---- the record ---- */

TEST(a_snapshot_takes_the_record_along)
{
    Demon d = {.step = {10, 0}, .kick = {{2, 0, 0}}};
    dig_body b;
    dig_world *w = two_balls(&d, &b, 1);
    dig_snapshot *before, *after;
    step(w, 5);
    CHECK_INT(dig_world_snapshot(w, &before), DIG_OK);
    step(w, 30);
    CHECK_INT(dig_world_snapshot(w, &after), DIG_OK);
    uint64_t sum = dig_world_checksum(w);
    CHECK_INT(dig_world_restore(w, before), DIG_OK);
    quiet("restored", w);
    step(w, 30);
    CHECK_INT(dig_warnings(w, NULL, 0), 1);
    CHECK(dig_world_checksum(w) == sum);
    CHECK_INT(dig_world_restore(w, after), DIG_OK);
    CHECK_TEXT(warned(w, DIG_RULE_ENERGY).name.s, "possessed");
    dig_snapshot_free(before);
    dig_snapshot_free(after);
    dismiss(w);
    dig_world_close(w);
}

TEST(a_body_that_breaks_a_rule_again_is_counted_not_listed_again)
{
    Demon d = {.step = {10, 20}, .kick = {{2, 0, 0}, {4, 0, 0}}};
    dig_body b;
    dig_world *w = two_balls(&d, &b, 1);
    step(w, 40);
    CHECK_INT(dig_warnings(w, NULL, 0), 1);
    CHECK_INT(warned(w, DIG_RULE_ENERGY).times, 2);
    CHECK_NEAR(warned(w, DIG_RULE_ENERGY).value, 0.5 * 2 * (7 * 7 - 3 * 3), 1e-9);
    CHECK_INT(dig_world_stats(w).warnings, 2);
    CHECK(dig_rule_get(DIG_RULES) == NULL);
    dismiss(w);
    dig_world_close(w);
}

int main(void)
{
    RUN_TESTS(unit_test(energy_from_nowhere_is_named_with_body_and_time), unit_test(what_is_taken_back_at_once_is_no_alarm),
              unit_test(the_smallest_steps_of_a_rise_add_up), unit_test(booked_work_is_no_rise),
              unit_test(what_is_pinned_between_walls_is_named_before_it_sleeps), unit_test(what_is_put_beyond_a_wall_is_told_so),
              unit_test(an_overlap_that_heals_is_no_alarm),
              unit_test(joints_that_contradict_each_other_are_named), unit_test(a_residual_that_does_not_fall_is_named),
              unit_test(a_dig_over_the_budget_of_what_was_asked_for_is_named), unit_test(at_the_default_sweeping_is_no_alarm),
              unit_test(a_snapshot_takes_the_record_along), unit_test(a_body_that_breaks_a_rule_again_is_counted_not_listed_again));
}
