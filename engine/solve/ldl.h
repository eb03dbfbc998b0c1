/* solve/ldl.h - A x = b for a symmetric positive definite matrix, as L D L^T without exchanges.
 *
 * Small ones are dense, larger ones sparse in the order of solve/degree.h: what 32 unknowns cost is then about the same.
 * The pattern is planned once; factor and solve take no memory.
 *
 * Owns:  nothing; all memory is the arena's.
 * Floor: solve. Includes base.
 */
#ifndef DIG_LDL_H
#define DIG_LDL_H

#include "base/arena.h"

#define LDL_DENSE 32            /* unknowns; Golub & Van Loan 2013, 4.1, for these; left-looking columns for more */

typedef struct Ldl {
    int   n, values;
    bool  dense;
    int  *place;                /* [n]      of unknown i in the order of elimination; NULL when dense        */
    int  *first;                /* [n + 1]  column k's values: first[k] .. first[k + 1] - 1; NULL when dense */
    int  *row;                  /* [values] their rows, ascending                                            */
    real *diagonal;             /* [n]      in places                                                        */
    real *below;                /* [values] dense: row by row, i (i - 1) / 2 + k                             */
    real *column;               /* [n]      scratch                                                          */
    int  *head, *after, *at;    /* [n]      scratch                                                          */
} Ldl;

/* link: pairs of unknowns (2 * links of them) that share a coefficient; twice the same is no harm. False: out of memory. */
bool  ldl_plan(Ldl *s, Arena *arena, int n, const int *link, int links);
int   ldl_find(const Ldl *s, int i, int k);     /* number in `below` of the coefficient of two linked unknowns */
void  ldl_clear(Ldl *s);
static inline real *ldl_diagonal(Ldl *s, int i) { return &s->diagonal[s->dense ? i : s->place[i]]; }
bool  ldl_factor(Ldl *s);                       /* in place; false: not positive definite */
void  ldl_solve(const Ldl *s, real *x);         /* b -> x, by unknowns */

#endif
