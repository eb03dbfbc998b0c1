/* solve/direct.c - all contacts of a group at once, with round friction cones and rolling resistance.
 *
 * Gauss-Seidel sweeps hand an impulse on by one body per sweep, so that towers, arches and heavy things on light ones take
 * hundreds of them, or never get there. Here the velocities v minimise
 *
 *     1/2 |v - v^|^2_M + sum over rows of 1/2 R |f|^2,   f = nearest point of the row's set to  p + (target - J v) / R
 *
 * with v^ the velocities without impulses, by Newton's method with an exact line search; then p <- f, which is an augmented
 * Lagrangian: its limit has R (f - p) = 0, hard rows, whatever R is (Rockafellar 1976; Hestenes 1969). A convex model of
 * friction lifts what slides; De Saxce & Feng 1998 take mu |slip| off the normal target, to be followed from round to round.
 * The matrix M + J^T D J is positive definite whatever the rows are: repeated ones do no harm, and nothing cycles. It has one
 * 6x6 block per body and link (solve/blocks.h).
 *
 * Joints that carry what is heavy take part with their geometric stiffness (solve/direct_joints.c): chains and bridges under
 * contact, cranes with a motor. There the rows start softer and harden from round to round, and slip is followed only as far as the rounds go.
 */
#include "base/bracket.h"
#include "solve/direct.h"

/* Counts that bound the work, without and with something heavy */
static const int most_points[2] = {1000, 4000}, most_failures[2] = {1, 4};      /* failures in a step, one after the other */
static const real most_work[2] = {1e6, 4e6};                                    /* multiplications of one factorisation */
#define MOST_BODIES   512
#define MOST_ROUNDS   20
#define MOST_STEPS    30        /*      of Newton's method in a round */
#define MOST_FACTORS  200       /*      in all rounds; where nothing is heavy also so many as points times factors allow, or few */
#define FACTOR_POINTS 4000
/* The same for many bodies that lie calm (crowd/calm.c): found once, their forces last. */
#define MANY_POINTS   6000
#define MANY_MATRIX   1.2e7     /*      multiplications of one factorisation, */
#define MANY_WORK     1.6e8     /*      and of all in a step (0.1 s), fewer where the last steps toiled. A pyramid of 210 boxes needs this, once */
#define MANY_FACTORS  500
#define FEW_FACTORS   12
/* The same for springs: a few sweeps leave forces that are not those of how they are stretched, which makes up energy without end. */
#define ELASTIC_BODIES 1200
#define ELASTIC_MATRIX 8e7
/* The second try of what slides at many points, from soft to hard: with rows hard at once Newton's method stops at their kinks. */
#define SOFT_POINTS   32000     /*      points times factors */
#define SOFT_FACTORS  150
#define SOFT_GOOD     1e-5      /* m/s  lifts within this are good enough */
/* Where the sweeps are stuck, too: from soft to hard, and what is much better than they are is taken */
#define RESCUE_SOFT   1e5       /*      times the compliance at first */
#define HARDEST       1e-3      /*      the same at last */
#define RESCUED       0.1       /*      of the error that the sweeps left */
#define MOST_RESCUES  2         /*      that failed in a step */
#define AIM           1e-9      /* m/s  wanted at least: what is left adds up to creep */
#define LOOSE         0.1       /*      a round is done to this part of what it is off */
#define AHEAD         0.1       /*      and of what the estimates were off in the last one: lifts that are still to change throw away what is finer */
#define LIFT_ALONE    1e-3      /*      of that: rows that are off by less hold, and only lifts change. Harder rows do not bring those nearer. */
#define LOST          1e-2      /* m/s  a round that ends this far from its minimum has failed, and with it the solve */
/* From the inside (direct_cone.c): where it ends, and its rows are refined from so soft */
#define INSIDE_GOOD   1e-3      /* m/s  good enough */
#define INSIDE_POOR   1e-2      /* m/s  and where there is nothing better */
#define INSIDE_AIM    1e-5      /* m/s  wanted */
#define INSIDE_SOFT   1e3       /*      times the compliance */
#define INSIDE_FACTORS 10       /*      of these rounds */
#define INSIDE_MOST   4000      /*      factorisations of a step, after which there are no more such solves */
/* With joints */
#define JOINT_SOFT    1e3       /*      times the compliance of a contact at first */
#define CROWD_SOFT    1e5       /*      the same where nothing is heavy, but much slides and turns */
#define JOINT_FACTORS 300
#define JOINT_STEPS   75
#define JOINT_ROUNDS  4         /*      so many, and on while rows are off by more than JOINT_POOR */
#define JOINT_SETTLED 0.1       /*      or estimates by more than this part of the rows' speeds, */
#define JOINT_MOST_ROUNDS 12    /*      up to this */
#define JOINT_AIM     1e-6      /* m/s */
#define JOINT_POOR    1e-3      /* m/s */
#define JOINT_FAILURES 4        /*      in a step, after which its rows are left to the sweeps */
#define MANY_JOINTS   6         /*      as many are solved together, with their contacts, */
#define GENTLE        1.0       /*      but springs that change speeds by less of what stretches them in a substep */
#define PROJECT_FACTORS 40      /*      of a projection; five are usual */
#define GOOD          1e-7      /* m/s  the rows hold within this: the solve has worked */

