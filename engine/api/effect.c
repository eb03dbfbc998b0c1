/* api/effect.c - effects: which are on, what called for them, and what they keep of the world and of bodies. */
#include "api/api.h"
#include "api/command.h"

#include <stdio.h>
#include <stdlib.h>

void api_open_effects(World *w)
{
    w->bits.old = true;
    for (int i = 0; i < MAX_EFFECTS && effect_types[i]; i++) {
        const EffectType *t = effect_types[i];
        w->flowing |= (uint32_t)(t->flow != NULL) << i;
        w->effects[w->effect_count++] = (EffectSlot){.type = t, .name = t->name, .on = true, .world_size = t->world_size,
                                                     .members = {.size = t->body_size}};
    }
}

/* -1: there is none. */
static int find(const World *w, const char *name)
{
    for (int i = 0; i < w->effect_count; i++)
        if (strcmp(w->effects[i].name, name) == 0)
            return i;
    return -1;
}

static void say_why(EffectSlot *e, const char *why)
{
    if (!e->why[0] && why)
        snprintf(e->why, sizeof e->why, "%s", why);
}

static dig_status unknown(const World *w, const char *name) { return world_fail(w, DIG_E_ARG, "there is no effect '%s'", name); }

void api_effects_energy(const World *w, dig_energy *sum)
{
    for (int i = 0; i < w->effect_count; i++) {
        const EffectSlot *e = &w->effects[i];
        if (e->type->energy && (e->world || e->members.count > 0 || e->owner))
            e->type->energy(w, e, sum);
    }
}

real api_effects_stored(const World *w)
{
    dig_energy e = {0};
    api_effects_energy(w, &e);
    return e.kinetic + e.potential + e.elastic + e.heat + e.electric;
}

void api_book_stored(World *w, real before)
{
    if (w->ledger.started)
        w->ledger.initial += api_effects_stored(w) - before;
}

/* ---- reports ---- */

int dig_effect_count(const dig_world *w) { return w->effect_count; }

dig_status dig_effect_get(const dig_world *w, int index, dig_effect_info *info)
{
    if (index < 0 || index >= w->effect_count)
        return world_fail(w, DIG_E_ARG, "effect %d: there are %d", index, w->effect_count);
    const EffectSlot *e = &w->effects[index];
    bool called = e->bodies > 0 || e->members.count > 0 || e->world || e->owner;
    *info = (dig_effect_info){.name = e->name, .law = e->type->law, .on = e->on && called, .allowed = e->on, .us = e->us,
                              .us_mean = e->us_count > 0 ? e->us_sum / (real)e->us_count : 0,
                              .bodies = e->on ? int_max(e->bodies, e->type->flow ? e->members.count : 0) : 0,
                              .bytes = effect_bytes(e), .calls = e->calls, .own = e->owner != NULL, .explained = e->why[0] != '\0'};
    info->first = world_body(w, e->cause.body) ? e->cause.body : (dig_body){0, 0};
    info->first_joint = world_joint(w, e->cause.joint) ? e->cause.joint : (dig_joint){0, 0};
    info->first_region = world_region(w, e->cause.region) ? e->cause.region : (dig_region){0, 0};
    const char *general = called ? "the scene calls for it" : "nothing calls for it";
    snprintf(info->why, sizeof info->why, "%s", !e->on ? "switched off" : e->why[0] ? e->why : general);
    return DIG_OK;
}

static dig_status do_switch_by_hand(World *w, const char *name, bool on)
{
    int i = find(w, name);
    if (i < 0)
        return unknown(w, name);
    real before = api_effects_stored(w);
    w->effects[i].on = on;
    w->bits.old = true;
    w->effects[i].forced = true;
    api_book_stored(w, before);
    world_wake_all(w);
    return DIG_OK;
}

dig_status run_effect_set(World *w, CommandArg *a)
{
    return do_switch_by_hand(w, a[0].what, a[1].yes);
}

