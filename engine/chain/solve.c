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
 *
 * A front is filled four bodies at a time, and so is all that a body does by itself; what goes along the tree takes one after the
 * other, and has only the sums and the elimination of a few rows to do.
 */
#include "chain/system.h"
#include "base/wide.h"

#define ITERATIONS 8
#define TURN_AT_ONCE 0.5        /* rad   of one iteration                                           */
#define TURN_SMALL 0.03         /* rad   an iteration that turned no body further is nearly exact   */
#define TURN_TINY 0.003         /* rad   the same after a blow, when the guess is far off           */
#define CAYLEY_MOST 2.0         /* of the Cayley vector: 90 degrees                                 */
#define SHARE 1e-8              /* of a row's own diagonal, that keeps redundant joints solvable    */

/* ---- the pose ---- */

/* By all impulses of the joints on the body. Positions follow from them without error. */
INLINE void move(const Chain *c, Links *l)
{
    four3 p = l->p0;
    for (const Ends *e = c->ends + l->end; e < c->ends + l->end + l->ends; e++)
        p = four3_mad(p, e->side, e->p);
    l->v = four3_scale(1.0 / l->mass, p);
    four3 mean = four3_add(four3_scale(four_all(c->k), l->v), four3_scale(four_all(1 - c->k), l->v0));
    l->x = four3_mad(l->x0, four_all(c->h), mean);
}

/* The end of what was before is the start, and joints push as they did. */
INLINE void predict(const Chain *c, Links *l)
{
    const four h = four_all(c->h), k = four_all(c->k), rest = four_all(1 - c->k);
    l->x0 = l->x;
    l->q0 = l->q;
    l->r0 = l->r;
    l->v0 = l->v;
    l->w0 = l->w;
    l->p0 = four3_mad(four3_scale(l->mass, l->v0), h, l->force);
    l->l0 = four3_mad(four33_mul3(&l->r0, four33_mul3(&l->inertia, l->w0)), h, l->torque);
    four3 spin = l->l0;
    for (Ends *e = c->ends + l->end; e < c->ends + l->end + l->ends; e++) {
        e->r0 = four33_mul3(&l->r0, e->arm);
        spin = four3_add(spin, four3_cross(e->r0, four3_scale(e->side, e->p)));
    }
    four3 w = four33_mul3(&l->inverse, four33_back3(&l->r0, spin));
    four3 g = four3_scale(0.5 * h, four3_add(four3_scale(k, w), four3_scale(rest, l->w0)));
    l->q = four_quat_unit(four_quat_mul(l->q0, (four_quat){g.x, g.y, g.z, four_all(1)}));
    move(c, l);
}

/* ---- errors ---- */

/* c from the pose and the velocity that it implies, and where the ends are. Lanes that turned too far, or are no numbers, are 0 in `fine`. */
INLINE void imply(const Chain *c, Links *l, four_int *fine)
{
    four_quat d = four_quat_mul(four_quat_conjugate(l->q0), l->q);
    l->c = four3_scale(2.0 / d.w, (four3){d.x, d.y, d.z});
    l->w = four3_scale(four_all(1 / c->k), four3_mad(four3_scale(four_all(1 / c->h), l->c), four_all(c->k - 1), l->w0));
    l->r = four_quat_matrix(l->q);
    *fine &= four3_dot(l->c, l->c) < four_all(CAYLEY_MOST * CAYLEY_MOST);
    for (Ends *e = c->ends + l->end; e < c->ends + l->end + l->ends; e++) {
        e->r = four33_mul3(&l->r, e->arm);
        e->at = four3_scale(e->side, four3_add(l->x, e->r));
    }
}

/* By how much the joints are off that a link owns. */
static void part(const Chain *c, const Links *l, int lane)
{
    for (int i = l->own[lane]; i < l->count[lane]; i++) {
        Ends *e = &c->ends[l->end + i];
        int child = e->child[lane];
        vec3 other = child < 0 ? vec3_scale(-e->side[lane], c->tie[e->tie[lane]].fixed)
                               : four3_get(&ends_of(c, first_end(c, child))->at, lane_of(child));
        four3_put(&e->error, lane, vec3_add(four3_get(&e->at, lane), other));
    }
}

