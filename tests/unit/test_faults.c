/* tests/unit/test_faults.c - what is refused leaves the world as it was: non-finite numbers, bad arguments, dead and foreign
 * handles. */
#include "physics_fixture.h"
#include "world/world.h"

/* A world in motion with something of everything. */
typedef struct Scene { dig_world *w; dig_body floor, ball, box, mover; dig_joint joint; } Scene;

static Scene open_scene(void)
{
    Scene s = {.w = open_world(1.0 / 60, NULL, true)};
    s.floor = add_floor(s.w, look(0.5, 0.2));
    s.ball = add_ball(s.w, look(0.5, 0.2), 0.3, 2, (vec3){0, 0.8, 0}, (vec3){1, 0, 0});
    s.box = add_box(s.w, look(0.5, 0.2), (vec3){1, 1, 1}, 5, (vec3){3, 0.5, 0}, quat_identity());
    dig_body_def d = body_with(look(0.5, 0.2), (vec3){-4, 1, 0}, quat_identity());
    d.kinematic = true;
    d.velocity = (vec3){0.1, 0, 0};
    d.mass = 20;
    s.mover = add_body(s.w, d, "box", &(dig_box_def){{1, 1, 1}});
    dig_joint_def j = dig_joint_defaults();
    j.type = "ball";
    j.a = s.box;
    j.at = (vec3){3, 1.5, 0};
    const dig_schema *schema = dig_schema_find("joint", "ball");
    char data[1024];
    CHECK(schema && schema->size <= sizeof data);
    dig_schema_defaults(schema, data);
    j.data = data;
    if (dig_joint_create(s.w, &j, &s.joint) != DIG_OK)
        fail_msg("joint: %s", dig_error(s.w));
    step(s.w, 10);
    return s;
}

/* ---- B24, P07: non-finite numbers ---------------------------------------------------------- */

/* A step that meets NaN fails, says where it came from, and changes nothing. */
static void poison(const char *what, const char *effect, int case_number)
{
    Scene s = open_scene();
    Body *b = &s.w->bodies.data[s.ball.slot];
    dig_body_set(s.w, s.ball, "name", &(dig_text){"red ball"});
    Body clean = *b;
    if (case_number == 0)
        b->v.x = NAN;
    else if (case_number == 1)
        b->w.z = INFINITY;
    else if (case_number == 2) {
        CHECK(dig_body_push(s.w, s.ball, (vec3){1, 0, 0}, vec3_zero(), false, 1) == DIG_OK);
        s.w->pushes.data[s.w->pushes.count - 1].force.y = NAN;
    } else if (case_number == 3)
        b->gravity_scale = NAN;
    real others = state_of(s.w, s.box).position.y;
    uint64_t before = dig_world_checksum(s.w), steps = dig_world_steps(s.w), rejected = dig_world_stats(s.w).rejected;
    real time = dig_world_time(s.w);
    for (int i = 0; i < 2; i++) {           /* and again the same */
        dig_status status = dig_world_step(s.w);
        if (status != DIG_E_FINITE)
            fail_msg("%s: step returned %s", what, dig_status_name(status));
        CHECK(dig_world_checksum(s.w) == before);
        CHECK_INT(dig_world_steps(s.w), steps);
        CHECK_NEAR(dig_world_time(s.w), time, 0);
        CHECK_INT(dig_world_stats(s.w).rejected, rejected + 1 + (uint64_t)i);
        CHECK_NEAR(state_of(s.w, s.box).position.y, others, 0);
        const char *why = dig_error(s.w);
        char at[32];
        snprintf(at, sizeof at, "t = %g s", time);
        if (!strstr(why, "red ball") || !strstr(why, effect) || !strstr(why, at))
            fail_msg("%s: the message does not name body, '%s' and '%s': %s", what, effect, at, why);
    }
    /* repaired, it goes on */
    clean.x = b->x;
    b->v = clean.v;
    b->w = clean.w;
    b->gravity_scale = clean.gravity_scale;
    if (case_number == 2)
        s.w->pushes.data[s.w->pushes.count - 1].force.y = 0;
    step(s.w, 5);
    check_world(s.w);
    dig_world_close(s.w);
}

TEST(non_finite_numbers_fail_the_step_and_name_the_culprit)
{
    poison("NaN velocity", "state", 0);
    poison("infinite spin", "state", 1);
    poison("NaN push", "push", 2);
    poison("NaN gravity scale", "gravity", 3);
}

