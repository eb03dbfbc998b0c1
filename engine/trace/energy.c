/* trace/energy.c - mechanisms that nothing drives or brakes keep their energy to rounding, frame after frame.
 *
 * The pair's local error is far below the tolerance, but it has a sign: over a million frames a pendulum's energy would drift. At
 * the end of a frame in which only hard joints, undamped springs and an even field acted, the velocities are scaled so that the
 * energy is that at its start (Hairer, Lubich & Wanner, Geometric Numerical Integration, IV.4: projection on an invariant). A
 * scaled velocity obeys every joint that the velocity obeyed. Mechanisms that hang on nothing are scaled in their motion relative
 * to the rigid one with the same momentum and angular momentum, so that these stay, too; and before that the rigid motion is given the
 * angular momentum of the frame's start, for the pair keeps no invariant but the linear ones. What the local errors of its steps may
 * be, the change may be, and no more: what asks for more is no error of the integration. What hangs on something is moved along its
 * velocities, too, the more the nearer it is to turning back: there is little velocity to scale, and its time would be lost.
 */
#include "base/forest.h"
#include "solve/momentum.h"
#include "trace/trace.h"

#define NOISE 1e-14             /* of the energies in the sum: less may be rounding...  */
#define BRISK 1e-6              /* ...which disturbs only what has less kinetic energy  */
#define HARMONIC 3              /* of a swing: local errors are of high derivatives, and these of its higher harmonics */
#define STANDING 1e-3           /* of the speed of the swing */
#define GENTLE 0.1              /* of the kinetic energy: more is not made good        */

/* Mechanisms, by their lowest body; moving_count stands for all that does not move. */
static void find_mechanisms(Tracer *t)
{
    const Group *g = t->g;
    int n = g->moving_count;
    for (int i = 0; i <= n; i++) {
        t->root[i] = i;
        t->held[i] = false;
    }
    for (int j = 0; j < g->joint_count; j++)
        for (int k = 0; k < t->row_count[j]; k++) {
            const Row *r = &t->rows[j * JOINT_SLOTS + k];
            int first = -1;
            for (int m = 0; m < r->count; m++) {
                if (!trace_moves(t, r->body[m]))
                    continue;
                if (first >= 0)
                    forest_unite(t->root, first, r->body[m]);
                first = r->body[m];
            }
        }
    for (int i = 0; i < n; i++)
        t->root[i] = forest_root(t->root, i);
    for (int j = 0; j < g->joint_count; j++) {
        int a = g->joints[j].a, b = g->joints[j].b;
        if (trace_moves(t, a) == trace_moves(t, b))
            continue;
        int root = t->root[trace_moves(t, a) ? a : b];
        t->held[root] = true;
        t->anchor[root] = trace_moves(t, a) ? g->joints[j].view.b.p : g->joints[j].view.a.p;
    }
}

/* Is all that acts a joint, a contact, or the same force wherever bodies go? */
static bool keeps_turning(const Tracer *t)
{
    const Group *g = t->g;
    if (!group_isolated(g))
        return false;
    for (int i = g->moving_count; i < g->body_count; i++)
        if (g->member[i].kinematic && (vec3_length2(g->vel[i].v) > 0 || vec3_length2(g->vel[i].w) > 0))
            return false;
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves && vec3_length2(t->twist[i]) > 0)
            return false;
    return true;
}

/* ... and is it a hard joint, or an undamped spring of known energy? */
static bool conserves(const Tracer *t)
{
    const Group *g = t->g;
    if (g->joint_count == 0 || g->stores || t->hold_count > 0)
        return false;
    for (int j = 0; j < g->joint_count; j++)
        for (int k = 0; k < t->row_count[j]; k++) {
            const Row *r = &t->rows[j * JOINT_SLOTS + k];
            if (r->kind == ROW_SOFT && (r->damping != 0 || !g->joints[j].view.type->energy))
                return false;
        }
    return true;
}

/* Energy in springs, by mechanism. */
static void add_springs(const Tracer *t, real sign, real *sum)
{
    const Group *g = t->g;
    for (int j = 0; j < g->joint_count; j++) {
        const GroupJoint *joint = &g->joints[j];
        int body = trace_moves(t, joint->a) ? joint->a : joint->b;
        if (joint->stores && trace_moves(t, body))
            sum[t->root[body]] += sign * group_spring_energy(joint);
    }
}

/* At the start of the frame, once its joints were viewed and the forces are known. */
void trace_mark_energy(Tracer *t)
{
    t->turns = keeps_turning(t);
    t->conserves = t->turns && conserves(t);
    if (!t->turns)
        return;
    find_mechanisms(t);
    memset(t->gain, 0, (size_t)t->g->moving_count * sizeof *t->gain);
    add_springs(t, -1, t->gain);
}

