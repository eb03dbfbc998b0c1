/* test_row_drift.c - every row of every joint type: its drift is what its rate gains along a motion without accelerations.
 *
 * The reference is the fourth-order central difference of the rate along x += v s, q = exp(w s) q with v and w constant, the rows
 * written anew at each pose. Left out, as there is no such difference: rows whose direction is a convention of one pose, the
 * distance of ends that coincide and the swing of opposite axes; these are held against the motion of a direction fixed in b.
 */
#include "joint_fixture.h"

enum { TRIES = 40, BODIES = 3 };

static const real disturbances[] = {0, 0.02, 0.3, 1.2};     /* m and rad: on the constraint manifold, near it and far from it */
enum { NEARNESSES = sizeof disturbances / sizeof *disturbances };

/* m/s and rad/s, by body */
typedef struct Motion { vec3 v[BODIES], w[BODIES]; } Motion;

static real rate_of(const Row *r, const Motion *m)
{
    real rate = 0;
    for (int i = 0; i < r->count; i++)
        if (r->body[i] >= 0)
            rate += vec3_dot(r->lin[i], m->v[r->body[i]]) + vec3_dot(r->ang[i], m->w[r->body[i]]);
    return rate;
}

static Motion motion_of(const Rig *g)
{
    Motion m = {{vec3_zero()}, {vec3_zero()}};
    for (int i = 0; i < 2; i++)
        if (g->body[i] >= 0) {
            m.v[g->body[i]] = g->v[i];
            m.w[g->body[i]] = g->w[i];
        }
    return m;
}

/* The row of the same slot and kind. */
static const Row *same_row(const Row *like, const Row *rows, int count)
{
    for (int i = 0; i < count; i++)
        if (rows[i].slot == like->slot && rows[i].kind == like->kind)
            return &rows[i];
    fail_msg("slot %d is gone after a tick", like->slot);
    return NULL;
}

static void check_drift(const char *name, const Row *r, const real f[4], real tick)
{
    real want = difference(f, tick);
    if (!(fabs(r->drift - want) <= 1e-8 * (1 + fabs(want))))
        fail_msg("%s, slot %d, kind %d: drift = %.17g, want %.17g (off by %g)", name, r->slot, (int)r->kind, r->drift, want,
                 r->drift - want);
}

/* The direction of a length turns as 1 / length, that of a swing as 1 / swing: ticks shrink in proportion. */
static real tick_of(Joint *t)
{
    JointView j = view_of(t, &t->rig);
    real swing = vec3_length(vec3_cross(j.a.axis, j.b.axis)), pole = 1;
    if (t->type->two_anchors)
        pole = vec3_distance(j.a.p, j.b.p);
    else if (has(t->type, "swing") && swing > 1e-9)
        pole = swing;
    return TICK * real_min(pole, 1);
}

/* Checks all rows at the joint's present pose; marks the slots it saw; returns the largest drift. */
static real check_joint(Joint *t, unsigned *seen)
{
    Row rows[JOINT_SLOTS], then[4][JOINT_SLOTS];
    Motion m = motion_of(&t->rig);
    int count = rows_of(t, &t->rig, rows), counts[4];
    real tick = tick_of(t), largest = 0;
    for (int k = 0; k < 4; k++) {
        Rig moved = rig_after(&t->rig, ticks[k] / TICK * tick);
        counts[k] = rows_of(t, &moved, then[k]);
    }
    for (int i = 0; i < count; i++) {
        real f[4];
        for (int k = 0; k < 4; k++)
            f[k] = rate_of(same_row(&rows[i], then[k], counts[k]), &m);
        check_drift(t->type->name, &rows[i], f, tick);
        largest = real_max(largest, fabs(rows[i].drift));
        *seen |= 1u << rows[i].slot;
    }
    return largest;
}

/* ---- types that join two bodies -------------------------------------------------------- */

