/* chain/solve.c - one implicit step of a tree of bodies, by Newton's method from a guess that is nearly right.
 *
 * Everything angular is in the axes of the body it belongs to: levers of points are then constants, and the slope is
 *
 *     A = I (1 + [c/2] + c c^T / 4) / (k h) - [I W] + sum of ((p . r) 1 - r p^T) / 2
 *
 * whose last term, how joint forces change as a body turns, is the geometric stiffness. With levers E at the end, M of the
 * discrete gradient, and the turn `loose` that would be without joints, the rows' impulses change by
 *
 *     (k h / m + E A^-1 M^T) dp = -C - E loose          one such front for each body, added up joint by joint
 */
#include "chain/system.h"

#define ITERATIONS 8
#define TURN_AT_ONCE 0.5        /* rad   of one iteration                                           */
#define TURN_SMALL 0.03         /* rad   an iteration that turned no body further is nearly exact   */
#define TURN_TINY 0.003         /* rad   the same after a blow, when the guess is far off           */
#define CAYLEY_MOST 2.0         /* of the Cayley vector: 90 degrees                                 */
#define SHARE 1e-8              /* of a row's own diagonal, that keeps redundant joints solvable    */

/* ---- the pose ---- */

/* c from the pose and the velocity that it implies. False: too far a turn, or NaN. */
static bool imply(const Chain *c, Link *l)
{
    quat d = quat_mul(quat_conjugate(l->q0), l->q);
    l->c = vec3_scale(2 / d.w, (vec3){d.x, d.y, d.z});
    l->w = vec3_scale(1 / c->k, vec3_mad(vec3_scale(1 / c->h, l->c), c->k - 1, l->w0));
    l->r = quat_matrix(l->q);
    return vec3_length2(l->c) < CAYLEY_MOST * CAYLEY_MOST;
}

static vec3 point_impulse(const Tie *t, const End *e) { return vec3_scale(e->side, t->p); }

/* Positions follow from the impulses without error. */
static void move(const Chain *c, Link *l)
{
    vec3 p = l->p0;
    for (const End *e = c->end + l->end; e < c->end + l->end + l->ends; e++)
        p = vec3_add(p, point_impulse(&c->tie[e->tie], e));
    l->v = vec3_scale(1 / l->mass, p);
    l->x = vec3_mad(l->x0, c->h, vec3_add(vec3_scale(c->k, l->v), vec3_scale(1 - c->k, l->v0)));
}

static void predict(const Chain *c, Link *l)
{
    vec3 spin = l->l0;
    for (End *e = c->end + l->end; e < c->end + l->end + l->ends; e++) {
        e->r0 = mat3_mul_vec(l->r0, e->arm);
        spin = vec3_add(spin, vec3_cross(e->r0, point_impulse(&c->tie[e->tie], e)));
    }
    vec3 w = mat3_mul_vec(mat3_inverse(l->inertia), mat3_mul_vec(mat3_transpose(l->r0), spin));
    vec3 g = vec3_scale(0.5 * c->h, vec3_add(vec3_scale(c->k, w), vec3_scale(1 - c->k, l->w0)));
    l->q = quat_unit(quat_mul(l->q0, (quat){g.x, g.y, g.z, 1}));
    move(c, l);
}

/* ---- errors ---- */

/* Arms, and by how much each joint is off; the largest error. INFINITY: a body turned too far. */
static real place(const Chain *c, const Linkage *t)
{
    real worst = 0;
    for (int n = t->first; n < t->first + t->links; n++) {
        Link *l = &c->link[n];
        if (!imply(c, l))
            return INFINITY;
        for (End *e = c->end + l->end; e < c->end + l->end + l->ends; e++)
            e->r = mat3_mul_vec(l->r, e->arm);
    }
    for (int n = t->first + t->links - 1; n >= t->first; n--) {
        const Link *l = &c->link[n];
        for (int i = 0; i < l->ends; i++) {
            const End *e = &c->end[l->end + i];
            Tie *tie = &c->tie[e->tie];
            vec3 at = vec3_scale(e->side, vec3_add(l->x, e->r));
            if (link_owns(l, i))            /* the link that hangs on this one has set its part before */
                at = vec3_add(at, e->child < 0 ? vec3_scale(-e->side, tie->fixed) : tie->error);
            tie->error = at;
            if (link_owns(l, i))
                worst = real_max(worst, vec3_largest(vec3_abs(at)));
        }
    }
    return isfinite(worst) ? worst : INFINITY;
}

/* ---- the front of a body ---- */

