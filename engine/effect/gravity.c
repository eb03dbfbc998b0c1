/* effect/gravity.c - uniform gravity. */
#include "effect/effect.h"

static bool wanted(const World *w, const Group *g)
{
    (void)g;
    return vec3_length2(w->def.gravity) > 0;
}

static dig_status force(const EffectSlot *e, Group *g)
{
    (void)e;
    for (int i = 0; i < g->moving_count; i++) {
        Member *m = &g->member[i];
        if (m->moves)
            m->force = vec3_mad(m->force, m->mass * m->gravity_scale, g->gravity);
    }
    return DIG_OK;
}

const EffectType effect_gravity = {
    .name = "gravity",
    .law = "F = m g",
    .cite = "newton1687",
    .wanted = wanted,
    .run = {[STAGE_FORCE] = force},
};
