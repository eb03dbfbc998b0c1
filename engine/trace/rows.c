/* trace/rows.c - the equations at one instant: kinematics of contacts and joints, their rows, forces and accelerations. */
#include "math/pair.h"
#include "trace/trace.h"

/* Part of the largest acceleration by which redundant rows may contradict each other: the stages of a step are off their loops by its
 * local error, and what that does moves nothing. More than this is no drift. */
#define CONTRADICTION 1e-2

Row *trace_row(const Tracer *t, int joint, int slot)
{
    Row *rows = &t->rows[joint * JOINT_SLOTS];
    for (int i = 0; i < t->row_count[joint]; i++)
        if (rows[i].slot == slot)
            return &rows[i];
    return NULL;
}

real trace_row_rate(const Tracer *t, const Row *r) { return group_row_rate(t->g, r); }

/* ---- kinematics ---- */

static void move_joint(Tracer *t, int joint)
{
    Group *g = t->g;
    RowList list = {&t->rows[joint * JOINT_SLOTS], 0, JOINT_SLOTS};
    g->joints[joint].view.followed = true;
    g->joints[joint].view.passing = t->passing;
    g->joints[joint].view.type->rows(&g->joints[joint].view, &list);
    t->row_count[joint] = list.count;
    for (int i = 0; i < list.count && g->planar; i++)
        for (int k = 0; k < list.rows[i].count; k++)
            dir_mask(g, &list.rows[i].lin[k], &list.rows[i].ang[k]);
}

/* Springs and dampers are forces. */
static void push_soft(Tracer *t, const Row *r, real *kept)
{
    real force = -r->stiffness * r->error - r->damping * trace_row_rate(t, r);
    *kept = force;
    for (int k = 0; k < r->count; k++) {
        int b = r->body[k];
        if (!trace_moves(t, b))
            continue;
        t->acc0[b] = vec3_mad(t->acc0[b], force * t->g->mass[b].im, r->lin[k]);
        t->torque0[b] = vec3_mad(t->torque0[b], force, r->ang[k]);
    }
}

static void ask_effects(Tracer *t)
{
    Group *g = t->g;
    dig_status status = group_forces(g);
    if (status != DIG_OK)
        g->status = status;
    for (int i = 0; i < g->moving_count; i++) {
        t->pull[i] = vec3_scale(g->mass[i].im, g->member[i].force);
        t->twist[i] = g->member[i].torque;
        if (g->planar)
            dir_mask(g, &t->pull[i], &t->twist[i]);
    }
    t->pulled = t->even;
}

static void free_motion(Tracer *t)
{
    if (!t->pulled)
        ask_effects(t);
    for (int i = 0; i < t->g->moving_count; i++) {      /* of few bodies: calls to copy them would take longer */
        t->acc0[i] = t->pull[i];
        t->torque0[i] = t->twist[i];
    }
}

void trace_drives(Tracer *t)
{
    for (int i = 0; i < t->stop_count; i++) {
        Stop *s = &t->stops[i];
        const Row *r = trace_row(t, s->joint, s->slot);
        s->gate.gap = r ? r->error : INFINITY;
        s->gate.rate = r ? trace_row_rate(t, r) : 0;
    }
    for (int i = 0; i < t->hold_count; i++) {
        Hold *h = &t->holds[i];
        const Row *r = trace_row(t, h->joint, h->slot);
        h->rate = r ? trace_row_rate(t, r) : h->target;
    }
}

void trace_kinematics(Tracer *t)
{
    Group *g = t->g;
    free_motion(t);
    for (int i = 0; i < g->joint_count; i++)
        group_joint_move(g, i);
    for (int i = 0; i < g->joint_count; i++) {
        move_joint(t, i);
        for (int k = 0; k < t->row_count[i]; k++) {
            const Row *r = &t->rows[i * JOINT_SLOTS + k];
            if (r->kind == ROW_SOFT)
                push_soft(t, r, &t->joint_force[i * JOINT_SLOTS + r->slot]);
        }
    }
    trace_drives(t);
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        if (t->passing && !c->gate.presses)
            continue;           /* where it is, nobody asks before the step ends */
        feature_move(g, &c->feature, c->a, c->b, &c->k);
        c->gate.gap = c->k.gap;
        c->gate.rate = c->k.rate;
        c->slip.u = vec3_mad(c->k.u, -c->k.rate, c->k.n);
        c->roll.u = vec3_sub(g->vel[c->b].w, g->vel[c->a].w);
    }
}

