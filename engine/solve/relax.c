/* solve/relax.c - projected block Gauss-Seidel on velocities: contact points with a round friction cone, rolling
 * resistance, joints.
 *
 * Each visit changes the bodies' velocities at once; impulses are accumulated and bounded. A sweep returns the largest
 * velocity error it met, m/s, so that the caller stops on what was reached and not on a count alone.
 */
#include "solve/direction.h"
#include "solve/fours.h"
#include "base/wide.h"
#include "math/reg3.h"

/* One point and its two bodies' velocities, which stay in registers until all is done. */
typedef struct Meet { real ima, imb; reg3 va, wa, vb, wb; } Meet;

INLINE Meet meet_begin(const Group *g, const PointRow *r)
{
    const Vel *a = &g->vel[r->a], *b = &g->vel[r->b];
    return (Meet){g->mass[r->a].im, g->mass[r->b].im, reg3_load(&a->v), reg3_of(a->w), reg3_load(&b->v), reg3_of(b->w)};
}
/* As dir_rate_between and dir_apply_between, to the same bits. */
INLINE real meet_rate(const Meet *m, const Dir *d)
{
    return reg3_dot(reg3_load(&d->n), m->vb - m->va) + reg3_dot(reg3_load(&d->aa), m->wa) + reg3_dot(reg3_load(&d->ab), m->wb);
}
INLINE void meet_apply(Meet *m, const Dir *d, real p)
{
    m->va += reg3_all(-p * m->ima) * reg3_load(&d->n);
    m->wa += reg3_all(p) * reg3_load(&d->ia);
    m->vb += reg3_all(p * m->imb) * reg3_load(&d->n);
    m->wb += reg3_all(p) * reg3_load(&d->ib);
}

INLINE real relax_normal(Meet *m, PointRow *r)
{
    if (!(r->n.k > 0))
        return 0;
    real error = r->target - meet_rate(m, &r->n);
    real jn = real_max(0, r->jn + error / r->n.k);
    real p = jn - r->jn;
    r->jn = jn;
    meet_apply(m, &r->n, p);
    return fabs(p) * r->n.k;
}

/* Sticks if the cone allows it; else steps towards the cone along the slip, with the step 1 / largest eigenvalue, whose fixed
 * point has friction opposite to slip for any tangential mass matrix (maximal dissipation). */
INLINE real relax_friction(Meet *m, PointRow *r)
{
    if (!(r->friction > 0) || !(r->kmax > 0))
        return 0;
    real u0 = meet_rate(m, &r->t[0]), u1 = meet_rate(m, &r->t[1]);
    real det = r->t[0].k * r->t[1].k - r->ktt * r->ktt;
    real j0, j1;
    real bound = (r->jn + r->blow) * (r->slides ? r->friction_dynamic : r->friction);
    bool sticks = false;
    if (det > 1e-12 * r->kmax * r->kmax) {
        j0 = r->jt[0] - (r->t[1].k * u0 - r->ktt * u1) / det;
        j1 = r->jt[1] - (r->t[0].k * u1 - r->ktt * u0) / det;
        sticks = j0 * j0 + j1 * j1 <= bound * bound;
    }
    if (!sticks) {
        j0 = r->jt[0] - u0 / r->kmax;
        j1 = r->jt[1] - u1 / r->kmax;
        real length = sqrt(j0 * j0 + j1 * j1);
        if (length > bound) {
            real s = length > 0 ? bound / length : 0;
            j0 *= s;
            j1 *= s;
        }
    }
    real p0 = j0 - r->jt[0], p1 = j1 - r->jt[1];
    r->jt[0] = j0;
    r->jt[1] = j1;
    meet_apply(m, &r->t[0], p0);
    meet_apply(m, &r->t[1], p1);
    return real_max(fabs(p0), fabs(p1)) * r->kmax;
}

INLINE void meet_end(Group *g, const Meet *m, const PointRow *r)
{
    g->vel[r->a] = (Vel){reg3_get(m->va), reg3_get(m->wa)};
    g->vel[r->b] = (Vel){reg3_get(m->vb), reg3_get(m->wb)};
}

INLINE real relax_span(Group *g, int first, int count)
{
    real worst = 0;
    Meet m;
    for (int i = first; i < first + count; i++) {
        PointRow *r = &g->points[i], *last = i > first ? r - 1 : NULL;
        if (!last || last->a != r->a || last->b != r->b) {      /* else the next point of the same two */
            if (last)
                meet_end(g, &m, last);
            m = meet_begin(g, r);
        }
        worst = real_max(worst, relax_friction(&m, r));
        worst = real_max(worst, relax_normal(&m, r));
    }
    if (count > 0)
        meet_end(g, &m, &g->points[first + count - 1]);
    return worst;
}

