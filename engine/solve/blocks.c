/* solve/blocks.c - sparse block Cholesky: factor and solve.
 *
 * The factor takes most of the time of what is solved at once. It is written in vectors of four, which the compiler splits where registers
 * are shorter, and compiled for two sets of instructions: the same rounded operations in the same order, the same bits.
 */
#include "math/four.h"
#include "solve/blocks.h"

static size_t late_diagonals(const Blocks *s) { return (size_t)(s->n - s->early) * BLOCK * sizeof(real); }
static size_t late_blocks(const Blocks *s) { return (size_t)(s->at[s->first[s->n]] - s->at[s->first[s->early]]) * sizeof(real); }
static real *first_late(const Blocks *s) { return s->below + s->at[s->first[s->early]]; }

bool blocks_reserve(Blocks *s, Arena *arena)
{
    s->diagonal = arena_alloc(arena, (size_t)s->n * BLOCK * sizeof(real));
    s->below = arena_alloc(arena, (size_t)(s->at[s->first[s->n]] + 1) * sizeof(real));
    s->kept_diagonal = arena_alloc(arena, late_diagonals(s));
    s->kept_below = arena_alloc(arena, late_blocks(s));
    return s->diagonal && s->below && s->kept_diagonal && s->kept_below;
}

real *blocks_at(const Blocks *s, int row, int column)
{
    int from = s->first[column], to = s->first[column + 1];
    while (from < to) {
        int middle = from + (to - from) / 2;
        if (s->row[middle] < row)
            from = middle + 1;
        else
            to = middle;
    }
    DIG_ASSERT(from < s->first[column + 1] && s->row[from] == row);
    return s->below + s->at[from];
}

void blocks_keep(Blocks *s)
{
    memcpy(s->kept_diagonal, s->diagonal + (size_t)BLOCK * (size_t)s->early, late_diagonals(s));
    memcpy(s->kept_below, first_late(s), late_blocks(s));
}

void blocks_back(Blocks *s)
{
    memcpy(s->diagonal + (size_t)BLOCK * (size_t)s->early, s->kept_diagonal, late_diagonals(s));
    memcpy(first_late(s), s->kept_below, late_blocks(s));
}

void blocks_clear(Blocks *s)
{
    memset(s->diagonal, 0, (size_t)s->n * BLOCK * sizeof(real));
    memset(s->below, 0, (size_t)s->at[s->first[s->n]] * sizeof(real));
}

