/* test_joint_drives.c - gears and racks, which couple joints; wheels and motors. */
#include "joint_fixture.h"

enum { TRIES = 40 };

/* Two hinges or a hinge and a slider, side by side on one frame (body 2), for gears and racks. */
typedef struct Pair { Joint first, second; JointView view[2]; } Pair;

static void pair_look(Pair *p)
{
    p->view[0] = view_of(&p->first, &p->first.rig);
    p->view[1] = view_of(&p->second, &p->second.rig);
}

static void pair_make(Pair *p, Dice *d, const char *first, const char *second)
{
    p->first = joint_make(first, d, false);
    p->second = joint_make(second, d, false);
    Rig *a = &p->first.rig, *b = &p->second.rig;
    a->body[0] = 0;
    b->body[0] = 1;
    a->body[1] = b->body[1] = 2;
    b->x[1] = a->x[1];
    b->q[1] = a->q[1];
    b->v[1] = a->v[1];
    b->w[1] = a->w[1];
    vec3 at = dice_vec(d), both[2] = {at, at};
    rig_join(b, both, dice_quat(d));
    pair_look(p);
}

static Joint couple(const char *name, Pair *p)
{
    Joint t = {.type = type_of(name)};
    param_defaults(t.type->params, t.params);
    t.other[0] = &p->view[0];
    t.other[1] = &p->view[1];
    return t;
}

/* ---- gear and rack -------------------------------------------------------------------------- */

static real coupled_rate(const Row *r, const Pair *p)
{
    vec3 v[3] = {p->first.rig.v[0], p->second.rig.v[0], p->first.rig.v[1]};
    vec3 w[3] = {p->first.rig.w[0], p->second.rig.w[0], p->first.rig.w[1]};
    real rate = 0;
    for (int i = 0; i < r->count; i++)
        rate += vec3_dot(r->lin[i], v[r->body[i]]) + vec3_dot(r->ang[i], w[r->body[i]]);
    return rate;
}

/* Lets a turn at wa and b move at xb against their common frame, which turns itself. */
static void pair_drive(Pair *p, real wa, real xb)
{
    Rig *a = &p->first.rig, *b = &p->second.rig;
    JointEnd ea = rig_end(a, 0), eb = rig_end(b, 0), fa = rig_end(a, 1), fb = rig_end(b, 1);
    bool turns = p->second.type->angular;
    a->w[0] = vec3_mad(a->w[1], wa, fa.axis);
    a->v[0] = vec3_sub(vec3_add(a->v[1], vec3_cross(a->w[1], fa.r)), vec3_cross(a->w[0], ea.r));
    b->w[0] = turns ? vec3_mad(b->w[1], xb, fb.axis) : b->w[1];
    b->v[0] = vec3_sub(vec3_add(b->v[1], vec3_cross(b->w[1], fb.r)), vec3_cross(b->w[0], eb.r));
    if (!turns)
        b->v[0] = vec3_mad(b->v[0], xb, fb.axis);
    pair_look(p);
}

TEST(gears_turn_as_their_numbers_say_whatever_their_frame_does)
{
    static const real cases[][4] = {{1, 12, 12, 1}, {12, 1, 1, 12}, {20, -40, 2, -1}, {-3, 1, -1, 3}};     /* ratio, speeds */
    Dice d = {21};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        Pair p;
        Row rows[JOINT_SLOTS];
        pair_make(&p, &d, "hinge", "hinge");
        Joint t = couple("gear", &p);
        set_range(&t, "ratio", cases[i][0], cases[i][1]);
        pair_drive(&p, cases[i][2], cases[i][3]);
        CHECK_INT(check(&t, (char[100]){0}, 100), DIG_OK);
        CHECK_INT(rows_of(&t, &t.rig, rows), 1);
        CHECK(rows[0].kind == ROW_HARD && rows[0].angular);
        CHECK_INT(rows[0].count, 3);                /* the common frame is one body */
        CHECK_NEAR(coupled_rate(&rows[0], &p), 0, 1e-14);
        pair_drive(&p, cases[i][2], cases[i][3] + 1);
        rows_of(&t, &t.rig, rows);
        CHECK(fabs(coupled_rate(&rows[0], &p)) > 0.01);
    }
}

