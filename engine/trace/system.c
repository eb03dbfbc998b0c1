/* trace/system.c - the direct solve A x = b, A = J M^-1 G.
 *
 * Without sliding friction A is symmetric and is factored within its profile (Cholesky): rows come in order along chains and
 * stacks, so that the cost grows with their length. Sliding friction folds into the column of its normal force, and A is
 * factored by L U with partial pivoting.
 *
 * Rows that repeat each other (four corners on a face, a door on eight hinges) make A singular. Then every diagonal entry
 * is softened by a small part of itself and the solution refined with the unsoftened A: a proximal-point iteration whose limit
 * keeps the constraints exactly and shares the load with least norm (Rockafellar 1976). Where rows that should repeat each other
 * differ a little, because the bodies have drifted off a loop, what is left is that difference: it moves nothing.
 */
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

/* Rows i .. i_end of A in the columns k .. k_end, where all rows have the same bodies, and so have all columns. */
static void couple(System *s, int i, int i_end, int k, int k_end)
{
    const Line *own = &s->lines[i], *other = &s->lines[k];
    int count = 0, m[ROW_BODIES * ROW_BODIES], n[ROW_BODIES * ROW_BODIES];
    for (int p = 0; p < own->count; p++)
        for (int q = 0; q < other->count; q++)
            if (own->body[p] == other->body[q]) {
                m[count] = p;
                n[count++] = q;
            }
    for (; i < i_end; i++, own++) {
        real *a = s->a + i * s->count;
        int last = s->sliding ? k_end : int_min(k_end, i + 1);
        other = &s->lines[k];
        for (int c = k; c < last; c++, other++) {
            real sum = 0;
            for (int p = 0; p < count; p++)
                sum += vec3_dot(own->lin[m[p]], other->mlin[n[p]]) + vec3_dot(own->ang[m[p]], other->mang[n[p]]);
            a[c] = sum;
        }
        if (count > 0)
            s->first[i] = int_min(s->first[i], k);
    }
}

/* From `from` on. Rows of one joint or patch follow each other and have the same bodies. */
static int run_end(const System *s, int from)
{
    int end = from + 1;
    while (end < s->count && same_bodies(&s->lines[end], &s->lines[from]))
        end++;
    return end;
}

/* a holds the rows by their own stride `count`. */
static void assemble(System *s)
{
    for (int i = 0; i < s->count; i++)
        s->first[i] = s->sliding ? 0 : i;
    for (int i = 0, i_end; i < s->count; i = i_end) {
        i_end = run_end(s, i);
        for (int k = 0, k_end; k < (s->sliding ? s->count : i_end); k = k_end) {
            k_end = run_end(s, k);
            couple(s, i, i_end, k, k_end);
        }
    }
}

/* Cholesky within the profile, the diagonal inverted. False: a pivot vanished. */
static bool factor_symmetric(System *s)
{
    int n = s->count;
    real softer = s->redundant ? 1 + SOFTENING : 1, least = s->redundant ? 0 : SINGULAR;
    for (int i = 0; i < n; i++) {
        const real *a = s->a + i * n;
        real *li = s->f + i * n, diagonal = a[i] * softer, pivot = diagonal;
        int first = s->first[i];
        for (int k = first; k < i; k++) {
            const real *lk = s->f + k * n;
            real sum = a[k];
            for (int m = int_max(first, s->first[k]); m < k; m++)
                sum -= li[m] * lk[m];
            li[k] = sum * lk[k];
            pivot -= li[k] * li[k];
        }
        if (!(pivot > least * diagonal))
            return false;
        li[i] = 1 / sqrt(pivot);
    }
    return true;
}

static bool factor_general(System *s)
{
    int n = s->count;
    memcpy(s->f, s->a, (size_t)n * (size_t)n * sizeof *s->f);
    for (int i = 0; s->redundant && i < n; i++)
        s->f[i * n + i] *= 1 + SOFTENING;
    for (int i = 0; i < n; i++) {
        int best = i;
        for (int k = i + 1; k < n; k++)
            if (fabs(s->f[k * n + i]) > fabs(s->f[best * n + i]))
                best = k;
        s->swap[i] = best;
        if (best != i)
            for (int k = 0; k < n; k++) {
                real x = s->f[i * n + k];
                s->f[i * n + k] = s->f[best * n + k];
                s->f[best * n + k] = x;
            }
        real pivot = s->f[i * n + i];
        if (!(fabs(pivot) > (s->redundant ? 1e-300 : SINGULAR * fabs(s->a[i * n + i]))))
            return false;
        for (int k = i + 1; k < n; k++) {
            real l = s->f[k * n + i] /= pivot;
            if (l != 0)
                for (int m = i + 1; m < n; m++)
                    s->f[k * n + m] -= l * s->f[i * n + m];
        }
    }
    return true;
}

bool system_factor(System *s)
{
    assemble(s);
    for (int i = 0; i < s->count; i++)      /* a row without any effect holds nothing: it stands for itself */
        if (!(s->a[i * s->count + i] > 0) && !s->sliding)
            s->a[i * s->count + i] = 1;
    if (s->sliding ? factor_general(s) : factor_symmetric(s))
        return true;
    if (s->redundant)
        return false;
    s->redundant = true;
    return s->sliding ? factor_general(s) : factor_symmetric(s);
}

static void back_symmetric(const System *s, real *x)
{
    int n = s->count;
    const real *f = s->f;
    for (int i = 0; i < n; i++, f += n) {
        real sum = x[i];
        for (int k = s->first[i]; k < i; k++)
            sum -= f[k] * x[k];
        x[i] = sum * f[i];
    }
    for (int i = n - 1; i >= 0; i--) {
        f -= n;
        real v = x[i] *= f[i];
        for (int k = s->first[i]; k < i; k++)
            x[k] -= f[k] * v;
    }
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
    for (int i = 0; i < n; i++)
        for (int k = 0; k < i; k++)
            x[i] -= s->f[i * n + k] * x[k];
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++)
            x[i] -= s->f[i * n + k] * x[k];
        x[i] /= s->f[i * n + i];
    }
}

/* r = b - A x; returns its largest entry. */
static real remainder_of(const System *s)
{
    int n = s->count;
    const real *a = s->a, *x = s->x;
    real worst = 0;
    for (int i = 0; i < n; i++, a += n) {
        real sum = s->b[i] - a[i] * x[i];
        for (int k = s->first[i]; k < i; k++) {
            sum -= a[k] * x[k];
            if (!s->sliding)
                s->r[k] -= a[k] * x[i];
        }
        for (int k = i + 1; s->sliding && k < n; k++)
            sum -= a[k] * x[k];
        s->r[i] = sum;
    }
    for (int i = 0; i < n; i++)
        worst = real_max(worst, fabs(s->r[i]));
    return worst;
}

static void back(const System *s, real *x)
{
    if (s->sliding)
        back_general(s, x);
    else
        back_symmetric(s, x);
}

bool system_solve(System *s, real accept)
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