/* ---- rows ---- */

static Line *line_joint(Tracer *t, LineKind kind, int owner, int joint, const Row *r)
{
    Line *l = trace_line(t, kind, owner);
    if (!l)
        return NULL;
    l->slot = joint * JOINT_SLOTS + r->slot;
    l->drift = r->drift;
    l->error = r->error;
    for (int k = 0; k < r->count; k++) {
        if (!trace_moves(t, r->body[k]))
            continue;
        Arrow j = {r->lin[k], r->ang[k]};
        trace_line_push(t, l, r->body[k], &j, &j);
    }
    return l;
}

static int stop_at(const Tracer *t, int joint, int slot)
{
    for (int i = 0; i < t->stop_count; i++)
        if (t->stops[i].joint == joint && t->stops[i].slot == slot)
            return i;
    return -1;
}

static int hold_at(const Tracer *t, int joint, int slot)
{
    for (int i = 0; i < t->hold_count; i++)
        if (t->holds[i].joint == joint && t->holds[i].slot == slot)
            return i;
    return -1;
}

static void joint_lines(Tracer *t, int j, bool positions)
{
    for (int k = 0; k < t->row_count[j]; k++) {
        const Row *r = &t->rows[j * JOINT_SLOTS + k];
        int i;
        if (r->kind == ROW_HARD) {
            line_joint(t, LINE_HARD, j, j, r);
        } else if (r->kind == ROW_LIMIT && (i = stop_at(t, j, r->slot)) >= 0 && t->stops[i].gate.presses) {
            line_joint(t, LINE_STOP, i, j, r);
        } else if (!positions && (r->kind == ROW_MOTOR || r->kind == ROW_DRY) && (i = hold_at(t, j, r->slot)) >= 0 && t->holds[i].side == 0) {
            Line *l = line_joint(t, LINE_HOLD, i, j, r);
            if (l)
                l->want = t->holds[i].target;
        }
    }
}

/* forces: with the columns of sliding friction. */
static void build_lines(Tracer *t, bool forces, bool positions)
{
    t->noted = false;
    t->sys.count = 0;
    t->sys.sliding = false;
    for (int i = 0; i < t->item_count && !t->fault; i++) {
        if (t->item[i] >= 0)
            joint_lines(t, t->item[i], positions);
        else
            trace_patch(t, -1 - t->item[i], forces, positions);
    }
}

/* ---- forces and accelerations ---- */

#define TELLS 1e-4              /* of the largest force on a body: by a part of 1e-9 (kinds.c) of less no one-sided force is told from rounding */

/* N  Balls of a cradle that hang side by side press each other by 1e-31 N or pull by as much: neither is a force. */
static real least_gate_force(const Tracer *t)
{
    real most = 0;
    for (int i = 0; i < t->g->moving_count; i++)
        most = real_max(most, t->g->member[i].mass * vec3_length(t->acc0[i]));
    return TELLS * most;
}

