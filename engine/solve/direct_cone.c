/* solve/direct_cone.c - the rows of contacts from the inside: a primal-dual interior-point method on their friction cones.
 *
 * Newton's method of solve/direct.c goes from kink to kink where rows are hard, and in a heap that lands, with masses of 1000:1 and more, it met more
 * of them than its steps: two of three such solves failed. Here impulses x and speeds s of a contact stay inside their cones (impulses in the friction
 * cone, speeds with De Saxce's lift in its dual), the product of both is one number for all, and that goes to nothing: 14 to 30 factorisations of
 * the same matrix, mostly 18, whatever the rows are. Both cones become Lorentz's by a factor mu in their normal parts. Steps are those of Nesterov &
 * Todd 1998 with Mehrotra's corrector, as Vandenberghe 2010 ("The CVXOPT linear and quadratic cone program solvers") writes them down; Acary, Armand,
 * Nguyen & Shpakovych 2024 solve friction so.
 *
 * The lift is the slip, and changes with it in the step: Newton's method for Coulomb's law itself. What is linear in that is not symmetric, so that
 * the factor is one of the rest, and the changes of lifts are found by a few solves with it (conjugate residuals: Eisenstat, Elman & Schultz 1983).
 * Velocities and impulses agree to the last digit however far these have come; only lifts are a little off. Where that leads to a short step (that
 * matrix need not be positive definite) lifts stay in it, and follow after it. From step LIVE on they only follow, and only fall: what swings until
 * then would do so for ever, and a contact whose lift is less than its slip asks for parts too fast, but does not sink in. With none at all the
 * problem is convex, and 98 of 100 are solved in 19 steps.
 *
 * A bound that does not follow the normal impulse (rolling resistance, friction beside a blow, motors and dry friction of joints) is a cone of which the
 * first part of the impulse is given; the first part of the speed is then free, and eliminated. Stops are rays. What else a joint has is linear, and
 * part of the matrix.
 */
#include "base/wide.h"
#include "math/four.h"
#include "solve/direct.h"

#define MOST_STEPS  60
#define LIVE        36
#define FOLLOWS     4           /* solves for the changes of lifts, */
#define FOLLOWED    0.05        /* or until this is left of them */
#define SHORT       0.2         /* of a step: then lifts do not change in it, but after it */
#define INSIDE      0.99        /* of the way to where the first cone ends */
#define NEAR        1e-5        /* m/s  done; rounds take off the rest */
#define LEAST       1e-3        /* of a step: it is stuck, */
#define MOST_LEAST  4           /* if that often */
#define LEAST_AIM   1e-6        /* of the present product: a step does not aim at less */

/* A ray (n = 1), a friction cone (n = 3), or a disc or ball (n = 1 + rows), whose first part is no row's. What is beyond n is 0. */
typedef struct Cone {
    four x, s, dx, ds;                  /* N s, m/s */
    four lambda, w[4], back[4];         /* the scaling, and its inverse: W x = W^-1 s = lambda; both are symmetric */
    four right;                         /* of  W dx + W^-1 ds = right */
    four slope[4], lead;                /* dx = lead - slope ds, without what is free */
    four off;                           /* m/s  what s is off */
    int  triple, n, row, rows;          /* its last parts are rows row..row + rows - 1 of the triple, or: */
    Single *single;                     /* the row of a joint; NULL */
    real base, hard;                    /* N s  of its impulse, what x counts from; its own compliance */
    bool given;                         /* x[0] is */
    real scale[3];                      /* of rows: times speeds, and impulses are over it: 1/mu of the normal, m of spins */
    real mobility;                      /* 1/kg */
    real lift, bend, rise;              /* m/s   and what is not straight of its change in the step, and all of it */
    four slides;                        /* where the slip goes to: the lift's slope; 0: it only follows */
} Cone;

typedef struct Inside {
    Direct *d;
    Cone   *cones; int count;
    real    mean;                       /* J  of the products */
    bool    convex;                     /* without lifts */
    int     step;
    /* m/s  changes of lifts that were tried, what they answer, how all moves by them; what is left, and how all moves */
    real   *ways[FOLLOWS], *answers[FOLLOWS], *moves[FOLLOWS], *left, *all;     /* [count, count, 6 places, count, 6 places] */
} Inside;

