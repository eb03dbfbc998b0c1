/* api/region.c - regions where other laws hold. */
#include "api/api.h"
#include "api/command.h"

#include "world/region.h"

#include <stdio.h>

dig_region_def dig_region_defaults(void)
{
    dig_region_def def;
    memset(&def, 0, sizeof def);
    param_defaults(dig_schema_at("region", 0)->rows, &def);
    def.at.q = quat_identity();
    return def;
}

static dig_status do_create(World *w, const dig_region_def *def, dig_region *out)
{
    char why[256];
    Shape shape;
    uint32_t slot;
    *out = (dig_region){0, 0};
    if (param_check(dig_schema_at("region", 0)->rows, def, "region", why, sizeof why) != DIG_OK)
        return world_fail(w, DIG_E_ARG, "%s", why);
    if (!isnan(def->gravity.x))
        DIG_TRY(api_finite(w, def->gravity, "region", "gravity", "m/s^2"));
    if (!def->shape.type || shape_make(def->shape.type, def->shape.data, &shape, why, sizeof why) != DIG_OK)
        return world_fail(w, DIG_E_ARG, "region: %s", def->shape.type ? why : "it needs a shape");
    world_work_shape(w, &shape, def->shape.data);
    uint32_t gen;
    dig_status status = world_generation(w, "region", &gen);
    if (status == DIG_OK && (status = world_slot(w, &w->regions, &w->free_regions, &slot)) != DIG_OK)
        world_fail(w, status, "region: not enough memory");
    if (status != DIG_OK) {
        shape_free(&shape);
        return status;
    }
    pose at = def->at;
    at.q = quat_norm2(at.q) > 0 ? quat_unit(at.q) : quat_identity();
    w->regions.data[slot] = (Region){.gen = gen, .alive = true, .shape = shape, .at = at, .laws = *def};
    param_settle(dig_schema_at("region", 0)->rows, &w->regions.data[slot].laws);
    w->regions.data[slot].laws.shape = (dig_shape_def){0};      /* the caller's: its copy is .shape */
    w->region_count++;
    region_changed(w);
    world_wake_all(w);
    *out = (dig_region){slot, w->regions.data[slot].gen};
    return DIG_OK;
}

dig_status run_region(World *w, CommandArg *a)
{
    return do_create(w, a[0].what, a[1].place);
}

dig_status dig_region_create(dig_world *w, const dig_region_def *def, dig_region *out)
{
    return COMMAND(w, COMMAND_REGION, do_create(w, def, out), {.what = def}, {.place = out});
}

static Region *find(const World *w, dig_region r)
{
    if (r.slot >= (uint32_t)w->regions.count || !w->regions.data[r.slot].alive || w->regions.data[r.slot].gen != r.gen)
        return NULL;
    return &w->regions.data[r.slot];
}

static dig_status do_remove_region(World *w, dig_region handle)
{
    Region *r = find(w, handle);
    if (!r)
        return world_fail(w, DIG_E_DEAD, "region: this region was removed");
    shape_free(&r->shape);
    r->alive = false;
    w->region_count--;
    slot_give(w, &w->free_regions, handle.slot);
    region_changed(w);
    world_wake_all(w);
    return DIG_OK;
}

dig_status run_region_remove(World *w, CommandArg *a)
{
    return do_remove_region(w, a[0].region);
}

dig_status dig_region_remove(dig_world *w, dig_region handle)
{
    return COMMAND(w, COMMAND_REGION_REMOVE, do_remove_region(w, handle), {.region = handle});
}

static dig_status do_push(World *w, dig_region handle, dig_body body, vec3 force)
{
    dig_status s;
    if (!find(w, handle))
        return world_fail(w, DIG_E_DEAD, "region: this region was removed");
    if (!api_pushable(w, body, "region", &s))
        return s;
    DIG_TRY(api_within(w, force, WORLD_STRONG, "region", "force", "N"));
    return api_push(w, body, (Push){.force = force, .law = true}, 0, "region");
}

dig_status run_region_push(World *w, CommandArg *a)
{
    return do_push(w, a[0].region, a[1].body, a[2].vec);
}

dig_status dig_region_push(dig_world *w, dig_region handle, dig_body body, vec3 force)
{
    return COMMAND(w, COMMAND_REGION_PUSH, do_push(w, handle, body, force), {.region = handle}, {.body = body}, {.vec = force});
}

bool dig_region_alive(const dig_world *w, dig_region handle) { return find(w, handle) != NULL; }

int dig_region_bodies(const dig_world *w, dig_region handle, dig_body *out, int capacity)
{
    const Region *r = find(w, handle);
    int n = 0;
    for (int i = 0; r && i < w->bodies.count; i++) {
        const Body *b = &w->bodies.data[i];
        if (!b->alive || b->kind != DIG_DYNAMIC || !region_holds(r, b->x))
            continue;
        if (n < capacity)
            out[n] = body_handle(w, (uint32_t)i);
        n++;
    }
    return n;
}
