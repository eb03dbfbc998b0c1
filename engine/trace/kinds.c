/* trace/kinds.c - who presses, sticks or slides now, at the level of accelerations.
 *
 * Everything closed is first taken to press, to stick where it does not move and to slide where it does. Then one gate at a
 * time is opened (it would pull) or closed again (it would sink in), and grips whose force leaves the cone are put on its
 * edge, the brink, until nothing contradicts. On the brink the force's direction is the one the slip is about to take; it is
 * found by a damped fixed point  d <- (rho d + a) / |rho d + a|,  whose damping rho is the acceleration that the whole bound of
 * friction could cause: with less, it diverges wherever the slip is slow to grow.
 *
 * Who pushes in a jerk, at the start of a frame, is found the same way, of impulses and rates.
 */
#include "trace/trace.h"

#define PULLS      1e-9         /* of the largest force: less is rounding           */
#define SINKS      1e-9         /* of the largest acceleration                      */
#define TURNED     1e-10        /* a direction that moves less has settled          */
#define DIRECTIONS 400          /* passes of the fixed point                        */

real trace_acceleration_scale(const Tracer *t)
{
    real most = t->g->fall + 1e-9 * t->size * t->pace * t->pace;
    for (int i = 0; i < t->g->moving_count; i++)
        most = real_max(most, vec3_length(t->acc0[i]));
    return most;
}

/* What pressed up to here and is off by no more than a step's error still does; it is put right as soon as all kinds are known. deep: m
 * or rad, so far beyond may it be. */
static void close_gate(const Tracer *t, Gate *g, real unit, real deep)
{
    real gap = g->presses ? real_max(t->gap_zero, t->tolerance) : t->gap_zero;
    real rate = g->presses ? real_max(t->speed_zero, t->tolerance * t->pace) : t->speed_zero;
    g->closed = g->gap * unit <= gap && g->gap >= -deep && fabs(g->rate) * unit <= rate;
    g->presses = g->closed;
    if (!g->closed)
        g->force = 0;
}

/* What slid before slides on, however slowly: whether it is coming to rest its acceleration will tell. So does what was on the brink and has not moved:
 * to stick may serve as well here, where many share a load, and it would be on the brink again at once, with other forces. */
static void take_grip(Cone *c, real zero)
{
    real speed = vec3_length(c->u);
    c->locked = false;
    if (c->axes && c->grip == GRIP_BRINK && speed <= zero)
        return;
    c->grip = c->axes && (speed > zero || (c->grip == GRIP_SLIP && speed > 1e-6 * zero)) ? GRIP_SLIP : GRIP_STICK;
    if (c->grip == GRIP_SLIP)
        c->d = vec3_scale(1 / speed, c->u);
}

static real arm_term(const Group *g, int body, vec3 at, vec3 e)
{
    vec3 r = vec3_cross(vec3_sub(at, g->pos[body].x), e);
    return g->mass[body].im + vec3_dot(r, mat3_mul_vec(g->mass[body].ii, r));
}

/* 1/kg or 1/(kg m^2)  The largest velocity per impulse along the contact's plane, or spin per angular impulse. */
static real mobility_of(const Group *g, const Touching *c, bool roll)
{
    vec3 e[2];
    real most = 0;
    vec3_basis(c->k.n, &e[0], &e[1]);
    mat3 ii = mat3_add(g->mass[c->a].ii, g->mass[c->b].ii);
    for (int k = 0; k < 2; k++)
        most = real_max(most, arm_term(g, c->a, c->k.at, e[k]) + arm_term(g, c->b, c->k.at, e[k]));
    return roll ? real_max(ii.r0.x, real_max(ii.r1.y, ii.r2.z)) : most;
}

/* What is so slow that it will be held in its direction is so from the first solve on. */
static void lock_slow(Tracer *t, bool first)
{
    t->locks = false;
    for (int i = 0; i < t->touch_count && first; i++) {
        Touching *c = &t->touch[i];
        c->slip.locked = trace_slow_slip(t, c, real_min(t->h_next, t->end));
        t->locks = t->locks || c->slip.locked;
    }
}

#define AT_STOP 1e-9            /* m or rad */

