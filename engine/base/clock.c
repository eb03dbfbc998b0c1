/* base/clock.c - the wall clock and the CPU clock of the thread. */
#define _POSIX_C_SOURCE 200809L
#include "base/clock.h"

#include <time.h>

#define SHORT_LAP 30.0          /* us */

static real read_us(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return 1e6 * (real)t.tv_sec + 1e-3 * (real)t.tv_nsec;
}

real cpu_us(void) { return read_us(CLOCK_THREAD_CPUTIME_ID); }
real wall_us(void) { return read_us(CLOCK_MONOTONIC); }

Stopwatch stopwatch_start(void) { return (Stopwatch){cpu_us(), wall_us()}; }

real stopwatch_lap(Stopwatch *s)
{
    real wall = wall_us(), spent = wall - s->wall;
    if (spent > SHORT_LAP) {
        real cpu = cpu_us();
        spent = real_max(0, cpu - s->cpu);
        s->cpu = cpu;
    } else
        s->cpu += spent;
    s->wall = wall;
    return spent;
}