dig_status dig_effect_set(dig_world *w, const char *name, bool on)
{
    return COMMAND(w, COMMAND_EFFECT_SET, do_switch_by_hand(w, name, on), {.what = name}, {.yes = on});
}

static dig_status do_explain(World *w, const char *name, const char *why)
{
    int i = find(w, name);
    if (i < 0)
        return unknown(w, name);
    say_why(&w->effects[i], why);
    return DIG_OK;
}

dig_status run_effect_explain(World *w, CommandArg *a)
{
    return do_explain(w, a[0].what, a[1].what);
}

dig_status dig_effect_explain(dig_world *w, const char *name, const char *why)
{
    return COMMAND(w, COMMAND_EFFECT_EXPLAIN, do_explain(w, name, why), {.what = name}, {.what = why});
}

/* ---- what an effect keeps ---- */

bool dig_effect_schema(int index, const char *part, dig_schema *schema)
{
    if (index < 0)
        return false;
    for (int i = 0; effect_types[i]; i++) {
        const EffectType *t = effect_types[i];
        if (i != index)
            continue;
        bool of_body = strcmp(part, "body") == 0;
        *schema = (dig_schema){t->name, t->law, of_body ? t->body_params : t->world_params, of_body ? t->body_size : t->world_size};
        return true;
    }
    return false;
}

static dig_status join(World *w, int effect, uint32_t body, const void *given, const char *why)
{
    EffectSlot *e = &w->effects[effect];
    const EffectType *t = e->type;
    char reason[256] = "";
    real *member = malloc(t->body_size);
    if (!member)
        return world_fail(w, DIG_E_MEMORY, "effect '%s': not enough memory", e->name);
    memcpy(member, given, t->body_size);
    dig_status s = param_check(t->body_params, member, BODY_TEXT(w, &w->bodies.data[body]), reason, sizeof reason);
    if (s == DIG_OK && t->join)
        s = t->join(w, e, body, member, reason, sizeof reason);
    real before = api_effects_stored(w);
    if (s != DIG_OK)
        world_fail(w, s, "%s", reason);
    else if ((s = column_add(&e->members, body, member, &w->allocations)) != DIG_OK)
        world_fail(w, s, "effect '%s': not enough memory", e->name);
    free(member);
    if (s != DIG_OK)
        return s;
    w->bits.old = true;
    say_why(e, why);
    api_book_stored(w, before);
    body_wake(w, body);
    return DIG_OK;
}

static dig_status do_join_named(World *w, const char *effect, dig_body b, const void *member, const char *why)
{
    int i = find(w, effect);
    if (i < 0)
        return unknown(w, effect);
    if (!api_body(w, b, effect))
        return DIG_E_DEAD;
    if (w->effects[i].owner)
        return api_own_join(w, i, b.slot);
    if (!w->effects[i].type->body_params)
        return world_fail(w, DIG_E_KIND, "effect '%s' keeps nothing of a body", effect);
    return join(w, i, b.slot, member, why);
}

dig_status run_effect_join(World *w, CommandArg *a)
{
    return do_join_named(w, a[0].what, a[1].body, a[2].what, a[3].what);
}

dig_status dig_effect_join(dig_world *w, const char *effect, dig_body b, const void *member, const char *why)
{
    return COMMAND(w, COMMAND_EFFECT_JOIN, do_join_named(w, effect, b, member, why),
                   {.what = effect}, {.body = b}, {.what = member}, {.what = why});
}

static dig_status do_leave(World *w, const char *effect, dig_body b)
{
    int i = find(w, effect);
    if (i < 0)
        return unknown(w, effect);
    if (!api_body(w, b, effect))
        return DIG_E_DEAD;
    real before = api_effects_stored(w);
    column_remove(&w->effects[i].members, b.slot);
    w->bits.old = true;
    api_book_stored(w, before);
    body_wake(w, b.slot);
    return DIG_OK;
}

dig_status run_effect_leave(World *w, CommandArg *a)
{
    return do_leave(w, a[0].what, a[1].body);
}

