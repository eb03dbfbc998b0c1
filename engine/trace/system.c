/* trace/system.c - the direct solve A x = b, A = J M^-1 G.
 *
 * Without sliding friction A is symmetric and is factored within its profile (L D L^T): rows come in order along chains and
 * stacks, so that the cost grows with their length. Sliding friction folds into the column of its normal force, and A is
 * factored by L U with partial pivoting.
 *
 * Rows that repeat each other (four corners on a face, a door on eight hinges) make A singular. Then every diagonal entry
 * is softened by a small part of itself and the solution refined with the unsoftened A: a proximal-point iteration whose limit
 * keeps the constraints exactly and shares the load with least norm (Rockafellar 1976). Many such rows on the same bodies are
 * reduced to their rank instead (rank.c). Where rows that should repeat each other
 * differ a little, because the bodies have drifted off a loop, what is left is that difference: it moves nothing.
 */
#include "base/wide.h"
#include "math/pair.h"
#include "trace/system.h"
#include "trace/trace.h"

#define SINGULAR     1e-10      /* a pivot below this part of its diagonal: the row repeats others */
#define REFINE_MOST  16
#define SOFTENING    1e-7       /* part of the diagonal */
#define ENOUGH       2e-15

static inline bool same_bodies(const Line *i, const Line *k)
{
    if (i->count != k->count)
        return false;
    for (int m = 0; m < i->count; m++)
        if (i->body[m] != k->body[m])
            return false;
    return true;
}

/* Adds to (or, at first, makes) one or two columns of A, k and the next, in the rows i .. i_end: what their p-th body and the q-th of those
 * rows, the same one, do. */
INLINE void couple_columns(System *s, int i, int i_end, int p, int k, int columns, int q, bool first)
{
    const real *m = &s->lines[k].m[q].lin.x, *n = &s->lines[k + columns - 1].m[q].lin.x;
    const pair m0 = two(m), m1 = two(m + 2), m2 = two(m + 4), n0 = two(n), n1 = two(n + 2), n2 = two(n + 4);
    real *a = s->a + i * s->count + k;
    for (const Line *own = &s->lines[i]; i < i_end; i++, own++, a += s->count) {
        const real *j = &own->j[p].lin.x;
        const pair j0 = two(j), j1 = two(j + 2), j2 = two(j + 4), x = j0 * m0 + j1 * m1 + j2 * m2;
        if (columns == 2) {
            const pair y = j0 * n0 + j1 * n1 + j2 * n2;
            pair sum = (pair){x[0], y[0]} + (pair){x[1], y[1]};
            if (!first)
                sum += PAIR(a[0]);
            PAIR(a[0]) = sum;
        } else {
            a[0] = first ? x[0] + x[1] : a[0] + (x[0] + x[1]);
        }
    }
}

/* The rows i .. i_end of A in the columns k .. k_end, all rows of the same bodies, and so all columns. Where A is symmetric up to the
 * diagonal, or one beyond, which nobody reads. */
static inline void couple_body(System *s, int i, int i_end, int p, int k, int k_end, int q, bool first)
{
    for (; k < k_end; k += 2) {
        int from = s->sliding ? i : int_max(i, k);
        if (k + 1 == k_end)
            couple_columns(s, from, i_end, p, k, 1, q, first);
        else if (first)
            couple_columns(s, from, i_end, p, k, 2, q, true);
        else
            couple_columns(s, from, i_end, p, k, 2, q, false);
    }
}

/* All that they have in common. False: nothing. */
static bool couple(System *s, int i, int i_end, int k, int k_end)
{
    const Line *own = &s->lines[i], *other = &s->lines[k];
    bool first = true;
    for (int p = 0; p < own->count; p++)
        for (int q = 0; q < other->count; q++)
            if (own->body[p] == other->body[q]) {
                couple_body(s, i, i_end, p, k, k_end, q, first);
                first = false;
            }
    for (; first && i < i_end; i++)
        memset(s->a + i * s->count + k, 0, (size_t)(k_end - k) * sizeof *s->a);
    return !first;
}

/* Rows of one joint or patch follow each other and have the same bodies: where each such run ends. */
static void find_runs(System *s)
{
    for (int i = s->count - 1; i >= 0; i--)
        s->run[i] = i + 1 < s->count && same_bodies(&s->lines[i], &s->lines[i + 1]) ? s->run[i + 1] : i + 1;
}

