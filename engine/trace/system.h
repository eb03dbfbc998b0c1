/* trace/system.h - parts of the direct solve: see system.c.
 *
 * A is symmetric, given by its lower triangle, row by row with the stride n; f holds L below the diagonal and 1 / D on it.
 *
 * Floor: trace. Includes base.
 */
#ifndef DIG_TRACE_SYSTEM_H
#define DIG_TRACE_SYSTEM_H

#include "base/base.h"

#define SMALL_ROWS 10

bool small_size(int n);         /* is it one of those written out? The others are not for the rest */
bool small_factor(const real *a, real *f, real softer, real least, int n);     /* false: a pivot is not above `least` of its diagonal */
void small_back(const real *f, real *x, int n);                                /* x in place of the right side */
void small_remainder(const real *a, const real *b, const real *x, real *r, int n);      /* r = b - A x */

/* ---- rows of the same bodies that repeat each other (rank.c) ---- */

#define RANK_ROWS 12            /* with fewer the softened factor costs no more */

struct Line;

/* f takes what rank_back needs, n * n reals. 0: the rank cannot be told, or is more than six. */
int rank_factor(const struct Line *lines, real *f, int n);
void rank_back(const real *f, real *x, int n, int rank);                       /* x of the least norm in place of the right side */
void rank_remainder(const struct Line *lines, const real *b, const real *x, real *r, int n);    /* r = b - A x, without A */

#endif
