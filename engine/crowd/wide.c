/* crowd/wide.c - the substeps, eight rows at a time, or sixteen.
 *
 * Written once in vectors of so many floats as are computed at once. Those of eight the compiler splits where registers are shorter, and it
 * is compiled for several sets of instructions; those of sixteen are for AVX-512 (wide16.c). Every lane computes with the same rounded
 * operations in the same order, without fused multiply-adds: the bits are the same on all.
 */
#include "crowd/lanes.h"

/* ---- rows from points ---- */

typedef struct Axes { wide s[9], root; } Axes;      /* columns of S */

INLINE void gather_axes(const Crowd *c, const int32_t at[AT_ONCE], Axes *to)
{
    wide first[8], second[8];
    gather(c->axes[0], at, first);
    gather(c->axes[1], at, second);
    UNROLL
    for (int i = 0; i < 8; i++)
        to->s[i] = first[i];
    to->s[8] = second[0];
    to->root = second[1];
}

/* S^T v */
INLINE void scaled(const Axes *x, const wide v[3], Wide out[3])
{
    out[0].own = dot(&x->s[0], v);
    out[1].own = dot(&x->s[3], v);
    out[2].own = dot(&x->s[6], v);
}

/* Angular Jacobians of direction n at points ra, rb from the centres of mass. */
INLINE void angular(const Axes *a, const Axes *b, const wide n[3], const wide ra[3], const wide rb[3], Wide ja[3], Wide jb[3])
{
    wide ta[3], tb[3];
    cross(n, ra, ta);
    cross(rb, n, tb);
    scaled(a, ta, ja);
    scaled(b, tb, jb);
}

INLINE wide inverse_of(wide x) { return all(1) / most(x, all(1e-30f)); }

INLINE void prepare_patch(const Lot *x, const Axes *a, const Axes *b, const wide middle[2][3], wide linear)
{
    WidePatch *f = x->patch;
    const wide t[3] = THREE(f->t);
    wide u[3];
    cross(x->n, t, u);
    angular(a, b, t, middle[0], middle[1], f->ta, f->tb);
    angular(a, b, u, middle[0], middle[1], f->ua, f->ub);
    const wide ta[3] = THREE(f->ta), tb[3] = THREE(f->tb), ua[3] = THREE(f->ua), ub[3] = THREE(f->ub);
    wide ktt = linear + dot(ta, ta) + dot(tb, tb), kuu = linear + dot(ua, ua) + dot(ub, ub);
    wide ktu = dot(ta, ua) + dot(tb, ub), half = all(0.5f) * (ktt - kuu);
    f->ktt.own = kuu;               /* the inverse of a 2 x 2 matrix exchanges them */
    f->kuu.own = ktt;
    f->ktu.own = -ktu;
    f->det.own = inverse_of(ktt * kuu - ktu * ktu);
    f->step.own = inverse_of(all(0.5f) * (ktt + kuu) + root(half * half + ktu * ktu));
    f->sum[0].own = f->sum[1].own = all(0);
}

INLINE void prepare_twist(const Lot *x, const Axes *a, const Axes *b)
{
    WideTwist *t = x->twist;
    wide minus[3] = {-x->n[0], -x->n[1], -x->n[2]};
    scaled(a, minus, t->a);
    scaled(b, x->n, t->b);
    const wide ja[3] = THREE(t->a), jb[3] = THREE(t->b);
    t->mass.own = inverse_of(dot(ja, ja) + dot(jb, jb));
    t->sum.own = all(0);
}

/* What does not move is read and written like the rest: each thread has a body that is nobody's. */
INLINE void spare(const Crowd *c, int32_t at[AT_ONCE], int thread)
{
    for (int i = 0; i < AT_ONCE; i++)
        at[i] = at[i] < c->bodies ? at[i] : crowd_spare(c, thread);
}

