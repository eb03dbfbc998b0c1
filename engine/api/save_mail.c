/* api/save_mail.c - the sections of the other layers and of messages on their way. */
#include "api/save.h"
#include "world/graph_save.h"

#include <stdlib.h>

enum { WIRE_BYTES = 36, POST_BYTES = 90, LETTER_BYTES = 90 };          /* at least */

/* ---- layers ---- */

static void pack_wire(Pack *p, const World *w, LayerLink *k)
{
    save_gen(p, w, &k->gen, true);
    pack_bool(p, &k->kept);
    pack_index(p, &k->a, (uint32_t)w->bodies.count, false, "first body of a link");
    pack_index(p, &k->b, (uint32_t)w->bodies.count, false, "second body of a link");
    pack_u32(p, &k->link);
    pack_real_in(p, &k->effort, -SAVE_MUCH, SAVE_MUCH, "effort of a link");
    pack_real_in(p, &k->flow, -SAVE_MUCH, SAVE_MUCH, "flow of a link");
    pack_real_in(p, &k->ratio, -SAVE_MUCH, SAVE_MUCH, "ratio of a link");
    k->alive = true;
}

static bool wires_are_sound(const World *w, const Layer *l)
{
    int wires = 0, links = 0;
    for (int i = 0; i < l->links.count; i++) {
        const LayerLink *k = &l->links.data[i];
        wires += k->alive;
        if (k->alive && (!w->bodies.data[k->a].alive || !w->bodies.data[k->b].alive))
            return false;
    }
    for (int i = 0; i < w->bodies.count; i++) {
        if (!graph_has_node(l->graph, (uint32_t)i))
            continue;
        if (graph_link_first(l->graph, (uint32_t)i) == GRAPH_END)
            return false;
        for (uint32_t k = graph_link_first(l->graph, (uint32_t)i); k != GRAPH_END; k = graph_link_next(l->graph, (uint32_t)i, k))
            links += graph_link(l->graph, k)->a == (uint32_t)i;
    }
    return wires == links && layer_check(l);
}

static void pack_layer(Pack *p, World *w, Layer *l)
{
    bool used = l->graph != NULL;
    pack_bool(p, &used);
    if (!used)
        return;
    if (p->reading && graph_open(&l->graph) != DIG_OK) {
        pack_fail_memory(p);
        return;
    }
    graph_pack(p, l->graph, (uint32_t)w->bodies.count);
    unsigned char *free_slot = SAVE_TABLE(p, w, &l->links, &l->free_links, WIRE_BYTES, "links of a layer");
    for (int i = 0; free_slot && i < l->links.count && pack_good(p); i++)
        if (!free_slot[i])
            pack_wire(p, w, &l->links.data[i]);
    free(free_slot);
    if (!p->reading || !pack_good(p))
        return;
    if (pack_check(p, wires_are_sound(w, l), "the links of a layer make no graph") && layer_connect(l) != DIG_OK)
        pack_fail_memory(p);
}

void save_layers(Pack *p, World *w)
{
    for (int i = 1; i < DIG_LAYERS && pack_good(p); i++)
        pack_layer(p, w, &w->layers[i]);
}

/* ---- messages on their way ---- */

static void pack_what(Pack *p, const World *w, dig_post *d)
{
    uint32_t hops = (uint32_t)d->hops, link = (uint32_t)(d->link + 1);
    pack_enum(p, &d->route, DIG_ROUTES, "route of a message");
    pack_enum(p, &d->transform, DIG_TRANSFORMS, "transform of a message");
    pack_text(p, d->kind, sizeof d->kind);
    for (int i = 0; i < 4; i++)
        pack_real_in(p, &d->value[i], -1.7976931348623157e308, 1.7976931348623157e308, "value of a message");
    pack_real_in(p, &d->factor, -1.7976931348623157e308, 1.7976931348623157e308, "factor of a message");
    save_body_handle(p, w, &d->from);
    save_body_handle(p, w, &d->to);
    pack_u32(p, &d->dig.id);
    pack_index(p, &d->dig.layer, DIG_LAYERS, false, "layer of a message");
    save_region_handle(p, w, &d->region);
    pack_index(p, &d->layer, DIG_LAYERS, false, "layer of a message");
    pack_index(p, &link, DIG_LINK_KINDS + 1, false, "links of a message");
    pack_index(p, &hops, INT32_MAX, false, "hops of a message");
    d->link = (int)link - 1;
    d->hops = (int)hops;
    pack_check(p, d->kind[0] != 0, "a message on its way has no kind");
}

static void pack_queue(Pack *p, World *w)
{
    Mail *m = &w->mail;
    uint32_t count = pack_count(p, (uint32_t)m->queue.count, POST_BYTES, "messages on their way");
    if (p->reading && list_reserve(&m->queue, (int)count, &w->allocations) != DIG_OK) {
        pack_fail_memory(p);
        return;
    }
    m->queue.count = (int)count;
    for (uint32_t i = 0; i < count && pack_good(p); i++) {
        Post *post = &m->queue.data[i];
        pack_u64(p, &post->id);
        pack_u64(p, &post->root);
        pack_real_in(p, &post->time, -SAVE_LONG, SAVE_LONG, "time of a message");
        pack_what(p, w, &post->what);
        pack_check(p, post->id >= 1 && post->id <= w->messages.last_id, "a message on its way has a number that was never given");
    }
    if (pack_good(p))
        pack_check(p, mail_in_order(m), "messages on their way are not in order");
}

typedef LIST(dig_message) Letters;
typedef LIST(dig_event) Events;

/* The messages of events: one for each, in the order in which they were given. */
static void pack_letters(Pack *p, World *w, void *list, const void *of)
{
    Letters *letters = list;
    const Events *events = of;
    uint32_t count = pack_count(p, (uint32_t)letters->count, LETTER_BYTES, "messages of events"), told = 0;
    if (p->reading && list_reserve(letters, (int)count, &w->allocations) != DIG_OK) {
        pack_fail_memory(p);
        return;
    }
    letters->count = (int)count;
    for (uint32_t i = 0; i < count && pack_good(p); i++) {
        save_message(p, w, &letters->data[i]);
        pack_check(p, i == 0 || letters->data[i].id > letters->data[i - 1].id, "messages of events are not in order");
    }
    for (int i = 0; i < events->count; i++)
        told += events->data[i].kind == DIG_EVENT_MESSAGE;
    pack_check(p, told == count, "there are other messages than events tell of");
}

/* Not what was heard at this instant: nobody is answering when a world is saved. */
void save_mail(Pack *p, World *w)
{
    pack_queue(p, w);
    pack_letters(p, w, &w->mail.waiting, &w->pending);
    pack_letters(p, w, &w->mail.shown, &w->events);
}
