/* solve/joint_rows.c - joints write their rows; blocks are factored, soft rows get their implicit numbers. */
#include "solve/group.h"

#include "solve/direction.h"

void joint_end_set(JointEnd *e, vec3 x, quat q, vec3 v, vec3 w, vec3 local_anchor, quat local_frame)
{
    e->x = x;
    e->v = v;
    e->w = w;
    e->r = quat_rotate(q, local_anchor);
    e->p = vec3_add(x, e->r);
    mat3 f = mat3_transpose(quat_matrix(quat_mul(q, local_frame)));
    e->axis = f.r0;
    e->u = f.r1;
    e->n = f.r2;
}

static void set_end(const Group *g, JointEnd *e, int body, vec3 anchor, quat frame)
{
    e->body = body;
    if (body < 0)
        joint_end_set(e, vec3_zero(), quat_identity(), vec3_zero(), vec3_zero(), anchor, frame);
    else
        joint_end_set(e, g->pos[body].x, g->pos[body].q, g->vel[body].v, g->vel[body].w, anchor, frame);
}

static void set_ends(const Group *g, GroupJoint *j)
{
    set_end(g, &j->view.a, j->a, j->ra, j->fa);
    set_end(g, &j->view.b, j->b, j->rb, j->fb);
}

/* Who asks for a gear alone is to find its hinges where they are, too: it may come before them. */
void group_joint_view(Group *g, int joint)
{
    GroupJoint *j = &g->joints[joint];
    set_ends(g, j);
    for (int k = 0; k < 2; k++) {
        GroupJoint *other = j->other[k] < 0 ? NULL : &g->joints[j->other[k]];
        j->view.other[k] = other ? &other->view : NULL;
        if (other)
            set_ends(g, other);
    }
}

void group_joint_move(Group *g, int joint)
{
    GroupJoint *j = &g->joints[joint];
    if (j->a >= 0 && (g->member[j->a].moves || g->member[j->a].kinematic))
        set_end(g, &j->view.a, j->a, j->ra, j->fa);
    if (j->b >= 0 && (g->member[j->b].moves || g->member[j->b].kinematic))
        set_end(g, &j->view.b, j->b, j->rb, j->fb);
}

real group_row_mobility(const Group *g, const Row *r, int k)
{
    int b = r->body[k];
    if (b < 0)
        return 0;
    return g->mass[b].im * vec3_length2(r->lin[k]) + vec3_dot(r->ang[k], mat3_mul_vec(g->mass[b].ii, r->ang[k]));
}

static real start_rate(const Group *g, const Row *r)
{
    real rate = 0;
    for (int k = 0; k < r->count; k++) {
        int b = r->body[k];
        if (b < 0)
            continue;
        Vel v = g->member[b].moves ? g->start_vel[b] : g->vel[b];
        rate += vec3_dot(r->lin[k], v.v) + vec3_dot(r->ang[k], v.w);
    }
    return rate;
}

/* Spring and damper, implicit. With the end velocity it damps (backward Euler); with the mean velocity it keeps energy. */
static void finish_soft(const Group *g, JointRow *r)
{
    real h = g->h, k = r->row.stiffness, c = r->row.damping;
    real s = g->midpoint ? 0.5 * h * (0.5 * h * k + c) : h * (h * k + c);
    if (!(s > 1e-290)) {        /* below, 1 / s overflows */
        r->k = 0;               /* neither stiff nor damped: no row */
        return;
    }
    r->gamma = 1 / s;
    r->bias = -r->row.error * h * k / s - (g->midpoint ? start_rate(g, &r->row) : 0);
}

#define STRONG 1e4              /* times what brings all of the group to the motor's speed in a step, or by its own size, and what else acts on it */

/* Against a wall a motor without a bound is stalled by any force, and no number is that: while it is not at its speed, it gives what nothing else in
 * the group comes near to. At its speed it holds whatever comes. */
