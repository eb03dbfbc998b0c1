/* effect/gravity.c - uniform gravity. */
#include "effect/effect.h"

static bool wanted(const World *w, const Group *g)
{
    if (!(vec3_length2(w->def.gravity) > 0))
        return false;
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves && g->member[i].gravity_scale != 0)       /* nor is what is not finite passed over */
            return true;
    return false;
}

static EffectCause cause(const Group *g)
{
    int i = 0;
    while (i + 1 < g->moving_count && (!g->member[i].moves || !(fabs(g->member[i].gravity_scale) > 0)))
        i++;
    return (EffectCause){.body = body_handle(g->world, g->member[i].slot)};
}

INLINE void force_share(void *context, int thread, int threads)
{
    Group *g = context;
    for (int i = team_first(g->moving_count, thread, threads), end = team_end(g->moving_count, thread, threads); i < end; i++) {
        Member *m = &g->member[i];
        if (m->moves)
            m->force = vec3_mad(m->force, m->mass * m->gravity_scale, g->gravity);
    }
}

static dig_status force(const EffectSlot *e, Group *g)
{
    (void)e;
    team_deal(g->team, force_share, g);
    return DIG_OK;
}

const EffectType effect_gravity = {
    .name = "gravity",
    .law = "F = m g",
    .central = true,
    .cite = "newton1687",
    .wanted = wanted,
    .cause = cause,
    .run = {[STAGE_FORCE] = force},
};