/* a holds the rows by their own stride `count`. */
static void assemble(System *s)
{
    if (s->count > 0 && s->run[0] == s->count && s->lines[0].count > 0 && !s->sliding) {       /* one joint or contact */
        memset(s->first, 0, (size_t)s->count * sizeof *s->first);
        for (int p = 0; p < s->lines[0].count; p++)
            couple_body(s, 0, s->count, p, 0, s->count, p, p == 0);
        return;
    }
    for (int i = 0; i < s->count; i = s->run[i]) {
        int first = s->sliding ? 0 : s->count;
        for (int k = 0; k < (s->sliding ? s->count : s->run[i]); k = s->run[k])
            if (couple(s, i, s->run[i], k, s->run[k]))
                first = int_min(first, k);
        for (int k = i; k < s->run[i]; k++)
            s->first[k] = int_min(first, k);
    }
}

/* L D L^T within the profile, D inverted. False: a pivot vanished. */
static bool factor_symmetric(System *s)
{
    int n = s->count;
    real softer = s->redundant ? 1 + SOFTENING : 1, least = s->redundant ? 0 : SINGULAR;
    if (small_size(n))
        return small_factor(s->a, s->f, softer, least, n);
    for (int i = 0; i < n; i++) {
        const real *a = s->a + i * n, *lk;
        real *li = s->f + i * n, diagonal = a[i] * softer, pivot = diagonal;
        int first = s->first[i];
        lk = s->f + first * n;
        for (int k = first; k < i; k++, lk += n) {      /* (L D)_ik */
            real sum = a[k];
            for (int m = int_max(first, s->first[k]); m < k; m++)
                sum -= li[m] * lk[m];
            li[k] = sum;
        }
        lk = s->f + first * (n + 1);
        for (int k = first; k < i; k++, lk += n + 1) {
            real l = li[k] * *lk;
            pivot -= l * li[k];
            li[k] = l;
        }
        if (!(pivot > least * diagonal))
            return false;
        li[i] = 1 / pivot;
    }
    return true;
}

#define PANEL 4                  /* pivots whose rows are taken off the others at once: one at a time, each number was read and written for two operations */
#define PANELS_FROM 24           /* rows: fewer are done sooner one at a time */

/* row -= l[0] top[0] - l[1] top[1] ..., one after the other; tops: n apart */
INLINE void take_off(real *restrict row, const real *l, const real *restrict top, int n, int pivots, int from, int end)
{
    if (pivots == PANEL)
        for (int m = from; m < end; m++)
            row[m] = row[m] - l[0] * top[m] - l[1] * top[n + m] - l[2] * top[2 * n + m] - l[3] * top[3 * n + m];
    else
        for (int p = 0; p < pivots; p++, top += n)
            for (int m = from; m < end; m++)
                row[m] -= l[p] * top[m];
}

static void swap_rows(real *a, real *b, int n)
{
    for (int k = 0; k < n && a != b; k++) {
        real x = a[k];
        a[k] = b[k];
        b[k] = x;
    }
}

/* The largest number of a column from its diagonal down comes onto that. False: it is as good as none. */
INLINE bool take_pivot(System *s, int i)
{
    int n = s->count, best = i;
    real *top = s->f + i * n, most = fabs(top[i]);
    for (int k = i + 1; k < n; k++)
        if (fabs(s->f[k * n + i]) > most) {
            most = fabs(s->f[k * n + i]);
            best = k;
        }
    s->swap[i] = best;
    swap_rows(top, s->f + best * n, n);
    return fabs(top[i]) > (s->redundant ? 1e-300 : SINGULAR * fabs(s->a[i * n + i]));
}

/* One pivot at a time: what panels do, too, but they are made for long rows. */
static bool factor_few(System *s)
{
    int n = s->count;
    for (int i = 0; i < n; i++) {
        if (!take_pivot(s, i))
            return false;
        const real *top = s->f + i * n;
        for (int k = i + 1; k < n; k++) {
            real *row = s->f + k * n, l = row[i] /= top[i];
            int m = i + 1;
            if (l != 0 && (n - m) % 2 == 1) {
                row[m] -= l * top[m];
                m++;
            }
            for (; l != 0 && m < n; m += 2)
                PAIR(row[m]) -= (pair){l, l} * two(top + m);
        }
    }
    return true;
}

