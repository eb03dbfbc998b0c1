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

static real coupling(const Line *i, const Line *k)
{
    real s = 0;
    for (int m = 0; m < i->count; m++)
        for (int n = 0; n < k->count; n++)
            if (i->body[m] == k->body[n])
                s += vec3_dot(i->lin[m], k->mlin[n]) + vec3_dot(i->ang[m], k->mang[n]);
    return s;
}

static bool meet(const Line *i, const Line *k)
{
    for (int m = 0; m < i->count; m++)
        for (int n = 0; n < k->count; n++)
            if (i->body[m] == k->body[n])
                return true;
    return false;
}

/* a holds the rows by their own stride `count`. */
static void assemble(System *s)
{
    int n = s->count;
    for (int i = 0; i < n; i++) {
        s->lines[i].soft = SOFTENING * coupling(&s->lines[i], &s->lines[i]);
        int first = i;
        if (s->sliding)
            first = 0;
        else
            for (int k = 0; k < i && first == i; k++)
                if (meet(&s->lines[i], &s->lines[k]))
                    first = k;
        s->first[i] = first;
        int last = s->sliding ? n - 1 : i;
        for (int k = first; k <= last; k++)
            s->a[i * n + k] = coupling(&s->lines[i], &s->lines[k]);
    }
}

/* Cholesky within the profile. False: a pivot vanished. */
static bool factor_symmetric(System *s)
{
    int n = s->count;
    for (int i = 0; i < n; i++) {
        real *li = s->f + i * n;
        real diagonal = s->a[i * n + i] + (s->redundant ? s->lines[i].soft : 0), pivot = diagonal;
        for (int k = s->first[i]; k < i; k++) {
            const real *lk = s->f + k * n;
            real sum = s->a[i * n + k];
            for (int m = int_max(s->first[i], s->first[k]); m < k; m++)
                sum -= li[m] * lk[m];
            li[k] = sum / lk[k];
            pivot -= li[k] * li[k];
        }
        if (!(pivot > (s->redundant ? 0 : SINGULAR) * diagonal))
            return false;
        li[i] = sqrt(pivot);
    }
    return true;
}

static bool factor_general(System *s)
{
    int n = s->count;
    memcpy(s->f, s->a, (size_t)n * (size_t)n * sizeof *s->f);
    for (int i = 0; s->redundant && i < n; i++)
        s->f[i * n + i] += s->lines[i].soft;
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
    for (int i = 0; i < n; i++) {
        real sum = x[i];
        for (int k = s->first[i]; k < i; k++)
            sum -= s->f[i * n + k] * x[k];
        x[i] = sum / s->f[i * n + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        real v = x[i] /= s->f[i * n + i];
        for (int k = s->first[i]; k < i; k++)
            x[k] -= s->f[i * n + k] * v;
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
    real worst = 0;
    memcpy(s->r, s->b, (size_t)n * sizeof *s->r);
    for (int i = 0; i < n; i++) {
        if (s->sliding) {
            for (int k = 0; k < n; k++)
                s->r[i] -= s->a[i * n + k] * s->x[k];
            continue;
        }
        for (int k = s->first[i]; k < i; k++) {
            s->r[i] -= s->a[i * n + k] * s->x[k];
            s->r[k] -= s->a[i * n + k] * s->x[i];
        }
        s->r[i] -= s->a[i * n + i] * s->x[i];
    }
    for (int i = 0; i < n; i++)
        worst = real_max(worst, fabs(s->r[i]));
    return worst;
}

bool system_solve(System *s, real accept)
{
    int n = s->count;
    real scale = 0;
    for (int i = 0; i < n; i++)
        scale = real_max(scale, fabs(s->b[i]));
    memset(s->x, 0, (size_t)n * sizeof *s->x);
    memcpy(s->r, s->b, (size_t)n * sizeof *s->r);
    s->residual = 0;
    if (!(scale > 0))
        return scale == 0;
    real worst = scale, last = INFINITY;
    for (int pass = 0; pass < REFINE_MOST && worst > ENOUGH * scale && worst < 0.5 * last; pass++) {
        memcpy(s->dx, s->r, (size_t)n * sizeof *s->dx);
        if (s->sliding)
            back_general(s, s->dx);
        else
            back_symmetric(s, s->dx);
        for (int i = 0; i < n; i++)
            s->x[i] += s->dx[i];
        last = worst;
        worst = remainder_of(s);
        if (!s->redundant && worst < 1e-13 * scale)
            break;
    }
    s->residual = worst / scale;
    return s->residual <= (s->redundant ? accept : 1e-8);
}