/* B24. One poisoned body of a hundred: the other ninety-nine keep every bit. */
TEST(one_poisoned_body_of_a_hundred_leaves_the_others_untouched)
{
    dig_world *w = open_world(1.0 / 60, NULL, true);
    add_floor(w, look(0.5, 0.3));
    dig_body b[100];
    for (int i = 0; i < 100; i++)
        b[i] = add_ball(w, look(0.5, 0.3), 0.2, 1, (vec3){i % 10, 0.5 + 0.01 * i, i / 10}, vec3_zero());
    step(w, 5);
    vec3 x[100];
    for (int i = 0; i < 100; i++)
        x[i] = state_of(w, b[i]).position;
    CHECK(dig_body_push(w, b[37], (vec3){1, 0, 0}, vec3_zero(), false, 0) == DIG_OK);
    w->pushes.data[0].force.x = NAN;
    CHECK(dig_world_step(w) == DIG_E_FINITE);
    for (int i = 0; i < 100; i++)
        CHECK(vec3_equal(state_of(w, b[i]).position, x[i]));
    dig_world_close(w);
}

/* A crowd that is landing, with events in each step. */
static dig_world *open_crowd(dig_body *one)
{
    dig_world *w = open_world(1.0 / 60, "play", true);
    add_floor(w, look(0.5, 0));
    for (int i = 0; i < 640; i++)
        *one = add_ball(w, look(0.5, 0), 0.2, 1, (vec3){0.41 * (i % 8), 0.3 + 0.45 * (i / 64) + 0.07 * (i % 13), 0.41 * (i / 8 % 8)}, vec3_zero());
    step(w, 20);
    return w;
}

/* Events are those of the last step: a step that fails has none, and what it wrote where they had been is not in those of the next one. */
TEST(a_step_that_fails_has_no_events_and_the_next_one_has_its_own)
{
    dig_body one, other;
    dig_world *w = open_crowd(&one), *twin = open_crowd(&other);
    const dig_event *e, *expected;
    CHECK(dig_events(w, &e) > 50);
    CHECK(dig_world_inject(w, one) == DIG_OK);
    CHECK(dig_world_step(w) == DIG_E_FINITE);
    CHECK_INT(dig_events(w, &e), 0);
    for (int i = 0; i < 10; i++) {
        step(w, 1);
        step(twin, 1);
        int count = dig_events(twin, &expected);
        CHECK(count > 0);
        CHECK_INT(dig_events(w, &e), count);
        for (int k = 0; k < count; k++)
            CHECK(e[k].kind == expected[k].kind && e[k].a.slot == expected[k].a.slot && e[k].b.slot == expected[k].b.slot &&
                  e[k].time == expected[k].time && e[k].speed == expected[k].speed && e[k].impulse == expected[k].impulse);
        CHECK(dig_world_checksum(w) == dig_world_checksum(twin));
    }
    CHECK(w->events_written > 64);          /* enough for rows to lie there */
    dig_world_close(w);
    dig_world_close(twin);
}

/* ---- A13: who spoils a step can be set aside ---------------------------------------------- */

enum { PILE = 40 };

/* Balls that fall on each other, the seventh joined to its neighbours and to the world; after 60 steps it is given NaN, or disabled. */
static dig_world *run_pile(const char *accuracy, bool inject, dig_body out[PILE])
{
    dig_world *w = open_world(1.0 / 60, accuracy, true);
    add_floor(w, look(0.5, 0.3));
    for (int i = 0; i < PILE; i++)
        out[i] = add_ball(w, look(0.5, 0.3), 0.2, 1, (vec3){0.41 * (i % 5), 0.3 + 0.45 * (i / 5), 0.01 * i}, vec3_zero());
    for (int k = 0; k < 2; k++) {
        dig_joint_def j = dig_joint_defaults();
        dig_joint id;
        const dig_schema *schema = dig_schema_find("joint", "ball");
        char data[1024];
        dig_schema_defaults(schema, data);
        j.type = "ball";
        j.data = data;
        j.a = out[7];
        j.b = k == 0 ? out[8] : (dig_body){0, 0};
        j.at = state_of(w, out[7]).position;
        CHECK(dig_joint_create(w, &j, &id) == DIG_OK);
    }
    step(w, 60);
    if (inject) {
        uint64_t rejected = dig_world_stats(w).rejected;
        CHECK(dig_world_inject(w, out[7]) == DIG_OK);
        CHECK_INT(dig_world_step(w), DIG_E_FINITE);
        CHECK_INT(dig_world_stats(w).rejected, rejected + 1);
        CHECK_INT(dig_world_culprit(w).slot, out[7].slot);
        CHECK_INT(dig_world_culprit(w).gen, out[7].gen);
    }
    CHECK(dig_body_disable(w, out[7]) == DIG_OK);
    CHECK(dig_joints(w, NULL, 0) == 0);
    check_world(w);
    step(w, 60);
    check_world(w);
    CHECK_INT(dig_world_culprit(w).gen, 0);
    return w;
}