/* Ball against ball, or against what does not move: only arms are scaled. */
INLINE void prepare_round(Lot *x, const Axes *a, const Axes *b, wide closing)
{
    WidePoint *p = x->point;
    wide linear = x->ra * x->ra + x->rb * x->rb, present = p->mass.own;
    p->mass.own = present * inverse_of(linear);
    p->rate_before.own = present * closing;
    p->sum.own = all(0);
    if (!x->rub)
        return;
    WideRub *r = x->rub;
    r->a.own *= a->s[0];
    r->b.own *= b->s[0];
    r->mass.own = inverse_of(linear + r->a.own * r->a.own + r->b.own * r->b.own);
    r->sum[0].own = r->sum[1].own = r->sum[2].own = all(0);
}

/* What is one vector a point becomes its Jacobian, and the middle of the points the place of friction. */
INLINE void prepare_lot(const Crowd *c, Lot *x, int thread)
{
    spare(c, x->a, thread);
    spare(c, x->b, thread);
    Axes a, b;
    wide va[8], vb[8], middle[2][3], count = all(0), reach = all(0);
    gather_axes(c, x->a, &a);
    gather_axes(c, x->b, &b);
    gather(c->vel, x->a, va);
    gather(c->vel, x->b, vb);
    x->of->ra.own = x->ra = a.root;
    x->of->rb.own = x->rb = b.root;
    wide linear = x->ra * x->ra + x->rb * x->rb, closing = all(0);
    UNROLL
    for (int k = 0; k < 3; k++)
        closing += x->n[k] * (x->rb * vb[k] - x->ra * va[k]);
    if (x->round) {
        prepare_round(x, &a, &b, closing);
        return;
    }
    for (int i = 0; i < x->points; i++)
        count += x->point[i].mass.own;
    UNROLL
    for (int k = 0; k < 3; k++) {
        middle[0][k] = middle[1][k] = all(0);
        for (int i = 0; i < x->points; i++) {
            middle[0][k] += x->arms[i].a[k].own;
            middle[1][k] += x->arms[i].b[k].own;
        }
        middle[0][k] *= inverse_of(count);
        middle[1][k] *= inverse_of(count);
    }
    for (int i = 0; i < x->points; i++) {
        WidePoint *p = &x->point[i];
        WideArms *arm = &x->arms[i];
        wide_int moves = x->ra > 0;
        const wide ra[3] = THREE(arm->a), rb[3] = THREE(arm->b);
        wide off[3], present = p->mass.own;
        UNROLL
        for (int k = 0; k < 3; k++)
            off[k] = pick(moves, ra[k] - middle[0][k], rb[k] - middle[1][k]);
        reach += present * root(dot(off, off));
        angular(&a, &b, x->n, ra, rb, arm->a, arm->b);
        const wide ja[3] = THREE(arm->a), jb[3] = THREE(arm->b);
        p->mass.own = present * inverse_of(linear + dot(ja, ja) + dot(jb, jb));
        wide rate = closing + dot(ja, &va[3]) + dot(jb, &vb[3]);
        p->rate_before.own = present * (x->drive ? rate + x->drive[i].own : rate);
        p->sum.own = all(0);
    }
    if (x->patch)
        prepare_patch(x, &a, &b, (const wide(*)[3])middle, linear);
    if (x->twist) {
        prepare_twist(x, &a, &b);
        x->twist->reach.own = reach * inverse_of(count);
    }
}

INLINE void prepare(const Crowd *c, Batch *b, int thread)
{
    for (int i = 0; i < lots(b); i++) {
        Lot x = lot_of(b, i);
        prepare_lot(c, &x, thread);
    }
}

/* ---- one batch ---- */

typedef struct Both { wide a[8], b[8]; } Both;      /* of the two bodies of each lane */

INLINE void gather_both(const Six *from, const Lot *x, Both *to)
{
    gather(from, x->a, to->a);
    gather(from, x->b, to->b);
}

/* b's linear coordinates less a's, as velocities (or displacements). */
INLINE void between(const Lot *x, const Both *v, wide out[3])
{
    UNROLL
    for (int i = 0; i < 3; i++)
        out[i] = x->rb * v->b[i] - x->ra * v->a[i];
}

