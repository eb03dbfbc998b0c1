/* base/sort.h - numbers into ascending order, without comparisons where there are many; and found in it.
 *
 * Floor: base.
 */
#ifndef DIG_SORT_H
#define DIG_SORT_H

#include "base/arena.h"

/* Ascending. In order already: one look at each. Else a few passes over bytes: the cost grows with the count only. Scratch memory is
 * given back. DIG_E_MEMORY: there was none, nothing is changed. */
dig_status sort_u32(uint32_t *a, int count, Arena *scratch);

/* Where in from..to - 1, ascending, the first is that is no less than x; to: there is none. */
static inline int sorted_place(const int *a, int from, int to, int x)
{
    while (from < to) {
        int middle = from + (to - from) / 2;
        if (a[middle] < x)
            from = middle + 1;
        else
            to = middle;
    }
    return from;
}

#endif
