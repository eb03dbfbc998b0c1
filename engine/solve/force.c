/* solve/force.c - forces of the effects, and the energy that those of them take which are drags. */
#include "solve/group.h"

dig_status group_forces(Group *g)
{
    for (int i = 0; i < g->moving_count; i++) {
        Member *m = &g->member[i];
        m->force = m->torque = vec3_zero();
        if (g->drags) {
            m->drag = m->drag_torque = vec3_zero();
            m->driven = 0;
        }
    }
    return g->stage(g, STAGE_FORCE);
}

/* A drag -k (v - u) does the work of u in, and loses that of v - u. */
void group_book_drag(Group *g, int body, vec3 moved, vec3 turned, real h)
{
    const Member *m = &g->member[body];
    if (!g->drags || !m->moves)
        return;
    g->work_in += m->driven * h;
    g->lost += m->driven * h - vec3_dot(m->drag, moved) - vec3_dot(m->drag_torque, turned);
}