INLINE void push_linear(const Lot *x, Both *v, const wide n[3], wide p)
{
    wide pa = p * x->ra, pb = p * x->rb;
    UNROLL
    for (int i = 0; i < 3; i++) {
        v->a[i] -= pa * n[i];
        v->b[i] += pb * n[i];
    }
}

INLINE void push_angular(Both *v, const Wide a[3], const Wide b[3], wide p)
{
    UNROLL
    for (int i = 0; i < 3; i++) {
        v->a[3 + i] += p * a[i].own;
        v->b[3 + i] += p * b[i].own;
    }
}

/* By a vector across the normal. */
INLINE void push_rub(const Lot *x, Both *v, const wide p[3])
{
    wide turn[3];
    cross(p, x->n, turn);
    UNROLL
    for (int i = 0; i < 3; i++) {
        v->a[i] -= x->ra * p[i];
        v->b[i] += x->rb * p[i];
        v->a[3 + i] += x->rub->a.own * turn[i];
        v->b[3 + i] += x->rub->b.own * turn[i];
    }
}

INLINE wide normal_sum(const Lot *x)
{
    wide sum = x->point[0].j.own;
    for (int k = 1; k < x->points; k++)
        sum += x->point[k].j.own;
    return sum;
}

/* Sticks where the cone allows it; else a step along the slip, back onto the cone: friction then opposes slip for any matrix. */
INLINE void solve_friction(const Lot *x, Both *v, wide bound)
{
    WidePatch *f = x->patch;
    const wide t[3] = THREE(f->t);
    wide d[3], u[3];
    cross(x->n, t, u);
    between(x, v, d);
    wide rt = dot(t, d) + dot_of(f->ta, &v->a[3]) + dot_of(f->tb, &v->b[3]), ru = dot(u, d) + dot_of(f->ua, &v->a[3]) + dot_of(f->ub, &v->b[3]);
    if (x->drive) {
        rt += x->drive[x->points].own;
        ru += x->drive[x->points + 1].own;
    }
    wide st = f->j[0].own - f->det.own * (f->ktt.own * rt + f->ktu.own * ru), su = f->j[1].own - f->det.own * (f->ktu.own * rt + f->kuu.own * ru);
    wide gt = f->j[0].own - f->step.own * rt, gu = f->j[1].own - f->step.own * ru;
    wide length = root(gt * gt + gu * gu), scale = bound / most(length, all(1e-30f));
    scale = least(scale, all(1));
    wide_int sticks = st * st + su * su <= bound * bound;
    wide jt = pick(sticks, st, gt * scale), ju = pick(sticks, su, gu * scale);
    wide pt = jt - f->j[0].own, pu = ju - f->j[1].own;
    f->j[0].own = jt;
    f->j[1].own = ju;
    push_linear(x, v, t, pt);
    push_linear(x, v, u, pu);
    push_angular(v, f->ta, f->tb, pt);
    push_angular(v, f->ua, f->ub, pu);
}

INLINE void solve_twist(const Lot *x, Both *v, wide bound)
{
    WideTwist *t = x->twist;
    wide rate = dot_of(t->a, &v->a[3]) + dot_of(t->b, &v->b[3]), top = bound * t->reach.own;
    rate = x->drive ? rate + x->drive[x->points + 2].own : rate;
    wide j = least(top, most(-top, t->j.own - t->mass.own * rate)), p = j - t->j.own;
    t->j.own = j;
    push_angular(v, t->a, t->b, p);
}

INLINE void push_roll(Both *v, const WideRoll *r, const wide p[3])
{
    UNROLL
    for (int i = 0; i < 3; i++) {
        UNROLL
        for (int k = 0; k < 3; k++) {
            v->a[3 + k] -= r->sa[3 * i + k].own * p[i];
            v->b[3 + k] += r->sb[3 * i + k].own * p[i];
        }
    }
}

