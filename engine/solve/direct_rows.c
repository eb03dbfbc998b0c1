/* solve/direct_rows.c - rows of the direct solve: Jacobians, impulses as functions of velocities, gradient and matrix. */
#include "base/wide.h"
#include "math/four.h"
#include "solve/direct.h"

#define FOUR(x) (*(four_any *)(void *)&(x))     /* x and the three after it */
INLINE four part_of(const real *x) { return *(const four_any *)(const void *)x; }

/* Compliance of the augmented Lagrangian over a row's own effective mass. The smaller, the fewer rounds; too small, and
 * Newton's method stalls on the kinks: with the method's prototype 1e-5 let a 10,000:1 stack creep, and 1e-8 stalled. */
#define COMPLIANCE 1e-6

/* Where a round takes off less than nine tenths, the next one has a tenth of the compliance. */
#define HARDEN  0.1

/* ---- rows ---- */

/* Impulses and speeds are far from what overflows when squared, and hypot() took a sixth of all that is solved here. */
static real length_of(const real *x, int n) { return sqrt(x[0] * x[0] + x[1] * x[1] + (n > 2 ? x[2] * x[2] : 0)); }

static void set_line(real *j, const Dir *d)
{
    vec3 part[4] = {vec3_neg(d->n), d->aa, d->n, d->ab};
    memcpy(j, part, sizeof part);
}

/* m/s  The same as dir_rate before the substep: guesses of impulses that a break has made void do not count. */
static real start_rate(const Group *g, const Dir *d, int a, int b)
{
    Vel va = g->member[a].moves ? g->start_vel[a] : g->vel[a], vb = g->member[b].moves ? g->start_vel[b] : g->vel[b];
    return vec3_dot(d->n, vec3_sub(vb.v, va.v)) + vec3_dot(d->aa, va.w) + vec3_dot(d->ab, vb.w);
}

/* What does not turn has an inertia beyond all others: its arms do not count. */
static void drop_arms(const Direct *d, real *j, int a, int b)
{
    if (d->narrow[a])
        memset(j + 3, 0, 3 * sizeof *j);
    if (d->narrow[b])
        memset(j + 9, 0, 3 * sizeof *j);
}

#define ON_CONE 0.999           /* of the bound: what sweeps have left there slides */

/* By the sweeps so far. What is open counts as sliding: it will, should it close. */
static bool sticks(const PointRow *p, real mu) { return hypot(p->jt[0], p->jt[1]) < ON_CONE * mu * (p->jn + p->blow); }

static void add_point(Direct *d, int i)
{
    const PointRow *p = &d->g->points[i];
    if (!(p->n.k > 0))
        return;
    Triple *t = &d->triples[d->triple_count++];
    *t = (Triple){.place = {d->place[p->a], d->place[p->b]}, .index = i, .set = p->blow > 0 ? SET_DISC : SET_CONE};
    set_line(t->j[0], &p->n);
    set_line(t->j[1], &p->t[0]);
    set_line(t->j[2], &p->t[1]);
    for (int k = 0; k < 3; k++)
        drop_arms(d, t->j[k], p->a, p->b);
    t->r = COMPLIANCE * d->hardened * (p->n.k + p->t[0].k + p->t[1].k) / 3;
    t->target[0] = p->target;
    t->mu = p->friction > 0 && p->kmax > 0 ? p->slides ? p->friction_dynamic : p->friction : 0;
    t->bound = t->mu * (p->jn + p->blow);
    real start[3] = {p->jn, p->jt[0], p->jt[1]};
    memcpy(t->start, start, sizeof start);
    memcpy(t->prox, start, sizeof start);
    t->rate[0] = dir_rate(d->g, &p->n, p->a, p->b);
    t->rate[1] = dir_rate(d->g, &p->t[0], p->a, p->b);
    t->rate[2] = dir_rate(d->g, &p->t[1], p->a, p->b);
    t->lift_before = t->slip_before = NAN;
    if (t->set == SET_CONE && (d->g->joints_direct ? p->slides && p->jn > 0 : !sticks(p, t->mu)))
        t->lift = t->mu * (d->late_lift ? hypot(start_rate(d->g, &p->t[0], p->a, p->b), start_rate(d->g, &p->t[1], p->a, p->b))
                                        : length_of(t->rate + 1, 2));
}