/* A motor without a bound that has got to its stop holds there, and nothing is left to press on the stop. */
static void hold_at_stop(Tracer *t, Hold *h, const Row *r)
{
    bool there = r->error <= AT_STOP;
    h->target = there ? 0 : r->rate;
    for (int i = 0; i < t->stop_count && there; i++)
        if (t->stops[i].joint == h->joint && t->stops[i].slot == h->slot - DRIVE_MOTOR + (r->rate > 0 ? DRIVE_HI : DRIVE_LO))
            t->stops[i].gate.presses = false;
}

/* What is not at its speed pushes with its bound. */
void trace_sides(Tracer *t)
{
    for (int i = 0; i < t->hold_count; i++) {
        Hold *h = &t->holds[i];
        const Row *r = trace_row(t, h->joint, h->slot);
        if (r && isinf(h->most))
            hold_at_stop(t, h, r);
        real off = h->target - h->rate;
        bool lags = fabs(off) * (r && r->angular ? t->size : 1) > t->slip_zero;
        h->side = !lags ? 0 : off > 0 ? 1 : -1;
    }
}

/* One past the last point of the contact that this is the first of. */
static int end_of_contact(const Tracer *t, int first)
{
    int i = first;
    while (i < t->touch_count && t->touch[i].contact == t->touch[first].contact)
        i++;
    return i;
}

/* A joint may bear what the contact does: they share it, as of all rows that repeat others each has its part. */
static bool is_joined(const Tracer *t, const Touching *c)
{
    bool joined = false;
    for (int i = 0; i < t->g->joint_count && !joined; i++) {
        const GroupJoint *j = &t->g->joints[i];
        joined = (trace_moves(t, c->a) && (j->a == c->a || j->b == c->a)) || (trace_moves(t, c->b) && (j->a == c->b || j->b == c->b));
    }
    return joined;
}

#define OVERLAPS 1e-8           /* of the size: what is deeper was pressed, and is to be put right */

/* Faces that touched without a force have none to begin with: they press when they would sink in. A thing between two walls that just
 * fit may be held by any force between these and friction along them; such a force is only there if something calls for it. */
static void leave_idle(Tracer *t)
{
    real most = 0;
    for (int i = 0; i < t->touch_count; i++)
        most = real_max(most, t->touch[i].gate.force);
    for (int i = 0, end; i < t->touch_count; i = end) {
        bool idle = !is_joined(t, &t->touch[i]);
        end = end_of_contact(t, i);
        for (int k = i; k < end; k++) {
            const Gate *g = &t->touch[k].gate;
            idle = idle && !t->touch[k].called && !(g->force > PULLS * most) && g != t->hint.gate && !(g->gap < -OVERLAPS * t->size);
        }
        for (int k = i; k < end; k++) {
            Touching *c = &t->touch[k];
            c->idle = idle && c->gate.closed;
            c->called = !idle;
            c->gate.presses = c->gate.presses && !c->idle;
        }
    }
}

/* Those that would sink in press, with all their points, and all at once. */
static bool call_idle(Tracer *t, real acc_scale)
{
    bool any = false;
    for (int i = 0, end; i < t->touch_count; i = end) {
        bool called = false;
        end = end_of_contact(t, i);
        for (int k = i; k < end; k++)
            called = called || (t->touch[k].idle && t->touch[k].gate.acc < -SINKS * acc_scale);
        for (int k = i; k < end && called; k++) {
            Touching *c = &t->touch[k];
            c->gate.presses = c->gate.presses || c->idle;
            c->idle = false;
            c->called = any = true;
        }
    }
    return any;
}

static void start_kinds(Tracer *t)
{
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        close_gate(t, &c->gate, 1, t->gap_deep);
        c->opened = 0;
        take_grip(&c->slip, t->slip_zero);
        take_grip(&c->roll, t->slip_zero / t->size);
    }
    leave_idle(t);
    for (int i = 0; i < t->stop_count; i++) {
        const Row *r = trace_row(t, t->stops[i].joint, t->stops[i].slot);
        close_gate(t, &t->stops[i].gate, r && r->angular ? t->size : 1, BEYOND);
    }
    trace_sides(t);
}

