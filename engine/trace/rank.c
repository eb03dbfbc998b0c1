/* trace/rank.c - many rows on the same bodies, most of which repeat others: a door on eight hinges has forty rows, five of them free.
 *
 * A, scaled to a diagonal of ones, is L L^T with no more columns in L than a rigid body has freedoms: a Cholesky factorisation with
 * pivots, left where nothing is left. Then A^+ = L (L^T L)^-2 L^T, so that the load is shared with the least norm at once: (rows) x 36
 * multiplications where the whole factor has a sixth of the cube of the rows. Nor is A itself needed: of its columns those of the pivots
 * are, and what it does to the forces goes by way of the bodies.
 */
#include "math/pair.h"
#include "trace/system.h"
#include "trace/trace.h"

#define RANK_MOST 6
#define CLEAR     1e-5          /* a pivot above this part of its diagonal counts, */
#define NOTHING   1e-12         /* below this it is rounding: in between no rank can be told */

/* f: L by rows of RANK_MOST, zero where it has no columns, what scales each row, what is left of its diagonal, and the factor of L^T L. */
static real *scale_in(real *f, int n) { return f + RANK_MOST * n; }
static real *rest_in(real *f, int n) { return scale_in(f, n) + n; }
static real *gram_in(real *f, int n) { return rest_in(f, n) + n; }

_Static_assert(RANK_ROWS * RANK_ROWS >= (RANK_MOST + 2) * RANK_ROWS + RANK_MOST * RANK_MOST, "all of it lies in f");

INLINE real sum_of(pair p) { return p[0] + p[1]; }

/* Of six numbers each. */
INLINE real dot_six(const real *a, const real *b) { return sum_of(two(a) * two(b) + two(a + 2) * two(b + 2) + two(a + 4) * two(b + 4)); }

/* A_ii */
INLINE real diagonal_of(const Line *l)
{
    real sum = 0;
    for (int m = 0; m < l->count; m++)
        sum += dot_six(&l->j[m].lin.x, &l->m[m].lin.x);
    return sum;
}

typedef struct Moved { real of[ROW_BODIES][6]; } Moved;      /* of the bodies */

/* Column `rank` of L, from the pivot p: each row times one motion, M^-1 G of the pivot's less what the columns before have of it. Returns
 * the row of which the most is left. */
static int add_column(const Line *lines, real *f, int n, int p, int rank, Moved columns[RANK_MOST])
{
    real *scale = scale_in(f, n), *rest = rest_in(f, n), root = 1 / sqrt(rest[p]), most = -1;
    int bodies = lines[0].count, best = 0;
    Moved *own = &columns[rank];
    for (int m = 0; m < bodies; m++) {
        const real *moves = (const real *)(const void *)&lines[p].m[m];
        for (int c = 0; c < 6; c++) {
            real sum = scale[p] * moves[c];
            for (int k = 0; k < rank; k++)
                sum -= columns[k].of[m][c] * f[RANK_MOST * p + k];
            own->of[m][c] = root * sum;
        }
    }
    for (int i = 0; i < n; i++, f += RANK_MOST) {
        const Arrow *j = lines[i].j;
        real sum = dot_six(&j[0].lin.x, own->of[0]);
        for (int m = 1; m < bodies; m++)
            sum += dot_six(&j[m].lin.x, own->of[m]);
        sum *= scale[i];
        f[rank] = sum;
        real left = rest[i] - sum * sum;
        rest[i] = left;
        if (left > most) {
            most = left;
            best = i;
        }
    }
    rest[p] = 0;                /* but for rounding: where that is the most, nothing is left of the others, either */
    return best;
}

/* Cholesky's factor of L^T L, its diagonal inverted. */
static void factor_gram(real *f, int n, int rank)
{
    real *g = gram_in(f, n);
    pair sum[RANK_MOST][RANK_MOST / 2] = {{{0}}};
    for (int row = 0; row < n; row++) {
        const real *l = f + RANK_MOST * row;
        UNROLL
        for (int i = 0; i < RANK_MOST; i++) {
            const pair own = {l[i], l[i]};
            UNROLL
            for (int k = 0; k <= i / 2; k++)
                sum[i][k] += own * two(l + 2 * k);
        }
    }
    for (int i = 0; i < rank; i++)
        for (int k = 0; k <= i; k++) {
            real left = sum[i][k / 2][k % 2];
            for (int m = 0; m < k; m++)
                left -= g[RANK_MOST * i + m] * g[RANK_MOST * k + m];
            g[RANK_MOST * i + k] = i == k ? 1 / sqrt(left) : left * g[RANK_MOST * k + k];
        }
}

int rank_factor(const Line *lines, real *f, int n)
{
    real *scale = scale_in(f, n), *rest = rest_in(f, n);
    memset(f, 0, (size_t)(RANK_MOST * n) * sizeof *f);
    for (int i = 0; i < n; i++) {
        real own = diagonal_of(&lines[i]);
        if (!(own > 0))
            return 0;
        scale[i] = 1 / sqrt(own);
        rest[i] = 1;
    }
    Moved columns[RANK_MOST];
    int rank = 0, p = 0;
    for (; rank < RANK_MOST && rest[p] > CLEAR; rank++)
        p = add_column(lines, f, n, p, rank, columns);
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
    for (int i = 0; i < n; i++) {
        const pair by = {scale[i] * x[i], scale[i] * x[i]};
        for (int m = 0; m < RANK_MOST; m += 2)
            PAIR(z[m]) += by * two(f + RANK_MOST * i + m);
    }
    solve_gram(g, z, rank);
    solve_gram(g, z, rank);
    for (int i = 0; i < n; i++)
        x[i] = scale[i] * dot_six(f + RANK_MOST * i, z);
}

void rank_remainder(const Line *lines, const real *b, const real *x, real *r, int n)
{
    memcpy(r, b, (size_t)n * sizeof *r);
    for (int m = 0; m < lines[0].count; m++) {
        real moved[6] = {0};            /* this body, by all forces */
        for (int i = 0; i < n; i++) {
            const pair by = {x[i], x[i]};
            for (int c = 0; c < 6; c += 2)
                PAIR(moved[c]) += by * two(&lines[i].m[m].lin.x + c);
        }
        for (int i = 0; i < n; i++)
            r[i] -= dot_six(&lines[i].j[m].lin.x, moved);
    }
}
