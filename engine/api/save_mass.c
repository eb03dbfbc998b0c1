/* api/save_mass.c - is a body's inertia one that its shapes can have? And what follows from mass and shapes. */
#include "api/save.h"

static real least_of(mat3 symmetric)
{
    vec3 moments;
    mat3 axes;
    mat3_principal(symmetric, &moments, &axes);
    return real_min(moments.x, real_min(moments.y, moments.z));
}

/* m^2  Smallest principal moment per mass. */
static real least_moment(const MassProps *unit)
{
    real least = least_of(unit->inertia) / unit->volume;
    return least > 0 && isfinite(least) ? least : 0;
}

/* Every solid of a body has a mass and a volume, else the body could not be dynamic. */
static bool solids_weigh(const World *w, const Body *b, real *least)
{
    *least = INFINITY;
    for (uint32_t s = b->shape_first; s != NONE; s = w->solids.data[s].next) {
        const Shape *shape = &w->solids.data[s].form->shape;
        MassProps unit = {.volume = 0};
        if (!shape->type->mass || !isfinite(shape->outer))
            return false;
        shape->type->mass(shape, &unit);
        if (!(unit.volume > 0))
            return false;
        *least = real_min(*least, least_moment(&unit));
    }
    return true;
}

/* Inertia is a sum over the solids, each at least its own mass times its least moment, and no mass lies farther out than `outer`.
 * Half the bound, and a little of the trace for rounding where a body is much longer than thick. */
static bool inertia_is_possible(const Body *b, real least)
{
    mat3 i = body_inertia(b)->of;
    if (!body_turns(b))
        return b->round_inertia && vec3_equal(i.r0, (vec3){i.r0.x, 0, 0}) && vec3_equal(i.r1, (vec3){0, i.r0.x, 0}) &&
               vec3_equal(i.r2, (vec3){0, 0, i.r0.x}) && i.r0.x <= 1e10 * b->mass * b->outer * b->outer;
    real trace = i.r0.x + i.r1.y + i.r2.z, slack = 1e-9 * trace;
    if (!(trace > 0 && trace <= 2 * b->mass * b->outer * b->outer * (1 + 1e-9)))
        return false;
    if (!(fabs(i.r0.y - i.r1.x) <= slack && fabs(i.r0.z - i.r2.x) <= slack && fabs(i.r1.z - i.r2.y) <= slack))
        return false;
    return least_of(i) >= 0.5 * least * b->mass - 1e-12 * trace;
}

static bool mat3_finite(mat3 m) { return vec3_finite(m.r0) && vec3_finite(m.r1) && vec3_finite(m.r2); }

/* As body_create does, from the same numbers. */
bool save_derive_mass(World *w, Body *b)
{
    real least = 0;
    body_measure(w, b);
    if (b->kind != DIG_DYNAMIC)
        return true;
    if (!solids_weigh(w, b, &least) || !inertia_is_possible(b, least))
        return false;
    b->inv_mass = 1 / b->mass;
    return isfinite(b->inv_mass) && mat3_finite(body_inertia(b)->inverse);
}
