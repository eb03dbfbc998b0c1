/* joint/rack.c - the rack and pinion: a slider moves as a hinge turns.
 *
 *   speed of b (slider) = ratio * speed of a (hinge)
 *
 * The ratio is the radius of the pinion's pitch circle; a negative one turns the sense round. Angle and distance keep the
 * phase they have when the rack is made.
 */
#include <stdio.h>

#include "solve/joint_type.h"

typedef struct Rack {
    dig_joint a, b;
    real      ratio;        /* m/rad */
} Rack;

static const dig_param rack_rows[] = {
    {.name = "a", .kind = DIG_JOINT, .unit = "", .doc = "the hinge", .offset = offsetof(Rack, a), .required = true},
    {.name = "b", .kind = DIG_JOINT, .unit = "", .doc = "the slider", .offset = offsetof(Rack, b), .required = true},
    {.name = "ratio", .kind = DIG_REAL, .unit = "m/rad", .doc = "distance of the slider per angle of the hinge: the pinion's radius",
     .fallback = NAN, .min = -1e6, .max = 1e6, .offset = offsetof(Rack, ratio), .required = true},
    {.name = NULL},
};

static dig_status check(void *params, const JointView *now, char *why, size_t capacity)
{
    const Rack *rack = params;
    for (int i = 0; i < 2; i++) {
        const JointView *o = now->other[i];
        if (o && o->type->coordinate_row && o->type->angular == (i == 0))
            continue;
        snprintf(why, capacity, "%s is %s, must be a %s", i ? "b" : "a", o ? o->type->name : "no joint", i ? "slider" : "hinge");
        return DIG_E_ARG;
    }
    if (fabs(rack->ratio) >= 1e-9)
        return DIG_OK;
    snprintf(why, capacity, "ratio = %g m/rad, must not be 0", rack->ratio);
    return DIG_E_ARG;
}

static void rows(const JointView *j, RowList *out)
{
    rows_coupled(out, j, -((const Rack *)j->params)->ratio, 1, 0);
}

const JointType joint_rack = {
    .name = "rack",
    .doc = "a slider moves in proportion to the angle of a hinge",
    .params = rack_rows,
    .params_size = sizeof(Rack),
    .free_axes = 5,
    .couples = 2,
    .no_axis = true,
    .check = check,
    .rows = rows,
};
