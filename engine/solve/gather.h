/* solve/gather.h - what gather.c, gather_pairs.c and seam.c share.
 *
 * Floor: solve.
 */
#ifndef DIG_SOLVE_GATHER_H
#define DIG_SOLVE_GATHER_H

#include "solve/group.h"

#define SHARED_LEAST 512        /* pairs: fewer are not worth a team */

/* Local index of a body slot: moving members first, then what stands still. */
int local_of(const Group *g, uint32_t slot);

dig_status gather_pairs(Group *g, const uint32_t *pairs, int pair_count);

#endif
