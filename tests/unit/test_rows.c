/* test_rows.c - the parts of joints: rates against differences of errors, momentum, angles over turns, limits, couplings. */
#include "joint_fixture.h"

enum { TRIES = 200 };

typedef void Build(RowList *list, const JointView *j);

static void build_point(RowList *list, const JointView *j) { rows_point(list, j, 0); }
static void build_along(RowList *list, const JointView *j) { rows_along(list, j, vec3_unit(vec3_add(j->b.u, j->b.axis)), 0); }
static void build_parallel(RowList *list, const JointView *j) { rows_parallel(list, j, 0); }
static void build_aligned(RowList *list, const JointView *j) { rows_aligned(list, j, 0); }

static void build_length(RowList *list, const JointView *j)
{
    real length;
    Row *r = rows_length(list, j, ROW_HARD, &length, 0);
    if (r)
        r->error = length;
}

static void build_twist(RowList *list, const JointView *j)
{
    real memory = 0;
    rows_twist(list, j, ROW_HARD, 0)->error = joint_angle(j, &memory);
}

static void build_limits(RowList *list, const JointView *j)
{
    Row like;
    RowList one = {&like, 0, 1};
    rows_translation(&one, j, ROW_SOFT, j->b.n, 0);
    rows_limits(list, &like, like.error, -0.5, 0.75, 0);
}

static Build *const builders[] = {build_point, build_along, build_parallel, build_aligned, build_length, build_twist, build_limits};
enum { BUILDERS = sizeof builders / sizeof *builders };

static int build_rows(Build *build, const Rig *g, Row rows[JOINT_SLOTS])
{
    RowList list = {rows, 0, JOINT_SLOTS};
    JointView j = {.a = rig_end(g, 0), .b = rig_end(g, 1)};
    build(&list, &j);
    return list.count;
}

static void check_rates(Build *build, const Rig *g)
{
    Row rows[JOINT_SLOTS], then[4][JOINT_SLOTS];
    int count = build_rows(build, g, rows);
    JointView j = {.a = rig_end(g, 0), .b = rig_end(g, 1)};
    for (int k = 0; k < 4; k++) {
        Rig moved = rig_after(g, ticks[k]);
        CHECK_INT(build_rows(build, &moved, then[k]), count);
    }
    for (int i = 0; i < count; i++) {
        real f[4] = {then[0][i].error, then[1][i].error, then[2][i].error, then[3][i].error};
        real want = difference(f, TICK), got = joint_rate(&j, &rows[i]);
        CHECK_NEAR(got, want, 1e-9 * (1 + fabs(want)));
    }
}

TEST(every_rate_is_the_derivative_of_its_error)
{
    Dice d = {1};
    for (int k = 0; k < BUILDERS; k++)
        for (int i = 0; i < TRIES; i++) {
            Rig g = rig_make(&d, i % 3 == 0);
            rig_disturb(&g, &d, 0.8);
            check_rates(builders[k], &g);
        }
}

TEST(no_row_makes_momentum)
{
    Dice d = {2};
    for (int k = 0; k < BUILDERS; k++)
        for (int i = 0; i < TRIES; i++) {
            Row rows[JOINT_SLOTS];
            Rig g = rig_make(&d, false);
            rig_disturb(&g, &d, 0.8);
            int count = build_rows(builders[k], &g, rows);
            CHECK(count > 0);
            for (int m = 0; m < count; m++) {
                vec3 p = vec3_zero(), l = vec3_zero();
                for (int b = 0; b < rows[m].count; b++) {
                    p = vec3_add(p, rows[m].lin[b]);
                    l = vec3_add(l, vec3_add(vec3_cross(g.x[rows[m].body[b]], rows[m].lin[b]), rows[m].ang[b]));
                }
                CHECK_NEAR(vec3_length(p), 0, 1e-15);
                CHECK_NEAR(vec3_length(l), 0, 1e-14);
            }
        }
}

