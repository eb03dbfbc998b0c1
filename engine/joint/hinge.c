/* joint/hinge.c - the hinge: a turns against b about one axis through one point.
 *
 * Three rows keep the anchors together, two the axes parallel; one freedom is left, the angle of a against b, counted over
 * any number of turns from the pose of creation.
 */
#include "solve/joint_type.h"

enum { POINT = 0, PARALLEL = 3, DRIVE = 5 };        /* slots */

static const dig_param motor_rows[] = {
    {.name = "speed", .kind = DIG_REAL, .unit = "rad/s", .doc = "speed wanted; not given = no motor", .fallback = NAN,
     .min = -1e6, .max = 1e6, .offset = offsetof(DriveMotor, speed)},
    {.name = "max_torque", .kind = DIG_REAL, .unit = "N*m", .doc = "greatest torque it gives; 0 = off, inf = more than anything takes", .fallback = INFINITY,
     .min = 0, .max = INFINITY, .offset = offsetof(DriveMotor, most)},
    {.name = NULL},
};

static const dig_param spring_rows[] = {
    {.name = "stiffness", .kind = DIG_REAL, .unit = "N*m/rad", .doc = "torque per angle", .min = 0, .max = 1e12,
     .offset = offsetof(DriveSpring, stiffness)},
    {.name = "damping", .kind = DIG_REAL, .unit = "N*m*s/rad", .doc = "torque per speed", .min = 0, .max = 1e12,
     .offset = offsetof(DriveSpring, damping)},
    {.name = "rest", .kind = DIG_REAL, .unit = "rad", .doc = "angle without torque", .min = -1e6, .max = 1e6,
     .offset = offsetof(DriveSpring, rest)},
    {.name = NULL},
};

static const dig_param hinge_rows[] = {
    {.name = "limits", .kind = DIG_RANGE, .unit = "rad", .doc = "least and greatest angle of a against b", .fallback = NAN,
     .min = -INFINITY, .max = INFINITY, .offset = offsetof(Drive, limits)},
    {.name = "motor", .kind = DIG_TABLE, .unit = "", .doc = "drives the angle at a speed", .offset = offsetof(Drive, motor),
     .rows = motor_rows},
    {.name = "spring", .kind = DIG_TABLE, .unit = "", .doc = "pulls to an angle", .offset = offsetof(Drive, spring),
     .rows = spring_rows},
    {.name = "friction", .kind = DIG_REAL, .unit = "N*m", .doc = "dry friction torque", .min = 0, .max = 1e12,
     .offset = offsetof(Drive, friction)},
    {.name = NULL},
};

static real coordinate(const JointView *j)
{
    real last = j->memory[0];
    return joint_angle(j, &last);
}

static real speed(const JointView *j)
{
    return vec3_dot(joint_twist(j), vec3_sub(j->a.w, j->b.w));
}

static Row *coordinate_row(RowList *list, const JointView *j, RowKind kind, int slot) { return rows_twist(list, j, kind, slot); }

static void rows(const JointView *j, RowList *out)
{
    Row like;
    RowList one = {&like, 0, 1};
    rows_point(out, j, POINT);
    rows_parallel(out, j, PARALLEL);
    bool acts = drive_acts(j->params);
    real angle = acts || !j->passing ? joint_angle(j, j->memory) : 0;       /* unwound even where nothing needs it now */
    if (!acts)
        return;
    rows_twist(&one, j, ROW_SOFT, DRIVE);
    rows_drive(out, &like, angle, j->params, DRIVE);
}

static bool loose(const void *params) { return !drive_acts(params); }

static real energy(const JointView *j) { return spring_energy(&((const Drive *)j->params)->spring, coordinate(j)); }

static bool at_limit(const JointView *j)
{
    const Drive *d = j->params;
    return drive_acts(d) && at_limits(coordinate(j), d->limits[0], d->limits[1]);
}

const JointType joint_hinge = {
    .name = "hinge",
    .doc = "a turns against b about an axis through a point",
    .params = hinge_rows,
    .params_size = sizeof(Drive),
    .free_axes = 1,
    .at_point = true,
    .driven = true,
    .lower_pair = true,
    .rows = rows,
    .coordinate = coordinate,
    .speed = speed,
    .angular = true,
    .coordinate_row = coordinate_row,
    .energy = energy,
    .loose = loose,
    .at_limit = at_limit,
};
