/* api/snapshot.c - a world's whole state, set aside and put back, bit for bit: sleep, warm start, graph ids and all. */
#include "api/api.h"
#include "api/command.h"

#include <stdlib.h>

enum { COPIED = 10 };           /* units of world_work for each thing */

/* A snapshot is a world that never steps: the same tables, copied. */
struct dig_snapshot {
    World       *state;
    const World *of;
    Tap         *tap;           /* who listened when it was taken; NULL: nobody */
    uint64_t     number;        /* of it there                                  */
};

/* ---- copying ---- */

static dig_status copy_tables(World *to, const World *from)
{
    uint64_t *n = &to->allocations;
    for (int i = 0; i < to->bodies.count; i++)
        body_shares_drop(&to->bodies.data[i]);
    DIG_TRY(list_copy(&to->bodies, &from->bodies, n));
    for (int i = 0; i < to->bodies.count; i++)
        body_shares_keep(&to->bodies.data[i]);
    DIG_TRY(bodies_rest(to));
    for (int i = 0; i < from->bodies.count; i++)
        if (from->bodies.data[i].rests)
            to->rest.data[i] = from->rest.data[i];
    for (int i = 0; i < from->bodies.count; i++)
        if (from->bodies.data[i].crowded)
            to->drifts.data[i] = from->drifts.data[i];
    DIG_TRY(list_copy(&to->pairs, &from->pairs, n));
    DIG_TRY(list_copy(&to->memories, &from->memories, n));
    DIG_TRY(list_copy(&to->contacts, &from->contacts, n));
    DIG_TRY(contacts_rest(to));
    for (int i = 0; i < from->contacts.count; i++)
        if (from->contacts.data[i].rests)
            to->contact_rest.data[i] = from->contact_rest.data[i];
    DIG_TRY(list_copy(&to->more, &from->more, n));
    DIG_TRY(list_copy(&to->touches, &from->touches, n));
    DIG_TRY(list_copy(&to->joints, &from->joints, n));
    DIG_TRY(list_copy(&to->pushes, &from->pushes, n));
    DIG_TRY(list_copy(&to->unbounded, &from->unbounded, n));
    DIG_TRY(list_copy(&to->awake, &from->awake, n));
    DIG_TRY(list_copy(&to->near, &from->near, n));
    DIG_TRY(list_copy(&to->asking, &from->asking, n));
    DIG_TRY(list_copy(&to->brief, &from->brief, n));
    DIG_TRY(list_copy(&to->parent, &from->parent, n));
    DIG_TRY(list_copy(&to->materials, &from->materials, n));
    DIG_TRY(list_copy(&to->material_pairs, &from->material_pairs, n));
    to->paired = from->paired;
    DIG_TRY(list_copy(&to->events, &from->events, n));
    DIG_TRY(list_copy(&to->pending, &from->pending, n));
    DIG_TRY(index_copy(&to->pair_index, &from->pair_index));
    DIG_TRY(index_copy(&to->touch_index, &from->touch_index));
    DIG_TRY(tree_copy(&to->tree, &from->tree));
    for (int i = 0; i < DIG_LAYERS; i++)
        DIG_TRY(layer_copy(&to->layers[i], &from->layers[i], n));
    DIG_TRY(mail_copy(&to->mail, &from->mail, n));
    return graph_copy(&to->graph, from->graph);
}

