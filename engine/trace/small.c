/* trace/small.c - symmetric systems of the sizes that one joint, one contact or two hinges have: the same L D L^T and the same layout
 * as in system.c, written out without loops by the compiler for each size. Loops of a few passes cost three times what they do.
 */
#include "trace/system.h"

#ifdef DIG_DEBUG
#define UNROLLED                /* clang takes minutes to write these out with the checks of its sanitizers in them */
#else
#define UNROLLED _Pragma("GCC unroll 10")
#endif
_Static_assert(SMALL_ROWS == 10, "as many passes as are written out");

/* What `of` makes of each size: up to a contact that sticks, and two hinges. */
#define EACH_SIZE(of) of(1) of(2) of(3) of(4) of(5) of(6) of(10)

static inline __attribute__((always_inline)) bool factor(const real *a, real *f, real softer, real least, int n)
{
    UNROLLED
    for (int i = 0; i < n; i++) {
        real u[SMALL_ROWS], diagonal = a[i * n + i] * softer, pivot = diagonal;     /* u: row i of L D */
        UNROLLED
        for (int k = 0; k < i; k++) {
            real sum = a[i * n + k];
            UNROLLED
            for (int m = 0; m < k; m++)
                sum -= u[m] * f[k * n + m];
            u[k] = sum;
        }
        UNROLLED
        for (int k = 0; k < i; k++) {
            real l = u[k] * f[k * n + k];
            pivot -= l * u[k];
            f[i * n + k] = l;
        }
        if (!(pivot > least * diagonal))
            return false;
        f[i * n + i] = 1 / pivot;
    }
    return true;
}

static inline __attribute__((always_inline)) void back(const real *f, real *x, int n)
{
    real y[SMALL_ROWS];
    UNROLLED
    for (int i = 0; i < n; i++) {
        y[i] = x[i];
        UNROLLED
        for (int k = 0; k < i; k++)
            y[i] -= f[i * n + k] * y[k];
    }
    UNROLLED
    for (int i = n - 1; i >= 0; i--) {
        y[i] *= f[i * n + i];
        UNROLLED
        for (int k = i + 1; k < n; k++)
            y[i] -= f[k * n + i] * y[k];
        x[i] = y[i];
    }
}

static inline __attribute__((always_inline)) void remainder_of(const real *a, const real *b, const real *x, real *r, int n)
{
    UNROLLED
    for (int i = 0; i < n; i++) {
        real sum = b[i];
        UNROLLED
        for (int k = 0; k < n; k++)
            sum -= (k < i ? a[i * n + k] : a[k * n + i]) * x[k];
        r[i] = sum;
    }
}

bool small_size(int n)
{
#define IS(size) || n == size
    return false EACH_SIZE(IS);
}

bool small_factor(const real *a, real *f, real softer, real least, int n)
{
#define FACTOR(size) case size: return factor(a, f, softer, least, size);
    switch (n) {
    EACH_SIZE(FACTOR)
    default: return false;
    }
}

void small_back(const real *f, real *x, int n)
{
#define BACK(size) case size: back(f, x, size); break;
    switch (n) {
    EACH_SIZE(BACK)
    default: break;
    }
}

void small_remainder(const real *a, const real *b, const real *x, real *r, int n)
{
#define REMAINDER(size) case size: remainder_of(a, b, x, r, size); break;
    switch (n) {
    EACH_SIZE(REMAINDER)
    default: break;
    }
}
