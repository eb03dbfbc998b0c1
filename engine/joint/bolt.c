/* joint/bolt.c - the bolt: holds a fast to b until its force exceeds the strength, which is the joint's breaks_at. */
#include "solve/joint_type.h"

enum { POINT = 0, ALIGNED = 3 };        /* slots */

static const dig_param bolt_rows[] = {{.name = NULL}};      /* nothing but what all joints have */

static void rows(const JointView *j, RowList *out)
{
    rows_point(out, j, POINT);
    rows_aligned(out, j, ALIGNED);
}

const JointType joint_bolt = {
    .name = "bolt",
    .doc = "a is held fast to b until its strength is exceeded",
    .params = bolt_rows,
    .fuses = true,
    .free_axes = 0,
    .at_point = true,
    .lower_pair = true,
    .no_axis = true,
    .rows = rows,
};