static void add_roll(Direct *d, int i)
{
    const RollRow *p = &d->g->rolls[i];
    Triple *t = &d->triples[d->triple_count++];
    *t = (Triple){.place = {d->place[p->a], d->place[p->b]}, .index = i, .set = SET_BALL};
    for (int k = 0; k < 3; k++) {
        t->j[k][3 + k] = -1;
        t->j[k][9 + k] = 1;
        drop_arms(d, t->j[k], p->a, p->b);
    }
    mat3 k = mat3_add(d->g->mass[p->a].ii, d->g->mass[p->b].ii);
    t->r = COMPLIANCE * d->hardened * (k.r0.x + k.r1.y + k.r2.z) / 3;
    for (int m = 0; m < p->count; m++)
        t->bound += p->lever * (d->g->points[p->first + m].jn + d->g->points[p->first + m].blow);
    real start[3] = {p->j.x, p->j.y, p->j.z};
    memcpy(t->start, start, sizeof start);
    memcpy(t->prox, start, sizeof start);
    vec3 spin = vec3_sub(d->g->vel[p->b].w, d->g->vel[p->a].w);
    memcpy(t->rate, &spin, sizeof spin);
}

bool direct_rows(Direct *d)
{
    const Group *g = d->g;
    d->triples = arena_alloc(g->arena, (size_t)(g->point_count + g->roll_count + 1) * sizeof *d->triples);
    if (!d->triples)
        return false;
    for (int i = 0; i < g->point_count; i++)
        add_point(d, i);
    for (int i = 0; i < g->roll_count; i++)
        add_roll(d, i);
    return singles_open(d);
}

/* ---- impulses ---- */

static real dot6(const real *a, const real *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]; }

void triples_changes(Direct *d)
{
    for (int i = 0; i < d->triple_count; i++) {
        Triple *t = &d->triples[i];
        for (int k = 0; k < 3; k++) {
            t->change[k] = 0;
            for (int m = 0; m < 2; m++)
                if (t->place[m] >= 0)
                    t->change[k] += dot6(t->j[k] + 6 * m, d->dv + 6 * t->place[m]);
        }
    }
}

void direct_changes(Direct *d)
{
    triples_changes(d);
    singles_changes(d);
}

void direct_move(Direct *d, real along)
{
    for (int i = 0; i < 6 * d->blocks.n; i++)
        d->v[i] += along * d->dv[i];
    for (int i = 0; i < d->triple_count; i++)
        for (int k = 0; k < 3; k++)
            d->triples[i].rate[k] += along * d->triples[i].change[k];
    singles_move(d, along);
}

/* The nearest point y of the set. */
static Held nearest(const Triple *t, const real *y, real *f)
{
    real s = length_of(y + 1, 2);
    if (t->set == SET_BALL) {
        real length = length_of(y, 3), scale = length > t->bound ? t->bound / length : 1;
        for (int k = 0; k < 3; k++)
            f[k] = scale * y[k];
        return length > t->bound ? HELD_SLIPS : HELD_ALL;
    }
    if (t->set == SET_DISC) {
        f[0] = real_max(y[0], 0);
        real scale = s > t->bound ? t->bound / s : 1;
        f[1] = scale * y[1];
        f[2] = scale * y[2];
        return s > t->bound || !(y[0] > 0) ? HELD_SLIPS : HELD_ALL;
    }
    f[1] = f[2] = 0;
    if (!(t->mu > 0)) {
        f[0] = real_max(y[0], 0);
        return y[0] > 0 ? HELD_NORMAL : HELD_NOT;
    }
    if (s <= t->mu * y[0]) {
        memcpy(f, y, 3 * sizeof *f);
        return HELD_ALL;
    }
    f[0] = (y[0] + t->mu * s) / (1 + t->mu * t->mu);
    if (!(f[0] > 0)) {
        f[0] = 0;
        return HELD_NOT;
    }
    f[1] = t->mu * f[0] * y[1] / s;
    f[2] = t->mu * f[0] * y[2] / s;
    return HELD_SLIPS;
}

static void wish(const Triple *t, real along, real *y)
{
    for (int k = 0; k < 3; k++)
        y[k] = t->prox[k] + (t->target[k] - t->rate[k] - along * t->change[k]) / t->r;
    if (t->set == SET_CONE)
        y[0] -= t->lift / t->r;
}

void direct_forces(Direct *d)
{
    bool same = singles_forces(d);
    for (int i = 0; i < d->triple_count; i++) {
        Triple *t = &d->triples[i];
        real y[3];
        wish(t, 0, y);
        t->held = nearest(t, y, t->force);
        same = same && t->held == t->factored && t->held != HELD_SLIPS;
    }
    d->kept = d->kept && same;
}

