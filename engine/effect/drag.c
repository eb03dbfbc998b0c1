/* effect/drag.c - the drag of air, which may move as wind.
 *
 * Either the world has air, and every body that does not say otherwise feels it, or a body's own coefficient calls for it.
 */
#include "effect/effect.h"
#include "solve/medium.h"

typedef struct Air { real density; vec3 wind; } Air;

#define DENSITY 1.204           /* kg/m^3  at 20 C and 101,325 Pa */

static const dig_param world_params[] = {
    {.name = "density", .kind = DIG_REAL, .unit = "kg/m^3", .doc = "of the air; the default is that at 20 C and 101,325 Pa", .fallback = DENSITY,
     .min = 0, .max = 1e5, .offset = offsetof(Air, density)},
    {.name = "wind", .kind = DIG_VEC3, .unit = "m/s", .doc = "velocity of the air", .fallback = 0, .min = -1e4, .max = 1e4,
     .offset = offsetof(Air, wind)},
    {0}
};

static const dig_param body_params[] = {
    {.name = "drag_coefficient", .kind = DIG_REAL, .unit = "1", .doc = "of the drag of air and water; default: that of the shape; 0 = feels none",
     .fallback = NAN, .min = 0, .max = 1e3, .offset = offsetof(DragBody, coefficient)},
    {.name = "drag_area", .kind = DIG_REAL, .unit = "m^2", .doc = "reference area; 0: what the shape shows to the flow", .fallback = 0, .min = 0,
     .max = 1e9, .offset = offsetof(DragBody, area)},
    {0}
};

extern const EffectType effect_drag;

static const EffectSlot *slot_of(const World *w)
{
    for (int i = 0; i < w->effect_count; i++)
        if (w->effects[i].type == &effect_drag)
            return &w->effects[i];
    return NULL;
}

static const DragBody *own_of(const EffectSlot *e, const Group *g, int i) { return column_find(&e->members, g->member[i].slot); }

/* Does it feel the air? Who names a coefficient alone does without a world's air. */
static bool takes_part(const EffectSlot *e, const Group *g, int i)
{
    const DragBody *own = own_of(e, g, i);
    return g->member[i].moves && (own ? !(own->coefficient <= 0) : e->world != NULL);
}

static bool wanted(const World *w, const Group *g)
{
    const EffectSlot *e = slot_of(w);
    for (int i = 0; i < g->moving_count && e && (e->world || e->members.count > 0); i++)
        if (takes_part(e, g, i))
            return true;
    return false;
}

static int members(const Group *g)
{
    int n = 0;
    for (int i = 0; i < g->moving_count; i++)
        n += takes_part(slot_of(g->world), g, i);
    return n;
}

/* A body that names only its area keeps the coefficient of its shapes. */
static dig_status join(const World *w, const EffectSlot *e, uint32_t body, void *member, char *why, size_t capacity)
{
    DragBody *own = member;
    real area, drag;
    (void)e;
    (void)why;
    (void)capacity;
    if (!isnan(own->coefficient))
        return DIG_OK;
    medium_area(w, body, w->bodies.data[body].q, (vec3){0, 1, 0}, &area, &drag);
    own->coefficient = area > 0 ? drag / area : 0;
    return DIG_OK;
}

static dig_status force(const EffectSlot *e, Group *g)
{
    const Air *air = e->world;
    Medium m = {air ? air->density : DENSITY, air ? air->wind : vec3_zero(), 0, 0};
    for (int i = 0; i < g->moving_count; i++)
        if (takes_part(e, g, i))
            medium_drag(g, i, &m, own_of(e, g, i), 1, 0, vec3_zero());
    return DIG_OK;
}

const EffectType effect_drag = {
    .name = "drag",
    .law = "F = -1/2 rho c A |v - u| (v - u), u: wind",
    .cite = "hoerner1965",
    .world_params = world_params,
    .world_size = sizeof(Air),
    .body_params = body_params,
    .body_size = sizeof(DragBody),
    .join = join,
    .wanted = wanted,
    .members = members,
    .varies = true,
    .run = {[STAGE_FORCE] = force},
};