void trace_read_forces(Tracer *t)
{
    t->gate_most = t->gate_least = least_gate_force(t);
    for (int i = 0; i < t->touch_count; i++) {
        t->touch[i].gate.force = t->touch[i].slip.lateral = 0;
        t->touch[i].slip.force = t->touch[i].roll.force = vec3_zero();
    }
    for (int i = 0; i < t->stop_count; i++)
        t->stops[i].gate.force = t->joint_force[t->stops[i].joint * JOINT_SLOTS + t->stops[i].slot] = 0;
    for (int i = 0; i < t->hold_count; i++) {
        Hold *h = &t->holds[i];
        h->force = h->side * h->lag;
        t->joint_force[h->joint * JOINT_SLOTS + h->slot] = h->force;
    }
    for (int i = 0; i < t->sys.count; i++) {
        const Line *l = &t->sys.lines[i];
        real force = t->sys.x[i];
        switch (l->kind) {
        case LINE_NORMAL:
            for (int k = 0; k < l->points; k++)
                t->touch[l->point[k]].gate.force += l->share[k] * force;
            continue;
        case LINE_LATERAL:
            for (int k = 0; k < l->points; k++)
                t->touch[l->point[k]].slip.lateral += vec3_length(l->e[k]) * force;
            /* fall through */
        case LINE_SLIP:
            for (int k = 0; k < l->points; k++)
                t->touch[l->point[k]].slip.force = vec3_mad(t->touch[l->point[k]].slip.force, force, l->e[k]);
            continue;
        case LINE_ROLL:
            t->touch[l->owner].roll.force = vec3_mad(t->touch[l->owner].roll.force, force, l->e[0]);
            continue;
        case LINE_STOP:
            t->stops[l->owner].gate.force = force;
            t->gate_most = real_max(t->gate_most, fabs(force));
            break;
        case LINE_HOLD: t->holds[l->owner].force = force; break;
        case LINE_HARD: break;
        }
        t->joint_force[l->slot] = force;
    }
    for (int i = 0; i < t->touch_count; i++) {      /* sliding friction follows the normal force */
        Touching *c = &t->touch[i];
        if (!c->gate.presses)
            continue;
        t->gate_most = real_max(t->gate_most, fabs(c->gate.force));
        if (c->slip.axes && c->slip.grip != GRIP_STICK)
            c->slip.force = vec3_mad(c->slip.force, -cone_bound(&c->slip) * c->gate.force, c->slip.d);
        if (c->roll.axes && c->roll.grip != GRIP_STICK)
            c->roll.force = vec3_mad(c->roll.force, -cone_bound(&c->roll) * c->gate.force, c->roll.d);
    }
}

INLINE vec3 point_acceleration(const Tracer *t, int body, vec3 at)
{
    if (!trace_moves(t, body))
        return vec3_zero();
    return vec3_add(t->acc[body], vec3_cross(t->alpha[body], vec3_sub(at, t->g->pos[body].x)));
}

real trace_row_acceleration(const Tracer *t, const Row *r)
{
    real a = r->drift;
    for (int k = 0; k < r->count; k++)
        if (trace_moves(t, r->body[k]))
            a += vec3_dot(r->lin[k], t->acc[r->body[k]]) + vec3_dot(r->ang[k], t->alpha[r->body[k]]);
    return a;
}

/* Of the bodies at a point, b against a. */
INLINE vec3 parting_acceleration(const Tracer *t, const Touching *c)
{
    return vec3_sub(point_acceleration(t, c->b, c->k.at), point_acceleration(t, c->a, c->k.at));
}

real trace_gap_acceleration(const Tracer *t, const Touching *c) { return vec3_dot(c->k.n, parting_acceleration(t, c)) + c->k.drift_n; }

void trace_read_accelerations(Tracer *t)
{
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        if (!c->gate.closed)
            continue;
        vec3 a = parting_acceleration(t, c);
        c->gate.acc = vec3_dot(c->k.n, a) + c->k.drift_n;
        a = vec3_add(a, c->k.drift);
        c->slip.acc = vec3_mad(a, -vec3_dot(c->k.n, a), c->k.n);
        vec3 aa = trace_moves(t, c->a) ? t->alpha[c->a] : vec3_zero(), ab = trace_moves(t, c->b) ? t->alpha[c->b] : vec3_zero();
        c->roll.acc = vec3_sub(ab, aa);
    }
    for (int i = 0; i < t->stop_count; i++) {
        const Row *r = trace_row(t, t->stops[i].joint, t->stops[i].slot);
        t->stops[i].gate.acc = r ? trace_row_acceleration(t, r) : 0;
    }
    for (int i = 0; i < t->hold_count; i++) {
        const Row *r = trace_row(t, t->holds[i].joint, t->holds[i].slot);
        t->holds[i].acc = r ? trace_row_acceleration(t, r) : 0;
    }
}

/* alpha = I^-1 (tau - w x L) */
vec3 trace_spin_up(const Tracer *t, int i, vec3 torque)
{
    const Group *g = t->g;
    if (!g->member[i].round && !g->planar)
        torque = vec3_sub(torque, vec3_cross(g->vel[i].w, t->spin_l[i]));
    return mat3_mul_vec(g->mass[i].ii, torque);
}

