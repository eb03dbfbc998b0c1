/* test_joint_rows.c - every joint type: its rows, its freedom, its parameters; then hinges, sliders, ball joints, lengths and
 * springs. Gears, racks, wheels and motors are in test_joint_drives.c. */
#include "joint_fixture.h"

enum { TRIES = 40, PARAM_BYTES = 48 * sizeof(real) };   /* room in a joint record */

/* Everything a type has is switched on. */
static void all_on(Joint *t)
{
    const JointType *type = t->type;
    switch_on(t);
    if (has(type, "spring")) {
        set(t, "spring.damping", 2);
        set(t, "spring.rest", 0.1);
    }
    if (has(type, "damping"))
        set(t, "damping", 2);
}

/* ---- what holds for every type ------------------------------------------------- */

TEST(the_list_has_its_order)
{
    static const char *const names[] = {"hinge", "slider", "ball", "weld", "distance", "rope", "spring", "gear", "rack", "wheel",
                                        "bolt", "motor", "strut", "beam", "guide"};
    for (int i = 0; i < 15; i++)
        CHECK_TEXT(joint_types[i]->name, names[i]);
    CHECK(joint_types[15] == NULL);
}

static void check_schema(const dig_param *rows, size_t size)
{
    for (const dig_param *r = rows; r->name; r++) {
        CHECK(r->doc && r->doc[0] && r->unit);
        CHECK(r->offset + param_size(r) <= size);
        if (r->kind == DIG_TABLE)
            check_schema(r->rows, size - r->offset);
    }
}

TEST(parameters_fit_their_struct_and_its_defaults_pass)
{
    for (int i = 0; joint_types[i]; i++) {
        const JointType *type = joint_types[i];
        real params[48] = {0};
        char why[200] = "";
        CHECK(type->params_size <= PARAM_BYTES);
        CHECK(type->schema.rows == type->params && type->schema.size == type->params_size);
        CHECK(type->doc && type->doc[0]);
        check_schema(type->params, type->params_size);
        param_defaults(type->params, params);
        for (const dig_param *r = type->params; r->name; r++)
            if (!r->required && param_check_field(r, (char *)params + r->offset, type->name, why, sizeof why) != DIG_OK)
                fail_msg("%s", why);
        if (type->two_anchors)
            CHECK(param_find(type->params, "at_a")->offset == 0 && param_find(type->params, "at_b")->offset == sizeof(vec3));
        if (type->couples)
            CHECK(param_find(type->params, "a")->offset == 0 && param_find(type->params, "b")->offset == sizeof(dig_joint));
    }
}

/* Rank of the rows for unit masses and inertias: pivots of their Gram matrix. */
static int rank_of(const Row *rows, int count)
{
    real m[6][6];
    int rank = 0;
    for (int i = 0; i < count; i++)
        for (int k = 0; k < count; k++) {
            m[i][k] = 0;
            for (int b = 0; b < 2; b++)
                if (rows[i].body[b] >= 0)
                    m[i][k] += vec3_dot(rows[i].lin[b], rows[k].lin[b]) + vec3_dot(rows[i].ang[b], rows[k].ang[b]);
        }
    for (int i = 0; i < count; i++) {
        rank += m[i][i] > 1e-6;
        for (int r = i + 1; r < count && m[i][i] > 1e-6; r++)
            for (int c = count - 1; c >= i; c--)
                m[r][c] -= m[r][i] / m[i][i] * m[i][c];
    }
    return rank;
}

TEST(hard_rows_are_six_less_the_free_axes_independent_and_zero_at_creation)
{
    Dice d = {11};
    for (int i = 0; joint_types[i]; i++) {
        if (joint_types[i]->couples)
            continue;
        for (int k = 0; k < TRIES; k++) {
            Joint t = joint_make(joint_types[i]->name, &d, k % 2);
            Row rows[JOINT_SLOTS], hard[6];
            int count = rows_of(&t, &t.rig, rows), n = 0;
            for (int r = 0; r < count; r++)
                if (rows[r].kind == ROW_HARD) {
                    CHECK_NEAR(rows[r].error, 0, 4e-15);
                    CHECK(n < 6);
                    hard[n++] = rows[r];
                }
            CHECK_INT(n, 6 - t.type->free_axes);
            CHECK_INT(rank_of(hard, n), n);
        }
    }
}

