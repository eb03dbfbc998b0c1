/* solve/blocks.c - sparse block Cholesky: factor and solve.
 *
 * The factor takes most of the time of what is solved at once. It is written in vectors of four, which the compiler splits where registers
 * are shorter, and compiled for two sets of instructions: the same rounded operations in the same order, the same bits.
 */
#include "base/sort.h"
#include "base/wide.h"
#include "math/four.h"
#include "solve/blocks.h"

#define HALF 21                 /* reals from the first of a block to that of its lower right half */

static real *diagonal(const Blocks *s, int j) { return s->diagonal + (size_t)BLOCK * (size_t)j; }
static size_t late_diagonals(const Blocks *s) { return (size_t)(s->n - s->early) * BLOCK * sizeof(real); }
static size_t late_blocks(const Blocks *s) { return (size_t)(s->at[s->first[s->n]] - s->at[s->first[s->early]]) * sizeof(real); }
static real *first_late(const Blocks *s) { return s->below + s->at[s->first[s->early]]; }

/* Vectors of four reach past what counts, by one at the very end. */
bool blocks_reserve(Blocks *s, Arena *arena)
{
    s->diagonal = arena_alloc(arena, ((size_t)s->n * BLOCK + 1) * sizeof(real));
    s->below = arena_alloc(arena, (size_t)(s->at[s->first[s->n]] + 1) * sizeof(real));
    s->kept_diagonal = arena_alloc(arena, late_diagonals(s));
    s->kept_below = arena_alloc(arena, late_blocks(s));
    return s->diagonal && s->below && s->kept_diagonal && s->kept_below;
}

real *blocks_at(const Blocks *s, int row, int column)
{
    int at = sorted_place(s->row, s->first[column], s->first[column + 1], row);
    DIG_ASSERT(at < s->first[column + 1] && s->row[at] == row);
    return s->below + s->at[at];
}

void blocks_keep(Blocks *s)
{
    memcpy(s->kept_diagonal, diagonal(s, s->early), late_diagonals(s));
    memcpy(s->kept_below, first_late(s), late_blocks(s));
}

void blocks_back(Blocks *s)
{
    memcpy(diagonal(s, s->early), s->kept_diagonal, late_diagonals(s));
    memcpy(first_late(s), s->kept_below, late_blocks(s));
}

void blocks_clear(Blocks *s)
{
    memset(s->diagonal, 0, ((size_t)s->n * BLOCK + 1) * sizeof(real));
    memset(s->below, 0, (size_t)(s->at[s->first[s->n]] + 1) * sizeof(real));
}

/* L L^T = A within `size` rows and columns of a block; the diagonal of L is kept inverted. */
INLINE bool factor_block(real *a, int size)
{
    for (int j = 0; j < size; j++) {
        real pivot = a[7 * j];
        for (int k = 0; k < j; k++)
            pivot -= a[6 * j + k] * a[6 * j + k];
        if (!(pivot > 1e-15 * a[7 * j]))
            return false;
        real inverse = 1 / sqrt(pivot);
        for (int i = j + 1; i < size; i++) {
            real sum = a[6 * i + j];
            for (int k = 0; k < j; k++)
                sum -= a[6 * i + k] * a[6 * j + k];
            a[6 * i + j] = sum * inverse;
        }
        a[7 * j] = inverse;
    }
    return true;
}

/* Of what does not turn the halves are not coupled: one need not wait for the other. */
INLINE bool factor_halves(real *a)
{
    bool upper = factor_block(a, 3), lower = factor_block(a + HALF, 3);
    return upper && lower;
}

/* A = A L^-T, and its transpose for subtract(): each row of that twice, so that two rows of six are three vectors. */
INLINE void divide(real *restrict a, const real *restrict l, real *restrict spread)
{
    real t[BLOCK];
    UNROLL
    for (int i = 0; i < 6; i++)
        for (int k = 0; k < 6; k++)
            t[6 * k + i] = a[6 * i + k];
    for (int j = 0; j < 6; j++) {
        for (int k = 0; k < j; k++)
            for (int i = 0; i < 6; i++)
                t[6 * j + i] -= t[6 * k + i] * l[6 * j + k];
        for (int i = 0; i < 6; i++)
            t[6 * j + i] *= l[7 * j];
    }
    for (int k = 0; k < 6; k++)
        for (int i = 0; i < 6; i++)
            spread[12 * k + i] = spread[12 * k + 6 + i] = a[6 * i + k] = t[6 * k + i];
}

