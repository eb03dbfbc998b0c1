/* joint/motor.c - the motor: drives the spin of a against b about an axis of b at a speed, with a torque that has a bound. It
 * holds nothing in place. */
#include "solve/joint_type.h"

enum { SPIN = 0 };          /* slots */

static const dig_param motor_rows[] = {
    {.name = "speed", .kind = DIG_REAL, .unit = "rad/s", .doc = "spin wanted of a against b", .fallback = NAN, .min = -1e6,
     .max = 1e6, .offset = offsetof(DriveMotor, speed), .required = true},
    {.name = "max_torque", .kind = DIG_REAL, .unit = "N*m", .doc = "greatest torque it gives; 0 = off, inf = more than anything takes", .fallback = INFINITY,
     .min = 0, .max = INFINITY, .offset = offsetof(DriveMotor, most)},
    {.name = NULL},
};

static real coordinate(const JointView *j)
{
    real last = j->memory[0];
    return joint_angle(j, &last);
}

static real speed(const JointView *j) { return vec3_dot(j->b.axis, vec3_sub(j->a.w, j->b.w)); }

static void rows(const JointView *j, RowList *out)
{
    Row like;
    RowList one = {&like, 0, 1};
    row_turns(rows_spin(&one, j, ROW_MOTOR, j->b.axis, SPIN), j, vec3_cross(j->b.w, j->b.axis));
    rows_motor(out, &like, j->params, SPIN);
    joint_angle(j, j->memory);
}

const JointType joint_motor = {
    .name = "motor",
    .doc = "drives the spin of a against b about an axis",
    .params = motor_rows,
    .params_size = sizeof(DriveMotor),
    .free_axes = 6,
    .rows = rows,
    .coordinate = coordinate,
    .speed = speed,
    .angular = true,
};