/* Impulses from nowhere, of all points. */
INLINE void warm_all(Group *g)
{
    Meet m;
    for (int i = 0; i < g->point_count; i++) {
        const PointRow *r = &g->points[i], *next = i + 1 < g->point_count ? r + 1 : NULL;
        if (i == 0 || r[-1].a != r->a || r[-1].b != r->b)
            m = meet_begin(g, r);
        meet_apply(&m, &r->n, r->jn);
        meet_apply(&m, &r->t[0], r->jt[0]);
        meet_apply(&m, &r->t[1], r->jt[1]);
        if (!next || next->a != r->a || next->b != r->b)
            meet_end(g, &m, r);
    }
}

static real relax_plain(Group *g, int first, int count) { return relax_span(g, first, count); }
static void warm_plain(Group *g) { warm_all(g); }
WIDE static real relax_wide(Group *g, int first, int count) { return relax_span(g, first, count); }
WIDE static void warm_wide(Group *g) { warm_all(g); }

real relax_points(Group *g, int first, int count) { return (has_wide() ? relax_wide : relax_plain)(g, first, count); }
void warm_points(Group *g) { (has_wide() ? warm_wide : warm_plain)(g); }

static Vel vel_part(Vel to, const Vel *now, const Vel *was, real part)
{
    return (Vel){vec3_mad(to.v, part, vec3_sub(now->v, was->v)), vec3_mad(to.w, part, vec3_sub(now->w, was->w))};
}

/* The points of one contact at once: each meets the same velocities, and takes its share of what it would take alone. One after the
 * other, the first of two corners takes more than the second; and where bodies lean on each other and slide, a blow has outcomes
 * that turn them aside, to which such sweeps lead, in thousands, though all is alike on both sides. */
real relax_patch(Group *g, int first, int count)
{
    if (count == 1)
        return relax_points(g, first, 1);
    int a = g->points[first].a, b = g->points[first].b;
    Vel was_a = g->vel[a], was_b = g->vel[b], to_a = was_a, to_b = was_b;
    real worst = 0, share = 1.0 / count;
    for (int i = first; i < first + count; i++) {
        PointRow *r = &g->points[i];
        real jn = r->jn, j0 = r->jt[0], j1 = r->jt[1];
        worst = real_max(worst, relax_points(g, i, 1));
        r->jn = jn + share * (r->jn - jn);
        r->jt[0] = j0 + share * (r->jt[0] - j0);
        r->jt[1] = j1 + share * (r->jt[1] - j1);
        to_a = vel_part(to_a, &g->vel[a], &was_a, share);
        to_b = vel_part(to_b, &g->vel[b], &was_b, share);
        g->vel[a] = was_a;
        g->vel[b] = was_b;
    }
    g->vel[a] = to_a;
    g->vel[b] = to_b;
    return worst;
}

static real relax_patches(Group *g)
{
    real worst = 0;
    for (int i = 0, n; i < g->point_count; i += n) {
        for (n = 1; i + n < g->point_count && g->points[i + n].contact == g->points[i].contact; n++);
        worst = real_max(worst, relax_patch(g, i, n));
    }
    return worst;
}

real relax_roll(Group *g, RollRow *r)
{
    real normal = 0;
    for (int k = 0; k < r->count; k++)
        normal += g->points[r->first + k].jn + g->points[r->first + k].blow;
    vec3 rate = vec3_sub(g->vel[r->b].w, g->vel[r->a].w);
    vec3 j = vec3_sub(r->j, mat3_mul_vec(r->inv_k, rate));
    real length = vec3_length(j), bound = r->lever * normal;
    if (length > bound)
        j = vec3_scale(length > 0 ? bound / length : 0, j);
    vec3 p = vec3_sub(j, r->j);
    r->j = j;
    vec3 da = mat3_mul_vec(g->mass[r->a].ii, p), db = mat3_mul_vec(g->mass[r->b].ii, p);
    g->vel[r->a].w = vec3_sub(g->vel[r->a].w, da);
    g->vel[r->b].w = vec3_add(g->vel[r->b].w, db);
    return r->reach * real_max(vec3_length(da), vec3_length(db));
}

real relax_rolls(Group *g)
{
    real worst = 0;
    for (int i = 0; i < g->roll_count; i++)
        worst = real_max(worst, relax_roll(g, &g->rolls[i]));
    return worst;
}

