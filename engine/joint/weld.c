/* joint/weld.c - the weld: a is rigidly fixed to b as they lie at creation. */
#include "solve/joint_type.h"

enum { POINT = 0, ALIGNED = 3 };        /* slots */

static const dig_param weld_rows[] = {{.name = NULL}};      /* nothing but what all joints have */

static void rows(const JointView *j, RowList *out)
{
    rows_point(out, j, POINT);
    rows_aligned(out, j, ALIGNED);
}

const JointType joint_weld = {
    .name = "weld",
    .doc = "a is rigidly fixed to b; what a chain of welds holds does not touch itself",
    .params = weld_rows,
    .fuses = true,
    .free_axes = 0,
    .at_point = true,
    .lower_pair = true,
    .no_axis = true,
    .rows = rows,
};