TEST(every_error_but_of_limits_and_lengths_is_zero_at_creation)
{
    Dice d = {3};
    Build *const exact[] = {build_point, build_along, build_parallel, build_aligned, build_twist};
    for (size_t k = 0; k < sizeof exact / sizeof *exact; k++)
        for (int i = 0; i < TRIES; i++) {
            Row rows[JOINT_SLOTS];
            Rig g = rig_make(&d, i % 2 == 0);
            int count = build_rows(exact[k], &g, rows);
            for (int m = 0; m < count; m++)
                CHECK_NEAR(rows[m].error, 0, 2e-15);
        }
}

/* The twist of the relative rotation q = (x, y, z, w) about the x axis is 2 atan2(x, w). */
TEST(the_angle_is_the_twist_of_the_relative_rotation)
{
    Dice d = {4};
    for (int i = 0; i < TRIES; i++) {
        Rig g = rig_make(&d, false);
        rig_disturb(&g, &d, 1.2);
        JointView j = {.a = rig_end(&g, 0), .b = rig_end(&g, 1)};
        quat fa = quat_mul(g.q[0], g.frame[0]), fb = quat_mul(g.q[1], g.frame[1]);
        quat q = quat_mul(quat_conjugate(fb), fa);
        real memory = 0, want = remainder(2 * atan2(q.x, q.w), 2 * DIG_PI);
        CHECK_NEAR(joint_angle(&j, &memory), want, 1e-13);
        CHECK_NEAR(memory, want, 1e-13);
    }
}

TEST(the_angle_counts_turns_both_ways)
{
    Dice d = {5};
    Rig g = rig_make(&d, true);
    JointView j = {.a = rig_end(&g, 0), .b = rig_end(&g, 1)};
    vec3 axis = j.b.axis;
    quat start = g.q[0];
    real memory = 0;
    for (int i = -400; i <= 400; i++) {
        real want = i <= 0 ? 0.11 * (i + 400) : 0.11 * (400 - 2 * i);      /* 44 rad there, then 88 rad back */
        g.q[0] = quat_mul(quat_axis_angle(axis, want), start);
        j.a = rig_end(&g, 0);
        CHECK_NEAR(joint_angle(&j, &memory), want, 1e-12);
    }
    CHECK_NEAR(memory, -44, 1e-12);
}

TEST(opposite_axes_give_a_finite_twist)
{
    JointView j = {.a = {.axis = {-1, 0, 0}, .u = {0, 1, 0}, .n = {0, 0, -1}}, .b = {.axis = {1, 0, 0}, .u = {0, 1, 0}, .n = {0, 0, 1}}};
    real memory = 0;
    CHECK(isfinite(joint_angle(&j, &memory)));
    CHECK_NEAR(vec3_length(joint_twist(&j)), 1, 1e-15);
}

TEST(ends_that_coincide_have_no_length)
{
    Dice d = {6};
    Rig g = rig_make(&d, true);
    JointView j = {.a = rig_end(&g, 0), .b = rig_end(&g, 1)};
    j.a.p = j.b.p;
    Row r;
    RowList list = {&r, 0, 1};
    real length = -1;
    CHECK(rows_length(&list, &j, ROW_HARD, &length, 0) == NULL);
    CHECK_INT(list.count, 0);
    CHECK_NEAR(length, 0, 0);
}

