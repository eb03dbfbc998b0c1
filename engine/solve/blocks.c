/* solve/blocks.c - sparse block Cholesky: order, pattern, factor, solve.
 *
 * The factor takes most of the time of what is solved at once. It is written in vectors of four, which the compiler splits where registers
 * are shorter, and compiled for two sets of instructions: the same rounded operations in the same order, the same bits.
 */
#include "math/four.h"
#include "solve/blocks.h"

/* What is left of the graph after an elimination has all neighbours of the eliminated linked with each other. */
static void order(Blocks *s, unsigned char *linked, int *degree, int *around)
{
    int n = s->n;
    for (int i = 0; i < n; i++) {
        degree[i] = 0;
        for (int k = 0; k < n; k++)
            degree[i] += linked[i * n + k] != 0;
        s->place[i] = -1;
    }
    for (int place = 0; place < n; place++) {
        int best = -1, count = 0;
        for (int i = 0; i < n; i++)
            if (s->place[i] < 0 && (best < 0 || degree[i] < degree[best]))
                best = i;
        s->place[best] = place;
        for (int i = 0; i < n; i++)
            if (linked[best * n + i] && s->place[i] < 0)
                around[count++] = i;
        for (int i = 0; i < count; i++) {
            degree[around[i]]--;
            for (int k = 0; k < count; k++)
                if (i != k && !linked[around[i] * n + around[k]]) {
                    linked[around[i] * n + around[k]] = 1;
                    degree[around[i]]++;
                }
        }
    }
}

/* Multiplications of column j, that many blocks long, of which that many are narrow. */
static real work_of(bool narrow, real blocks, real narrow_blocks)
{
    real all = 72 + 126 * blocks + 108 * blocks * (blocks + 1);
    real few = 72 + 18 * narrow_blocks + 13.5 * narrow_blocks * (narrow_blocks + 1), rest = blocks - narrow_blocks;
    return narrow ? few + 126 * rest + 108 * rest * (blocks + narrow_blocks + 1) : all;
}

bool blocks_plan(Blocks *s, Arena *arena, int n, unsigned char *linked, const bool *narrow)
{
    size_t size = (size_t)n;
    s->n = n;
    s->place = arena_alloc(arena, size * sizeof *s->place);
    s->first = arena_alloc(arena, (size + 1) * sizeof *s->first);
    s->at = arena_alloc(arena, size * size * sizeof *s->at);
    s->narrow = arena_zero(arena, size * sizeof *s->narrow);
    int *degree = arena_alloc(arena, size * sizeof *degree), *around = arena_alloc(arena, size * sizeof *around);
    if (!s->place || !s->first || !s->at || !s->narrow || !degree || !around)
        return false;
    order(s, linked, degree, around);
    int *who = degree, blocks = 0, longest = 0;
    for (int i = 0; i < n; i++) {
        who[s->place[i]] = i;
        s->narrow[s->place[i]] = narrow && narrow[i];
    }
    s->work = 0;
    for (int j = 0; j < n; j++) {
        int thin = 0;
        s->first[j] = blocks;
        for (int i = 0; i < n; i++) {
            bool below = i > j && linked[who[j] * n + who[i]];
            s->at[i * n + j] = below ? blocks++ : -1;
            thin += below && s->narrow[i];
        }
        longest = int_max(longest, blocks - s->first[j]);
        s->work += work_of(s->narrow[j], blocks - s->first[j], thin);
    }
    s->first[n] = blocks;
    s->row = arena_alloc(arena, (size_t)(blocks + 1) * sizeof *s->row);
    s->spread = arena_alloc(arena, (size_t)(longest + 1) * SPREAD * sizeof *s->spread);
    for (int i = 0; s->row && i < n; i++)
        for (int j = 0; j < i; j++)
            if (s->at[i * n + j] >= 0)
                s->row[s->at[i * n + j]] = i;
    return s->row && s->spread;
}

bool blocks_reserve(Blocks *s, Arena *arena)
{
    s->diagonal = arena_alloc(arena, (size_t)s->n * BLOCK * sizeof(real));
    s->below = arena_alloc(arena, (size_t)(s->first[s->n] + 1) * BLOCK * sizeof(real));
    return s->diagonal && s->below;
}

bool blocks_like(Blocks *s, const Blocks *of, Arena *arena)
{
    *s = *of;
    return blocks_reserve(s, arena);
}

void blocks_copy(Blocks *to, const Blocks *from)
{
    memcpy(to->diagonal, from->diagonal, (size_t)to->n * BLOCK * sizeof(real));
    memcpy(to->below, from->below, (size_t)to->first[to->n] * BLOCK * sizeof(real));
}

