/* world/world.c - opening, closing and measuring a world; slots; errors. */
#include "world/world.h"
#include "world/region.h"

#include <stdio.h>
#include <stdlib.h>

dig_status world_fail(const World *w, dig_status status, const char *format, ...)
{
    /* The text buffer is the one part of a const world that a failing query may write. */
    World *mutable_world = (World *)(uintptr_t)w;
    va_list args;
    va_start(args, format);
    vsnprintf(mutable_world->error, sizeof mutable_world->error, format, args);
    va_end(args);
    return status;
}

dig_status slot_take(World *w, void **data, int *count, int *capacity, size_t item, void *free_list, uint32_t *slot)
{
    LIST(uint32_t) *list = free_list;
    if (list->count > 0) {
        *slot = list->data[--list->count];
        memset((char *)*data + (size_t)*slot * item, 0, item);
        return DIG_OK;
    }
    /* Room in the free list for every slot there is, so that slot_give cannot fail. */
    DIG_TRY(list_reserve_any((void **)&list->data, &list->capacity, sizeof *list->data, *count + 1, &w->allocations));
    DIG_TRY(list_push_any(data, count, capacity, item, &w->allocations));
    *slot = (uint32_t)(*count - 1);
    return DIG_OK;
}

void slot_give(World *w, void *free_list, uint32_t slot)
{
    (void)w;
    LIST(uint32_t) *list = free_list;
    DIG_ASSERT(list->count < list->capacity);
    list->data[list->count++] = slot;
}

dig_status world_generation(World *w, const char *what, uint32_t *gen)
{
    if (w->serial >= HANDLES_MOST)
        return world_fail(w, DIG_E_MEMORY, "%s: this world has made %u bodies, joints and links, and can make no more", what, HANDLES_MOST);
    *gen = w->gen_start + (uint32_t)w->serial++;
    return DIG_OK;
}

dig_status world_open(const dig_world_def *def, World **out, char *why, size_t capacity)
{
    World *w = calloc(1, sizeof *w);
    if (!w) {
        snprintf(why, capacity, "not enough memory for a world");
        return DIG_E_MEMORY;
    }
    w->def = *def;
    w->rng = (uint64_t)def->seed;
    /* Handles of different worlds start at different generations, so that one shown to the wrong world is caught. The
     * number comes from the world's own address and is not part of the state hash. */
    uint64_t mixed = hash_u64(HASH_START, (uint64_t)(uintptr_t)w);
    w->gen_start = (uint32_t)(mixed % 0x3fffffffu) + 1;
    tree_open(&w->tree);
    dig_status s = graph_open(&w->graph);
    if (s == DIG_OK)
        s = materials_open(w);
    if (s != DIG_OK) {
        snprintf(why, capacity, "not enough memory for a world");
        world_close(w);
        return s;
    }
    *out = w;
    return DIG_OK;
}

void world_close(World *w)
{
    if (!w)
        return;
    for (int i = 0; i < w->solids.count; i++)
        if (w->solids.data[i].alive)
            form_drop(w->solids.data[i].form);
    for (int i = 0; i < w->effect_count; i++) {
        EffectOwner *o = w->effects[i].owner;
        free(w->effects[i].world);
        column_close(&w->effects[i].members);
        if (o && --o->users == 0)
            o->end(o);
    }
    for (int i = 0; i < w->regions.count; i++)
        if (w->regions.data[i].alive)
            shape_free(&w->regions.data[i].shape);
    for (int i = 0; i < w->bodies.count; i++)
        body_shares_drop(&w->bodies.data[i]);
    for (int i = 0; i < SHARES_RECENT; i++) {
        body_shares_drop(&(Body){.inertia = w->inertias.of[i], .make = w->makes.of[i]});
        form_drop(w->forms.of[i]);
    }
    free(w->note);
    list_close(&w->regions);
    list_close(&w->free_regions);
    list_close(&w->bodies);
    list_close(&w->rest);
    list_close(&w->drifts);
    list_close(&w->solids);
    list_close(&w->pairs);
    list_close(&w->memories);
    list_close(&w->contacts);
    list_close(&w->contact_rest);
    list_close(&w->more);
    list_close(&w->touches);
    list_close(&w->joints);
    list_close(&w->pushes);
    list_close(&w->free_bodies);
    list_close(&w->free_solids);
    list_close(&w->free_pairs);
    list_close(&w->free_memories);
    list_close(&w->free_contacts);
    list_close(&w->free_more);
    list_close(&w->free_touches);
    list_close(&w->free_joints);
    list_close(&w->unbounded);
    list_close(&w->awake);
    list_close(&w->near);
    list_close(&w->asking);
    list_close(&w->brief);
    list_close(&w->parent);
    list_close(&w->materials);
    list_close(&w->material_pairs);
    list_close(&w->events);
    list_close(&w->pending);
    index_close(&w->pair_index);
    index_close(&w->touch_index);
    tree_close(&w->tree);
    graph_close(w->graph);
    for (int i = 0; i < DIG_LAYERS; i++)
        layer_close(&w->layers[i]);
    mail_close(&w->mail);
    arena_close(&w->scratch);
    arena_close(&w->group_scratch);
    free(w);
}