real group_motor_lag(const Group *g, const Row *r)
{
    const Bulk *b = &g->bulk;
    real dt = g->world->def.step;
    if (!isinf(r->hi))
        return r->hi;
    DIG_ASSERT(b->found);
    return STRONG * (r->angular ? b->size * (b->mass * b->size * (1 / dt + fabs(r->rate)) / dt + b->load) :
                                  b->mass * (b->size / dt + fabs(r->rate)) / dt + b->load);
}

#define DRIVE_SPEED 10          /* times what brings all of the group to the motor's speed in a step, */
#define DRIVE_LOAD 100          /* and what else acts on it */

/* In a loop, where links come to lie in one line, or jammed between contacts, no torque is enough to go on at its speed, and what turns there is thrown
 * about by whatever there is of it. What only brakes throws nothing about. */
real group_motor_most(const Group *g, const GroupJoint *j, const Row *r)
{
    const Bulk *b = &g->bulk;
    if (!isinf(r->hi) || !(j->lags || j->looped))
        return r->hi;
    if (r->rate == 0)
        return group_motor_lag(g, r);
    DIG_ASSERT(b->found);
    real speed = DRIVE_SPEED * fabs(r->rate) / g->world->def.step;
    return r->angular ? b->size * (speed * b->size * b->mass + DRIVE_LOAD * b->load) : speed * b->mass + DRIVE_LOAD * b->load;
}

#define RIGID 1e3               /* times the impulse that brings it to its speed: no sweep gets to the bound of a motor that gives more */

/* Where a stop is as near as a substep's way, and the motor has no bound or one that sweeps do not get to, the stop wins: the motor
 * drives no faster than the stop allows, and brakes nothing. That is the stop's to do. */
static void finish_motor(const Group *g, const GroupJoint *j, JointRow *r)
{
    real rate = r->row.rate, most = group_motor_most(g, j, &r->row) * g->h, room = r->row.error;
    r->bias = rate;
    r->lo = -most;
    r->hi = most;
    if (!(most * r->k > RIGID * fabs(rate)) || !(room < g->h * fabs(rate)))
        return;
    r->bias = copysign(real_max(0, room) / g->h, rate);
    *(rate > 0 ? &r->lo : &r->hi) = 0;
}

/* A row at the start of a substep: its error, and how fast that changes. */
typedef struct RowStart { real error, rate; } RowStart;

/* The rate at the end of a substep that a stop allows. By the midpoint rule its direction, that of the middle, has turned by what the
 * motion has on `turned`, m/s or rad/s: along the stop as much is turned back, as of a joint that holds, and no energy is lost. What
 * ran into the stop is not. */
static real stop_rate(const Group *g, const Row *r, const RowStart *start)
{
    real turned = g->midpoint && start ? start_rate(g, r) - start->rate : 0;
    return (r->error > 0 ? -r->error / g->h : 0) - turned;
}

/* start: NULL = the rows are those of the start. */
static void finish_row(const Group *g, const GroupJoint *j, JointRow *r, const RowStart *start)
{
    real k = 0;
    for (int i = 0; i < r->row.count; i++) {
        int b = r->row.body[i];
        if (b < 0) {
            r->im[i] = r->ii[i] = vec3_zero();
            continue;
        }
        dir_mask(g, &r->row.lin[i], &r->row.ang[i]);
        r->im[i] = vec3_scale(g->mass[b].im, r->row.lin[i]);
        r->ii[i] = mat3_mul_vec(g->mass[b].ii, r->row.ang[i]);
        k += vec3_dot(r->row.lin[i], r->im[i]) + vec3_dot(r->row.ang[i], r->ii[i]);
    }
    r->k = k;
    r->gamma = r->bias = 0;
    r->p = j->force[r->row.slot] * g->h;
    r->lo = r->row.kind == ROW_LIMIT ? 0 : r->row.kind == ROW_DRY ? -r->row.hi * g->h : -INFINITY;
    r->hi = r->row.kind == ROW_DRY ? r->row.hi * g->h : INFINITY;
    if (r->row.kind == ROW_MOTOR)
        finish_motor(g, j, r);
    else if (r->row.kind == ROW_LIMIT)
        r->bias = stop_rate(g, &r->row, start);
    else if (r->row.kind == ROW_SOFT)
        finish_soft(g, r);
    else if (r->row.kind == ROW_HARD && g->midpoint)
        r->bias = -start_rate(g, &r->row);          /* the mean velocity keeps the constraint: no work is done */
}