/* ---- Lorentz's cone: |x[1..]| <= x[0] ---- */

INLINE real sum_of(four a) { return (a[0] + a[1]) + (a[2] + a[3]); }
INLINE real rest_of(four a) { return a[1] + (a[2] + a[3]); }
INLINE real dot(four a, four b) { return sum_of(a * b); }
INLINE real tail(four x) { return sqrt(rest_of(x * x)); }

/* x[0]^2 - |x[1..]|^2, so that nothing cancels */
INLINE real spread(four x)
{
    real rest = tail(x);
    return (x[0] - rest) * (x[0] + rest);
}

INLINE four times(const four m[4], four x) { return (m[0] * x[0] + m[1] * x[1]) + (m[2] * x[2] + m[3] * x[3]); }

/* a o b, and the y of  a o y = b */
INLINE four jordan(four a, four b)
{
    four y = a[0] * b + b[0] * a;
    y[0] = dot(a, b);
    return y;
}

INLINE four jordan_solve(four a, four b)
{
    real first = (a[0] * b[0] - rest_of(a * b)) / spread(a);
    four y = (b - first * a) / a[0];
    y[0] = first;
    return y;
}

/* How far along d the cone ends. */
INLINE real way_out(four x, four d)
{
    real out = d[0] < 0 ? -x[0] / d[0] : INFINITY;
    real a = spread(d), b = x[0] * d[0] - rest_of(x * d), c = spread(x), under = b * b - a * c;
    if (!(under >= 0))
        return out;
    real q = -(b + copysign(sqrt(under), b)), first = q / a, second = c / q;
    if (first > 0)
        out = real_min(out, first);
    return second > 0 ? real_min(out, second) : out;
}

/* The scaling takes the square root of the quadratic map of a point between x and s. */
INLINE void scaling(Cone *c)
{
    real ds = sqrt(spread(c->s)), dx = sqrt(spread(c->x)), size = sqrt(ds / dx);
    real between = 2 * sqrt((1 + dot(c->s, c->x) / (ds * dx)) / 2);
    four s = c->s / (ds * between), x = c->x / (dx * between), p = s - x;
    p[0] = s[0] + x[0];
    for (int i = 1; i < 4; i++) {
        four row = p * (p[i] / (1 + p[0]));
        row[i] += i < c->n;
        row[0] = p[i];
        c->w[i] = size * row;
        row[0] = -p[i];
        c->back[i] = row / size;
    }
    c->w[0] = size * p;
    p[0] = -p[0];
    c->back[0] = -p / size;
    c->lambda = times(c->w, c->x);
}

/* ---- cones of the group ---- */

INLINE bool lifts(const Cone *c) { return c->n == 3 && !c->given; }
INLINE bool spins(const Cone *c) { return c->given && c->row == 0 && !c->single; }

static Cone *add(Inside *in, int triple, int row, int rows, real bound)
{
    Cone *c = &in->cones[in->count++];
    *c = (Cone){.triple = triple, .row = row, .rows = rows, .given = bound > 0, .n = rows + (bound > 0), .scale = {1, 1, 1},
                .mobility = direct_mobility(in->d, &in->d->triples[triple])};
    return c;
}

/* Spins count as speeds of what rolls: a step that suits the ones must suit the others, whatever the size. */
static void add_spins(Inside *in, int triple)
{
    const Triple *t = &in->d->triples[triple];
    real reach = in->d->g->rolls[t->index].reach;
    Cone *c = add(in, triple, 0, 3, t->bound / reach);
    c->scale[0] = c->scale[1] = c->scale[2] = reach;
    c->mobility *= reach * reach;
    c->x[0] = t->bound / reach;
}

