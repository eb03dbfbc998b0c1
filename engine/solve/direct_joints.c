/* solve/direct_joints.c - rows of joints in the direct solve, and the geometric stiffness of the bodies they pull at.
 *
 * A taut joint turns with its bodies within the substep: a restoring torque that velocities alone do not see, and that makes
 * an exact solve of chains and bridges explode when the substep is long against their transverse swing. It is taken implicitly,
 * with the joint's last force F at the arm r:  I + h^2 K in place of I  (Tournier, Nesme, Gilles & Faure 2015, "Stable constrained
 * dynamics", ACM Trans. Graph. 34(4)). The torque (t x r) x F that a turn t gives rise to is -((F . r) 1 - r F^T) t, of which the
 * symmetric part is taken:  K = (F . r) 1 - sym(r F^T). Of a mechanism that floats, t is a turn against it as one rigid body: F goes
 * round with that. Not where it would hand a turn across a thin rod over to one about the rod, which has next to no inertia there: a rope of
 * 6 kg that 10 t jerk at got 1e35 J by that.
 */
#include "math/pair.h"
#include "solve/direct.h"
#include "solve/momentum.h"

/* Compliance of the augmented Lagrangian over a row's own effective mass. Equations have no kinks, and may be harder than what
 * has a bound. */
#define COMPLIANCE         1e-8
#define BOUNDED_COMPLIANCE 1e-6

/* ---- rows ---- */

static void place_row(const Direct *d, Single *t, const Row *row)
{
    const Group *g = d->g;
    for (int k = 0; k < row->count; k++) {
        int b = row->body[k];
        if (b < 0)
            continue;
        t->rate += vec3_dot(row->lin[k], g->vel[b].v) + vec3_dot(row->ang[k], g->vel[b].w);
        if (d->place[b] < 0)
            continue;
        vec3 part[2] = {row->lin[k], d->narrow[b] ? vec3_zero() : row->ang[k]};
        memcpy(t->j[t->count], part, sizeof part);
        t->place[t->count++] = d->place[b];
    }
}

/* A row that only turns what does not turn has nothing to answer with: its estimate would grow by what it is off, over next to nothing, in each round. */
static bool moves_something(const Single *t)
{
    for (int k = 0; k < t->count; k++)
        for (int c = 0; c < 6; c++)
            if (t->j[k][c] != 0)
                return true;
    return false;
}

static void add_single(Direct *d, int i)
{
    const Group *g = d->g;
    const JointRow *p = &g->rows[i];
    if (!(p->k > 0))
        return;
    Single *t = &d->singles[d->single_count++];
    *t = (Single){.row = i, .target = p->bias, .start = p->p, .prox = p->p, .lo = p->lo, .hi = p->hi, .r = COMPLIANCE * p->k};
    t->bounded = t->lo > -INFINITY || t->hi < INFINITY;
    if (t->bounded)
        t->r = BOUNDED_COMPLIANCE * d->hardened * p->k;
    if (p->row.kind == ROW_SOFT) {      /* a spring gives by itself: force = (target - rate) / gamma, and no estimate beside it */
        t->soft = true;
        t->r = p->gamma;
        t->prox = 0;
    }
    place_row(d, t, &p->row);
    if (!moves_something(t))
        d->single_count--;
}

/* N  The last force of a joint on the side `a` of it. */
static vec3 joint_pull(const Group *g, const JointBlock *b)
{
    const GroupJoint *j = &g->joints[b->joint];
    vec3 f = vec3_zero();
    for (int i = b->first; i < b->first + b->count; i++) {
        const Row *r = &g->rows[i].row;
        for (int k = 0; k < r->count; k++)
            if (r->body[k] == j->a)
                f = vec3_mad(f, j->force[r->slot], r->lin[k]);
    }
    return f;
}

#define SWINGS 0.05             /* h^2 K over the mass: tauter lines are taken into account */