/* The end is located to the tolerance: a slip that comes to it, too, may have been followed past it by as much, and point the other way. */
static bool ends(const Cone *c) { return vec3_dot(c->acc, c->u) <= 0 || vec3_dot(c->u, c->from) <= 0; }

/* Where one slip comes to its end, those as slow that lose speed end with it: one at a time they would drag each other on. */
static void halt_slow(Tracer *t)
{
    for (int i = 0; i < t->touch_count; i++) {
        Cone *both[2] = {&t->touch[i].slip, &t->touch[i].roll};
        for (int k = 0; k < 2; k++) {
            Cone *c = both[k];
            if (c->axes && c->grip == GRIP_SLIP && vec3_length(c->u) * (k ? t->size : 1) <= 10 * t->slip_zero && ends(c))
                c->grip = GRIP_STICK;
        }
    }
}

#define FAINT      1e-3         /* of the largest normal force of the patch */

static bool sticks(const Touching *c) { return c->gate.presses && c->slip.axes && c->slip.grip == GRIP_STICK; }

/* Tangential load is shared in proportion to the normal forces, so that all corners of a face reach the brink together. What next to
 * nothing presses bears none while two others stick: it would yield again and again on its way to letting go, and nothing moves. */
static bool change_weights(Tracer *t)
{
    bool changed = false;
    for (int i = 0; i < t->touch_count;) {
        int first = i, sticking = 0, strong = 0;
        real most = 0;
        for (int end = end_of_contact(t, first); i < end; i++) {
            const Touching *c = &t->touch[i];
            sticking += sticks(c);
            most = real_max(most, c->gate.presses ? c->gate.force : 0);
        }
        for (int k = first; k < i; k++)
            strong += sticks(&t->touch[k]) && t->touch[k].gate.force >= FAINT * most;
        for (int k = first; k < i && sticking > 1; k++) {
            Cone *c = &t->touch[k].slip;
            real share = t->touch[k].gate.presses && most > 0 ? t->touch[k].gate.force / most : 1;
            real w = share >= FAINT || strong < 2 ? real_max(share, 1e-4) : 0;
            changed = changed || fabs(w - c->weight) > 1e-6;
            c->weight = w;
        }
    }
    return changed;
}

#define NEAR_BOUND 1e-7         /* of the bound */
#define NEAR_ZERO  1e-6         /* of the largest normal force of the patch */

/* Where one point yields, those that are as near to their bound yield with it: one at a time, each would find the other sticking,
 * and at its bound, for ever. Two corners of an edge do, and the two sides of what is alike on both. It itself may be off its bound by the error of
 * the step that leads there. */
static void yield_near(Tracer *t, const Event *e)
{
    real full = e->cone->still * e->normal->force, near = full > 0 ? real_min(1, vec3_length(e->cone->force) / full) * (1 - NEAR_BOUND) : 1;
    for (int i = 0; i < t->touch_count; i++) {
        Cone *c = &t->touch[i].slip;
        real bound = c->still * t->touch[i].gate.force;
        if (sticks(&t->touch[i]) && c->weight > 0 && bound > 0 && vec3_length(c->force) >= bound * near) {
            c->grip = GRIP_BRINK;
            c->d = vec3_unit_or(vec3_neg(c->force), c->d);
        }
    }
}

/* The same of points that let go, by the load that was on their patch as the step began: where all of it goes, the last is rounding. One that is to
 * press is closed again for its acceleration. */
static void open_near(Tracer *t)
{
    for (int i = 0; i < t->touch_count;) {
        int first = i;
        real most = 0;
        for (int end = end_of_contact(t, first); i < end; i++)
            most = real_max(most, t->touch[i].gate.presses ? real_max(t->touch[i].gate.force, t->touch[i].gate.force0) : 0);
        for (int k = first; k < i; k++) {
            Gate *g = &t->touch[k].gate;
            g->presses = g->presses && g->force >= NEAR_ZERO * most;
        }
    }
}