/* Stops, motors and dry friction. Angular rows count as speeds, by the arm with which they are as easily moved as what they turn. */
static void add_single(Inside *in, Single *t)
{
    const Group *g = in->d->g;
    t->answers = t->bounded && t->hi > t->lo;
    if (!t->answers)                        /* nor is a line that swings back a row of the group's */
        return;
    const JointRow *p = &g->rows[t->row];
    real mass = 0, arm = 0;
    for (int k = 0; k < p->row.count; k++) {
        int b = p->row.body[k];
        mass += b < 0 ? 0 : g->mass[b].im;
        arm += vec3_length2(p->row.lin[k]);
    }
    arm = arm > 0 ? 1 : sqrt(mass / p->k);
    bool both = t->lo > -INFINITY && t->hi < INFINITY;
    real half = 0.5 * (t->hi - t->lo);
    Cone *c = &in->cones[in->count++];
    *c = (Cone){.single = t, .hard = t->r, .rows = 1, .given = both, .n = 1 + both, .scale = {t->lo > -INFINITY ? arm : -arm}, .mobility = arm * arm * p->k,
                .base = both ? t->lo + half : t->lo > -INFINITY ? t->lo : t->hi};
    if (both)
        c->x[0] = half / arm;
}

static bool open_cones(Inside *in)
{
    const Direct *d = in->d;
    size_t most = (size_t)(2 * d->triple_count + d->single_count + 1), n = 6 * (size_t)d->blocks.n;
    in->cones = arena_alloc(d->g->arena, most * sizeof *in->cones);
    in->left = arena_alloc(d->g->arena, ((2 * FOLLOWS + 1) * most + (FOLLOWS + 1) * n) * sizeof *in->left);
    if (!in->cones || !in->left) {
        d->g->status = DIG_E_MEMORY;
        return false;
    }
    in->all = in->left + most;
    for (size_t i = 0; i < FOLLOWS; i++) {
        in->moves[i] = in->all + (i + 1) * n;
        in->ways[i] = in->all + (FOLLOWS + 1) * n + 2 * i * most;
        in->answers[i] = in->ways[i] + most;
    }
    for (int i = 0; i < d->triple_count; i++) {
        const Triple *t = &d->triples[i];
        if (t->set == SET_CONE && t->mu > 0)
            add(in, i, 0, 3, 0)->scale[0] = 1 / t->mu;
        else if (t->set != SET_BALL)
            add(in, i, 0, 1, 0);
        if (t->set == SET_DISC && t->bound > 0)
            add(in, i, 1, 2, t->bound)->x[0] = t->bound;
        if (t->set == SET_BALL && t->bound > 0)
            add_spins(in, i);
    }
    for (int i = 0; i < d->single_count; i++)
        add_single(in, &d->singles[i]);
    return in->count > 0;
}

/* m/s  What its row k does, over what it should. */
static real speed(const Inside *in, const Cone *c, int k)
{
    const Triple *t = &in->d->triples[c->triple];
    int row = c->row + k;
    real over = c->single ? c->single->rate - c->single->target : t->rate[row] - t->target[row];
    return c->scale[row] * over + (row == 0 ? c->lift : 0);
}

INLINE real speed_change(const Inside *in, const Cone *c, int k)
{
    return c->scale[c->row + k] * (c->single ? c->single->change : in->d->triples[c->triple].change[c->row + k]);
}

/* All products are the same: what carries least has as much to go as what carries most. Impulses and speeds that are the local ones' share begin nearer
 * where much moves, but light things under heavy ones bear a thousand times what they begin with: of 7000 solves of 200 boxes of 1000:1 86 failed, now none. */
static void begin(Inside *in)
{
    real sum = 0, mobility[2] = {INFINITY, INFINITY};       /* the least of what is not given, and of what is: that does not begin by it */
    int rows = 0;
    for (int i = 0; i < in->count; i++) {
        const Cone *c = &in->cones[i];
        for (int k = 0; k < c->rows; k++) {
            real u = speed(in, c, k);
            sum += u * u;
        }
        rows += c->rows;
        mobility[c->given] = real_min(mobility[c->given], c->mobility);
    }
    real fast = real_max(NEAR, sqrt(sum / rows)), least = isfinite(mobility[0]) ? mobility[0] : mobility[1];
    for (int i = 0; i < in->count; i++) {
        Cone *c = &in->cones[i];
        c->x[0] = c->given ? c->x[0] : fast / least;
        c->s[0] = fast * fast / least / c->x[0];
    }
}