TEST(a_gear_keeps_the_phase_of_its_creation_over_turns_and_new_ratios)
{
    Dice d = {22};
    Pair p;
    Row rows[JOINT_SLOTS];
    pair_make(&p, &d, "hinge", "hinge");
    pair_drive(&p, 0.4, 0.7);
    p.first.rig = rig_after(&p.first.rig, 1);       /* angles 0.4 and 0.7 before there is a gear */
    p.second.rig = rig_after(&p.second.rig, 1);
    p.second.rig.x[1] = p.first.rig.x[1];
    p.second.rig.q[1] = p.first.rig.q[1];
    Joint t = couple("gear", &p);
    set_range(&t, "ratio", 1, 3);
    pair_look(&p);
    rows_of(&t, &t.rig, rows);
    CHECK_NEAR(rows[0].error, 0, 1e-15);
    for (int i = 1; i <= 60; i++) {                 /* 18 rad of a, 6 of b */
        Rig *g[2] = {&p.first.rig, &p.second.rig};
        for (int k = 0; k < 2; k++)
            g[k]->q[0] = quat_mul(quat_axis_angle(rig_end(g[k], 1).axis, k ? 0.1 : 0.3), g[k]->q[0]);
        pair_look(&p);
        Row own[JOINT_SLOTS];
        rows_of(&p.first, g[0], own);
        rows_of(&p.second, g[1], own);
        rows_of(&t, &t.rig, rows);
        CHECK_NEAR(rows[0].error, 0, 1e-12);
    }
    p.second.rig.q[0] = quat_mul(quat_axis_angle(rig_end(&p.second.rig, 1).axis, 0.1), p.second.rig.q[0]);
    pair_look(&p);
    rows_of(&t, &t.rig, rows);
    CHECK_NEAR(rows[0].error, -0.1, 1e-12);         /* b is 0.1 rad ahead; the larger factor is 1 */
    for (int k = 2; k < 4; k++) {
        set_range(&t, "ratio", k, 1);
        rows_of(&t, &t.rig, rows);
        CHECK_NEAR(rows[0].error, 0, 1e-15);
    }
}

TEST(a_rack_moves_by_the_radius_of_its_pinion)
{
    Dice d = {23};
    for (int i = 0; i < TRIES; i++) {
        Pair p;
        Row rows[JOINT_SLOTS];
        pair_make(&p, &d, "hinge", "slider");
        Joint t = couple("rack", &p);
        set(&t, "ratio", i % 2 ? 0.05 : -0.05);
        pair_drive(&p, 4, i % 2 ? 0.2 : -0.2);
        CHECK_INT(check(&t, (char[100]){0}, 100), DIG_OK);
        CHECK_INT(rows_of(&t, &t.rig, rows), 1);
        CHECK_NEAR(coupled_rate(&rows[0], &p), 0, 1e-14);
        CHECK(!rows[0].angular);
        pair_drive(&p, 4, 0);
        rows_of(&t, &t.rig, rows);
        CHECK_NEAR(fabs(coupled_rate(&rows[0], &p)), 0.2, 1e-14);
    }
}

TEST(a_coupled_row_has_the_rate_of_its_error)
{
    static const char *const cases[][3] = {{"gear", "hinge", "hinge"}, {"rack", "hinge", "slider"}, {"gear", "wheel", "hinge"}};
    Dice d = {24};
    for (int i = 0; i < 3 * TRIES; i++) {
        Pair p, then;
        Row row, moved[JOINT_SLOTS];
        real e[4];
        pair_make(&p, &d, cases[i % 3][1], cases[i % 3][2]);
        Joint t = couple(cases[i % 3][0], &p);
        if (i % 3 == 1)
            set(&t, "ratio", 0.3);
        else
            set_range(&t, "ratio", 2, -3);
        rows_of(&t, &t.rig, moved);
        rig_disturb(&p.first.rig, &d, 0.3);
        rig_disturb(&p.second.rig, &d, 0.3);
        pair_look(&p);
        rows_of(&t, &t.rig, moved);
        row = moved[0];
        for (int k = 0; k < 4; k++) {
            then = p;
            then.first.rig = rig_after(&p.first.rig, ticks[k]);
            then.second.rig = rig_after(&p.second.rig, ticks[k]);
            pair_look(&then);
            t.other[0] = &then.view[0];
            t.other[1] = &then.view[1];
            rows_of(&t, &t.rig, moved);
            e[k] = moved[0].error;
        }
        CHECK_NEAR(coupled_rate(&row, &p), difference(e, TICK), 1e-8);
    }
}

