/* math/pair.h - loops over small matrices: unrolled, two columns at a time.
 *
 * Every number is computed by the same rounded operations in the same order as alone: the bits are the same.
 *
 * Floor: math.
 */
#ifndef DIG_PAIR_H
#define DIG_PAIR_H

#include "base/base.h"

#if defined(__clang__)
#define UNROLL _Pragma("clang loop unroll(full)")
#else
#define UNROLL _Pragma("GCC unroll 8")
#endif

typedef real pair __attribute__((vector_size(16), aligned(8), may_alias));
typedef int64_t pair_int __attribute__((vector_size(16)));
#define PAIR(x) (*(pair *)(void *)&(x))         /* x and its neighbour */
static inline pair two(const real *x) { return *(const pair *)(const void *)x; }
INLINE pair pair_all(real x) { return (pair){x, x}; }

INLINE pair pair_abs(pair a) { return (pair)((pair_int)a & INT64_MAX); }

/* Bit k: lane k of what a comparison says. */
INLINE int pair_bits(pair_int which) { return (int)(which[0] & 1) | (int)(which[1] & 2); }

/* Of each lane real_min and real_max, which compilers do not put together by themselves. */
#ifdef __SSE2__
INLINE pair pair_min(pair a, pair b) { return __builtin_ia32_minpd(a, b); }
INLINE pair pair_max(pair a, pair b) { return __builtin_ia32_maxpd(a, b); }
#else
INLINE pair pair_min(pair a, pair b) { return (pair){a[0] < b[0] ? a[0] : b[0], a[1] < b[1] ? a[1] : b[1]}; }
INLINE pair pair_max(pair a, pair b) { return (pair){a[0] > b[0] ? a[0] : b[0], a[1] > b[1] ? a[1] : b[1]}; }
#endif

#endif