/* Everything a type has is switched on; the variant chooses where a parameter makes other rows. */
static void all_on(Joint *t, bool variant)
{
    const JointType *type = t->type;
    switch_on(t);
    if (variant && has(type, "keeps")) {            /* flat: the rows that a line has not */
        int64_t flat = 3;
        memcpy(field(t, "keeps"), &flat, sizeof flat);
    }
    if (variant && strcmp(type->name, "spring") == 0)          /* a spring of no length: three rows */
        set(t, "length", 0);
    if (variant && has(type, "min")) {              /* a range of distances: two stops   */
        set(t, "length", NAN);
        set(t, "min", 0.2);
        set(t, "max", 1.5);
    }
}

/* Slots each type fills, over both variants. */
static const struct { const char *name; int slots; } all_slots[] = {
    {"hinge", 10}, {"slider", 10}, {"ball", 9}, {"weld", 6}, {"distance", 3}, {"rope", 1}, {"spring", 3}, {"wheel", 9}, {"bolt", 6},
    {"motor", 1}, {"strut", 1}, {"beam", 6}, {"guide", 4},
};
enum { TYPES = sizeof all_slots / sizeof *all_slots };

static int bits(unsigned x)
{
    int n = 0;
    for (; x; x &= x - 1)
        n++;
    return n;
}

TEST(the_list_of_this_test_has_every_type_that_joins_bodies)
{
    int n = 0;
    for (int i = 0; joint_types[i]; i++)
        if (!joint_types[i]->couples)
            CHECK_TEXT(joint_types[i]->name, all_slots[n++].name);
    CHECK_INT(n, TYPES);
}

TEST(the_drift_of_every_row_is_what_its_rate_gains_without_accelerations)
{
    Dice d = {31};
    for (int i = 0; i < TYPES; i++) {
        unsigned seen = 0;
        real largest = 0;
        for (int k = 0; k < TRIES * NEARNESSES; k++) {
            Joint t = joint_make(all_slots[i].name, &d, k / 8 % 2);
            all_on(&t, k / 4 % 2);
            Row rows[JOINT_SLOTS];
            rows_of(&t, &t.rig, rows);              /* the wheel takes down its axis */
            rig_disturb(&t.rig, &d, disturbances[k % 4]);
            largest = real_max(largest, check_joint(&t, &seen));
        }
        CHECK_INT(bits(seen), all_slots[i].slots);
        CHECK(largest > 1);
    }
}

/* On the constraint manifold in velocity too: a turns about the axis of a hinge whose frame b turns itself. */
TEST(the_drift_holds_for_velocities_that_keep_the_joint)
{
    Dice d = {32};
    for (int k = 0; k < TRIES; k++) {
        Joint t = joint_make("hinge", &d, k % 4 == 0);
        Rig *g = &t.rig;
        JointEnd a = rig_end(g, 0), b = rig_end(g, 1);
        g->w[0] = vec3_mad(g->w[1], 3 * dice(&d), b.axis);
        g->v[0] = vec3_sub(vec3_add(g->v[1], vec3_cross(g->w[1], b.r)), vec3_cross(g->w[0], a.r));
        Row rows[JOINT_SLOTS];
        Motion m = motion_of(g);
        int count = rows_of(&t, g, rows);
        for (int i = 0; i < count; i++)
            CHECK_NEAR(rate_of(&rows[i], &m), 0, 1e-13);
        unsigned seen = 0;
        check_joint(&t, &seen);
        CHECK_INT(bits(seen), 5);
    }
}

/* Below 1e-3 rad/s the friction of a ball joint takes the frame of b. */
TEST(a_ball_that_hardly_turns_has_friction_along_a_frame_that_turns_with_b)
{
    Dice d = {33};
    real largest = 0;
    for (int k = 0; k < TRIES; k++) {
        Joint t = joint_make("ball", &d, false);
        set(&t, "friction", 3);
        rig_disturb(&t.rig, &d, 0.3);
        t.rig.w[0] = vec3_mad(t.rig.w[1], 5e-4, dice_vec(&d));
        unsigned seen = 0;
        check_joint(&t, &seen);
        CHECK_INT(bits(seen), 6);
        Row rows[JOINT_SLOTS];
        int count = rows_of(&t, &t.rig, rows);
        for (int i = 0; i < count; i++)
            if (rows[i].kind == ROW_DRY)
                largest = real_max(largest, fabs(rows[i].drift));
    }
    CHECK(largest > 1e-4);
}