/* L D L^T of J M^-1 J^T over the hard rows. A row that repeats another gets a pivot of its own share (1e-9), so that
 * redundant joints share their load instead of failing. */
static void factor_block(Group *g, JointBlock *b)
{
    for (int i = 0; i < b->hard; i++) {
        const JointRow *ri = &g->rows[b->first + i];
        for (int k = 0; k <= i; k++) {
            const JointRow *rk = &g->rows[b->first + k];
            real s = 0;
            for (int m = 0; m < ri->row.count; m++)
                for (int n = 0; n < rk->row.count; n++)
                    if (ri->row.body[m] >= 0 && ri->row.body[m] == rk->row.body[n])
                        s += vec3_dot(ri->row.lin[m], rk->im[n]) + vec3_dot(ri->row.ang[m], rk->ii[n]);
            b->l[i * 6 + k] = s;
        }
        b->l[i * 6 + i] *= 1 + 1e-12;
    }
    real d[6];
    for (int i = 0; i < b->hard; i++) {
        real diagonal = b->l[i * 6 + i];
        for (int k = 0; k < i; k++) {
            real s = b->l[i * 6 + k];
            for (int m = 0; m < k; m++)
                s -= b->l[i * 6 + m] * b->l[k * 6 + m] * d[m];
            b->l[i * 6 + k] = s / d[k];
        }
        real pivot = diagonal;
        for (int k = 0; k < i; k++)
            pivot -= b->l[i * 6 + k] * b->l[i * 6 + k] * d[k];
        d[i] = pivot > 1e-9 * diagonal ? pivot : diagonal > 0 ? diagonal : 1;
    }
    for (int i = 0; i < b->hard; i++)
        b->l[i * 6 + i] = 1 / d[i];
}

/* Hard rows first, so that a block is contiguous. */
static void sort_hard_first(Row *rows, int count)
{
    for (int i = 1; i < count; i++)
        for (int k = i; k > 0 && rows[k].kind == ROW_HARD && rows[k - 1].kind != ROW_HARD; k--) {
            Row t = rows[k];
            rows[k] = rows[k - 1];
            rows[k - 1] = t;
        }
}

static void build_joint(Group *g, int joint, const RowStart *starts)
{
    GroupJoint *j = &g->joints[joint];
    Row rows[JOINT_SLOTS];
    RowList list = {rows, 0, JOINT_SLOTS};
    j->view.swept = true;
    j->view.type->rows(&j->view, &list);
    j->view.swept = false;
    sort_hard_first(rows, list.count);
    JointBlock *b = &g->blocks[g->block_count++];
    *b = (JointBlock){.joint = joint, .first = g->row_count};
    for (int i = 0; i < list.count; i++) {
        JointRow *r = &g->rows[g->row_count++];
        memset(r, 0, sizeof *r);
        r->row = rows[i];
        const RowStart *start = starts ? &starts[joint * JOINT_SLOTS + rows[i].slot] : NULL;
        if (start)
            r->row.error = start->error;
        finish_row(g, j, r, start);
        b->hard += rows[i].kind == ROW_HARD;
        b->count++;
    }
    factor_block(g, b);
}