INLINE void solve_roll(const Lot *x, Both *v, wide load)
{
    WideRoll *r = x->roll;
    wide rate[3], j[3], p[3];
    UNROLL
    for (int i = 0; i < 3; i++)
        rate[i] = dot_of(&r->sb[3 * i], &v->b[3]) - dot_of(&r->sa[3 * i], &v->a[3]) + r->drive[i].own;
    j[0] = r->j[0].own - (r->k[0].own * rate[0] + r->k[1].own * rate[1] + r->k[2].own * rate[2]);
    j[1] = r->j[1].own - (r->k[1].own * rate[0] + r->k[3].own * rate[1] + r->k[4].own * rate[2]);
    j[2] = r->j[2].own - (r->k[2].own * rate[0] + r->k[4].own * rate[1] + r->k[5].own * rate[2]);
    wide scale = least(all(1), r->lever.own * load / most(root(dot(j, j)), all(1e-30f)));
    UNROLL
    for (int i = 0; i < 3; i++) {
        j[i] *= scale;
        p[i] = j[i] - r->j[i].own;
        r->j[i].own = j[i];
    }
    push_roll(v, r, p);
}

/* How overlap and gap bear on a row: rate wanted, and how firmly. */
typedef struct Care { wide rate, push_most, mass, keep, per_step, time, worst; bool push, first; } Care;

/* The pushing pass: an overlap is pushed out softly, a gap may close within the substep. What is left of it is for the other pass. */
INLINE wide pushed_impulse(WidePoint *p, Care *k, wide rate, wide gap, wide care)
{
    wide_int open = gap > 0;
    wide bias = pick(open, gap * k->per_step, most(gap * k->rate, -k->push_most));
    wide j = p->j.own - pick(open, p->mass.own, p->mass.own * k->mass) * (rate + bias) - pick(open, all(0), (p->j.own - p->borne.own) * k->keep);
    j = most(j, all(0));
    wide by = (j - p->j.own) / most(p->mass.own, all(1e-30f));
    p->room.own = most(all(0), gap * k->per_step + rate + by);
    k->worst = most(k->worst, most(by, -by) * care);
    return j;
}

/* The relaxing pass: what the other one left, less what pushed. */
INLINE wide relaxed_impulse(WidePoint *p, Care *k, wide rate, wide care)
{
    wide j = most(p->j.own - p->mass.own * (rate + p->room.own), all(0));
    wide by = (j - p->j.own) / most(p->mass.own, all(1e-30f));
    k->worst = most(k->worst, most(by, -by) * care);
    p->sum.own += k->first ? j : j - p->j.own;
    return j;
}

/* Returns the change of the impulse of a point whose bodies go apart at this rate. */
INLINE wide solve_point(const Lot *x, WidePoint *p, Care *k, wide rate)
{
    wide j = k->push ? pushed_impulse(p, k, rate, p->now.own, x->of->care.own) : relaxed_impulse(p, k, rate, x->of->care.own);
    wide change = j - p->j.own;
    p->j.own = j;
    return change;
}

/* What the centres of mass do along the normal, and what spins and movers add to that at point i: velocities, or displacements in a time. */
INLINE wide at_point(const Lot *x, int i, const Both *d, wide centres, wide time)
{
    if (!x->round)
        centres = centres + dot_of(x->arms[i].a, &d->a[3]) + dot_of(x->arms[i].b, &d->b[3]);
    return x->drive ? centres + x->drive[i].own * time : centres;
}

/* Gaps hold for all passes of a substep that push. */
INLINE void find_gaps(const Crowd *c, const Lot *x, wide time)
{
    Both d;
    wide b[3];
    gather_both(c->move, x, &d);
    between(x, &d, b);
    wide closed = dot(x->n, b);
    for (int i = 0; i < x->points; i++) {
        WidePoint *p = &x->point[i];
        p->now.own = at_point(x, i, &d, p->gap.own + closed, time);
    }
}

