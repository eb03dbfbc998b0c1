/* joint/slider.c - the slider: a moves against b along one axis and does not turn against it.
 *
 * Two rows keep the anchor of a on the line through the anchor of b, three keep the frames aligned; one freedom is left, the
 * distance of a along the axis from the pose of creation.
 */
#include "solve/joint_type.h"

enum { LINE = 0, ALIGNED = 2, DRIVE = 5 };          /* slots */

static const dig_param motor_rows[] = {
    {.name = "speed", .kind = DIG_REAL, .unit = "m/s", .doc = "speed wanted; not given = no motor", .fallback = NAN,
     .min = -1e6, .max = 1e6, .offset = offsetof(DriveMotor, speed)},
    {.name = "max_force", .kind = DIG_REAL, .unit = "N", .doc = "greatest force it gives; 0 = off, inf = more than anything takes", .fallback = INFINITY,
     .min = 0, .max = INFINITY, .offset = offsetof(DriveMotor, most)},
    {.name = NULL},
};

static const dig_param spring_rows[] = {
    {.name = "stiffness", .kind = DIG_REAL, .unit = "N/m", .doc = "force per distance", .min = 0, .max = 1e12,
     .offset = offsetof(DriveSpring, stiffness)},
    {.name = "damping", .kind = DIG_REAL, .unit = "N*s/m", .doc = "force per speed", .min = 0, .max = 1e12,
     .offset = offsetof(DriveSpring, damping)},
    {.name = "rest", .kind = DIG_REAL, .unit = "m", .doc = "distance without force", .min = -1e6, .max = 1e6,
     .offset = offsetof(DriveSpring, rest)},
    {.name = NULL},
};

static const dig_param slider_rows[] = {
    {.name = "limits", .kind = DIG_RANGE, .unit = "m", .doc = "least and greatest distance of a along the axis", .fallback = NAN,
     .min = -INFINITY, .max = INFINITY, .offset = offsetof(Drive, limits)},
    {.name = "motor", .kind = DIG_TABLE, .unit = "", .doc = "drives the distance at a speed", .offset = offsetof(Drive, motor),
     .rows = motor_rows},
    {.name = "spring", .kind = DIG_TABLE, .unit = "", .doc = "pulls to a distance", .offset = offsetof(Drive, spring),
     .rows = spring_rows},
    {.name = "friction", .kind = DIG_REAL, .unit = "N", .doc = "dry friction force", .min = 0, .max = 1e12,
     .offset = offsetof(Drive, friction)},
    {.name = NULL},
};

static real coordinate(const JointView *j) { return vec3_dot(j->b.axis, vec3_sub(j->a.p, j->b.p)); }

static Row *coordinate_row(RowList *list, const JointView *j, RowKind kind, int slot)
{
    return rows_translation(list, j, kind, j->b.axis, slot);
}

static real speed(const JointView *j)
{
    Row r;
    RowList one = {&r, 0, 1};
    return joint_rate(j, coordinate_row(&one, j, ROW_SOFT, DRIVE));
}

static void rows(const JointView *j, RowList *out)
{
    Row like;
    RowList one = {&like, 0, 1};
    rows_along(out, j, j->b.u, LINE);
    rows_along(out, j, j->b.n, LINE + 1);
    rows_aligned(out, j, ALIGNED);
    coordinate_row(&one, j, ROW_SOFT, DRIVE);
    rows_drive(out, &like, like.error, j->params, DRIVE);
}

static bool loose(const void *params) { return !drive_acts(params); }

static real energy(const JointView *j) { return spring_energy(&((const Drive *)j->params)->spring, coordinate(j)); }

static bool at_limit(const JointView *j)
{
    const Drive *d = j->params;
    return drive_acts(d) && at_limits(coordinate(j), d->limits[0], d->limits[1]);
}

const JointType joint_slider = {
    .name = "slider",
    .doc = "a moves against b along an axis and does not turn against it",
    .params = slider_rows,
    .params_size = sizeof(Drive),
    .free_axes = 1,
    .driven = true,
    .lower_pair = true,
    .rows = rows,
    .coordinate = coordinate,
    .speed = speed,
    .coordinate_row = coordinate_row,
    .energy = energy,
    .loose = loose,
    .at_limit = at_limit,
};
