/* api/own.c - effects of the caller's: a function that is asked for forces, or to look, run through the table of the others.
 *
 * Each gets an EffectType of its own, which worlds and their snapshots share. Who takes part stands in the column of its slot,
 * with a number that nobody reads.
 */
#include "api/api.h"
#include "api/command.h"

#include <stdio.h>
#include <stdlib.h>

typedef struct OwnEffect {
    EffectOwner    owner;           /* comes first: a slot's owner is its address */
    EffectType     type;
    dig_effect_def def;
    char           name[32], law[96];
} OwnEffect;

static const OwnEffect *own_of(const EffectSlot *e) { return (const OwnEffect *)(const void *)e->owner; }

const char *dig_stage_name(dig_stage s)
{
    static const char *const names[] = {[DIG_STAGE_FORCE] = "force", [DIG_STAGE_SETTLE] = "settle"};
    return (unsigned)s < DIG_STAGES ? names[s] : NULL;
}

/* ---- on groups ---- */

static bool takes_part(const EffectSlot *e, const Group *g, int i)
{
    return g->member[i].moves && (e->owner->all || column_find(&e->members, g->member[i].slot));
}

static dig_effect_part part_of(const Group *g, int i)
{
    const Member *m = &g->member[i];
    const Pos *p = &g->pos[i];
    vec3 centre = g->world->bodies.data[m->slot].centre;
    return (dig_effect_part){.body = body_handle(g->world, m->slot), .position = vec3_sub(p->x, quat_rotate(p->q, centre)), .rotation = p->q,
                             .centre = p->x, .velocity = g->vel[i].v, .spin = g->vel[i].w, .mass = m->mass};
}

static dig_status ask(const EffectSlot *e, Group *g, real dt)
{
    const OwnEffect *o = own_of(e);
    char why[400] = "";
    int n = 0;
    if (!g->parts && !(g->parts = arena_alloc(g->lasting, (size_t)g->moving_count * sizeof *g->parts)))
        return DIG_E_MEMORY;
    for (int i = 0; i < g->moving_count; i++)
        if (takes_part(e, g, i))
            g->parts[n++] = part_of(g, i);
    dig_effect_call call = {world_time(g->world) + g->t, dt, g->parts, n};
    dig_status s = n > 0 ? o->def.step(o->def.data, &call, why, sizeof why) : DIG_OK;
    if (n > 0)
        DIG_TRY(command_answer(g->world, s, &call, why));
    if (s != DIG_OK)
        return world_fail(g->world, DIG_E_ARG, "at t = %g s effect '%s': %s", call.time, o->name, why);
    return DIG_OK;
}

#define INSTANT 1e-12           /* s  the traced way asks for a time this short: there it means no time */

static dig_status force(const EffectSlot *e, Group *g)
{
    DIG_TRY(ask(e, g, g->h > INSTANT ? g->h : 0));
    const OwnEffect *o = own_of(e);
    g->stores = true;               /* what its forces do is not in the group's energy */
    for (int i = 0, n = 0; i < g->moving_count; i++) {
        Member *m = &g->member[i];
        if (!takes_part(e, g, i))
            continue;
        if (o->def.energy) {            /* it says itself what it stores */
            m->force = vec3_add(m->force, g->parts[n].force);
            m->torque = vec3_add(m->torque, g->parts[n].torque);
        } else {
            group_rule(g, i, g->parts[n].force, g->parts[n].torque);
        }
        n++;
    }
    return DIG_OK;
}

static dig_status settle(const EffectSlot *e, Group *g) { return ask(e, g, g->world->def.step); }

/* ---- on the world ---- */

