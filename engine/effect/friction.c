/* effect/friction.c - dry friction on contact points: a round cone, static and dynamic. Or, when the world asks for it, the
 * founding document's alternative: sliding speed decays at a rate in proportion to the coefficient. */
#include "effect/effect.h"
#include "solve/direction.h"

/* 1/s per unit of friction coefficient, of the scalar decay law. */
#define DECAY_RATE 10.0

static bool wanted(const World *w, const Group *g)
{
    (void)w;
    for (int i = 0; i < g->pair_count; i++)
        if (g->pairs[i].rub->friction > 0)
            return true;
    return false;
}

static int members(const Group *g) { return g->rubbing_count; }

static EffectCause cause(const Group *g)
{
    int i = 0;
    while (i + 1 < g->pair_count && !(g->pairs[i].rub->friction > 0))
        i++;
    return effect_cause_pair(g, &g->pairs[i]);
}

static dig_status decay(Group *g)
{
    for (int i = 0; i < g->contact_count; i++) {
        const GroupContact *c = &g->contacts[i];
        if (!c->live || !(contact_memory(c)[0].normal > 0))
            continue;
        real rate = DECAY_RATE * g->pairs[c->pair].rub->friction_dynamic;
        vec3 slip = vec3_sub(g->vel[c->b].v, g->vel[c->a].v);
        slip = vec3_mad(slip, -vec3_dot(slip, c->manifold.normal), c->manifold.normal);
        for (int k = 0; k < 2; k++) {
            Member *m = &g->member[k ? c->b : c->a];
            /* the exact decay over the substep, as a mean force */
            real factor = -expm1(-rate * g->h) / g->h;
            if (m->moves)
                m->force = vec3_mad(m->force, (k ? -1 : 1) * factor * m->mass, slip);
        }
    }
    return DIG_OK;
}

static dig_status force(const EffectSlot *e, Group *g)
{
    (void)e;
    return g->decay_friction ? decay(g) : DIG_OK;
}

static dig_status rows(const EffectSlot *e, Group *g)
{
    (void)e;
    if (g->decay_friction)
        return DIG_OK;
    real slow = 0.01 * g->close_speed + 1e-9;
    for (int i = 0; i < g->point_count; i++) {
        PointRow *r = &g->points[i];
        const GroupPair *q = &g->pairs[g->contacts[r->contact].pair];
        r->friction = q->rub->friction;
        r->friction_dynamic = q->rub->friction_dynamic;
        Vel va = g->member[r->a].moves ? g->start_vel[r->a] : g->vel[r->a];
        Vel vb = g->member[r->b].moves ? g->start_vel[r->b] : g->vel[r->b];
        real slip[2];
        for (int k = 0; k < 2; k++)
            slip[k] = vec3_dot(r->t[k].n, vec3_sub(vb.v, va.v)) + vec3_dot(r->t[k].aa, va.w) + vec3_dot(r->t[k].ab, vb.w);
        r->slides = sqrt(slip[0] * slip[0] + slip[1] * slip[1]) > slow;
    }
    return DIG_OK;
}

const EffectType effect_friction = {
    .name = "friction",
    .law = "|F_t| <= mu_s F_n at rest; F_t = -mu_d F_n v_t / |v_t| sliding",
    .cite = "coulomb1785",
    .wanted = wanted,
    .stands = LAW_FRICTION,
    .members = members,
    .cause = cause,
    .run = {[STAGE_FORCE] = force, [STAGE_ROWS] = rows},
};
