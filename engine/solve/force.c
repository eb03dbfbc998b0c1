/* solve/force.c - forces of the effects; whose work is booked apart: drags, and the laws of regions; energy at joints. */
#include "solve/group.h"

dig_status group_apart(Group *g)
{
    if (!g->varies && g->world->region_count == 0)
        return DIG_OK;
    g->apart = arena_zero(g->arena, (size_t)g->moving_count * sizeof *g->apart);
    return g->apart ? DIG_OK : DIG_E_MEMORY;
}

INLINE void clear_share(void *context, int thread, int threads)
{
    Group *g = context;
    for (int i = team_first(g->moving_count, thread, threads), end = team_end(g->moving_count, thread, threads); i < end; i++) {
        Member *m = &g->member[i];
        m->force = m->torque = vec3_zero();
    }
}

dig_status group_forces(Group *g)
{
    team_deal(g->team, clear_share, g);
    if (g->drags || g->rules)
        memset(g->apart, 0, (size_t)g->moving_count * sizeof *g->apart);
    return g->stage(g, STAGE_FORCE);
}

void group_brake(Group *g, int body, vec3 force, vec3 torque)
{
    Member *m = &g->member[body];
    m->force = vec3_add(m->force, force);
    m->torque = vec3_add(m->torque, torque);
    Apart *a = &g->apart[body];
    a->drag = vec3_add(a->drag, force);
    a->drag_torque = vec3_add(a->drag_torque, torque);
    g->drags = true;
}

void group_rule(Group *g, int body, vec3 force, vec3 torque)
{
    Member *m = &g->member[body];
    m->force = vec3_add(m->force, force);
    m->torque = vec3_add(m->torque, torque);
    Apart *a = &g->apart[body];
    a->law = vec3_add(a->law, force);
    a->law_torque = vec3_add(a->law_torque, torque);
    g->rules = true;
}

/* A drag -k (v - u) does the work of u in, and loses that of v - u. */
void group_book_apart(Group *g, int body, vec3 moved, vec3 turned, real h)
{
    if (!g->member[body].moves || !g->apart)
        return;
    const Apart *a = &g->apart[body];
    if (g->drags) {
        g->work_in += a->driven * h;
        g->lost += a->driven * h - vec3_dot(a->drag, moved) - vec3_dot(a->drag_torque, turned);
    }
    if (g->rules)
        g->law += vec3_dot(a->law, moved) + vec3_dot(a->law_torque, turned);
}

real group_spring_energy(const GroupJoint *j)
{
    real memory[JOINT_MEMORY];
    if (!j->stores)
        return 0;
    if (j->view.type->two_anchors)      /* what acts along a line unwinds no angle: nothing is written */
        return j->view.type->energy(&j->view);
    JointView now = j->view;
    memcpy(memory, j->memory, sizeof memory);
    now.memory = memory;
    return now.type->energy(&now);
}

real group_row_driven(const Group *g, const Row *r)
{
    real rate = 0;
    for (int k = 0; k < r->count; k++)
        if (r->body[k] >= 0 && g->member[r->body[k]].kinematic)
            rate += vec3_dot(r->lin[k], g->vel[r->body[k]].v) + vec3_dot(r->ang[k], g->vel[r->body[k]].w);
    return rate;
}

void group_book_push(Group *g, const GroupPush *p, real work)
{
    if (p->law) {
        g->law += work;
        return;
    }
    g->member[p->body].push_work += work;
    g->work_in += work;
}