/* Pivots of the columns from .. end, and these columns of all rows below. False: one vanished. */
INLINE bool factor_panel(System *s, int from, int end)
{
    int n = s->count;
    for (int i = from; i < end; i++) {
        if (!take_pivot(s, i))
            return false;
        const real *top = s->f + i * n;
        real pivot = top[i];
        for (int k = i + 1; k < n; k++) {
            real *row = s->f + k * n, l = row[i] /= pivot;
            for (int m = i + 1; m < end; m++)
                row[m] -= l * top[m];
        }
    }
    return true;
}

/* L U with partial pivoting. Where not all touch all, most of a row is zero: what comes after the last number of the topmost ones is left alone. */
INLINE bool factor_lu(System *s)
{
    int n = s->count;
    real *f = s->f;
    memcpy(f, s->a, (size_t)n * (size_t)n * sizeof *f);
    for (int i = 0; s->redundant && i < n; i++)
        f[i * n + i] *= 1 + SOFTENING;
    if (n < PANELS_FROM)
        return factor_few(s);
    for (int i = 0, next; i < n; i = next) {
        next = int_min(i + PANEL, n);
        int end = next;
        real *top = f + i * n;
        if (!factor_panel(s, i, next))
            return false;
        for (int k = i; k < next; k++) {
            take_off(f + k * n, f + k * n + i, top, n, k - i, next, n);
            for (int m = n; m > end; m--)
                end = f[k * n + m - 1] != 0 ? m : end;
        }
        for (int k = next; k < n; k++) {
            const real *l = f + k * n + i;
            real sum = 0;
            for (int p = 0; p < next - i; p++)
                sum += fabs(l[p]);
            if (sum > 0)
                take_off(f + k * n, l, top, n, next - i, next, end);
        }
    }
    return true;
}

static bool factor_plain(System *s) { return factor_lu(s); }
WIDE static bool factor_wide(System *s) { return factor_lu(s); }
static bool factor_general(System *s) { return (s->count >= PANELS_FROM && has_wide() ? factor_wide : factor_plain)(s); }

/* All rows are of the same bodies, and their rank can be told. */
static bool factor_by_rank(System *s)
{
    bool alike = s->redundant && !s->sliding && s->count >= RANK_ROWS && s->run[0] == s->count && s->lines[0].count > 0;
    s->rank = alike ? rank_factor(s->lines, s->f, s->count) : 0;
    return s->rank > 0;
}

static bool factor(System *s) { return s->sliding ? factor_general(s) : factor_symmetric(s); }

/* A row without any effect holds nothing: it stands for itself. Its pivot is none, and so it is looked for where one vanished. */
static bool stand_alone(System *s)
{
    bool any = false;
    for (int i = 0; i < s->count && !s->sliding; i++)
        if (!(s->a[i * s->count + i] > 0)) {
            s->a[i * s->count + i] = 1;
            any = true;
        }
    return any;
}

bool system_factor(System *s)
{
    find_runs(s);
    if (factor_by_rank(s))
        return true;
    assemble(s);
    if (factor(s) || (stand_alone(s) && factor(s)))
        return true;
    if (s->redundant)
        return false;
    s->redundant = true;
    return factor_by_rank(s) || factor(s);
}

static void back_symmetric(const System *s, real *x)
{
    int n = s->count;
    const real *f = s->f;
    for (int i = 0; i < n; i++, f += n) {
        real sum = x[i];
        for (int k = s->first[i]; k < i; k++)
            sum -= f[k] * x[k];
        x[i] = sum;
    }
    f -= n;
    for (int i = 0; i < n; i++)
        x[i] *= s->f[i * (n + 1)];
    for (int i = n - 1; i > 0; i--, f -= n) {
        real v = x[i];
        for (int k = s->first[i]; k < i; k++)
            x[k] -= f[k] * v;
    }
}

#define ROWS 4                  /* whose sums go on beside each other: one alone waits for each of its additions */