static void build_all(Group *g, const RowStart *starts)
{
    g->block_count = g->row_count = 0;
    for (int i = 0; i < g->joint_count; i++)
        group_joint_view(g, i);
    for (int i = 0; i < g->joint_count; i++)
        build_joint(g, i, starts);
}

/* A soft row whose own oscillation the step cannot follow makes the whole group move with end velocities. */
static bool any_stiff(const Group *g)
{
    for (int i = 0; i < g->row_count; i++) {
        const JointRow *r = &g->rows[i];
        if (r->row.kind == ROW_SOFT && r->k * g->h * (g->h * r->row.stiffness + r->row.damping) > 0.25)
            return true;
    }
    return false;
}

static void read_starts(const Group *g, RowStart *starts)
{
    for (int i = 0; i < g->block_count; i++)
        for (int k = 0; k < g->blocks[i].count; k++) {
            const Row *r = &g->rows[g->blocks[i].first + k].row;
            starts[g->blocks[i].joint * JOINT_SLOTS + r->slot] = (RowStart){r->error, start_rate(g, r)};
        }
}

/* Everybody half a substep on, along the start velocities or those found, and back. Inertias stay those of the start: group_turn takes
 * what impulses give for momentum there. With those of the middle the couple of a stop spun a thin rod about its own axis. */
static void shift_half(Group *g, const Vel *found, const Pos *back)
{
    for (int i = 0; i < g->body_count; i++) {
        const Member *m = &g->member[i];
        if (!m->moves && !m->kinematic)
            continue;
        Vel v = !m->moves ? g->vel[i] : found ? found[i] : g->start_vel[i];
        g->pos[i] = back ? back[i] : (Pos){vec3_mad(g->pos[i].x, 0.5 * g->h, v.v),
                                           quat_unit(quat_mul(quat_exp(vec3_scale(0.5 * g->h, v.w)), g->pos[i].q))};
    }
}

/* Directions at the middle of the substep, errors at its start, for the mean velocity or for that at the end. */
static void build_middle(Group *g, bool mean, const Vel *found)
{
    ArenaMark mark = arena_mark(g->arena);
    RowStart *starts = arena_zero(g->arena, (size_t)(g->joint_count * JOINT_SLOTS) * sizeof *starts);
    Pos *back = arena_alloc(g->arena, (size_t)g->body_count * sizeof *back);
    if (!starts || !back) {
        g->status = DIG_E_MEMORY;
        return;
    }
    memcpy(back, g->pos, (size_t)g->body_count * sizeof *back);
    read_starts(g, starts);
    g->midpoint = mean;
    shift_half(g, found, NULL);
    build_all(g, starts);
    shift_half(g, NULL, back);
    arena_rewind(g->arena, mark);
}

/* Rows at the present positions; or, for the midpoint rule, their directions at the middle of the substep and their errors
 * at its start. */
void group_build_joints(Group *g, bool midpoint)
{
    g->midpoint = false;
    build_all(g, NULL);
    if (midpoint && g->joint_count > 0 && !any_stiff(g))
        build_middle(g, true, NULL);
}

void group_turn_joints(Group *g, const Vel *found)
{
    g->midpoint = false;
    build_all(g, NULL);
    build_middle(g, false, found);
}

#define RUN_PAST 1e-6           /* m or rad */

static bool runs_past(const Group *g)
{
    for (int i = 0; i < g->row_count; i++) {
        const JointRow *r = &g->rows[i];
        if (r->row.kind == ROW_LIMIT && joint_row_rate(g, &r->row) < r->bias - RUN_PAST / g->h)
            return true;
    }
    return false;
}

/* Velocities that break a joint (a hit, a new joint) would be mirrored for ever by the midpoint rule: they are put right first. And where
 * they get to a stop in this substep, half of them would run past it: true, then it is to be struck. */