/* Arms, and by how much each joint is off; the largest error. INFINITY: a body turned too far. */
INLINE real place(const Chain *c, const Linkage *t)
{
    four_int fine = four_all(0) == four_all(0);
    four worst = four_all(0);
    for (int n = t->first; n < t->last; n++)
        imply(c, &c->links[n], &fine);
    for (int n = t->first; n < t->last; n++) {
        const Links *l = &c->links[n];
        for (int lane = 0; lane < LANES; lane++)
            part(c, l, lane);
        for (const Ends *e = c->ends + l->end; e < c->ends + l->end + l->ends; e++) {
            four off = four_most(four_abs(e->error.x), four_most(four_abs(e->error.y), four_abs(e->error.z)));
            fine &= off < four_all(INFINITY);
            worst = four_most(worst, off);
        }
    }
    real most = 0;
    for (int i = 0; i < LANES; i++)
        most = fine[i] ? real_max(most, worst[i]) : INFINITY;
    return most;
}

/* ---- the fronts of four bodies ---- */

/* Levers of the rows of one end, with their impulses' torque and how that changes with the turn. */
INLINE void add_levers(const Links *l, const Ends *e, four3 *end, four3 *mid, four3 *twist, four33 *slope)
{
    const four3 axis[3] = {four3_scale(e->side, l->r.r0), four3_scale(e->side, l->r.r1), four3_scale(e->side, l->r.r2)};
    const four half = four_all(0.5);
    four3 lever = four3_scale(half, four3_add(e->arm, four33_back3(&l->r, e->r0)));
    four3 p = four3_mad(four3_mad(four3_scale(e->p.x, axis[0]), e->p.y, axis[1]), e->p.z, axis[2]);
    UNROLL
    for (int i = 0; i < 3; i++) {
        end[i] = four3_cross(e->arm, axis[i]);
        mid[i] = four3_cross(lever, axis[i]);
    }
    *twist = four3_add(*twist, four3_cross(lever, p));
    four along = half * four3_dot(p, e->arm);
    four3 arm = four3_scale(half, e->arm);
    slope->r0 = four3_sub(slope->r0, (four3){arm.x * p.x - along, arm.x * p.y, arm.x * p.z});
    slope->r1 = four3_sub(slope->r1, (four3){arm.y * p.x, arm.y * p.y - along, arm.y * p.z});
    slope->r2 = four3_sub(slope->r2, (four3){arm.z * p.x, arm.z * p.y, arm.z * p.z - along});
}

/* A without its joints. */
INLINE four33 free_slope(const Chain *c, const Links *l, four3 spin)
{
    const four one = four_all(1);
    four3 g = four3_scale(four_all(0.5), l->c);
    four33 by = {{one + g.x * g.x, g.x * g.y - g.z, g.x * g.z + g.y},
                 {g.y * g.x + g.z, one + g.y * g.y, g.y * g.z - g.x},
                 {g.z * g.x - g.y, g.z * g.y + g.x, one + g.z * g.z}};
    four33 turn = four33_scale(four_all(1 / (c->k * c->h)), four33_mul(&l->inertia, &by));
    return (four33){{turn.r0.x, turn.r0.y + spin.z, turn.r0.z - spin.y},
                    {turn.r1.x - spin.z, turn.r1.y, turn.r1.z + spin.x},
                    {turn.r2.x + spin.y, turn.r2.y - spin.x, turn.r2.z}};
}

/* What of the fronts the bodies alone know: the rows, and the errors of the joints that they own. */
INLINE void fill(const Chain *c, Links *l, int ends)
{
    four3 end[LINK_ROWS], mid[LINK_ROWS];       /* levers of the rows, body axes */
    const int rows = ends * TIE_ROWS, stride = rows + 1;
    const Ends *e = c->ends + l->end;
    four *f = c->number + l->front, give = c->k * c->h / l->mass;
    four3 *turn = c->turn + l->turn, spin = four33_mul3(&l->inertia, l->w), twist = four3_zero();
    four33 slope = free_slope(c, l, spin);
    for (int i = 0; i < ends; i++)
        add_levers(l, &e[i], end + i * TIE_ROWS, mid + i * TIE_ROWS, &twist, &slope);
    four33 inverse = four33_inverse(&slope);
    l->loose = four33_mul3(&inverse, four3_sub(four3_add(four33_back3(&l->r, l->l0), twist), spin));
    for (int i = 0; i < rows; i++)
        turn[i] = four33_mul3(&inverse, mid[i]);
    for (int i = 0; i < rows; i++)
        for (int k = 0; k < rows; k++)
            f[i * stride + k] = four3_dot(end[i], turn[k]);
    for (int a = 0; a < ends; a++)
        for (int b = 0; b < ends; b++)
            for (int i = 0; i < TIE_ROWS; i++)
                f[(a * TIE_ROWS + i) * stride + b * TIE_ROWS + i] += e[a].side * e[b].side * give;
    for (int i = 0; i < rows; i++)
        f[i * (stride + 1)] *= four_all(1 + SHARE);
    for (int a = 0; a < ends; a++) {
        const four error[TIE_ROWS] = {e[a].error.x, e[a].error.y, e[a].error.z};
        for (int i = 0; i < TIE_ROWS; i++)
            f[(a * TIE_ROWS + i) * stride + rows] = -four3_dot(end[a * TIE_ROWS + i], l->loose) - error[i];
    }
}

