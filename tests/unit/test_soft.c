/* tests/unit/test_soft.c - struts and beams: what they bear, what they store, what stays when they yield, and what is lost when they
 * break. Expectations are closed forms.
 */
#include "physics_fixture.h"

/* Two balls of 1 kg, 1 m apart along x, and a strut of EA = 1000 N between them. */
typedef struct Pair2 { dig_world *w; dig_body a, b; dig_joint j; } Pair2;

static void put(const dig_schema *s, void *params, const char *name, real x)
{
    for (const dig_param *p = s->rows; p->name; p++)
        if (strcmp(p->name, name) == 0) {
            memcpy((char *)params + p->offset, &x, sizeof x);
            return;
        }
    fail_msg("%s has no parameter '%s'", s->name, name);
}

static dig_body ball(dig_world *w, real x)
{
    dig_body_def d = body_with(look(0, 0), (vec3){x, 0, 0}, quat_identity());
    d.mass = 1;
    d.collides = false;
    return add_body(w, d, "sphere", &(dig_sphere_def){0.1});
}

typedef struct Wish { const char *name; real value; } Wish;

static Pair2 pair_of(real step, real breaks_at, const Wish *wishes, int count)
{
    Pair2 p = {.w = open_world(step, NULL, false)};
    const dig_schema *s = dig_schema_find("joint", "strut");
    real params[48];
    p.a = ball(p.w, 0);
    p.b = ball(p.w, 1);
    dig_schema_defaults(s, params);
    put(s, params, "stiffness", 1000);
    for (int i = 0; i < count; i++)
        put(s, params, wishes[i].name, wishes[i].value);
    dig_joint_def d = dig_joint_defaults();
    d.type = "strut";
    d.a = p.a;
    d.b = p.b;
    d.breaks_at = breaks_at;
    d.data = params;
    CHECK_INT(dig_joint_create(p.w, &d, &p.j), DIG_OK);
    return p;
}

static void pull(const Pair2 *p, real force, int steps)
{
    for (int i = 0; i < steps; i++) {
        CHECK_INT(dig_body_push(p->w, p->a, (vec3){-force, 0, 0}, vec3_zero(), false, 0), DIG_OK);
        CHECK_INT(dig_body_push(p->w, p->b, (vec3){force, 0, 0}, vec3_zero(), false, 0), DIG_OK);
        CHECK_INT(dig_world_step(p->w), DIG_OK);
    }
}

static real length_of(const Pair2 *p)
{
    dig_joint_state s;
    CHECK_INT(dig_joint_get(p->w, p->j, &s), DIG_OK);
    return s.distance;
}

TEST(a_strut_says_what_share_of_its_limits_it_bears_pulled_and_pressed)
{
    const Wish with[] = {{"relaxation", 0.1}, {"breaks_pressed", 40}};
    Pair2 p = pair_of(1.0 / 60, 100, with, 2);
    dig_joint_state s;
    pull(&p, 30, 300);
    CHECK_INT(dig_joint_get(p.w, p.j, &s), DIG_OK);
    CHECK_NEAR(s.distance, 1.03, 1e-6);
    CHECK_NEAR(s.stress, 0.3, 1e-4);
    pull(&p, -30, 300);
    CHECK_INT(dig_joint_get(p.w, p.j, &s), DIG_OK);
    CHECK_NEAR(s.distance, 0.97, 1e-6);
    CHECK_NEAR(s.stress, 0.75, 1e-4);
    CHECK(dig_joint_alive(p.w, p.j));
    pull(&p, -41, 300);
    CHECK(!dig_joint_alive(p.w, p.j));
    dig_world_close(p.w);
}

TEST(a_strut_strained_past_its_elastic_limit_stays_longer_and_its_loss_is_booked)
{
    const Wish with[] = {{"relaxation", 0.1}, {"yield", 50}};
    Pair2 p = pair_of(1.0 / 60, INFINITY, with, 2);
    pull(&p, 49, 300);
    pull(&p, 0, 300);
    CHECK_NEAR(length_of(&p), 1, 1e-6);
    for (int i = 0; i < 60; i++)
        pull(&p, 60, 1);            /* more than it bears: it flows */
    pull(&p, 0, 400);
    CHECK(length_of(&p) > 1.02);
    dig_energy e = dig_world_energy(p.w);
    CHECK(e.lost > 50 * (length_of(&p) - 1));       /* at least the force at yield times the way */
    CHECK_NEAR(e.numerical, 0, 1e-6 * e.work_in);
    dig_world_close(p.w);
}

/* J that a script takes out of the world with a strained strut: k x^2 / 2. */
TEST(what_is_taken_away_under_load_takes_its_elastic_energy_out_of_the_ledger)
{
    const Wish with[] = {{"relaxation", 0.1}};
    Pair2 p = pair_of(1.0 / 60, INFINITY, with, 1);
    pull(&p, 30, 300);
    dig_energy before = dig_world_energy(p.w);
    CHECK_NEAR(before.elastic, 0.5 * 1000 * 0.03 * 0.03, 1e-5);
    CHECK_INT(dig_joint_remove(p.w, p.j), DIG_OK);
    dig_energy after = dig_world_energy(p.w);
    CHECK_NEAR(before.initial - after.initial, before.elastic, 1e-12);
    CHECK_NEAR(after.numerical, before.numerical, 1e-12);
    dig_world_close(p.w);
}

