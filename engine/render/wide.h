/* render/wide.h - loops over pixels that are compiled twice (base/wide.h): each is an inline function, LANE_CODE.
 *
 * Floor: render. No OpenGL here.
 */
#ifndef DIG_WIDE_H
#define DIG_WIDE_H

#include "base/base.h"
#include "base/wide.h"

#define LANE_CODE static inline __attribute__((always_inline))

/* As vector instructions have them: b where the two do not compare. */
LANE_CODE float least(float a, float b) { return a < b ? a : b; }
LANE_CODE float most(float a, float b) { return a > b ? a : b; }

#endif
