/* solve/stick.c - points that press and stick, at once.
 *
 * A few sweeps show which points of a blow press; hundreds more only add digits. Where none of those slides, what is left is linear: the
 * impulses that leave no velocity at them. Points that would pull are let go, and the others solved again. Corners of one face
 * repeat each other; their matrix is softened and the solution refined with the velocities themselves, which shares the rest with
 * least norm, as in trace/system.c. */
#include "solve/direction.h"
#include "solve/ldl.h"

#define STICKS    8             /* points; more are left to the sweeps   */
#define PASSES    8
#define ROUNDS    4             /* of letting go                         */
#define SOFTENING 1e-7          /* part of the diagonal                  */

typedef struct StickRow { const Dir *d; int a, b; real target; real *impulse; } StickRow;

typedef struct Stick { int count; StickRow row[3 * STICKS]; } Stick;

static void add_row(Stick *s, PointRow *r, const Dir *d, real target, real *impulse)
{
    if (d->k > 0)
        s->row[s->count++] = (StickRow){d, r->a, r->b, target, impulse};
}

static real bound_of(const PointRow *r) { return (r->jn + r->blow) * (r->slides ? r->friction_dynamic : r->friction); }

static bool within_cone(const PointRow *r) { return r->jt[0] * r->jt[0] + r->jt[1] * r->jt[1] <= bound_of(r) * bound_of(r); }

/* Of the points that press. False: too many, or none. */
static bool list_rows(Group *g, Stick *s)
{
    int points = 0;
    s->count = 0;
    for (int i = 0; i < g->point_count; i++) {
        PointRow *r = &g->points[i];
        if (!(r->jn > 0))
            continue;
        if (++points > STICKS)
            return false;
        add_row(s, r, &r->n, r->target, &r->jn);
        if (!(r->friction > 0))
            continue;
        add_row(s, r, &r->t[0], 0, &r->jt[0]);
        add_row(s, r, &r->t[1], 0, &r->jt[1]);
    }
    return s->count > 0;
}

/* J_1 M^-1 J_2^T */
static real coupling(const Group *g, const StickRow *r, const StickRow *s)
{
    real sum = 0, along = vec3_dot(r->d->n, s->d->n);
    if (r->a == s->a)
        sum += g->mass[r->a].im * along + vec3_dot(r->d->aa, s->d->ia);
    if (r->a == s->b)
        sum += -g->mass[r->a].im * along + vec3_dot(r->d->aa, s->d->ib);
    if (r->b == s->a)
        sum += -g->mass[r->b].im * along + vec3_dot(r->d->ab, s->d->ia);
    if (r->b == s->b)
        sum += g->mass[r->b].im * along + vec3_dot(r->d->ab, s->d->ib);
    return sum;
}

static bool factor(const Group *g, const Stick *s, Ldl *l)
{
    if (!ldl_plan(l, g->arena, s->count, NULL, 0))
        return false;
    ldl_clear(l);
    for (int i = 0; i < s->count; i++) {
        *ldl_diagonal(l, i) = (1 + SOFTENING) * s->row[i].d->k;
        for (int k = 0; k < i; k++)
            l->below[ldl_find(l, i, k)] = coupling(g, &s->row[i], &s->row[k]);
    }
    return ldl_factor(l);
}

/* m/s  Fills in what is missing at the rows. */
static real missing(const Group *g, const Stick *s, real *b)
{
    real worst = 0;
    for (int i = 0; i < s->count; i++) {
        const StickRow *r = &s->row[i];
        b[i] = r->target - dir_rate(g, r->d, r->a, r->b);
        worst = real_max(worst, fabs(b[i]));
    }
    return worst;
}

/* False: not all of it could be filled in. */
static bool fill_in(Group *g, const Stick *s, const Ldl *l, real residual)
{
    real x[3 * STICKS], worst = missing(g, s, x);
    for (int pass = 0; pass < PASSES && worst > residual; pass++) {
        ldl_solve(l, x);
        for (int i = 0; i < s->count; i++) {
            *s->row[i].impulse += x[i];
            dir_apply(g, s->row[i].d, s->row[i].a, s->row[i].b, x[i]);
        }
        worst = missing(g, s, x);
    }
    return worst <= residual;
}

static void take_off(Group *g, const PointRow *r, const Dir *d, real *impulse)
{
    dir_apply(g, d, r->a, r->b, -*impulse);
    *impulse = 0;
}

/* Lets go what pulls; true when something did. */
static bool let_go(Group *g)
{
    bool any = false;
    for (int i = 0; i < g->point_count; i++) {
        PointRow *r = &g->points[i];
        if (!(r->jn < 0))
            continue;
        take_off(g, r, &r->n, &r->jn);
        take_off(g, r, &r->t[0], &r->jt[0]);
        take_off(g, r, &r->t[1], &r->jt[1]);
        any = true;
    }
    return any;
}

/* Do the impulses lie within their cones, and do the points without one let go? */
static bool holds(const Group *g, real residual)
{
    for (int i = 0; i < g->point_count; i++) {
        const PointRow *r = &g->points[i];
        if (!(r->jn >= 0) || (r->friction > 0 && !within_cone(r)))
            return false;
        if (r->jn == 0 && r->n.k > 0 && !(dir_rate(g, &r->n, r->a, r->b) >= r->target - residual))
            return false;
    }
    return true;
}

static bool solve(Group *g, Stick *s, real residual)
{
    for (int round = 0; round < ROUNDS; round++) {
        Ldl l;
        if (!list_rows(g, s) || !factor(g, s, &l) || !fill_in(g, s, &l, residual))
            return false;
        if (!let_go(g))
            return holds(g, residual);
    }
    return false;
}

bool stick_solve(Group *g, real residual)
{
    Stick all, s;
    real before[3 * STICKS];
    if (!list_rows(g, &all))
        return false;
    ArenaMark mark = arena_mark(g->arena);
    Vel *vel = arena_alloc(g->arena, (size_t)g->body_count * sizeof *vel);
    bool done = false;
    if (vel) {
        memcpy(vel, g->vel, (size_t)g->body_count * sizeof *vel);
        for (int i = 0; i < all.count; i++)
            before[i] = *all.row[i].impulse;
        done = solve(g, &s, residual);
        for (int i = 0; i < all.count && !done; i++)
            *all.row[i].impulse = before[i];
        if (!done)
            memcpy(g->vel, vel, (size_t)g->body_count * sizeof *vel);
    }
    arena_rewind(g->arena, mark);
    return done;
}