/* One direction for all points of a contact: rate along the normal of the centres of mass is kept up by hand. */
INLINE void solve_points(const Lot *x, Both *v, Care *k)
{
    wide b[3], inverse = x->ra * x->ra + x->rb * x->rb, pushed = all(0);
    between(x, v, b);
    wide rate0 = dot(x->n, b);
    for (int i = 0; i < x->points; i++) {
        WidePoint *p = &x->point[i];
        wide rate = at_point(x, i, v, rate0, all(1));
        wide change = solve_point(x, p, k, rate);
        pushed += change;
        rate0 += inverse * change;
        push_angular(v, x->arms[i].a, x->arms[i].b, change);
    }
    push_linear(x, v, x->n, pushed);
}

/* Sticks where the cone allows it, else it opposes the slip, which is what is across the normal: between is the relative velocity of
 * the centres, along that which is along it. */
INLINE void solve_rub(const Lot *x, Both *v, const Care *k, const wide between[3], wide along, wide bound)
{
    WideRub *r = x->rub;
    wide spin[3], roll[3], f[3], p[3];
    UNROLL
    for (int i = 0; i < 3; i++)
        spin[i] = r->a.own * v->a[3 + i] + r->b.own * v->b[3 + i];
    cross(x->n, spin, roll);
    UNROLL
    for (int i = 0; i < 3; i++)
        f[i] = r->j[i].own - r->mass.own * (between[i] - along * x->n[i] + roll[i]);
    wide scale = least(all(1), bound / most(root(dot(f, f)), all(1e-30f)));
    UNROLL
    for (int i = 0; i < 3; i++) {
        f[i] *= scale;
        p[i] = f[i] - r->j[i].own;
        r->j[i].own = f[i];
        if (!k->push)
            r->sum[i].own += k->first ? f[i] : p[i];
    }
    push_rub(x, v, p);
}

/* Friction is across the normal, and changes nothing along it. */
INLINE void solve_round(const Lot *x, Both *v, Care *k)
{
    wide b[3];
    between(x, v, b);
    wide along = dot(x->n, b);
    if (x->rub)
        solve_rub(x, v, k, b, along, x->point->j.own * x->of->friction.own);
    push_linear(x, v, x->n, solve_point(x, x->point, k, along));
}

INLINE void solve_flat(const Lot *x, Both *v, Care *k)
{
    wide load = normal_sum(x), before[3] = {all(0), all(0), all(0)};
    bool driven = x->twist && x->drive;         /* nobody asks for the sum of other twists */
    if (x->roll)
        solve_roll(x, v, load);
    if (x->patch && !k->first) {
        before[0] = x->patch->j[0].own;
        before[1] = x->patch->j[1].own;
        before[2] = driven ? x->twist->j.own : before[2];
    }
    if (x->patch) {
        if (x->twist)
            solve_twist(x, v, load * x->of->friction.own);
        solve_friction(x, v, load * x->of->friction.own);
    }
    solve_points(x, v, k);
    if (x->patch && !k->push) {
        x->patch->sum[0].own += x->patch->j[0].own - before[0];
        x->patch->sum[1].own += x->patch->j[1].own - before[1];
        if (driven)
            x->twist->sum.own += x->twist->j.own - before[2];
    }
}

INLINE void solve_lot(const Crowd *c, const Lot *x, Care *k)
{
    Both v;
    if (k->push && k->first)
        find_gaps(c, x, k->time);
    gather_both(c->vel, x, &v);
    if (x->round)
        solve_round(x, &v, k);
    else
        solve_flat(x, &v, k);
    scatter(c->vel, x->a, v.a);
    scatter(c->vel, x->b, v.b);
}

INLINE void solve_batch(const Crowd *c, Batch *b, Care *k)
{
    for (int i = 0; i < lots(b); i++) {
        const Lot x = lot_of(b, i);
        solve_lot(c, &x, k);
    }
}

