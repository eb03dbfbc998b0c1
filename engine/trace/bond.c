/* trace/bond.c - joints that break: the load on them, and what is left when one has let go.
 *
 * A joint's load is the force by which it acts on one of its ends: for springs a function of the state, for what is rigid the
 * solution of the rows. It is smooth between events, and where it reaches the strength is an event like any other.
 */
#include "trace/trace.h"

void trace_bonds(Tracer *t)
{
    t->bond_count = 0;
    for (int j = 0; j < t->g->joint_count; j++)
        if (!t->g->joints[j].broken && (t->g->joints[j].view.type->share || t->g->joints[j].breaks_at > 0))
            t->bonds[t->bond_count++] = (Bond){.joint = j, .strength = t->g->joints[j].view.type->share ? 1 : t->g->joints[j].breaks_at};
}

real trace_load_on(const Tracer *t, int joint)
{
    const GroupJoint *j = &t->g->joints[joint];
    vec3 sum = vec3_zero(), twist = vec3_zero();
    for (int i = 0; i < t->row_count[joint]; i++) {
        const Row *r = &t->rows[joint * JOINT_SLOTS + i];
        for (int k = 0; k < r->count; k++)
            if (r->body[k] == j->a && j->a >= 0) {
                sum = vec3_mad(sum, t->joint_force[joint * JOINT_SLOTS + r->slot], r->lin[k]);
                twist = vec3_mad(twist, t->joint_force[joint * JOINT_SLOTS + r->slot], r->ang[k]);
            }
    }
    if (j->view.type->share)
        return j->view.type->share(&j->view, sum, vec3_sub(twist, vec3_cross(j->view.a.r, sum)));
    return vec3_length(sum);
}

void trace_part(Tracer *t, const Event *e)
{
    int joint = e->bond->joint, n = 0;
    trace_load(t, t->y, t->t);
    group_part(t->g, joint, 1);
    t->conserves = false;
    memset(&t->joint_force[joint * JOINT_SLOTS], 0, JOINT_SLOTS * sizeof *t->joint_force);
    for (int i = 0; i < t->stop_count; i++)
        if (t->stops[i].joint != joint)
            t->stops[n++] = t->stops[i];
    t->stop_count = n;
    n = 0;
    for (int i = 0; i < t->hold_count; i++)
        if (t->holds[i].joint != joint)
            t->holds[n++] = t->holds[i];
    t->hold_count = n;
    n = 0;
    for (int i = 0; i < t->bond_count; i++)
        if (t->bonds[i].joint != joint)
            t->bonds[n++] = t->bonds[i];
    t->bond_count = n;
    t->g->located++;
    t->dirty = true;
}