typedef struct Levers { vec3 end[LINK_ROWS], mid[LINK_ROWS]; } Levers;      /* body axes */

/* Of the rows of one end, with their impulses' torque and how that changes with the turn. */
static void add_levers(const Tie *t, const End *e, const Link *l, const mat3 *back, Levers *to, vec3 *twist, mat3 *slope)
{
    const vec3 axis[3] = {vec3_scale(e->side, l->r.r0), vec3_scale(e->side, l->r.r1), vec3_scale(e->side, l->r.r2)};
    vec3 mid = vec3_scale(0.5, vec3_add(e->arm, mat3_mul_vec(*back, e->r0)));
    vec3 p = vec3_mad(vec3_mad(vec3_scale(t->p.x, axis[0]), t->p.y, axis[1]), t->p.z, axis[2]);
    for (int i = 0; i < 3; i++) {
        to->end[e->at + i] = vec3_cross(e->arm, axis[i]);
        to->mid[e->at + i] = vec3_cross(mid, axis[i]);
    }
    *twist = vec3_add(*twist, vec3_cross(mid, p));
    real along = 0.5 * vec3_dot(p, e->arm);
    *slope = mat3_add(*slope, mat3_sub(mat3_diagonal((vec3){along, along, along}), mat3_outer(vec3_scale(0.5, e->arm), p)));
}

/* What of the front the body alone knows. */
static inline __attribute__((always_inline)) void fill_rows(real *f, vec3 *turn, const Levers *v, const mat3 *inverse, vec3 loose, int rows)
{
    for (int i = 0; i < rows; i++)
        turn[i] = mat3_mul_vec(*inverse, v->mid[i]);
    for (int i = 0; i < rows; i++, f += rows + 1) {
        for (int k = 0; k < rows; k++)
            f[k] = vec3_dot(v->end[i], turn[k]);
        f[rows] = -vec3_dot(v->end[i], loose);
    }
}

static void fill_front(const Chain *c, const Link *l, const Levers *v, const mat3 *inverse)
{
    real *f = c->number + l->front, give = c->k * c->h / l->mass;
    int rows = l->rows;
    const End *ends = c->end + l->end;
    if (rows == 6)
        fill_rows(f, c->turn + l->turn, v, inverse, l->loose, 6);
    else
        fill_rows(f, c->turn + l->turn, v, inverse, l->loose, rows);
    for (int a = 0; a < l->ends; a++)
        for (int b = 0; b < l->ends; b++)
            for (int i = 0; i < TIE_ROWS; i++)
                f[(ends[a].at + i) * (rows + 1) + ends[b].at + i] += ends[a].side * ends[b].side * give;
    for (int i = 0; i < rows; i++)
        f[i * (rows + 2)] *= 1 + SHARE;
}

/* Errors of the joints this body is the last to see, and what the bodies that hang on it left. */
static void gather_front(const Chain *c, Link *l)
{
    real *f = c->number + l->front;
    int stride = l->rows + 1;
    for (int n = 0; n < l->ends; n++) {
        const End *e = &c->end[l->end + n];
        const Tie *t = &c->tie[e->tie];
        const real error[TIE_ROWS] = {t->error.x, t->error.y, t->error.z};
        for (int i = 0; i < TIE_ROWS && link_owns(l, n); i++)
            f[(e->at + i) * stride + l->rows] -= error[i];
        if (e->child < 0)
            continue;
        const Link *d = &c->link[e->child];
        int wide = d->rows + 1, from = d->rows - d->passed;
        const real *left = c->number + d->front + from * wide + from;
        for (int i = 0; i < d->passed; i++) {
            for (int k = 0; k < d->passed; k++)
                f[(e->at + i) * stride + e->at + k] += left[i * wide + k];
            f[(e->at + i) * stride + l->rows] += left[i * wide + d->passed];
        }
    }
}

/* Gauss elimination of the first `done` rows. False: a pivot vanished. */
static inline __attribute__((always_inline)) bool eliminate(real *f, int rows, int done)
{
    int stride = rows + 1;
    for (int k = 0; k < done; k++) {
        real *pivot = f + k * stride, inverse = 1 / pivot[k];
        if (!isfinite(inverse))
            return false;
        pivot[k] = inverse;
        for (int i = k + 1; i < rows; i++) {
            real *row = f + i * stride, share = row[k] * inverse;
            for (int n = k + 1; n <= rows; n++)
                row[n] -= share * pivot[n];
        }
    }
    return true;
}

