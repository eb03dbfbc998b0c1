/* solve/stick.c - blows of few points that stick, solved directly.
 *
 * Where a block comes down on an edge, or balls that lie on each other on a floor, the points that strike mostly neither slip nor part
 * afterwards, and those that part have no part in it. Then the impulses follow from linear equations, which are singular where such points
 * repeat each other: softened a little and refined, they give those of least norm, alike on both sides, as the sweeps of patches do. Which
 * points part is found by trying: those that would pull are left out, those that others would be driven into come in (block principal
 * pivoting: Judice and Pires 1994). What comes out is checked on the velocities; it is a solution of what the sweeps solve, or is not taken. */
#include "solve/direction.h"

#define STICK_POINTS 8
#define STICK_ROWS (3 * STICK_POINTS)
#define STICK_SOFT 1e-7         /* part of the diagonal */
#define STICK_PASSES 10
#define STICK_TRIES 8           /* sets of points; 1 or 2 do mostly */

typedef struct StickRow { const Dir *dir; int a, b; } StickRow;

typedef struct Stick {
    int  count;                 /* points that take part                          */
    PointRow *point[STICK_POINTS];
    bool presses[STICK_POINTS];
    bool central;               /* nothing slides, and nothing is tried but normal impulses: of balls they do */
    Vel  was[STICK_POINTS][2];  /* of the bodies of each, before the blow         */
    int  n, first[STICK_POINTS];    /* rows; the first one of a point             */
    StickRow row[STICK_ROWS];
    real a[STICK_ROWS][STICK_ROWS], f[STICK_ROWS][STICK_ROWS];      /* 1/kg       */
    real b[STICK_ROWS], x[STICK_ROWS];                              /* m/s, N s   */
} Stick;

/* J_1 M^-1 J_2^T */
static real stick_coupling(const Group *g, const StickRow *i, const StickRow *j)
{
    const Dir *d = i->dir, *e = j->dir;
    if (i->a == j->a && i->b == j->b)
        return dir_coupling(g, d, e, i->a, i->b);
    real nn = vec3_dot(d->n, e->n), sum = 0;
    if (i->a == j->a)
        sum += g->mass[i->a].im * nn + vec3_dot(d->aa, e->ia);
    if (i->b == j->b)
        sum += g->mass[i->b].im * nn + vec3_dot(d->ab, e->ib);
    if (i->a == j->b)
        sum += vec3_dot(d->aa, e->ib) - g->mass[i->a].im * nn;
    if (i->b == j->a)
        sum += vec3_dot(d->ab, e->ia) - g->mass[i->b].im * nn;
    return sum;
}

static void stick_add(const Group *g, Stick *s, int point)
{
    const PointRow *r = s->point[point];
    const Dir *dirs[3] = {&r->n, &r->t[0], &r->t[1]};
    s->first[point] = s->n;
    for (int k = 0; k < (r->friction > 0 && !s->central ? 3 : 1); k++) {
        int i = s->n++;
        s->row[i] = (StickRow){dirs[k], r->a, r->b};
        s->b[i] = (k == 0 ? r->target : 0) - dir_rate(g, dirs[k], r->a, r->b);
        for (int j = 0; j <= i; j++)
            s->a[i][j] = s->a[j][i] = stick_coupling(g, &s->row[i], &s->row[j]);
    }
}

/* L D L^T, the inverse of D on its diagonal. */
static void stick_factor(Stick *s)
{
    for (int i = 0; i < s->n; i++) {
        real pivot = s->a[i][i] * (1 + STICK_SOFT);
        for (int j = 0; j < i; j++) {
            real sum = s->a[i][j];
            for (int k = 0; k < j; k++)
                sum -= s->f[i][k] * s->f[j][k];
            s->f[i][j] = sum;               /* (L D)_ij */
        }
        for (int j = 0; j < i; j++) {
            real l = s->f[i][j] * s->f[j][j];
            pivot -= l * s->f[i][j];
            s->f[i][j] = l;
        }
        s->f[i][i] = 1 / pivot;
    }
}
/* False: it does not come within `enough`, m/s. */
static bool stick_solve(Stick *s, real enough)
{
    stick_factor(s);
    memset(s->x, 0, sizeof s->x);
    for (int pass = 0; pass < STICK_PASSES; pass++) {
        real r[STICK_ROWS], worst = 0;
        for (int i = 0; i < s->n; i++) {
            real sum = s->b[i];
            for (int k = 0; k < s->n; k++)
                sum -= s->a[i][k] * s->x[k];
            r[i] = sum;
            worst = real_max(worst, fabs(sum));
        }
        if (worst == 0)
            return true;
        for (int i = 0; i < s->n; i++)
            for (int k = 0; k < i; k++)
                r[i] -= s->f[i][k] * r[k];
        for (int i = 0; i < s->n; i++)
            r[i] *= s->f[i][i];
        for (int i = s->n - 1; i >= 0; i--) {
            for (int k = i + 1; k < s->n; k++)
                r[i] -= s->f[k][i] * r[k];
            s->x[i] += r[i];
        }
        if (worst <= enough)    /* and once more, towards rounding */
            return true;
    }
    return false;
}

static real slip_of(const Group *g, const PointRow *r)
{
    return real_max(fabs(dir_rate(g, &r->t[0], r->a, r->b)), fabs(dir_rate(g, &r->t[1], r->a, r->b)));
}