/* m/s  By speeds without impulses, this part of the step on. */
INLINE real slip(const Cone *c, real along) { return tail(c->s + along * c->ds); }

INLINE real next_lift(const Inside *in, const Cone *c, real along)
{
    real lift = slip(c, along);
    return in->step < LIVE ? lift : real_min(lift, c->lift);
}

INLINE void set_lift(const Inside *in, Cone *c)
{
    c->lift = next_lift(in, c, 0);
    c->slides = (four){0};
    if (in->step >= LIVE || !(c->lift > 0))
        return;
    c->slides = c->s / c->lift;
    c->slides[0] = 0;
}

/* ---- one step ---- */

/* m/s  How far rows are off and cones from their ends; and their common product. */
INLINE real look(Inside *in)
{
    real worst = 0, sum = 0;
    for (int i = 0; i < in->count; i++) {
        Cone *c = &in->cones[i];
        if (lifts(c) && !in->convex)
            set_lift(in, c);
        for (int k = 0; k < c->rows; k++) {
            int at = k + c->given;
            c->off[at] = speed(in, c, k) - c->s[at];
            worst = real_max(worst, fabs(c->off[at]) / (spins(c) || c->single ? 1 : c->scale[c->row + k]));
        }
        real both = dot(c->x, c->s);
        worst = real_max(worst, both / (c->x[0] + c->s[0] / c->mobility));
        sum += both;
    }
    in->mean = sum / in->count;
    return worst;
}

/* Impulses of the triples are those of their cones; with what they lead to where speeds do not change, if asked. */
INLINE void put_forces(Inside *in, bool lead)
{
    for (int i = 0; i < in->d->triple_count; i++)
        memset(in->d->triples[i].force, 0, sizeof in->d->triples[i].force);
    singles_free(in->d);
    for (int i = 0; i < in->count; i++) {
        const Cone *c = &in->cones[i];
        four off = c->off;
        off[0] += c->rise;
        four x = lead ? c->x + c->lead - times(c->slope, off) : c->x;
        real *force = c->single ? &c->single->force : in->d->triples[c->triple].force;
        for (int k = 0; k < c->rows; k++)
            force[c->row + k] = c->base + c->scale[c->row + k] * x[k + c->given];
    }
}

/* What is free changes so that dx[0] = 0. */
INLINE void put_slope(Cone *c)
{
    for (int i = 0; i < 4; i++)
        c->slope[i] = times(c->back, c->back[i]);
    if (!c->given)
        return;
    four first = c->slope[0];
    for (int i = 0; i < 4; i++)
        c->slope[i] -= first * (first[i] / first[0]);
}

INLINE void put_lead(Cone *c)
{
    c->lead = times(c->back, c->right);
    if (c->given)
        c->lead -= times(c->back, c->back[0]) * (c->lead[0] / dot(c->back[0], c->back[0]));
}

INLINE bool factor(Inside *in)
{
    Direct *d = in->d;
    for (int i = 0; i < d->triple_count; i++) {
        memset(d->triples[i].w, 0, sizeof d->triples[i].w);
        d->triples[i].held = HELD_ALL;
    }
    for (int i = 0; i < in->count; i++) {
        Cone *c = &in->cones[i];
        Triple *t = &d->triples[c->triple];
        scaling(c);
        put_slope(c);
        if (c->single) {
            c->single->r = 1 / (c->scale[0] * c->scale[0] * c->slope[c->given][c->given]);
            continue;
        }
        for (int k = 0; k < c->rows; k++)
            for (int m = 0; m < c->rows; m++)
                t->w[3 * (c->row + k) + c->row + m] =
                    t->r * c->scale[c->row + k] * c->scale[c->row + m] * c->slope[k + c->given][m + c->given];
    }
    d->factors++;
    return direct_assemble(d, false) && blocks_factor(&d->blocks, false);
}