/* ---- storage ---- */

static void mark_late(const Direct *d, bool *late, int body)
{
    if (d->place[body] >= 0)
        late[d->place[body]] = true;
}

/* Who shares rows, and whose rows answer now so, now so. False: out of memory. */
static bool links(const Direct *d, BlockLinks *of)
{
    const Group *g = d->g;
    int most = g->point_count + g->row_count * ROW_BODIES * (ROW_BODIES - 1) / 2;
    int *link = arena_alloc(g->arena, 2 * (size_t)(most + 1) * sizeof *link);
    bool *late = arena_zero(g->arena, (size_t)of->n * sizeof *late);
    if (!link || !late)
        return false;
    for (int i = 0; i < g->point_count; i++) {
        const PointRow *p = &g->points[i];
        mark_late(d, late, p->a);
        mark_late(d, late, p->b);
        if (d->place[p->a] >= 0 && d->place[p->b] >= 0) {
            link[2 * of->links] = d->place[p->a];
            link[2 * of->links++ + 1] = d->place[p->b];
        }
    }
    for (int i = 0; i < g->roll_count; i++) {
        mark_late(d, late, g->rolls[i].a);
        mark_late(d, late, g->rolls[i].b);
    }
    singles_link(d, of, link, late);
    of->link = link;
    of->late = late;
    return true;
}

/* The inverse of what the sweeps use. 0 in what a planar world keeps still counts as 1: no row reaches there. */
bool direct_tensor(const Group *g, int body, mat3 *tensor)
{
    mat3 ii = g->mass[body].ii;
    if (g->planar) {
        ii.r0.x += ii.r0.x > 0 ? 0 : 1;
        ii.r1.y += ii.r1.y > 0 ? 0 : 1;
        ii.r2.z += ii.r2.z > 0 ? 0 : 1;
    }
    *tensor = mat3_inverse(ii);
    return mat3_det(ii) > 0;
}

/* Mass and tensor of inertia, and what taut joints add to it. */
static bool masses(Direct *d)
{
    const Group *g = d->g;
    for (int i = 0; i < d->blocks.n; i++) {
        const Mass *m = &g->mass[d->body[i]];
        mat3 k = d->stiff[d->body[i]], t;
        if (!(m->im > 0) || !direct_tensor(g, d->body[i], &t))
            return false;
        t = mat3_add(t, k);
        vec3 back = mat3_mul_vec(mat3_inverse(t), mat3_mul_vec(k, vec3_sub(g->vel[d->body[i]].w, d->round[d->body[i]])));
        real rest[3] = {-back.x, -back.y, -back.z};
        memcpy(d->v0 + 6 * i + 3, rest, sizeof rest);
        d->mass[10 * i] = 1 / m->im;
        memcpy(d->mass + 10 * i + 1, &t, sizeof t);
    }
    return true;
}