/* The free lists keep the room that slot_give relies on. */
static dig_status copy_free_lists(World *to, const World *from)
{
    uint64_t *n = &to->allocations;
    DIG_TRY(list_reserve(&to->free_bodies, from->free_bodies.capacity, n));
    DIG_TRY(list_reserve(&to->free_solids, from->free_solids.capacity, n));
    DIG_TRY(list_reserve(&to->free_pairs, from->free_pairs.capacity, n));
    DIG_TRY(list_reserve(&to->free_memories, from->free_memories.capacity, n));
    DIG_TRY(list_reserve(&to->free_contacts, from->free_contacts.capacity, n));
    DIG_TRY(list_reserve(&to->free_more, from->free_more.capacity, n));
    DIG_TRY(list_reserve(&to->free_touches, from->free_touches.capacity, n));
    DIG_TRY(list_reserve(&to->free_joints, from->free_joints.capacity, n));
    DIG_TRY(list_reserve(&to->free_regions, from->free_regions.capacity, n));
    DIG_TRY(list_copy(&to->free_bodies, &from->free_bodies, n));
    DIG_TRY(list_copy(&to->free_solids, &from->free_solids, n));
    DIG_TRY(list_copy(&to->free_pairs, &from->free_pairs, n));
    DIG_TRY(list_copy(&to->free_memories, &from->free_memories, n));
    DIG_TRY(list_copy(&to->free_contacts, &from->free_contacts, n));
    DIG_TRY(list_copy(&to->free_more, &from->free_more, n));
    DIG_TRY(list_copy(&to->free_touches, &from->free_touches, n));
    DIG_TRY(list_copy(&to->free_joints, &from->free_joints, n));
    return list_copy(&to->free_regions, &from->free_regions, n);
}

/* Lists that a call may only fill, never grow, need the capacity they had. */
static dig_status reserve_like(World *to, const World *from)
{
    uint64_t *n = &to->allocations;
    DIG_TRY(list_reserve(&to->asking, from->asking.capacity, n));
    DIG_TRY(list_reserve(&to->awake, from->awake.capacity, n));
    return list_reserve(&to->brief, from->brief.capacity, n);
}

static void free_shapes(World *w)
{
    for (int i = 0; i < w->solids.count; i++)
        if (w->solids.data[i].alive)
            form_drop(w->solids.data[i].form);
    for (int i = 0; i < w->regions.count; i++)
        if (w->regions.data[i].alive)
            shape_free(&w->regions.data[i].shape);
    w->solids.count = w->regions.count = 0;
}

/* Shapes never change: both worlds hold the same ones. */
static dig_status copy_shapes(World *to, const World *from)
{
    free_shapes(to);
    DIG_TRY(list_reserve(&to->solids, from->solids.count, &to->allocations));
    DIG_TRY(list_copy(&to->regions, &from->regions, &to->allocations));
    for (int i = 0; i < to->regions.count; i++)
        if (to->regions.data[i].alive)
            to->regions.data[i].shape = shape_keep(&from->regions.data[i].shape);
    DIG_TRY(list_copy(&to->solids, &from->solids, &to->allocations));
    for (int i = 0; i < to->solids.count; i++)
        if (to->solids.data[i].alive)
            share_keep(to->solids.data[i].form);
    return DIG_OK;
}

static void copy_numbers(World *to, const World *from)
{
    to->region_count = from->region_count;
    to->def = from->def;
    to->accuracy = from->accuracy;
    to->dig_accuracies = from->dig_accuracies;
    to->steps = from->steps;
    to->rng = from->rng;
    message_copy(&to->messages, &from->messages);
    to->room = from->room;
    to->has_room = from->has_room;
    memcpy(to->room_solid, from->room_solid, sizeof to->room_solid);
    to->ledger = from->ledger;
    to->tally = from->tally;
    to->stats = from->stats;
    memcpy(to->warnings, from->warnings, sizeof to->warnings);
    to->warning_count = from->warning_count;
}

/* The options of one effect; who takes part is another matter. */
static dig_status copy_effect(EffectSlot *to, const EffectSlot *from)
{
    void *options = to->world;
    Column members = to->members;
    if (from->owner && !to->owner)
        from->owner->users++;
    if (from->world && !options && !(options = malloc(from->world_size)))
        return DIG_E_MEMORY;
    if (!from->world) {
        free(options);
        options = NULL;
    }
    *to = *from;
    to->world = options;
    to->members = members;
    to->members.size = from->members.size;
    if (options)
        memcpy(options, from->world, from->world_size);
    return DIG_OK;
}

