/* api/body_param.c - parameters of a body that may change while it lives, by the names of the body schema. */
#include "api/api.h"
#include "api/command.h"

#include <stdio.h>

static void change_surface(Surface *s, const char *name, real value)
{
    if (strcmp(name, "friction") == 0)
        s->friction = value;
    else if (strcmp(name, "friction_dynamic") == 0)
        s->friction_dynamic = value;
    else if (strcmp(name, "rolling_friction") == 0)
        s->rolling = value;
    else if (strcmp(name, "restitution") == 0)
        s->restitution = value;
    else
        s->material = (int)value;
}

/* The surfaces of all its solids, too. DIG_E_MEMORY: none changed. */
static dig_status set_surface(World *w, uint32_t slot, const char *name, real value)
{
    Body *b = &w->bodies.data[slot];
    ArenaMark mark = arena_mark(&w->scratch);
    const Form **made = arena_alloc(&w->scratch, (size_t)b->shape_count * sizeof *made);
    int count = 0;
    for (uint32_t s = b->shape_first; made && s != NONE; s = w->solids.data[s].next) {
        Form like = *w->solids.data[s].form;
        change_surface(&like.surface, name, value);
        made[count] = form_take(w, w->solids.data[s].form, &like);
        for (int k = 0; !made[count] && k < count; k++)
            form_drop(made[k]);
        made = made[count++] ? made : NULL;
    }
    Make make = *body_make(b);
    change_surface(&make.surface, name, value);
    if (made && body_make_set(w, b, &make) != DIG_OK) {
        while (count > 0)
            form_drop(made[--count]);
        made = NULL;
    }
    for (uint32_t s = b->shape_first, k = 0; made && s != NONE; s = w->solids.data[s].next) {
        form_drop(w->solids.data[s].form);
        w->solids.data[s].form = made[k++];
    }
    arena_rewind(&w->scratch, mark);
    if (!made)
        return world_fail(w, DIG_E_MEMORY, "%s: not enough memory for its surfaces", BODY_TEXT(w, b));
    pairs_refresh_surfaces(w, slot);
    return DIG_OK;
}

static dig_status set_material(World *w, uint32_t slot, const char *name)
{
    int material = material_find(w, name);
    if (material < 0)
        return world_fail(w, DIG_E_ARG, "%s: there is no material '%s'", BODY_TEXT(w, &w->bodies.data[slot]), name);
    Body *b = &w->bodies.data[slot];
    Body before = *b;
    body_shares_keep(&before);
    dig_status status = DIG_OK;
    if (b->kind == DIG_DYNAMIC && b->density > 0)
        status = body_set_mass(w, b, b->mass * w->materials.data[material].def.density / b->density);
    if (status == DIG_OK)
        status = set_surface(w, slot, "material", material);
    if (status != DIG_OK) {             /* not the mass of one and the surface of another */
        Body half = *b;
        *b = before;
        before = half;
    }
    body_shares_drop(&before);
    return status;
}

static dig_status set_mass(World *w, Body *b, real mass)
{
    if (b->kind != DIG_DYNAMIC)
        return world_fail(w, DIG_E_KIND, "%s is not dynamic: it has no mass to set", BODY_TEXT(w, b));
    if (!(mass > 0 && isfinite(mass)))
        return world_fail(w, DIG_E_ARG, "%s: mass = %g kg, must be > 0 and finite", BODY_TEXT(w, b), mass);
    return body_set_mass(w, b, mass);
}

static dig_status set_make(World *w, Body *b, const char *name, const void *value)
{
    Make make = *body_make(b);
    if (strcmp(name, "group") == 0)
        make.group = *(const int64_t *)value;
    else if (strcmp(name, "colour") == 0)
        make.colour = *(const vec3 *)value;
    else
        make.opacity = *(const real *)value;
    return body_make_set(w, b, &make);
}

static void set_integrator(Body *b, int64_t integrator)
{
    b->integrator = (uint8_t)integrator;
    b->euler = integrator != DIG_VERLET;
}

/* A body made without collisions has no boxes in the tree yet. */
static dig_status set_collides(World *w, Body *b, bool collides)
{
    for (uint32_t s = b->shape_first; collides && s != NONE; s = w->solids.data[s].next) {
        Solid *solid = &w->solids.data[s];
        if (solid->leaf < 0 && isfinite(solid->form->shape.outer) &&
            tree_insert(&w->tree, solid->form->shape.type->bounds(&solid->form->shape, solid_pose(w, solid)), s, &solid->leaf) != DIG_OK)
            return world_fail(w, DIG_E_MEMORY, "%s: not enough memory", BODY_TEXT(w, b));
    }
    b->collides = collides;
    return DIG_OK;
}