/* A taut line of tension T and length l swings back with T / l across itself. */
static void add_line(Direct *d, const JointBlock *b)
{
    const Group *g = d->g;
    const JointView *v = &g->joints[b->joint].view;
    vec3 line = vec3_sub(v->a.p, v->b.p), across[2];
    real length = vec3_length(line);
    if (!v->type->two_anchors || !(length > 0))
        return;
    line = vec3_scale(1 / length, line);
    real added = -vec3_dot(joint_pull(g, b), line) / length * g->h * g->h, mobility = 0;        /* kg, 1 / kg */
    vec3_basis(line, &across[0], &across[1]);
    const JointEnd *end[2] = {&v->a, &v->b};
    for (int k = 0; k < 2; k++)
        mobility += end[k]->body < 0 ? 0 : g->mass[end[k]->body].im;
    if (!(added * mobility > SWINGS))
        return;
    for (int i = 0; i < 2; i++) {
        Row row = {.kind = ROW_SOFT};
        for (int k = 0; k < 2; k++) {
            row.lin[k] = k ? vec3_neg(across[i]) : across[i];
            row.ang[k] = vec3_cross(end[k]->r, row.lin[k]);
            row.body[k] = end[k]->body;
            dir_mask(g, &row.lin[k], &row.ang[k]);
        }
        row.count = 2;
        Single *t = &d->singles[d->single_count++];
        *t = (Single){.row = -1, .lo = -INFINITY, .hi = INFINITY, .soft = true, .r = 1 / added};
        place_row(d, t, &row);
        if (t->count == 0)
            d->single_count--;
    }
}

/* rad^2 in a substep: sweeps, explicit across springs, gain from 4 on, of all that pull at a body */
#define SWAY_MOST 1.0           /* of one, */
#define SWAY_ALL  3.0           /* and of all at a body: two side by side are as one of twice the stiffness */

/* 1/s^2  Of the sway of a spring's ends across it: as of a line, and as its pull brings back an arm that has turned. 0: it does not pull. */
static real sway_across(const Group *g, const JointView *v, real pull)
{
    vec3 line = vec3_sub(v->b.p, v->a.p), across[2];
    real length = vec3_length(line), most = 0;
    if (!(pull > 0) || !(length > 0))
        return 0;
    line = vec3_scale(1 / length, line);
    vec3_basis(line, &across[0], &across[1]);
    const JointEnd *end[2] = {&v->a, &v->b};
    for (int i = 0; i < 2; i++) {
        real sway = 0;
        for (int k = 0; k < 2; k++) {
            int b = end[k]->body;
            vec3 turn = vec3_cross(end[k]->r, across[i]);
            real arm2 = vec3_length2(turn), outward = (k ? -1 : 1) * vec3_dot(line, end[k]->r);
            if (b < 0 || !g->member[b].moves)
                continue;
            real spun = vec3_dot(turn, mat3_mul_vec(g->mass[b].ii, turn));
            sway += pull / length * (g->mass[b].im + spun) + (arm2 > 0 ? pull * real_max(0, outward) * spun / arm2 : 0);
        }
        most = real_max(most, sway);
    }
    return most;
}

/* rad^2 in a substep  Of the sway across it, if it is a spring; else 0. */
static real spring_sway(Group *g, int joint, real h)
{
    Row rows[JOINT_SLOTS];
    RowList list = {rows, 0, JOINT_SLOTS};
    if (!g->joints[joint].stores || !g->joints[joint].view.type->two_anchors)
        return 0;
    group_joint_view(g, joint);
    const JointView *v = &g->joints[joint].view;
    v->type->rows(v, &list);
    return list.count == 1 && rows[0].kind == ROW_SOFT ? h * h * sway_across(g, v, rows[0].stiffness * rows[0].error) : 0;
}

bool springs_swing(Group *g)
{
    if (g->joint_count < 2)         /* one alone goes with what it pulls at, and its blows are worth being located */
        return false;
    real h = g->world->def.step / g->plan->substeps;
    bool swings = false;
    ArenaMark mark = arena_mark(g->arena);
    real *all = arena_zero(g->arena, (size_t)g->body_count * sizeof *all);
    for (int i = 0; i < g->joint_count && all && !swings; i++) {
        real sway = spring_sway(g, i, h);
        const JointView *v = &g->joints[i].view;
        const int ends[2] = {v->a.body, v->b.body};
        swings = sway > SWAY_MOST;
        for (int k = 0; k < 2 && sway > 0; k++)
            swings = swings || (ends[k] >= 0 && (all[ends[k]] += sway) > SWAY_ALL);
    }
    if (!all)
        g->status = DIG_E_MEMORY;
    arena_rewind(g->arena, mark);
    return swings;
}

