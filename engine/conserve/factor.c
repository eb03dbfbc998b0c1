/* conserve/factor.c - block elimination of the step's linear system in the order of conserve/order.c.
 *
 * Unsymmetric: rows are exchanged inside a block only. Golub & Van Loan, Matrix Computations, ch. 3. */
#include "conserve/system.h"

static void swap_rows(real *m, int width, int i, int k)
{
    for (int c = 0; c < width; c++) {
        real t = m[i * width + c];
        m[i * width + c] = m[k * width + c];
        m[k * width + c] = t;
    }
}

/* y -= f x. Points and bodies have 3 and 6 rows: those are written out. */
static inline void subtract(real *restrict y, real f, const real *restrict x, int n)
{
    int c = 0;
    for (; c + 3 <= n; c += 3) {
        y[c] -= f * x[c];
        y[c + 1] -= f * x[c + 1];
        y[c + 2] -= f * x[c + 2];
    }
    for (; c < n; c++)
        y[c] -= f * x[c];
}

/* Solves d x = [u | b] in place; d is n x n. */
static bool solve_block(real *d, int n, real *u, int width, real *b)
{
    for (int k = 0; k < n; k++) {
        int best = k;
        for (int i = k + 1; i < n; i++)
            if (fabs(d[i * n + k]) > fabs(d[best * n + k]))
                best = i;
        real pivot = d[best * n + k];
        if (!(fabs(pivot) > 1e-280) || !isfinite(pivot))
            return false;
        if (best != k) {
            swap_rows(d, n, k, best);
            swap_rows(u, width, k, best);
            swap_rows(b, 1, k, best);
        }
        for (int i = k + 1; i < n; i++) {
            real f = d[i * n + k] / pivot;
            if (f == 0)
                continue;
            subtract(d + i * n + k + 1, f, d + k * n + k + 1, n - k - 1);
            subtract(u + i * width, f, u + k * width, width);
            b[i] -= f * b[k];
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        real f = 1 / d[k * n + k];
        for (int c = 0; c < width; c++)
            u[k * width + c] *= f;
        b[k] *= f;
        for (int i = 0; i < k; i++) {
            subtract(u + i * width, d[i * n + k], u + k * width, width);
            b[i] -= d[i * n + k] * b[k];
        }
    }
    return true;
}

/* to -= l x, l: rows x n, x: n rows of `width` of which `columns` are used */
static void subtract_product(real *to, int stride, const real *l, int rows, int n, const real *x, int width, int columns)
{
    for (int i = 0; i < rows; i++) {
        real *row = to + i * stride;
        for (int k = 0; k < n; k++) {
            real f = l[i * n + k];
            if (f == 0)
                continue;
            subtract(row, f, x + k * width, columns);
        }
    }
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
            const real *y = s->side + 6 * l->node;
            for (int r = 0; r < e->size; r++)
                for (int c = 0; c < l->size; c++)
                    b[r] -= x[r * e->width + l->column + c] * y[c];
        }
    }
    return true;
}