/* The event that brought us here forces its transition: at its exact root both kinds pass every tolerant test. */
static void apply_hint(Tracer *t)
{
    const Event *e = &t->hint;
    switch (e->kind) {
    case EVENT_OPEN:
        open_near(t);
        e->gate->presses = false;
        break;
    case EVENT_PRESS: e->gate->presses = true; break;
    case EVENT_YIELD:
        if (e->cone) {
            if (!(e->cone->weight > 0))
                break;          /* so little presses there that it was let off its share: see change_weights */
            yield_near(t, e);
            e->cone->grip = GRIP_BRINK;
            e->cone->d = vec3_unit_or(vec3_neg(e->cone->force), e->cone->d);
        } else {
            e->hold->side = e->hold->force > 0 ? 1 : -1;
        }
        break;
    case EVENT_HALT:
        if (e->cone)
            halt_slow(t);
        /* fall through */
    case EVENT_GRIP:
        if (e->cone) {
            e->cone->grip = GRIP_STICK;
            e->cone->locked = false;
        } else {
            e->hold->side = 0;
        }
        break;
    default: break;
    }
    t->hint.kind = EVENT_NONE;
}

/* ---- gates: one change at a time ---- */

typedef struct Change { Gate *gate; real worst; bool press; } Change;

static void consider(Change *c, Gate *g, real force_zero, real acc_zero, bool first_wins)
{
    real off = g->presses ? -g->force / force_zero : -g->acc / acc_zero;
    if (!g->closed || off <= 1 || (first_wins && c->gate) || off <= c->worst)
        return;
    *c = (Change){g, off, !g->presses};
}

/* What sticks may pull where what slides presses: the friction that holds it is more than its cone has. One that sinks again when it has let
 * go is such a one. */
static void let_go(Touching *c)
{
    if (c->opened++ > 0 && sticks(c) && vec3_length2(c->slip.force) > 0) {
        c->slip.grip = GRIP_BRINK;
        c->slip.d = vec3_unit_or(vec3_neg(c->slip.force), c->slip.d);
    } else {
        c->gate.presses = false;
    }
}

static bool change_gate(Tracer *t, real acc_scale, bool first_wins)
{
    Change c = {NULL, 0, false};
    real force_zero = PULLS * t->gate_most + 1e-300, acc_zero = SINKS * acc_scale + 1e-300;
    Touching *touching = NULL;
    for (int i = 0; i < t->touch_count; i++) {
        if (!t->touch[i].idle)
            consider(&c, &t->touch[i].gate, force_zero, acc_zero, first_wins);
        touching = c.gate == &t->touch[i].gate ? &t->touch[i] : touching;
    }
    for (int i = 0; i < t->stop_count; i++)
        consider(&c, &t->stops[i].gate, force_zero, acc_zero, first_wins);
    if (!c.gate)
        return false;
    if (touching && c.gate == &touching->gate && !c.press)
        let_go(touching);
    else
        c.gate->presses = c.press;
    return true;
}

/* ---- grips ---- */

static bool leaves_cone(const Cone *c, real normal, real force_zero)
{
    return c->axes && c->grip == GRIP_STICK && vec3_length(c->force) > cone_hold(c, normal) * (1 + 1e-11) + force_zero;
}

/* The normal force of all points of the contact's pair: a patch moves as one. */
static real patch_force(const Tracer *t, int contact)
{
    real sum = 0;
    for (int i = 0; i < t->touch_count; i++)
        if (t->touch[i].contact == contact && t->touch[i].gate.presses)
            sum += real_max(0, t->touch[i].gate.force);
    return sum;
}

/* Points of one patch that slide alike slide the same way: a difference in the last digits would make the rows across the
 * slip contradict each other. */
#define ALIKE 1e-5

void trace_align(Tracer *t)
{
    for (int i = 0; i < t->touch_count; i++) {
        Cone *c = &t->touch[i].slip;
        for (int k = 0; k < i && c->axes && c->grip != GRIP_STICK; k++) {
            const Cone *o = &t->touch[k].slip;
            if (t->touch[k].contact == t->touch[i].contact && o->grip != GRIP_STICK && t->touch[k].gate.presses && vec3_distance(o->d, c->d) < ALIKE) {
                c->d = o->d;
                break;
            }
        }
    }
}

typedef enum Move { MOVE_NONE, MOVE_DIRECTION, MOVE_GRIP } Move;