/* The way that conserves energy ends on the joints in place, not in velocity: some of its energy is across them (engine/conserve/step.c).
 * Not where something pressed, was hit or given a speed: those jerks are real. */
bool trace_mirrored(const Tracer *t)
{
    for (int i = 0; i < t->touch_count; i++)
        if (t->touch[i].gate.presses)
            return false;
    for (int i = 0; i < t->stop_count; i++)
        if (t->stops[i].gate.presses)
            return false;
    return t->conserves && !group_joints_broken(t->g);
}

void trace_mark_motion(Tracer *t)
{
    for (int i = 0; i < t->g->moving_count; i++)
        t->motion[i] = t->root[i] == i ? mechanism_kinetic(t->g, t->root, i) : 0;
}

bool trace_hold_motion(Tracer *t)
{
    for (int i = 0; i < t->g->moving_count; i++)
        if (t->root[i] == i && t->g->member[i].moves && !mechanism_hold_kinetic(t->g, t->root, i, !t->held[i], t->motion[i], GENTLE))
            return false;
    return true;
}

static real kinetic_of(const Member *m, quat q, vec3 v, vec3 w)
{
    vec3 l = quat_unrotate(q, w);
    return 0.5 * m->mass * vec3_length2(v) + 0.5 * vec3_dot(l, mat3_mul_vec(*m->inertia, l));
}

/* power: W  of what acts; reach: m  from where it hangs to its farthest point */
typedef struct Mechanism { real gain, scale, kinetic, power, reach; Rigid rigid; } Mechanism;
typedef struct Shift { real faster, later; } Shift;     /* of the velocities; s  along them */

/* The motion v of body i, and what takes part in it. */
static void add_motion(const Tracer *t, int i, const Vel *v, bool held, Mechanism *sum)
{
    const Member *m = &t->g->member[i];
    quat q = t->g->pos[i].q;
    vec3 turning = quat_unrotate(q, v->w), l = mat3_mul_vec(*m->inertia, turning);
    sum->kinetic += 0.5 * (m->mass * vec3_length2(v->v) + vec3_dot(turning, l));
    if (!held)
        return;
    sum->reach = real_max(sum->reach, vec3_distance(t->g->pos[i].x, t->anchor[t->root[i]]) + m->outer);
    sum->power += m->mass * vec3_dot(v->v, t->acc[i]) + vec3_dot(l, quat_unrotate(q, t->alpha[i]));
}

/* What body i gained since the start of the frame. */
static void add_gain(const Tracer *t, int i, Mechanism *sum)
{
    const Group *g = t->g;
    const Member *m = &g->member[i];
    const Body *b = &g->world->bodies.data[m->slot];    /* as it was before the step */
    real before = kinetic_of(m, b->q, b->v, b->w), after = kinetic_of(m, g->pos[i].q, g->vel[i].v, g->vel[i].w);
    sum->gain += after - before - m->mass * vec3_dot(t->pull[i], vec3_sub(g->pos[i].x, b->x));
    sum->scale += after + m->mass * vec3_length(t->pull[i]) * vec3_length(b->x);
}

static Vel relative(const Tracer *t, int i, const Rigid *m)
{
    const Vel *v = &t->g->vel[i];
    vec3 arm = vec3_sub(t->g->pos[i].x, m->at);
    return (Vel){vec3_sub(v->v, vec3_add(m->v, vec3_cross(m->w, arm))), vec3_sub(v->w, m->w)};
}

/* One body on which nothing pressed or pulled: its momenta are its state, and all its motion is rigid. */
static bool flies_alone(const Tracer *t, int root)
{
    for (int i = root + 1; i < t->g->moving_count; i++)
        if (t->root[i] == root)
            return false;
    return !t->held[root];
}

/* Where it turns back, velocities are too small for the change: it is moved along its accelerations instead, of which m a is the sum of
 * all that acts but for joints, which do no work. Only what hangs on something: what floats turns on about itself. */
static void move_mechanism(Tracer *t, int root, real gain)
{
    Group *g = t->g;
    real work = 0, farthest = 0;        /* J, m per s^2 */
    for (int i = root; i < g->moving_count; i++) {
        if (t->root[i] != root)
            continue;
        work += 2 * kinetic_of(&g->member[i], g->pos[i].q, t->acc[i], t->alpha[i]);
        farthest = real_max(farthest, vec3_length(t->acc[i]) + g->member[i].outer * vec3_length(t->alpha[i]));
    }
    if (!t->held[root] || !(work > 0) || !(fabs(gain) * farthest <= t->tolerance * work))      /* none: it hangs in balance */
        return;
    real far = gain / work;
    for (int i = root; i < g->moving_count; i++) {
        if (t->root[i] != root)
            continue;
        g->pos[i].x = vec3_mad(g->pos[i].x, far, t->acc[i]);
        g->pos[i].q = quat_unit(quat_mul(quat_exp(vec3_scale(far, t->alpha[i])), g->pos[i].q));
    }
}