/* c -= a b^T, of b what divide() spread */
INLINE void subtract(real *restrict c, const real *restrict a, const real *restrict b)
{
    UNROLL
    for (int i = 0; i < 6; i += 2) {
        four_any *to = (four_any *)(void *)(c + 6 * i);
        four c0 = to[0], c1 = to[1], c2 = to[2];
        UNROLL
        for (int k = 0; k < 6; k++) {
            const four_any *row = (const four_any *)(const void *)(b + 12 * k);
            four f0 = four_all(a[6 * i + k]), f2 = four_all(a[6 * i + 6 + k]);
            c0 -= f0 * row[0];
            c1 -= __builtin_shufflevector(f0, f2, 0, 1, 4, 5) * row[1];
            c2 -= f2 * row[2];
        }
        to[0] = c0;
        to[1] = c1;
        to[2] = c2;
    }
}

/* The same where column c is narrow: three or six rows of four. */
INLINE void subtract_thin(int rows, real *restrict c, const real *restrict a, const real *restrict b)
{
    for (int i = 0; i < rows; i++) {
        four_any *to = (four_any *)(void *)(c + 4 * i);
        four sum = *to;
        for (int k = 0; k < 6; k++)
            sum -= four_all(a[6 * i + k]) * *(const four_any *)(const void *)(b + 12 * k);
        *to = sum;
    }
}

INLINE bool eliminate(Blocks *s, int j)
{
    real *l = diagonal(s, j);
    if (!factor_block(l, 6))
        return false;
    const int first = s->first[j], count = s->first[j + 1] - first, *row = s->row + first;
    real *below = s->below + s->at[first];
    for (int p = 0; p < count; p++)
        divide(below + BLOCK * p, l, s->spread + SPREAD * p);
    const int *target = s->target + s->pair[j];
    for (int q = 0; q < count; q++) {
        const real *spread = s->spread + SPREAD * q;
        subtract(diagonal(s, row[q]), below + BLOCK * q, spread);
        for (int p = q + 1; p < count; p++, target++) {
            if (s->narrow[row[q]])
                subtract_thin(s->narrow[row[p]] ? 3 : 6, s->below + *target, below + BLOCK * p, spread);
            else
                subtract(s->below + *target, below + BLOCK * p, spread);
        }
    }
    return true;
}

/* ---- panels of narrow columns, in SMALL blocks: a row that turns has two in each column ---- */

/* Of a panel the blocks of one row that turns, of two that do not, or of one. */
typedef struct Strip {
    real *a;                    /* the first column's                        */
    int   rows, apart;          /* 1 or 2, and how far the second is away     */
    int   step;                 /* from one column to the next                */
    int   end;                  /* where in s->row the next strip begins      */
} Strip;

INLINE Strip strip_at(const Blocks *s, real *a, int width, int p, int end)
{
    if (!s->narrow[s->row[p]])
        return (Strip){a, 2, SMALL, 2 * SMALL, p + 1};
    int rows = p + 1 < end && s->narrow[s->row[p + 1]] ? 2 : 1;
    return (Strip){a, rows, SMALL * width, SMALL, p + rows};
}

/* c -= a b^T for one column of the panel after the other, so that c is read and written once. Its rows are `stride` long; b is transposed. */
INLINE void subtract_rows(int rows, const Strip *of, int depth, const real *restrict b, real *c0, real *c1, int stride)
{
    const int step = of->step;
    const real *a[2] = {of->a, of->a + of->apart};
    real *c[2] = {c0, c1};
    four sum[6];
    UNROLL
    for (int i = 0; i < 3 * rows; i++)
        sum[i] = *(const four_any *)(const void *)(c[i / 3] + stride * (i % 3));
    for (int m = 0; m < depth; m++, b += SMALL) {
        UNROLL
        for (int i = 0; i < 3 * rows; i++) {        /* one load a row: left to itself, GCC takes vectors apart for less */
            four r = *(const four_any *)(const void *)(a[i / 3] + 4 * (i % 3));
            sum[i] -= __builtin_shufflevector(r, r, 0, 0, 0, 0) * *(const four_any *)(const void *)b;
            sum[i] -= __builtin_shufflevector(r, r, 1, 1, 1, 1) * *(const four_any *)(const void *)(b + 4);
            sum[i] -= __builtin_shufflevector(r, r, 2, 2, 2, 2) * *(const four_any *)(const void *)(b + 8);
        }
        a[0] += step;
        a[1] += step;
    }
    UNROLL
    for (int i = 0; i < 3 * rows; i++)
        *(four_any *)(void *)(c[i / 3] + stride * (i % 3)) = sum[i];
}

INLINE void subtract_strip(const Strip *of, int depth, const real *restrict b, real *c0, real *c1, int stride)
{
    if (of->rows == 2)
        subtract_rows(2, of, depth, b, c0, c1, stride);
    else
        subtract_rows(1, of, depth, b, c0, c0, stride);
}