bool singles_open(Direct *d)
{
    const Group *g = d->g;
    size_t most = (size_t)(g->row_count + 2 * g->block_count + 1);
    d->singles = arena_alloc(g->arena, most * sizeof *d->singles);
    d->bends = arena_alloc(g->arena, most * sizeof *d->bends);
    if (!d->singles || !d->bends)
        return false;
    for (int i = 0; i < g->row_count; i++)
        add_single(d, i);
    for (int i = 0; i < g->block_count && !d->slack; i++)
        add_line(d, &g->blocks[i]);
    return true;
}

static bool has_bound(const Row *r) { return r->kind == ROW_LIMIT || r->kind == ROW_MOTOR || r->kind == ROW_DRY; }

void singles_link(const Direct *d, BlockLinks *of, int *link, bool *late)
{
    for (int i = 0; i < d->g->row_count; i++) {
        const Row *r = &d->g->rows[i].row;
        for (int k = 0; k < r->count; k++) {
            int a = r->body[k] < 0 ? -1 : d->place[r->body[k]];
            if (a < 0)
                continue;
            late[a] = late[a] || has_bound(r);
            for (int m = 0; m < k; m++) {
                int b = r->body[m] < 0 ? -1 : d->place[r->body[m]];
                if (b < 0)
                    continue;
                link[2 * of->links] = a;
                link[2 * of->links++ + 1] = b;
            }
        }
    }
}

/* ---- impulses ---- */

static real dot6(const real *a, const real *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]; }

static real wish(const Single *t, real along) { return t->prox + (t->target - t->rate - along * t->change) / t->r; }

void singles_changes(Direct *d)
{
    for (int i = 0; i < d->single_count; i++) {
        Single *t = &d->singles[i];
        t->change = 0;
        for (int m = 0; m < t->count; m++)
            t->change += dot6(t->j[m], d->dv + 6 * t->place[m]);
    }
}

void singles_move(Direct *d, real along)
{
    for (int i = 0; i < d->single_count; i++)
        d->singles[i].rate += along * d->singles[i].change;
}

/* False: what is at a bound has changed since the factor was made. */
bool singles_forces(Direct *d)
{
    bool same = true;
    for (int i = 0; i < d->single_count; i++) {
        Single *t = &d->singles[i];
        real y = wish(t, 0);
        t->force = real_clamp(y, t->lo, t->hi);
        t->answers = t->force == y;
        same = same && t->answers == t->factored;
    }
    return same;
}

void singles_free(Direct *d)
{
    for (int i = 0; i < d->single_count; i++) {
        Single *t = &d->singles[i];
        if (!t->answers || !t->bounded)
            t->force = t->bounded ? t->lo : wish(t, 0);
    }
}

void singles_keep(Direct *d)
{
    for (int i = 0; i < d->single_count; i++)
        if (!d->singles[i].soft)
            d->singles[i].prox = d->singles[i].force;
}

void singles_gradient(Direct *d)
{
    for (int i = 0; i < d->single_count; i++) {
        const Single *t = &d->singles[i];
        real change = t->force - t->start;
        for (int m = 0; m < t->count; m++) {
            real *restrict grad = d->grad + 6 * t->place[m];
            const real *restrict j = t->j[m];
            for (int c = 0; c < 6; c++)
                grad[c] -= j[c] * change;
        }
    }
}

void singles_line(Direct *d)
{
    d->bend_count = 0;
    for (int i = 0; i < d->single_count; i++) {
        const Single *t = &d->singles[i];
        real y = wish(t, 0), by = t->change / t->r;
        d->level += t->change * t->start;
        if (t->bounded)
            d->bends[d->bend_count++] = (Bend){y, by, t->change, t->lo, t->hi};
        else {
            d->level -= t->change * y;
            d->rise += t->change * by;
        }
    }
}