/* ---- beams ---- */

/* A beam of two bodies of 1 m and 2 kg, joint in the middle: the couple k angle about z, k = E b h^3 / 12 l. */
static dig_world *open_beam(real modulus, real relaxation, dig_body body[2], dig_joint *j)
{
    dig_world *w = open_world(1.0 / 60, NULL, false);
    const dig_schema *s = dig_schema_find("joint", "beam");
    real params[48];
    for (int i = 0; i < 2; i++) {
        dig_body_def d = body_with(look(0, 0), (vec3){i, 0, 0}, quat_identity());
        d.mass = 2;
        body[i] = add_body(w, d, "box", &(dig_box_def){{1, 0.02, 0.1}});
    }
    dig_schema_defaults(s, params);
    put(s, params, "length", 1);
    put(s, params, "width", 0.1);
    put(s, params, "height", 0.02);
    put(s, params, "modulus", modulus);
    put(s, params, "relaxation", relaxation);
    const vec3 up = {0, 1, 0};
    memcpy(params, &up, sizeof up);
    dig_joint_def d = dig_joint_defaults();
    d.type = "beam";
    d.a = body[1];
    d.b = body[0];
    d.at = (vec3){0.5, 0, 0};
    d.axis = (vec3){1, 0, 0};
    d.data = params;
    CHECK_INT(dig_joint_create(w, &d, j), DIG_OK);
    return w;
}

TEST(a_beam_bends_by_the_moment_over_its_stiffness_both_ways_and_twists)
{
    const real k[3] = {1e9 / 2.6 * 0.1 * 8e-6 * (1.0 / 3 - 0.21 * 0.2 * (1 - 0.0016 / 12)), 1e9 * 0.02 * 1e-3 / 12, 1e9 * 0.1 * 8e-6 / 12};
    for (int axis = 0; axis < 3; axis++) {
        dig_body b[2];
        dig_joint j;
        dig_world *w = open_beam(1e9, 0.2, b, &j);
        vec3 torque = {axis == 0, axis == 1, axis == 2};
        torque = vec3_scale(0.02 * k[axis], torque);
        for (int i = 0; i < 600; i++) {
            CHECK_INT(dig_body_twist(w, b[0], vec3_neg(torque), 0), DIG_OK);
            CHECK_INT(dig_body_twist(w, b[1], torque, 0), DIG_OK);
            CHECK_INT(dig_world_step(w), DIG_OK);
        }
        dig_body_state s[2];
        dig_body_get(w, b[0], &s[0]);
        dig_body_get(w, b[1], &s[1]);
        quat d = quat_mul(s[1].rotation, quat_conjugate(s[0].rotation));
        CHECK_NEAR(2 * vec3_length((vec3){d.x, d.y, d.z}), 0.02, 1e-5);
        dig_world_close(w);
    }
}

/* So stiff that it swings many times in a step: no way follows that, one keeps its energy. */
TEST(an_undamped_beam_in_free_flight_keeps_energy_and_momentum)
{
    dig_body b[2];
    dig_joint j;
    dig_world *w = open_beam(1e14, 0, b, &j);
    CHECK_INT(dig_body_hit(w, b[0], (vec3){1, 2, 0.5}, (vec3){-0.5, 0, 0}, true), DIG_OK);
    CHECK_INT(dig_world_step(w), DIG_OK);
    CHECK_INT(dig_world_stats(w).conserved, 1);
    real before = dig_world_energy(w).total;
    vec3 momentum = dig_world_momentum(w), turning = dig_world_angular_momentum(w);
    for (int i = 0; i < 600; i++)
        CHECK_INT(dig_world_step(w), DIG_OK);
    CHECK_NEAR(dig_world_energy(w).total, before, 1e-7 * before);
    CHECK_NEAR(vec3_distance(dig_world_momentum(w), momentum), 0, 1e-12);
    CHECK_NEAR(vec3_distance(dig_world_angular_momentum(w), turning), 0, 1e-9);
    dig_world_close(w);
}

int main(void)
{
    RUN_TESTS(unit_test(a_strut_says_what_share_of_its_limits_it_bears_pulled_and_pressed),
               unit_test(a_strut_strained_past_its_elastic_limit_stays_longer_and_its_loss_is_booked),
               unit_test(what_is_taken_away_under_load_takes_its_elastic_energy_out_of_the_ledger),
               unit_test(a_beam_bends_by_the_moment_over_its_stiffness_both_ways_and_twists),
               unit_test(an_undamped_beam_in_free_flight_keeps_energy_and_momentum));
}