/* The part of one thread in work on all bodies or batches, and whom it meets: who else does so. */
typedef struct Part { Team *team; int thread, threads; } Part;

#define MY_BODIES(c, me, i) \
    for (int i = team_first((c)->bodies, (me)->thread, (me)->threads), end = team_end((c)->bodies, (me)->thread, (me)->threads); i < end; i++)
#define MY_BATCHES(phase, me, i) \
    for (int i = phase_first(phase, (me)->thread, (me)->threads), end = phase_end(phase, (me)->thread, (me)->threads); i < end; i++)

/* Before a phase all must have done the one before it; not where one thread does both. */
INLINE void meet_before(const Crowd *c, const Part *me, int phase)
{
    if (me->threads > 1 && phase > 0 && (phase_shared(c->phase[phase - 1]) || phase_shared(c->phase[phase])))
        team_meet(me->team);
}

INLINE void meet(const Part *me)
{
    if (me->threads > 1)
        team_meet(me->team);
}

#define AHEAD 2                 /* batches */

/* Bodies that another thread had in the colour before come from its cache, which takes as long as a batch or two: they are asked for in time. */
INLINE void ask_for(const Crowd *c, int batch)
{
    if (batch >= c->batches)
        return;
    const Batch *x = &c->batch[batch];
    UNROLL
    for (int i = 0; i < LANES; i++) {
        __builtin_prefetch(&c->vel[x->a[i]], 1);
        __builtin_prefetch(&c->vel[x->b[i]], 1);
    }
}

/* soft: NULL = a relaxing pass. Returns the worst error of this thread's rates over what matters. */
INLINE float pass(const Crowd *c, const Part *me, const Soft (*soft)[2], float time, bool first)
{
    Care k = {.push_most = all(c->push_most), .per_step = all(1 / c->h), .time = all(time), .worst = all(0), .push = soft != NULL, .first = first};
    for (int p = 0; p < c->phases; p++) {
        meet_before(c, me, p);
        MY_BATCHES(c->phase[p], me, i) {
            const Soft s = soft ? soft[bearing_of(&c->batch[i])][c->batch[i].fixed] : (Soft){0};
            k.rate = all(s.rate);
            k.mass = all(s.mass);
            k.keep = all(s.keep);
            if (me->threads > 1)
                ask_for(c, i + AHEAD);
            solve_batch(c, &c->batch[i], &k);
        }
    }
    float most = 0;
    for (int i = 0; i < AT_ONCE; i++)
        most = k.worst[i] > most ? k.worst[i] : most;
    return most;
}

INLINE float worst_of(const Crowd *c, const Part *me, int which)
{
    float most = 0;
    for (int i = 0; i < me->threads; i++)
        most = c->worst[which][i] > most ? c->worst[which][i] : most;
    return most;
}

/* Passes until the rates hold, at least so many and at most; those that push harden with their number. Returns how many were needed. */
INLINE int passes_of(const Crowd *c, const Part *me, bool push, int least, int most, float time)
{
    for (int n = 0;; n++) {
        int hard = n + 1 > least ? n + 1 : least;
        c->worst[n & 1][me->thread] = pass(c, me, push ? c->soft[hard - 1] : NULL, time, n == 0);
        meet(me);
        if (n + 1 >= least && (n + 1 >= most || worst_of(c, me, n & 1) <= 1))
            return n + 1;
    }
}

/* ---- the substeps ---- */