dig_status api_copy_effects(World *to, const World *from)
{
    to->flowing = from->flowing;
    to->met = from->met;
    to->bits.old = true;
    for (int i = 0; i < from->effect_count; i++) {
        EffectSlot *e = &to->effects[i];
        if (i >= to->effect_count)
            *e = (EffectSlot){0};
        to->effect_count = int_max(to->effect_count, i + 1);
        DIG_TRY(copy_effect(e, &from->effects[i]));
    }
    return DIG_OK;
}

static dig_status copy_members(World *to, const World *from)
{
    for (int i = 0; i < from->effect_count; i++)
        DIG_TRY(column_copy(&to->effects[i].members, &from->effects[i].members, &to->allocations));
    return DIG_OK;
}

dig_status api_refill(World *to, const World *from)
{
    world_work_through(from, COPIED);
    world_work_through(to, COPIED);
    DIG_TRY(copy_shapes(to, from));
    DIG_TRY(copy_tables(to, from));
    DIG_TRY(copy_free_lists(to, from));
    DIG_TRY(reserve_like(to, from));
    DIG_TRY(api_copy_effects(to, from));
    DIG_TRY(copy_members(to, from));
    copy_numbers(to, from);
    return DIG_OK;
}

dig_status api_clone(const World *from, World **out)
{
    char why[64];
    World *to;
    DIG_TRY(world_open(&from->def, &to, why, sizeof why));
    dig_status s = api_refill(to, from);
    if (s == DIG_OK)
        *out = to;
    else
        world_close(to);
    return s;
}

/* ---- the calls ---- */

static dig_status do_snapshot(World *w, dig_snapshot **out)
{
    *out = NULL;
    if (w->busy)
        return world_fail(w, DIG_E_BUSY, "world:snapshot() cannot be called while the world is stepping");
    dig_snapshot *s = calloc(1, sizeof *s);
    if (!s || api_clone(w, &s->state) != DIG_OK) {
        free(s);
        return world_fail(w, DIG_E_MEMORY, "not enough memory for a snapshot");
    }
    s->of = w;
    s->state->gen_start = w->gen_start;         /* its handles are those of the world */
    s->state->serial = w->serial;
    *out = s;
    return DIG_OK;
}

/* Played, it is kept by its number until it is forgotten. */
dig_status run_snapshot(World *w, CommandArg *a)
{
    dig_snapshot *s;
    DIG_TRY(do_snapshot(w, a[1].place ? a[1].place : &s));
    if (a[1].place)
        return DIG_OK;
    Playback *b = w->playback;
    if (list_push(&b->snapshots, &b->allocations) != DIG_OK) {
        dig_snapshot_free(s);
        return world_fail(w, DIG_E_MEMORY, "not enough memory for a snapshot");
    }
    b->snapshots.data[b->snapshots.count - 1] = (PlaybackSnapshot){a[0].whole, s};
    return DIG_OK;
}

dig_status dig_world_snapshot(dig_world *w, dig_snapshot **out)
{
    if (!w->tap)
        return do_snapshot(w, out);
    DIG_TRY(command_do(w, COMMAND_SNAPSHOT, (CommandArg[COMMAND_ARGS]){{.whole = w->tap->snapshots + 1}, {.place = out}}));
    (*out)->number = ++w->tap->snapshots;
    (*out)->tap = w->tap;
    w->tap->users++;
    return DIG_OK;
}

static void swap_bytes(void *a, void *b, size_t size)
{
    unsigned char *x = a, *y = b, part[512];
    for (size_t n; size > 0; x += n, y += n, size -= n) {
        n = size < sizeof part ? size : sizeof part;
        memcpy(part, x, n);
        memcpy(x, y, n);
        memcpy(y, part, n);
    }
}

/* The world gets the state of the other, which gets the old one. What is no state stays: threads, scratch memory. Handle
 * numbers go on counting, so that a body made after the snapshot is dead for ever. */