/* False: not for this group, or no memory (then g->status says so). */
static bool open_direct(Direct *d)
{
    Group *g = d->g;
    int n = 0;
    d->place = arena_alloc(g->arena, (size_t)(g->body_count + 1) * sizeof *d->place);
    d->narrow = arena_alloc(g->arena, (size_t)(2 * g->body_count + 1) * sizeof *d->narrow);
    if (!d->place || !d->narrow) {
        g->status = DIG_E_MEMORY;
        return false;
    }
    bool *narrow = d->narrow + g->body_count;       /* of the unknowns */
    for (int i = 0; i < g->body_count; i++) {
        bool moves = g->member[i].moves;
        d->narrow[i] = narrow[n] = moves && !body_turns(&g->world->bodies.data[g->member[i].slot]);
        d->place[i] = moves ? n++ : -1;
    }
    if (n == 0)
        return false;
    real most = g->calm ? MANY_MATRIX : g->joints_direct && group_elastic(g) ? ELASTIC_MATRIX : most_work[d->heavy];
    BlockLinks of = {.n = n, .narrow = narrow, .most = most};
    size_t size = (size_t)n;
    d->body = arena_alloc(g->arena, size * sizeof *d->body);
    d->mass = arena_alloc(g->arena, 10 * size * sizeof *d->mass);
    d->v = arena_zero(g->arena, 6 * size * sizeof *d->v);
    d->v0 = arena_zero(g->arena, 6 * size * sizeof *d->v0);
    d->dv = arena_alloc(g->arena, 6 * size * sizeof *d->dv);
    d->grad = arena_alloc(g->arena, 6 * size * sizeof *d->grad);
    if (!d->body || !d->mass || !d->v || !d->v0 || !d->dv || !d->grad || !links(d, &of) || !blocks_plan(&d->blocks, g->arena, &of)) {
        g->status = DIG_E_MEMORY;
        return false;
    }
    if (d->blocks.work > most)
        return false;
    for (int i = 0; i < g->body_count; i++)
        if (d->place[i] >= 0) {
            d->place[i] = d->blocks.place[d->place[i]];
            d->body[d->place[i]] = i;
        }
    if (!blocks_reserve(&d->blocks, g->arena) || !direct_rows(d) || !stiffness_open(d)) {
        g->status = DIG_E_MEMORY;
        return false;
    }
    return masses(d);
}

static Vel start_velocity(const Group *g, int body) { return g->member[body].moves ? g->start_vel[body] : g->vel[body]; }

real group_mass_ratio(const Group *g)
{
    real lightest = INFINITY, heaviest = 0;
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves) {
            lightest = real_min(lightest, g->member[i].mass);
            heaviest = real_max(heaviest, g->member[i].mass);
        }
    return heaviest > 0 ? heaviest / lightest : 1;
}

bool group_top_heavy(const Group *g) { return group_mass_ratio(g) > HEAVY; }

static bool calm(const Group *g)
{
    int fast = 0;
    for (int i = 0; i < g->point_count; i++) {
        const PointRow *r = &g->points[i];
        const GroupContact *c = &g->contacts[r->contact];
        Vel a = start_velocity(g, r->a), b = start_velocity(g, r->b);
        vec3 at = c->manifold.points[r->point].a;
        vec3 va = vec3_add(a.v, vec3_cross(a.w, vec3_sub(at, g->pos[r->a].x)));
        vec3 vb = vec3_add(b.v, vec3_cross(b.w, vec3_sub(at, g->pos[r->b].x)));
        fast += vec3_length2(vec3_sub(vb, va)) > CALM_SPEED * CALM_SPEED * g->pairs[c->pair].size * g->fall;
    }
    return fast <= CALM_FAST * g->point_count;
}

/* ---- Newton's method ---- */

real direct_unbalanced(const Direct *d)
{
    real worst = 0;
    for (int i = 0; i < d->blocks.n; i++) {
        const real *r = d->grad + 6 * i;
        const Mass *m = &d->g->mass[d->body[i]];
        real reach = d->g->member[d->body[i]].outer;
        vec3 w = mat3_mul_vec(m->ii, (vec3){r[3], r[4], r[5]});
        worst = real_max(worst, m->im * vec3_length((vec3){r[0], r[1], r[2]}));
        worst = real_max(worst, (isfinite(reach) ? reach : 1) * vec3_length(w));
    }
    return worst;
}

/* m/s, rad/s */
static real size_of_step(const Direct *d)
{
    real worst = 0;
    for (int k = 0; k < 6 * d->blocks.n; k++)
        worst = real_max(worst, fabs(d->dv[k]));
    return worst;
}

/* How far along dv the merit function falls: its slope is monotone, for the function is convex. */
static real search(Direct *d)
{
    direct_line(d);
    Bracket b = {0, 1, direct_slope(d, 0), direct_slope(d, 1), 0};
    real start = fabs(b.at_lo);
    if (!(b.at_hi > 0.3 * start) || !(b.at_lo < 0))
        return 1;
    for (int i = 0; i < 20; i++) {
        real x = (b.lo * b.at_hi - b.hi * b.at_lo) / (b.at_hi - b.at_lo), s = direct_slope(d, x);
        if (fabs(s) < 0.05 * start)
            return x;
        bracket_put(&b, x, s);
    }
    return b.lo > 0 ? b.lo : b.hi;
}