/* One body of mass 1 on a line at x with velocity v: an impulse of 1 changes v by the Jacobian. */
TEST(the_impulse_of_a_limit_drives_away_from_its_stop)
{
    JointEnd end = {.axis = {1, 0, 0}, .u = {0, 1, 0}, .n = {0, 0, 1}};
    JointView j = {.a = end, .b = end};
    j.b.body = -1;
    j.a.p = j.a.x = (vec3){0.3, 0, 0};
    Row like, rows[2];
    RowList one = {&like, 0, 1}, list = {rows, 0, 2};
    rows_translation(&one, &j, ROW_SOFT, j.b.axis, 0);
    rows_limits(&list, &like, like.error, 0.1, 0.25, 4);
    CHECK_INT(list.count, 2);
    CHECK_NEAR(rows[0].error, 0.2, 1e-15);      /* free by 0.2 m below  */
    CHECK_NEAR(rows[1].error, -0.05, 1e-15);    /* past the upper stop  */
    CHECK_NEAR(rows[0].lin[0].x, 1, 0);
    CHECK_NEAR(rows[1].lin[0].x, -1, 0);
    CHECK_INT(rows[0].slot, 4);
    CHECK_INT(rows[1].slot, 5);
    CHECK(rows[0].kind == ROW_LIMIT && rows[1].kind == ROW_LIMIT);
}

TEST(bounds_that_are_infinite_or_missing_make_no_rows)
{
    Row like = {.count = 2}, rows[2];
    RowList list = {rows, 0, 2};
    rows_limits(&list, &like, 0, -INFINITY, INFINITY, 0);
    rows_limits(&list, &like, 0, NAN, NAN, 0);
    CHECK_INT(list.count, 0);
    rows_limits(&list, &like, 0, NAN, 1, 0);
    CHECK_INT(list.count, 1);
    CHECK_INT(rows[0].slot, 1);
}

TEST(a_drive_that_is_off_adds_no_row_and_one_that_is_on_all_of_its_own)
{
    Row like = {.count = 2, .lin = {{1, 0, 0}, {-1, 0, 0}}}, rows[JOINT_SLOTS];
    RowList list = {rows, 0, JOINT_SLOTS};
    Drive off = {{NAN, NAN}, {NAN, INFINITY}, {0, 0, 0}, 0}, on = {{-1, 2}, {3, 4}, {5, 6, 7}, 8};
    rows_drive(&list, &like, 0.5, &off, 0);
    off.motor = (DriveMotor){1, 0};
    off.friction = NAN;
    rows_drive(&list, &like, 0.5, &off, 0);
    CHECK_INT(list.count, 0);
    rows_drive(&list, &like, 0.5, &on, 3);
    CHECK_INT(list.count, 5);
    for (int i = 0; i < 5; i++)
        CHECK_INT(rows[i].slot, 3 + i);
    CHECK(rows[2].kind == ROW_MOTOR && rows[2].rate == 3 && rows[2].hi == 4);
    CHECK(rows[3].kind == ROW_SOFT && rows[3].stiffness == 5 && rows[3].damping == 6 && rows[3].error == 0.5 - 7);
    CHECK(rows[4].kind == ROW_DRY && rows[4].hi == 8);
    CHECK_NEAR(spring_energy(&on.spring, 0.5), 0.5 * 5 * 6.5 * 6.5, 1e-12);
}

TEST(a_stop_is_felt_within_a_tenth_of_a_millimetre)
{
    CHECK(at_limits(1.00005, 1, 2) && at_limits(1.99995, 1, 2) && at_limits(2.5, 1, 2) && at_limits(0, 1, 2));
    CHECK(!at_limits(1.001, 1, 2) && !at_limits(1.5, NAN, NAN) && !at_limits(1e9, -INFINITY, INFINITY));
}

int main(void)
{
    RUN_TESTS(unit_test(every_rate_is_the_derivative_of_its_error), unit_test(no_row_makes_momentum),
              unit_test(every_error_but_of_limits_and_lengths_is_zero_at_creation),
              unit_test(the_angle_is_the_twist_of_the_relative_rotation), unit_test(the_angle_counts_turns_both_ways),
              unit_test(opposite_axes_give_a_finite_twist), unit_test(ends_that_coincide_have_no_length),
              unit_test(the_impulse_of_a_limit_drives_away_from_its_stop),
              unit_test(bounds_that_are_infinite_or_missing_make_no_rows),
              unit_test(a_drive_that_is_off_adds_no_row_and_one_that_is_on_all_of_its_own),
              unit_test(a_stop_is_felt_within_a_tenth_of_a_millimetre));
}
