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
#include "math/reg3.h"

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
    if (l->ends > 0)
        four3_apart(c->ends[l->end].at, four_all(0), l->hung);
}

/* By how much the joints of an end are off, where the links own them. */
INLINE four3 miss(const Ends *e)
{
    four rest, other[LANES] = {*e->other[0], *e->other[1], *e->other[2], *e->other[3]};
    four3 off = four3_add(e->at, four3_together(other, &rest));
    return (four3){four_where(e->owned, off.x), four_where(e->owned, off.y), four_where(e->owned, off.z)};
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
        for (Ends *e = c->ends + l->end + l->first; e < c->ends + l->end + l->ends; e++) {
            e->error = miss(e);
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

/* The front of one body: three rows for each of its joints, in blocks of three columns for each. A row of a block lies in one register, with
 * a fourth number: in the first block the right-hand side of the row, in others nothing. Rows are then added, and multiplied into each
 * other, right-hand sides along with them. */
typedef struct Front { four *f; int ends; } Front;

INLINE Front front_of(const Chain *c, const Links *l, int lane) { return (Front){front_at(c, l, lane), l->ends}; }
INLINE four *block_at(const Front *t, int row, int column) { return t->f + (row * t->ends + column) * TIE_ROWS; }

/* The fourth number of `fourth`, the others of `three`. */
INLINE four with_fourth(four three, four fourth) { return SHUFFLE(three, fourth, 0, 1, 2, 7); }

/* What of the fronts the bodies alone know: the rows, and the errors of the joints that they own. */
INLINE void fill(const Chain *c, Links *l, int ends)
{
    four3 end[LINK_ROWS], mid[LINK_ROWS];       /* levers of the rows, body axes */
    const int rows = ends * TIE_ROWS;
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
    for (int a = 0; a < ends; a++) {
        const four error[TIE_ROWS] = {e[a].error.x, e[a].error.y, e[a].error.z};
        for (int b = 0; b < ends; b++) {
            const four both = e[a].side * e[b].side * give;
            UNROLL
            for (int i = 0; i < TIE_ROWS; i++) {
                const int row = a * TIE_ROWS + i;
                four n[LANES];
                UNROLL
                for (int k = 0; k < TIE_ROWS; k++)
                    n[k] = four3_dot(end[row], turn[b * TIE_ROWS + k]);
                n[i] += both;
                if (a == b)
                    n[i] *= four_all(1 + SHARE);
                n[TIE_ROWS] = b > 0 ? four_all(0) : -four3_dot(end[row], l->loose) - error[i];
                four_transpose(n);
                UNROLL
                for (int k = 0; k < LANES; k++)
                    f[((k * ends + a) * ends + b) * TIE_ROWS + i] = n[k];
            }
        }
    }
}

/* ---- along the tree ---- */

/* What the bodies that hang on this one left. */
INLINE void take_remains(const Ends *e, int lane, int count, int own, const Front *t)
{
    for (int n = own; n < count; n++) {
        const four *left = e[n].below[lane];
        four *sum = block_at(t, n, n), *side = block_at(t, n, 0);
        UNROLL
        for (int i = 0; i < TIE_ROWS && left; i++) {
            four both = side[i] + left[i];
            sum[i] += left[i];
            if (n > 0)
                side[i] = with_fourth(side[i], both);
        }
    }
}

/* A block becomes its inverse by columns, but for the fourth numbers; `rows` is the same by rows. False: it has none. */
INLINE bool invert(four *block, four rows[LANES])
{
    const four r0 = block[0], r1 = block[1], r2 = block[2];
    rows[0] = reg3_cross(r1, r2);
    rows[1] = reg3_cross(r2, r0);
    rows[2] = reg3_cross(r0, r1);
    rows[3] = four_all(0);
    const four d = four_all(1 / reg3_dot(r0, rows[0]));
    UNROLL
    for (int i = 0; i < TIE_ROWS; i++) {
        rows[i] *= d;
        block[i] = with_fourth(rows[i], block[i]);
    }
    bool fine = isfinite(rows[0][0]);
    four_transpose(rows);
    return fine;
}

/* Sum of three vectors, each times one of the first three numbers of m. */
INLINE four times(four m, const four v[TIE_ROWS]) { return four_all(m[0]) * v[0] + four_all(m[1]) * v[1] + four_all(m[2]) * v[2]; }

/* Gauss elimination of the joints that the link owns. False: a pivot vanished. */
INLINE bool eliminate(const Front *t, int count, int own)
{
    for (int k = count - 1; k >= own; k--) {
        four inverse[LANES], share[TIE_ROWS];
        if (!invert(block_at(t, k, k), inverse))
            return false;
        for (int i = 0; i < k; i++) {
            UNROLL
            for (int r = 0; r < TIE_ROWS; r++)
                share[r] = times(block_at(t, i, k)[r], inverse);
            for (int n = 0; n < k; n++)
                UNROLL
                for (int r = 0; r < TIE_ROWS; r++)
                    block_at(t, i, n)[r] -= times(share[r], block_at(t, k, n));
        }
    }
    return true;
}

INLINE bool front_rows(const Ends *e, int lane, int count, int own, const Front *t)
{
    take_remains(e, lane, count, own, t);
    return eliminate(t, count, own);
}

/* Most links have two joints, one towards the root: for these the compiler has no loops left. */
INLINE bool front(const Chain *c, const Links *l, int lane)
{
    const Ends *e = c->ends + l->end;
    const Front t = front_of(c, l, lane), two = {t.f, 2};
    const int count = l->count[lane], own = l->own[lane];
    return l->ends == 2 && count == 2 && own == 1 ? front_rows(e, lane, 2, 1, &two) : front_rows(e, lane, count, own, &t);
}

/* By how much a joint's impulse changes is written over the first row of its end's first block, which nobody asks for afterwards. */
INLINE four *change_of(const Front *t, int end) { return block_at(t, end, 0); }

/* What the body's own rows change by; the joint towards the root is known. */
INLINE void substitute_rows(const Ends *e, int lane, int count, int own, const Front *t)
{
    four dp[LINK_ENDS];
    if (own > 0)
        dp[0] = *change_of(t, 0);
    for (int k = own; k < count; k++) {
        const four *side = block_at(t, k, 0);
        four sum = {side[0][TIE_ROWS], side[1][TIE_ROWS], side[2][TIE_ROWS]};
        for (int i = 0; i < k; i++) {
            const four *row = block_at(t, k, i);
            four by[LANES] = {dp[i] * row[0], dp[i] * row[1], dp[i] * row[2], four_all(0)};
            four_transpose(by);
            sum -= by[0] + by[1] + by[2];
        }
        dp[k] = *change_of(t, k) = times(sum, block_at(t, k, k));
        four *below = e[k].below[lane];
        if (below)
            *below = dp[k];
    }
    for (int k = count; k < t->ends; k++)
        *change_of(t, k) = four_all(0);
}

INLINE void substitute(const Chain *c, const Links *l, int lane)
{
    const Ends *e = c->ends + l->end;
    const Front t = front_of(c, l, lane), two = {t.f, 2};
    const int count = l->count[lane], own = l->own[lane];
    if (l->ends == 2 && count == 2 && own == 1)
        substitute_rows(e, lane, 2, 1, &two);
    else
        substitute_rows(e, lane, count, own, &t);
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
    const Front t[LANES] = {front_of(c, l, 0), front_of(c, l, 1), front_of(c, l, 2), front_of(c, l, 3)};
    four3 by = l->loose;
    for (int n = 0; n < l->ends; n++) {
        Ends *e = &c->ends[l->end + n];
        four rest, of[LANES] = {*change_of(&t[0], n), *change_of(&t[1], n), *change_of(&t[2], n), *change_of(&t[3], n)};
        four3 change = four3_together(of, &rest);
        by = four3_mad(by, change.x, turn[n * TIE_ROWS]);
        by = four3_mad(by, change.y, turn[n * TIE_ROWS + 1]);
        by = four3_mad(by, change.z, turn[n * TIE_ROWS + 2]);
        e->p = four3_add(e->p, change);
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
    for (int n = t->last - 1; n >= t->first; n--)
        for (int lane = LANES - 1; lane >= 0; lane--)
            if (!front(c, &c->links[n], lane))
                return -1;
    for (int n = t->first; n < t->last; n++)
        for (int lane = 0; lane < LANES; lane++)
            substitute(c, &c->links[n], lane);
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
            c->ended = motion_of(c, t);
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
