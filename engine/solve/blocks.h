/* solve/blocks.h - a sparse symmetric positive definite matrix of 6x6 blocks, one row of blocks per body, and its Cholesky
 * factor.
 *
 * Bodies that share a row are linked. They are put in minimum-degree order (Tinney & Walker 1967; ties by index, so that the
 * order is a function of the links alone): chains, towers and rings are factored in linear time.
 *
 * Of what does not turn only the first three unknowns are linked with others: between two of those a block has three rows and columns,
 * and what is eliminated takes an eighth of the multiplications.
 *
 * Floor:  solve. Includes base.
 */
#ifndef DIG_BLOCKS_H
#define DIG_BLOCKS_H

#include "base/arena.h"

#define BLOCK  36               /* reals in a block, row by row */
#define SPREAD 72               /* the transpose of a block, each row of it twice */

typedef struct Blocks {
    int   n;
    int  *place;                /* [n]      of what is numbered i, in the order of elimination        */
    int  *first;                /* [n + 1]  column j's blocks below the diagonal: first[j] .. first[j + 1] - 1 */
    int  *row;                  /*          their rows, ascending                                     */
    int  *at;                   /* [n * n]  block of (row, column) with row > column, < 0 none        */
    real *diagonal, *below;     /* BLOCK reals each                                                   */
    real *spread;               /* [blocks of the longest column + 1][SPREAD] a column, as the factorisation reads it; of all of a pattern */
    bool *narrow;               /* [n]      by place: it does not turn                                */
    real  work;                 /* multiplications of a factorisation                                 */
} Blocks;

/* Order and pattern. linked: n * n bytes, symmetric, nonzero where two are linked; it is used up. narrow: [n], NULL = none is. False: out
 * of memory. */
bool blocks_plan(Blocks *s, Arena *arena, int n, unsigned char *linked, const bool *narrow);
bool blocks_reserve(Blocks *s, Arena *arena);
bool blocks_like(Blocks *s, const Blocks *of, Arena *arena);    /* of the same pattern; false: out of memory */
void blocks_copy(Blocks *to, const Blocks *from);
void blocks_clear(Blocks *s);
/* Block of two places, row > column, that are linked. */
static inline real *blocks_at(const Blocks *s, int row, int column) { return s->below + (size_t)BLOCK * (size_t)s->at[row * s->n + column]; }
bool blocks_factor(Blocks *s, bool plain);      /* in place; false: not positive definite. plain: without special instructions */
void blocks_solve(const Blocks *s, real *x);    /* [6 n] in places */

#endif