TEST(what_is_set_aside_leaves_the_others_what_they_would_have_done)
{
    const char *const levels[] = {"sketch", "play", "study"};
    for (int k = 0; k < 3; k++) {
        dig_body a[PILE], b[PILE];
        dig_world *injected = run_pile(levels[k], true, a), *disabled = run_pile(levels[k], false, b);
        for (int i = 0; i < PILE; i++) {
            dig_body_state p = state_of(injected, a[i]), q = state_of(disabled, b[i]);
            if (!vec3_equal(p.position, q.position) || !vec3_equal(p.velocity, q.velocity) || !vec3_equal(p.spin, q.spin))
                fail_msg("%s: body %d differs", levels[k], i);
        }
        CHECK(dig_world_checksum(injected) == dig_world_checksum(disabled));
        dig_body_state s = state_of(injected, a[7]);
        CHECK(s.kind == DIG_STATIC && s.mode == DIG_FIXED && vec3_length2(s.velocity) + vec3_length2(s.spin) == 0);
        dig_world_close(injected);
        dig_world_close(disabled);
    }
}

static real mass_of(dig_world *w, dig_body b)
{
    real mass;
    CHECK(dig_body_param(w, b, "mass", &mass) == DIG_OK);
    return mass;
}

/* A floor, a mover and one that is disabled already may be, and keep the mass they were given; one that is gone may not. What rested on it falls. */
TEST(anything_can_be_disabled)
{
    Scene s = open_scene();
    step(s.w, 200);
    real before = state_of(s.w, s.ball).position.y;
    const dig_event *e;
    CHECK(dig_body_disable(s.w, s.mover) == DIG_OK);
    CHECK(dig_body_disable(s.w, s.mover) == DIG_OK);
    CHECK_NEAR(mass_of(s.w, s.mover), 20, 0);
    CHECK(dig_body_disable(s.w, s.floor) == DIG_OK);
    step(s.w, 1);
    int count = dig_events(s.w, &e), disabled = 0;
    for (int i = 0; i < count; i++)
        disabled += e[i].kind == DIG_EVENT_DISABLED;
    CHECK_INT(disabled, 3);
    step(s.w, 60);
    CHECK(state_of(s.w, s.ball).position.y < before - 1);
    CHECK_NEAR(state_of(s.w, s.mover).velocity.x, 0, 0);
    check_world(s.w);
    CHECK(dig_body_remove(s.w, s.mover) == DIG_OK);
    CHECK(dig_body_disable(s.w, s.mover) == DIG_E_DEAD);
    CHECK(dig_world_inject(s.w, s.mover) == DIG_E_DEAD);
    CHECK(dig_world_inject(s.w, s.floor) == DIG_E_KIND);
    dig_world_close(s.w);
}

/* ---- bad arguments ---------------------------------------------------------------------------- */

