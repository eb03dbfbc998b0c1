/* solve/sway.c - how fast joints sway that are pressed against stops which turn with them.
 *
 * What leans on its cone passes it across as a pendulum hangs: by an angle s as the torque goes by s / swing. A row on the stop has no part
 * in that, for its direction is that of the swing at the middle of a substep, found beforehand; so it is as stable as an explicit rule is,
 * and gains energy where a substep is as long as such a sway. On narrow cones it is short: ten planks of a kilogram and 0.3 m that lie on
 * cones of 0.05 rad sway at 700 rad/s, and got 30 W out of that.
 */
#include "solve/group.h"

/* 1/s^2 */
static real sway_of(Group *g, int joint, real dt)
{
    const GroupJoint *j = &g->joints[joint];
    const int body[2] = {j->a, j->b};
    vec3 across, force, couple;
    real mobility = 0;
    group_mean_load(g, joint, dt, &force, &couple);
    real stiffness = j->view.type->sways(&j->view, j->force, couple, &across);
    for (int k = 0; k < 2 && stiffness > 0; k++)
        if (body[k] >= 0 && g->member[body[k]].moves)
            mobility += vec3_dot(across, mat3_mul_vec(g->mass[body[k]].ii, across));
    return stiffness * mobility;
}

real group_sways(Group *g, real dt)
{
    real most = 0;
    for (int i = 0; i < g->joint_count; i++)
        if (g->joints[i].view.type->sways && !g->joints[i].broken)
            most = real_max(most, sway_of(g, i, dt));
    return sqrt(most);
}
