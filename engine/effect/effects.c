/* effect/effects.c - the list of effects. Its order is the order within a stage. */
#include "effect/effect.h"

extern const EffectType effect_gravity, effect_push, effect_contact, effect_friction, effect_rolling, effect_joints,
    effect_region, effect_buoyancy, effect_drag, effect_heat;

const EffectType *const effect_types[] = {
    &effect_gravity, &effect_push, &effect_region, &effect_buoyancy, &effect_drag, &effect_contact, &effect_friction, &effect_rolling,
    &effect_joints, &effect_heat, NULL,
};

/* Nobody has a field or an option of it: it need not be asked. */
static bool is_idle(const EffectSlot *e)
{
    return e->members.count == 0 && !e->world && (e->type->body_params || e->type->world_params);
}

static EffectBits find_bits(const World *w)
{
    EffectBits b = {0};
    for (int i = 0; i < w->effect_count; i++) {
        const EffectSlot *e = &w->effects[i];
        if (!e->on || is_idle(e))
            continue;
        uint32_t bit = (uint32_t)1 << i;
        b.called |= bit;
        b.own |= e->owner ? bit : 0;
        b.turns |= e->type->central ? 0 : bit;
        b.varies |= e->type->varies ? bit : 0;
        b.flow |= e->type->flow && (e->world || e->members.count > 0) ? bit : 0;
        for (int k = 0; k < STAGE_COUNT; k++)
            b.stage[k] |= e->type->run[k] ? bit : 0;
        b.losses = b.losses || (e->type->losses && e->members.count > 0);
    }
    return b;
}

void effects_look(World *w)
{
    if (w->bits.old)
        w->bits = find_bits(w);
    DIG_ASSERT(find_bits(w).called == w->bits.called && find_bits(w).own == w->bits.own && find_bits(w).turns == w->bits.turns);
    DIG_ASSERT(find_bits(w).varies == w->bits.varies && find_bits(w).flow == w->bits.flow && find_bits(w).losses == w->bits.losses);
    DIG_ASSERT(memcmp(find_bits(w).stage, w->bits.stage, sizeof w->bits.stage) == 0);
}