static bool front(const Chain *c, Link *l)
{
    Levers v;
    mat3 back = mat3_transpose(l->r);
    vec3 g = vec3_scale(0.5, l->c), spin = mat3_mul_vec(l->inertia, l->w), twist = vec3_zero();
    mat3 slope = mat3_add(mat3_add(mat3_identity(), mat3_skew(g)), mat3_outer(g, g));
    slope = mat3_sub(mat3_scale(1 / (c->k * c->h), mat3_mul(l->inertia, slope)), mat3_skew(spin));
    for (int i = 0; i < l->ends; i++) {
        const End *e = &c->end[l->end + i];
        add_levers(&c->tie[e->tie], e, l, &back, &v, &twist, &slope);
    }
    mat3 inverse = mat3_inverse(slope);
    l->loose = mat3_mul_vec(inverse, vec3_sub(vec3_add(mat3_mul_vec(back, l->l0), twist), spin));
    fill_front(c, l, &v, &inverse);
    gather_front(c, l);
    real *f = c->number + l->front;
    return l->rows == 6 && l->passed == 3 ? eliminate(f, 6, 3) : eliminate(f, l->rows, l->rows - l->passed);
}

/* ---- the iteration ---- */

/* What the body's own rows change by, and with them its turn; the joint towards the root is known. Returns the turn, rad. */
static real substitute(const Chain *c, Link *l)
{
    real dp[LINK_ROWS];
    const real *f = c->number + l->front;
    const vec3 *turn = c->turn + l->turn;
    int own = l->rows - l->passed, stride = l->rows + 1;
    if (l->passed) {
        const Tie *t = &c->tie[c->end[l->end + l->ends - 1].tie];
        for (int i = 0; i < l->passed; i++)
            dp[own + i] = t->change[i];
    }
    for (int k = own - 1; k >= 0; k--) {
        real sum = f[k * stride + l->rows];
        for (int i = k + 1; i < l->rows; i++)
            sum -= f[k * stride + i] * dp[i];
        dp[k] = sum * f[k * stride + k];
    }
    vec3 by = l->loose;
    for (int i = 0; i < l->rows; i++)
        by = vec3_mad(by, dp[i], turn[i]);
    for (int n = 0; n < l->ends; n++) {
        const End *e = &c->end[l->end + n];
        Tie *t = &c->tie[e->tie];
        if (link_owns(l, n)) {
            memcpy(t->change, dp + e->at, sizeof t->change);
            t->p = vec3_add(t->p, (vec3){dp[e->at], dp[e->at + 1], dp[e->at + 2]});
        }
    }
    real length = vec3_length(by);
    if (length > TURN_AT_ONCE)
        by = vec3_scale(TURN_AT_ONCE / length, by);
    l->q = quat_unit(quat_mul(l->q, quat_exp(by)));
    move(c, l);
    return length;
}

/* Spin from the impulses at the end pose: no momentum is lost to what is left of the error. Each joint's impulses are added up,
 * and their torques at both ends. */
static void finish(const Chain *c, Link *l)
{
    vec3 spin = l->l0;
    for (const End *e = c->end + l->end; e < c->end + l->end + l->ends; e++) {
        Tie *t = &c->tie[e->tie];
        int b = e->side < 0;
        vec3 twist = vec3_cross(vec3_scale(0.5, vec3_add(e->r0, e->r)), point_impulse(t, e));
        spin = vec3_add(spin, twist);
        t->twist[b] = vec3_add(t->twist[b], twist);
        if (t->link[!b] < 0)
            t->twist[!b] = vec3_sub(t->twist[!b], vec3_cross(t->arm, point_impulse(t, e)));
        if (!b || t->link[0] < 0)
            t->impulse = vec3_add(t->impulse, t->p);
    }
    l->w = mat3_mul_vec(mat3_inverse(l->inertia), mat3_mul_vec(mat3_transpose(l->r), spin));
}

bool tree_step(Chain *c, const Linkage *t)
{
    int end = t->first + t->links;
    real turned = INFINITY;
    for (int n = t->first; n < end; n++)
        predict(c, &c->link[n]);
    for (int i = 0; i < ITERATIONS; i++) {
        c->error = place(c, t);
        if (!isfinite(c->error))
            return false;
        if (c->error < c->enough && turned < (c->k < 1 ? TURN_SMALL : TURN_TINY)) {
            for (int n = t->first; n < end; n++)
                finish(c, &c->link[n]);
            return true;
        }
        c->g->evaluations++;
        turned = 0;
        for (int n = end - 1; n >= t->first; n--)
            if (!front(c, &c->link[n]))
                return false;
        for (int n = t->first; n < end; n++)
            turned = real_max(turned, substitute(c, &c->link[n]));
    }
    return false;
}
