/* trace/suits.c - which groups the traced way takes. */
#include "base/forest.h"
#include "trace/trace.h"

#define FAST_LOOP  0.3          /* rad in a step */
#define LOOP_MOST  1e-10        /* of the size: a slow loop followed so closely is on its joints in singular positions, too */
#define LOOP_WORK  2000         /* evaluations in a frame that these may take: a plan with less does not trace them */
#define LOOP_LEAST 1e-12        /* of the size: finer steps of a loop come so near to singular positions that rounding leads on there */
#define LOOP_BODIES 128         /* more than any plan traces */

/* Is joint j one more of those that hold the same two bodies, as the hinges of a door do? What each of them allows is a group of motions,
 * and so is what all of them allow: of as many axes everywhere. No loop in the sense below. */
static bool repeats(const Group *g, int j)
{
    for (int i = 0; i < j && g->joints[j].view.type->lower_pair; i++)
        if (g->joints[i].a == g->joints[j].a && g->joints[i].b == g->joints[j].b && g->joints[i].view.type->lower_pair)
            return true;
    return false;
}

/* Do the joints close a loop, by themselves or through what does not move? Loops pass through singular positions; the way that
 * holds joints in place passes them better than this one, which holds accelerations, unless they turn fast against the step, or its own
 * steps are fine: then it passes them, and at less cost than the other, whose error no estimate controls. */
bool trace_has_loop(const Group *g)
{
    int parent[LOOP_BODIES + 1];
    if (g->moving_count > LOOP_BODIES)
        return true;
    for (int i = 0; i <= g->moving_count; i++)
        parent[i] = i;
    for (int j = 0; j < g->joint_count; j++) {
        const JointType *type = g->joints[j].view.type;
        if (type->free_axes == 6 || type->couples || (type->only_limits && type->only_limits(g->joints[j].view.params)))
            continue;
        int a = g->joints[j].a, b = g->joints[j].b, n = g->moving_count;
        a = forest_root(parent, a >= 0 && a < n && g->member[a].moves ? a : n);
        b = forest_root(parent, b >= 0 && b < n && g->member[b].moves ? b : n);
        if (a == b && !repeats(g, j))
            return true;
        parent[a] = b;
    }
    return false;
}

static real fastest_spin(const Group *g)
{
    real w = 0;
    for (int i = 0; i < g->moving_count; i++)
        w = real_max(w, vec3_length2(g->vel[i].w));
    return sqrt(w);
}

static bool is_slow_loop(const Group *g)
{
    return g->joint_count > 0 && g->pair_count == 0 && trace_has_loop(g) && fastest_spin(g) * g->world->def.step < FAST_LOOP;
}

real trace_tolerance(const Group *g)
{
    if (g->tolerance > LOOP_MOST && g->plan->trace_work >= LOOP_WORK && is_slow_loop(g))
        return LOOP_MOST;
    return g->tolerance < LOOP_LEAST && trace_has_loop(g) ? LOOP_LEAST : g->tolerance;
}

bool trace_suits(const Group *g)
{
    const AccuracyPlan *p = g->plan;
    if (g->moving_count > p->trace_bodies || g->decay_friction || g->trace_wait > 0 || !g->may_trace)
        return false;
    if (p->trace_bodies == 1 && g->joint_count > 0)     /* one that hangs has ways of its own, or is conserved for less */
        return false;
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves && g->member[i].integrator != DIG_AUTO)
            return false;
    if (p->trace_work < LOOP_WORK && is_slow_loop(g))
        return false;
    for (int i = 0; i < g->pair_count; i++) {
        const GroupPair *q = &g->pairs[i];
        if (!feature_kind_known(&q->on_a->shape) || !feature_kind_known(&q->on_b->shape) || q->contacts != 1)
            return false;
    }
    return true;
}
