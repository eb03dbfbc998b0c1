/* effect/push.c - forces and torques that scripts apply for a time, at a point fixed in the body. */
#include "effect/effect.h"

static bool wanted(const World *w, const Group *g)
{
    (void)w;
    return g->push_count > 0;
}

static int members(const Group *g) { return g->push_count; }

static EffectCause cause(const Group *g) { return (EffectCause){.body = body_handle(g->world, g->member[g->pushes[0].body].slot)}; }

static dig_status force(const EffectSlot *e, Group *g)
{
    (void)e;
    for (int i = 0; i < g->push_count; i++) {
        const GroupPush *p = &g->pushes[i];
        Member *m = &g->member[p->body];
        m->force = vec3_add(m->force, p->force);
        m->torque = vec3_add(m->torque, p->torque);
        if (p->has_at)
            m->torque = vec3_add(m->torque, vec3_cross(quat_rotate(g->pos[p->body].q, p->at), p->force));
    }
    return DIG_OK;
}

const EffectType effect_push = {
    .name = "push",
    .law = "F = F(t), tau = r x F",
    .cite = "newton1687",
    .wanted = wanted,
    .stands = LAW_PUSH,
    .members = members,
    .cause = cause,
    .run = {[STAGE_FORCE] = force},
};