/* ---- merit function: 1/2 |v - v^|^2_M + sum 1/2 R |force|^2 ---- */

static void mass_times(const real *m, const real *x, real *y)
{
    for (int k = 0; k < 3; k++) {
        y[k] += m[0] * x[k];
        y[3 + k] += m[1 + 3 * k] * x[3] + m[2 + 3 * k] * x[4] + m[3 + 3 * k] * x[5];
    }
}

/* Less what the impulses of rows do. */
INLINE void take_impulses(Direct *d)
{
    for (int i = 0; i < d->triple_count; i++) {
        const Triple *t = &d->triples[i];
        for (int m = 0; m < 2; m++) {
            if (t->place[m] < 0)
                continue;
            real *grad = d->grad + 6 * t->place[m];
            four sum = part_of(grad);
            pair more = two(grad + 4);
            UNROLL
            for (int k = 0; k < 3; k++) {
                const real *j = t->j[k] + 6 * m;
                real change = t->force[k] - t->start[k];
                sum -= part_of(j) * change;
                more -= two(j + 4) * change;
            }
            FOUR(grad[0]) = sum;
            PAIR(grad[4]) = more;
        }
    }
}

static void take_plain(Direct *d) { take_impulses(d); }
WIDE static void take_wide(Direct *d) { take_impulses(d); }

void direct_gradient(Direct *d)
{
    memset(d->grad, 0, (size_t)d->blocks.n * 6 * sizeof *d->grad);
    for (int i = 0; i < d->blocks.n; i++) {
        real off[6];
        for (int k = 0; k < 6; k++)
            off[k] = d->v[6 * i + k] - d->v0[6 * i + k];
        mass_times(d->mass + 10 * i, off, d->grad + 6 * i);
    }
    (has_wide() ? take_wide : take_plain)(d);
    singles_gradient(d);
}

void direct_line(Direct *d)
{
    d->level = d->rise = 0;
    for (int i = 0; i < d->blocks.n; i++) {
        const real *dv = d->dv + 6 * i;
        real off[6], p[6] = {0};
        for (int k = 0; k < 6; k++)
            off[k] = d->v[6 * i + k] - d->v0[6 * i + k];
        mass_times(d->mass + 10 * i, dv, p);    /* it is symmetric */
        d->level += dot6(p, off);
        d->rise += dot6(p, dv);
    }
    singles_line(d);
}

real direct_slope(const Direct *d, real along)
{
    real slope = d->level + along * d->rise + singles_slope(d, along);
    for (int i = 0; i < d->triple_count; i++) {
        const Triple *t = &d->triples[i];
        real y[3], f[3];
        wish(t, along, y);
        nearest(t, y, f);
        for (int k = 0; k < 3; k++)
            slope -= t->change[k] * (f[k] - t->start[k]);
    }
    return slope;
}

/* ---- the matrix M + sum J^T (d force / d wish) / R J ---- */

/* s times the projector on what is normal to the unit vector e of n dimensions, and `radial` along it */
static void turn_part(real *w, int first, const real *e, real across, real radial)
{
    for (int i = first; i < 3; i++)
        for (int k = first; k < 3; k++)
            w[3 * i + k] = (i == k ? across : 0) + (radial - across) * e[i] * e[k];
}

static void derivative(const Triple *t, const real *y, real *w)
{
    real e[3] = {0};
    memset(w, 0, 9 * sizeof *w);
    if (t->held == HELD_ALL || t->held == HELD_NORMAL)
        w[0] = 1;
    if (t->held == HELD_ALL)
        w[4] = w[8] = 1;
    if (t->held != HELD_SLIPS)
        return;
    real s = t->set == SET_BALL ? length_of(y, 3) : length_of(y + 1, 2);
    for (int k = t->set == SET_BALL ? 0 : 1; k < 3; k++)
        e[k] = s > 0 ? y[k] / s : 0;
    if (t->set != SET_CONE) {
        bool out = s > t->bound;
        turn_part(w, t->set == SET_BALL ? 0 : 1, e, out ? t->bound / s : 1, out ? 0 : 1);
        if (t->set == SET_DISC)
            w[0] = y[0] > 0;
        return;
    }
    real a = 1 / (1 + t->mu * t->mu), line[3] = {1, t->mu * e[1], t->mu * e[2]};
    turn_part(w, 1, e, t->mu * t->force[0] / s, 0);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            w[3 * i + k] += a * line[i] * line[k];
}