TEST(slots_are_distinct_and_few_enough_with_everything_on)
{
    Dice d = {12};
    for (int i = 0; joint_types[i]; i++) {
        if (joint_types[i]->couples)
            continue;
        Joint t = joint_make(joint_types[i]->name, &d, false);
        all_on(&t);
        rig_disturb(&t.rig, &d, 0.3);
        Row rows[JOINT_SLOTS];
        int count = rows_of(&t, &t.rig, rows);
        unsigned seen = 0;
        for (int r = 0; r < count; r++) {
            CHECK(rows[r].slot >= 0 && rows[r].slot < JOINT_SLOTS);
            CHECK(!(seen & 1u << rows[r].slot));
            seen |= 1u << rows[r].slot;
        }
    }
}

/* Rows with an error: rate = d(error)/dt. Motors and friction: rate = d(coordinate)/dt, by `speed`. */
static void check_all_rates(Joint *t)
{
    Row rows[JOINT_SLOTS], then[4][JOINT_SLOTS];
    JointView j = view_of(t, &t->rig);
    int count = rows_of(t, &t->rig, rows);
    real x[4] = {0};
    for (int k = 0; k < 4; k++) {
        Rig moved = rig_after(&t->rig, ticks[k]);
        CHECK_INT(rows_of(t, &moved, then[k]), count);
        x[k] = t->type->coordinate ? coordinate_at(t, &moved) : 0;
    }
    bool exact = strcmp(t->type->name, "motor") != 0;          /* drives the spin about b's axis, not the twist */
    real speed = t->type->speed ? t->type->speed(&j) : NAN;
    if (t->type->speed && exact)
        CHECK_NEAR(speed, difference(x, TICK), 1e-8 * (1 + fabs(speed)));
    for (int i = 0; i < count; i++) {
        real got = joint_rate(&j, &rows[i]), f[4];
        for (int k = 0; k < 4; k++)
            f[k] = then[k][i].error;
        if (rows[i].kind == ROW_MOTOR || rows[i].kind == ROW_DRY)
            CHECK(isnan(speed) || fabs(got - speed) < 1e-12 * (1 + fabs(speed)));
        else
            CHECK_NEAR(got, difference(f, TICK), 1e-8 * (1 + fabs(got)));
    }
}

TEST(every_row_of_every_type_has_the_rate_of_its_error)
{
    Dice d = {13};
    for (int i = 0; joint_types[i]; i++)
        for (int k = 0; k < TRIES && !joint_types[i]->couples; k++) {
            Joint t = joint_make(joint_types[i]->name, &d, k % 3 == 0);
            all_on(&t);
            Row rows[JOINT_SLOTS];
            rows_of(&t, &t.rig, rows);          /* the wheel takes down its axis */
            rig_disturb(&t.rig, &d, 0.3);
            check_all_rates(&t);
        }
}

/* dE/dt = sum over springs of stiffness * error * rate */
TEST(stored_energy_changes_by_the_power_of_the_springs)
{
    Dice d = {14};
    int with_energy = 0;
    for (int i = 0; joint_types[i]; i++) {
        if (!joint_types[i]->energy)
            continue;
        with_energy++;
        Joint t = joint_make(joint_types[i]->name, &d, false);
        all_on(&t);
        rig_disturb(&t.rig, &d, 0.3);
        Row rows[JOINT_SLOTS];
        int count = rows_of(&t, &t.rig, rows);
        JointView j = view_of(&t, &t.rig);
        real want = 0, e[4];
        for (int r = 0; r < count; r++)
            if (rows[r].kind == ROW_SOFT)
                want += rows[r].stiffness * rows[r].error * joint_rate(&j, &rows[r]);
        for (int k = 0; k < 4; k++) {
            Rig moved = rig_after(&t.rig, ticks[k]);
            JointView then = view_of(&t, &moved);
            e[k] = t.type->energy(&then);
        }
        CHECK(fabs(want) > 1e-3);
        CHECK_NEAR(difference(e, TICK), want, 1e-7 * (1 + fabs(want)));
    }
    CHECK_INT(with_energy, 6);
}

/* ---- hinge and slider -------------------------------------------------------------- */

TEST(a_door_turned_by_a_third_of_a_radian_says_so)
{
    Joint t = simple("hinge");
    t.rig.q[0] = quat_axis_angle((vec3){0, 0, 1}, 0.3);
    t.rig.w[0] = (vec3){0, 0, 2};
    CHECK_NEAR(coordinate_at(&t, &t.rig), 0.3, 1e-15);
    CHECK_NEAR(speed_of(&t), 2, 1e-15);
}

