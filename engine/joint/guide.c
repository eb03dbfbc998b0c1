/* joint/guide.c - the guide: holds a point of a on a line or in a plane of b, or keeps a direction of a, and leaves all else free.
 *
 * Rollers under bridges, things that stay in a plane, rails.
 */
#include "solve/joint_type.h"

enum { ALONG = 0, PARALLEL = 2 };       /* slots */

typedef enum Keeps { KEEPS_LINE, KEEPS_PLANE, KEEPS_DIRECTION, KEEPS_FLAT } Keeps;
static const char *const keeps_names[] = {"line", "plane", "direction", "flat", NULL};

typedef struct Guide { int64_t keeps; } Guide;

static const dig_param guide_rows[] = {
    {.name = "keeps", .kind = DIG_CHOICE, .unit = "",
     .doc = "the point on the line of the axis, or in the plane across it; the axis' direction; flat: plane and direction",
     .max = KEEPS_FLAT, .offset = offsetof(Guide, keeps), .choices = keeps_names},
    {.name = NULL},
};

static void rows(const JointView *j, RowList *out)
{
    Keeps keeps = (Keeps)((const Guide *)j->params)->keeps;
    if (keeps == KEEPS_LINE) {
        rows_along(out, j, j->b.u, ALONG);
        rows_along(out, j, j->b.n, ALONG + 1);
    }
    if (keeps == KEEPS_PLANE || keeps == KEEPS_FLAT)
        rows_along(out, j, j->b.axis, ALONG);
    if (keeps == KEEPS_DIRECTION || keeps == KEEPS_FLAT)
        rows_parallel(out, j, PARALLEL);
}

const JointType joint_guide = {
    .name = "guide",
    .doc = "a point of a stays on a line or in a plane of b, or an axis of it keeps its direction",
    .params = guide_rows,
    .params_size = sizeof(Guide),
    .free_axes = 4,             /* of a line; a plane leaves one more, what is flat one less */
    .rows = rows,
};