static void energy(const World *w, const EffectSlot *e, dig_energy *sum)
{
    const OwnEffect *o = own_of(e);
    dig_effect_part *parts = malloc((size_t)(w->bodies.count + 1) * sizeof *parts);
    dig_effect_call call = {world_time(w), 0, parts, 0};
    for (int i = 0; parts && i < w->bodies.count; i++) {
        const Body *b = &w->bodies.data[i];
        if (b->alive && b->kind == DIG_DYNAMIC && (o->owner.all || column_find(&e->members, (uint32_t)i)))
            parts[call.count++] = (dig_effect_part){.body = body_handle(w, (uint32_t)i), .position = body_pose(b).p, .rotation = b->q,
                                                    .centre = b->x, .velocity = b->v, .spin = b->w, .mass = b->mass};
    }
    real stored = call.count > 0 && e->on ? o->def.energy(o->def.data, &call) : 0;
    if (call.count > 0 && e->on)
        command_answer_energy(w, stored);
    sum->elastic += isfinite(stored) ? stored : 0;
    free(parts);
}

/* ---- adding ---- */

static void end(EffectOwner *o) { free(o); }

static dig_status check(const World *w, const dig_effect_def *def)
{
    if (w->busy)
        return world_fail(w, DIG_E_BUSY, "an effect cannot be added while the world is stepping");
    if (!def->name || !def->name[0] || strlen(def->name) >= sizeof ((OwnEffect *)0)->name)
        return world_fail(w, DIG_E_ARG, "an effect's name has 1 to 31 bytes; got %zu", def->name ? strlen(def->name) : 0);
    for (int i = 0; i < w->effect_count; i++)
        if (strcmp(w->effects[i].name, def->name) == 0)
            return world_fail(w, DIG_E_ARG, "there is an effect '%s' already", def->name);
    if (!dig_stage_name(def->stage) || !def->step)
        return world_fail(w, DIG_E_ARG, "effect '%s' needs a stage, force or settle, and a function", def->name);
    if (w->effect_count >= MAX_EFFECTS)
        return world_fail(w, DIG_E_FULL, "effect '%s': a world has at most %d effects", def->name, MAX_EFFECTS);
    return DIG_OK;
}

static void set_type(OwnEffect *o, const dig_effect_def *def)
{
    o->owner = (EffectOwner){.users = 1, .all = def->all, .bytes = sizeof *o, .end = end};
    o->def = *def;
    snprintf(o->name, sizeof o->name, "%s", def->name);
    snprintf(o->law, sizeof o->law, "%s", def->law ? def->law : "");
    o->def.name = o->type.name = o->name;
    o->def.law = o->type.law = o->law;
    o->def.why = NULL;
    o->type.cite = "";
    o->type.varies = def->stage == DIG_STAGE_FORCE;
    o->type.run[STAGE_FORCE] = def->stage == DIG_STAGE_FORCE ? force : NULL;
    o->type.run[STAGE_SETTLE] = def->stage == DIG_STAGE_SETTLE ? settle : NULL;
    o->type.energy = def->energy ? energy : NULL;
}

static dig_status place(World *w, const dig_effect_def *def)
{
    OwnEffect *o = calloc(1, sizeof *o);
    if (!o)
        return world_fail(w, DIG_E_MEMORY, "effect '%s': not enough memory", def->name);
    set_type(o, def);
    w->allocations++;
    w->effects[w->effect_count] = (EffectSlot){.type = &o->type, .name = o->name, .on = true, .members = {.size = sizeof(real)}, .owner = &o->owner};
    EffectSlot *e = &w->effects[w->effect_count++];
    w->bits.old = true;
    if (def->why)
        snprintf(e->why, sizeof e->why, "%s", def->why);
    return DIG_OK;
}

static dig_status do_add(World *w, const dig_effect_def *def)
{
    DIG_TRY(check(w, def));
    real before = api_effects_stored(w);
    DIG_TRY(place(w, def));
    api_book_stored(w, before);
    world_wake_all(w);
    return DIG_OK;
}

dig_status run_effect_add(World *w, CommandArg *a)
{
    return do_add(w, a[0].what);
}

