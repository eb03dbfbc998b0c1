/* base/sort.h - numbers into ascending order, without comparisons where there are many.
 *
 * Floor: base.
 */
#ifndef DIG_SORT_H
#define DIG_SORT_H

#include "base/arena.h"

/* Ascending. In order already: one look at each. Else a few passes over bytes: the cost grows with the count only. Scratch memory is
 * given back. DIG_E_MEMORY: there was none, nothing is changed. */
dig_status sort_u32(uint32_t *a, int count, Arena *scratch);

#endif
