/* base/wide.h - loops that are compiled twice: plainly, and with vectors twice as long where the processor has them.
 *
 * A loop is an inline function; a plain function calls it, and a WIDE one likewise. Which of the two runs is asked at run time. The bits
 * are the same: no operation is fused or put in another order.
 *
 * Floor: base.
 */
#ifndef DIG_BASE_WIDE_H
#define DIG_BASE_WIDE_H

#include <stdbool.h>

#ifdef __x86_64__
#define WIDE __attribute__((target("avx2")))
static inline bool has_wide(void) { return __builtin_cpu_supports("avx2"); }
#else
#define WIDE
static inline bool has_wide(void) { return false; }
#endif

#endif