/* Saturated motors and friction of joints push as forces. */
static void push_holds(Tracer *t)
{
    for (int i = 0; i < t->hold_count; i++) {
        const Hold *h = &t->holds[i];
        const Row *r = h->side ? trace_row(t, h->joint, h->slot) : NULL;
        for (int k = 0; r && k < r->count; k++) {
            int b = r->body[k];
            if (!trace_moves(t, b))
                continue;
            t->acc[b] = vec3_mad(t->acc[b], h->side * h->lag * t->g->mass[b].im, r->lin[k]);
            t->torque[b] = vec3_mad(t->torque[b], h->side * h->lag, r->ang[k]);
        }
    }
}

/* A linear and an angular vector, two numbers at a time, like those of an Arrow. */
typedef struct Six { pair p[3]; } Six;

static inline Six six_of(vec3 lin, vec3 ang) { return (Six){{{lin.x, lin.y}, {lin.z, ang.x}, {ang.y, ang.z}}}; }

static inline real dot_arrow(const Six *s, const Arrow *arrow)
{
    const real *a = &arrow->lin.x;
    pair sum = s->p[0] * two(a) + s->p[1] * two(a + 2) + s->p[2] * two(a + 4);
    return sum[0] + sum[1];
}

static inline void add_arrow(Six *s, real factor, const Arrow *arrow)
{
    const real *a = &arrow->lin.x;
    pair f = {factor, factor};
    for (int i = 0; i < 3; i++)
        s->p[i] += f * two(a + 2 * i);
}

/* The accelerations that are missing at the rows, which follow each other in runs on the same bodies. */
static void right_side(Tracer *t)
{
    System *s = &t->sys;
    for (int i = 0; i < s->count; i++)
        s->b[i] = -s->lines[i].drift;
    for (int i = 0; i < s->count; i = s->run[i])
        for (int k = 0; k < s->lines[i].count; k++) {
            int body = s->lines[i].body[k];
            const Six a = six_of(t->acc[body], t->alpha[body]);
            for (int r = i; r < s->run[i]; r++)
                s->b[r] -= dot_arrow(&a, &s->lines[r].j[k]);
        }
}

/* What the rows' forces do to the bodies. */
static void push_bodies(Tracer *t)
{
    const System *s = &t->sys;
    for (int i = 0; i < s->count; i = s->run[i])
        for (int k = 0; k < s->lines[i].count; k++) {
            int body = s->lines[i].body[k];
            Six a = six_of(t->acc[body], t->alpha[body]);
            vec3 torque = t->torque[body];
            for (int r = i; r < s->run[i]; r++) {
                add_arrow(&a, s->x[r], &s->lines[r].m[k]);
                torque = vec3_mad(torque, s->x[r], s->lines[r].gang[k]);
            }
            t->acc[body] = (vec3){a.p[0][0], a.p[0][1], a.p[1][0]};
            t->alpha[body] = (vec3){a.p[1][1], a.p[2][0], a.p[2][1]};
            t->torque[body] = torque;
        }
}

bool trace_solve(Tracer *t)
{
    Group *g = t->g;
    System *s = &t->sys;
    for (int i = 0; i < g->moving_count; i++) {
        t->acc[i] = t->acc0[i];
        t->torque[i] = t->torque0[i];
    }
    push_holds(t);
    for (int i = 0; i < g->moving_count; i++)
        t->alpha[i] = trace_spin_up(t, i, t->torque[i]);
    bool regular = t->noted && trace_rows_stay(t);
    if (!regular) {
        build_lines(t, true, false);
        if (t->fault)
            return false;
        regular = s->count == 0 || system_factor(s);
        trace_note_rows(t, regular);
    }
    if (s->count > 0) {
        right_side(t);
        if (!regular || !system_solve(s, CONTRADICTION)) {
            t->fault = "rows that contradict each other";
            return false;
        }
        g->residual = real_max(g->residual, s->residual);
    }
    trace_read_forces(t);
    push_bodies(t);
    return true;
}

bool trace_accelerate(Tracer *t)
{
    if (!trace_solve(t))
        return false;
    trace_read_accelerations(t);
    return true;
}

/* ---- what drifts is put back ---- */

