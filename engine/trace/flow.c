/* trace/flow.c - the motion between events: an explicit Runge-Kutta pair with error control.
 *
 * Order 5 with an embedded order 4 (Dormand & Prince 1980) and its dense output (Hairer, Norsett & Wanner, Solving Ordinary
 * Differential Equations I, II.6). Where forces are constant - free flight, sliding, rolling - an evaluation or two show it, and
 * the motion is the parabola itself.
 */
#include "math/pair.h"
#include "trace/trace.h"

#include <stddef.h>

#define EVEN 1e-9       /* normals that differ by less are one: see patch.c */

static const real node[STAGES] = {0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1, 1};
const real dormand_prince[STAGES][STAGES - 1] = {
    {0},
    {1.0 / 5},
    {3.0 / 40, 9.0 / 40},
    {44.0 / 45, -56.0 / 15, 32.0 / 9},
    {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
    {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
    {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84},
};
static const real error_weight[STAGES] = {71.0 / 57600, 0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200, 22.0 / 525, -1.0 / 40};
const real dormand_prince_dense[STAGES] = {
    -12715105075.0 / 11282082432.0, 0, 87487479700.0 / 32700410799.0, -10690763975.0 / 1880347072.0,
    701980252875.0 / 199316789632.0, -1453857185.0 / 822651844.0, 69997945.0 / 29380423.0,
};

/* ---- state and group ---- */

static vec3 angular_momentum(const Group *g, int i)
{
    const Member *m = &g->member[i];
    return quat_rotate(g->pos[i].q, mat3_mul_vec(*m->inertia, quat_unrotate(g->pos[i].q, g->vel[i].w)));
}

void trace_keep_angles(Tracer *t)
{
    for (int i = 0; i < t->g->joint_count; i++)
        memcpy(t->unwound[i].memory, t->g->joints[i].memory, sizeof t->unwound[i].memory);
}

static Pos mover_at(const Tracer *t, int i, real time)
{
    const Pos *p = &t->mover_start[i];
    const Vel *v = &t->g->vel[i];
    return (Pos){vec3_mad(p->x, time, v->v), quat_unit(quat_mul(quat_exp(vec3_scale(time, v->w)), p->q))};
}

/* Angles unwind from the start of the step: a stage of a step that is refused may have turned anywhere. What is moved along its own way
 * is where it is at the group's time. */
void trace_load(Tracer *t, const State *y, real time)
{
    Group *g = t->g;
    bool later = time != g->t;
    g->t = time;
    t->known = NULL;
    for (int i = 0; i < g->joint_count; i++)
        memcpy(g->joints[i].memory, t->unwound[i].memory, sizeof t->unwound[i].memory);
    for (int i = 0; i < g->body_count; i++) {
        const Member *m = &g->member[i];
        if (m->moves) {
            g->pos[i] = (Pos){y[i].x, quat_unit(y[i].q)};
            g->vel[i].v = y[i].v;
            group_refresh_mass(g, i);
            g->vel[i].w = mat3_mul_vec(g->mass[i].ii, y[i].l);
            t->spin_l[i] = y[i].l;
        } else if (m->kinematic && later) {
            g->pos[i] = mover_at(t, i, time);
        }
    }
}

void trace_store(Tracer *t, State *y)
{
    const Group *g = t->g;
    for (int i = 0; i < g->moving_count; i++) {
        t->spin_l[i] = angular_momentum(g, i);
        y[i] = (State){g->pos[i].x, g->pos[i].q, g->vel[i].v, t->spin_l[i]};
    }
}

/* |q| is 1 within rounding only: without this the bias of w = I^-1 L would add up, frame by frame, to a drift of L. */
void trace_refine(Tracer *t, const State *y)
{
    Group *g = t->g;
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves && !g->member[i].round)
            g->vel[i].w = vec3_add(g->vel[i].w, mat3_mul_vec(g->mass[i].ii, vec3_sub(y[i].l, angular_momentum(g, i))));
}

/* ---- rates ---- */

/* Half of (w, 0) q. */
static quat quat_rate(vec3 w, quat q)
{
    return (quat){0.5 * (w.x * q.w + w.y * q.z - w.z * q.y), 0.5 * (w.y * q.w - w.x * q.z + w.z * q.x),
                  0.5 * (w.x * q.y - w.y * q.x + w.z * q.w), -0.5 * (w.x * q.x + w.y * q.y + w.z * q.z)};
}

/* A direction that is held turns with the plane of its contact: friction has no part along the normal. Points of one patch keep one. */
static void turn_held(Tracer *t, int i)
{
    Touching *c = &t->touch[i];
    const Touching *before = i > 0 && t->touch[i - 1].contact == c->contact ? &t->touch[i - 1] : NULL;
    if (before && before->gate.presses && before->slip.locked && vec3_equal(before->slip.from, c->slip.from) && vec3_distance(before->k.n, c->k.n) < EVEN)
        c->slip.d = before->slip.d;
    else
        c->slip.d = vec3_unit_or(vec3_mad(c->slip.from, -vec3_dot(c->slip.from, c->k.n), c->k.n), c->slip.from);
}

/* Sliding follows the slip through the stages; where that turns round, the sign keeps the rates smooth beyond the stop. */
void trace_follow(Tracer *t)
{
    for (int i = 0; i < t->touch_count; i++) {
        Cone *both[2] = {&t->touch[i].slip, &t->touch[i].roll};
        if (t->passing && !t->touch[i].gate.presses)
            continue;
        if (both[0]->locked && both[0]->grip == GRIP_SLIP)
            turn_held(t, i);
        for (int k = 0; k < 2; k++) {
            Cone *c = both[k];
            real speed = c->axes && c->grip == GRIP_SLIP && !c->locked ? vec3_length(c->u) : 0;
            if (speed > 0)
                c->d = vec3_scale((vec3_dot(c->u, c->from) < 0 ? -1 : 1) / speed, c->u);
        }
    }
}

/* W  What the kinematic ones of a row's bodies give through its force. */
static real driven_power(const Group *g, const Row *r, real force)
{
    real power = 0;
    for (int m = 0; m < r->count; m++) {
        int b = r->body[m];
        if (b >= 0 && g->member[b].kinematic)
            power -= force * (vec3_dot(r->lin[m], g->vel[b].v) + vec3_dot(r->ang[m], g->vel[b].w));
    }
    return power;
}

/* Force and torque of a joint's rows on its body a, and what they take from or give to the energy. */
static Arrow keep_joint(const Tracer *t, int joint, bool movers, real *lost, real *gained)
{
    const Group *g = t->g;
    const real *forces = &t->joint_force[joint * JOINT_SLOTS];
    const Row *r = &t->rows[joint * JOINT_SLOTS], *end = r + t->row_count[joint];
    vec3 lin = vec3_zero(), ang = vec3_zero();
    for (int a = g->joints[joint].a; r < end; r++) {
        real force = forces[r->slot];
        for (int m = 0; m < r->count; m++)
            if (r->body[m] == a && a >= 0) {
                lin = vec3_mad(lin, force, r->lin[m]);
                ang = vec3_mad(ang, force, r->ang[m]);
            }
        if (movers)
            *gained += driven_power(g, r, force);
        if (r->kind == ROW_HARD || r->kind == ROW_LIMIT)
            continue;
        real rate = trace_row_rate(t, r);
        *lost += r->kind == ROW_DRY ? -force * rate : r->kind == ROW_SOFT ? r->damping * rate * rate : 0;
        *gained += r->kind == ROW_MOTOR ? force * rate : 0;
    }
    return (Arrow){lin, ang};
}

static void keep_quad(const Tracer *t, real *q)
{
    const Group *g = t->g;
    real lost = 0, gained = 0, law = 0;
    bool movers = g->joint_count > 0 && trace_movers(g);
    for (int i = 0; i < t->touch_count; i++, q += TOUCH_POWERS) {
        const Touching *c = &t->touch[i];
        vec3 f = c->gate.presses ? vec3_mad(c->slip.force, c->gate.force, c->k.n) : vec3_zero();
        q[0] = f.x;
        q[1] = f.y;
        q[2] = f.z;
        q[3] = c->gate.presses ? c->gate.force : 0;
        q[4] = c->gate.presses ? -vec3_dot(c->slip.force, c->slip.u) - vec3_dot(c->roll.force, c->roll.u) : 0;
        if (!c->gate.presses)
            continue;
        lost += q[4];
        for (int k = 0; k < 2; k++) {
            int b = k ? c->b : c->a;
            if (g->member[b].kinematic) {
                vec3 v = vec3_add(g->vel[b].v, vec3_cross(g->vel[b].w, vec3_sub(c->k.at, g->pos[b].x)));
                gained += (k ? -1 : 1) * (vec3_dot(f, v) + vec3_dot(c->roll.force, g->vel[b].w));
            }
        }
    }
    for (int j = 0; j < g->joint_count; j++, q += JOINT_POWERS) {
        real before = lost;
        Arrow sum = keep_joint(t, j, movers, &lost, &gained);
        memcpy(q, &sum, sizeof sum);
        q[6] = lost - before;
    }
    for (int i = 0; i < g->push_count; i++, q++) {
        const GroupPush *p = &g->pushes[i];
        vec3 arm = p->has_at ? quat_rotate(g->pos[p->body].q, p->at) : vec3_zero();
        *q = vec3_dot(p->force, vec3_add(g->vel[p->body].v, vec3_cross(g->vel[p->body].w, arm))) + vec3_dot(p->torque, g->vel[p->body].w);
        *(p->law ? &law : &gained) += *q;
    }
    for (int i = 0; i < g->moving_count && g->rules; i++)
        law += vec3_dot(g->apart[i].law, g->vel[i].v);
    for (int i = 0; i < g->moving_count && g->drags; i++) {
        const Apart *a = &g->apart[i];
        gained += a->driven;
        lost += a->driven - vec3_dot(a->drag, g->vel[i].v) - vec3_dot(a->drag_torque, g->vel[i].w);
    }
    q[0] = lost;
    q[1] = gained;
    q[2] = law;
}

void trace_keep(Tracer *t, int stage)
{
    const Group *g = t->g;
    State *k = t->stage[stage];
    for (int i = 0; i < g->moving_count; i++)
        k[i] = (State){g->vel[i].v, quat_rate(g->vel[i].w, g->pos[i].q), t->acc[i], t->torque[i]};
    if (stage != 1)             /* has no weight in their means */
        keep_quad(t, t->quad[stage]);
}

static void begin_rate(Tracer *t, const State *y, real time)
{
    trace_load(t, y, time);
    t->g->evaluations++;
    trace_kinematics(t);
    trace_follow(t);
}

bool trace_rate(Tracer *t, const State *y, real time, int stage)
{
    t->passing = stage > 0 && stage < STAGES - 1;
    begin_rate(t, y, time);
    bool solved = t->passing ? trace_solve(t) : trace_accelerate(t);
    t->passing = false;
    if (!solved)
        return false;
    trace_keep(t, stage);
    t->known = y;
    return true;
}

/* ---- what glides ---- */

#define ROUNDING 1e-15          /* rad */
#define TURNED   1e-12          /* rad  so far the friction of a slow slip is turned by rounding */

static bool turns(const Tracer *t, int i, real h)
{
    if (!trace_moves(t, i))
        return !vec3_is_zero(t->g->vel[i].w);
    return h * (vec3_length(t->spin0[i]) + h * vec3_length(t->alpha0[i])) > ROUNDING;
}

static bool keeps_direction(const Cone *c)
{
    return !c->axes || c->grip == GRIP_STICK || (c->grip == GRIP_SLIP && vec3_distance(c->d, c->from) <= TURNED);
}

/* Does a point that presses move along the body whose face it presses on? Its arm there changes: of the edge of a table, say, under a box. */
static bool wanders(const Tracer *t, int point, int face, real h)
{
    if (!trace_moves(t, face))
        return false;
    const Group *g = t->g;
    vec3 away = vec3_sub(g->vel[point].v, g->vel[face].v), acc = vec3_sub(trace_moves(t, point) ? t->stage[0][point].v : vec3_zero(), t->stage[0][face].v);
    return h * (vec3_length(away) + h * vec3_length(acc)) > ROUNDING * t->size;
}

/* Of a step that looks steady, at its end: does nothing turn in it but balls about their centres, and no slip change its direction? Then
 * all arms are what they were, and forces that held at its start hold. */
static bool glides(const Tracer *t, real h)
{
    const Group *g = t->g;
    bool same = t->even && !g->own, any = false;
    for (int i = 0; i < g->body_count && same; i++) {
        bool turned = turns(t, i, h);
        same = !turned || g->member[i].round || i >= g->moving_count;
        any = any || turned;
    }
    for (int i = 0; i < t->touch_count && same; i++) {
        const Touching *c = &t->touch[i];
        bool plane_b = c->feature.kind == POINT_PLANE;
        if (!c->gate.presses)
            continue;
        same = keeps_direction(&c->slip) && keeps_direction(&c->roll) && !wanders(t, plane_b ? c->a : c->b, plane_b ? c->b : c->a, h);
        if (any && same)
            same = !turns(t, plane_b ? c->b : c->a, h) &&
                   (vec3_is_zero(plane_b ? c->feature.pa : c->feature.pb) || !turns(t, plane_b ? c->a : c->b, h));
    }
    return same;
}

/* At the end of a probe: most often by the forces of its start, and of a steady one without a look at them. */
static bool probe_rate(Tracer *t, const State *y, real h, bool steady)
{
    begin_rate(t, y, t->t + h);
    if (!(steady && glides(t, h)) && !trace_again(t) && !trace_accelerate(t))
        return false;
    trace_keep(t, STAGES - 1);
    t->known = y;
    return true;
}

/* ---- constant accelerations ---- */

INLINE vec3 parabola_at(const State *y, const State *k, real h) { return vec3_mad(vec3_mad(y->x, h, y->v), 0.5 * h * h, k->v); }

/* Magnus: the rotation of an angular velocity that grows evenly. */
INLINE quat parabola_turn(const Tracer *t, int i, real h)
{
    vec3 w = t->spin0[i], al = t->alpha0[i];
    vec3 turn = vec3_add(vec3_scale(h, w), vec3_add(vec3_scale(0.5 * h * h, al), vec3_scale(h * h * h / 12, vec3_cross(al, w))));
    return quat_unit(quat_mul(quat_exp(turn), t->y[i].q));
}

static void parabola(const Tracer *t, real h, State *out)
{
    for (int i = 0; i < t->g->moving_count; i++) {
        const State *y = &t->y[i], *k = &t->stage[0][i];
        out[i] = (State){parabola_at(y, k, h), parabola_turn(t, i, h), vec3_mad(y->v, h, k->v), vec3_mad(y->l, h, k->l)};
    }
}

void trace_parabola(Tracer *t, real h)
{
    parabola(t, h, t->y1);
    t->h = t->h_probe = h;
    t->probed = true;
    memcpy(t->quad[STAGES - 1], t->quad[0], (size_t)trace_powers(t) * sizeof *t->quad[0]);
}

#define SAME  0.1       /* of the tolerance: what accelerations that differ by less do in a step; */
#define SAME_AIMED 1e-4 /* in one of the many that may lead from blow to blow within a frame      */

/* Those of the last evaluation and those at the start. */
static bool same_accelerations(const Tracer *t, real h)
{
    real most = (t->aims ? SAME_AIMED : SAME) * t->tolerance / h * t->pace;
    for (int i = 0; i < t->g->moving_count; i++) {
        real arm = t->g->member[i].outer;
        if (vec3_distance(t->acc[i], t->stage[0][i].v) > most || arm * vec3_distance(t->alpha[i], t->alpha0[i]) > most)
            return false;
    }
    return true;
}

/* Forces of joints turn with the bodies. */
#define TURNS  1e-3     /* rad */
#define STEADY 1e-9     /* rad */

static bool may_probe(const Tracer *t, real h)
{
    for (int i = 0; i < t->g->moving_count && t->g->joint_count > 0; i++)
        if (vec3_length(t->spin0[i]) * h > TURNS)
            return false;
    for (int i = 0; i < t->g->moving_count; i++) {
        real bend = vec3_length(vec3_cross(t->alpha0[i], t->spin0[i])) * h * h * h;
        if (bend * t->g->member[i].outer > 0.1 * t->tolerance)
            return false;
    }
    return true;
}

/* ---- the pair ---- */

/* In its loop it stays in registers. */
INLINE State state_mad(const State *a, real h, const State *k)
{
    return (State){vec3_mad(a->x, h, k->x), {a->q.x + h * k->q.x, a->q.y + h * k->q.y, a->q.z + h * k->q.z, a->q.w + h * k->q.w},
                   vec3_mad(a->v, h, k->v), vec3_mad(a->l, h, k->l)};
}

/* The small ones first: their sum is rounded by much less than the state that it is added to. */
static void combine(const Tracer *t, const real *weight, int stages, real h, const State *from, State *out)
{
    static const State none = {.q = {0, 0, 0, 0}};
    for (int i = 0; i < t->g->moving_count; i++) {
        State sum = none;
        for (int s = 0; s < stages; s++)
            if (weight[s] != 0)
                sum = state_mad(&sum, weight[s], &t->stage[s][i]);
        out[i] = state_mad(from ? &from[i] : &none, h, &sum);
    }
}

static real error_of(const Tracer *t, real h)
{
    combine(t, error_weight, STAGES, h, NULL, t->y2);
    real worst = t->swing > t->pace ? trace_swing_error(t, t->y2) : 0;
    for (int i = 0; i < t->g->moving_count; i++) {
        const State *e = &t->y2[i];
        const Member *m = &t->g->member[i];
        real arm = m->outer;
        vec3 dw = mat3_mul_vec(t->g->mass[i].ii, e->l);
        worst = real_max(worst, real_max(vec3_length(e->x), vec3_length(e->v) / t->pace));
        worst = real_max(worst, arm * real_max(2 * sqrt(quat_norm2(e->q)), vec3_length(dw) / t->pace));
    }
    return worst / t->tolerance;
}

/* The stages from `first` on. */
static real pair_step(Tracer *t, real h, int first)
{
    for (int s = first; s < STAGES; s++) {
        State *y = s == STAGES - 1 ? t->y1 : t->y2;
        combine(t, dormand_prince[s], s, h, t->y, y);
        if (!trace_rate(t, y, t->t + node[s] * h, s))
            return INFINITY;
    }
    for (int i = 0; i < t->g->moving_count; i++)
        t->y1[i].q = quat_unit(t->y1[i].q);
    return error_of(t, h);
}

/* Bodies that do not turn, or look the same when they do, on planes that do not turn: the forces of contacts are constant while
 * the kinds are. One probe, at the end, shows whether all others are. */
bool trace_steady(const Tracer *t, real h)
{
    const Group *g = t->g;
    if (g->joint_count > 0 || g->varies)
        return false;
    for (int i = 0; i < g->body_count; i++)
        if (!(g->member[i].moves && g->member[i].round) && vec3_length(g->vel[i].w) * h > STEADY)
            return false;
    for (int i = 0; i < t->touch_count; i++) {
        const Touching *c = &t->touch[i];
        if (c->gate.presses && c->gate.force != 0 && c->feature.kind != POINT_PLANE && c->feature.kind != PLANE_POINT)
            return false;
    }
    return true;
}

/* The pair's first stage is the first probe, too. */
real trace_try(Tracer *t, real h)
{
    t->h = h;
    t->part = 1;
    t->probed = false;
    bool may = t->probe_wait == 0 && may_probe(t, h), steady = may && trace_steady(t, h);
    int first = 1;
    if (!steady) {
        combine(t, dormand_prince[1], 1, h, t->y, t->y2);
        if (!trace_rate(t, t->y2, t->t + node[1] * h, 1))
            return INFINITY;
        first = 2;
    }
    if (steady || (may && same_accelerations(t, h))) {
        parabola(t, h, t->y1);
        if (!probe_rate(t, t->y1, h, steady))
            return INFINITY;
        if (same_accelerations(t, h)) {
            t->probed = true;
            t->h_probe = h;
            t->probe_fails = 0;
            return 0;
        }
        t->probe_wait = int_min(16, (1 << int_min(++t->probe_fails, 5)) - 1);
    }
    return pair_step(t, h, first);
}

/* What the rates at the end of a step leave out of a little more of it is of the second order, and less than rounding. */
#define LITTLE 1e-9             /* rad, of what swings or turns the fastest */

bool trace_stretch(Tracer *t, real more)
{
    const Group *g = t->g;
    real fastest = real_max(t->pace, t->swing);
    for (int i = 0; i < g->body_count; i++)
        fastest = real_max(fastest, vec3_length(g->vel[i].w));
    if (!(fabs(more) * fastest <= LITTLE))
        return false;
    for (int i = 0; i < g->moving_count; i++) {
        t->y1[i] = state_mad(&t->y1[i], more, &t->stage[STAGES - 1][i]);
        t->y1[i].q = quat_unit(t->y1[i].q);
    }
    t->h += more;
    trace_load(t, t->y1, t->t + t->h);
    return true;
}

/* Of the numbers of y from `begin` on. */
INLINE void dense_of(const Tracer *t, real part, int begin, int n, real *o)
{
    const real *y0 = (const real *)(const void *)t->y, *y1 = (const real *)(const void *)t->y1;
    const real *first = (const real *)(const void *)t->stage[0], *last = (const real *)(const void *)t->stage[STAGES - 1];
    real rest = 1 - part;
    for (int i = begin; i < begin + n; i++) {
        real r2 = y1[i] - y0[i], r3 = t->h * first[i] - r2, r4 = r2 - t->h * last[i] - r3, r5 = 0;
        for (int s = 0; s < STAGES; s++)
            r5 += dormand_prince_dense[s] * ((const real *)(const void *)t->stage[s])[i];
        o[i - begin] = y0[i] + part * (r2 + rest * (r3 + part * (r4 + rest * t->h * r5)));
    }
}

void trace_dense(const Tracer *t, real part, State *out)
{
    if (t->probed)
        parabola(t, part * t->h, out);
    else
        dense_of(t, part, 0, t->g->moving_count * STATE_REALS, (real *)(void *)out);
}

/* y2 becomes the end of the tried step, which ends at that part of it; mean forces and powers are those up to there. */
void trace_cut(Tracer *t, real part)
{
    for (int i = 0; i < t->g->moving_count; i++) {
        t->y1[i] = t->y2[i];
        t->y1[i].q = quat_unit(t->y1[i].q);
    }
    t->part = part;
}

Pos trace_place(const Tracer *t, int i, real part, bool turned)
{
    const Member *m = &t->g->member[i];
    if (!m->moves)
        return m->kinematic ? mover_at(t, i, t->t + part * t->h) : t->g->pos[i];
    if (t->probed)
        return (Pos){parabola_at(&t->y[i], &t->stage[0][i], part * t->h), turned ? quat_unit(parabola_turn(t, i, part * t->h)) : quat_identity()};
    struct { vec3 x; quat q; } at;
    _Static_assert(sizeof at == 7 * sizeof(real) && offsetof(State, q) == sizeof(vec3), "as a state begins");
    dense_of(t, part, i * STATE_REALS, 7, (real *)(void *)&at);
    return (Pos){at.x, quat_unit(at.q)};
}