static void exchange(World *w, World *other)
{
    swap_bytes(w, other, sizeof *w);
    swap_bytes(&w->serial, &other->serial, sizeof w->serial);
    swap_bytes(&w->gen_start, &other->gen_start, sizeof w->gen_start);
    swap_bytes(&w->scratch, &other->scratch, sizeof w->scratch);
    swap_bytes(&w->group_scratch, &other->group_scratch, sizeof w->group_scratch);
    swap_bytes(&w->workers, &other->workers, sizeof w->workers);
    swap_bytes(&w->error, &other->error, sizeof w->error);
    swap_bytes(&w->tap, &other->tap, sizeof w->tap);
    swap_bytes(&w->playback, &other->playback, sizeof w->playback);
    w->allocations += other->allocations;
    w->work += other->work;
}

static dig_status do_restore(World *w, const dig_snapshot *s)
{
    World *fresh;
    if (w->busy)
        return world_fail(w, DIG_E_BUSY, "world:restore() cannot be called while the world is stepping");
    if (s->of != w)
        return world_fail(w, DIG_E_KIND, "restore: the snapshot is of another world");
    if (api_clone(s->state, &fresh) != DIG_OK)
        return world_fail(w, DIG_E_MEMORY, "not enough memory to restore a snapshot");
    exchange(w, fresh);
    world_close(fresh);
    return DIG_OK;
}

static int played(const Playback *b, uint64_t number)
{
    for (int i = 0; b && i < b->snapshots.count; i++)
        if (b->snapshots.data[i].number == number)
            return i;
    return -1;
}

dig_status run_restore(World *w, CommandArg *a)
{
    int i = a[1].what ? 0 : played(w->playback, a[0].whole);
    if (i < 0)
        return world_fail(w, DIG_E_DEAD, "restore: there is no snapshot %llu", (unsigned long long)a[0].whole);
    return do_restore(w, a[1].what ? a[1].what : w->playback->snapshots.data[i].snapshot);
}

/* The snapshot is older than the log: its state is in the command. */
dig_status run_restore_saved(World *w, CommandArg *a)
{
    char why[256];
    World *fresh;
    const CommandBytes *bytes = a[0].what;
    if (a[1].what)
        return do_restore(w, a[1].what);
    if (w->busy)
        return world_fail(w, DIG_E_BUSY, "restore: the world is stepping");
    dig_status s = save_read(bytes->data, bytes->size, w->gen_start, &fresh, why, sizeof why);
    if (s != DIG_OK)
        return world_fail(w, s, "restore: %s", why);
    exchange(w, fresh);
    dig_world_close(fresh);             /* with its threads */
    return DIG_OK;
}

dig_status run_forget(World *w, CommandArg *a)
{
    int i = played(w->playback, a[0].whole);
    if (i < 0)
        return world_fail(w, DIG_E_DEAD, "there is no snapshot %llu", (unsigned long long)a[0].whole);
    Playback *b = w->playback;
    dig_snapshot_free(b->snapshots.data[i].snapshot);
    b->snapshots.data[i] = b->snapshots.data[--b->snapshots.count];
    return DIG_OK;
}

static dig_status restore_saved(World *w, const dig_snapshot *s)
{
    void *data;
    size_t size;
    DIG_TRY(dig_world_pack(s->state, &data, &size));
    const CommandBytes bytes = {data, size};
    dig_status status = command_do(w, COMMAND_RESTORE_SAVED, (CommandArg[COMMAND_ARGS]){{.what = &bytes}, {.what = s}});
    free(data);
    return status == DIG_OK ? tap_effects(w) : status;
}

dig_status dig_world_restore(dig_world *w, const dig_snapshot *s)
{
    if (!w->tap)
        return do_restore(w, s);
    if (s->of == w && s->tap != w->tap && !w->busy)
        return restore_saved(w, s);
    return command_do(w, COMMAND_RESTORE, (CommandArg[COMMAND_ARGS]){{.whole = s->number}, {.what = s}});
}

void dig_snapshot_free(dig_snapshot *s)
{
    if (!s)
        return;
    if (s->tap)
        tap_forget(s->tap, s->number);
    tap_release(s->tap);
    world_close(s->state);
    free(s);
}