TEST(a_drawer_pulled_along_its_axis_is_out_by_that_much)
{
    Joint t = simple("slider");
    t.rig.x[0] = (vec3){0, 0, 0.2};
    t.rig.v[0] = (vec3){0, 0, 0.5};
    set_range(&t, "limits", 0, 0.15);
    set(&t, "motor.speed", -1);
    set(&t, "motor.max_force", 7);
    CHECK_NEAR(coordinate_at(&t, &t.rig), 0.2, 1e-15);
    CHECK_NEAR(speed_of(&t), 0.5, 1e-15);
    Row rows[JOINT_SLOTS];
    int count = rows_of(&t, &t.rig, rows);
    const Row *motor = row_of(rows, count, ROW_MOTOR), *stop = &rows[6];
    CHECK_INT(count, 5 + 2 + 1);
    CHECK_NEAR(motor->rate, -1, 0);
    CHECK_NEAR(motor->hi, 7, 0);
    CHECK_NEAR(motor->lin[0].z, 1, 1e-15);
    CHECK(stop->kind == ROW_LIMIT);
    CHECK_NEAR(stop->error, -0.05, 1e-15);
    CHECK_NEAR(stop->lin[0].z, -1, 1e-15);          /* its impulse pushes the drawer back in */
    JointView j = view_of(&t, &t.rig);
    CHECK(t.type->at_limit(&j));
}

TEST(a_hinge_counts_its_turns_and_reading_it_changes_nothing)
{
    Joint t = simple("hinge");
    Row rows[JOINT_SLOTS];
    for (int i = 0; i <= 100; i++) {
        t.rig.q[0] = quat_axis_angle((vec3){0, 0, 1}, 0.5 * i);
        real before = t.memory[0];
        CHECK_NEAR(coordinate_at(&t, &t.rig), 0.5 * i, 1e-12);
        CHECK(t.memory[0] == before);
        rows_of(&t, &t.rig, rows);
    }
    CHECK_NEAR(t.memory[0], 50, 1e-12);
}

TEST(free_motion_of_a_hinge_and_a_slider_breaks_no_hard_row)
{
    Joint t[2] = {simple("hinge"), simple("slider")};
    t[0].rig.w[0] = (vec3){0, 0, 3};
    t[1].rig.v[0] = (vec3){0, 0, 3};
    for (int i = 0; i < 2; i++) {
        Rig moved = rig_after(&t[i].rig, 0.7);
        Row rows[JOINT_SLOTS];
        int count = rows_of(&t[i], &moved, rows);
        JointView j = view_of(&t[i], &moved);
        CHECK_INT(count, 5);
        for (int r = 0; r < count; r++) {
            CHECK_NEAR(rows[r].error, 0, 1e-14);
            CHECK_NEAR(joint_rate(&j, &rows[r]), 0, 1e-14);
        }
    }
}

TEST(a_motor_without_a_bound_has_none_and_without_a_speed_is_off)
{
    Joint t = simple("hinge");
    Row rows[JOINT_SLOTS];
    CHECK(!row_of(rows, rows_of(&t, &t.rig, rows), ROW_MOTOR));
    set(&t, "motor.speed", 2);
    const Row *motor = row_of(rows, rows_of(&t, &t.rig, rows), ROW_MOTOR);
    CHECK(motor && isinf(motor->hi) && motor->rate == 2 && motor->angular);
    set(&t, "motor.max_torque", 0);
    CHECK(!row_of(rows, rows_of(&t, &t.rig, rows), ROW_MOTOR));
}

/* ---- ball ------------------------------------------------------------------------------ */

TEST(the_cone_of_a_ball_joint_drives_the_swing_back)
{
    Joint t = simple("ball");
    set(&t, "swing", 0.4);
    t.rig.q[0] = quat_axis_angle((vec3){1, 0, 0}, 0.5);
    Row rows[JOINT_SLOTS];
    int count = rows_of(&t, &t.rig, rows);
    const Row *stop = row_of(rows, count, ROW_LIMIT);
    CHECK_INT(count, 4);
    CHECK_NEAR(stop->error, -0.1, 1e-15);
    CHECK_NEAR(stop->ang[0].x, -1, 1e-15);
    JointView j = view_of(&t, &t.rig);
    CHECK(t.type->at_limit(&j));
    t.rig.q[0] = quat_axis_angle((vec3){1, 0, 0}, 0.3);
    j = view_of(&t, &t.rig);
    CHECK(!t.type->at_limit(&j));
}

