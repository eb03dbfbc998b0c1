/* api/save_world.c - the sections of the world as a whole: settings, materials, lists, events, messages, note. */
#include "api/save.h"
#include "world/graph_save.h"

#include <stdio.h>
#include <stdlib.h>

/* ---- settings ---- */

/* Gravity may be set beyond what a new world is given. */
void save_def(Pack *p, dig_world_def *def)
{
    vec3 gravity = def->gravity;
    dig_world_def rest = *def;
    rest.gravity = vec3_zero();
    pack_vec3(p, &gravity, SAVE_FAST, "gravity");
    save_rows(p, NULL, dig_schema_at("world", 0)->rows, &rest, "world");
    if (p->reading) {
        *def = rest;
        def->gravity = gravity;
    }
}

static void pack_ledger(Pack *p, Ledger *l)
{
    pack_bool(p, &l->started);
    pack_real_in(p, &l->work_in, -SAVE_MUCH, SAVE_MUCH, "work");
    pack_real_in(p, &l->law, -SAVE_MUCH, SAVE_MUCH, "work of laws");
    pack_real_in(p, &l->lost, -SAVE_MUCH, SAVE_MUCH, "energy lost");
    pack_real_in(p, &l->initial, -SAVE_MUCH, SAVE_MUCH, "initial energy");
    pack_real_in(p, &l->last_total, -SAVE_MUCH, SAVE_MUCH, "last energy");
}

static void pack_number(Pack *p, int *n)
{
    uint32_t i = (uint32_t)*n;
    pack_index(p, &i, INT32_MAX, false, "a statistic");
    *n = (int)i;
}

/* Without the times, which no two runs share, and what is counted when asked. */
static void pack_stats(Pack *p, dig_stats *s)
{
    pack_u64(p, &s->events);
    pack_u64(p, &s->steps);
    pack_u64(p, &s->rejected);
    pack_u64(p, &s->posted);
    pack_u64(p, &s->delivered);
    pack_u64(p, &s->dropped);
    pack_u64(p, &s->repeated);
    pack_u64(p, &s->storms);
    pack_number(p, &s->groups);
    pack_number(p, &s->iterations);
    pack_number(p, &s->substeps);
    pack_number(p, &s->located);
    pack_real(p, &s->residual);
    pack_real(p, &s->penetration);
    pack_real(p, &s->joint_error);
}

static void pack_room(Pack *p, World *w)
{
    pack_bool(p, &w->has_room);
    if (!w->has_room)
        return;
    save_rows(p, w, dig_schema_at("room", 0)->rows, &w->room, "room");
    for (int i = 0; i < 6; i++)
        pack_u32(p, &w->room_solid[i]);
}

void save_settings(Pack *p, World *w)
{
    pack_enum(p, &w->accuracy, ACCURACY_FINEST + 1, "accuracy");
    pack_u64(p, &w->steps);
    pack_u64(p, &w->serial);
    pack_u64(p, &w->rng);
    pack_bool(p, &w->dig_accuracies);
    pack_u64(p, &w->debt.work);
    pack_u32(p, &w->debt.pause);
    pack_check(p, w->steps <= (uint64_t)1 << 52, "the number of steps is too large");
    pack_check(p, w->serial <= HANDLES_MOST, "the number of handles is too large");
    pack_ledger(p, &w->ledger);
    pack_stats(p, &w->stats);
    pack_room(p, w);
}

/* ---- materials ---- */

static void pack_material(Pack *p, const World *w, Material *m)
{
    pack_text(p, m->name, sizeof m->name);
    pack_check(p, m->name[0] != '\0', "a material has no name");
    save_rows(p, w, dig_schema_at("material", 0)->rows, &m->def, m->name);
}

static void pack_material_pair(Pack *p, const World *w, MaterialPair *m)
{
    uint32_t a = (uint32_t)m->a, b = (uint32_t)m->b;
    pack_index(p, &a, (uint32_t)w->materials.count, false, "material of a pair");
    pack_index(p, &b, (uint32_t)w->materials.count, false, "material of a pair");
    m->a = (int)a;
    m->b = (int)b;
    pack_real_or_nan(p, &m->friction, 0, 100, "friction of two materials");
    pack_real_or_nan(p, &m->friction_dynamic, 0, 100, "friction_dynamic of two materials");
    pack_real_or_nan(p, &m->rolling, 0, 10, "rolling_friction of two materials");
    pack_real_or_nan(p, &m->restitution, 0, 1, "restitution of two materials");
}

/* A new world has the everyday materials: they are replaced. */
void save_materials(Pack *p, World *w)
{
    uint32_t count = pack_count(p, (uint32_t)w->materials.count, 120, "materials");
    if (!pack_check(p, count >= 1, "there is no material"))
        return;
    if (p->reading && list_reserve(&w->materials, (int)count, &w->allocations) != DIG_OK) {
        pack_fail_memory(p);
        return;
    }
    w->materials.count = (int)count;
    for (uint32_t i = 0; i < count; i++)
        pack_material(p, w, &w->materials.data[i]);
    uint32_t pairs = pack_count(p, (uint32_t)w->material_pairs.count, 40, "pairs of materials");
    if (p->reading && list_reserve(&w->material_pairs, (int)pairs, &w->allocations) != DIG_OK) {
        pack_fail_memory(p);
        return;
    }
    w->material_pairs.count = (int)pairs;
    for (uint32_t i = 0; i < pairs; i++)
        pack_material_pair(p, w, &w->material_pairs.data[i]);
    material_pairs_look(w);
}