/* Part of what a sweep changes on its way. */
#define SAME 1e-9

/* Did the sweep leave all bodies as they were before it? Then rows contradict each other (a box between a wall and a piston), and only
 * their impulses go on growing. */
bool relax_in_vain(const Group *g, const Vel *before, real worst)
{
    real most = SAME * worst;
    bool same = true;
    for (int i = 0; i < g->moving_count && same; i++)
        same = vec3_largest(vec3_abs(vec3_sub(g->vel[i].v, before[i].v))) <= most &&
               vec3_largest(vec3_abs(vec3_sub(g->vel[i].w, before[i].w))) <= most;
    return same;
}

/* ---- joints ---- */

real joint_row_rate(const Group *g, const Row *r)
{
    real rate = 0;
    for (int k = 0; k < r->count; k++)
        if (r->body[k] >= 0)
            rate += vec3_dot(r->lin[k], g->vel[r->body[k]].v) + vec3_dot(r->ang[k], g->vel[r->body[k]].w);
    return rate;
}

static void row_apply(Group *g, const JointRow *r, real p)
{
    for (int k = 0; k < r->row.count; k++) {
        int b = r->row.body[k];
        if (b < 0)
            continue;
        g->vel[b].v = vec3_mad(g->vel[b].v, p, r->im[k]);
        g->vel[b].w = vec3_mad(g->vel[b].w, p, r->ii[k]);
    }
}

void joint_row_warm(Group *g, JointRow *r) { row_apply(g, r, r->p); }

/* Solves L D L^T x = b in place for the n x n factor. */
static void ldl_solve(const real *l, int n, real *x)
{
    for (int i = 0; i < n; i++)
        for (int k = 0; k < i; k++)
            x[i] -= l[i * 6 + k] * x[k];
    for (int i = 0; i < n; i++)
        x[i] *= l[i * 6 + i];           /* the inverse of D */
    for (int i = n - 1; i >= 0; i--)
        for (int k = i + 1; k < n; k++)
            x[i] -= l[k * 6 + i] * x[k];
}

static real relax_hard(Group *g, const JointBlock *b)
{
    real x[6], worst = 0;
    for (int i = 0; i < b->hard; i++) {
        JointRow *r = &g->rows[b->first + i];
        x[i] = r->bias - joint_row_rate(g, &r->row);
        worst = real_max(worst, fabs(x[i]));
    }
    ldl_solve(b->l, b->hard, x);
    for (int i = 0; i < b->hard; i++) {
        JointRow *r = &g->rows[b->first + i];
        r->p += x[i];
        row_apply(g, r, x[i]);
    }
    return worst;
}

static real relax_scalar(Group *g, JointRow *r)
{
    if (!(r->k > 0))
        return 0;
    real error = r->bias - joint_row_rate(g, &r->row) - r->gamma * r->p;
    real p = real_clamp(r->p + error / (r->k + r->gamma), r->lo, r->hi);
    real change = p - r->p;
    r->p = p;
    row_apply(g, r, change);
    return fabs(change) * r->k;
}

real relax_joints(Group *g)
{
    real worst = 0;
    for (int i = 0; i < g->block_count; i++) {
        const JointBlock *b = &g->blocks[i];
        for (int k = b->hard; k < b->count; k++)
            worst = real_max(worst, relax_scalar(g, &g->rows[b->first + k]));
        if (b->hard)
            worst = real_max(worst, relax_hard(g, b));
    }
    return worst;
}

/* ---- acceleration: nonsmooth nonlinear conjugate gradients ----
 *
 * The change of one sweep is taken as a gradient; impulses are carried on along the conjugate direction (Fletcher-Reeves) and
 * the next sweep puts them back into their cones. Silcowitz, Niebe, Erleben, "A nonsmooth nonlinear conjugate gradient method
 * for interactive contact force problems", The Visual Computer 26 (2010). A tower of ten boxes needs tens of sweeps instead of
 * thousands. */

/* What is swept: the rows as they are, or points and rolls four at a time. */
typedef struct Sweep {
    Group *g;
    Fours *fours;               /* NULL: one row after the other                       */
    real  *now;                 /* [4 quads] N s, N m s  impulses: of points and rolls, then of joints' rows; the last ones may be no row's */
    int    quads;
} Sweep;