static Move settle_brink(Cone *c, real rho, real acc_zero)
{
    if (vec3_length(c->acc) <= acc_zero)        /* it does not move: rounding has no direction */
        return MOVE_NONE;
    vec3 v = vec3_mad(c->acc, rho, c->d), d = vec3_unit_or(v, c->d);
    if (vec3_distance(d, c->d) > TURNED) {
        c->d = d;
        return MOVE_DIRECTION;
    }
    if (vec3_dot(c->acc, c->d) < -acc_zero) {
        c->grip = GRIP_STICK;
        return MOVE_GRIP;
    }
    return MOVE_NONE;
}

static Move change_grips(Tracer *t, real acc_scale)
{
    real force_zero = PULLS * t->gate_most;
    Move move = MOVE_NONE;
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        Cone *both[2] = {&c->slip, &c->roll};
        for (int k = 0; k < 2 && c->gate.presses; k++)
            if (leaves_cone(both[k], c->gate.force, force_zero * (k ? t->size : 1))) {
                both[k]->grip = GRIP_BRINK;
                both[k]->d = vec3_unit_or(vec3_neg(both[k]->force), both[k]->d);
                move = MOVE_GRIP;
            }
    }
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        Cone *both[2] = {&c->slip, &c->roll};
        for (int k = 0; k < 2 && c->gate.presses; k++) {
            real unit = k ? t->size : 1;
            bool slow = both[k]->axes && both[k]->grip == GRIP_SLIP && unit * vec3_length(both[k]->u) <= t->slip_zero;
            if (slow && unit * vec3_dot(both[k]->acc, both[k]->d) < -SINKS * acc_scale) {
                both[k]->grip = GRIP_STICK;
                move = MOVE_GRIP;
            }
        }
    }
    for (int i = 0; i < t->hold_count; i++) {
        Hold *h = &t->holds[i];
        real zero = SINKS * acc_scale;
        if (h->side == 0 && fabs(h->force) > h->most * (1 + 1e-11)) {
            h->side = h->force > 0 ? 1 : -1;
            move = MOVE_GRIP;
        } else if (h->side != 0 && fabs(h->rate - h->target) <= t->slip_zero && h->side * h->acc > zero) {
            h->side = 0;
            move = MOVE_GRIP;
        }
    }
    if (move != MOVE_NONE)
        return move;
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        Cone *both[2] = {&c->slip, &c->roll};
        for (int k = 0; k < 2 && c->gate.presses; k++)
            if (both[k]->axes && both[k]->grip == GRIP_BRINK) {
                Move m = settle_brink(both[k], both[k]->still * patch_force(t, c->contact) * mobility_of(t->g, c, k),
                                      SINKS * acc_scale / (k ? t->size : 1));
                move = m > move ? m : move;
            }
    }
    return move;
}

/* What is on the brink and moves on starts to slide. */
static bool start_slips(Tracer *t, real acc_scale)
{
    bool weaker = false;
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        Cone *both[2] = {&c->slip, &c->roll};
        for (int k = 0; k < 2 && c->gate.presses; k++)
            if (both[k]->axes && both[k]->grip == GRIP_BRINK && vec3_length(both[k]->acc) > SINKS * acc_scale / (k ? t->size : 1)) {
                both[k]->grip = GRIP_SLIP;
                both[k]->locked = true;
                weaker = weaker || both[k]->moving != both[k]->still;
            }
    }
    return weaker;
}

#define EASED 1e-3              /* of its friction: with less of it what could move does */

/* What has just come to its bound does not move yet. Where it can, it slides from here on, in the direction it is held in; on the brink through a step
 * it would slide as it likes, with friction in one direction. */
static bool start_loose(Tracer *t, real acc_scale)
{
    real moving[WATCHED][2];        /* of those; else none */
    bool any = false;
    for (int i = 0; i < t->touch_count; i++) {
        Cone *both[2] = {&t->touch[i].slip, &t->touch[i].roll};
        for (int k = 0; k < 2; k++) {
            bool loose = t->touch[i].gate.presses && both[k]->axes && both[k]->grip == GRIP_BRINK;
            moving[i][k] = loose ? both[k]->moving : NAN;
            if (!loose)
                continue;
            any = both[k]->locked = true;
            both[k]->grip = GRIP_SLIP;
            both[k]->moving *= 1 - EASED;
        }
    }
    if (!any)
        return true;
    bool solved = trace_accelerate(t);
    for (int i = 0; i < t->touch_count; i++) {
        Cone *both[2] = {&t->touch[i].slip, &t->touch[i].roll};
        for (int k = 0; k < 2; k++) {
            if (isnan(moving[i][k]))
                continue;
            both[k]->moving = moving[i][k];
            both[k]->locked = solved && vec3_dot(both[k]->acc, both[k]->d) > 10 * SINKS * acc_scale / (k ? t->size : 1);
            both[k]->grip = both[k]->locked ? GRIP_SLIP : GRIP_BRINK;
        }
    }
    if (t->g->status == DIG_OK)
        t->fault = NULL;
    return trace_accelerate(t);
}