INLINE void warm_lot(const Crowd *c, const Lot *x)
{
    Both v;
    gather_both(c->vel, x, &v);
    push_linear(x, &v, x->n, normal_sum(x));
    if (x->rub) {
        const wide j[3] = THREE(x->rub->j);
        push_rub(x, &v, j);
    }
    for (int k = 0; k < x->points && !x->round; k++)
        push_angular(&v, x->arms[k].a, x->arms[k].b, x->point[k].j.own);
    if (x->patch) {
        WidePatch *f = x->patch;
        const wide t[3] = THREE(f->t);
        wide u[3];
        cross(x->n, t, u);
        push_linear(x, &v, t, f->j[0].own);
        push_linear(x, &v, u, f->j[1].own);
        push_angular(&v, f->ta, f->tb, f->j[0].own);
        push_angular(&v, f->ua, f->ub, f->j[1].own);
    }
    if (x->twist)
        push_angular(&v, x->twist->a, x->twist->b, x->twist->j.own);
    if (x->roll) {
        const wide j[3] = THREE(x->roll->j);
        push_roll(&v, x->roll, j);
    }
    scatter(c->vel, x->a, v.a);
    scatter(c->vel, x->b, v.b);
}

INLINE void warm_batch(const Crowd *c, Batch *b)
{
    for (int i = 0; i < lots(b); i++) {
        const Lot x = lot_of(b, i);
        warm_lot(c, &x);
    }
}

INLINE void warm_start(const Crowd *c, const Part *me)
{
    for (int p = 0; p < c->phases; p++) {
        meet_before(c, me, p);
        MY_BATCHES(c->phase[p], me, i)
            warm_batch(c, &c->batch[i]);
    }
}

/* The forces and, by the last difference, the impulses of the substep before. */
INLINE void speed_up(const Crowd *c, const Part *me, bool first)
{
    MY_BODIES(c, me, i) {
        six *v = (six *)(void *)&c->vel[i], *last = (six *)(void *)&c->last[i];
        six now = *v;
        *v = now + (first ? *(const six *)(const void *)&c->push[i] : now - *last);
        *last = now;
    }
}

INLINE void move_on(const Crowd *c, const Part *me)
{
    MY_BODIES(c, me, i)
        *(six *)(void *)&c->move[i] += c->h * *(const six *)(const void *)&c->vel[i];
}

/* What approached and was stopped leaves with its share of the approach. */
INLINE void bounce_lot(const Crowd *c, const Lot *x)
{
    Both v;
    gather_both(c->vel, x, &v);
    for (int i = 0; i < x->points; i++) {
        WidePoint *p = &x->point[i];
        wide b[3];
        between(x, &v, b);
        wide rate = at_point(x, i, &v, dot(x->n, b), all(1));
        wide_int struck = (p->rate_before.own < all(-c->bounce_least)) & (p->sum.own > 0);
        wide j = most(p->j.own - p->mass.own * (rate + x->of->restitution.own * p->rate_before.own), all(0));
        wide change = pick(struck, j - p->j.own, all(0));
        p->room.own = change;
        push_linear(x, &v, x->n, change);
        if (!x->round)
            push_angular(&v, x->arms[i].a, x->arms[i].b, change);
    }
    scatter(c->vel, x->a, v.a);
    scatter(c->vel, x->b, v.b);
}

INLINE void bounce(const Crowd *c, Batch *b)
{
    for (int i = 0; i < lots(b); i++) {
        const Lot x = lot_of(b, i);
        bounce_lot(c, &x);
    }
}

/* Restitution; what depends on sums over all bodies is one thread's. */
INLINE void bounce_all(Crowd *c, const Part *me)
{
    meet(me);
    if (me->thread == 0)
        memcpy(c->last, c->vel, (size_t)c->bodies * sizeof *c->last);
    meet(me);
    for (int p = 0; p < c->phases; p++) {
        meet_before(c, me, p);
        MY_BATCHES(c->phase[p], me, i)
            if (c->batch[i].bounces)
                bounce(c, &c->batch[i]);
    }
    meet(me);
    if (me->thread == 0)
        bounce_share(c);
}

/* ---- what is deep after all ---- */

/* m  Overlap that is nothing to care about. */
INLINE wide shallow(const Crowd *c, const Lot *x) { return all(c->leaves * c->h) / x->of->care.own; }

INLINE bool any_of(wide_int which)
{
    int found = 0;
    for (int i = 0; i < AT_ONCE; i++)
        found |= which[i];
    return found;
}

