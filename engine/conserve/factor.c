/* conserve/factor.c - block elimination of the step's linear system in the order of conserve/order.c.
 *
 * Unsymmetric: rows are exchanged inside a block only. Golub & Van Loan, Matrix Computations, ch. 3. */
#include "conserve/system.h"
#include "math/pair.h"

#define SIZE_MOST TIE_ROWS      /* rows of a block: 6 of a body, at most as many of a joint */

/* d of n x n becomes L U of its rows in the order `row`; the diagonal of U is inverted apart from it. */
INLINE bool decompose(real *restrict d, int n, int *restrict row, real *restrict inverse)
{
    for (int k = 0; k < n; k++)
        row[k] = k;
    UNROLL
    for (int k = 0; k < n; k++) {
        int best = k;
        for (int i = k + 1; i < n; i++)
            if (fabs(d[i * n + k]) > fabs(d[best * n + k]))
                best = i;
        real pivot = d[best * n + k];
        if (!(fabs(pivot) > 1e-280) || !isfinite(pivot))
            return false;
        if (best != k) {
            int r = row[k];
            row[k] = row[best];
            row[best] = r;
            for (int c = 0; c < n; c++) {
                real t = d[k * n + c];
                d[k * n + c] = d[best * n + c];
                d[best * n + c] = t;
            }
        }
        inverse[k] = 1 / pivot;
        UNROLL
        for (int i = k + 1; i < n; i++) {
            real f = d[i * n + k] / pivot;
            d[i * n + k] = f;
            UNROLL
            for (int c = k + 1; c < n; c++)
                d[i * n + c] -= f * d[k * n + c];
        }
    }
    return true;
}

/* One or two columns of u, next to each other in n rows of `width`, become x with d x = u. */
INLINE void solve_columns(const real *restrict d, int n, const int *restrict row, const real *restrict inverse, real *restrict u, int width,
                          int columns)
{
    pair x[SIZE_MOST];
    UNROLL
    for (int k = 0; k < n; k++)
        x[k] = columns == 2 ? PAIR(u[row[k] * width]) : (pair){u[row[k] * width], 0};
    UNROLL
    for (int k = 0; k < n; k++) {
        UNROLL
        for (int i = k + 1; i < n; i++)
            x[i] -= d[i * n + k] * x[k];
    }
    UNROLL
    for (int k = n - 1; k >= 0; k--) {
        x[k] *= inverse[k];
        UNROLL
        for (int i = 0; i < k; i++)
            x[i] -= d[i * n + k] * x[k];
    }
    UNROLL
    for (int k = 0; k < n; k++) {
        if (columns == 2)
            PAIR(u[k * width]) = x[k];
        else
            u[k * width] = x[k][0];
    }
}

/* Solves d x = [u | b] in place; d is n x n. */
INLINE bool solve_sized(real *restrict d, int n, real *restrict u, int width, real *restrict b)
{
    int row[SIZE_MOST], at = 0;
    real inverse[SIZE_MOST];
    if (!decompose(d, n, row, inverse))
        return false;
    for (; at + 2 <= width; at += 2)
        solve_columns(d, n, row, inverse, u + at, width, 2);
    if (at < width)
        solve_columns(d, n, row, inverse, u + at, width, 1);
    solve_columns(d, n, row, inverse, b, 1, 1);
    return true;
}

static bool solve_block(real *d, int n, real *u, int width, real *b)
{
    switch (n) {
    case 1: return solve_sized(d, 1, u, width, b);
    case 2: return solve_sized(d, 2, u, width, b);
    case 3: return solve_sized(d, 3, u, width, b);
    case 4: return solve_sized(d, 4, u, width, b);
    case 5: return solve_sized(d, 5, u, width, b);
    default: return solve_sized(d, SIZE_MOST, u, width, b);
    }
}

/* to -= l x, l: rows x n, x: n rows of `width` of which `columns` are used */
INLINE void subtract_sized(real *restrict to, int stride, const real *restrict l, int l_stride, int rows, int n, const real *restrict x, int width, int columns)
{
    for (int i = 0; i < rows; i++, to += stride, l += l_stride) {
        int c = 0;
        for (; c + 2 <= columns; c += 2) {
            pair sum = PAIR(to[c]);
            UNROLL
            for (int k = 0; k < n; k++)
                sum -= l[k] * PAIR(x[k * width + c]);
            PAIR(to[c]) = sum;
        }
        if (c < columns) {
            real sum = to[c];
            UNROLL
            for (int k = 0; k < n; k++)
                sum -= l[k] * x[k * width + c];
            to[c] = sum;
        }
    }
}

static void subtract_product(real *to, int stride, const real *l, int rows, int n, const real *x, int width, int columns)
{
    switch (n) {
    case 1: subtract_sized(to, stride, l, 1, rows, 1, x, width, columns); return;
    case 2: subtract_sized(to, stride, l, 2, rows, 2, x, width, columns); return;
    case 3: subtract_sized(to, stride, l, 3, rows, 3, x, width, columns); return;
    case 4: subtract_sized(to, stride, l, 4, rows, 4, x, width, columns); return;
    case 5: subtract_sized(to, stride, l, 5, rows, 5, x, width, columns); return;
    default: subtract_sized(to, stride, l, SIZE_MOST, rows, SIZE_MOST, x, width, columns);
    }
}

/* to -= x y, x: rows of `width` of which the first n are used */
static void subtract_known(real *to, int rows, const real *x, int width, const real *y, int n)
{
    if (n == SIZE_MOST)
        subtract_sized(to, 1, x, width, rows, SIZE_MOST, y, 1, 1);
    else if (n == 3)
        subtract_sized(to, 1, x, width, rows, 3, y, 1, 1);
    else
        for (int i = 0; i < n; i++)
            subtract_sized(to, 1, x + i, width, rows, 1, y + i, 1, 1);
}

bool factor_solve(System *s)
{
    for (int k = 0; k < s->node_count; k++) {
        const Elimination *e = &s->order[k];
        const Later *later = s->later + e->first;
        real *x = s->value + e->upper, *b = s->side + 6 * e->node;
        if (!solve_block(s->value + e->diagonal, e->size, x, e->width, b))
            return false;
        for (int i = 0; i < e->count; i++) {
            const real *l = s->value + e->lower + later[i].column * e->size;
            for (int j = 0; j < e->count; j++) {
                Block t = s->target[e->pair + i * e->count + j];
                subtract_product(s->value + t.at, t.stride, l, later[i].size, e->size, x + later[j].column, e->width, later[j].size);
            }
            subtract_product(s->side + 6 * later[i].node, 1, l, later[i].size, e->size, b, 1, 1);
        }
    }
    for (int k = s->node_count - 1; k >= 0; k--) {
        const Elimination *e = &s->order[k];
        const real *x = s->value + e->upper;
        real *b = s->side + 6 * e->node;
        for (int i = 0; i < e->count; i++) {
            const Later *l = &s->later[e->first + i];
            subtract_known(b, e->size, x + l->column, e->width, s->side + 6 * l->node, l->size);
        }
    }
    return true;
}