dig_status dig_effect_add(dig_world *w, const dig_effect_def *def)
{
    return COMMAND(w, COMMAND_EFFECT_ADD, do_add(w, def), {.what = def});
}

static dig_status do_drop(World *w, const char *name)
{
    int i = w->effect_count - 1;
    while (i >= 0 && !(w->effects[i].owner && strcmp(w->effects[i].name, name) == 0))
        i--;
    if (i < 0 || w->busy)
        return world_fail(w, i < 0 ? DIG_E_ARG : DIG_E_BUSY, i < 0 ? "no effect '%s' was added" : "effect '%s': the world is stepping", name);
    real before = api_effects_stored(w);
    EffectSlot gone = w->effects[i];
    w->effect_count--;
    w->met = UINT32_MAX;                /* places have changed */
    w->bits.old = true;
    memmove(&w->effects[i], &w->effects[i + 1], (size_t)(w->effect_count - i) * sizeof gone);
    w->effects[w->effect_count] = (EffectSlot){.type = NULL};
    column_close(&gone.members);
    if (--gone.owner->users == 0)
        gone.owner->end(gone.owner);
    api_book_stored(w, before);
    world_wake_all(w);
    return DIG_OK;
}

dig_status run_effect_drop(World *w, CommandArg *a)
{
    return do_drop(w, a[0].what);
}

dig_status dig_effect_drop(dig_world *w, const char *name)
{
    return COMMAND(w, COMMAND_EFFECT_DROP, do_drop(w, name), {.what = name});
}

/* ---- in a log ---- */

/* What is there when a log begins is put there as it is: nothing is booked, and nobody wakes. */
dig_status run_effect_there(World *w, CommandArg *a)
{
    const CommandEffect *c = a[0].what;
    const real none = 0;
    if (a[1].yes)                       /* it is there, and only told of */
        return DIG_OK;
    DIG_TRY(check(w, &c->def));
    for (int i = 0; i < c->count; i++)
        if (!api_body(w, c->members[i], c->def.name))
            return DIG_E_DEAD;
    DIG_TRY(place(w, &c->def));
    EffectSlot *e = &w->effects[w->effect_count - 1];
    e->on = c->on;
    e->forced = c->forced;
    for (int i = 0; i < c->count; i++)
        if (column_add(&e->members, c->members[i].slot, &none, &w->allocations) != DIG_OK)
            return world_fail(w, DIG_E_MEMORY, "effect '%s': not enough memory", e->name);
    return DIG_OK;
}

static dig_status tell_there(World *w, const EffectSlot *e)
{
    const OwnEffect *o = own_of(e);
    dig_body *members = malloc((size_t)(e->members.count + 1) * sizeof *members);
    if (!members)
        return world_fail(w, DIG_E_MEMORY, "effect '%s': not enough memory", e->name);
    for (int i = 0; i < e->members.count; i++)
        members[i] = body_handle(w, e->members.body[i]);
    CommandEffect c = {o->def, e->on, e->forced, members, e->members.count};
    c.def.why = e->why;
    dig_status s = command_do(w, COMMAND_EFFECT_THERE, (CommandArg[COMMAND_ARGS]){{.what = &c}, {.yes = true}});
    free(members);
    return s;
}

dig_status tap_effects(World *w)
{
    for (int i = 0; i < w->effect_count; i++)
        if (w->effects[i].owner)
            DIG_TRY(tell_there(w, &w->effects[i]));
    return DIG_OK;
}

dig_status api_own_join(World *w, int effect, uint32_t body)
{
    const real none = 0;
    EffectSlot *e = &w->effects[effect];
    real before = api_effects_stored(w);
    if (column_add(&e->members, body, &none, &w->allocations) != DIG_OK)
        return world_fail(w, DIG_E_MEMORY, "effect '%s': not enough memory", e->name);
    w->bits.old = true;
    api_book_stored(w, before);
    body_wake(w, body);
    return DIG_OK;
}