/* Known by hand: a point that goes round at speed v on a radius r keeps its length only with v^2 / r towards the middle. */
TEST(a_length_across_a_velocity_drifts_by_the_centripetal_acceleration)
{
    Joint t = simple("distance");
    t.rig.x[0] = (vec3){0, 0, 0.5};
    t.rig.v[0] = (vec3){3, 0, 0};
    set(&t, "length", 0.5);
    Row rows[JOINT_SLOTS];
    CHECK_INT(rows_of(&t, &t.rig, rows), 1);
    CHECK_NEAR(rows[0].drift, 9 / 0.5, 1e-14);
}

/* ---- gears and racks ------------------------------------------------------------------------ */

/* Two joints between bodies 0 and 1 and their common frame, body 2, or the world. */
typedef struct Pair { Joint joint[2]; JointView view[2]; } Pair;

static void pair_look(Pair *p)
{
    for (int i = 0; i < 2; i++)
        p->view[i] = view_of(&p->joint[i], &p->joint[i].rig);
}

static void pair_make(Pair *p, Dice *d, const char *const names[2], bool bound, real by)
{
    for (int i = 0; i < 2; i++) {
        p->joint[i] = joint_make(names[i], d, bound);
        p->joint[i].rig.body[0] = i;
        p->joint[i].rig.body[1] = bound ? -1 : 2;
    }
    Rig *a = &p->joint[0].rig, *b = &p->joint[1].rig;
    b->x[1] = a->x[1];
    b->q[1] = a->q[1];
    b->v[1] = a->v[1];
    b->w[1] = a->w[1];
    vec3 at = dice_vec(d), both[2] = {at, at};
    rig_join(b, both, dice_quat(d));
    for (int i = 0; i < 2; i++)
        rig_disturb(&p->joint[i].rig, d, by);
    pair_look(p);
}

static Motion motion_of_pair(const Pair *p)
{
    Motion m = motion_of(&p->joint[0].rig), n = motion_of(&p->joint[1].rig);
    m.v[1] = n.v[1];
    m.w[1] = n.w[1];
    return m;
}

static real coupled_rate_after(Joint *t, const Pair *p, real time)
{
    Pair then = *p;
    Row rows[JOINT_SLOTS];
    for (int i = 0; i < 2; i++)
        then.joint[i].rig = rig_after(&p->joint[i].rig, time);
    pair_look(&then);
    t->other[0] = &then.view[0];
    t->other[1] = &then.view[1];
    Motion m = motion_of_pair(p);
    CHECK_INT(rows_of(t, &t->rig, rows), 1);
    return rate_of(&rows[0], &m);
}

TEST(the_drift_of_a_coupled_row_is_what_its_rate_gains_without_accelerations)
{
    static const char *const cases[][3] = {{"gear", "hinge", "hinge"}, {"rack", "hinge", "slider"}, {"gear", "wheel", "hinge"}};
    Dice d = {34};
    for (int i = 0; i < 3; i++) {
        real largest = 0;
        for (int k = 0; k < TRIES * NEARNESSES; k++) {
            Pair p;
            Row rows[JOINT_SLOTS];
            real f[4];
            pair_make(&p, &d, &cases[i][1], k / 4 % 2, disturbances[k % 4]);
            Joint t = {.type = type_of(cases[i][0]), .other = {&p.view[0], &p.view[1]}};
            param_defaults(t.type->params, t.params);
            if (i == 1)
                set(&t, "ratio", 0.3);
            else
                set_range(&t, "ratio", 2, -3);
            CHECK_INT(rows_of(&t, &t.rig, rows), 1);
            for (int n = 0; n < 4; n++)
                f[n] = coupled_rate_after(&t, &p, ticks[n]);
            check_drift(cases[i][0], &rows[0], f, TICK);
            largest = real_max(largest, fabs(rows[0].drift));
        }
        CHECK(largest > 1);
    }
}