/* Those of the points from first to end that are on: all, where on is NULL. False: none, too many, or what has no such equations. */
static bool stick_open(Group *g, Stick *s, const bool *on, int first, int end, real enough)
{
    bool any = false;
    s->count = 0;
    s->central = on;            /* else it mostly comes down on an edge */
    if (!g->patches || first == end || g->row_count + g->roll_count > 0 || g->point_count > STICK_POINTS)
        return false;
    if (!on && (end - first > MANIFOLD_POINTS || g->points[first].contact != g->points[end - 1].contact))
        return false;
    for (int i = first; i < end; i++) {
        PointRow *r = &g->points[i];
        if (on && !on[i])
            continue;
        if (!(r->n.k > 0) || !(r->friction == 0 || (r->t[0].k > 0 && r->t[1].k > 0)))
            return false;
        int k = s->count++;
        s->point[k] = r;
        s->presses[k] = dir_rate(g, &r->n, r->a, r->b) < r->target - enough;
        s->was[k][0] = g->vel[r->a];
        s->was[k][1] = g->vel[r->b];
        any = any || s->presses[k];
        s->central = s->central && (r->friction == 0 || slip_of(g, r) <= enough);
    }
    return any && (!on || s->count > 1);         /* one point alone takes a sweep or two */
}

static bool stick_slips(const Stick *s)
{
    for (int k = 0; k < s->count; k++) {
        const PointRow *r = s->point[k];
        const real *x = s->x + (s->presses[k] ? s->first[k] : 0);
        if (s->presses[k] && r->friction > 0 && !s->central && !(hypot(x[1], x[2]) < (r->slides ? r->friction_dynamic : r->friction) * x[0]))
            return true;
    }
    return false;
}

#define STICK_ALIKE 1e-6        /* of the impulse: what rounding makes of equal ones where points repeat each other */

/* Where all normal impulses of a contact are equal but for rounding, they are made so: a cube that comes down flat shall not turn. */
static void stick_even(Stick *s)
{
    for (int k = 0, n; k < s->count; k += n) {
        real least = INFINITY, most = 0, sum = 0;
        int presses = 0;
        for (n = 0; k + n < s->count && s->point[k + n]->contact == s->point[k]->contact; n++) {
            real x = s->presses[k + n] ? s->x[s->first[k + n]] : 0;
            presses += s->presses[k + n];
            sum += x;
            most = real_max(most, x);
            least = s->presses[k + n] ? real_min(least, x) : least;
        }
        for (int i = k; i < k + n && most - least <= STICK_ALIKE * most; i++)
            if (s->presses[i])
                s->x[s->first[i]] = sum / presses;
    }
}

/* Solves for the points that press. More: some pull, and press no more. */
static bool stick_try(const Group *g, Stick *s, real enough, bool *more)
{
    s->n = 0;
    *more = false;
    for (int k = 0; k < s->count; k++)
        if (s->presses[k])
            stick_add(g, s, k);
    if (s->n == 0 || !stick_solve(s, enough))
        return false;
    for (int k = 0; k < s->count; k++)
        if (s->presses[k] && !(s->x[s->first[k]] > 0)) {
            s->presses[k] = false;
            *more = true;
        }
    if (s->central && !*more)
        stick_even(s);
    return *more || !stick_slips(s);
}

/* The velocities after. False: some points are driven into each other, and press now, or along each other; then nothing has changed. */
static bool stick_apply(Group *g, Stick *s, real enough)
{
    bool fine = true, central = s->central;
    for (int i = 0; i < s->n; i++)
        dir_apply(g, s->row[i].dir, s->row[i].a, s->row[i].b, s->x[i]);
    for (int k = 0; k < s->count; k++) {
        const PointRow *r = s->point[k];
        if (!(dir_rate(g, &r->n, r->a, r->b) >= r->target - 2 * enough))
            fine = !(s->presses[k] = true);
        bool off = s->presses[k] && !(dir_rate(g, &r->n, r->a, r->b) <= r->target + 2 * enough);
        if (central && (off || (r->friction > 0 && !(slip_of(g, r) <= 2 * enough))))
            fine = s->central = false;
    }
    for (int k = 0; k < s->count && !fine; k++) {
        g->vel[s->point[k]->a] = s->was[k][0];
        g->vel[s->point[k]->b] = s->was[k][1];
    }
    return fine;
}

/* False: some point slips, or no set of points does; then nothing has changed. */
bool stick(Group *g, const bool *on, int first, int end, real enough)
{
    Stick s;
    bool done = false;
    if (!stick_open(g, &s, on, first, end, enough))
        return false;
    for (int try = 0; try < STICK_TRIES && !done; try++) {
        bool more;
        if (!stick_try(g, &s, enough, &more))
            return false;
        done = !more && stick_apply(g, &s, enough);
    }
    for (int k = 0; k < s.count && done; k++) {
        const real *x = s.x + (s.presses[k] ? s.first[k] : 0);       /* what parts has no row */
        PointRow *r = s.point[k];
        r->jn = s.presses[k] ? x[0] : 0;
        bool rubs = s.presses[k] && r->friction > 0 && !s.central;
        r->jt[0] = rubs ? x[1] : 0;
        r->jt[1] = rubs ? x[2] : 0;
    }
    g->sweeps += done;
    return done;
}
