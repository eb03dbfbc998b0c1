/* base/base.h - what every file of the engine may use: types, assertions, DIG_TRY.
 *
 * Floor: base.
 */
#ifndef DIG_BASE_H
#define DIG_BASE_H

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "digbox.h"

#define DIG_PI 3.14159265358979323846

/* Checked in debug and test builds; a release build compiles it away. */
#ifdef DIG_DEBUG
#include <assert.h>
#define DIG_ASSERT(condition) assert(condition)
#else
#define DIG_ASSERT(condition) ((void)sizeof((condition) ? 1 : 0))
#endif

/* Passes a failure on to the caller. */
#define DIG_TRY(call)                       \
    do {                                    \
        dig_status try_status_ = (call);    \
        if (try_status_ != DIG_OK)          \
            return try_status_;             \
    } while (0)

#if defined(__GNUC__)
#define DIG_PRINTF(text, first) __attribute__((format(printf, text, first)))
#else
#define DIG_PRINTF(text, first)
#endif

/* A function of which each call is a copy. */
#define INLINE static inline __attribute__((always_inline))

/* Tells the processor of memory that is read soon: in large worlds, records that belong together lie far apart. Changes no result. */
static inline void fetch_soon(const void *at, size_t bytes)
{
#if defined(__GNUC__)
    __asm__ volatile("");       /* or GCC 12 takes what does nothing else for a function without effects, and leaves out its calls */
    for (size_t i = 0; i < bytes; i += 64)
        __builtin_prefetch((const char *)at + i);
    __builtin_prefetch((const char *)at + bytes - 1);
#else
    (void)at;
    (void)bytes;
#endif
}
#define FETCH_AHEAD 16          /* turns of a loop */

static inline real real_min(real a, real b) { return a < b ? a : b; }
static inline real real_max(real a, real b) { return a > b ? a : b; }
static inline real real_clamp(real x, real lo, real hi) { return x < lo ? lo : x > hi ? hi : x; }
static inline int int_min(int a, int b) { return a < b ? a : b; }
static inline int int_max(int a, int b) { return a > b ? a : b; }

#endif