Violation trace_violation(const Tracer *t)
{
    Violation v = {0, 0};
    for (int i = 0; i < t->g->joint_count; i++)
        for (int k = 0; k < t->row_count[i]; k++) {
            const Row *r = &t->rows[i * JOINT_SLOTS + k];
            real unit = r->angular ? t->size : 1;
            if (r->kind == ROW_HARD)
                v.joints = real_max(v.joints, unit * real_max(fabs(r->error), fabs(trace_row_rate(t, r)) / t->pace));
        }
    for (int i = 0; i < t->stop_count; i++)
        if (t->stops[i].gate.presses)
            v.gates = real_max(v.gates, real_max(fabs(t->stops[i].gate.gap), fabs(t->stops[i].gate.rate) / t->pace));
    for (int i = 0; i < t->touch_count; i++) {
        const Touching *c = &t->touch[i];
        if (!c->gate.presses)
            continue;
        v.gates = real_max(v.gates, real_max(fabs(c->gate.gap), fabs(c->gate.rate) / t->pace));
        if (c->slip.axes && c->slip.grip == GRIP_STICK)
            v.gates = real_max(v.gates, vec3_length(c->slip.u) / t->pace);
        if (c->roll.axes && c->roll.grip == GRIP_STICK)
            v.gates = real_max(v.gates, t->size * vec3_length(c->roll.u) / t->pace);
    }
    return v;
}

/* What the rows' impulses do to velocities, or to places: each body once for a run of rows. */
static void shift_bodies(Tracer *t, bool positions)
{
    Group *g = t->g;
    const System *s = &t->sys;
    for (int i = 0; i < s->count; i = s->run[i])
        for (int k = 0; k < s->lines[i].count; k++) {
            int b = s->lines[i].body[k];
            vec3 move = vec3_zero(), turn = vec3_zero();
            for (int r = i; r < s->run[i]; r++) {
                move = vec3_mad(move, s->x[r], s->lines[r].m[k].lin);
                turn = vec3_mad(turn, s->x[r], s->lines[r].m[k].ang);
            }
            if (positions) {
                g->pos[b].x = vec3_add(g->pos[b].x, move);
                g->pos[b].q = quat_unit(quat_mul(quat_exp(turn), g->pos[b].q));
            } else {
                g->vel[b].v = vec3_add(g->vel[b].v, move);
                g->vel[b].w = vec3_add(g->vel[b].w, turn);
            }
        }
}

/* The rate of a row that should be what it wants: against what moves by itself, too. */
static real off_rate(const Tracer *t, const Line *l)
{
    real off = 0;
    switch (l->kind) {
    case LINE_NORMAL:
        for (int k = 0; k < l->points; k++)
            off += l->share[k] * t->touch[l->point[k]].gate.rate;
        return off;
    case LINE_SLIP:
    case LINE_LATERAL:
        for (int k = 0; k < l->points; k++)
            off += vec3_dot(l->e[k], t->touch[l->point[k]].slip.u);
        return off;
    case LINE_ROLL: return vec3_dot(l->e[0], t->touch[l->owner].roll.u);
    default: return trace_row_rate(t, trace_row(t, l->slot / JOINT_SLOTS, l->slot % JOINT_SLOTS)) - l->want;
    }
}

/* What those that impulses move have of a row's rate; movers and motors have the rest. */
static real own_rate(const Tracer *t, const Line *l)
{
    real rate = 0;
    for (int k = 0; k < l->count; k++) {
        const Vel *v = &t->g->vel[l->body[k]];
        rate += vec3_dot(l->j[k].lin, v->v) + vec3_dot(l->j[k].ang, v->w);
    }
    return rate;
}

bool trace_movers(const Group *g)
{
    for (int i = g->moving_count; i < g->body_count; i++)
        if (g->member[i].kinematic)
            return true;
    return false;
}

bool trace_project(Tracer *t, bool positions)
{
    System *s = &t->sys;
    build_lines(t, false, positions);
    t->given = 0;
    if (s->count == 0 || t->fault)
        return !t->fault;
    for (int i = 0; i < s->count; i++) {
        const Line *l = &s->lines[i];
        s->b[i] = -(positions ? l->error : off_rate(t, l));
    }
    if (!system_factor(s) || !system_solve(s, INFINITY)) {        /* passes are repeated until nothing is off */
        t->fault = "rows that contradict each other";
        return false;
    }
    bool driven = !positions && (t->hold_count > 0 || trace_movers(t->g));
    for (int i = 0; i < s->count && driven; i++)
        t->given += s->x[i] * (own_rate(t, &s->lines[i]) + s->b[i]);
    shift_bodies(t, positions);
    return true;
}