/* h += J^T X, both three rows of which six columns count */
INLINE void add_block(real *restrict h, const real *restrict j, const real *restrict x)
{
    four x0 = part_of(x), x1 = part_of(x + 12), x2 = part_of(x + 24);
    pair y0 = two(x + 4), y1 = two(x + 16), y2 = two(x + 28);
    UNROLL
    for (int r = 0; r < 6; r++) {
        FOUR(h[6 * r]) = FOUR(h[6 * r]) + j[r] * x0 + j[12 + r] * x1 + j[24 + r] * x2;
        PAIR(h[6 * r + 4]) = PAIR(h[6 * r + 4]) + j[r] * y0 + j[12 + r] * y1 + j[24 + r] * y2;
    }
}

/* The same in the column of what does not turn */
INLINE void add_thin(real *restrict h, int rows, const real *restrict j, const real *restrict x)
{
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < 3; c++)
            h[4 * r + c] += j[r] * x[c] + j[12 + r] * x[12 + c] + j[24 + r] * x[24 + c];
}

INLINE void assemble_triple(Direct *d, const Triple *t)
{
    if (t->held == HELD_NOT)
        return;
    real x[36];
    for (int i = 0; i < 3; i++) {
        const real *w = t->w + 3 * i;
        UNROLL
        for (int c = 0; c < 12; c += LANES)
            FOUR(x[12 * i + c]) = (w[0] * part_of(t->j[0] + c) + w[1] * part_of(t->j[1] + c) + w[2] * part_of(t->j[2] + c)) / t->r;
    }
    for (int m = 0; m < 2; m++)
        if (t->place[m] >= 0)
            add_block(d->blocks.diagonal + BLOCK * t->place[m], t->j[0] + 6 * m, x + 6 * m);
    if (t->place[0] < 0 || t->place[1] < 0)
        return;
    int row = t->place[0] > t->place[1] ? 0 : 1;
    real *to = blocks_at(&d->blocks, t->place[row], t->place[1 - row]);
    if (d->blocks.narrow[t->place[1 - row]])
        add_thin(to, d->blocks.narrow[t->place[row]] ? 3 : 6, t->j[0] + 6 * row, x + 6 * (1 - row));
    else
        add_block(to, t->j[0] + 6 * row, x + 6 * (1 - row));
}

INLINE void assemble_triples(Direct *d)
{
    for (int i = 0; i < d->triple_count; i++) {
        assemble_triple(d, &d->triples[i]);
        d->triples[i].factored = d->triples[i].held;
    }
}

static void assemble_plain(Direct *d) { assemble_triples(d); }
WIDE static void assemble_wide(Direct *d) { assemble_triples(d); }

/* What stays the same from one assembly to the next: masses, and rows without a bound. False: not positive definite. */
static bool assemble_base(Direct *d)
{
    blocks_clear(&d->blocks);
    for (int i = 0; i < d->blocks.n; i++) {
        real *h = d->blocks.diagonal + BLOCK * i;
        const real *m = d->mass + 10 * i;
        for (int k = 0; k < 3; k++) {
            h[7 * k] = m[0];
            memcpy(h + 6 * (3 + k) + 3, m + 1 + 3 * k, 3 * sizeof *h);
        }
    }
    singles_assemble(d, false);
    d->based = blocks_begin(&d->blocks, false);
    blocks_keep(&d->blocks);
    return d->based;
}

bool direct_assemble(Direct *d, bool fresh)
{
    if (d->based)
        blocks_back(&d->blocks);
    else if (!assemble_base(d))
        return false;
    for (int i = 0; i < d->triple_count && fresh; i++) {
        real y[3];
        wish(&d->triples[i], 0, y);
        derivative(&d->triples[i], y, d->triples[i].w);
    }
    (has_wide() ? assemble_wide : assemble_plain)(d);
    singles_assemble(d, true);
    return true;
}

/* ---- the outer loop ---- */

/* By what its points bore in this round: what they are predicted to bear in the next may be negative, and resistance with a negative
 * bound would drive. */
static void follow_bounds(Direct *d, int i)
{
    Triple *t = &d->triples[i];
    const Group *g = d->g;
    if (t->set == SET_DISC)
        t->bound = t->mu * (t->force[0] + g->points[t->index].blow);
    if (t->set != SET_BALL)
        return;
    const RollRow *p = &g->rolls[t->index];
    t->bound = 0;
    for (int k = 0; k < i; k++) {
        int point = d->triples[k].index - p->first;
        if (d->triples[k].set != SET_BALL && point >= 0 && point < p->count)
            t->bound += p->lever * (d->triples[k].prox[0] + g->points[d->triples[k].index].blow);
    }
}