/* A = A L^-T, and its transpose */
INLINE void divide_small(real *restrict a, const real *restrict l, real *restrict spread)
{
    UNROLL
    for (int i = 0; i < 3; i++) {
        real *restrict row = a + 4 * i;
        row[0] *= l[0];
        row[1] = (row[1] - row[0] * l[6]) * l[7];
        row[2] = (row[2] - row[0] * l[12] - row[1] * l[13]) * l[14];
        for (int k = 0; k < 3; k++)
            spread[4 * k + i] = row[k];
    }
    spread[3] = spread[7] = spread[11] = 0;
}

/* The same for the first `depth` columns of panel j. */
INLINE void divide_strip(Blocks *s, int j, const Strip *of, int depth, real *spread)
{
    const int width = SMALL * s->width[j];
    for (int m = 0; m < depth; m++) {
        real *c0 = of->a + of->step * m, *c1 = c0 + of->apart;
        const real *l = diagonal(s, j + m);
        subtract_strip(of, m, s->spread + width * m, c0, c1, 4);
        divide_small(c0, l, spread + SMALL * m);
        if (of->rows == 2)
            divide_small(c1, l, spread + width + SMALL * m);
    }
}

/* Out of column row[q], whose own blocks are at a. */
INLINE void subtract_panel(Blocks *s, int width, int q, int end, real *a, const real *spread, const int *target)
{
    const int column = s->row[q], halves = s->narrow[column] ? 1 : 2, stride = s->narrow[column] ? 4 : 6;
    for (int half = 0; half < halves; half++) {
        const real *b = spread + SMALL * width * half;
        Strip of = strip_at(s, a, width, q, q + 1);
        real *c = diagonal(s, column) + 3 * half;
        subtract_strip(&of, width, b, c, c + 18, 6);
        for (int p = q + 1; p < end; p = of.end) {
            of = strip_at(s, of.a + SMALL * width * of.rows, width, p, end);
            const int *to = target + p - q - 1;
            c = s->below + to[0] + 3 * half;
            subtract_strip(&of, width, b, c, of.end == p + 1 ? c + 3 * stride : s->below + to[1] + 3 * half, stride);
        }
    }
}

INLINE bool factor_panel(Blocks *s, int j)
{
    const int width = s->width[j], outside = s->first[j] + width - 1, end = s->first[j + 1];
    real *a = s->below + s->at[s->first[j]], *spread = s->spread;
    for (int i = 0; i < width; i++) {
        real *l = diagonal(s, j + i);
        Strip of = {.a = a, .rows = 1, .step = SMALL};
        divide_strip(s, j, &of, i, spread);
        subtract_strip(&of, i, spread, l, l, 6);
        if (!factor_halves(l))
            return false;
        a += SMALL * i;
        spread += SMALL * width;
    }
    real *rest = a, *rest_spread = spread;
    for (int p = outside; p < end;) {
        Strip of = strip_at(s, a, width, p, end);
        divide_strip(s, j, &of, width, spread);
        a += SMALL * width * of.rows;
        spread += SMALL * width * of.rows;
        p = of.end;
    }
    const int *target = s->target + s->pair[j];
    for (int q = outside; q < end; q++) {
        int size = SMALL * width * (s->narrow[s->row[q]] ? 1 : 2);
        subtract_panel(s, width, q, end, rest, rest_spread, target);
        target += end - q - 1;
        rest += size;
        rest_spread += size;
    }
    return true;
}

INLINE bool factor(Blocks *s, int from, int to)
{
    for (int j = from; j < to; j += s->width[j])
        if (!(s->narrow[j] ? factor_panel(s, j) : eliminate(s, j)))
            return false;
    return true;
}

static bool factor_plain(Blocks *s, int from, int to) { return factor(s, from, to); }
WIDE static bool factor_wide(Blocks *s, int from, int to) { return factor(s, from, to); }

static bool factor_columns(Blocks *s, int from, int to, bool plain)
{
    return (plain || !has_wide() ? factor_plain : factor_wide)(s, from, to);
}

bool blocks_begin(Blocks *s, bool plain) { return factor_columns(s, 0, s->early, plain); }
bool blocks_factor(Blocks *s, bool plain) { return factor_columns(s, s->early, s->n, plain); }

/* Within a diagonal block, or half of one; and the other way round. */
INLINE void solve_lower(const real *l, real *x, int size)
{
    for (int i = 0; i < size; i++) {
        for (int k = 0; k < i; k++)
            x[i] -= l[6 * i + k] * x[k];
        x[i] *= l[7 * i];
    }
}

