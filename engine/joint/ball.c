/* joint/ball.c - the ball joint: a turns freely against b about one point; a cone and a range of twist may bound it.
 *
 * The swing is the angle between the axes of a and b, the twist what is left after the shortest rotation that makes the axes
 * parallel.
 */
#include "solve/joint_type.h"

enum { POINT = 0, SWING = 3, TWIST = 5, FRICTION = 7 };         /* slots */

typedef struct Ball {
    real swing;         /* rad  half angle of the cone; NaN = none */
    real twist[2];      /* rad  NaN = none                         */
    real friction;      /* N m                                     */
} Ball;

static const dig_param ball_rows[] = {
    {.name = "swing", .kind = DIG_REAL, .unit = "rad", .doc = "greatest angle between the axes of a and b", .fallback = NAN,
     .min = 1e-3, .max = DIG_PI, .offset = offsetof(Ball, swing)},
    {.name = "twist", .kind = DIG_RANGE, .unit = "rad", .doc = "least and greatest twist of a about its axis", .fallback = NAN,
     .min = -INFINITY, .max = INFINITY, .offset = offsetof(Ball, twist)},
    {.name = "friction", .kind = DIG_REAL, .unit = "N*m", .doc = "dry friction torque", .min = 0, .max = 1e12,
     .offset = offsetof(Ball, friction)},
    {.name = NULL},
};

/* rad in [0, pi], exact at both ends */
static real swing_of(const JointView *j)
{
    return atan2(vec3_length(vec3_cross(j->b.axis, j->a.axis)), vec3_dot(j->b.axis, j->a.axis));
}

static real twist_of(const JointView *j)
{
    real last = j->memory[0];
    return joint_angle(j, &last);
}

#define STRAIGHT 1e-9           /* rad  less swing has no direction */

/* The swing grows with the spin of a about d = D / |D|, D = eb x ea.
 *   dD/dt = (wb x eb) x ea + eb x (wa x ea),   dd/dt = (dD/dt - (d . dD/dt) d) / |D|
 * With opposite axes |D| = 0, and any direction normal to them will do: one fixed in b. */
static Row *swing_row(const JointView *j, RowList *one, vec3 d, vec3 across)
{
    vec3 ea = j->a.axis, eb = j->b.axis;
    vec3 turn = vec3_add(vec3_cross(vec3_cross(j->b.w, eb), ea), vec3_cross(eb, vec3_cross(j->a.w, ea)));
    real size = vec3_dot(d, across);
    Row *r = rows_spin(one, j, ROW_SOFT, d, SWING);
    row_turns(r, j, size > 0 ? vec3_scale(1 / size, vec3_mad(turn, -vec3_dot(d, turn), d)) : vec3_cross(j->b.w, d));
    return r;
}

/* Without swing it has no direction, and no stop is near now. But one may be before rows are asked for again: then it is that of the spin. */
static void add_swing(const JointView *j, const Ball *ball, RowList *out)
{
    Row like;
    RowList one = {&like, 0, 1};
    real swing = swing_of(j);
    if (isnan(ball->swing) || !(swing > STRAIGHT || j->followed || j->swept))
        return;
    vec3 ea = j->a.axis, across = vec3_cross(j->b.axis, ea), spin = vec3_sub(j->a.w, j->b.w);
    spin = vec3_mad(spin, -vec3_dot(spin, ea), ea);
    swing_row(j, &one, vec3_unit_or(swing > STRAIGHT ? across : spin, j->b.u), across);
    rows_limits(out, &like, swing, NAN, ball->swing, SWING);
}

/* The first of the three rows lies along the present spin, so that the torque of a turning ball is the one given in every
 * direction, not up to sqrt(3) times as much. Without accelerations that spin keeps its direction, and with it all three rows:
 * their drift is 0. A ball that hardly turns takes the frame of b instead, which turns with b.
 *
 * Where the motion is followed, the first row is all there is: what lies across the spin would hold its direction, and a stop that turns
 * it would contradict. */
static void add_friction(const JointView *j, real friction, RowList *out)
{
    vec3 spin = vec3_sub(j->a.w, j->b.w), d[3] = {j->b.axis, j->b.u, j->b.n};
    if (!(friction > 0))
        return;
    bool turning = vec3_length2(spin) > 1e-6;
    if (turning) {
        d[0] = vec3_unit(spin);
        vec3_basis(d[0], &d[1], &d[2]);
    }
    for (int i = 0; i < (turning && j->followed ? 1 : 3); i++) {
        Row *r = rows_spin(out, j, ROW_DRY, d[i], FRICTION + i);
        r->hi = friction;
        row_turns(r, j, turning ? vec3_zero() : vec3_cross(j->b.w, d[i]));
    }
}

static void rows(const JointView *j, RowList *out)
{
    const Ball *ball = j->params;
    Row like;
    RowList one = {&like, 0, 1};
    rows_point(out, j, POINT);
    add_swing(j, ball, out);
    rows_twist(&one, j, ROW_SOFT, TWIST);
    rows_limits(out, &like, joint_angle(j, j->memory), ball->twist[0], ball->twist[1], TWIST);
    add_friction(j, ball->friction, out);
}

static bool only_point(const void *params)
{
    const Ball *ball = params;
    return isnan(ball->swing) && isnan(ball->twist[0]) && isnan(ball->twist[1]) && !(ball->friction > 0);
}

static bool at_limit(const JointView *j)
{
    const Ball *ball = j->params;
    bool cone = !isnan(ball->swing), range = !isnan(ball->twist[0]) || !isnan(ball->twist[1]);
    return (cone && at_limits(swing_of(j), NAN, ball->swing)) || (range && at_limits(twist_of(j), ball->twist[0], ball->twist[1]));
}

static real sways(const JointView *j, const real *force, vec3 couple, vec3 *across)
{
    vec3 axle = vec3_cross(j->b.axis, j->a.axis);
    real sine = vec3_length(axle);
    if (isnan(((const Ball *)j->params)->swing) || !(sine > STRAIGHT))
        return 0;
    *across = vec3_scale(1 / sine, vec3_cross(axle, j->a.axis));
    real pressed = real_max(force[SWING + 1], -vec3_dot(couple, axle) / sine);
    return real_max(0, pressed * vec3_dot(j->b.axis, j->a.axis) / sine);        /* over the tangent: none in a cone of a right angle */
}

const JointType joint_ball = {
    .name = "ball",
    .doc = "a turns freely against b about a point",
    .params = ball_rows,
    .params_size = sizeof(Ball),
    .free_axes = 3,
    .at_point = true,
    .lower_pair = true,
    .rows = rows,
    .only_point = only_point,
    .at_limit = at_limit,
    .sways = sways,
};