static dig_status do_set(World *w, dig_body handle, const char *name, const void *value)
{
    Body *b = api_body(w, handle, name);
    if (!b)
        return DIG_E_DEAD;
    const dig_param *row = param_find(dig_schema_at("body", 0)->rows, name);
    char subject[96], why[256];
    int effect;
    snprintf(subject, sizeof subject, "%s", BODY_TEXT(w, b));
    if (!row && (row = api_effect_row(w, name, &effect)) != NULL)
        return api_effect_set(w, handle.slot, effect, row, value);
    if (!row)
        return world_fail(w, DIG_E_ARG, "%s has no parameter '%s'", BODY_TEXT(w, b), name);
    if (param_check_field(row, value, subject, why, sizeof why) != DIG_OK)
        return world_fail(w, DIG_E_ARG, "%s", why);
    const real *number = value;
    real before = body_energy(w, b);
    dig_status status = DIG_OK;
    if (strcmp(name, "mass") == 0)
        status = set_mass(w, b, *number);
    else if (strcmp(name, "density") == 0)
        status = set_mass(w, b, b->density > 0 ? b->mass * *number / b->density : *number);
    else if (strcmp(name, "material") == 0)
        status = set_material(w, handle.slot, ((const dig_text *)value)->s);
    else if (strstr(name, "friction") || strcmp(name, "restitution") == 0)
        status = set_surface(w, handle.slot, name, *number);
    else if (strcmp(name, "gravity_scale") == 0) {
        b->gravity_scale = *number;
        b->lies = -1;
    } else if (strcmp(name, "group") == 0 || strcmp(name, "colour") == 0 || strcmp(name, "opacity") == 0)
        status = set_make(w, b, name, value);
    else if (strcmp(name, "integrator") == 0)
        set_integrator(b, *(const int64_t *)value);
    else if (strcmp(name, "collides") == 0)
        status = set_collides(w, b, *(const bool *)value);
    else if (strcmp(name, "name") == 0)
        memcpy(body_rest_own(w, b)->name, value, sizeof no_rest.name);
    else
        return world_fail(w, DIG_E_ARG, "%s: '%s' is decided when a body is made%s", BODY_TEXT(w, b), name,
                          strcmp(name, "fixed") == 0 ? " (what is held for a while is welded to the world, until the weld is removed)" : "");
    w->ledger.initial += w->ledger.started ? body_energy(w, b) - before : 0;      /* mass, material, gravity_scale */
    if (status == DIG_OK && (strcmp(name, "mass") == 0 || strcmp(name, "density") == 0 || strcmp(name, "material") == 0))
        status = api_effects_follow(w, handle.slot);
    if (status == DIG_OK && (strcmp(name, "group") == 0 || strcmp(name, "collides") == 0))
        body_refit(w, handle.slot);
    if (status == DIG_OK && strcmp(name, "name") != 0 && strcmp(name, "colour") != 0 && strcmp(name, "opacity") != 0) {
        touches_wake(w, handle.slot);
        body_wake(w, handle.slot);
    }
    return status;
}

dig_status run_body_set(World *w, CommandArg *a)
{
    return do_set(w, a[0].body, a[1].what, a[2].what);
}

dig_status dig_body_set(dig_world *w, dig_body handle, const char *name, const void *value)
{
    return COMMAND(w, COMMAND_BODY_SET, do_set(w, handle, name, value), {.body = handle}, {.what = name}, {.what = value});
}

dig_status dig_body_param(const dig_world *w, dig_body handle, const char *name, void *value)
{
    const Body *b = api_body(w, handle, name);
    if (!b)
        return DIG_E_DEAD;
    const dig_param *row = param_find(dig_schema_at("body", 0)->rows, name);
    int effect;
    if (!row && (row = api_effect_row(w, name, &effect)) != NULL) {
        api_effect_get(w, handle.slot, effect, row, value);
        return DIG_OK;
    }
    if (!row)
        return world_fail(w, DIG_E_ARG, "%s has no parameter '%s'", BODY_TEXT(w, b), name);
    Surface s = surface_resolve(w, &body_make(b)->surface);
    dig_body_def def = dig_body_defaults();
    memcpy(def.name.s, body_name(w, b), sizeof def.name.s);
    pose at = body_pose(b);
    def.at = at.p;
    def.rotation = at.q;
    def.velocity = b->v;
    def.spin = b->w;
    def.mass = body_mass_read(b);
    def.density = b->density;
    snprintf(def.material.s, sizeof def.material.s, "%s", w->materials.data[s.material].name);
    def.friction = s.friction;
    def.friction_dynamic = s.friction_dynamic;
    def.rolling_friction = s.rolling;
    def.restitution = s.restitution;
    def.fixed = b->kind == DIG_STATIC;
    def.kinematic = b->kind == DIG_KINEMATIC;
    def.gravity_scale = b->gravity_scale;
    def.collides = b->collides;
    def.turns = body_turns(b);
    def.group = body_make(b)->group;
    def.integrator = b->integrator;
    def.colour = body_make(b)->colour.x >= 0 ? body_make(b)->colour : w->materials.data[s.material].def.colour;
    def.opacity = body_make(b)->opacity;
    def.sheet = body_rest(w, b)->sheet;
    memcpy(value, (const char *)&def + row->offset, param_size(row));
    return DIG_OK;
}