/* ---- along the tree ---- */

/* One lane of the front of four bodies, in blocks of the rows of one joint each. */
typedef struct Front { four *f; int stride, lane; } Front;

INLINE Front front_of(const Chain *c, int link)
{
    const Links *l = links_of(c, link);
    return (Front){c->number + l->front, l->ends * TIE_ROWS + 1, lane_of(link)};
}
INLINE four *block_at(const Front *t, int row, int column) { return t->f + row * TIE_ROWS * t->stride + column * TIE_ROWS; }
INLINE vec3 get3(const four *f, int lane) { return (vec3){f[0][lane], f[1][lane], f[2][lane]}; }
INLINE void put3(four *f, int lane, vec3 v)
{
    f[0][lane] = v.x;
    f[1][lane] = v.y;
    f[2][lane] = v.z;
}
INLINE mat3 get_block(const Front *t, int row, int column)
{
    const four *f = block_at(t, row, column);
    return (mat3){get3(f, t->lane), get3(f + t->stride, t->lane), get3(f + 2 * t->stride, t->lane)};
}
INLINE void put_block(const Front *t, int row, int column, const mat3 *m)
{
    four *f = block_at(t, row, column);
    put3(f, t->lane, m->r0);
    put3(f + t->stride, t->lane, m->r1);
    put3(f + 2 * t->stride, t->lane, m->r2);
}
INLINE vec3 get_side(const Front *t, int row)
{
    const four *f = block_at(t, row, 0) + t->stride - 1;
    return (vec3){f[0][t->lane], f[t->stride][t->lane], f[2 * t->stride][t->lane]};
}
INLINE void put_side(const Front *t, int row, vec3 v)
{
    four *f = block_at(t, row, 0) + t->stride - 1;
    f[0][t->lane] = v.x;
    f[t->stride][t->lane] = v.y;
    f[2 * t->stride][t->lane] = v.z;
}

/* What the bodies that hang on this one left. */
INLINE void take_remains(const Chain *c, const Links *l, const Front *t)
{
    for (int n = l->own[t->lane]; n < l->count[t->lane]; n++) {
        int child = c->ends[l->end + n].child[t->lane];
        if (child < 0)
            continue;
        const Front left = front_of(c, child);
        mat3 sum = mat3_add(get_block(t, n, n), get_block(&left, 0, 0));
        put_block(t, n, n, &sum);
        put_side(t, n, vec3_add(get_side(t, n), get_side(&left, 0)));
    }
}

/* Gauss elimination of the joints that the link owns. False: a pivot vanished. */
INLINE bool eliminate(const Front *t, int count, int own)
{
    for (int k = count - 1; k >= own; k--) {
        mat3 inverse = mat3_inverse(get_block(t, k, k));
        vec3 side = get_side(t, k);
        if (!isfinite(inverse.r0.x))
            return false;
        put_block(t, k, k, &inverse);
        for (int i = 0; i < k; i++) {
            mat3 share = mat3_mul(get_block(t, i, k), inverse);
            for (int n = 0; n < k; n++) {
                mat3 left = mat3_sub(get_block(t, i, n), mat3_mul(share, get_block(t, k, n)));
                put_block(t, i, n, &left);
            }
            put_side(t, i, vec3_sub(get_side(t, i), mat3_mul_vec(share, side)));
        }
    }
    return true;
}

static bool front(const Chain *c, int link)
{
    const Links *l = links_of(c, link);
    const Front t = front_of(c, link);
    const int count = l->count[t.lane], own = l->own[t.lane];
    take_remains(c, l, &t);
    return count == 2 && own == 1 ? eliminate(&t, 2, 1) : eliminate(&t, count, own);
}

