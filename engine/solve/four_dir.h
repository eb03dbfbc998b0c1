/* solve/four_dir.h - one direction of four contact points, side by side.
 *
 * Floor: solve.
 */
#ifndef DIG_FOUR_DIR_H
#define DIG_FOUR_DIR_H

#include "math/four.h"
#include "solve/group.h"

typedef struct FourDir { four3 n, aa, ab, ia, ib; four k; } FourDir;       /* as Dir */

enum { DIR_FOURS = sizeof(Dir) / sizeof(four) };
_Static_assert(sizeof(FourDir) == LANES * sizeof(Dir) && sizeof(Dir) % sizeof(four) == 0, "a direction is whole fours");

INLINE void four_dir_load(FourDir *to, const Dir *const from[LANES])
{
    UNROLL
    for (int i = 0; i < DIR_FOURS; i++) {
        four part[LANES];
        UNROLL
        for (int lane = 0; lane < LANES; lane++)
            part[lane] = ((const four_any *)(const void *)from[lane])[i];
        four_transpose(part);
        memcpy((char *)to + (size_t)i * sizeof part, part, sizeof part);
    }
}

/* The first `count` lanes; each goes `stride` bytes after the one before. */
INLINE void four_dir_store(const FourDir *from, Dir *first, size_t stride, int count)
{
    UNROLL
    for (int i = 0; i < DIR_FOURS; i++) {
        four part[LANES];
        memcpy(part, (const char *)from + (size_t)i * sizeof part, sizeof part);
        four_transpose(part);
        for (int lane = 0; lane < count; lane++)
            ((four_any *)(void *)((char *)first + (size_t)lane * stride))[i] = part[lane];
    }
}

#endif
