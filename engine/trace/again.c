/* trace/again.c - do the forces of before still hold?
 *
 * What rests, slides or rolls on needs the same forces in frame after frame, and at both ends of each. To see that they solve the
 * equations of now costs a small part of solving these. They are taken only when they do so to rounding, better than a solve is asked to.
 */
#include "math/pair.h"
#include "trace/trace.h"

#define ROUNDING 1e-15          /* of the largest acceleration or force */
#define FOLLOWS  (1 - 1e-9)     /* cosine */
#define UNSEEN   1e-3           /* of the tolerance: what the accelerations of joints are off by makes no more in a frame */

INLINE void push(Tracer *t, int body, vec3 at, vec3 force, vec3 couple)
{
    const Group *g = t->g;
    if (!trace_moves(t, body))
        return;
    t->acc[body] = vec3_mad(t->acc[body], g->mass[body].im, force);
    t->torque[body] = vec3_add(t->torque[body], vec3_add(couple, vec3_cross(vec3_sub(at, g->pos[body].x), force)));
}

/* Friction points where the slip does now: by as little as rounding from where it did, but a slow slip turns by that. */
INLINE void follow_slip(Cone *c, real normal)
{
    if (c->axes && c->grip == GRIP_SLIP && !c->locked && vec3_dot(c->force, c->d) < -FOLLOWS * vec3_length(c->force))
        c->force = vec3_scale(-cone_bound(c) * normal, c->d);
}

/* False: something that touches pulls. */
static bool put_forces(Tracer *t)
{
    t->gate_most = 0;
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        if (!c->gate.closed || c->idle) {
            c->gate.force = 0;
            c->slip.force = c->roll.force = vec3_zero();
            continue;
        }
        if (!c->gate.presses || !(c->gate.force >= 0))
            return false;
        follow_slip(&c->slip, c->gate.force);
        follow_slip(&c->roll, c->gate.force);
        vec3 force = vec3_mad(c->slip.force, c->gate.force, c->k.n);
        push(t, c->a, c->k.at, vec3_neg(force), vec3_neg(c->roll.force));
        push(t, c->b, c->k.at, force, c->roll.force);
        t->gate_most = real_max(t->gate_most, c->gate.force);
    }
    return t->touch_count > 0;
}

/* unit: m a unit of the cone's motion. Is its force the one that its grip has, and its acceleration the one it leaves? */
INLINE bool cone_holds(const Tracer *t, Cone *c, vec3 n, real normal, real acc_zero, real unit)
{
    real force_zero = ROUNDING * t->gate_most * unit;
    c->lateral = 0;
    if (!c->axes)
        return vec3_length(c->force) <= force_zero;
    if (c->grip == GRIP_STICK)
        return vec3_length(c->force) <= cone_hold(c, normal) && vec3_length(c->acc) * unit <= acc_zero;
    if (c->grip != GRIP_SLIP || vec3_length(c->u) * unit <= t->slip_zero)
        return false;
    vec3 off = vec3_mad(c->force, cone_bound(c) * normal, c->d);
    if (c->locked) {
        vec3 across = vec3_cross(n, c->d);
        c->lateral = vec3_dot(off, across);
        off = vec3_mad(off, -c->lateral, across);
        if (fabs(vec3_dot(c->acc, across)) * unit > acc_zero)
            return false;
    }
    return vec3_length(off) <= force_zero;
}

/* What turns faster and faster by no more than rounding does not: else that would add up from frame to frame, until slips of one body
 * have other directions. */
static void end_noise(Tracer *t, real acc_zero)
{
    const Group *g = t->g;
    for (int i = 0; i < g->moving_count; i++) {
        if (!(vec3_length(t->alpha[i]) * g->member[i].outer <= acc_zero))
            continue;
        t->alpha[i] = vec3_zero();
        t->torque[i] = g->member[i].round ? vec3_zero() : vec3_cross(g->vel[i].w, t->spin_l[i]);
    }
}

bool trace_again(Tracer *t)
{
    const Group *g = t->g;
    if (g->joint_count > 0 || g->planar)
        return false;
    memcpy(t->acc, t->acc0, (size_t)g->moving_count * sizeof *t->acc);
    memcpy(t->torque, t->torque0, (size_t)g->moving_count * sizeof *t->torque);
    if (!put_forces(t))
        return false;
    for (int i = 0; i < g->moving_count; i++)
        t->alpha[i] = trace_spin_up(t, i, t->torque[i]);
    trace_read_accelerations(t);
    real acc_zero = ROUNDING * trace_acceleration_scale(t);
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        if (c->idle && c->gate.acc < -acc_zero)
            return false;
        if (c->gate.closed && !c->idle &&
            !(fabs(c->gate.acc) <= acc_zero && cone_holds(t, &c->slip, c->k.n, c->gate.force, acc_zero, 1) &&
              cone_holds(t, &c->roll, c->k.n, c->gate.force, acc_zero, t->size)))
            return false;
    }
    end_noise(t, acc_zero);
    return true;
}

/* What the forces of the frame before do through the hard rows of a joint. */
static void push_joint(Tracer *t, int joint)
{
    const Group *g = t->g;
    for (int k = 0; k < t->row_count[joint]; k++) {
        const Row *r = &t->rows[joint * JOINT_SLOTS + k];
        if (r->kind != ROW_HARD)
            continue;
        real force = t->joint_force[joint * JOINT_SLOTS + r->slot] = g->joints[joint].force[r->slot];
        for (int m = 0; m < r->count; m++) {
            int b = r->body[m];
            if (!trace_moves(t, b))
                continue;
            t->acc[b] = vec3_mad(t->acc[b], force * g->mass[b].im, r->lin[m]);
            t->torque[b] = vec3_mad(t->torque[b], force, r->ang[m]);
        }
    }
}

/* At a frame's end joints are put right and energy is held, by changes far below the tolerance: so are those of the forces. A frame is
 * begun with them all the same where they leave no more than that at any row. Not in loops: near a singular position rows tell little. */
bool trace_joints_again(Tracer *t)
{
    const Group *g = t->g;
    if (g->joint_count == 0 || t->touch_count + t->stop_count + t->hold_count > 0 || g->planar || trace_has_loop(g))
        return false;
    memcpy(t->acc, t->acc0, (size_t)g->moving_count * sizeof *t->acc);
    memcpy(t->torque, t->torque0, (size_t)g->moving_count * sizeof *t->torque);
    for (int j = 0; j < g->joint_count; j++)
        push_joint(t, j);
    for (int i = 0; i < g->moving_count; i++)
        t->alpha[i] = trace_spin_up(t, i, t->torque[i]);
    real most = UNSEEN * t->tolerance / (t->end * t->end);
    for (int j = 0; j < g->joint_count; j++)
        for (int k = 0; k < t->row_count[j]; k++) {
            const Row *r = &t->rows[j * JOINT_SLOTS + k];
            if (r->kind == ROW_HARD && !(fabs(trace_row_acceleration(t, r)) * (r->angular ? t->size : 1) <= most))
                return false;
        }
    t->gate_most = 0;
    return true;
}