INLINE void solve_upper(const real *l, real *x, int size)
{
    for (int i = size - 1; i >= 0; i--) {
        for (int k = i + 1; k < size; k++)
            x[i] -= l[6 * k + i] * x[k];
        x[i] *= l[7 * i];
    }
}

/* Takes what place j is out of those below it, and the other way round. */
INLINE void solve_forth(const Blocks *s, int j, real *x)
{
    const real *xj = x + 6 * j;
    for (int p = s->first[j]; p < s->first[j + 1]; p++) {
        const real *b = s->below + s->at[p];
        real *restrict to = x + 6 * s->row[p];
        for (int i = 0; i < 6; i++) {
            real sum = to[i];
            for (int k = 0; k < 6; k++)
                sum -= b[6 * i + k] * xj[k];
            to[i] = sum;
        }
    }
}

INLINE void solve_back(const Blocks *s, int j, real *x)
{
    real *xj = x + 6 * j;
    pair x0 = two(xj), x1 = two(xj + 2), x2 = two(xj + 4);
    for (int p = s->first[j]; p < s->first[j + 1]; p++) {
        const real *b = s->below + s->at[p], *from = x + 6 * s->row[p];
        UNROLL
        for (int i = 0; i < 6; i++) {
            x0 -= two(b + 6 * i) * from[i];
            x1 -= two(b + 6 * i + 2) * from[i];
            x2 -= two(b + 6 * i + 4) * from[i];
        }
    }
    PAIR(xj[0]) = x0;
    PAIR(xj[2]) = x1;
    PAIR(xj[4]) = x2;
}

/* Takes out of three unknowns what `depth` narrow places from x on are, by SMALL blocks that are `step` apart. */
INLINE void take(real *to, const real *b, int step, const real *x, int depth)
{
    real t0 = to[0], t1 = to[1], t2 = to[2];
    for (int m = 0; m < depth; m++, b += step, x += 6) {
        t0 -= b[0] * x[0] + b[1] * x[1] + b[2] * x[2];
        t1 -= b[4] * x[0] + b[5] * x[1] + b[6] * x[2];
        t2 -= b[8] * x[0] + b[9] * x[1] + b[10] * x[2];
    }
    to[0] = t0;
    to[1] = t1;
    to[2] = t2;
}

/* The same of panels of narrow columns: what is above in it first, then what is below all of them. */
INLINE void solve_forth_panel(const Blocks *s, int j, real *x)
{
    const int width = s->width[j];
    const real *b = s->below + s->at[s->first[j]];
    for (int i = 0; i < width; i++) {
        take(x + 6 * (j + i), b, SMALL, x + 6 * j, i);
        solve_lower(diagonal(s, j + i), x + 6 * (j + i), 3);
        solve_lower(diagonal(s, j + i) + HALF, x + 6 * (j + i) + 3, 3);
        b += SMALL * i;
    }
    for (int p = s->first[j] + width - 1; p < s->first[j + 1]; p++) {
        int halves = s->narrow[s->row[p]] ? 1 : 2;
        for (int i = 0; i < halves; i++)
            take(x + 6 * s->row[p] + 3 * i, b + SMALL * i, SMALL * halves, x + 6 * j, width);
        b += SMALL * halves * width;
    }
}

INLINE void solve_back_narrow(const Blocks *s, int j, real *x)
{
    real *xj = x + 6 * j;
    pair x0 = two(xj), x2 = {xj[2], 0};
    for (int p = s->first[j]; p < s->first[j + 1]; p++) {
        const real *b = s->below + s->at[p], *from = x + 6 * s->row[p], *end = from + (s->narrow[s->row[p]] ? 3 : 6);
        for (; from < end; from += 3, b += SMALL) {
            UNROLL
            for (int i = 0; i < 3; i++) {
                x0 -= two(b + 4 * i) * from[i];
                x2 -= two(b + 4 * i + 2) * from[i];
            }
        }
    }
    PAIR(xj[0]) = x0;
    xj[2] = x2[0];
}

void blocks_solve(const Blocks *s, real *x)
{
    for (int j = 0; j < s->n; j += s->width[j]) {
        if (s->narrow[j]) {
            solve_forth_panel(s, j, x);
        } else {
            solve_lower(diagonal(s, j), x + 6 * j, 6);
            solve_forth(s, j, x);
        }
    }
    for (int j = s->n - 1; j >= 0; j--) {
        if (s->narrow[j]) {
            solve_back_narrow(s, j, x);
            solve_upper(diagonal(s, j), x + 6 * j, 3);
            solve_upper(diagonal(s, j) + HALF, x + 6 * j + 3, 3);
        } else {
            solve_back(s, j, x);
            solve_upper(diagonal(s, j), x + 6 * j, 6);
        }
    }
}