/* ---- directions by convention ------------------------------------------------------------------ */

/* Differences of the rate along a direction fixed in b, for a row that has b's axis d at this pose: a translation row on the
 * anchors, or a spin row. */
static real drift_fixed_in_b(const Rig *g, vec3 d, bool angular)
{
    real f[4];
    vec3 local = quat_unrotate(g->q[1], d);
    for (int k = 0; k < 4; k++) {
        Rig moved = rig_after(g, ticks[k]);
        JointEnd a = rig_end(&moved, 0), b = rig_end(&moved, 1);
        vec3 now = quat_rotate(moved.q[1], local);
        vec3 slide = vec3_sub(vec3_add(a.v, vec3_cross(a.w, a.r)), vec3_add(b.v, vec3_cross(b.w, vec3_sub(a.p, b.x))));
        f[k] = vec3_dot(now, angular ? vec3_sub(a.w, b.w) : slide);
    }
    return difference(f, TICK);
}

TEST(ends_of_a_distance_that_coincide_part_along_a_direction_fixed_in_b)
{
    Dice d = {35};
    for (int k = 0; k < TRIES; k++) {
        Joint t = joint_make("distance", &d, k % 2);
        JointEnd b = rig_end(&t.rig, 1);
        Row rows[JOINT_SLOTS];
        t.rig.anchor[0] = vec3_zero();
        t.rig.x[0] = b.p;                           /* the centre of a, without rounding */
        CHECK_INT(rows_of(&t, &t.rig, rows), 1);
        CHECK_NEAR(vec3_distance(rows[0].lin[0], b.axis), 0, 1e-15);
        CHECK_NEAR(rows[0].drift, drift_fixed_in_b(&t.rig, b.axis, false), 1e-8);
    }
}

/* Frames half a turn apart about u: exact in binary, so that the axes are exactly opposite. */
TEST(opposite_axes_of_a_ball_joint_swing_and_twist_about_directions_fixed_in_b)
{
    Dice d = {36};
    for (int k = 0; k < TRIES; k++) {
        Joint t = simple("ball");
        Rig *g = &t.rig;
        g->body[1] = 1;
        g->frame[0] = (quat){.y = 1};
        g->frame[1] = quat_identity();
        set(&t, "swing", 0.5);
        set_range(&t, "twist", -0.4, 0.3);
        for (int i = 0; i < 2; i++) {
            g->v[i] = dice_vec(&d);
            g->w[i] = dice_vec(&d);
        }
        Row rows[JOINT_SLOTS];
        CHECK_INT(rows_of(&t, g, rows), 6);         /* point 3, swing 1, twist 2 */
        CHECK_NEAR(rows[3].drift, -drift_fixed_in_b(g, (vec3){0, 1, 0}, true), 1e-8);
        CHECK_NEAR(rows[4].drift, drift_fixed_in_b(g, (vec3){1, 0, 0}, true), 1e-8);
        CHECK_NEAR(rows[5].drift, -drift_fixed_in_b(g, (vec3){1, 0, 0}, true), 1e-8);
    }
}

int main(void)
{
    RUN_TESTS(unit_test(the_list_of_this_test_has_every_type_that_joins_bodies),
              unit_test(the_drift_of_every_row_is_what_its_rate_gains_without_accelerations),
              unit_test(the_drift_holds_for_velocities_that_keep_the_joint),
              unit_test(a_ball_that_hardly_turns_has_friction_along_a_frame_that_turns_with_b),
              unit_test(a_length_across_a_velocity_drifts_by_the_centripetal_acceleration),
              unit_test(the_drift_of_a_coupled_row_is_what_its_rate_gains_without_accelerations),
              unit_test(ends_of_a_distance_that_coincide_part_along_a_direction_fixed_in_b),
              unit_test(opposite_axes_of_a_ball_joint_swing_and_twist_about_directions_fixed_in_b));
}