void blocks_clear(Blocks *s)
{
    memset(s->diagonal, 0, (size_t)s->n * BLOCK * sizeof(real));
    memset(s->below, 0, (size_t)s->first[s->n] * BLOCK * sizeof(real));
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

/* ---- the same where three rows and columns count: in blocks of the same size, of which the others are zero ---- */

/* What divide_narrow() leaves out of the transpose: subtract() reads it. */
INLINE void spread_all(real *spread)
{
    for (int k = 0; k < 3; k++) {
        spread[12 * k + 4] = spread[12 * k + 5] = 0;
        memcpy(spread + 12 * k + 6, spread + 12 * k, 6 * sizeof *spread);
    }
    memset(spread + 36, 0, (SPREAD - 36) * sizeof *spread);
}

INLINE void divide_narrow(real *restrict a, const real *restrict l, real *restrict spread)
{
    UNROLL
    for (int i = 0; i < 3; i++) {
        real *restrict row = a + 6 * i;
        row[0] *= l[0];
        row[1] = (row[1] - row[0] * l[6]) * l[7];
        row[2] = (row[2] - row[0] * l[12] - row[1] * l[13]) * l[14];
        for (int k = 0; k < 3; k++)
            spread[12 * k + i] = row[k];
    }
    spread[3] = spread[15] = spread[27] = 0;
}

INLINE void subtract_narrow(real *restrict c, const real *restrict a, const real *restrict b)
{
    const four_any *row = (const four_any *)(const void *)b;
    four b0 = row[0], b1 = *(const four_any *)(const void *)(b + 12), b2 = *(const four_any *)(const void *)(b + 24);
    UNROLL
    for (int i = 0; i < 3; i++) {
        four_any *to = (four_any *)(void *)(c + 6 * i);
        *to = *to - four_all(a[6 * i]) * b0 - four_all(a[6 * i + 1]) * b1 - four_all(a[6 * i + 2]) * b2;
    }
}

INLINE void eliminate_narrow(Blocks *s, int j)
{
    const real *l = s->diagonal + (size_t)BLOCK * (size_t)j;
    int first = s->first[j], count = s->first[j + 1] - first;
    real *below = s->below + (size_t)BLOCK * (size_t)first;
    bool mixed = false;
    for (int p = 0; p < count; p++) {
        if (s->narrow[s->row[first + p]])
            divide_narrow(below + BLOCK * p, l, s->spread + SPREAD * p);
        else
            divide(below + BLOCK * p, l, s->spread + SPREAD * p);
        mixed = mixed || !s->narrow[s->row[first + p]];
    }
    for (int p = 0; p < count && mixed; p++)
        if (s->narrow[s->row[first + p]])
            spread_all(s->spread + SPREAD * p);
    for (int p = 0; p < count; p++) {
        int row = s->row[first + p];
        const int *at = s->at + (size_t)row * (size_t)s->n;
        for (int q = 0; q <= p; q++) {
            int column = s->row[first + q];
            real *to = q < p ? s->below + (size_t)BLOCK * (size_t)at[column] : s->diagonal + (size_t)BLOCK * (size_t)row;
            if (s->narrow[row] && s->narrow[column])
                subtract_narrow(to, below + BLOCK * p, s->spread + SPREAD * q);
            else
                subtract(to, below + BLOCK * p, s->spread + SPREAD * q);
        }
    }
}

INLINE bool factor(Blocks *s)
{
    for (int j = 0; j < s->n; j++) {
        real *l = s->diagonal + (size_t)BLOCK * (size_t)j;
        if (!factor_block(l))
            return false;
        if (s->narrow[j]) {
            eliminate_narrow(s, j);
            continue;
        }
        int first = s->first[j], count = s->first[j + 1] - first;
        real *below = s->below + (size_t)BLOCK * (size_t)first;
        for (int p = 0; p < count; p++)
            divide(below + BLOCK * p, l, s->spread + SPREAD * p);
        for (int p = 0; p < count; p++) {
            for (int q = 0; q < p; q++)
                subtract(blocks_at(s, s->row[first + p], s->row[first + q]), below + BLOCK * p, s->spread + SPREAD * q);
            subtract(s->diagonal + (size_t)BLOCK * (size_t)s->row[first + p], below + BLOCK * p, s->spread + SPREAD * p);
        }
    }
    return true;
}

static bool factor_plain(Blocks *s) { return factor(s); }

#if defined(__x86_64__)
__attribute__((target("avx2"))) static bool factor_avx2(Blocks *s) { return factor(s); }

bool blocks_factor(Blocks *s, bool plain) { return !plain && __builtin_cpu_supports("avx2") ? factor_avx2(s) : factor_plain(s); }
#else
bool blocks_factor(Blocks *s, bool plain)
{
    (void)plain;
    return factor_plain(s);
}
#endif

/* Takes what place j is out of those below it, and the other way round. */
INLINE void solve_forth(const Blocks *s, int j, real *x)
{
    const real *xj = x + 6 * j;
    for (int p = s->first[j]; p < s->first[j + 1]; p++) {
        const real *b = s->below + (size_t)BLOCK * (size_t)p;
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
        const real *b = s->below + (size_t)BLOCK * (size_t)p, *from = x + 6 * s->row[p];
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
    const real *xj = x + 6 * j;
    for (int p = s->first[j]; p < s->first[j + 1]; p++) {
        const real *b = s->below + (size_t)BLOCK * (size_t)p;
        real *restrict to = x + 6 * s->row[p];
        for (int i = 0, n = s->narrow[s->row[p]] ? 3 : 6; i < n; i++)
            to[i] -= b[6 * i] * xj[0] + b[6 * i + 1] * xj[1] + b[6 * i + 2] * xj[2];
    }
}

INLINE void solve_back_narrow(const Blocks *s, int j, real *x)
{
    real *xj = x + 6 * j;
    for (int p = s->first[j]; p < s->first[j + 1]; p++) {
        const real *b = s->below + (size_t)BLOCK * (size_t)p, *from = x + 6 * s->row[p];
        for (int i = 0, n = s->narrow[s->row[p]] ? 3 : 6; i < n; i++)
            for (int k = 0; k < 3; k++)
                xj[k] -= b[6 * i + k] * from[i];
    }
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
