/* render/wide.h - loops over pixels that are compiled twice: plainly, and with vectors twice as long where the processor has them.
 *
 * A loop is an inline function (LANE_CODE); a plain function calls it, and a WIDE one likewise. Which of the two runs is asked at
 * run time. The bits are the same: no operation is fused or put in another order.
 *
 * Floor: render. No OpenGL here.
 */
#ifndef DIG_WIDE_H
#define DIG_WIDE_H

#include "base/base.h"

#define LANE_CODE static inline __attribute__((always_inline))

#ifdef __x86_64__
#define WIDE __attribute__((target("avx2")))
static inline bool has_wide(void) { return __builtin_cpu_supports("avx2"); }
#else
#define WIDE
static inline bool has_wide(void) { return false; }
#endif

/* As vector instructions have them: b where the two do not compare. */
LANE_CODE float least(float a, float b) { return a < b ? a : b; }
LANE_CODE float most(float a, float b) { return a > b ? a : b; }

#endif
