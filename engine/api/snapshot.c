/* api/snapshot.c - a world's whole state, set aside and put back, bit for bit: sleep, warm start, graph ids and all. */
#include "api/api.h"

#include <stdlib.h>

/* A snapshot is a world that never steps: the same tables, copied. */
struct dig_snapshot { World *state; const World *of; };

static dig_status copy_tables(World *to, const World *from)
{
    uint64_t *n = &to->allocations;
    DIG_TRY(list_copy(&to->bodies, &from->bodies, n));
    DIG_TRY(list_copy(&to->pairs, &from->pairs, n));
    DIG_TRY(list_copy(&to->contacts, &from->contacts, n));
    DIG_TRY(list_copy(&to->touches, &from->touches, n));
    DIG_TRY(list_copy(&to->joints, &from->joints, n));
    DIG_TRY(list_copy(&to->pushes, &from->pushes, n));
    DIG_TRY(list_copy(&to->free_regions, &from->free_regions, n));
    DIG_TRY(list_copy(&to->unbounded, &from->unbounded, n));
    DIG_TRY(list_copy(&to->awake, &from->awake, n));
    DIG_TRY(list_copy(&to->asking, &from->asking, n));
    DIG_TRY(list_copy(&to->brief, &from->brief, n));
    DIG_TRY(list_copy(&to->parent, &from->parent, n));
    DIG_TRY(list_copy(&to->materials, &from->materials, n));
    DIG_TRY(list_copy(&to->material_pairs, &from->material_pairs, n));
    DIG_TRY(list_copy(&to->events, &from->events, n));
    DIG_TRY(list_copy(&to->pending, &from->pending, n));
    DIG_TRY(map_copy(&to->pair_map, &from->pair_map));
    DIG_TRY(map_copy(&to->touch_map, &from->touch_map));
    DIG_TRY(tree_copy(&to->tree, &from->tree));
    return graph_copy(&to->graph, from->graph);
}

/* The free lists keep the room that slot_give relies on. */
static dig_status copy_free_lists(World *to, const World *from)
{
    uint64_t *n = &to->allocations;
    DIG_TRY(list_reserve(&to->free_bodies, from->free_bodies.capacity, n));
    DIG_TRY(list_reserve(&to->free_solids, from->free_solids.capacity, n));
    DIG_TRY(list_reserve(&to->free_pairs, from->free_pairs.capacity, n));
    DIG_TRY(list_reserve(&to->free_contacts, from->free_contacts.capacity, n));
    DIG_TRY(list_reserve(&to->free_touches, from->free_touches.capacity, n));
    DIG_TRY(list_reserve(&to->free_joints, from->free_joints.capacity, n));
    DIG_TRY(list_copy(&to->free_bodies, &from->free_bodies, n));
    DIG_TRY(list_copy(&to->free_solids, &from->free_solids, n));
    DIG_TRY(list_copy(&to->free_pairs, &from->free_pairs, n));
    DIG_TRY(list_copy(&to->free_contacts, &from->free_contacts, n));
    DIG_TRY(list_copy(&to->free_touches, &from->free_touches, n));
    return list_copy(&to->free_joints, &from->free_joints, n);
}

/* Lists that a call may only fill, never grow, need the capacity they had. */
static dig_status reserve_like(World *to, const World *from)
{
    uint64_t *n = &to->allocations;
    DIG_TRY(list_reserve(&to->asking, from->asking.capacity, n));
    DIG_TRY(list_reserve(&to->awake, from->awake.capacity, n));
    return list_reserve(&to->brief, from->brief.capacity, n);
}

/* Everything that holds a shape gives up its reference. */
static void drop_shapes(World *w)
{
    for (int i = 0; i < w->solids.count; i++)
        if (w->solids.data[i].alive)
            shape_free(&w->solids.data[i].shape);
    for (int i = 0; i < w->regions.count; i++)
        if (w->regions.data[i].alive)
            shape_free(&w->regions.data[i].shape);
    list_close(&w->solids);
    list_close(&w->regions);
}

static dig_status copy_world(World *to, const World *from)
{
    struct { LIST(Solid) solids; LIST(Region) regions; } fresh = {0};
    dig_status s = list_copy(&fresh.solids, &from->solids, &to->allocations);
    if (s == DIG_OK)
        s = list_copy(&fresh.regions, &from->regions, &to->allocations);
    if (s == DIG_OK)
        s = copy_tables(to, from);
    if (s == DIG_OK)
        s = copy_free_lists(to, from);
    if (s == DIG_OK)
        s = reserve_like(to, from);
    if (s != DIG_OK) {
        list_close(&fresh.solids);
        list_close(&fresh.regions);
        return s;
    }
    for (int i = 0; i < fresh.solids.count; i++)
        if (fresh.solids.data[i].alive)
            fresh.solids.data[i].shape = shape_keep(&from->solids.data[i].shape);
    for (int i = 0; i < fresh.regions.count; i++)
        if (fresh.regions.data[i].alive)
            fresh.regions.data[i].shape = shape_keep(&from->regions.data[i].shape);
    drop_shapes(to);
    memcpy(&to->solids, &fresh.solids, sizeof to->solids);      /* LISTs are anonymous types: alike, but not assignable */
    memcpy(&to->regions, &fresh.regions, sizeof to->regions);
    to->region_count = from->region_count;
    to->def = from->def;
    to->plan = from->plan;
    to->dig_plans = from->dig_plans;
    to->steps = from->steps;
    to->rng = from->rng;
    to->messages = from->messages;
    to->room = from->room;
    to->has_room = from->has_room;
    memcpy(to->room_solid, from->room_solid, sizeof to->room_solid);
    to->ledger = from->ledger;
    to->stats = from->stats;
    for (int i = 0; i < from->effect_count; i++) {
        to->effects[i].on = from->effects[i].on;
        to->effects[i].forced = from->effects[i].forced;
    }
    return DIG_OK;
}

dig_status dig_world_snapshot(dig_world *w, dig_snapshot **out)
{
    char why[64];
    *out = NULL;
    dig_snapshot *s = calloc(1, sizeof *s);
    if (!s || world_open(&w->def, &s->state, why, sizeof why) != DIG_OK) {
        free(s);
        return world_fail(w, DIG_E_MEMORY, "not enough memory for a snapshot");
    }
    s->of = w;
    s->state->effect_count = w->effect_count;
    if (copy_world(s->state, w) != DIG_OK) {
        s->state->effect_count = 0;
        dig_snapshot_free(s);
        return world_fail(w, DIG_E_MEMORY, "not enough memory for a snapshot");
    }
    *out = s;
    return DIG_OK;
}

/* Handle numbers go on counting from where the world is: a body made after the snapshot stays dead afterwards. */
dig_status dig_world_restore(dig_world *w, const dig_snapshot *s)
{
    if (s->of != w)
        return world_fail(w, DIG_E_KIND, "restore: the snapshot is of another world");
    if (copy_world(w, s->state) != DIG_OK)
        return world_fail(w, DIG_E_MEMORY, "not enough memory to restore a snapshot; the world may be half restored");
    return DIG_OK;
}

void dig_snapshot_free(dig_snapshot *s)
{
    if (!s)
        return;
    world_close(s->state);
    free(s);
}