real singles_slope(const Direct *d, real along)
{
    real slope = 0;
    for (int i = 0; i < d->bend_count; i++) {
        const Bend *b = &d->bends[i];
        slope -= b->change * real_clamp(b->wish - along * b->by, b->lo, b->hi);
    }
    return slope;
}

/* h += s x y^T, in rows of `stride` */
INLINE void add_outer(real *restrict h, int stride, int rows, int columns, const real *restrict x, const real *restrict y, real s)
{
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < columns; c++)
            h[stride * r + c] += s * x[r] * y[c];
}

/* Of places row >= column, of which three unknowns count where they do not turn. */
static void add_pair(const Blocks *s, int row, int column, const real *x, const real *y, real by)
{
    if (row == column)
        add_outer(s->diagonal + BLOCK * row, 6, 6, 6, x, y, by);
    else if (!s->narrow[column])
        add_outer(blocks_at(s, row, column), 6, 6, 6, x, y, by);
    else
        add_outer(blocks_at(s, row, column), 4, s->narrow[row] ? 3 : 6, 3, x, y, by);
}

void singles_assemble(Direct *d, bool bounded)
{
    for (int i = 0; i < d->single_count; i++) {
        Single *t = &d->singles[i];
        if (t->bounded != bounded)
            continue;
        bool answers = !bounded || t->answers;      /* what has no bound answers in each assembly */
        t->factored = t->answers;
        for (int m = 0; answers && m < t->count; m++)
            for (int n = 0; n < t->count; n++)
                if (t->place[m] >= t->place[n])
                    add_pair(&d->blocks, t->place[m], t->place[n], t->j[m], t->j[n], 1 / t->r);
    }
}

/* ---- the outer loop ---- */

void singles_begin(Direct *d)
{
    for (int i = 0; i < d->single_count; i++) {
        Single *t = &d->singles[i];
        t->answers = !(t->lo == 0 && t->prox == 0);
        t->force = t->answers ? wish(t, 0) : 0;
    }
}

/* m/s or rad/s  how far off the estimates are */
real singles_off(const Direct *d)
{
    real worst = 0;
    for (int i = 0; i < d->single_count; i++) {
        const Single *t = &d->singles[i];
        if (!t->soft)
            worst = real_max(worst, t->r * fabs(t->force - t->prox));
    }
    return worst;
}

real singles_unmet(const Direct *d)
{
    real worst = 0;
    for (int i = 0; i < d->single_count; i++) {
        const Single *t = &d->singles[i];
        if (!t->soft && !t->bounded)
            worst = real_max(worst, fabs(t->rate - t->target));
    }
    return worst;
}

void singles_round(Direct *d, real harder)
{
    for (int i = 0; i < d->single_count; i++) {
        Single *t = &d->singles[i];
        real before = wish(t, 0);
        if (!t->soft)
            t->prox = t->force;
        t->r *= t->bounded ? harder : 1;
        t->force += t->answers ? wish(t, 0) - before : 0;
    }
}

static real rate_at_start(const Direct *d, const Single *t)
{
    real rate = 0;
    for (int k = 0; k < t->count; k++) {
        const Vel *v = &d->g->start_vel[d->body[t->place[k]]];
        const real *j = t->j[k];
        rate += vec3_dot((vec3){j[0], j[1], j[2]}, v->v) + vec3_dot((vec3){j[3], j[4], j[5]}, v->w);
    }
    return rate;
}

/* Impulses of the rows, and the velocities. */
void singles_write(Direct *d)
{
    Group *g = d->g;
    for (int i = 0; i < d->single_count; i++) {
        const Single *t = &d->singles[i];
        if (t->row < 0)
            g->braced -= t->force * 0.5 * (rate_at_start(d, t) - t->r * t->force);
        else
            g->rows[t->row].p = t->soft ? t->force : t->prox;
    }
    for (int i = 0; i < d->blocks.n; i++) {
        int b = d->body[i];
        const real *v = d->v + 6 * i;
        vec3 w = d->narrow[b] ? vec3_zero() : vec3_add(g->vel[b].w, (vec3){v[3], v[4], v[5]});
        Vel end = {vec3_add(g->vel[b].v, (vec3){v[0], v[1], v[2]}), w};
        vec3 mean = vec3_scale(0.5, vec3_add(g->start_vel[b].w, end.w));
        g->braced += vec3_dot(mat3_mul_vec(d->stiff[b], vec3_sub(end.w, d->round[b])), mean);
        g->vel[b] = end;
    }
}

