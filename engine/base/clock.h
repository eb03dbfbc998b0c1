/* base/clock.h - clocks for statistics. Nothing that is simulated depends on them.
 *
 * Floor: base.
 */
#ifndef DIG_CLOCK_H
#define DIG_CLOCK_H

#include "base/base.h"

real wall_us(void);             /* us; some 30 ns a look                                                             */
real cpu_us(void);              /* us of CPU time of this thread; a system call, as dear as a step of a small world  */

/* CPU time from lap to lap. A lap too short to have been interrupted is taken from the wall clock. */
typedef struct Stopwatch { real cpu, wall; } Stopwatch;
Stopwatch stopwatch_start(void);
real      stopwatch_lap(Stopwatch *s);      /* us since the start or the last lap */

#endif
