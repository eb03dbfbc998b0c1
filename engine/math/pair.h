/* math/pair.h - loops over small matrices: unrolled, two columns at a time.
 *
 * Every number is computed by the same rounded operations in the same order as alone: the bits are the same.
 *
 * Floor: math.
 */
#ifndef DIG_PAIR_H
#define DIG_PAIR_H

#include "digbox.h"

#define INLINE static inline __attribute__((always_inline))
#if defined(__clang__)
#define UNROLL _Pragma("clang loop unroll(full)")
#else
#define UNROLL _Pragma("GCC unroll 8")
#endif

typedef real pair __attribute__((vector_size(16), aligned(8), may_alias));
#define PAIR(x) (*(pair *)(void *)&(x))         /* x and its neighbour */
static inline pair two(const real *x) { return *(const pair *)(const void *)x; }

#endif
