/* trace/rank.c - many rows on the same bodies, most of which repeat others: a door on eight hinges has forty rows, five of them free.
 *
 * A, scaled to a diagonal of ones, is L L^T with no more columns in L than a rigid body has freedoms: a Cholesky factorisation with
 * pivots, left where nothing is left. Then A^+ = L (L^T L)^-2 L^T, so that the load is shared with the least norm at once: (rows) x 36
 * multiplications where the whole factor has a sixth of the cube of the rows.
 */
#include "trace/system.h"

#define RANK_MOST 6
#define CLEAR     1e-5          /* a pivot above this part of its diagonal counts, */
#define NOTHING   1e-12         /* below this it is rounding: in between no rank can be told */

/* f: L by rows of RANK_MOST, what scales each row, what is left of its diagonal, and the factor of L^T L. */
static real *scale_in(real *f, int n) { return f + RANK_MOST * n; }
static real *rest_in(real *f, int n) { return scale_in(f, n) + n; }
static real *gram_in(real *f, int n) { return rest_in(f, n) + n; }

_Static_assert(RANK_ROWS * RANK_ROWS >= (RANK_MOST + 2) * RANK_ROWS + RANK_MOST * RANK_MOST, "all of it lies in f");

static int largest(const real *x, int n)
{
    int best = 0;
    for (int i = 1; i < n; i++)
        best = x[i] > x[best] ? i : best;
    return best;
}

/* Column `rank` of L, from the pivot p. */
static void add_column(const real *a, real *f, int n, int p, int rank)
{
    const real *scale = scale_in(f, n), *lp = f + RANK_MOST * p;
    real *rest = rest_in(f, n), root = 1 / sqrt(rest[p]);
    for (int i = 0; i < n; i++) {
        real *l = f + RANK_MOST * i, sum = scale[i] * scale[p] * (i > p ? a[i * n + p] : a[p * n + i]);
        for (int m = 0; m < rank; m++)
            sum -= l[m] * lp[m];
        l[rank] = sum * root;
        rest[i] -= l[rank] * l[rank];
    }
    rest[p] = 0;
}

/* Cholesky's factor of L^T L, its diagonal inverted. */
static void factor_gram(real *f, int n, int rank)
{
    real *g = gram_in(f, n);
    for (int i = 0; i < rank; i++)
        for (int k = 0; k <= i; k++) {
            real sum = 0;
            for (int row = 0; row < n; row++)
                sum += f[RANK_MOST * row + i] * f[RANK_MOST * row + k];
            for (int m = 0; m < k; m++)
                sum -= g[RANK_MOST * i + m] * g[RANK_MOST * k + m];
            g[RANK_MOST * i + k] = i == k ? 1 / sqrt(sum) : sum * g[RANK_MOST * k + k];
        }
}

int rank_factor(const real *a, real *f, int n)
{
    real *scale = scale_in(f, n), *rest = rest_in(f, n);
    for (int i = 0; i < n; i++) {
        scale[i] = 1 / sqrt(a[i * n + i]);
        rest[i] = 1;
    }
    int rank = 0, p = 0;
    for (; rank < RANK_MOST && rest[p] > CLEAR; rank++) {
        add_column(a, f, n, p, rank);
        p = largest(rest, n);
    }
    if (!(rest[p] <= NOTHING))
        return 0;
    factor_gram(f, n, rank);
    return rank;
}

static void solve_gram(const real *g, real *z, int rank)
{
    for (int i = 0; i < rank; i++) {
        for (int m = 0; m < i; m++)
            z[i] -= g[RANK_MOST * i + m] * z[m];
        z[i] *= g[RANK_MOST * i + i];
    }
    for (int i = rank - 1; i >= 0; i--) {
        for (int m = i + 1; m < rank; m++)
            z[i] -= g[RANK_MOST * m + i] * z[m];
        z[i] *= g[RANK_MOST * i + i];
    }
}

void rank_back(const real *f, real *x, int n, int rank)
{
    const real *scale = f + RANK_MOST * n, *g = scale + 2 * n;
    real z[RANK_MOST] = {0};
    for (int i = 0; i < n; i++)
        for (int m = 0; m < rank; m++)
            z[m] += f[RANK_MOST * i + m] * scale[i] * x[i];
    solve_gram(g, z, rank);
    solve_gram(g, z, rank);
    for (int i = 0; i < n; i++) {
        real sum = 0;
        for (int m = 0; m < rank; m++)
            sum += f[RANK_MOST * i + m] * z[m];
        x[i] = scale[i] * sum;
    }
}
