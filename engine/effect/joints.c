/* effect/joints.c - joints: each type writes its rows (joint/), the solver does the rest. */
#include "effect/effect.h"

static bool wanted(const World *w, const Group *g)
{
    (void)w;
    return g->joint_count > 0;
}

static int members(const Group *g) { return g->joint_count; }

static EffectCause cause(const Group *g) { return (EffectCause){.joint = joint_handle(g->world, g->joints[0].slot)}; }

static dig_status rows(const EffectSlot *e, Group *g)
{
    (void)e;
    group_build_joints(g, g->locate);
    return DIG_OK;
}

const EffectType effect_joints = {
    .name = "joints",
    .law = "C(q) = 0, force along the gradient of C",
    .cite = "lanczos1949",
    .wanted = wanted,
    .stands = LAW_JOINTS,
    .members = members,
    .cause = cause,
    .run = {[STAGE_ROWS] = rows},
};
