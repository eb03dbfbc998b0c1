/* effect/effects.c - the list of effects. Its order is the order within a stage. */
#include "effect/effect.h"

extern const EffectType effect_gravity, effect_push, effect_contact, effect_friction, effect_rolling, effect_joints,
    effect_region, effect_buoyancy, effect_drag, effect_heat;

const EffectType *const effect_types[] = {
    &effect_gravity, &effect_push, &effect_region, &effect_buoyancy, &effect_drag, &effect_contact, &effect_friction, &effect_rolling,
    &effect_joints, &effect_heat, NULL,
};