/* dv by the present forces. False: the matrix could not be factored. */
static bool newton(Direct *d, bool fresh)
{
    if (!d->kept) {
        d->factors++;
        d->kept = direct_assemble(d, fresh) && blocks_factor(&d->blocks, false);
    }
    for (int k = 0; k < 6 * d->blocks.n; k++)
        d->dv[k] = -d->grad[k];
    if (d->kept)
        blocks_solve(&d->blocks, d->dv);
    return d->kept;
}

/* Where the new estimate would lead, were every row to answer as at the end of the last round. Without it a change of the lift
 * throws all contacts open, and hinges across their dry friction, and they come back one by one: 16 steps in a round of
 * figures that land (B22), where 7 are enough, and up to 75. */
static bool carry_on(Direct *d)
{
    direct_gradient(d);
    if (!newton(d, false))
        return false;
    direct_changes(d);
    direct_move(d, 1);
    return true;
}

/* One round. False: the matrix could not be factored. */
static bool minimise(Direct *d, real enough)
{
    real best = INFINITY;
    int worse = 0;
    int most = d->g->joints_direct ? JOINT_STEPS : MOST_STEPS;
    for (int i = 0; i < most && d->factors < d->most_factors; i++) {
        direct_forces(d);
        direct_gradient(d);
        real now = direct_unbalanced(d);
        d->unbalanced = now;
        if (now <= real_max(enough, LOOSE * direct_off(d)) || (worse > 2 && best < GOOD))
            return true;
        worse = now < 0.5 * best ? 0 : worse + 1;
        best = real_min(best, now);
        if (!newton(d, true))
            return false;
        direct_changes(d);
        direct_move(d, search(d));
        if (d->g->joints_direct && size_of_step(d) <= real_max(enough, LOOSE * direct_off(d)))
            break;
    }
    direct_forces(d);
    direct_gradient(d);
    d->unbalanced = direct_unbalanced(d);
    return true;
}

/* ---- */

/* The impulses change the velocities, so that momentum is kept whatever the solve has reached; not so with joints, where
 * impulses that the solve has not got to the last digit would throw what is light. */
static void write_back(Direct *d)
{
    Group *g = d->g;
    bool push = !g->joints_direct;
    for (int i = 0; i < d->triple_count; i++) {
        const Triple *t = &d->triples[i];
        real p[3];
        for (int k = 0; k < 3; k++)
            p[k] = t->prox[k] - t->start[k];
        if (t->set == SET_BALL) {
            RollRow *r = &g->rolls[t->index];
            vec3 by = {p[0], p[1], p[2]};
            r->j = vec3_add(r->j, by);
            if (!push)
                continue;
            g->vel[r->a].w = vec3_sub(g->vel[r->a].w, mat3_mul_vec(g->mass[r->a].ii, by));
            g->vel[r->b].w = vec3_add(g->vel[r->b].w, mat3_mul_vec(g->mass[r->b].ii, by));
            continue;
        }
        PointRow *r = &g->points[t->index];
        r->jn = t->prox[0];
        r->jt[0] = t->prox[1];
        r->jt[1] = t->prox[2];
        if (!push)
            continue;
        dir_apply(g, &r->n, r->a, r->b, p[0]);
        dir_apply(g, &r->t[0], r->a, r->b, p[1]);
        dir_apply(g, &r->t[1], r->a, r->b, p[2]);
    }
    if (!push)
        singles_write(d);
}

/* The velocities before the substep are near those after it, whatever the impulses so far are worth. */
static void start_from(Direct *d)
{
    const Group *g = d->g;
    if (d->projects)
        return;
    for (int i = 0; i < d->blocks.n; i++) {
        const Vel *now = &g->vel[d->body[i]], *before = &g->start_vel[d->body[i]];
        vec3 change[2] = {vec3_sub(before->v, now->v), vec3_sub(before->w, now->w)};
        memcpy(d->dv + 6 * i, change, sizeof change);
    }
    direct_changes(d);
    direct_move(d, 1);
}