/* ---- lists, tree, graph ---- */

void save_lists(Pack *p, World *w)
{
    save_slots(p, w, &w->unbounded, (uint32_t)w->solids.count, "plane");
    save_slots(p, w, &w->awake, (uint32_t)w->bodies.count, "body awake");
    save_slots(p, w, &w->asking, (uint32_t)w->solids.count, "solid to be compared");
    save_slots(p, w, &w->brief, (uint32_t)w->touches.count, "touch that is over");
}

void save_tree(Pack *p, World *w) { tree_pack(p, &w->tree, (uint32_t)w->solids.count); }
void save_graph(Pack *p, World *w) { graph_pack(p, w->graph, (uint32_t)w->bodies.count); }

/* ---- events ---- */

static void pack_event(Pack *p, const World *w, dig_event *e)
{
    pack_enum(p, &e->kind, DIG_EVENT_KINDS, "kind of an event");
    pack_real_in(p, &e->time, -SAVE_LONG, SAVE_LONG, "time of an event");
    save_body_handle(p, w, &e->a);
    save_body_handle(p, w, &e->b);
    save_joint_handle(p, w, &e->joint);
    pack_u32(p, &e->dig);
    pack_u32(p, &e->other_dig);
    pack_enum(p, &e->wall, 7, "wall of an event");
    pack_real_in(p, &e->speed, -SAVE_FAST, SAVE_FAST, "speed of an event");
    pack_real_in(p, &e->impulse, -SAVE_STRONG, SAVE_STRONG, "impulse of an event");
    pack_real_in(p, &e->stress, 0, SAVE_STRONG, "stress of an event");
    pack_vec3(p, &e->point, SAVE_FAR, "place of an event");
    pack_vec3(p, &e->normal, 2, "normal of an event");
    pack_enum(p, &e->link, DIG_LINK_KINDS, "link of an event");
    pack_u64(p, &e->message);
    save_region_handle(p, w, &e->region);
    pack_index(p, &e->layer, DIG_LAYERS, false, "layer of an event");
}

typedef LIST(dig_event) EventList;

static void pack_events(Pack *p, World *w, void *list)
{
    EventList *events = list;
    uint32_t count = pack_count(p, (uint32_t)events->count, 100, "events");
    if (p->reading && list_reserve(events, (int)count, &w->allocations) != DIG_OK) {
        pack_fail_memory(p);
        return;
    }
    events->count = (int)count;
    for (uint32_t i = 0; i < count; i++)
        pack_event(p, w, &events->data[i]);
}

void save_events(Pack *p, World *w)
{
    pack_events(p, w, &w->events);
    pack_events(p, w, &w->pending);
}

/* ---- messages ---- */

void save_message(Pack *p, const World *w, dig_message *m)
{
    pack_u64(p, &m->id);
    pack_u64(p, &m->root);
    pack_real_in(p, &m->time, -SAVE_LONG, SAVE_LONG, "time of a message");
    save_body_handle(p, w, &m->from);
    save_body_handle(p, w, &m->to);
    pack_text(p, m->kind, sizeof m->kind);
    for (int i = 0; i < 4; i++)
        pack_real_in(p, &m->value[i], -1.7976931348623157e308, 1.7976931348623157e308, "value of a message");
    pack_vec3(p, &m->direction, 4 * SAVE_FAR, "direction of a message");
}

/* In order, from the start of the ring. */
void save_messages(Pack *p, World *w)
{
    MessageLog *log = &w->messages;
    pack_u64(p, &log->last_id);
    uint32_t count = pack_count(p, log->count, 90, "messages");
    if (!pack_check(p, count <= MESSAGE_KEPT, "there are more messages than are kept"))
        return;
    for (uint32_t i = 0; i < count; i++) {
        dig_message *m = &log->ring[(log->start + i) % MESSAGE_KEPT];
        const dig_message *before = &log->ring[(log->start + i + MESSAGE_KEPT - 1) % MESSAGE_KEPT];
        save_message(p, w, m);
        pack_check(p, m->id >= 1 && m->id <= log->last_id, "a message has a number that was never given");
        pack_check(p, i == 0 || m->time > before->time || (m->time == before->time && m->id > before->id), "messages are not in order");
    }
    log->count = count;
}

/* ---- the note ---- */

enum { NOTE_MOST = 256 << 20 };         /* bytes */

dig_status dig_world_note(dig_world *w, const void *bytes, size_t size)
{
    unsigned char *note = NULL;
    if (size > NOTE_MOST)
        return world_fail(w, DIG_E_ARG, "a note of %zu bytes, must have at most %d", size, (int)NOTE_MOST);
    if (size > 0 && !(note = malloc(size)))
        return world_fail(w, DIG_E_MEMORY, "not enough memory for a note of %zu bytes", size);
    if (note)
        memcpy(note, bytes, size);
    free(w->note);
    w->note = note;
    w->note_size = size;
    return DIG_OK;
}

const void *dig_world_noted(const dig_world *w, size_t *size)
{
    *size = w->note_size;
    return w->note;
}

void save_note(Pack *p, World *w)
{
    uint32_t size = pack_count(p, (uint32_t)w->note_size, 1, "bytes of the note");
    if (!pack_check(p, size <= NOTE_MOST, "its note is too long") || size == 0)
        return;
    if (!p->reading) {
        pack_bytes(p, w->note, size);
        return;
    }
    const unsigned char *bytes = pack_take(p, size);
    if (bytes && dig_world_note(w, bytes, size) != DIG_OK)
        pack_fail_memory(p);
}
