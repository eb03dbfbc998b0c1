/* effect/region.c - other laws inside a region: its own gravity, drag, and scaled friction and restitution. Where regions
 * overlap, the one made last gives the gravity; drags add and scales multiply. The rate of time inside is a state of bodies
 * (world/region.h). The work of its gravity, as far as it is not the world's, is booked as the law's; drag is a loss. */
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

static EffectCause cause(const Group *g)
{
    for (int r = 0; r < g->world->regions.count; r++)
        if (g->world->regions.data[r].alive)
            return (EffectCause){.region = {(uint32_t)r, g->world->regions.data[r].gen}};
    return (EffectCause){.body = {0, 0}};
}

/* 1/s  A mean rate of decay that holds its exact course over the substep: stable for any drag. */
static real decay(real drag, real h) { return h > 0 && drag > 0 ? -expm1(-drag * h) / h : drag; }

static void apply(Group *g, int i)
{
    const Member *m = &g->member[i];
    vec3 gravity = g->gravity;
    real drag = 0;
    for (int r = 0; r < g->world->regions.count; r++) {
        const Region *region = &g->world->regions.data[r];
        if (!region_holds(region, g->pos[i].x))
            continue;
        gravity = isnan(region->laws.gravity.x) ? gravity : region->laws.gravity;
        drag += region->laws.drag;
    }
    vec3 change = vec3_sub(gravity, g->gravity);
    if (vec3_length2(change) > 0)
        group_rule(g, i, vec3_scale(m->mass * m->gravity_scale, change), vec3_zero());
    if (!(drag > 0))
        return;
    real c = decay(drag * g->world->bodies.data[m->slot].rate, g->h);
    vec3 w = quat_unrotate(g->pos[i].q, g->vel[i].w);
    group_brake(g, i, vec3_scale(-c * m->mass, g->vel[i].v), quat_rotate(g->pos[i].q, vec3_scale(-c, mat3_mul_vec(*m->inertia, w))));
}

/* Friction and restitution of a contact take the scales of both bodies' places. */
static void scale_pair(Group *g, GroupPair *q)
{
    Rub rub = pair_rub(g->world, &g->world->pairs.data[q->slot]);
    real friction = 1, restitution = 1;
    for (int r = 0; r < g->world->regions.count; r++) {
        const Region *region = &g->world->regions.data[r];
        bool inside = (g->member[q->a].moves && region_holds(region, g->pos[q->a].x)) || (g->member[q->b].moves && region_holds(region, g->pos[q->b].x));
        friction *= inside ? region->laws.friction_scale : 1;
        restitution *= inside ? region->laws.restitution_scale : 1;
    }
    friction = g->laws >> LAW_FRICTION & 1 ? friction : 0;
    Rub *own = &g->rubs[q - g->pairs];          /* where there are regions, each pair has its own */
    own->friction = friction * rub.friction;
    own->friction_dynamic = friction * rub.friction_dynamic;
    own->restitution = real_min(1, restitution * rub.restitution);
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
    .law = "inside a region: F = m g', F = -c m v, mu' = s mu, e' = s e, dt' = r dt",
    .cite = "viper2000",
    .wanted = wanted,
    .members = members,
    .cause = cause,
    .run = {[STAGE_FORCE] = force},
};