bool trace_kinds(Tracer *t, bool first)
{
    int n = t->touch_count + t->stop_count + t->hold_count, directions = 0;
    start_kinds(t);
    change_weights(t);          /* by the forces of before: most often they are those of now */
    lock_slow(t, first);
    if (first && (trace_again(t) || trace_joints_again(t)))
        return true;
    apply_hint(t);
    t->sys.redundant = false;
    real acc_scale = trace_acceleration_scale(t);
    for (int pivots = 0; pivots < 20 + 6 * n && directions < DIRECTIONS; t->g->kind_turns++) {
        trace_align(t);
        if (!trace_accelerate(t))
            return false;
        if (change_gate(t, acc_scale, pivots > 2 * n)) {
            pivots++;
            continue;
        }
        if (change_weights(t)) {
            directions++;
            continue;
        }
        Move move = change_grips(t, acc_scale);
        if (move == MOVE_NONE && call_idle(t, acc_scale)) {
            pivots++;
            continue;
        }
        if (move == MOVE_NONE)
            return (!start_slips(t, acc_scale) || trace_accelerate(t)) && start_loose(t, acc_scale);
        pivots += move == MOVE_GRIP;
        directions += move == MOVE_DIRECTION;
    }
    t->fault = "contacts that find no agreement";
    return false;
}

/* ---- jerks: the same at the level of velocities ---- */

#define JERKED 1e-4             /* of size times pace: velocities less off than that drifted, or another way left them so */

/* m/s  How far velocities are off what joints, and what presses at their stops, allow. */
static real off_speed(const Tracer *t)
{
    real most = 0;
    for (int j = 0; j < t->g->joint_count; j++)
        for (int k = 0; k < t->row_count[j]; k++) {
            const Row *r = &t->rows[j * JOINT_SLOTS + k];
            if (r->kind == ROW_HARD)
                most = real_max(most, fabs(trace_row_rate(t, r)) * (r->angular ? t->size : 1));
        }
    for (int i = 0; i < t->stop_count; i++) {
        const Row *r = t->stops[i].gate.presses ? trace_row(t, t->stops[i].joint, t->stops[i].slot) : NULL;
        if (r)
            most = real_max(most, fabs(t->stops[i].gate.rate) * (r->angular ? t->size : 1));
    }
    return most;
}

/* What presses takes part in a jerk, and what could. false: nothing there has a bound, and all rows are equalities. */
static bool start_jerk(Tracer *t)
{
    bool bounded = false;
    for (int i = 0; i < t->touch_count; i++) {
        Gate *g = &t->touch[i].gate;
        g->closed = g->presses || g->gap <= t->gap_zero;
        t->touch[i].opened = 0;
        bounded = bounded || g->closed;
    }
    for (int i = 0; i < t->stop_count; i++) {
        Gate *g = &t->stops[i].gate;
        g->closed = g->presses || g->gap <= 1e-9;
        bounded = bounded || g->closed;
    }
    for (int i = 0; i < t->hold_count; i++)
        bounded = bounded || (t->holds[i].side == 0 && !isinf(t->holds[i].most));
    return bounded;
}

/* What forces of the frame before give in `time` is added to the impulses of the jerk. */
static void add_lasting(Tracer *t, real time)
{
    Group *g = t->g;
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        if (c->gate.presses)
            c->gate.force += time * real_max(0, contact_memory(&g->contacts[c->contact])[c->point].normal);
    }
    for (int i = 0; i < t->stop_count; i++) {
        Stop *s = &t->stops[i];
        if (s->gate.presses)
            s->gate.force += time * real_max(0, g->joints[s->joint].force[s->slot]);
    }
    for (int i = 0; i < t->hold_count; i++)
        t->holds[i].force += time * g->joints[t->holds[i].joint].force[t->holds[i].slot];
}

