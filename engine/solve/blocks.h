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
#define SMALL  12               /* in one between two that do not turn: three rows of three and a fourth that is not used */
#define SPREAD 72               /* the transpose of a block, each row of it twice */

typedef struct Blocks {
    int   n, early;             /* rows; how many are eliminated by blocks_begin                      */
    int  *place;                /* [n]      of what is numbered i, in the order of elimination        */
    int  *first;                /* [n + 1]  column j's blocks below the diagonal: first[j] .. first[j + 1] - 1 */
    int  *row;                  /*          their rows, ascending                                     */
    int  *at;                   /* [first[n] + 1]  where they are in below                            */
    int  *pair;                 /* [n]      column j's targets: from pair[j] on                       */
    int  *target;               /*          of rows q < p of a column, q by q: where block (row[p], row[q]) is in below */
    int  *width;                /* [n]      columns of the panel that begins with j                   */
    real *diagonal, *below;     /* BLOCK reals each; BLOCK, or SMALL once or twice                    */
    real *kept_diagonal, *kept_below;       /* of those that are not early, by blocks_keep            */
    real *spread;               /*          a column or a panel transposed, as the factorisation reads it */
    bool *narrow;               /* [n]      by place: it does not turn                                */
    real  begin_work, late_work;            /* multiplications of blocks_begin and blocks_factor   */
    real  work;                 /* of a factorisation, where four go on from one beginning            */
} Blocks;

typedef struct BlockLinks {
    int         n, links;
    const int  *link;           /* [2 links]  pairs of numbers that share a row; twice the same, or one with itself, is no harm */
    const bool *narrow, *late;  /* [n] which do not turn, and whose blocks change; NULL = none         */
    real        most;           /* work, beyond which the pattern is not wanted; 0 = none              */
} BlockLinks;

/* Order and pattern. The late ones are put last where that saves work. Of a pattern that is not wanted only n and work are known. False:
 * out of memory. */
bool blocks_plan(Blocks *s, Arena *arena, const BlockLinks *of);
bool blocks_reserve(Blocks *s, Arena *arena);
void blocks_clear(Blocks *s);
/* Block of two places, row > column, that are linked. */
real *blocks_at(const Blocks *s, int row, int column);
/* How long its rows are in there. In a narrow column there are four reals in a row, of which three count; three rows where the row is
 * narrow, too, else six. */
static inline int blocks_stride(const Blocks *s, int column) { return s->narrow[column] ? 4 : 6; }
/* In place; false: not positive definite. plain: without special instructions. */
bool blocks_begin(Blocks *s, bool plain);
bool blocks_factor(Blocks *s, bool plain);
void blocks_keep(Blocks *s);
void blocks_back(Blocks *s);
void blocks_solve(const Blocks *s, real *x);    /* [6 n] in places */

#endif
