/* joint/distance.c - the distance joint: two points stay a given distance apart, or within a range of distances. */
#include <stdio.h>

#include "solve/joint_type.h"

enum { LENGTH = 0, LIMITS = 1 };        /* slots */

typedef struct Distance {
    vec3 at_a, at_b;    /* m  world points at creation  */
    real length;        /* m  NaN = between min and max */
    real min, max;      /* m  NaN = none                */
} Distance;

static const dig_param distance_rows[] = {
    JOINT_END("at_a", "its end on a; default the centre of mass", Distance, at_a),
    JOINT_END("at_b", "its end on b; default the centre of mass", Distance, at_b),
    {.name = "length", .kind = DIG_REAL, .unit = "m", .doc = "distance of the ends; default as they are", .fallback = NAN,
     .min = 1e-6, .max = 1e9, .offset = offsetof(Distance, length)},
    {.name = "min", .kind = DIG_REAL, .unit = "m", .doc = "least distance, instead of length", .fallback = NAN, .min = 0,
     .max = 1e9, .offset = offsetof(Distance, min)},
    {.name = "max", .kind = DIG_REAL, .unit = "m", .doc = "greatest distance, instead of length", .fallback = NAN, .min = 0,
     .max = 1e9, .offset = offsetof(Distance, max)},
    {.name = NULL},
};

static dig_status check(void *params, const JointView *now, char *why, size_t capacity)
{
    Distance *d = params;
    bool range = !isnan(d->min) || !isnan(d->max);
    if (range && !isnan(d->length)) {
        snprintf(why, capacity, "length = %g m cannot go with min or max: give either", d->length);
        return DIG_E_ARG;
    }
    if (d->min > d->max) {
        snprintf(why, capacity, "min = %g m, must be at most max = %g m", d->min, d->max);
        return DIG_E_ARG;
    }
    if (range || !isnan(d->length))
        return DIG_OK;
    real present = vec3_distance(now->a.p, now->b.p);
    if (!(present >= 1e-6)) {
        snprintf(why, capacity, "its ends are %g m apart, which is no length to keep: give length, min or max", present);
        return DIG_E_ARG;
    }
    d->length = present;
    return DIG_OK;
}

static void rows(const JointView *j, RowList *out)
{
    const Distance *d = j->params;
    Row like;
    RowList one = {&like, 0, 1};
    real length;
    if (!rows_length(&one, j, ROW_HARD, &length, LENGTH))
        rows_along(&one, j, j->b.axis, LENGTH);         /* ends that coincide part along any direction */
    if (isnan(d->length)) {
        rows_limits(out, &like, length, d->min, d->max, LIMITS);
        return;
    }
    Row *r = rows_add(out, ROW_HARD, LENGTH);
    *r = like;
    r->error = length - d->length;
}

static bool at_limit(const JointView *j)
{
    const Distance *d = j->params;
    return at_limits(joint_length(j), d->min, d->max);
}

static bool ranged(const void *params) { return isnan(((const Distance *)params)->length); }

const JointType joint_distance = {
    .name = "distance",
    .doc = "two points stay a distance apart, or within a range of distances",
    .params = distance_rows,
    .params_size = sizeof(Distance),
    .free_axes = 5,
    .no_axis = true,
    .two_anchors = true,
    .check = check,
    .rows = rows,
    .coordinate = joint_length,
    .speed = joint_length_rate,
    .at_limit = at_limit,
    .only_limits = ranged,
};