/* Those forces, in the place of impulses: they are where the search for kinds begins. */
static void recall_forces(Tracer *t)
{
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        const GroupContact *from = &t->g->contacts[c->contact];
        c->gate.force = contact_memory(from)[c->point].normal;
        c->slip.force = contact_memory(from)[c->point].tangent;
        c->roll.force = c->roll.axes && from->manifold.count == 1 ? contact_rolling(t->g, from) : vec3_zero();
    }
}

/* What sticks or holds and would need more than it has in `time` gives nothing. */
static bool yield_all(Tracer *t, real time)
{
    bool changed = false;
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        Cone *both[2] = {&c->slip, &c->roll};
        for (int k = 0; k < 2 && c->gate.presses; k++)
            if (leaves_cone(both[k], c->gate.force, PULLS * t->gate_most * (k ? t->size : 1))) {
                both[k]->grip = GRIP_SLIP;
                both[k]->locked = false;
                changed = true;
            }
    }
    for (int i = 0; i < t->hold_count; i++) {
        Hold *h = &t->holds[i];
        if (h->side == 0 && !isinf(h->most) && fabs(h->force) > h->most * time) {
            h->side = 1;
            changed = true;
        }
    }
    return changed;
}

static void read_rates(Tracer *t)
{
    trace_kinematics(t);
    for (int i = 0; i < t->touch_count; i++)
        t->touch[i].gate.acc = t->touch[i].gate.rate;
    for (int i = 0; i < t->stop_count; i++)
        t->stops[i].gate.acc = t->stops[i].gate.rate;
}

/* s  The speeds of a mover, one a frame, stand for a smooth motion: what has the force for its share in a frame follows. A hit is none. */
static real smooth_time(const Tracer *t)
{
    const Group *g = t->g;
    bool moved = false, hit = false;
    for (int i = 0; i < g->moving_count; i++) {
        const BodyRest *b = body_rest(g->world, &g->world->bodies.data[g->member[i].slot]);
        hit = hit || vec3_length2(b->hit_v) > 0 || vec3_length2(b->hit_w) > 0;
    }
    for (int i = g->moving_count; i < g->body_count; i++)
        moved = moved || (g->member[i].kinematic && (vec3_length2(g->vel[i].v) > 0 || vec3_length2(g->vel[i].w) > 0));
    return moved && !hit ? t->end : 0;
}

/* Velocities that a script or a mover left apart at the start of the frame: joints share the impulse that mends it, but what presses only
 * pushes, and lets go what leaves it. Forces are impulses here, and accelerations the rates after them. A bounded force gives none over
 * no time. */
bool trace_jerk(Tracer *t)
{
    Group *g = t->g;
    int n = t->touch_count + t->stop_count, pivots = 0, most = 20 + 6 * n + t->hold_count;
    real off = n + t->hold_count > 0 ? off_speed(t) : 0;
    if (!(off > JERKED * t->size * t->pace) || !start_jerk(t))
        return true;
    real kinetic = group_kinetic(g), zero = real_max(0.1 * g->close_speed / SINKS, off), time = smooth_time(t);
    for (; pivots < most; pivots++) {
        if (!trace_project(t, false))
            return false;
        trace_read_forces(t);
        add_lasting(t, time);
        read_rates(t);
        if (!change_gate(t, zero, pivots > 2 * n) && !yield_all(t, time))
            break;
        trace_load(t, t->y, t->t);
        trace_kinematics(t);
    }
    recall_forces(t);
    if (pivots == most) {
        t->fault = "a jerk that finds no agreement";
        return false;
    }
    if (pivots > 0) {           /* else all is as if it were joints: that is put right with what drifted */
        t->conserves = false;
        g->work_in += t->given;
        g->lost += kinetic + t->given - group_kinetic(g);
        trace_store(t, t->y);
    }
    trace_load(t, t->y, t->t);
    trace_kinematics(t);
    trace_sides(t);
    return true;
}
