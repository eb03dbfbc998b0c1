/* api/save_effect.c - what effects keep, as bytes: which are on, their options, their members. */
#include "api/save.h"

#include <stdio.h>
#include <stdlib.h>

static EffectSlot *find(World *w, const char *name)
{
    for (int i = 0; i < w->effect_count; i++)
        if (strcmp(w->effects[i].name, name) == 0)
            return &w->effects[i];
    return NULL;
}

/* All its reals, those that rows declare and those that are private. */
static void pack_struct(Pack *p, const dig_param *rows, real *x, size_t size, const char *subject)
{
    char why[200];
    for (size_t i = 0; i < size / sizeof *x; i++)
        pack_real(p, &x[i]);
    if (!p->reading || !pack_good(p))
        return;
    for (size_t i = 0; i < size / sizeof *x; i++)
        pack_check(p, !(fabs(x[i]) > SAVE_MUCH), "a number of an effect is too large");
    if (param_check(rows, x, subject, why, sizeof why) != DIG_OK)
        pack_fail(p, "%s", why);
}

static void pack_options(Pack *p, World *w, EffectSlot *e)
{
    bool there = e->world != NULL;
    pack_bool(p, &there);
    if (!there || !pack_good(p) || !pack_check(p, e->type->world_params != NULL, "an effect has no options"))
        return;
    if (p->reading && !e->world && !(e->world = calloc(1, e->world_size))) {
        pack_fail_memory(p);
        return;
    }
    w->allocations += p->reading;
    pack_struct(p, e->type->world_params, e->world, e->world_size, e->name);
}

static void pack_member(Pack *p, World *w, EffectSlot *e, int i, real *member)
{
    uint32_t body = p->reading ? 0 : e->members.body[i];
    pack_index(p, &body, (uint32_t)w->bodies.count, false, "body of an effect");
    if (!pack_good(p) || !pack_check(p, w->bodies.data[body].alive, "a body of an effect is not there"))
        return;
    if (!p->reading)
        memcpy(member, column_at(&e->members, i), e->members.size);
    pack_struct(p, e->type->body_params, member, e->members.size, body_name(w, &w->bodies.data[body]));
    if (p->reading && pack_good(p) && column_add(&e->members, body, member, &w->allocations) != DIG_OK)
        pack_fail_memory(p);
}

static void pack_members(Pack *p, World *w, EffectSlot *e)
{
    uint32_t count = pack_count(p, (uint32_t)e->members.count, 4 + e->members.size, "members of an effect");
    if (count == 0 || !pack_good(p) || !pack_check(p, e->type->body_params != NULL, "an effect has no members"))
        return;
    real *member = malloc(e->members.size);
    if (!member) {
        pack_fail_memory(p);
        return;
    }
    for (uint32_t i = 0; i < count && pack_good(p); i++)
        pack_member(p, w, e, (int)i, member);
    free(member);
}

/* By name: the list of another build may have another order. */
void save_effects(Pack *p, World *w)
{
    int listed = 0;
    w->met = p->reading ? UINT32_MAX : w->met;
    w->bits.old = w->bits.old || p->reading;
    while (listed < w->effect_count && !w->effects[listed].owner)       /* those of the caller's come last, and cannot be saved */
        listed++;
    uint32_t count = pack_count(p, (uint32_t)listed, 16, "effects");
    for (uint32_t i = 0; i < count && pack_good(p); i++) {
        char name[64] = "";
        if (!p->reading)
            snprintf(name, sizeof name, "%s", w->effects[i].name);
        pack_text(p, name, sizeof name);
        EffectSlot *e = find(w, name);
        if (!e) {
            pack_fail(p, "there is no effect '%s'", name);
            return;
        }
        uint32_t bodies = (uint32_t)e->bodies;
        pack_bool(p, &e->on);
        pack_bool(p, &e->forced);
        pack_index(p, &bodies, INT32_MAX, false, "a statistic");
        e->bodies = (int)bodies;
        pack_text(p, e->why, sizeof e->why);
        pack_options(p, w, e);
        pack_members(p, w, e);
    }
}
