/* joint/rope.c - the rope: two points are never farther apart than its length. It pulls and never pushes. */
#include <stdio.h>

#include "solve/joint_type.h"

enum { TAUT = 0 };          /* slots: TAUT + 1 is the upper limit */

typedef struct Rope {
    vec3 at_a, at_b;    /* m  world points at creation */
    real length;        /* m                           */
} Rope;

static const dig_param rope_rows[] = {
    JOINT_END("at_a", "its end on a; default the centre of mass", Rope, at_a),
    JOINT_END("at_b", "its end on b; default the centre of mass", Rope, at_b),
    {.name = "length", .kind = DIG_REAL, .unit = "m", .doc = "greatest distance of the ends; default as they are, at least that; to take it in, set it later",
     .fallback = NAN, .min = 1e-6, .max = 1e9, .offset = offsetof(Rope, length)},
    {.name = NULL},
};

static dig_status check(void *params, const JointView *now, char *why, size_t capacity)
{
    Rope *rope = params;
    if (isnan(rope->length))
        rope->length = joint_length(now);
    if (rope->length >= 1e-6)
        return DIG_OK;
    snprintf(why, capacity, "its ends are %g m apart, which is no length for a rope: give length", rope->length);
    return DIG_E_ARG;
}

#define ROUNDING 0.01           /* of its length: 1.41 m for a diagonal of 1 m is meant to fit, and is taken in by the first step */

/* Its ends would be drawn together from the first step on, at no speed. */
static dig_status check_new(const void *params, const JointView *now, char *why, size_t capacity)
{
    const Rope *rope = params;
    real apart = joint_length(now);
    if (rope->length >= apart * (1 - ROUNDING))
        return DIG_OK;
    snprintf(why, capacity, "length = %g m, must be at least the distance of its ends (%g m); to take it in, set its length later", rope->length,
             apart);
    return DIG_E_ARG;
}

static void rows(const JointView *j, RowList *out)
{
    Row like;
    RowList one = {&like, 0, 1};
    real length;
    if (rows_length(&one, j, ROW_LIMIT, &length, TAUT))         /* ends that coincide leave it slack */
        rows_limits(out, &like, length, NAN, ((const Rope *)j->params)->length, TAUT);
}

static bool at_limit(const JointView *j) { return at_limits(joint_length(j), NAN, ((const Rope *)j->params)->length); }

const JointType joint_rope = {
    .name = "rope",
    .doc = "two points are never farther apart than its length",
    .params = rope_rows,
    .params_size = sizeof(Rope),
    .free_axes = 6,
    .no_axis = true,
    .two_anchors = true,
    .check = check,
    .check_new = check_new,
    .rows = rows,
    .coordinate = joint_length,
    .speed = joint_length_rate,
    .at_limit = at_limit,
};