dig_status dig_effect_leave(dig_world *w, const char *effect, dig_body b)
{
    return COMMAND(w, COMMAND_EFFECT_LEAVE, do_leave(w, effect, b), {.what = effect}, {.body = b});
}

bool dig_effect_member(const dig_world *w, const char *effect, dig_body b, void *member)
{
    int i = find(w, effect);
    const void *there = i >= 0 && world_body(w, b) ? column_find(&w->effects[i].members, b.slot) : NULL;
    if (there)
        memcpy(member, there, w->effects[i].type->body_size);
    return there != NULL;
}

bool dig_effect_options(const dig_world *w, const char *effect, void *options)
{
    int i = find(w, effect);
    if (i < 0 || !w->effects[i].type->world_params)
        return false;
    const EffectSlot *e = &w->effects[i];
    if (e->world) {
        memcpy(options, e->world, e->world_size);
        return true;
    }
    memset(options, 0, e->world_size);
    param_defaults(e->type->world_params, options);
    return false;
}

static dig_status do_set_options(World *w, const char *effect, const void *options, const char *why)
{
    int i = find(w, effect);
    char reason[256];
    if (i < 0)
        return unknown(w, effect);
    EffectSlot *e = &w->effects[i];
    if (!e->type->world_params)
        return world_fail(w, DIG_E_KIND, "effect '%s' has no options", effect);
    if (param_check(e->type->world_params, options, effect, reason, sizeof reason) != DIG_OK)
        return world_fail(w, DIG_E_ARG, "%s", reason);
    real before = api_effects_stored(w);
    if (!e->world && !(e->world = malloc(e->world_size)))
        return world_fail(w, DIG_E_MEMORY, "effect '%s': not enough memory", effect);
    w->allocations++;
    memcpy(e->world, options, e->world_size);
    e->on = true;
    w->bits.old = true;
    say_why(e, why);
    api_book_stored(w, before);
    world_wake_all(w);
    return DIG_OK;
}

dig_status run_effect_option(World *w, CommandArg *a)
{
    return do_set_options(w, a[0].what, a[1].what, a[2].what);
}

dig_status dig_effect_option(dig_world *w, const char *effect, const void *options, const char *why)
{
    return COMMAND(w, COMMAND_EFFECT_OPTION, do_set_options(w, effect, options, why), {.what = effect}, {.what = options}, {.what = why});
}

/* ---- as parameters of a body ---- */

const dig_param *api_effect_row(const World *w, const char *name, int *effect)
{
    for (int i = 0; i < w->effect_count; i++) {
        const dig_param *row = w->effects[i].type->body_params ? param_find(w->effects[i].type->body_params, name) : NULL;
        *effect = i;
        if (row)
            return row;
    }
    return NULL;
}

dig_status api_effect_set(World *w, uint32_t body, int effect, const dig_param *row, const void *value)
{
    const EffectType *t = w->effects[effect].type;
    const void *old = column_find(&w->effects[effect].members, body);
    char *member = calloc(1, t->body_size);
    if (!member)
        return world_fail(w, DIG_E_MEMORY, "effect '%s': not enough memory", t->name);
    param_defaults(t->body_params, member);
    if (old)
        memcpy(member, old, t->body_size);
    memcpy(member + row->offset, value, param_size(row));
    dig_status s = join(w, effect, body, member, NULL);
    free(member);
    return s;
}

dig_status api_effects_follow(World *w, uint32_t body)
{
    for (int i = 0; i < w->effect_count; i++) {
        const EffectType *t = w->effects[i].type;
        const void *member = t->join ? column_find(&w->effects[i].members, body) : NULL;
        if (member)
            DIG_TRY(join(w, i, body, member, NULL));
    }
    return DIG_OK;
}

void api_effect_get(const World *w, uint32_t body, int effect, const dig_param *row, void *value)
{
    const char *member = column_find(&w->effects[effect].members, body);
    if (member) {
        memcpy(value, member + row->offset, param_size(row));
        return;
    }
    real x[4] = {row->fallback, row->fallback, row->fallback, row->fallback};
    memcpy(value, x, param_size(row));
}
