/* joint/gear.c - the gear: two hinges turn in a fixed ratio.
 *
 *   speed of a * ratio[1] = speed of b * ratio[2]
 *
 * as with numbers of teeth: with ratio = {1, 12} b turns once while a turns twelve times, in the same sense about its own axis.
 * A negative number turns the sense round, as two wheels that mesh: ratio = {20, -40}. The angles keep the phase they have
 * when the gear is made.
 */
#include <stdio.h>

#include "solve/joint_type.h"

typedef struct Gear {
    dig_joint a, b;
    real      ratio[2];     /* 1 */
} Gear;

static const dig_param gear_rows[] = {
    {.name = "a", .kind = DIG_JOINT, .unit = "", .doc = "one hinge", .offset = offsetof(Gear, a), .required = true},
    {.name = "b", .kind = DIG_JOINT, .unit = "", .doc = "the other hinge", .offset = offsetof(Gear, b), .required = true},
    {.name = "ratio", .kind = DIG_PAIR, .unit = "1", .doc = "speed of a * first = speed of b * second", .fallback = 1,
     .min = -1e6, .max = 1e6, .offset = offsetof(Gear, ratio)},
    {.name = NULL},
};

static dig_status check(void *params, const JointView *now, char *why, size_t capacity)
{
    const Gear *g = params;
    for (int i = 0; i < 2; i++) {
        const JointView *o = now->other[i];
        if (!o || !o->type->coordinate_row || !o->type->angular) {
            snprintf(why, capacity, "%s is %s, must be a hinge", i ? "b" : "a", o ? o->type->name : "no joint");
            return DIG_E_ARG;
        }
        if (!(fabs(g->ratio[i]) >= 1e-6)) {
            snprintf(why, capacity, "ratio[%d] = %g, must not be 0", i + 1, g->ratio[i]);
            return DIG_E_ARG;
        }
    }
    if (now->other[0] != now->other[1])
        return DIG_OK;
    snprintf(why, capacity, "a and b are the same joint");
    return DIG_E_ARG;
}

/* Scaled so that the larger factor is 1: the error stays an angle whatever the numbers of teeth. */
static void rows(const JointView *j, RowList *out)
{
    const Gear *g = j->params;
    real largest = real_max(fabs(g->ratio[0]), fabs(g->ratio[1]));
    if (!(largest > 0))
        return;
    Row *r = rows_coupled(out, j, g->ratio[0] / largest, -g->ratio[1] / largest, 0);
    if (r)
        r->angular = true;
}

const JointType joint_gear = {
    .name = "gear",
    .doc = "two hinges turn in a fixed ratio",
    .params = gear_rows,
    .params_size = sizeof(Gear),
    .free_axes = 5,
    .couples = 2,
    .no_axis = true,
    .check = check,
    .rows = rows,
};