/* The change that takes the energy back, along the velocities, which obey all joints. Nearly all of it is theirs; but scaled velocities
 * alone shift a swing in time where it turns back, by the error of its energy over what is left of its speed. So within the time there
 * that its local errors belong to, its place changes instead. Not of stiff springs, whose energy a place tells to its rounding only. */
static bool find_shift(const Tracer *t, const Mechanism *m, Shift *out)
{
    real rate = m->reach > 0 && t->g->fall > 0 ? HARMONIC * sqrt(t->g->fall / m->reach) : t->pace;
    real twice = 2 * m->kinetic, turn = t->swing > rate ? 0 : fabs(m->power) / rate;
    if (!(twice > STANDING * turn))             /* what joints leave to rounding tells their direction by then */
        return false;
    real over = turn / twice, places = over * over * over * over, part = m->gain / (1 + places);
    if (!(fabs(part) <= GENTLE * m->kinetic))
        return false;
    *out = (Shift){sqrt(1 - part / m->kinetic) - 1, turn > 0 ? places * part / m->power : 0};
    return true;
}

static void hold_mechanism(Tracer *t, int root)
{
    Group *g = t->g;
    if (flies_alone(t, root))
        return;
    Mechanism m = {.gain = t->gain[root]};
    real allowed = 0;           /* J  what local errors of the tolerance do */
    real pace = real_max(t->pace, t->swing), steps = real_max(1, g->substeps);
    if (!t->held[root]) {
        rigid_motion(g, t->root, root, &m.rigid);
        rigid_hold_turning(g, t->root, root, t->tolerance, &m.rigid);
    }
    if (!t->conserves || g->located > 0)
        return;
    for (int i = root; i < g->moving_count; i++)
        if (t->root[i] == root)
            add_gain(t, i, &m);
    for (int i = root; i < g->moving_count; i++) {
        if (t->root[i] != root)
            continue;
        Vel own = relative(t, i, &m.rigid);
        add_motion(t, i, &own, t->held[root], &m);
        real speed = vec3_length(own.v) + g->member[i].outer * vec3_length(own.w);
        allowed += steps * g->member[i].mass * t->tolerance * (vec3_length(t->pull[i]) + pace * speed);
    }
    bool known = m.kinetic > BRISK * m.scale || fabs(m.gain) > NOISE * m.scale;
    if (!known || !(fabs(m.gain) <= allowed))
        return;
    Shift shift;
    if (!find_shift(t, &m, &shift)) {
        move_mechanism(t, root, m.gain);
        return;
    }
    for (int i = root; i < g->moving_count; i++) {
        if (t->root[i] != root)
            continue;
        Vel own = relative(t, i, &m.rigid);
        g->vel[i].v = vec3_mad(g->vel[i].v, shift.faster, own.v);
        g->vel[i].w = vec3_mad(g->vel[i].w, shift.faster, own.w);
        g->pos[i].x = vec3_mad(g->pos[i].x, shift.later, own.v);
        if (shift.later != 0)
            g->pos[i].q = quat_unit(quat_mul(quat_exp(vec3_scale(shift.later, own.w)), g->pos[i].q));
    }
}

/* What pressed on each other in the frame has one angular momentum. */
static void join_touching(Tracer *t)
{
    const Group *g = t->g;
    for (int i = 0; i < g->contact_count; i++) {
        int a = g->contacts[i].a, b = g->contacts[i].b;
        bool one = trace_moves(t, a), other = trace_moves(t, b);
        if (vec3_is_zero(g->acted[i].impulse) || !(one || other))
            continue;
        if (one && other)
            forest_unite(t->root, a, b);
        else
            t->held[forest_root(t->root, one ? a : b)] = true;
    }
    for (int i = 0; i < g->moving_count; i++) {
        int root = forest_root(t->root, i);
        t->held[root] = t->held[root] || t->held[i];
        t->gain[root] += root == i ? 0 : t->gain[i];
        t->root[i] = root;
    }
}

/* At the end of the frame. Whatever else gave or took energy in it is in the books. */
void trace_hold_energy(Tracer *t)
{
    Group *g = t->g;
    if (!t->turns)
        return;
    join_touching(t);
    for (int i = 0; i < g->joint_count; i++)
        if (g->joints[i].stores)
            group_joint_view(g, i);
    add_springs(t, 1, t->gain);
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves && t->root[i] == i)
            hold_mechanism(t, i);
}