static bool sweep_open(Sweep *s, Group *g)
{
    Fours *fours = fours_open(g, g->row_count, false);
    int count = (fours ? fours_count(fours) : 3 * g->point_count + 3 * g->roll_count) + g->row_count, quads = (count + 3) / 4;
    *s = (Sweep){g, fours, fours ? fours_impulses(fours) : arena_zero(g->arena, 4 * (size_t)quads * sizeof(real)), quads};
    if (!s->now)
        g->status = DIG_E_MEMORY;
    return g->status == DIG_OK;
}

/* From the rows to `now`; of fours it is there. */
static void read_impulses(const Sweep *s)
{
    const Group *g = s->g;
    real *x = s->now + (s->fours ? fours_count(s->fours) : 0);
    for (int i = 0; i < g->point_count && !s->fours; i++) {
        *x++ = g->points[i].jn;
        *x++ = g->points[i].jt[0];
        *x++ = g->points[i].jt[1];
    }
    for (int i = 0; i < g->roll_count && !s->fours; i++) {
        *x++ = g->rolls[i].j.x;
        *x++ = g->rolls[i].j.y;
        *x++ = g->rolls[i].j.z;
    }
    for (int i = 0; i < g->row_count; i++)
        *x++ = g->rows[i].p;
}

/* And back. */
static void write_impulses(const Sweep *s)
{
    Group *g = s->g;
    const real *x = s->now + (s->fours ? fours_count(s->fours) : 0);
    for (int i = 0; i < g->point_count && !s->fours; i++, x += 3) {
        g->points[i].jn = x[0];
        g->points[i].jt[0] = x[1];
        g->points[i].jt[1] = x[2];
    }
    for (int i = 0; i < g->roll_count && !s->fours; i++, x += 3)
        g->rolls[i].j = (vec3){x[0], x[1], x[2]};
    for (int i = 0; i < g->row_count; i++)
        g->rows[i].p = *x++;
}

static real relax_contacts(Group *g)
{
    real worst = relax_rolls(g);
    return real_max(worst, g->patches ? relax_patches(g) : relax_points(g, 0, g->point_count));
}

static real sweep_once(const Sweep *s)
{
    real worst = relax_joints(s->g);
    worst = real_max(worst, s->fours ? fours_relax(s->fours) : relax_contacts(s->g));
    read_impulses(s);
    return worst;
}

/* The conjugate direction has no guarantee where friction couples with several normals: a sweep that changes velocities this
 * many times more than the first one is off for infinity. */
#define DIVERGED 30

/* Rows that contradict each other (a body between a wall and a mover) have no solution: their impulses grow without end, and
 * more sweeps bring nothing. While the sweeps change velocities by over a hundredth of what the first did, the best of so many
 * must be better than the best of those before by a tenth. */
#define LOOK 40
#define LOOK_AGAIN 10           /* once a substep of the step has been so */
#define PROGRESS 0.9
#define FAR 0.01

typedef struct Progress { real first, best, latest; int seen, look; } Progress;

static bool stalls(Progress *p, real worst)
{
    p->first = p->seen == 0 ? worst : p->first;
    p->latest = p->seen % p->look == 0 ? worst : real_min(p->latest, worst);
    if (++p->seen % p->look != 0)
        return false;
    bool none = p->seen > p->look && p->latest > FAR * p->first && !(p->latest < PROGRESS * p->best);
    p->best = p->seen > p->look ? real_min(p->best, p->latest) : p->latest;
    return none;
}

static bool vel_finite(const Group *g)
{
    real sum = 0;
    for (int i = 0; i < g->body_count; i++)
        sum += vec3_length2(g->vel[i].v) + vec3_length2(g->vel[i].w);
    return isfinite(sum);
}

/* Impulses, and velocities: as they are, or what the one does to the other. Sums of both go together, so that no row need be applied again. */
typedef struct Line { real *x; Vel *vel; } Line;

static bool line_open(Line *l, const Sweep *s)
{
    l->x = arena_alloc(s->g->arena, 4 * (size_t)s->quads * sizeof *l->x);
    l->vel = arena_alloc(s->g->arena, (size_t)(s->g->body_count + 1) * sizeof *l->vel);
    return l->x && l->vel;
}

static void line_read(Line *l, const Sweep *s)
{
    memcpy(l->x, s->now, 4 * (size_t)s->quads * sizeof *l->x);
    memcpy(l->vel, s->g->vel, (size_t)s->g->body_count * sizeof *l->vel);
}

/* Impulses and velocities as they were: taking impulses off again would not bring back what has overflowed. */
static void back_to(const Sweep *s, const Line *l)
{
    memcpy(s->now, l->x, 4 * (size_t)s->quads * sizeof *l->x);
    write_impulses(s);
    memcpy(s->g->vel, l->vel, (size_t)s->g->body_count * sizeof *l->vel);
}