real direct_mobility(const Direct *d, const Triple *t) { return t->r / (COMPLIANCE * d->hardened); }

real direct_off(const Direct *d)
{
    real worst = singles_off(d);
    for (int i = 0; i < d->triple_count; i++) {
        const Triple *t = &d->triples[i];
        real reach = t->set == SET_BALL ? d->g->rolls[t->index].reach : 1;
        for (int k = 0; k < 3; k++)
            worst = real_max(worst, reach * t->r * fabs(t->force[k] - t->prox[k]));
    }
    return worst;
}

/* What pressed still presses, and sticks unless it slid. */
void direct_begin(Direct *d)
{
    singles_begin(d);
    for (int i = 0; i < d->triple_count; i++) {
        Triple *t = &d->triples[i];
        real y[3], from[3] = {t->prox[0], 1.001 * t->prox[1], 1.001 * t->prox[2]};
        wish(t, 0, y);
        if (t->lift > 0 && from[1] == 0 && from[2] == 0) {      /* what slides without friction so far does so as it would like to */
            from[1] = y[1];
            from[2] = y[2];
        }
        bool slips = t->lift > 0 && (from[1] != 0 || from[2] != 0);
        t->held = t->set != SET_BALL && !(t->prox[0] > 0) ? HELD_NOT : slips ? HELD_SLIPS : t->mu > 0 ? HELD_ALL : HELD_NORMAL;
        memcpy(t->force, t->prox, sizeof t->force);
        derivative(t, from, t->w);
        for (int k = 0; k < 3; k++)
            for (int m = 0; m < 3; m++)
                t->force[k] += t->w[3 * k + m] * (y[m] - t->prox[m]);
    }
}

/* The lift that the slip of this round asks for, or a better one where rounds go to and fro: by the secant through the last two, which is
 * Aitken's (Irons & Tuck 1969). Plain rounds come nearer by half each, or not at all; the bounds keep kinks from throwing it.
 * Where joints are solved, too, it goes half the way: their rows harden from round to round, and a heap of ragdolls had 6 m/s left. */
#define SECANT_LEAST 0.25
#define SECANT_MOST  8.0
static void follow_lift(const Direct *d, Triple *t, real lift)
{
    real was = t->lift, part = 1;
    if (d->swings) {
        real slope = (lift - t->slip_before) / (was - t->lift_before);
        part = isfinite(slope) && !d->g->joints_direct ? slope < 1 ? real_clamp(1 / (1 - slope), SECANT_LEAST, SECANT_MOST) : SECANT_MOST : 0.5;
    }
    t->lift = real_max(0, was + part * (lift - was));
    t->lift_before = was;
    t->slip_before = lift;
}

/* The estimate of one triple; returns how far it was off. The forces are carried on in a straight line to what the new
 * estimate wishes for: friction and gaps answer to it as they do now. */
static real next_triple(Direct *d, int i, real harder)
{
    Triple *t = &d->triples[i];
    real reach = t->set == SET_BALL ? d->g->rolls[t->index].reach : 1, lift = 0, bound = t->bound, worst = 0, y[3], y1[3];
    wish(t, 0, y);
    derivative(t, y, t->w);
    for (int k = 0; k < 3; k++) {
        worst = real_max(worst, reach * t->r * fabs(t->force[k] - t->prox[k]));
        t->prox[k] = t->force[k];
    }
    if (t->set == SET_CONE && (t->held == HELD_SLIPS || t->held == HELD_NOT))
        lift = t->mu * length_of(t->rate + 1, 2);
    if (d->late_lift)
        lift = t->lift;
    if (d->inside)
        lift = real_min(lift, t->lift);
    worst = real_max(worst, fabs(lift - t->lift));
    follow_lift(d, t, lift);
    follow_bounds(d, i);
    worst = real_max(worst, reach * t->r / (COMPLIANCE * d->hardened) * fabs(t->bound - bound));
    t->r *= harder;
    wish(t, 0, y1);
    for (int k = 0; k < 3; k++)
        for (int m = 0; m < 3; m++)
            t->force[k] += t->w[3 * k + m] * (y1[m] - y[m]);
    return worst;
}

real direct_round(Direct *d, bool harden)
{
    real worst = singles_off(d), harder = harden && d->hardened > 1.001 * d->hardest ? HARDEN : 1;
    singles_round(d, harder);
    for (int i = 0; i < d->triple_count; i++)
        worst = real_max(worst, next_triple(d, i, harder));
    d->hardened *= harder;
    d->kept = d->kept && harder == 1;
    return worst;
}