/* Does a joint push only as springs do that hardly change the speeds of their ends in a substep? Sweeps agree on those at once. */
static bool is_gentle(Group *g, int joint)
{
    Row rows[JOINT_SLOTS];
    RowList list = {rows, 0, JOINT_SLOTS};
    real memory[JOINT_MEMORY], h = g->world->def.step / g->plan->substeps;
    group_joint_view(g, joint);
    JointView v = g->joints[joint].view;
    memcpy(memory, g->joints[joint].memory, sizeof memory);
    v.memory = memory;
    v.type->rows(&v, &list);
    for (int i = 0; i < list.count; i++) {
        real mobility = 0;
        for (int k = 0; k < rows[i].count; k++)
            mobility += group_row_mobility(g, &rows[i], k);
        if (rows[i].kind != ROW_SOFT || !(h * mobility * (h * rows[i].stiffness + rows[i].damping) < GENTLE))
            return false;
    }
    return true;
}

/* Of what bends one will do: a stump of a plank that breaks, swept, has forces in its joints that are not those of how they are bent. */
static bool holds_many(Group *g)
{
    int count = 0, many = group_elastic(g) ? 1 : MANY_JOINTS;
    for (int i = 0; i < g->joint_count && count < many; i++)
        count += !is_gentle(g, i);
    return count >= many;
}

bool group_elastic(const Group *g)
{
    for (int i = 0; i < g->joint_count; i++)
        if (g->joints[i].view.type->elastic)
            return true;
    return false;
}

bool group_bears_load(const Group *g) { return g->conserve_failed || group_top_heavy(g) || group_elastic(g); }

bool direct_joints(Group *g)
{
    if (g->joint_count == 0)
        return false;
    return g->conserve_failed || group_top_heavy(g) || (g->contact_count > 0 && (holds_many(g) || springs_swing(g)));
}

real direct_wanted(const Group *g)
{
    bool heavy = group_top_heavy(g);
    int most = g->joints_direct && group_elastic(g) ? ELASTIC_BODIES : MOST_BODIES;
    if (g->joints_direct)
        return g->point_count > most_points[heavy] || g->moving_count > most || g->direct_failures >= JOINT_FAILURES
                   ? 0 : g->plan->residual;
    if (g->row_count > 0 || g->point_count == 0 || g->point_count > (g->calm ? MANY_POINTS : most_points[heavy]) || g->moving_count > MOST_BODIES)
        return 0;
    if (toil_pauses(g) || g->direct_failures >= most_failures[heavy] || !(heavy || calm(g)))
        return 0;
    return heavy ? real_min(g->plan->residual, AIM) : g->plan->residual;
}

/* What overflowed is no solution, and comparisons do not see it. */
static bool finite(const Direct *d)
{
    real sum = d->error + d->unbalanced;
    for (int k = 0; k < 6 * d->blocks.n; k++)
        sum += fabs(d->v[k]);
    for (int i = 0; i < d->triple_count; i++)
        for (int k = 0; k < 3; k++)
            sum += fabs(d->triples[i].prox[k]);
    for (int i = 0; i < d->single_count; i++)
        sum += fabs(d->singles[i].prox) + fabs(d->singles[i].force);
    return isfinite(sum);
}

/* m/s, rad/s  What the rows begin with and aim at. */
static real speed_of_rows(const Direct *d)
{
    real speed = 0;
    for (int i = 0; i < d->triple_count; i++)
        for (int k = 0; k < 3; k++)
            speed = real_max(speed, real_max(fabs(d->triples[i].rate[k]), fabs(d->triples[i].target[k])));
    for (int i = 0; i < d->single_count; i++)
        speed = real_max(speed, real_max(fabs(d->singles[i].rate), fabs(d->singles[i].target)));
    return speed;
}

/* Rounds until the rows hold. Where a round takes off less than nine tenths, the next has harder rows. */
static bool solve(Direct *d, real residual)
{
    real speed = 0, off = INFINITY;
    for (int i = 0; i < d->triple_count; i++)
        speed = real_max(speed, real_max(fabs(d->triples[i].rate[0]), fabs(d->triples[i].target[0])));
    real enough = real_max(0.1 * residual, 1e-14 * speed);
    bool carries = !d->inside;
    if (!d->inside) {
        start_from(d);
        direct_begin(d);
    }
    d->error = INFINITY;
    for (int stalled = 0; d->rounds < MOST_ROUNDS && d->error > residual && d->factors < d->most_factors; d->rounds++) {
        real before = d->error, off_before = off;
        real near = isfinite(before) ? real_max(enough, AHEAD * before) : enough;
        if ((carries && !carry_on(d)) || !minimise(d, near))
            return false;
        off = direct_off(d);
        if (d->unbalanced > real_max(LOST, real_max(near, LOOSE * off)))
            return false;
        carries = true;
        bool soft = d->hardened > 1 || off > 0.1 * off_before, holds = off < real_max(0.1 * residual, LIFT_ALONE * before);
        d->error = direct_round(d, soft && !holds);
        stalled = d->error > 0.5 * before ? stalled + 1 : 0;
        d->swings = stalled >= 2;
        if (stalled >= 2 && d->error < GOOD)
            break;
    }
    return finite(d) && real_max(d->error, d->unbalanced) < real_max(d->accept, 1e-9 * speed);
}