TEST(twist_and_swing_of_a_ball_joint_are_apart)
{
    Joint t = simple("ball");
    set_range(&t, "twist", -0.2, 0.2);
    set(&t, "swing", 1);
    t.rig.q[0] = quat_mul(quat_axis_angle((vec3){0.6, 0.8, 0}, 0.9), quat_axis_angle((vec3){0, 0, 1}, 0.15));
    Row rows[JOINT_SLOTS];
    int count = rows_of(&t, &t.rig, rows);
    CHECK_INT(count, 6);
    CHECK_NEAR(rows[3].error, 0.1, 1e-14);          /* swing 0.9 of 1         */
    CHECK_NEAR(rows[4].error, 0.35, 1e-14);         /* twist 0.15 above -0.2  */
    CHECK_NEAR(rows[5].error, 0.05, 1e-14);
}

TEST(the_first_friction_row_of_a_ball_joint_lies_along_the_spin)
{
    Joint t = simple("ball");
    set(&t, "friction", 3);
    t.rig.w[0] = (vec3){1, 2, 2};
    Row rows[JOINT_SLOTS];
    int count = rows_of(&t, &t.rig, rows);
    JointView j = view_of(&t, &t.rig);
    CHECK_INT(count, 6);
    CHECK_NEAR(joint_rate(&j, &rows[3]), 3, 1e-14);
    CHECK_NEAR(joint_rate(&j, &rows[4]), 0, 1e-14);
    CHECK_NEAR(joint_rate(&j, &rows[5]), 0, 1e-14);
    CHECK(rows[3].kind == ROW_DRY && rows[3].hi == 3);
}

/* ---- distance, rope, spring -------------------------------------------------------------- */

/* Ends on the z axis at 0 (the world) and z (the body). */
static Joint ends_at(const char *name, real z)
{
    Joint t = simple(name);
    t.rig.x[0] = (vec3){0, 0, z};
    return t;
}

TEST(a_length_that_is_not_given_is_the_present_one)
{
    static const char *const names[] = {"distance", "rope", "spring"};
    for (int i = 0; i < 3; i++) {
        Joint t = ends_at(names[i], 0.7);
        char why[200];
        if (has(t.type, "stiffness"))
            set(&t, "stiffness", 1);
        CHECK_INT(check(&t, why, sizeof why), DIG_OK);
        real length;
        memcpy(&length, field(&t, "length"), sizeof length);
        CHECK_NEAR(length, 0.7, 1e-15);
    }
}

TEST(lengths_that_cannot_be_are_refused_with_a_reason)
{
    Joint t = ends_at("distance", 0.7);
    set(&t, "length", 1);
    set(&t, "max", 2);
    check_refused(&t, "length = 1 m");
    t = ends_at("distance", 0.7);
    set(&t, "min", 3);
    set(&t, "max", 2);
    check_refused(&t, "min = 3 m, must be at most max = 2 m");
    t = ends_at("distance", 0);
    check_refused(&t, "0 m apart");
    t = ends_at("rope", 0);
    check_refused(&t, "0 m apart");
}

TEST(a_rope_pulls_when_it_is_taut_and_only_then)
{
    Joint t = ends_at("rope", 1.25);
    set(&t, "length", 1);
    Row rows[JOINT_SLOTS];
    CHECK_INT(rows_of(&t, &t.rig, rows), 1);
    CHECK(rows[0].kind == ROW_LIMIT);
    CHECK_NEAR(rows[0].error, -0.25, 1e-15);
    CHECK_NEAR(rows[0].lin[0].z, -1, 1e-15);        /* an impulse >= 0 pulls the body to the world's end */
    t.rig.x[0].z = 0.25;
    rows_of(&t, &t.rig, rows);
    CHECK_NEAR(rows[0].error, 0.75, 1e-15);
    t.rig.x[0].z = 0;
    CHECK_INT(rows_of(&t, &t.rig, rows), 0);
}

TEST(a_distance_within_a_range_has_two_stops_and_no_hard_row)
{
    Joint t = ends_at("distance", 0.7);
    set(&t, "min", 0.5);
    set(&t, "max", 1);
    Row rows[JOINT_SLOTS];
    CHECK_INT(rows_of(&t, &t.rig, rows), 2);
    CHECK_NEAR(rows[0].error, 0.2, 1e-15);
    CHECK_NEAR(rows[1].error, 0.3, 1e-15);
    CHECK(rows[0].kind == ROW_LIMIT && rows[1].kind == ROW_LIMIT);
}

