/* solve/ldl.c - dense and sparse L D L^T. */
#include "solve/ldl.h"

#include "base/sort.h"
#include "solve/degree.h"

/* ---- order and pattern ---- */

static bool plan_scratch(Ldl *s, Arena *arena)
{
    size_t n = (size_t)s->n + 1;
    s->diagonal = arena_alloc(arena, n * sizeof *s->diagonal);
    s->below = arena_alloc(arena, ((size_t)s->values + 1) * sizeof *s->below);
    s->column = arena_alloc(arena, n * sizeof *s->column);
    s->head = arena_alloc(arena, n * sizeof *s->head);
    s->after = arena_alloc(arena, n * sizeof *s->after);
    s->at = arena_alloc(arena, n * sizeof *s->at);
    return s->diagonal && s->below && s->column && s->head && s->after && s->at;
}

static void sort_rows(int *row, int count)
{
    for (int i = 1; i < count; i++) {
        int r = row[i], k = i;
        for (; k > 0 && row[k - 1] > r; k--)
            row[k] = row[k - 1];
        row[k] = r;
    }
}

/* Which unknown goes when, and what is linked to it then. */
static bool eliminate(Ldl *s, Degree *d, Adjacent *later)
{
    s->values = 0;
    for (int k = 0; k < s->n && !d->failed; k++) {
        int node = degree_next(d);
        s->place[node] = k;
        later[k] = d->next[node];       /* nobody changes the list of one that has gone */
        s->first[k] = s->values;
        s->values += later[k].count;
        degree_eliminate(d, node, true);
    }
    s->first[s->n] = s->values;
    return !d->failed;
}

bool ldl_plan(Ldl *s, Arena *arena, int n, const int *link, int links)
{
    *s = (Ldl){.n = n, .dense = n <= LDL_DENSE, .values = n * (n - 1) / 2};
    if (s->dense)
        return plan_scratch(s, arena);
    Degree d;
    degree_open(&d, arena, n);
    Adjacent *later = arena_alloc(arena, ((size_t)n + 1) * sizeof *later);
    s->place = arena_alloc(arena, ((size_t)n + 1) * sizeof *s->place);
    s->first = arena_alloc(arena, ((size_t)n + 1) * sizeof *s->first);
    if (d.failed || !later || !s->place || !s->first)
        return false;
    for (int i = 0; i < links; i++)
        if (link[2 * i] != link[2 * i + 1])
            degree_link(&d, link[2 * i], link[2 * i + 1]);
    for (int i = n - 1; i >= 0 && !d.failed; i--)
        degree_ready(&d, i);
    if (d.failed || !eliminate(s, &d, later))
        return false;
    s->row = arena_alloc(arena, ((size_t)s->values + 1) * sizeof *s->row);
    if (!s->row)
        return false;
    for (int k = 0; k < n; k++) {
        for (int i = 0; i < later[k].count; i++)
            s->row[s->first[k] + i] = s->place[later[k].node[i]];
        sort_rows(s->row + s->first[k], later[k].count);
    }
    return plan_scratch(s, arena);
}

int ldl_find(const Ldl *s, int i, int k)
{
    int r = s->dense ? i : s->place[i], c = s->dense ? k : s->place[k];
    int low = int_min(r, c), high = int_max(r, c);
    if (s->dense)
        return high * (high - 1) / 2 + low;
    int at = sorted_place(s->row, s->first[low], s->first[low + 1], high);
    DIG_ASSERT(at < s->first[low + 1] && s->row[at] == high);
    return at;
}

void ldl_clear(Ldl *s)
{
    memset(s->diagonal, 0, (size_t)s->n * sizeof *s->diagonal);
    memset(s->below, 0, (size_t)s->values * sizeof *s->below);
}

/* ---- numbers ---- */

static bool dense_factor(Ldl *s)
{
    for (int i = 0; i < s->n; i++) {
        real *a = s->below + i * (i - 1) / 2, pivot = s->diagonal[i];
        for (int k = 0; k < i; k++) {
            const real *b = s->below + k * (k - 1) / 2;
            for (int m = 0; m < k; m++)
                a[k] -= a[m] * b[m];    /* a[m] still holds L d */
        }
        for (int k = 0; k < i; k++) {
            real l = a[k] / s->diagonal[k];
            pivot -= l * a[k];
            a[k] = l;
        }
        if (!(pivot > 1e-15 * s->diagonal[i]))
            return false;
        s->diagonal[i] = pivot;
    }
    return true;
}

/* The column is now waited for by the next row that it reaches. */
static void queue_column(Ldl *s, int k)
{
    if (s->at[k] >= s->first[k + 1])
        return;
    int row = s->row[s->at[k]];
    s->after[k] = s->head[row];
    s->head[row] = k;
}

static bool sparse_factor(Ldl *s)
{
    for (int k = 0; k < s->n; k++)
        s->head[k] = -1;
    for (int j = 0; j < s->n; j++) {
        real pivot = s->diagonal[j];
        for (int p = s->first[j]; p < s->first[j + 1]; p++)
            s->column[s->row[p]] = s->below[p];
        for (int k = s->head[j], after; k >= 0; k = after) {
            after = s->after[k];
            real l = s->below[s->at[k]], f = l * s->diagonal[k];
            pivot -= l * f;
            for (int p = ++s->at[k]; p < s->first[k + 1]; p++)
                s->column[s->row[p]] -= f * s->below[p];
            queue_column(s, k);
        }
        if (!(pivot > 1e-15 * s->diagonal[j]))
            return false;
        s->diagonal[j] = pivot;
        for (int p = s->first[j]; p < s->first[j + 1]; p++)
            s->below[p] = s->column[s->row[p]] / pivot;
        s->at[j] = s->first[j];
        queue_column(s, j);
    }
    return true;
}

bool ldl_factor(Ldl *s) { return s->dense ? dense_factor(s) : sparse_factor(s); }

static void dense_solve(const Ldl *s, real *x)
{
    for (int i = 0; i < s->n; i++)
        for (int k = 0; k < i; k++)
            x[i] -= s->below[i * (i - 1) / 2 + k] * x[k];
    for (int i = 0; i < s->n; i++)
        x[i] /= s->diagonal[i];
    for (int i = s->n - 1; i >= 0; i--)
        for (int k = 0; k < i; k++)
            x[k] -= s->below[i * (i - 1) / 2 + k] * x[i];
}

static void sparse_solve(const Ldl *s, real *x)
{
    real *y = s->column;
    for (int i = 0; i < s->n; i++)
        y[s->place[i]] = x[i];
    for (int k = 0; k < s->n; k++)
        for (int p = s->first[k]; p < s->first[k + 1]; p++)
            y[s->row[p]] -= s->below[p] * y[k];
    for (int k = s->n - 1; k >= 0; k--) {
        y[k] /= s->diagonal[k];
        for (int p = s->first[k]; p < s->first[k + 1]; p++)
            y[k] -= s->below[p] * y[s->row[p]];
    }
    for (int i = 0; i < s->n; i++)
        x[i] = y[s->place[i]];
}

void ldl_solve(const Ldl *s, real *x) { s->dense ? dense_solve(s, x) : sparse_solve(s, x); }