TEST(couplings_refuse_what_they_cannot_couple)
{
    Dice d = {25};
    Pair p;
    pair_make(&p, &d, "hinge", "slider");
    Joint t = couple("gear", &p);
    check_refused(&t, "b is slider, must be a hinge");
    t = couple("rack", &p);
    set(&t, "ratio", 0);
    check_refused(&t, "must not be 0");
    pair_make(&p, &d, "ball", "hinge");
    t = couple("rack", &p);
    set(&t, "ratio", 1);
    check_refused(&t, "a is ball, must be a hinge");
    pair_make(&p, &d, "hinge", "hinge");
    t = couple("gear", &p);
    set_range(&t, "ratio", 0, 1);
    check_refused(&t, "ratio[1] = 0, must not be 0");
    t = couple("gear", &p);
    t.other[1] = t.other[0];
    check_refused(&t, "the same joint");
    t.other[1] = NULL;
    check_refused(&t, "b is no joint");
    Row rows[JOINT_SLOTS];
    CHECK_INT(rows_of(&t, &t.rig, rows), 0);
}

TEST(the_world_has_no_part_in_a_coupled_row)
{
    Dice d = {26};
    Pair p;
    Row rows[JOINT_SLOTS];
    p.first = joint_make("hinge", &d, true);
    p.second = joint_make("hinge", &d, true);
    p.second.rig.body[0] = 1;
    pair_look(&p);
    Joint t = couple("gear", &p);
    CHECK_INT(rows_of(&t, &t.rig, rows), 1);
    CHECK_INT(rows[0].count, 2);
    CHECK_INT(rows[0].body[0], 0);
    CHECK_INT(rows[0].body[1], 1);
}

/* ---- wheel and motor --------------------------------------------------------------------------- */

TEST(a_wheel_travels_along_its_axis_and_spins_about_the_other)
{
    Joint t = simple("wheel");                      /* suspension along z */
    vec3 x = {1, 0, 0};
    memcpy(field(&t, "spin_axis"), &x, sizeof x);
    set_range(&t, "limits", -0.1, 0.1);
    set(&t, "spring.stiffness", 100);
    set(&t, "motor.speed", 5);
    set(&t, "motor.max_torque", 9);
    Row rows[JOINT_SLOTS];
    rows_of(&t, &t.rig, rows);
    t.rig.v[0] = (vec3){0, 0, 1};
    t.rig.w[0] = (vec3){3, 0, 0};
    for (int i = 1; i <= 50; i++) {
        Rig g = rig_after(&t.rig, 0.1 * i);         /* 15 rad, 5 m */
        CHECK_NEAR(coordinate_at(&t, &g), 0.3 * i, 1e-12);
        int count = rows_of(&t, &g, rows);
        JointView j = view_of(&t, &g);
        CHECK_INT(count, 4 + 2 + 1 + 1);
        for (int r = 0; r < 4; r++) {
            CHECK_NEAR(rows[r].error, 0, 1e-14);
            CHECK_NEAR(joint_rate(&j, &rows[r]), 0, 1e-14);
        }
        CHECK_NEAR(row_of(rows, count, ROW_SOFT)->error, 0.1 * i, 1e-14);
        CHECK_NEAR(joint_rate(&j, row_of(rows, count, ROW_SOFT)), 1, 1e-14);
        CHECK_NEAR(joint_rate(&j, row_of(rows, count, ROW_MOTOR)), 3, 1e-14);
        CHECK_NEAR(t.type->speed(&j), 3, 1e-14);
        CHECK_NEAR(t.type->energy(&j), 0.5 * 100 * 0.01 * i * i, 1e-11);
        CHECK(t.type->at_limit(&j));
    }
}