/* ---- geometric stiffness ---- */

static void add_stiffness(mat3 *k, vec3 f, vec3 r)
{
    mat3 both = mat3_add(mat3_outer(r, f), mat3_outer(f, r));
    *k = mat3_add(*k, mat3_add(mat3_scale(vec3_dot(f, r), mat3_identity()), mat3_scale(-0.5, both)));
}

#define THIN 16.0               /* times the inertia about one axis: a body that has more about another is thin */

static void uncouple(real *a, real *b, real one, real other)
{
    if (one > THIN * other || other > THIN * one)
        *a = *b = 0;
}

/* In body axes without what couples a turn about the length of a thin body to others. */
static mat3 uncoupled(const Group *g, int body, mat3 k)
{
    const mat3 r = quat_matrix(g->pos[body].q), i = *g->member[body].inertia;
    mat3 m = mat3_mul(mat3_mul(mat3_transpose(r), k), r);
    uncouple(&m.r0.y, &m.r1.x, i.r0.x, i.r1.y);
    uncouple(&m.r1.z, &m.r2.y, i.r1.y, i.r2.z);
    uncouple(&m.r0.z, &m.r2.x, i.r0.x, i.r2.z);
    return mat3_mul(mat3_mul(r, m), mat3_transpose(r));
}

/* Of what a planar world lets turn. */
static mat3 in_plane(const Group *g, mat3 k)
{
    return mat3_diagonal((vec3){g->planar == 1 ? k.r0.x : 0, g->planar == 2 ? k.r1.y : 0, g->planar == 3 ? k.r2.z : 0});
}

static bool positive_definite(mat3 m)
{
    return m.r0.x > 0 && m.r0.x * m.r1.y - m.r0.y * m.r1.x > 0 && mat3_det(m) > 0;
}

static bool find_round(Direct *d)
{
    const Group *g = d->g;
    d->round = arena_zero(g->arena, (size_t)(g->body_count + 1) * sizeof *d->round);
    if (!d->round || d->slack || g->block_count == 0)
        return d->round;
    int *root = arena_alloc(g->arena, (size_t)(g->moving_count + 1) * sizeof *root);
    uint8_t *ties = arena_zero(g->arena, (size_t)g->moving_count + 1);
    if (!root || !ties)
        return false;
    group_mechanisms(g, root, ties);
    for (int which = 0; which < g->moving_count; which++) {
        if (!g->member[which].moves || root[which] != which || ties[which] != MECHANISM_TIED)
            continue;
        Rigid r;
        rigid_motion(g, root, which, &r);
        for (int i = which; i < g->moving_count; i++)
            d->round[i] = root[i] == which ? r.w : d->round[i];
    }
    return true;
}

bool stiffness_open(Direct *d)
{
    const Group *g = d->g;
    d->stiff = arena_zero(g->arena, (size_t)(g->body_count + 1) * sizeof *d->stiff);
    if (!d->stiff || !find_round(d))
        return false;
    for (int i = 0; i < g->block_count && !d->slack; i++) {
        const GroupJoint *j = &g->joints[g->blocks[i].joint];
        vec3 f = joint_pull(g, &g->blocks[i]);
        if (j->a >= 0)
            add_stiffness(&d->stiff[j->a], f, j->view.a.r);
        if (j->b >= 0)
            add_stiffness(&d->stiff[j->b], vec3_neg(f), j->view.b.r);
    }
    for (int i = 0; i < g->body_count; i++) {
        mat3 *k = &d->stiff[i];
        *k = mat3_scale(g->h * g->h, *k);
        *k = g->planar ? in_plane(g, *k) : uncoupled(g, i, *k);
        mat3 tensor;
        bool pulls = k->r0.x + k->r1.y + k->r2.z > 0 && d->place[i] >= 0;
        if (!pulls || !direct_tensor(g, i, &tensor) || !positive_definite(mat3_add(*k, tensor)))
            *k = (mat3){vec3_zero(), vec3_zero(), vec3_zero()};
    }
    return true;
}