/* m/s  How much faster than Coulomb's law has it contacts part, whose lift is less than their slip asks for; by no more than their impulses do. */
static real missing_lift(const Direct *d)
{
    real worst = 0;
    for (int i = 0; i < d->triple_count; i++) {
        const Triple *t = &d->triples[i];
        real missing = t->set == SET_CONE ? t->mu * hypot(t->rate[1], t->rate[2]) - t->lift : 0;
        worst = real_max(worst, real_min(missing, t->prox[0] * direct_mobility(d, t)));
    }
    return worst;
}

/* Once more without lifts, and what overlaps need not part: between two walls nothing can. */
static real inside_convex(Direct *d)
{
    for (int k = 0; k < 6 * d->blocks.n; k++)
        d->dv[k] = -d->v[k];
    direct_changes(d);
    direct_move(d, 1);
    for (int i = 0; i < d->triple_count; i++) {
        Triple *t = &d->triples[i];
        t->lift = 0;
        t->target[0] = real_min(t->target[0], 0);
    }
    for (int i = 0; i < d->single_count; i++)
        d->singles[i].prox = d->singles[i].soft ? 0 : d->singles[i].start;      /* what was found had no bound where there is no solution */
    return direct_inside(d, true);
}

static void keep_found(const Direct *d, real (*found)[3])
{
    for (int i = 0; i < d->triple_count; i++)
        memcpy(found[i], d->triples[i].prox, sizeof found[i]);
}

static bool take_found(Direct *d, real (*found)[3], real off, real most)
{
    for (int i = 0; i < d->triple_count; i++)
        memcpy(d->triples[i].prox, found[i], sizeof found[i]);
    d->error = d->unbalanced = off;
    return finite(d) && off < most;
}

/* From the inside; of lifts that do not come to rest and none at all what is less wrong. It is refined by rounds, and taken as it was where these make it
 * worse. What is wrong about it is the residual. */
static bool solve_inside(Direct *d, real residual)
{
    real (*found)[3] = arena_alloc(d->g->arena, (size_t)(d->triple_count + 1) * sizeof *found);
    if (!found) {
        d->g->status = DIG_E_MEMORY;
        return false;
    }
    real off = direct_inside(d, false), missing = missing_lift(d), first = real_max(off, missing);
    keep_found(d, found);
    if (!(off < INSIDE_GOOD)) {
        off = inside_convex(d);
        missing = missing_lift(d);
        if (!(off < INSIDE_GOOD))
            return take_found(d, found, first, INSIDE_POOR);
        if (first <= real_max(off, missing))
            return take_found(d, found, first, INFINITY);
        keep_found(d, found);
    }
    d->most_factors += d->factors;
    bool better = solve(d, real_max(residual, INSIDE_AIM)) && d->error < off;
    off = better ? d->error : off;
    if (!better && !take_found(d, found, off, INSIDE_GOOD))
        return false;
    d->error = real_max(off, missing);
    return true;
}

/* The same for joints, whose rows are solved from soft to hard. Poor is better than what sweeps leave, but what is off by more than
 * the rows' own speeds has diverged. Lifts that change as much are not those of this motion: what heals on a slope slides, its lift
 * takes back all that it aims at, and by turns it is thrown up and let sink. */
static bool solve_joints(Direct *d)
{
    start_from(d);
    real speed = speed_of_rows(d), moved = INFINITY;
    direct_begin(d);
    d->error = INFINITY;
    while (d->rounds < JOINT_MOST_ROUNDS && d->factors < d->most_factors && d->error > JOINT_AIM) {
        if (!carry_on(d) || !minimise(d, 0.1 * AIM) || (d->quits && d->unbalanced > LOST))
            return false;
        real before = moved;
        d->error = direct_off(d);
        moved = direct_round(d, true);
        d->swings = moved > 0.5 * before;
        if (++d->rounds >= JOINT_ROUNDS && d->error < JOINT_POOR && moved < JOINT_SETTLED * speed)
            break;
    }
    return finite(d) && real_max(d->error, d->unbalanced) < real_min(d->accept, real_max(JOINT_POOR, speed));
}