/* L L^T = A within the block; the diagonal of L is kept inverted. */
INLINE bool factor_block(real *a)
{
    for (int j = 0; j < 6; j++) {
        real pivot = a[7 * j];
        for (int k = 0; k < j; k++)
            pivot -= a[6 * j + k] * a[6 * j + k];
        if (!(pivot > 1e-15 * a[7 * j]))
            return false;
        real inverse = 1 / sqrt(pivot);
        for (int i = j + 1; i < 6; i++) {
            real sum = a[6 * i + j];
            for (int k = 0; k < j; k++)
                sum -= a[6 * i + k] * a[6 * j + k];
            a[6 * i + j] = sum * inverse;
        }
        a[7 * j] = inverse;
    }
    return true;
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

/* ---- the same where three rows and columns count: SMALL blocks, or larger ones of which the others are zero ---- */

/* What divide_narrow() leaves out of the transpose: subtract() reads it. */
INLINE void spread_all(real *spread)
{
    for (int k = 0; k < 3; k++) {
        spread[12 * k + 4] = spread[12 * k + 5] = 0;
        memcpy(spread + 12 * k + 6, spread + 12 * k, 6 * sizeof *spread);
    }
    memset(spread + 36, 0, (SPREAD - 36) * sizeof *spread);
}

/* a has three rows of which three columns count, l six. */
INLINE void divide_narrow(real *restrict a, const real *restrict l, real *restrict spread)
{
    UNROLL
    for (int i = 0; i < 3; i++) {
        real *restrict row = a + 4 * i;
        row[0] *= l[0];
        row[1] = (row[1] - row[0] * l[6]) * l[7];
        row[2] = (row[2] - row[0] * l[12] - row[1] * l[13]) * l[14];
        for (int k = 0; k < 3; k++)
            spread[12 * k + i] = row[k];
    }
    spread[3] = spread[15] = spread[27] = 0;
}

/* c's rows are that long, a is SMALL */
INLINE void subtract_narrow(real *restrict c, int stride, const real *restrict a, const real *restrict b)
{
    const four_any *row = (const four_any *)(const void *)b;
    four b0 = row[0], b1 = *(const four_any *)(const void *)(b + 12), b2 = *(const four_any *)(const void *)(b + 24);
    UNROLL
    for (int i = 0; i < 3; i++) {
        four_any *to = (four_any *)(void *)(c + stride * i);
        *to = *to - four_all(a[4 * i]) * b0 - four_all(a[4 * i + 1]) * b1 - four_all(a[4 * i + 2]) * b2;
    }
}

/* The same of what turns: c is SMALL, a and b are not. */
INLINE void subtract_small(real *restrict c, const real *restrict a, const real *restrict b)
{
    for (int i = 0; i < 3; i++) {
        four_any *to = (four_any *)(void *)(c + 4 * i);
        four sum = *to;
        for (int k = 0; k < 6; k++)
            sum -= four_all(a[6 * i + k]) * *(const four_any *)(const void *)(b + 12 * k);
        *to = sum;
    }
}

/* Of a SMALL block one as others are */
INLINE void widen(real *restrict to, const real *restrict a)
{
    memset(to, 0, BLOCK * sizeof *to);
    for (int i = 0; i < 3; i++)
        memcpy(to + 6 * i, a + 4 * i, 3 * sizeof *to);
}

/* Where one of the two turns: rarely. */
INLINE void subtract_mixed(Blocks *s, int p, real *to, const real *spread)
{
    real wide[BLOCK];
    const real *a = s->below + s->at[p];
    if (s->narrow[s->row[p]]) {
        widen(wide, a);
        a = wide;
    }
    subtract(to, a, spread);
}

INLINE void eliminate_narrow(Blocks *s, int j)
{
    const real *l = s->diagonal + (size_t)BLOCK * (size_t)j;
    int first = s->first[j], end = s->first[j + 1];
    bool mixed = false;
    for (int p = first; p < end; p++) {
        if (s->narrow[s->row[p]])
            divide_narrow(s->below + s->at[p], l, s->spread + SPREAD * (p - first));
        else
            divide(s->below + s->at[p], l, s->spread + SPREAD * (p - first));
        mixed = mixed || !s->narrow[s->row[p]];
    }
    for (int p = first; p < end && mixed; p++)
        if (s->narrow[s->row[p]])
            spread_all(s->spread + SPREAD * (p - first));
    const int *target = s->target + s->pair[j];
    for (int q = first; q < end; q++) {
        const int column = s->row[q];
        const real *spread = s->spread + SPREAD * (q - first);
        if (s->narrow[column])
            subtract_narrow(s->diagonal + (size_t)BLOCK * (size_t)column, 6, s->below + s->at[q], spread);
        else
            subtract(s->diagonal + (size_t)BLOCK * (size_t)column, s->below + s->at[q], spread);
        for (int p = q + 1; p < end; p++) {
            if (blocks_small(s, s->row[p], column))
                subtract_narrow(s->below + s->at[*target++], 4, s->below + s->at[p], spread);
            else
                subtract_mixed(s, p, s->below + s->at[*target++], spread);
        }
    }
}

INLINE void eliminate(Blocks *s, int j)
{
    const real *l = s->diagonal + (size_t)BLOCK * (size_t)j;
    int first = s->first[j], count = s->first[j + 1] - first;
    real *below = s->below + s->at[first];
    for (int p = 0; p < count; p++)
        divide(below + BLOCK * p, l, s->spread + SPREAD * p);
    const int *target = s->target + s->pair[j];
    for (int q = 0; q < count; q++) {
        int column = s->row[first + q];
        subtract(s->diagonal + (size_t)BLOCK * (size_t)column, below + BLOCK * q, s->spread + SPREAD * q);
        for (int p = q + 1; p < count; p++) {
            int k = *target++;
            if (blocks_small(s, s->row[k], column))
                subtract_small(s->below + s->at[k], below + BLOCK * p, s->spread + SPREAD * q);
            else
                subtract(s->below + s->at[k], below + BLOCK * p, s->spread + SPREAD * q);
        }
    }
}

INLINE bool factor(Blocks *s, int from, int to)
{
    for (int j = from; j < to; j++) {
        if (!factor_block(s->diagonal + (size_t)BLOCK * (size_t)j))
            return false;
        if (s->narrow[j])
            eliminate_narrow(s, j);
        else
            eliminate(s, j);
    }
    return true;
}

static bool factor_plain(Blocks *s, int from, int to) { return factor(s, from, to); }

#if defined(__x86_64__)
__attribute__((target("avx2"))) static bool factor_avx2(Blocks *s, int from, int to) { return factor(s, from, to); }

static bool factor_columns(Blocks *s, int from, int to, bool plain)
{
    return !plain && __builtin_cpu_supports("avx2") ? factor_avx2(s, from, to) : factor_plain(s, from, to);
}
#else
static bool factor_columns(Blocks *s, int from, int to, bool plain)
{
    (void)plain;
    return factor_plain(s, from, to);
}
#endif

bool blocks_begin(Blocks *s, bool plain) { return factor_columns(s, 0, s->early, plain); }
bool blocks_factor(Blocks *s, bool plain) { return factor_columns(s, s->early, s->n, plain); }

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

/* The same of what is narrow. */
INLINE void solve_forth_narrow(const Blocks *s, int j, real *x)
{
    const real x0 = x[6 * j], x1 = x[6 * j + 1], x2 = x[6 * j + 2];
    for (int p = s->first[j]; p < s->first[j + 1]; p++) {
        const real *b = s->below + s->at[p];
        real *restrict to = x + 6 * s->row[p];
        const bool small = s->narrow[s->row[p]];
        for (int i = 0, n = small ? 3 : 6, stride = small ? 4 : 6; i < n; i++)
            to[i] -= b[stride * i] * x0 + b[stride * i + 1] * x1 + b[stride * i + 2] * x2;
    }
}

INLINE void solve_back_narrow(const Blocks *s, int j, real *x)
{
    real x0 = x[6 * j], x1 = x[6 * j + 1], x2 = x[6 * j + 2];
    for (int p = s->first[j]; p < s->first[j + 1]; p++) {
        const real *b = s->below + s->at[p], *from = x + 6 * s->row[p];
        const bool small = s->narrow[s->row[p]];
        for (int i = 0, n = small ? 3 : 6, stride = small ? 4 : 6; i < n; i++) {
            x0 -= b[stride * i] * from[i];
            x1 -= b[stride * i + 1] * from[i];
            x2 -= b[stride * i + 2] * from[i];
        }
    }
    x[6 * j] = x0;
    x[6 * j + 1] = x1;
    x[6 * j + 2] = x2;
}

void blocks_solve(const Blocks *s, real *x)
{
    for (int j = 0; j < s->n; j++) {
        const real *l = s->diagonal + (size_t)BLOCK * (size_t)j;
        real *xj = x + 6 * j;
        for (int i = 0; i < 6; i++) {
            for (int k = 0; k < i; k++)
                xj[i] -= l[6 * i + k] * xj[k];
            xj[i] *= l[7 * i];
        }
        if (s->narrow[j])
            solve_forth_narrow(s, j, x);
        else
            solve_forth(s, j, x);
    }
    for (int j = s->n - 1; j >= 0; j--) {
        const real *l = s->diagonal + (size_t)BLOCK * (size_t)j;
        real *xj = x + 6 * j;
        if (s->narrow[j])
            solve_back_narrow(s, j, x);
        else
            solve_back(s, j, x);
        for (int i = 5; i >= 0; i--) {
            for (int k = i + 1; k < 6; k++)
                xj[i] -= l[6 * k + i] * xj[k];
            xj[i] *= l[7 * i];
        }
    }
}