INLINE void change(const Inside *in, Cone *c)
{
    four ds = c->off;
    ds[0] += c->rise;
    for (int k = 0; k < c->rows; k++)
        ds[k + c->given] += speed_change(in, c, k);
    c->dx = c->lead - times(c->slope, ds);
    if (c->given) {
        c->dx[0] = 0;
        ds[0] = (dot(c->back[0], c->right) - dot(times(c->back, c->back[0]), ds)) / dot(c->back[0], c->back[0]);
    }
    c->ds = ds;
}

/* What velocities change by, with lifts that change so far. */
INLINE void solve_rows(Inside *in)
{
    Direct *d = in->d;
    put_forces(in, true);
    direct_gradient(d);
    for (int k = 0; k < 6 * d->blocks.n; k++)
        d->dv[k] = -d->grad[k];
    blocks_solve(&d->blocks, d->dv);
    direct_changes(d);
}

INLINE real slip_change(const Cone *c, const Triple *t) { return lifts(c) ? c->slides[1] * t->change[1] + c->slides[2] * t->change[2] : 0; }

/* What a lift takes from momenta of body m. */
INLINE void take_lift(const Cone *c, const Triple *t, real lift, int m, real *restrict from)
{
    if (t->place[m] < 0)
        return;
    real first = c->scale[0] * c->slope[0][0] * lift, second = c->slope[1][0] * lift, third = c->slope[2][0] * lift;
    const real *j0 = t->j[0] + 6 * m, *j1 = t->j[1] + 6 * m, *j2 = t->j[2] + 6 * m;
    from += 6 * t->place[m];
    UNROLL
    for (int k = 0; k < 6; k++)
        from[k] -= j0[k] * first + j1[k] * second + j2[k] * third;
}

/* out = by less the slips that lifts which change by this much lead to */
static void answer(Inside *in, const real *by, real *out)
{
    Direct *d = in->d;
    memset(d->dv, 0, 6 * (size_t)d->blocks.n * sizeof *d->dv);
    for (int i = 0; i < in->count; i++) {
        const Cone *c = &in->cones[i];
        const Triple *t = &d->triples[c->triple];
        for (int m = 0; m < 2 && by[i] != 0; m++)
            take_lift(c, t, by[i], m, d->dv);
    }
    blocks_solve(&d->blocks, d->dv);
    triples_changes(d);
    for (int i = 0; i < in->count; i++)
        out[i] = by[i] - slip_change(&in->cones[i], &d->triples[in->cones[i].triple]);
}

static real product(int n, const real *a, const real *b)
{
    real sum = 0;
    for (int i = 0; i < n; i++)
        sum += a[i] * b[i];
    return sum;
}

static void add_part(int n, real *to, real part, const real *what)
{
    for (int i = 0; i < n; i++)
        to[i] += part * what[i];
}

/* Changes of lifts, and with them of velocities, that are those of their slips: by conjugate residuals. */
static void follow_slips(Inside *in)
{
    Direct *d = in->d;
    int count = in->count, n = 6 * d->blocks.n;
    for (int i = 0; i < count; i++) {
        const Cone *c = &in->cones[i];
        in->left[i] = dot(c->slides, c->off) + slip_change(c, &d->triples[c->triple]) - (c->rise - c->bend);
    }
    memcpy(in->all, d->dv, (size_t)n * sizeof *d->dv);
    real enough = FOLLOWED * FOLLOWED * product(count, in->left, in->left);
    for (int m = 0; m < FOLLOWS && product(count, in->left, in->left) > enough; m++) {
        real *way = in->ways[m], *to = in->answers[m], *move = in->moves[m];
        memcpy(way, in->left, (size_t)count * sizeof *way);
        answer(in, way, to);
        memcpy(move, d->dv, (size_t)n * sizeof *move);
        for (int k = 0; k < m; k++) {
            real part = -product(count, to, in->answers[k]) / product(count, in->answers[k], in->answers[k]);
            add_part(count, to, part, in->answers[k]);
            add_part(count, way, part, in->ways[k]);
            add_part(n, move, part, in->moves[k]);
        }
        real size = product(count, to, to), part = product(count, in->left, to) / size;
        if (!(size > 0))
            break;
        add_part(count, in->left, -part, to);
        add_part(n, in->all, part, move);
        for (int i = 0; i < count; i++)
            in->cones[i].rise += part * way[i];
    }
    memcpy(d->dv, in->all, (size_t)n * sizeof *d->dv);
    direct_changes(d);
}