size_t world_bytes(const World *w)
{
    size_t bytes = sizeof *w;
    bytes += list_bytes(&w->bodies) + list_bytes(&w->solids) + list_bytes(&w->pairs) + list_bytes(&w->memories) + list_bytes(&w->contacts);
    bytes += list_bytes(&w->rest) + list_bytes(&w->drifts) + list_bytes(&w->contact_rest);
    bytes += list_bytes(&w->more) + list_bytes(&w->touches) + list_bytes(&w->joints) + list_bytes(&w->pushes) + list_bytes(&w->events)
        + list_bytes(&w->pending);
    bytes += list_bytes(&w->materials) + list_bytes(&w->material_pairs);
    bytes += index_bytes(&w->pair_index) + index_bytes(&w->touch_index) + (size_t)w->tree.capacity * sizeof(TreeNode);
    bytes += list_bytes(&w->near) + graph_bytes(w->graph) + arena_bytes(&w->scratch) + arena_bytes(&w->group_scratch) + w->note_size;
    bytes += w->tally.shapes;
    for (int i = 0; i < w->effect_count; i++)
        bytes += effect_bytes(&w->effects[i]);
    for (int i = 0; i < DIG_LAYERS; i++)
        bytes += layer_bytes(&w->layers[i]);
    return bytes + mail_bytes(&w->mail);
}

Tally world_tally(const World *w)
{
    Tally t = {0, 0, 0};
    for (int i = 0; i < w->touches.count; i++)
        t.touching += w->touches.data[i].alive && w->touches.data[i].pairs > 0;
    for (int i = 0; i < w->pairs.count; i++)
        t.smooth += w->pairs.data[i].alive && w->pairs.data[i].smooth;
    for (int i = 0; i < w->solids.count; i++)
        t.shapes += w->solids.data[i].alive ? shape_bytes(&w->solids.data[i].form->shape) : 0;
    return t;
}

size_t effect_bytes(const EffectSlot *e)
{
    return (e->world ? e->world_size : 0) + column_bytes(&e->members) + (e->owner ? e->owner->bytes : 0);
}

/* An effect that nothing called for leaves no trace in the sum: a build without it has the same one. */
static uint64_t hash_effect(uint64_t h, const EffectSlot *e, const char *name)
{
    const real *x = e->world;
    if (e->on && !x && e->members.count == 0 && !e->owner)
        return h;
    h = hash_u64(hash_bytes(h, name, strlen(name)), e->on);
    for (size_t k = 0; x && k < e->world_size / sizeof *x; k++)
        h = hash_real(h, x[k]);
    return column_hash(&e->members, h);
}

