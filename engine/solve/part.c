/* solve/part.c - joints that let go within a step: when, and what is left of them for the rest of it.
 *
 * The load that counts is the mean over the last frame step: a blow is no force. While a step is under way its part that is still
 * to come is that of the step before. The most loaded joint of a group that is over its limit goes first; the part in which it is found so
 * is done again, so that what it bore is on others before the next is judged.
 */
#include "solve/group.h"

/* What holds no more. Joints that couple it find no coordinate in it, and add no rows either. */
static void no_rows(const JointView *j, RowList *out)
{
    (void)j;
    (void)out;
}

static const JointType parted = {.name = "parted", .doc = "broken in this step", .free_axes = 6, .rows = no_rows};

void group_part(Group *g, int joint, real share)
{
    GroupJoint *j = &g->joints[joint];
    group_joint_view(g, joint);
    g->lost += group_spring_energy(j);          /* a spring that breaks swings out by itself */
    j->broken = true;
    j->broke = g->t;
    j->overload = share;
    j->view.type = &parted;
    j->stores = false;
    memset(j->force, 0, sizeof j->force);
}

void group_mean_load(Group *g, int joint, real dt, vec3 *force, vec3 *couple)
{
    const GroupJoint *j = &g->joints[joint];
    const JointRec *r = &g->world->joints.data[j->slot];
    real rest = real_max(0, dt - g->t);
    *force = vec3_scale(1 / dt, vec3_mad(j->impulse, rest, r->force));
    vec3 torque = vec3_scale(1 / dt, vec3_mad(j->angular_impulse, rest, r->torque));
    group_joint_view(g, joint);
    *couple = vec3_sub(torque, vec3_cross(j->view.a.r, *force));
}

/* Over the frame that ends now. */
real group_share(Group *g, int joint, real dt)
{
    vec3 force, couple;
    group_mean_load(g, joint, dt, &force, &couple);
    return joint_share(&g->joints[joint].view, force, couple);
}

#define AGAIN 64                /* times in a step: beyond that a joint is judged by what it bore beside the one that went before */

static bool can_part(const GroupJoint *j) { return !j->broken && (j->breaks_at > 0 || j->view.type->share); }

bool group_may_part(const Group *g)
{
    bool any = false;
    for (int i = 0; i < g->joint_count && !any; i++)
        any = can_part(&g->joints[i]);
    return any && g->parted_before < AGAIN;
}

bool group_keep_before(Group *g)
{
    if (!g->before && !(g->before = arena_zero(g->arena, sizeof *g->before)))
        return false;
    return group_keep_in(g, g->before);
}

void group_back_before(Group *g)
{
    int times = g->parted_before, sweeps = g->sweeps, factors = g->factors;
    group_put_back(g, g->before);
    g->parted_before = times + 1;
    g->sweeps = sweeps;             /* what the try has cost */
    g->factors = factors;
}

int group_overloaded(Group *g, real dt, real *share)
{
    int worst = -1;
    *share = 1;
    for (int i = 0; i < g->joint_count; i++) {
        const GroupJoint *j = &g->joints[i];
        if (!can_part(j))
            continue;
        real s = group_share(g, i, dt);
        if (s > *share) {
            *share = s;
            worst = i;
        }
    }
    return worst;
}