TEST(a_wheel_that_tilts_or_turns_breaks_its_hard_rows)
{
    Joint t = simple("wheel");
    vec3 x = {1, 0, 0}, turns[2] = {{0, 1, 0}, {0, 0, 1}};
    memcpy(field(&t, "spin_axis"), &x, sizeof x);
    for (int i = 0; i < 2; i++) {
        Row rows[JOINT_SLOTS];
        t.rig.w[0] = turns[i];
        rows_of(&t, &t.rig, rows);
        JointView j = view_of(&t, &t.rig);
        CHECK_NEAR(hypot(joint_rate(&j, &rows[2]), joint_rate(&j, &rows[3])), 1, 1e-14);
    }
}

/* A skew spin axis: after any time of pure spin about it, no hard row is broken. */
TEST(a_wheel_keeps_its_spin_axis_in_both_bodies)
{
    Dice d = {27};
    for (int i = 0; i < TRIES; i++) {
        Joint t = joint_make("wheel", &d, true);
        Rig *g = &t.rig;
        vec3 spin = vec3_unit(dice_vec(&d)), r = quat_rotate(g->q[0], g->anchor[0]), at = vec3_add(g->x[0], r);
        Row rows[JOINT_SLOTS];
        memcpy(field(&t, "spin_axis"), &spin, sizeof spin);
        rows_of(&t, g, rows);
        quat turn = quat_axis_angle(spin, 2.5);
        g->q[0] = quat_mul(turn, g->q[0]);
        g->x[0] = vec3_sub(at, quat_rotate(turn, r));
        g->w[0] = vec3_scale(3, spin);
        g->v[0] = vec3_neg(vec3_cross(g->w[0], quat_rotate(turn, r)));
        JointView j = view_of(&t, g);
        CHECK_INT(rows_of(&t, g, rows), 4);
        for (int k = 0; k < 4; k++) {
            CHECK_NEAR(rows[k].error, 0, 1e-14);
            CHECK_NEAR(joint_rate(&j, &rows[k]), 0, 1e-13);
        }
        CHECK_NEAR(coordinate_at(&t, g), 2.5, 1e-13);
    }
}

TEST(a_motor_drives_a_against_b_and_holds_nothing)
{
    Joint t = simple("motor");
    set(&t, "speed", -4);
    set(&t, "max_torque", 2);
    Row rows[JOINT_SLOTS];
    CHECK_INT(rows_of(&t, &t.rig, rows), 1);
    CHECK(rows[0].kind == ROW_MOTOR && rows[0].rate == -4 && rows[0].hi == 2 && rows[0].angular);
    CHECK_NEAR(rows[0].ang[0].z, 1, 1e-15);
    CHECK_NEAR(vec3_length(rows[0].lin[0]), 0, 0);
}

TEST(a_motor_counts_the_turns_it_makes)
{
    Joint t = simple("motor");
    Row rows[JOINT_SLOTS];
    set(&t, "speed", 1);
    for (int i = 0; i <= 40; i++) {
        t.rig.q[0] = quat_axis_angle((vec3){0, 0, 1}, 0.5 * i);
        rows_of(&t, &t.rig, rows);
        CHECK_NEAR(coordinate_at(&t, &t.rig), 0.5 * i, 1e-12);
    }
}

int main(void)
{
    RUN_TESTS(unit_test(gears_turn_as_their_numbers_say_whatever_their_frame_does),
              unit_test(a_gear_keeps_the_phase_of_its_creation_over_turns_and_new_ratios),
              unit_test(a_rack_moves_by_the_radius_of_its_pinion), unit_test(a_coupled_row_has_the_rate_of_its_error),
              unit_test(couplings_refuse_what_they_cannot_couple), unit_test(the_world_has_no_part_in_a_coupled_row),
              unit_test(a_wheel_travels_along_its_axis_and_spins_about_the_other),
              unit_test(a_wheel_that_tilts_or_turns_breaks_its_hard_rows), unit_test(a_wheel_keeps_its_spin_axis_in_both_bodies),
              unit_test(a_motor_drives_a_against_b_and_holds_nothing), unit_test(a_motor_counts_the_turns_it_makes));
}