/* From the inside, with joints. What is wedged between parts that joints hold has no solution, and presses until their rows give. */
static bool solve_inside_joints(Direct *d)
{
    real off = direct_inside(d, false);
    off = real_max(off, singles_unmet(d));
    if (!(off < INSIDE_GOOD)) {
        off = inside_convex(d);
        off = real_max(off, singles_unmet(d));
    }
    d->error = real_max(off, missing_lift(d));
    d->unbalanced = off;
    return off < INSIDE_POOR && finite(d);
}

/* A factorisation also counts as a sweep. */
static void count(Direct *d)
{
    d->g->sweeps += d->factors;
    d->g->factors += d->factors;
    d->g->multiplied += d->factors > 0 ? d->blocks.begin_work + d->factors * d->blocks.late_work : 0;
}

static bool run(Direct *d, real residual)
{
    Group *g = d->g;
    d->late_lift = group_elastic(g);
    ArenaMark mark = arena_mark(g->arena);
    d->heavy = group_top_heavy(g);
    bool open = open_direct(d);
    if (open && g->calm && g->trace_wait == 0)
        d->most_factors = (int)real_clamp((MANY_WORK / (1 + g->toil.steps) - g->multiplied) / d->blocks.work, 1, MANY_FACTORS);
    bool fine = open && (g->joints_direct ? d->inside ? solve_inside_joints(d) : solve_joints(d)
                                          : d->inside ? solve_inside(d, residual) : solve(d, residual));
    if (fine)
        write_back(d);
    count(d);
    arena_rewind(g->arena, mark);
    return fine;
}

#define LEVERED 4.0             /* times all that overlaps: what moves on by more does so along a wedge, for which rows of these poses are not made */

/* 1  The part of a projection that may be made at once. In a stack the topmost moves by what overlaps below it, all together. Any part of a
 * projection obeys its rows, too: what may close closes less, and what overlaps is left for later. */
static real share_of_shift(const Direct *d)
{
    const Group *g = d->g;
    real sum = 0, deep = 0, most = 0;
    for (int i = 0; i < g->point_count; i++) {
        bool next = i == 0 || g->points[i].contact != g->points[i - 1].contact;
        sum += next ? deep : 0;
        deep = real_max(next ? 0 : deep, g->points[i].target);
    }
    for (int i = 0; i < d->blocks.n; i++) {
        const real *v = d->v + 6 * i;
        vec3 move = {v[0], v[1], v[2]}, turn = {v[3], v[4], v[5]};
        most = real_max(most, vec3_length(move) + g->member[d->body[i]].outer * vec3_length(turn));
    }
    real all = LEVERED * (sum + deep);
    return most > all ? all / most : 1;
}

bool direct_project(Group *g)
{
    if (g->point_count > most_points[1] || g->moving_count > MOST_BODIES)
        return false;
    ArenaMark mark = arena_mark(g->arena);
    Direct d = {.g = g, .heavy = true, .projects = true, .slack = true, .hardened = JOINT_SOFT, .hardest = HARDEST, .most_factors = PROJECT_FACTORS,
                .accept = INFINITY};
    bool fine = open_direct(&d) && solve_joints(&d);
    real share = fine && !g->joints_direct ? share_of_shift(&d) : 1;
    for (int i = 0; fine && i < d.blocks.n; i++) {
        const real *v = d.v + 6 * i;
        g->vel[d.body[i]] = (Vel){vec3_scale(share, (vec3){v[0], v[1], v[2]}), vec3_scale(share, (vec3){v[3], v[4], v[5]})};
    }
    count(&d);
    arena_rewind(g->arena, mark);
    return fine;
}

bool direct_project_joints(Group *g)
{
    g->joints_direct = true;
    bool fine = direct_project(g);
    g->joints_direct = false;
    return fine;
}

/* Rows that are soft at first. */
static bool solve_soft(Group *g, real residual, int most_factors, real accept)
{
    Direct d = {.g = g, .hardened = RESCUE_SOFT, .hardest = 1, .most_factors = most_factors, .accept = accept};
    return run(&d, residual);
}

/* Where something is heavy, but for what is stirred and may pause (toil.c): each step has another heap to find forces for. With joints, too, where none of
 * them gives: there lifts are those of the start. */