/* to[i] -= a[i n + k] x[k], k = 0 .. count - 1 in this order, for ROWS rows */
static void subtract_rows(const real *a, const real *x, real *to, int n, int count)
{
    real s0 = to[0], s1 = to[1], s2 = to[2], s3 = to[3];
    for (int k = 0; k < count; k++) {
        s0 -= a[k] * x[k];
        s1 -= a[n + k] * x[k];
        s2 -= a[2 * n + k] * x[k];
        s3 -= a[3 * n + k] * x[k];
    }
    to[0] = s0;
    to[1] = s1;
    to[2] = s2;
    to[3] = s3;
}

static void back_general(const System *s, real *x)
{
    int n = s->count;
    for (int i = 0; i < n; i++)
        if (s->swap[i] != i) {
            real v = x[i];
            x[i] = x[s->swap[i]];
            x[s->swap[i]] = v;
        }
    const real *f = s->f;
    for (int i = 0; i < n; i++) {
        int whole = n / ROWS * ROWS, done = i < whole ? i / ROWS * ROWS : 0;
        if (i == done && i < whole)
            subtract_rows(f + i * n, x, x + i, n, i);
        for (int k = done; k < i; k++)
            x[i] -= f[i * n + k] * x[k];
    }
    f += n * n;
    for (int i = n - 1; i >= 0; i--) {
        f -= n;
        real sum = x[i];
        for (int k = i + 1; k < n; k++)
            sum -= f[k] * x[k];
        x[i] = sum / f[i];
    }
}

/* r = b - A x */
static void remainder_symmetric(const System *s)
{
    int n = s->count;
    const real *a = s->a, *x = s->x;
    for (int i = 0; i < n; i++, a += n) {
        real sum = s->b[i] - a[i] * x[i];
        for (int k = s->first[i]; k < i; k++) {
            sum -= a[k] * x[k];
            s->r[k] -= a[k] * x[i];
        }
        s->r[i] = sum;
    }
}

static void remainder_general(const System *s)
{
    int n = s->count, whole = n / ROWS * ROWS;
    memcpy(s->r, s->b, (size_t)n * sizeof *s->r);
    for (int i = 0; i < whole; i += ROWS)
        subtract_rows(s->a + i * n, s->x, s->r + i, n, n);
    for (int i = whole; i < n; i++)
        for (int k = 0; k < n; k++)
            s->r[i] -= s->a[i * n + k] * s->x[k];
}

/* Its largest entry. */
static real remainder_of(const System *s)
{
    if (s->rank > 0)
        rank_remainder(s->lines, s->b, s->x, s->r, s->count);
    else if (s->sliding)
        remainder_general(s);
    else if (small_size(s->count))
        small_remainder(s->a, s->b, s->x, s->r, s->count);
    else
        remainder_symmetric(s);
    real worst = 0;
    for (int i = 0; i < s->count; i++)
        worst = real_max(worst, fabs(s->r[i]));
    return worst;
}

static void back(const System *s, real *x)
{
    if (s->rank > 0)
        rank_back(s->f, x, s->count, s->rank);
    else if (s->sliding)
        back_general(s, x);
    else if (small_size(s->count))
        small_back(s->f, x, s->count);
    else
        back_symmetric(s, x);
}

static bool solved(System *s, real accept)
{
    int n = s->count;
    real scale = 0;
    for (int i = 0; i < n; i++) {
        s->x[i] = s->b[i];
        scale = real_max(scale, fabs(s->b[i]));
    }
    s->residual = 0;
    if (!(scale > 0))
        return scale == 0;
    back(s, s->x);
    real worst = remainder_of(s), last = scale, good = (s->redundant ? ENOUGH : 1e-13) * scale;
    for (int pass = 1; pass < REFINE_MOST && worst > good && worst < 0.5 * last; pass++) {
        memcpy(s->dx, s->r, (size_t)n * sizeof *s->dx);
        back(s, s->dx);
        for (int i = 0; i < n; i++)
            s->x[i] += s->dx[i];
        last = worst;
        worst = remainder_of(s);
    }
    s->residual = worst / scale;
    return s->residual <= (s->redundant ? accept : 1e-8);
}

/* Rows that nearly repeat others may pass for independent ones, by pivots just large enough: then the solution tells. */
bool system_solve(System *s, real accept)
{
    if (solved(s, accept))
        return true;
    if (s->redundant)
        return false;
    s->redundant = true;
    return (factor_by_rank(s) || factor(s)) && solved(s, accept);
}