static uint64_t hash_body(uint64_t h, const World *w, const Body *b)
{
    h = hash_vec3(hash_quat(hash_vec3(h, b->x), b->q), b->v);
    h = hash_vec3(h, b->w);
    h = hash_real(hash_real(hash_real(h, b->mass), b->still), b->rate);
    if (b->crowded)
        h = hash_vec3(hash_vec3(h, w->drifts.data[b - w->bodies.data].way), w->drifts.data[b - w->bodies.data].turn);
    h = hash_u64(h, (uint64_t)b->kind | (uint64_t)b->mode << 8 | (uint64_t)b->awake << 16 | (uint64_t)b->collides << 17);
    h = hash_u64(h, (uint64_t)b->integrator | (uint64_t)b->euler << 8 | (uint64_t)b->accuracy << 16 | (uint64_t)b->trace_wait << 24);
    h = hash_real(hash_u64(h, (uint64_t)b->trace_pause | (uint64_t)b->toil.steps << 16 | (uint64_t)b->toil.pause << 24 | (uint64_t)b->toil.dear << 32),
                  b->trace_step);
    return hash_real(hash_real(h, b->move_end), b->gravity_scale);
}

static uint64_t hash_point(const PointMemory *m)
{
    uint64_t h = hash_real(hash_real(HASH_START, m->normal), (real)m->borne);
    return hash_u64(hash_vec3(h, m->tangent), (uint64_t)m->held);
}

/* A pair, its contacts and their points. */
static uint64_t hash_pair(const World *w, const Pair *p)
{
    uint64_t h = hash_u64(HASH_START, (uint64_t)p->solid_a << 32 | p->solid_b);
    for (uint32_t c = p->contact; c != NONE; c = w->contacts.data[c].next) {
        const Contact *contact = &w->contacts.data[c];
        for (int k = 0; k < contact->count; k++)
            h = hash_u64(h, hash_point(&contact_point_seen(w, contact, k)->memory));
        h = hash_vec3(h, contact_rest(w, c).rolling);
        h = contact->grips ? hash_u64(h, 1) : h;
    }
    return h;
}

/* Everything the future depends on: motion, sleep, warm start, joints, pushes. Not generations: they differ between worlds. Bodies, pairs and
 * points have sums of their own, so that one need not wait for the other. */
uint64_t world_hash(const World *w)
{
    uint64_t h = hash_u64(hash_u64(HASH_START, w->steps), w->rng);
    h = hash_u64(hash_u64(h, w->debt.work), w->debt.pause);
    h = hash_vec3(h, w->def.gravity);
    for (int i = 0; i < w->bodies.count; i++)
        if (w->bodies.data[i].alive)
            h = hash_u64(h, hash_body(hash_u64(HASH_START, (uint64_t)i), w, &w->bodies.data[i]));
    for (int i = 0; i < w->pairs.count; i++) {
        const Pair *p = &w->pairs.data[i];
        contacts_fetch(w, p, w->pairs.data + w->pairs.count);
        if (p->alive)
            h = hash_u64(h, hash_pair(w, p));
    }
    for (int i = 0; i < w->joints.count; i++) {
        const JointRec *j = &w->joints.data[i];
        if (!j->alive)
            continue;
        h = hash_u64(h, (uint64_t)i);
        for (int k = 0; k < 12; k++)
            h = hash_real(h, j->impulse[k]);
        for (int k = j->other[0] != NONE ? 2 : 0; k < 48; k++)     /* gear and rack begin with two handles */
            h = hash_real(h, j->params[k]);
        for (int k = 0; k < 4; k++)
            h = hash_real(h, j->memory[k]);
    }
    for (int i = 0; i < w->pushes.count; i++) {
        const Push *p = &w->pushes.data[i];
        h = hash_real(hash_vec3(hash_vec3(hash_u64(h, p->body), p->force), p->torque), p->until);
        h = p->has_at ? hash_vec3(h, p->at) : h;
    }
    for (int i = 0; i < w->effect_count; i++)
        h = hash_effect(h, &w->effects[i], w->effects[i].name);
    for (int i = 0; i < w->regions.count; i++)
        if (w->regions.data[i].alive)
            h = region_hash(&w->regions.data[i], h);
    h = mail_hash(h, &w->mail);
    for (int i = 0; i < DIG_LAYERS; i++)
        h = layer_hash(h, &w->layers[i]);
    return hash_u64(h, graph_hash(w->graph));
}
