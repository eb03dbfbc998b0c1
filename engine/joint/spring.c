/* joint/spring.c - the spring: pulls two points to its length, with damping along its line.
 *
 *   force = -stiffness (distance - length) - damping d(distance)/dt       along the line of its ends
 *
 * A spring of length 0 has no line when its ends meet, so it is written as three rows, one per direction, with
 * force = -stiffness (pa - pb) - damping d/dt (pa - pb) as seen from b.
 */
#include "solve/joint_type.h"

enum { LINE = 0 };          /* slots, up to 2 */

typedef struct Spring {
    vec3 at_a, at_b;            /* m  world points at creation   */
    real stiffness, damping;    /* N/m, N s/m                    */
    real length;                /* m                             */
} Spring;

static const dig_param spring_rows[] = {
    JOINT_END("at_a", "its end on a; default the centre of mass", Spring, at_a),
    JOINT_END("at_b", "its end on b; default the centre of mass", Spring, at_b),
    {.name = "stiffness", .kind = DIG_REAL, .unit = "N/m", .doc = "force per distance", .fallback = NAN, .min = 0, .max = 1e12,
     .offset = offsetof(Spring, stiffness), .required = true},
    {.name = "damping", .kind = DIG_REAL, .unit = "N*s/m", .doc = "force per speed", .min = 0, .max = 1e12,
     .offset = offsetof(Spring, damping)},
    {.name = "length", .kind = DIG_REAL, .unit = "m", .doc = "length without force; default as its ends lie", .fallback = NAN,
     .min = 0, .max = 1e9, .offset = offsetof(Spring, length)},
    {.name = NULL},
};

static dig_status check(void *params, const JointView *now, char *why, size_t capacity)
{
    Spring *s = params;
    (void)why;
    (void)capacity;
    if (isnan(s->length))
        s->length = joint_length(now);
    return DIG_OK;
}

static void rows(const JointView *j, RowList *out)
{
    const Spring *s = j->params;
    Row like;
    RowList one = {&like, 0, 1};
    real length;
    if (s->length > 0) {
        if (rows_length(&one, j, ROW_SOFT, &length, LINE))
            rows_spring(out, &like, length, &(DriveSpring){s->stiffness, s->damping, s->length}, LINE);
        return;
    }
    vec3 d[3] = {j->b.axis, j->b.u, j->b.n};
    for (int i = 0; i < 3; i++) {
        one.count = 0;
        rows_translation(&one, j, ROW_SOFT, d[i], LINE);
        rows_spring(out, &like, like.error, &(DriveSpring){s->stiffness, s->damping, 0}, LINE + i);
    }
}

static real energy(const JointView *j)
{
    const Spring *s = j->params;
    return spring_energy(&(DriveSpring){s->stiffness, s->damping, s->length}, joint_length(j));
}

const JointType joint_spring = {
    .name = "spring",
    .doc = "pulls two points to its length",
    .params = spring_rows,
    .params_size = sizeof(Spring),
    .free_axes = 6,
    .no_axis = true,
    .two_anchors = true,
    .check = check,
    .rows = rows,
    .coordinate = joint_length,
    .speed = joint_length_rate,
    .energy = energy,
};