bool group_clean_joints(Group *g)
{
    if (g->joint_count == 0)
        return false;
    group_build_joints(g, false);
    bool mean = !any_stiff(g);
    for (int i = 0; i < g->row_count; i++) {
        g->rows[i].p = 0;
        if (g->rows[i].row.kind != ROW_HARD)
            g->rows[i].k = 0;
        if (g->rows[i].row.kind != ROW_LIMIT)
            g->rows[i].bias = 0;
    }
    real before = group_kinetic(g), given = 0;
    for (int i = 0; i < 200 && relax_joints(g) > g->plan->residual; i++)
        g->sweeps++;
    for (int i = 0; i < g->row_count; i++)
        given -= g->rows[i].p * group_row_driven(g, &g->rows[i].row);
    g->work_in += given;
    g->lost += before + given - group_kinetic(g);       /* the jerk */
    return mean && runs_past(g);
}

#define OPENS_MOST 1.5e-3         /* of the smaller body, or of a line: by more no joint may be opened in one substep */

/* m  Where an anchor gets in the substep, and in *straight if its body did not turn on; *size becomes that of its body if smaller. */
static vec3 anchor_after(const Group *g, const JointEnd *e, vec3 anchor, real *size, vec3 *straight)
{
    *straight = e->p;
    if (e->body < 0)
        return e->p;
    Vel way = group_way_of(g, e->body);
    quat q = quat_mul(quat_exp(vec3_scale(g->h, way.w)), g->pos[e->body].q);
    *size = real_min(*size, g->member[e->body].outer);
    *straight = vec3_mad(e->p, g->h, vec3_add(way.v, vec3_cross(way.w, e->r)));
    return vec3_add(vec3_mad(g->pos[e->body].x, g->h, way.v), quat_rotate(q, anchor));
}

typedef enum Keeps { KEEPS_OTHER, KEEPS_POINT, KEEPS_LINE } Keeps;

static Keeps what_it_keeps(const Group *g, const JointBlock *b)
{
    const JointRow *rows = &g->rows[b->first];
    int hard = 0;
    for (int i = 0; i < b->count; i++)
        hard += rows[i].row.kind == ROW_HARD && !rows[i].row.angular;
    if (hard == 3)
        return KEEPS_POINT;
    bool line = g->joints[b->joint].view.type->two_anchors && b->count == 1;
    return line && (hard == 1 || (rows->row.kind == ROW_LIMIT && rows->p > 0)) ? KEEPS_LINE : KEEPS_OTHER;
}

bool group_joints_open(const Group *g)
{
    for (int i = 0; i < g->block_count; i++) {
        const GroupJoint *j = &g->joints[g->blocks[i].joint];
        const JointView *v = &j->view;
        Keeps keeps = what_it_keeps(g, &g->blocks[i]);
        if (keeps == KEEPS_OTHER)
            continue;
        real size = INFINITY, before = vec3_distance(v->a.p, v->b.p);
        vec3 straight[2], a = anchor_after(g, &v->a, j->ra, &size, &straight[0]), b = anchor_after(g, &v->b, j->rb, &size, &straight[1]);
        real opens = vec3_distance(a, b) - before;
        if (keeps == KEEPS_LINE) {
            vec3 line = vec3_sub(v->a.p, v->b.p);
            opens -= vec3_dot(vec3_sub(vec3_sub(straight[0], straight[1]), line), line) / before;
            size = before;
        }
        if (opens > OPENS_MOST * size)
            return true;
    }
    return false;
}

#define GAPING 1e-3             /* of the smallest size: wider gaps of joints are closed before anybody sees them */

bool group_joints_gape(const Group *g)
{
    for (int i = 0; i < g->row_count; i++) {
        const Row *r = &g->rows[i].row;
        real size = INFINITY;
        for (int k = 0; k < r->count; k++)
            size = r->body[k] < 0 ? size : real_min(size, g->member[r->body[k]].outer);
        if (r->kind == ROW_HARD && !r->angular && fabs(r->error) > GAPING * size)
            return true;
    }
    return false;
}