/* The call must be refused with this status, with a sentence, and without any change. */
#define REFUSED(call, want)                                                                              \
    do {                                                                                                 \
        uint64_t sum_ = dig_world_checksum(w);                                                           \
        int64_t bodies_ = dig_world_stats(w).bodies, joints_ = dig_world_stats(w).joints;                \
        dig_status got_ = (call);                                                                        \
        if (got_ != (want))                                                                              \
            fail_msg("%s:%d: %s gives %s, want %s", __FILE__, __LINE__, #call, dig_status_name(got_), dig_status_name(want)); \
        CHECK(dig_error(w)[0] != '\0');                                                                  \
        if (dig_world_checksum(w) != sum_ || dig_world_stats(w).bodies != bodies_ || dig_world_stats(w).joints != joints_) \
            fail_msg("%s:%d: %s was refused but changed the world", __FILE__, __LINE__, #call);          \
    } while (0)

static dig_status create(dig_world *w, dig_body_def d, const char *type, const void *data)
{
    dig_shape_def s;
    memset(&s, 0, sizeof s);
    s.type = type;
    s.data = data;
    s.colour.x = -1;
    d.shapes = &s;
    d.shape_count = 1;
    dig_body b;
    return dig_body_create(w, &d, &b);
}

static const real bad_numbers[] = {NAN, INFINITY, -INFINITY};

/* B24. */
TEST(bodies_with_bad_numbers_are_refused)
{
    Scene s = open_scene();
    dig_world *w = s.w;
    const dig_sphere_def ball = {0.5};
    dig_body_def good = body_with(look(0.5, 0), (vec3){0, 9, 0}, quat_identity());
    for (int i = 0; i < 3; i++) {
        real x = bad_numbers[i];
        dig_body_def d = good;
        d.at.y = x;
        REFUSED(create(w, d, "sphere", &ball), DIG_E_ARG);
        d = good;
        d.velocity.z = x;
        REFUSED(create(w, d, "sphere", &ball), DIG_E_ARG);
        d = good;
        d.spin.x = x;
        REFUSED(create(w, d, "sphere", &ball), DIG_E_ARG);
        d = good;
        d.rotation.w = x;
        REFUSED(create(w, d, "sphere", &ball), DIG_E_ARG);
        d = good;
        d.gravity_scale = x;
        REFUSED(create(w, d, "sphere", &ball), DIG_E_ARG);
        if (!isnan(x)) {
            d = good;
            d.mass = x;
            REFUSED(create(w, d, "sphere", &ball), DIG_E_ARG);
            d = good;
            d.restitution = x;
            REFUSED(create(w, d, "sphere", &ball), DIG_E_ARG);
        }
        REFUSED(create(w, good, "sphere", &(dig_sphere_def){x}), DIG_E_FINITE);
        REFUSED(create(w, good, "box", &(dig_box_def){{1, x, 1}}), DIG_E_FINITE);
        REFUSED(create(w, good, "capsule", &(dig_capsule_def){0.1, x}), DIG_E_FINITE);
        REFUSED(create(w, good, "cylinder", &(dig_cylinder_def){x, 1}), DIG_E_FINITE);
        REFUSED(create(w, good, "cone", &(dig_cone_def){x, 1}), DIG_E_FINITE);
    }
    dig_body_def d = good;
    d.mass = 0;
    REFUSED(create(w, d, "sphere", &ball), DIG_E_ARG);
    d.mass = -1;
    REFUSED(create(w, d, "sphere", &ball), DIG_E_ARG);
    d = good;
    d.restitution = -1;
    REFUSED(create(w, d, "sphere", &ball), DIG_E_ARG);
    d.restitution = 2;
    REFUSED(create(w, d, "sphere", &ball), DIG_E_ARG);
    d = good;
    d.friction = -1;
    REFUSED(create(w, d, "sphere", &ball), DIG_E_ARG);
    REFUSED(create(w, good, "sphere", &(dig_sphere_def){0}), DIG_E_ARG);
    REFUSED(create(w, good, "sphere", &(dig_sphere_def){-1}), DIG_E_ARG);
    REFUSED(create(w, good, "box", &(dig_box_def){{1, 0, 1}}), DIG_E_ARG);
    REFUSED(create(w, good, "torus", &ball), DIG_E_ARG);
    d = good;
    snprintf(d.material.s, sizeof d.material.s, "unobtainium");
    REFUSED(create(w, d, "sphere", &ball), DIG_E_ARG);
    d = good;
    dig_body out;
    d.shape_count = 0;
    d.shapes = NULL;
    REFUSED(dig_body_create(w, &d, &out), DIG_E_ARG);
    vec3 flat[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    REFUSED(create(w, good, "hull", &(dig_hull_def){{flat, 4}}), DIG_E_ARG);
    REFUSED(create(w, good, "hull", &(dig_hull_def){{flat, 0}}), DIG_E_ARG);
    step(w, 5);
    check_world(w);
    dig_world_close(w);
}

TEST(calls_with_bad_numbers_are_refused)
{
    Scene s = open_scene();
    dig_world *w = s.w;
    vec3 zero = vec3_zero();
    for (int i = 0; i < 3; i++) {
        real x = bad_numbers[i];
        vec3 bad = {0, x, 0};
        quat bad_turn = {0, 0, x, 1};
        REFUSED(dig_world_set_gravity(w, bad), DIG_E_ARG);
        REFUSED(dig_world_set_accuracy(w, NULL, x), DIG_E_ARG);
        REFUSED(dig_body_push(w, s.ball, bad, zero, false, 1), DIG_E_ARG);
        REFUSED(dig_body_push(w, s.ball, (vec3){1, 0, 0}, bad, true, 1), DIG_E_ARG);
        REFUSED(dig_body_twist(w, s.ball, bad, 1), DIG_E_ARG);
        REFUSED(dig_body_hit(w, s.ball, bad, zero, false), DIG_E_ARG);
        REFUSED(dig_body_hit(w, s.ball, (vec3){1, 0, 0}, bad, true), DIG_E_ARG);
        REFUSED(dig_body_teleport(w, s.ball, &bad, NULL, NULL, NULL), DIG_E_ARG);
        REFUSED(dig_body_teleport(w, s.ball, NULL, &bad_turn, NULL, NULL), DIG_E_ARG);
        REFUSED(dig_body_teleport(w, s.ball, NULL, NULL, &bad, NULL), DIG_E_ARG);
        REFUSED(dig_body_teleport(w, s.ball, NULL, NULL, NULL, &bad), DIG_E_ARG);
        REFUSED(dig_body_move_to(w, s.mover, bad, NULL, 1), DIG_E_ARG);
        REFUSED(dig_body_move_to(w, s.mover, zero, &bad_turn, 1), DIG_E_ARG);
        REFUSED(dig_body_set_velocity(w, s.mover, bad, zero), DIG_E_ARG);
        REFUSED(dig_body_set_velocity(w, s.mover, zero, bad), DIG_E_ARG);
        REFUSED(dig_body_set(w, s.ball, "mass", &x), DIG_E_ARG);
        REFUSED(dig_body_set(w, s.ball, "gravity_scale", &x), DIG_E_ARG);
        dig_room_def room = {.size = {4, 4, 4}, .at = bad, .friction = 0.5};
        REFUSED(dig_room_set(w, &room), DIG_E_ARG);
        room = (dig_room_def){.size = bad, .friction = 0.5};
        REFUSED(dig_room_set(w, &room), DIG_E_ARG);
        REFUSED(dig_message_send(w, s.ball, s.box, "hello", (real[4]){x, 0, 0, 0}), DIG_E_ARG);
    }
    REFUSED(dig_body_push(w, s.ball, (vec3){1, 0, 0}, zero, false, NAN), DIG_E_ARG);
    REFUSED(dig_body_twist(w, s.ball, (vec3){1, 0, 0}, NAN), DIG_E_ARG);
    REFUSED(dig_body_move_to(w, s.mover, zero, NULL, NAN), DIG_E_ARG);
    REFUSED(dig_body_move_to(w, s.mover, zero, NULL, -1), DIG_E_ARG);
    real mass = 0;
    REFUSED(dig_body_set(w, s.ball, "mass", &mass), DIG_E_ARG);
    REFUSED(dig_body_set(w, s.ball, "colour of the sky", &mass), DIG_E_ARG);
    REFUSED(dig_body_set(w, s.ball, "at", &zero), DIG_E_ARG);
    REFUSED(dig_world_set_accuracy(w, "sloppy", NAN), DIG_E_ARG);
    REFUSED(dig_world_set_accuracy(w, NULL, 0), DIG_E_ARG);
    REFUSED(dig_effect_set(w, "magic", true), DIG_E_ARG);
    REFUSED(dig_room_open(w, "up", true), DIG_E_ARG);
    REFUSED(dig_message_send(w, s.ball, s.box, "", (real[4]){0}), DIG_E_ARG);
    dig_material_def m;
    CHECK(dig_material_get(w, "steel", &m) == DIG_OK);
    m.density = -1;
    REFUSED(dig_material_add(w, "antimatter", &m), DIG_E_ARG);
    m.density = NAN;
    REFUSED(dig_material_add(w, "antimatter", &m), DIG_E_ARG);
    REFUSED(dig_material_get(w, "antimatter", &m), DIG_E_ARG);
    dig_pair_def p = {.a = {"steel"}, .b = {"antimatter"}, .friction = 0.1, .friction_dynamic = NAN, .rolling_friction = NAN,
                      .restitution = NAN};
    REFUSED(dig_material_pair(w, &p), DIG_E_ARG);
    step(w, 5);
    check_world(w);
    dig_world_close(w);
}

TEST(bodies_of_the_wrong_kind_are_refused)
{
    Scene s = open_scene();
    dig_world *w = s.w;
    vec3 one = {1, 0, 0};
    real mass = 2;
    REFUSED(dig_body_push(w, s.floor, one, one, false, 1), DIG_E_KIND);
    REFUSED(dig_body_push(w, s.mover, one, one, false, 1), DIG_E_KIND);
    REFUSED(dig_body_twist(w, s.floor, one, 1), DIG_E_KIND);
    REFUSED(dig_body_hit(w, s.mover, one, one, false), DIG_E_KIND);
    REFUSED(dig_body_move_to(w, s.ball, one, NULL, 1), DIG_E_KIND);
    REFUSED(dig_body_set_velocity(w, s.ball, one, one), DIG_E_KIND);
    REFUSED(dig_body_set(w, s.floor, "mass", &mass), DIG_E_KIND);
    dig_world_close(w);
}

TEST(joints_with_bad_arguments_are_refused)
{
    Scene s = open_scene();
    dig_world *w = s.w;
    const dig_schema *schema = dig_schema_find("joint", "hinge");
    char data[2048];
    CHECK(schema && schema->size <= sizeof data);
    dig_schema_defaults(schema, data);
    dig_joint_def good = dig_joint_defaults();
    good.type = "hinge";
    good.a = s.ball;
    good.b = s.box;
    good.at = (vec3){1, 1, 0};
    good.axis = (vec3){0, 0, 1};
    good.data = data;
    dig_joint out;
    dig_joint_def d = good;
    d.type = "glue";
    REFUSED(dig_joint_create(w, &d, &out), DIG_E_ARG);
    d = good;
    d.b = d.a;
    REFUSED(dig_joint_create(w, &d, &out), DIG_E_ARG);
    d = good;
    d.axis = vec3_zero();
    REFUSED(dig_joint_create(w, &d, &out), DIG_E_ARG);
    d = good;
    d.at.y = INFINITY;
    REFUSED(dig_joint_create(w, &d, &out), DIG_E_ARG);
    d = good;
    d.breaks_at = NAN;
    REFUSED(dig_joint_create(w, &d, &out), DIG_E_ARG);
    d.breaks_at = -1;
    REFUSED(dig_joint_create(w, &d, &out), DIG_E_ARG);
    d = good;
    d.a = s.floor;
    d.b = (dig_body){0, 0};
    REFUSED(dig_joint_create(w, &d, &out), DIG_E_ARG);
    real x = NAN;
    REFUSED(dig_joint_set(w, s.joint, &(dig_setting){"no such row", &x}, 1), DIG_E_ARG);
    CHECK(dig_joint_create(w, &good, &out) == DIG_OK);
    REFUSED(dig_joint_set(w, out, &(dig_setting){"friction", &x}, 1), DIG_E_ARG);
    step(w, 5);
    check_world(w);
    dig_world_close(w);
}

TEST(worlds_with_bad_numbers_do_not_open)
{
    char why[256];
    dig_world *w;
    const real steps[] = {0, -1, 1, NAN, INFINITY};
    for (int i = 0; i < 5; i++) {
        dig_world_def d = dig_world_defaults();
        d.step = steps[i];
        why[0] = '\0';
        CHECK(dig_world_open(&d, &w, why, sizeof why) == DIG_E_ARG);
        CHECK(w == NULL && why[0]);
    }
    dig_world_def d = dig_world_defaults();
    d.gravity.x = NAN;
    CHECK(dig_world_open(&d, &w, why, sizeof why) == DIG_E_ARG);
    d = dig_world_defaults();
    d.threads = 0;
    CHECK(dig_world_open(&d, &w, why, sizeof why) == DIG_E_ARG);
    d = dig_world_defaults();
    snprintf(d.plane.s, sizeof d.plane.s, "zz");
    CHECK(dig_world_open(&d, &w, why, sizeof why) == DIG_E_ARG);
    d = dig_world_defaults();
    snprintf(d.accuracy.s, sizeof d.accuracy.s, "perfect");
    CHECK(dig_world_open(&d, &w, why, sizeof why) == DIG_E_ARG);
    d = dig_world_defaults();
    snprintf(d.friction_law.s, sizeof d.friction_law.s, "none");
    CHECK(dig_world_open(&d, &w, why, sizeof why) == DIG_E_ARG);
}

/* ---- handles ------------------------------------------------------------------------------------- */

/* Every call that takes a body, with a handle that is not of a living body of this world. */
static void refuse_body(dig_world *w, dig_body b, dig_body good, dig_status want)
{
    vec3 one = {1, 0, 0};
    real x = 1;
    dig_body_state state;
    dig_body_debug debug;
    dig_link links[4];
    dig_body list[4];
    REFUSED(dig_body_get(w, b, &state), want);
    REFUSED(dig_body_inspect(w, b, &debug), want);
    REFUSED(dig_body_remove(w, b), want);
    REFUSED(dig_body_push(w, b, one, one, false, 1), want);
    REFUSED(dig_body_twist(w, b, one, 1), want);
    REFUSED(dig_body_hit(w, b, one, one, false), want);
    REFUSED(dig_body_teleport(w, b, &one, NULL, NULL, NULL), want);
    REFUSED(dig_body_move_to(w, b, one, NULL, 1), want);
    REFUSED(dig_body_set_velocity(w, b, one, one), want);
    REFUSED(dig_body_set(w, b, "mass", &x), want);
    REFUSED(dig_body_param(w, b, "mass", &x), want);
    REFUSED(dig_body_wake(w, b), want);
    REFUSED(dig_message_send(w, good, b, "hello", (real[4]){0}), want);
    dig_joint_def j = dig_joint_defaults();
    const dig_schema *schema = dig_schema_find("joint", "ball");
    char data[1024];
    dig_schema_defaults(schema, data);
    j.type = "ball";
    j.a = b;
    j.data = data;
    dig_joint out;
    REFUSED(dig_joint_create(w, &j, &out), want);
    j.a = good;
    j.b = b;
    if (b.gen)
        REFUSED(dig_joint_create(w, &j, &out), want);
    CHECK(!dig_body_alive(w, b));
    CHECK(!dig_body_touches(w, b, good) && !dig_body_touches(w, good, b));
    CHECK(!dig_body_contains(w, b, good) && !dig_body_contains(w, good, b));
    CHECK_INT(dig_links_of(w, b, links, 4), 0);
    CHECK_INT(dig_neighbours(w, b, -1, list, 4), 0);
    CHECK_INT(dig_path(w, b, good, -1, list, 4), 0);
    CHECK_INT(dig_path(w, good, b, -1, list, 4), 0);
    CHECK_INT(dig_of(w, b).id, 0);
}

TEST(dead_null_and_foreign_handles_are_refused)
{
    Scene s = open_scene();
    dig_body gone = s.ball;
    CHECK(dig_body_remove(s.w, s.ball) == DIG_OK);
    refuse_body(s.w, gone, s.box, DIG_E_DEAD);
    /* its slot is taken again: the old handle stays dead */
    dig_body next = add_ball(s.w, look(0.5, 0), 0.3, 1, (vec3){0, 3, 0}, vec3_zero());
    CHECK_INT(next.slot, gone.slot);
    refuse_body(s.w, gone, s.box, DIG_E_DEAD);
    refuse_body(s.w, (dig_body){0, 0}, s.box, DIG_E_DEAD);
    refuse_body(s.w, (dig_body){1000000, 1}, s.box, DIG_E_DEAD);
    refuse_body(s.w, (dig_body){UINT32_MAX, UINT32_MAX}, s.box, DIG_E_DEAD);
    Scene other = open_scene();
    refuse_body(s.w, other.ball, s.box, DIG_E_DEAD);
    refuse_body(other.w, s.box, other.box, DIG_E_DEAD);

    dig_world *w = s.w;
    dig_joint_state state;
    dig_joint joints[] = {{0, 0}, {99, 1}, other.joint};
    real x = 1;
    for (int i = 0; i < 3; i++) {
        REFUSED(dig_joint_get(w, joints[i], &state), DIG_E_DEAD);
        REFUSED(dig_joint_set(w, joints[i], &(dig_setting){"friction", &x}, 1), DIG_E_DEAD);
        REFUSED(dig_joint_remove(w, joints[i]), DIG_E_DEAD);
        CHECK(!dig_joint_alive(w, joints[i]));
    }
    CHECK(dig_joint_remove(w, s.joint) == DIG_OK);
    REFUSED(dig_joint_remove(w, s.joint), DIG_E_DEAD);
    dig_dig_state dig;
    REFUSED(dig_dig_get(w, (dig_dig){0, 0}, &dig), DIG_E_DEAD);
    REFUSED(dig_dig_get(w, (dig_dig){12345, 0}, &dig), DIG_E_DEAD);
    REFUSED(dig_dig_accuracy(w, (dig_dig){12345, 0}, "study", 0), DIG_E_DEAD);
    REFUSED(dig_dig_accuracy(w, dig_of(w, s.box), "perfect", 0), DIG_E_ARG);
    REFUSED(dig_message_broadcast(w, (dig_dig){12345, 0}, s.box, "hello", (real[4]){0}), DIG_E_DEAD);
    step(w, 5);
    check_world(w);
    dig_world_close(w);
    dig_world_close(other.w);
}

TEST(queries_take_bad_arguments_without_harm)
{
    Scene s = open_scene();
    dig_world *w = s.w;
    uint64_t before = dig_world_checksum(w);
    dig_hit hits[4];
    vec3 down = {0, -1, 0};
    for (int i = 0; i < 3; i++) {
        real x = bad_numbers[i];
        CHECK(dig_ray(w, (vec3){0, x, 0}, down, 10, hits, 4) <= 0);
        CHECK(dig_ray(w, (vec3){0, 5, 0}, (vec3){x, 0, 0}, 10, hits, 4) <= 0);
        CHECK(dig_ray(w, (vec3){0, 5, 0}, down, x, hits, 4) <= (x > 0 ? 4 : 0));
    }
    CHECK(dig_ray(w, (vec3){0, 5, 0}, vec3_zero(), 10, hits, 4) <= 0);
    CHECK(dig_ray(w, (vec3){0, 5, 0}, down, 0, hits, 4) <= 0);
    CHECK(dig_ray(w, (vec3){0, 5, 0}, down, -1, hits, 4) <= 0);
    dig_sphere_def ball = {0.5};
    dig_shape_def shape = {.type = "sphere", .data = &ball, .at = {{0, 0, 0}, {0, 0, 0, 1}}};
    pose at = {{0, 5, 0}, {0, 0, 0, 1}};
    CHECK_INT(dig_sweep(w, &shape, at, down, vec3_zero(), 10, hits), 1);
    CHECK(dig_sweep(w, &shape, at, (vec3){NAN, 0, 0}, vec3_zero(), 10, hits) < 0);
    CHECK(dig_sweep(w, &shape, at, down, vec3_zero(), NAN, hits) < 0);
    CHECK(dig_sweep(w, &shape, at, down, vec3_zero(), -1, hits) < 0);
    ball.radius = -1;
    CHECK(dig_sweep(w, &shape, at, down, vec3_zero(), 10, hits) < 0);
    shape.type = "cloud";
    CHECK(dig_sweep(w, &shape, at, down, vec3_zero(), 10, hits) < 0);
    CHECK(dig_world_checksum(w) == before);
    dig_world_close(w);
}

int main(void)
{
    RUN_TESTS(unit_test(non_finite_numbers_fail_the_step_and_name_the_culprit),
              unit_test(what_is_set_aside_leaves_the_others_what_they_would_have_done),
              unit_test(anything_can_be_disabled),
              unit_test(one_poisoned_body_of_a_hundred_leaves_the_others_untouched),
              unit_test(a_step_that_fails_has_no_events_and_the_next_one_has_its_own),
              unit_test(bodies_with_bad_numbers_are_refused),
              unit_test(calls_with_bad_numbers_are_refused),
              unit_test(bodies_of_the_wrong_kind_are_refused),
              unit_test(joints_with_bad_arguments_are_refused),
              unit_test(worlds_with_bad_numbers_do_not_open),
              unit_test(dead_null_and_foreign_handles_are_refused),
              unit_test(queries_take_bad_arguments_without_harm));
}
