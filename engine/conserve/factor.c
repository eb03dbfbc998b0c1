/* conserve/factor.c - block elimination of the step's linear system in the order of conserve/order.c.
 *
 * Unsymmetric: rows are exchanged inside a block only. Golub & Van Loan, Matrix Computations, ch. 3. */
#include "conserve/system.h"
#include "math/pair.h"

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
    pair x[BLOCK_ROWS];
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

/* Decomposes d, of n x n, and solves d x = [u | b] in place. */
INLINE bool factor_sized(real *restrict d, int n, Exchange *restrict by, real *restrict u, int width, real *restrict b)
{
    int at = 0;
    if (!decompose(d, n, by->row, by->inverse))
        return false;
    for (; at + 2 <= width; at += 2)
        solve_columns(d, n, by->row, by->inverse, u + at, width, 2);
    if (at < width)
        solve_columns(d, n, by->row, by->inverse, u + at, width, 1);
    solve_columns(d, n, by->row, by->inverse, b, 1, 1);
    return true;
}

static bool factor_block(real *d, int n, Exchange *by, real *u, int width, real *b)
{
    switch (n) {
    case 1: return factor_sized(d, 1, by, u, width, b);
    case 2: return factor_sized(d, 2, by, u, width, b);
    case 3: return factor_sized(d, 3, by, u, width, b);
    case 4: return factor_sized(d, 4, by, u, width, b);
    case 5: return factor_sized(d, 5, by, u, width, b);
    default: return factor_sized(d, BLOCK_ROWS, by, u, width, b);
    }
}

/* d x = b of a block that is decomposed. */
static void solve_block(const real *d, int n, const Exchange *by, real *b)
{
    switch (n) {
    case 1: solve_columns(d, 1, by->row, by->inverse, b, 1, 1); return;
    case 2: solve_columns(d, 2, by->row, by->inverse, b, 1, 1); return;
    case 3: solve_columns(d, 3, by->row, by->inverse, b, 1, 1); return;
    case 4: solve_columns(d, 4, by->row, by->inverse, b, 1, 1); return;
    case 5: solve_columns(d, 5, by->row, by->inverse, b, 1, 1); return;
    default: solve_columns(d, BLOCK_ROWS, by->row, by->inverse, b, 1, 1);
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
    default: subtract_sized(to, stride, l, BLOCK_ROWS, rows, BLOCK_ROWS, x, width, columns);
    }
}

/* to -= x y, x: rows of `width` of which the first n are used */
static void subtract_known(real *to, int rows, const real *x, int width, const real *y, int n)
{
    if (n == BLOCK_ROWS)
        subtract_sized(to, 1, x, width, rows, BLOCK_ROWS, y, 1, 1);
    else if (n == 3)
        subtract_sized(to, 1, x, width, rows, 3, y, 1, 1);
    else
        for (int i = 0; i < n; i++)
            subtract_sized(to, 1, x + i, width, rows, 1, y + i, 1, 1);
}

/* What an eliminated node's part b of the side takes from its later neighbours'. */
INLINE void subtract_side(System *s, const Elimination *e, const Later *l, const real *b)
{
    subtract_product(s->side + 6 * l->node, 1, s->value + e->lower + l->column * e->size, l->size, e->size, b, 1, 1);
}

static void substitute_back(System *s)
{
    for (int k = s->node_count - 1; k >= 0; k--) {
        const Elimination *e = &s->order[k];
        const real *x = s->value + e->upper;
        real *b = s->side + 6 * e->node;
        for (int i = 0; i < e->count; i++) {
            const Later *l = &s->later[e->first + i];
            subtract_known(b, e->size, x + l->column, e->width, s->side + 6 * l->node, l->size);
        }
    }
}

bool factor_solve(System *s)
{
    for (int k = 0; k < s->node_count; k++) {
        const Elimination *e = &s->order[k];
        const Later *later = s->later + e->first;
        real *x = s->value + e->upper, *b = s->side + 6 * e->node;
        if (!factor_block(s->value + e->diagonal, e->size, &s->exchange[k], x, e->width, b))
            return false;
        for (int i = 0; i < e->count; i++) {
            const real *l = s->value + e->lower + later[i].column * e->size;
            for (int j = 0; j < e->count; j++) {
                Block t = s->target[e->pair + i * e->count + j];
                subtract_product(s->value + t.at, t.stride, l, later[i].size, e->size, x + later[j].column, e->width, later[j].size);
            }
            subtract_side(s, e, &later[i], b);
        }
    }
    substitute_back(s);
    return true;
}

void factor_again(System *s)
{
    for (int k = 0; k < s->node_count; k++) {
        const Elimination *e = &s->order[k];
        real *b = s->side + 6 * e->node;
        solve_block(s->value + e->diagonal, e->size, &s->exchange[k], b);
        for (int i = 0; i < e->count; i++)
            subtract_side(s, e, &s->later[e->first + i], b);
    }
    substitute_back(s);
}