static bool has_cones(const Group *g)
{
    bool suits = !g->joints_direct || (g->point_count > 0 && !group_elastic(g));
    return suits && group_top_heavy(g) && !g->may_pause && g->factors < INSIDE_MOST;
}

/* quits: where a round does not get there, there is another way */
static bool solve_joined(Group *g, real residual, bool quits)
{
    Direct d = {.g = g, .hardened = group_bears_load(g) ? JOINT_SOFT : CROWD_SOFT, .hardest = HARDEST, .most_factors = JOINT_FACTORS, .accept = INFINITY,
                .quits = quits};
    bool fine = run(&d, residual);
    if (fine)
        g->residual = d.error;
    return fine;
}

/* What is heavy on what is light, at kinks that Newton's method does not get over. */
static bool solve_cones(Group *g, real residual)
{
    Direct d = {.g = g, .inside = true, .hardened = INSIDE_SOFT, .hardest = 1, .most_factors = INSIDE_FACTORS, .accept = INSIDE_GOOD};
    g->from_inside = run(&d, residual);
    g->inside_failed = !g->from_inside;
    if (g->from_inside)
        g->residual = d.error;
    return g->from_inside;
}

/* Rows that are hard at once. */
static bool solve_hard(Group *g, real residual, bool heavy)
{
    Direct d = {.g = g, .hardened = 1, .hardest = HARDEST, .most_factors = MOST_FACTORS, .accept = GOOD};
    if (!heavy)
        d.most_factors = int_min(MOST_FACTORS, int_max(FEW_FACTORS, FACTOR_POINTS / g->point_count));
    return run(&d, residual);
}

bool direct_solve(Group *g, real residual)
{
    bool joints = g->joints_direct, heavy = group_top_heavy(g), cones = has_cones(g), fine = false;
    int before = g->factors;
    residual = real_min(residual, AIM);
    g->from_inside = false;
    if (!g->starts_soft)
        fine = joints ? solve_joined(g, residual, cones) : solve_hard(g, residual, heavy);
    g->starts_soft = (cones || (!heavy && !joints)) && !fine && !(g->calm && g->trace_wait > 0);
    if (g->starts_soft && cones)
        fine = solve_cones(g, residual) || (joints && solve_joined(g, residual, false));
    else if (g->starts_soft)
        fine = solve_soft(g, residual, int_min(SOFT_FACTORS, SOFT_POINTS / g->point_count), SOFT_GOOD);
    g->direct_factors = g->factors - before;
    g->direct_failures = fine && !joints ? 0 : g->direct_failures + !fine;
    return fine;
}

static bool at_stop(const Group *g)
{
    for (int i = 0; i < g->row_count; i++)
        if (g->rows[i].row.kind == ROW_LIMIT && g->rows[i].p > 0)
            return true;
    return false;
}

/* Few joints are left to sweeps. Where these stall far from a solution there may be one all the same: a chain of five joints, two of them
 * welds, was left 1 to 11 m/s off and got 55 J of 40 by it in eight substeps; here it takes two to six factorisations.
 * Of what hangs on its stops as one stiff beam each of many sweeps brings a little, and it sinks. */
static bool rescue_joints(Group *g)
{
    if (!(g->stalled || at_stop(g)) || g->point_count > most_points[0] || g->moving_count > MOST_BODIES || g->rescues_failed >= MOST_RESCUES)
        return false;
    Direct d = {.g = g, .slack = true, .hardened = JOINT_SOFT, .hardest = HARDEST, .most_factors = JOINT_FACTORS, .accept = RESCUED * g->residual};
    g->joints_direct = true;
    bool fine = run(&d, g->plan->residual);
    g->joints_direct = false;
    g->rescues_failed += !fine;
    if (fine) {
        g->residual = d.error;
        g->stalled = false;
    }
    return fine;
}

bool direct_rescue(Group *g)
{
    if (g->row_count > 0)
        return !g->joints_direct && rescue_joints(g);
    if (g->calm || toil_pauses(g) || g->point_count == 0 || g->point_count > most_points[0] || g->moving_count > MOST_BODIES
        || g->rescues_failed >= MOST_RESCUES)
        return false;
    if (has_cones(g)) {
        bool fine = solve_cones(g, AIM);
        g->rescues_failed += !fine;
        return fine;
    }
    g->from_inside = false;
    real accept = RESCUED * g->residual;
    bool fine = solve_soft(g, RESCUED * accept, MOST_FACTORS, accept);
    g->rescues_failed += !fine;
    return fine;
}