TEST(ends_of_a_distance_that_coincide_are_driven_apart)
{
    Joint t = ends_at("distance", 0);
    set(&t, "length", 1);
    Row rows[JOINT_SLOTS];
    CHECK_INT(rows_of(&t, &t.rig, rows), 1);
    CHECK_NEAR(rows[0].error, -1, 1e-15);
    CHECK_NEAR(vec3_length(rows[0].lin[0]), 1, 1e-15);
}

/* Force on a = -(stiffness error + damping rate) along the row. */
static vec3 spring_force(Joint *t)
{
    Row rows[JOINT_SLOTS];
    int count = rows_of(t, &t->rig, rows);
    JointView j = view_of(t, &t->rig);
    vec3 f = vec3_zero();
    for (int i = 0; i < count; i++)
        f = vec3_mad(f, -(rows[i].stiffness * rows[i].error + rows[i].damping * joint_rate(&j, &rows[i])), rows[i].lin[0]);
    return f;
}

TEST(a_spring_obeys_hooke_and_its_damper)
{
    Joint t = ends_at("spring", 0.7);
    set(&t, "stiffness", 20);
    set(&t, "damping", 3);
    set(&t, "length", 0.5);
    t.rig.v[0] = (vec3){4, 0, 0.25};                /* only the part along the line is damped */
    CHECK_NEAR(spring_force(&t).z, -(20 * 0.2 + 3 * 0.25), 1e-14);
    CHECK_NEAR(spring_force(&t).x, 0, 1e-15);
    JointView j = view_of(&t, &t.rig);
    CHECK_NEAR(t.type->energy(&j), 0.5 * 20 * 0.04, 1e-15);
}

TEST(a_spring_of_no_length_pulls_and_damps_in_every_direction)
{
    Joint t = ends_at("spring", 0);
    set(&t, "stiffness", 20);
    set(&t, "damping", 3);
    set(&t, "length", 0);
    t.rig.v[0] = (vec3){1, 2, 3};
    CHECK_NEAR(vec3_distance(spring_force(&t), (vec3){-3, -6, -9}), 0, 1e-14);
    t.rig.x[0] = (vec3){0.1, 0, -0.2};
    CHECK_NEAR(vec3_distance(spring_force(&t), (vec3){-5, -6, -5}), 0, 1e-14);
    Row rows[JOINT_SLOTS];
    CHECK_INT(rows_of(&t, &t.rig, rows), 3);
    for (int i = 0; i < 3; i++)
        CHECK_INT(rows[i].slot, i);
}

int main(void)
{
    RUN_TESTS(unit_test(the_list_has_its_order), unit_test(parameters_fit_their_struct_and_its_defaults_pass),
              unit_test(hard_rows_are_six_less_the_free_axes_independent_and_zero_at_creation),
              unit_test(slots_are_distinct_and_few_enough_with_everything_on),
              unit_test(every_row_of_every_type_has_the_rate_of_its_error),
              unit_test(stored_energy_changes_by_the_power_of_the_springs),
              unit_test(a_door_turned_by_a_third_of_a_radian_says_so),
              unit_test(a_drawer_pulled_along_its_axis_is_out_by_that_much),
              unit_test(a_hinge_counts_its_turns_and_reading_it_changes_nothing),
              unit_test(free_motion_of_a_hinge_and_a_slider_breaks_no_hard_row),
              unit_test(a_motor_without_a_bound_has_none_and_without_a_speed_is_off),
              unit_test(the_cone_of_a_ball_joint_drives_the_swing_back), unit_test(twist_and_swing_of_a_ball_joint_are_apart),
              unit_test(the_first_friction_row_of_a_ball_joint_lies_along_the_spin),
              unit_test(a_length_that_is_not_given_is_the_present_one),
              unit_test(lengths_that_cannot_be_are_refused_with_a_reason), unit_test(a_rope_pulls_when_it_is_taut_and_only_then),
              unit_test(a_distance_within_a_range_has_two_stops_and_no_hard_row),
              unit_test(ends_of_a_distance_that_coincide_are_driven_apart), unit_test(a_spring_obeys_hooke_and_its_damper),
              unit_test(a_spring_of_no_length_pulls_and_damps_in_every_direction));
}