/* Takes from each point of the batch what it overlaps by over what is shallow, by moving its bodies alone, no faster than springs may:
 * velocities and impulses stay. Returns whether there was anything to take. */
INLINE bool separate_lot(const Crowd *c, const Lot *x)
{
    Both d;
    gather_both(c->move, x, &d);
    wide most_by = all(c->push_most * c->h), bound = shallow(c, x), time = all((float)c->substeps * c->h);
    wide_int any = {0};
    for (int i = 0; i < x->points; i++) {
        const WidePoint *p = &x->point[i];
        wide b[3];
        between(x, &d, b);
        wide gap = at_point(x, i, &d, p->gap.own + dot(x->n, b), time);
        wide j = p->mass.own * least(most(-gap - bound, all(0)), most_by);      /* no point in a lane: mass 0 */
        any |= j > all(0);
        push_linear(x, &d, x->n, j);
        if (!x->round)
            push_angular(&d, x->arms[i].a, x->arms[i].b, j);
    }
    if (!any_of(any))
        return false;
    scatter(c->move, x->a, d.a);
    scatter(c->move, x->b, d.b);
    return true;
}

INLINE bool separate_batch(const Crowd *c, Batch *b)
{
    bool any = false;
    for (int i = 0; i < lots(b); i++) {
        const Lot x = lot_of(b, i);
        any |= separate_lot(c, &x);
    }
    return any;
}

INLINE void separate(const Crowd *c, const Part *me)
{
    for (int n = 0; n < c->separations; n++) {
        bool any = false;
        for (int p = 0; p < c->phases; p++) {
            meet_before(c, me, p);
            MY_BATCHES(c->phase[p], me, i)
                any |= (c->lifts || !c->batch[i].shares) && separate_batch(c, &c->batch[i]);
        }
        c->worst[n & 1][me->thread] = any;
        meet(me);
        if (worst_of(c, me, n & 1) == 0)
            return;
    }
}

/* What comes to rest carries what it carries without overlap. */
INLINE void bear(Batch *b)
{
    for (int i = 0; i < lots(b); i++) {
        const Lot x = lot_of(b, i);
        for (int k = 0; k < x.points; k++)
            x.point[k].borne.own = x.point[k].j.own;
    }
}

INLINE void solve(Crowd *c, const Part *me)
{
    for (int p = 0; p < c->phases; p++)
        MY_BATCHES(c->phase[p], me, i) {
            prepare(c, &c->batch[i], me->thread);
            if (c->settles)
                bear(&c->batch[i]);
        }
    meet(me);
    int passes = c->passes, all_passes = 0;
    for (int s = 0; s < c->substeps; s++) {
        speed_up(c, me, s == 0);
        meet(me);
        if (s == 0) {
            warm_start(c, me);
            meet(me);
        }
        passes = passes_of(c, me, true, passes, c->passes_most, (float)s * c->h);
        all_passes += passes;
        move_on(c, me);
        meet(me);
        passes_of(c, me, false, 1, passes, (float)(s + 1) * c->h);
    }
    separate(c, me);
    if (me->thread == 0)        /* the others have theirs, and the last meeting is over */
        c->passes = all_passes;
    bool bounces = false;
    for (int i = 0; i < c->batches; i++)
        bounces = bounces || c->batch[i].bounces;
    if (bounces)
        bounce_all(c, me);
}

INLINE void solve_part(void *context, int thread, int threads)
{
    Crowd *c = context;
    solve(c, &(Part){c->team, thread, threads});
}

#if AT_ONCE == 16
AVX512 static void solve_avx512(void *context, int thread, int threads) { solve_part(context, thread, threads); }

void wide_solve_longest(Crowd *c) { team_run(c->team, solve_avx512, c); }
#else
FOR_WIDTHS(solve_for, solve_part)

void wide_solve(Crowd *c)
{
    if (c->width == WIDTH_AVX512)
        wide_solve_longest(c);
    else
        team_run(c->team, solve_for(c), c);
}
#endif