/* Of what the sweep has changed impulses by since `was`. Four sums, which do not wait for each other. */
static real change_squared(const Sweep *s, const Line *was)
{
    real sum[4] = {0, 0, 0, 0};
    for (int i = 0; i < s->quads; i++)
        for (int k = 0; k < 4; k++) {
            real change = s->now[4 * i + k] - was->x[4 * i + k];
            sum[k] += change * change;
        }
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/* Goes on by beta times `way`, which then becomes that and what the sweep has changed since `was`; and `was` is where that leads. */
static void line_go(const Sweep *s, Line *way, Line *was, real beta)
{
    real *restrict x = s->now, *restrict to = way->x, *restrict from = was->x;
    for (int i = 0; i < 4 * s->quads; i++) {
        real step = beta * to[i];
        to[i] = step + (x[i] - from[i]);
        from[i] = x[i] += step;
    }
    write_impulses(s);
    real *restrict v = (real *)s->g->vel, *restrict w = (real *)way->vel, *restrict u = (real *)was->vel;
    for (int i = 0; i < 6 * s->g->moving_count; i++) {
        real step = beta * w[i];
        w[i] = step + (v[i] - u[i]);
        u[i] = v[i] += step;
    }
}

static void line_stop(const Sweep *s, Line *way)
{
    memset(way->x, 0, 4 * (size_t)s->quads * sizeof *way->x);
    memset(way->vel, 0, (size_t)s->g->body_count * sizeof *way->vel);
}

/* Back to the start, and on without acceleration. What overflows all the same is not solved, and stays as it was. */
static int relax_plainly(const Sweep *s, const Line *start, int sweeps, real residual, real *worst)
{
    Group *g = s->g;
    int done = 0;
    real first = 0;
    Progress progress = {.look = g->contradicts ? LOOK_AGAIN : LOOK};
    back_to(s, start);
    g->stalled = false;
    *worst = INFINITY;
    while (done < sweeps && *worst > residual && !g->stalled) {
        *worst = sweep_once(s);
        first = done++ == 0 ? *worst : first;
        g->stalled = stalls(&progress, *worst);
    }
    if (vel_finite(g) && isfinite(*worst))
        return done;
    back_to(s, start);
    *worst = isfinite(first) ? first : 1e300;
    g->stalled = true;
    return done;
}

static int relax_accelerated(const Sweep *s, int sweeps, real residual, real *worst)
{
    Group *g = s->g;
    int done = 0;
    Line start, was, way;
    if (!line_open(&start, s) || !line_open(&was, s) || !line_open(&way, s)) {
        g->status = DIG_E_MEMORY;
        return 0;
    }
    real old = 0, first = INFINITY;
    Progress progress = {.look = g->contradicts ? LOOK_AGAIN : LOOK};
    read_impulses(s);
    line_read(&start, s);
    line_read(&was, s);
    line_stop(s, &way);
    *worst = INFINITY;
    bool diverged = false;
    while (done < sweeps && *worst > residual && !g->stalled) {
        *worst = sweep_once(s);
        done++;
        first = done == 1 ? *worst : first;
        g->residual_first = first;
        diverged = !(*worst <= DIVERGED * first);       /* or is no number */
        if (diverged)
            break;
        real now = change_squared(s, &was), beta = old > 0 ? now / old : 0;
        old = now;
        g->stalled = *worst > residual && (relax_in_vain(g, was.vel, *worst) || stalls(&progress, *worst));
        if (*worst <= residual || done == sweeps || g->stalled)     /* no step after the last sweep: cones hold */
            break;
        if (beta > 1) {
            line_stop(s, &way);
            line_read(&was, s);
        } else {
            line_go(s, &way, &was, beta);
        }
    }
    if (diverged || !vel_finite(g))
        done += relax_plainly(s, &start, sweeps, residual, worst);
    return done;
}

int relax(Group *g, int sweeps, real residual)
{
    real worst = 0;
    int done = 0;
    g->stalled = false;
    if (g->point_count + g->roll_count + g->row_count > 0) {
        ArenaMark mark = arena_mark(g->arena);
        Sweep s;
        if (sweep_open(&s, g))
            done = relax_accelerated(&s, sweeps, residual, &worst);
        if (s.fours)
            fours_close(s.fours);
        arena_rewind(g->arena, mark);
    }
    g->residual = real_max(g->residual, worst == INFINITY ? 0 : worst);
    g->sweeps += int_max(done, 1);
    return done;
}
