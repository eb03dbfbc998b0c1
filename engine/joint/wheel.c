/* joint/wheel.c - the wheel: a (the wheel) moves against b (the chassis) along the axis of the suspension and spins about a
 * second axis.
 *
 * Two rows keep the anchor of a on the suspension's line, two keep the spin axes parallel; the travel and the angle of spin
 * are left. The coordinate is the angle of spin. memory: [0] that angle, [1..3] the spin axis in the joint frame, which both
 * bodies share at creation; it is taken down when the first rows are written.
 */
#include "solve/joint_type.h"

enum { LINE = 0, PARALLEL = 2, TRAVEL = 4, SPRING = 6, MOTOR = 7, FRICTION = 8 };       /* slots */

typedef struct Wheel {
    vec3        spin_axis;      /* world, at creation; NaN = the second axis of the frame */
    real        limits[2];      /* m, NaN = none             */
    DriveSpring spring;         /* N/m, N s/m, m             */
    DriveMotor  motor;          /* rad/s, N m                */
    real        friction;       /* N m                       */
} Wheel;

static const dig_param spring_rows[] = {
    {.name = "stiffness", .kind = DIG_REAL, .unit = "N/m", .doc = "force per travel", .min = 0, .max = 1e12,
     .offset = offsetof(DriveSpring, stiffness)},
    {.name = "damping", .kind = DIG_REAL, .unit = "N*s/m", .doc = "force per speed", .min = 0, .max = 1e12,
     .offset = offsetof(DriveSpring, damping)},
    {.name = "rest", .kind = DIG_REAL, .unit = "m", .doc = "travel without force", .min = -1e6, .max = 1e6,
     .offset = offsetof(DriveSpring, rest)},
    {.name = NULL},
};

static const dig_param motor_rows[] = {
    {.name = "speed", .kind = DIG_REAL, .unit = "rad/s", .doc = "speed wanted; not given = no motor", .fallback = NAN,
     .min = -1e6, .max = 1e6, .offset = offsetof(DriveMotor, speed)},
    {.name = "max_torque", .kind = DIG_REAL, .unit = "N*m", .doc = "greatest torque it gives; 0 = off, inf = more than anything takes", .fallback = INFINITY,
     .min = 0, .max = INFINITY, .offset = offsetof(DriveMotor, most)},
    {.name = NULL},
};

static const dig_param wheel_rows[] = {
    {.name = "spin_axis", .kind = DIG_DIR, .unit = "1", .doc = "axis it spins about; default at right angles to the suspension's",
     .fallback = NAN, .offset = offsetof(Wheel, spin_axis)},
    {.name = "limits", .kind = DIG_RANGE, .unit = "m", .doc = "least and greatest travel of a along the axis", .fallback = NAN,
     .min = -INFINITY, .max = INFINITY, .offset = offsetof(Wheel, limits)},
    {.name = "spring", .kind = DIG_TABLE, .unit = "", .doc = "the suspension's spring", .offset = offsetof(Wheel, spring),
     .rows = spring_rows},
    {.name = "motor", .kind = DIG_TABLE, .unit = "", .doc = "drives the spin", .offset = offsetof(Wheel, motor), .rows = motor_rows},
    {.name = "friction", .kind = DIG_REAL, .unit = "N*m", .doc = "dry friction torque of the spin", .min = 0, .max = 1e12,
     .offset = offsetof(Wheel, friction)},
    {.name = NULL},
};

/* Coordinates of the spin axis in the joint frame. */
static vec3 spin_local(const JointView *j)
{
    vec3 known = {j->memory[1], j->memory[2], j->memory[3]}, s = ((const Wheel *)j->params)->spin_axis;
    if (vec3_length2(known) > 0)
        return known;
    vec3 local = {vec3_dot(s, j->b.axis), vec3_dot(s, j->b.u), vec3_dot(s, j->b.n)};
    return vec3_finite(s) ? vec3_unit_or(local, (vec3){0, 1, 0}) : (vec3){0, 1, 0};
}

static void turn_frame(JointEnd *e, vec3 s, vec3 t)
{
    vec3 x = e->axis, y = e->u, z = e->n;
    e->axis = vec3_mad(vec3_mad(vec3_scale(s.x, x), s.y, y), s.z, z);
    e->u = vec3_mad(vec3_mad(vec3_scale(t.x, x), t.y, y), t.z, z);
    e->n = vec3_cross(e->axis, e->u);
}

/* The joint with the spin axis in the place of the suspension's. */
static JointView spin_view(const JointView *j)
{
    JointView v = *j;
    vec3 s = spin_local(j), t, u;
    vec3_basis(s, &t, &u);
    turn_frame(&v.a, s, t);
    turn_frame(&v.b, s, t);
    return v;
}

static real travel(const JointView *j) { return vec3_dot(j->b.axis, vec3_sub(j->a.p, j->b.p)); }

static real coordinate(const JointView *j)
{
    JointView spin = spin_view(j);
    real last = j->memory[0];
    return joint_angle(&spin, &last);
}

static real speed(const JointView *j)
{
    JointView spin = spin_view(j);
    return vec3_dot(joint_twist(&spin), vec3_sub(j->a.w, j->b.w));
}

static Row *coordinate_row(RowList *list, const JointView *j, RowKind kind, int slot)
{
    JointView spin = spin_view(j);
    return rows_twist(list, &spin, kind, slot);
}

static void rows(const JointView *j, RowList *out)
{
    const Wheel *wheel = j->params;
    JointView spin = spin_view(j);
    vec3 s = spin_local(j);
    Row slide, turn;
    RowList one = {&slide, 0, 1}, two = {&turn, 0, 1};
    rows_along(out, j, j->b.u, LINE);
    rows_along(out, j, j->b.n, LINE + 1);
    rows_parallel(out, &spin, PARALLEL);
    rows_translation(&one, j, ROW_SOFT, j->b.axis, TRAVEL);
    rows_limits(out, &slide, slide.error, wheel->limits[0], wheel->limits[1], TRAVEL);
    rows_spring(out, &slide, slide.error, &wheel->spring, SPRING);
    rows_twist(&two, &spin, ROW_SOFT, MOTOR);
    rows_motor(out, &turn, &wheel->motor, MOTOR);
    rows_friction(out, &turn, wheel->friction, FRICTION);
    joint_angle(&spin, j->memory);
    j->memory[1] = s.x;
    j->memory[2] = s.y;
    j->memory[3] = s.z;
}

static real energy(const JointView *j) { return spring_energy(&((const Wheel *)j->params)->spring, travel(j)); }

static bool at_limit(const JointView *j)
{
    const Wheel *wheel = j->params;
    return at_limits(travel(j), wheel->limits[0], wheel->limits[1]);
}

const JointType joint_wheel = {
    .name = "wheel",
    .doc = "a spins about one axis and is sprung against b along another",
    .params = wheel_rows,
    .params_size = sizeof(Wheel),
    .free_axes = 2,
    .rows = rows,
    .coordinate = coordinate,
    .speed = speed,
    .angular = true,
    .coordinate_row = coordinate_row,
    .energy = energy,
    .at_limit = at_limit,
};