/* What the body's own rows change by; the joint towards the root is known. */
static void substitute(const Chain *c, int link)
{
    vec3 dp[LINK_ENDS];
    const Links *l = links_of(c, link);
    const Front t = front_of(c, link);
    const int own = l->own[t.lane], count = l->count[t.lane];
    Ends *e = c->ends + l->end;
    if (own > 0)
        dp[0] = four3_get(&e->change, t.lane);
    for (int k = own; k < count; k++) {
        vec3 sum = get_side(&t, k);
        for (int i = 0; i < k; i++)
            sum = vec3_sub(sum, mat3_mul_vec(get_block(&t, k, i), dp[i]));
        dp[k] = mat3_mul_vec(get_block(&t, k, k), sum);
        four3_put(&e[k].change, t.lane, dp[k]);
        int child = e[k].child[t.lane];
        if (child >= 0)
            four3_put(&ends_of(c, first_end(c, child))->change, lane_of(child), dp[k]);
    }
}

/* ---- the iteration ---- */

/* A rotation by the vector, in a few terms of its series: an iteration need not be exact. */
INLINE four_quat turn_by(four3 by)
{
    four h2 = 0.25 * four3_dot(by, by);
    four s = 0.5 - h2 * (1.0 / 12 - h2 / 240.0);
    return (four_quat){s * by.x, s * by.y, s * by.z, 1.0 - h2 * (0.5 - h2 / 24.0)};
}

/* The turns that follow from what the rows change by. Adds to the most that a body turned, rad squared. */
INLINE void improve(const Chain *c, Links *l, four *most)
{
    const four3 *turn = c->turn + l->turn;
    four3 by = l->loose;
    for (int n = 0; n < l->ends; n++) {
        Ends *e = &c->ends[l->end + n];
        by = four3_mad(by, e->change.x, turn[n * TIE_ROWS]);
        by = four3_mad(by, e->change.y, turn[n * TIE_ROWS + 1]);
        by = four3_mad(by, e->change.z, turn[n * TIE_ROWS + 2]);
        e->p = four3_add(e->p, e->change);
    }
    const four once = four_all(TURN_AT_ONCE);
    four length2 = four3_dot(by, by);
    *most = four_most(*most, length2);
    by = four3_scale(four_pick(length2 > once * once, once / four_root(length2), four_all(1)), by);
    l->q = four_quat_unit(four_quat_mul(l->q, turn_by(by)));
    move(c, l);
}

/* Spin from the impulses at the end pose: no momentum is lost to what is left of the error. Each joint's impulses and their
 * torques are added up at both ends. */
INLINE void finish(const Chain *c, Links *l)
{
    four3 spin = l->l0;
    for (Ends *e = c->ends + l->end; e < c->ends + l->end + l->ends; e++) {
        four3 p = four3_scale(e->side, e->p);
        four3 twist = four3_cross(four3_scale(four_all(0.5), four3_add(e->r0, e->r)), p);
        spin = four3_add(spin, twist);
        e->twist = four3_add(e->twist, twist);
        e->impulse = four3_add(e->impulse, p);
    }
    l->w = four33_mul3(&l->inverse, four33_back3(&l->r, spin));
}

/* One iteration. Returns the most that a body turned, rad; < 0: no solution. */
INLINE real iterate(const Chain *c, const Linkage *t)
{
    four most = four_all(0);
    for (int n = t->first; n < t->last; n++) {
        Links *l = &c->links[n];
        if (l->ends == 2)
            fill(c, l, 2);
        else
            fill(c, l, l->ends);
    }
    for (int n = t->last * LANES - 1; n >= t->first * LANES; n--)
        if (!front(c, n))
            return -1;
    for (int n = t->first * LANES; n < t->last * LANES; n++)
        substitute(c, n);
    for (int n = t->first; n < t->last; n++)
        improve(c, &c->links[n], &most);
    return sqrt(real_max(real_max(most[0], most[1]), real_max(most[2], most[3])));
}

INLINE bool solve(Chain *c, const Linkage *t)
{
    real turned = INFINITY;
    for (int n = t->first; n < t->last; n++)
        predict(c, &c->links[n]);
    for (int i = 0; i < ITERATIONS && turned >= 0; i++) {
        c->error = place(c, t);
        if (!isfinite(c->error))
            return false;
        if (c->error < c->enough && turned < (c->k < 1 ? TURN_SMALL : TURN_TINY)) {
            for (int n = t->first; n < t->last; n++)
                finish(c, &c->links[n]);
            return true;
        }
        c->g->evaluations++;
        turned = iterate(c, t);
    }
    return false;
}

static bool solve_plain(Chain *c, const Linkage *t) { return solve(c, t); }
WIDE static bool solve_wide(Chain *c, const Linkage *t) { return solve(c, t); }

bool tree_step(Chain *c, const Linkage *t) { return (has_wide() ? solve_wide : solve_plain)(c, t); }
