/* solve/blocks.c - sparse block Cholesky: order, pattern, factor, solve. */
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

bool blocks_plan(Blocks *s, Arena *arena, int n, unsigned char *linked)
{
    size_t size = (size_t)n;
    s->n = n;
    s->place = arena_alloc(arena, size * sizeof *s->place);
    s->first = arena_alloc(arena, (size + 1) * sizeof *s->first);
    s->at = arena_alloc(arena, size * size * sizeof *s->at);
    int *degree = arena_alloc(arena, size * sizeof *degree), *around = arena_alloc(arena, size * sizeof *around);
    if (!s->place || !s->first || !s->at || !degree || !around)
        return false;
    order(s, linked, degree, around);
    int *who = degree, blocks = 0;
    for (int i = 0; i < n; i++)
        who[s->place[i]] = i;
    s->work = 0;
    for (int j = 0; j < n; j++) {
        s->first[j] = blocks;
        for (int i = 0; i < n; i++)
            s->at[i * n + j] = i > j && linked[who[i] * n + who[j]] ? blocks++ : -1;
        real count = blocks - s->first[j];
        s->work += 72 + 126 * count + 108 * count * (count + 1);
    }
    s->first[n] = blocks;
    s->row = arena_alloc(arena, (size_t)(blocks + 1) * sizeof *s->row);
    for (int i = 0; s->row && i < n; i++)
        for (int j = 0; j < i; j++)
            if (s->at[i * n + j] >= 0)
                s->row[s->at[i * n + j]] = i;
    return s->row != NULL;
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
static bool factor_block(real *a)
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

/* X = A L^-T, row by row */
static void divide(real *a, const real *l)
{
    for (int r = 0; r < 6; r++, a += 6)
        for (int j = 0; j < 6; j++) {
            real sum = a[j];
            for (int k = 0; k < j; k++)
                sum -= a[k] * l[6 * j + k];
            a[j] = sum * l[7 * j];
        }
}

/* c -= a b^T */
static void subtract(real *restrict c, const real *restrict a, const real *restrict b)
{
    real t[BLOCK];
    for (int i = 0; i < 6; i++)
        for (int k = 0; k < 6; k++)
            t[6 * k + i] = b[6 * i + k];
    for (int i = 0; i < 6; i++)
        for (int k = 0; k < 6; k++) {
            real f = a[6 * i + k];
            for (int j = 0; j < 6; j++)
                c[6 * i + j] -= f * t[6 * k + j];
        }
}

bool blocks_factor(Blocks *s)
{
    for (int j = 0; j < s->n; j++) {
        real *l = s->diagonal + (size_t)BLOCK * (size_t)j;
        if (!factor_block(l))
            return false;
        int end = s->first[j + 1];
        for (int p = s->first[j]; p < end; p++)
            divide(s->below + (size_t)BLOCK * (size_t)p, l);
        for (int p = s->first[j]; p < end; p++) {
            const real *lp = s->below + (size_t)BLOCK * (size_t)p;
            for (int q = s->first[j]; q < p; q++)
                subtract(blocks_at(s, s->row[p], s->row[q]), lp, s->below + (size_t)BLOCK * (size_t)q);
            subtract(s->diagonal + (size_t)BLOCK * (size_t)s->row[p], lp, lp);
        }
    }
    return true;
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
        for (int p = s->first[j]; p < s->first[j + 1]; p++) {
            const real *b = s->below + (size_t)BLOCK * (size_t)p;
            real *to = x + 6 * s->row[p];
            for (int i = 0; i < 6; i++)
                for (int k = 0; k < 6; k++)
                    to[i] -= b[6 * i + k] * xj[k];
        }
    }
    for (int j = s->n - 1; j >= 0; j--) {
        const real *l = s->diagonal + (size_t)BLOCK * (size_t)j;
        real *xj = x + 6 * j;
        for (int p = s->first[j]; p < s->first[j + 1]; p++) {
            const real *b = s->below + (size_t)BLOCK * (size_t)p, *from = x + 6 * s->row[p];
            for (int i = 0; i < 6; i++)
                for (int k = 0; k < 6; k++)
                    xj[k] -= b[6 * i + k] * from[i];
        }
        for (int i = 5; i >= 0; i--) {
            for (int k = i + 1; k < 6; k++)
                xj[i] -= l[6 * k + i] * xj[k];
            xj[i] *= l[7 * i];
        }
    }
}