INLINE void direction(Inside *in)
{
    for (int i = 0; i < in->count; i++)
        put_lead(&in->cones[i]);
    solve_rows(in);
    if (in->step < LIVE && !in->convex)
        follow_slips(in);
    for (int i = 0; i < in->count; i++)
        change(in, &in->cones[i]);
}

INLINE real room(const Inside *in)
{
    real most = INFINITY;
    for (int i = 0; i < in->count; i++) {
        const Cone *c = &in->cones[i];
        most = real_min(most, real_min(way_out(c->x, c->dx), way_out(c->s, c->ds)));
    }
    return most;
}

/* Straight to where all products are nothing. */
INLINE void predict(Inside *in)
{
    for (int i = 0; i < in->count; i++) {
        in->cones[i].right = -in->cones[i].lambda;
        in->cones[i].bend = in->cones[i].rise = 0;
    }
    direction(in);
}

/* To the part of the present product that the prediction suggests, less what bends its way. */
INLINE void correct(Inside *in)
{
    real along = real_min(1, room(in)), sum = 0;
    for (int i = 0; i < in->count; i++) {
        const Cone *c = &in->cones[i];
        sum += dot(c->x + along * c->dx, c->s + along * c->ds);
    }
    real part = sum / in->count / in->mean, aim = in->mean * real_clamp(part * part * part, LEAST_AIM, 1);
    for (int i = 0; i < in->count; i++) {
        Cone *c = &in->cones[i];
        four right = -jordan(c->lambda, c->lambda) - jordan(times(c->back, c->ds), times(c->w, c->dx));
        right[0] += aim;
        c->right = jordan_solve(c->lambda, right);
        if (lifts(c) && !in->convex)
            c->rise += c->bend = next_lift(in, c, along) - c->lift - along * dot(c->slides, c->ds);
    }
    direction(in);
}

INLINE void aim(Inside *in)
{
    for (int time = 1; time <= 2; time++) {
        predict(in);
        correct(in);
        if (time == 2 || in->convex || in->step >= LIVE || room(in) > SHORT)
            return;
        for (int i = 0; i < in->count; i++)
            in->cones[i].slides = (four){0};
    }
}

INLINE void go(Inside *in, real along)
{
    direct_move(in->d, along);
    for (int i = 0; i < in->count; i++) {
        Cone *c = &in->cones[i];
        c->x += along * c->dx;
        c->s += along * c->ds;
    }
}

/* ---- */

/* m/s  How far off its steps end. */
INLINE real steps(Inside *in)
{
    real off = INFINITY;
    for (int stuck = 0; stuck < MOST_LEAST; in->step++) {
        off = look(in);
        put_forces(in, false);
        direct_gradient(in->d);
        off = real_max(off, direct_unbalanced(in->d));
        if (in->step == MOST_STEPS || off <= NEAR)
            break;
        if (!factor(in))
            break;
        aim(in);
        real along = real_min(1, INSIDE * room(in));
        if (!(along > 0))
            break;
        stuck = along < LEAST ? stuck + 1 : 0;
        go(in, along);
    }
    put_forces(in, false);
    return off;
}

static real steps_plain(Inside *in) { return steps(in); }
WIDE static real steps_wide(Inside *in) { return steps(in); }

real direct_inside(Direct *d, bool convex)
{
    Inside in = {.d = d, .convex = convex};
    if (!open_cones(&in))
        return INFINITY;
    begin(&in);
    real off = (has_wide() ? steps_wide : steps_plain)(&in);
    for (int i = 0; i < d->triple_count; i++)
        memcpy(d->triples[i].prox, d->triples[i].force, sizeof d->triples[i].prox);
    singles_keep(d);
    for (int i = 0; i < in.count; i++)
        if (in.cones[i].single)
            in.cones[i].single->r = in.cones[i].hard;
        else if (lifts(&in.cones[i]))
            d->triples[in.cones[i].triple].lift = in.cones[i].lift / in.cones[i].scale[0];
    d->kept = false;
    return off;
}
