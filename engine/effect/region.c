/* effect/region.c - other laws inside a region: its own gravity, drag, and scaled friction and restitution. Where regions
 * overlap, the one made last gives the gravity; drags add and scales multiply. */
#include "effect/effect.h"
#include "world/region.h"

static bool wanted(const World *w, const Group *g)
{
    (void)g;
    return w->region_count > 0;
}

static int members(const Group *g)
{
    int n = 0;
    for (int i = 0; i < g->moving_count; i++)
        for (int r = 0; r < g->world->regions.count; r++)
            if (region_holds(&g->world->regions.data[r], g->pos[i].x)) {
                n++;
                break;
            }
    return n;
}

static void apply(const Group *g, int i)
{
    Member *m = &g->member[i];
    vec3 gravity = g->gravity;
    real drag = 0;
    for (int r = 0; r < g->world->regions.count; r++) {
        const Region *region = &g->world->regions.data[r];
        if (!region_holds(region, g->pos[i].x))
            continue;
        gravity = isnan(region->laws.gravity.x) ? gravity : region->laws.gravity;
        drag += region->laws.drag;
    }
    m->force = vec3_mad(m->force, m->mass * m->gravity_scale, vec3_sub(gravity, g->gravity));
    /* the exact decay of speed over the substep, as a mean force: stable for any drag */
    real share = -expm1(-drag * g->h) / g->h;
    m->force = vec3_mad(m->force, -share * m->mass, g->vel[i].v);
    m->torque = vec3_sub(m->torque, vec3_scale(share, quat_rotate(g->pos[i].q, mat3_mul_vec(m->inertia, quat_unrotate(g->pos[i].q, g->vel[i].w)))));
}

/* Friction and restitution of a contact take the scales of both bodies' places. */
static void scale_pair(Group *g, GroupPair *q)
{
    const Pair *p = &g->world->pairs.data[q->slot];
    real friction = 1, restitution = 1;
    for (int r = 0; r < g->world->regions.count; r++) {
        const Region *region = &g->world->regions.data[r];
        bool inside = (g->member[q->a].moves && region_holds(region, g->pos[q->a].x)) || (g->member[q->b].moves && region_holds(region, g->pos[q->b].x));
        friction *= inside ? region->laws.friction_scale : 1;
        restitution *= inside ? region->laws.restitution_scale : 1;
    }
    q->friction = friction * p->friction;
    q->friction_dynamic = friction * p->friction_dynamic;
    q->restitution = real_min(1, restitution * p->restitution);
}

static dig_status force(const EffectSlot *e, Group *g)
{
    (void)e;
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves)
            apply(g, i);
    for (int i = 0; i < g->pair_count; i++)
        scale_pair(g, &g->pairs[i]);
    return DIG_OK;
}

const EffectType effect_region = {
    .name = "region",
    .law = "inside a region: F = m g', F = -c m v, mu' = s mu, e' = s e",
    .cite = "viper2000",
    .wanted = wanted,
    .members = members,
    .run = {[STAGE_FORCE] = force},
};
