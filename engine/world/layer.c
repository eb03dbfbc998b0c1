/* world/layer.c - links of a layer and the graph they make. */
#include "world/world.h"

const char *dig_layer_name(uint32_t layer)
{
    static const char *const names[DIG_LAYERS] = {"mechanical", "electrical", "thermal", "hydraulic", "range"};
    return layer < DIG_LAYERS ? names[layer] : NULL;
}

Graph *layer_graph(const World *w, uint32_t layer)
{
    if (layer == DIG_LAYER_MECHANICAL)
        return w->graph;
    return layer < DIG_LAYERS ? w->layers[layer].graph : NULL;
}

void layer_begin(World *w, uint32_t layer)
{
    Layer *l = &w->layers[layer];
    if (l->graph)
        graph_begin(l->graph);
}

/* The first link opens the graph and the batch. */
static dig_status open_layer(Layer *l)
{
    if (l->graph)
        return DIG_OK;
    DIG_TRY(graph_open(&l->graph));
    graph_begin(l->graph);
    return DIG_OK;
}

static dig_status add_node(Graph *g, uint32_t body) { return graph_has_node(g, body) ? DIG_OK : graph_node_add(g, body); }

bool layer_bounds(const Layer *l, uint32_t body) { return l->bounds.count > 0 && map_find(&l->bounds, (MapKey){body, 0, 0}, NULL); }

/* One bound link more or less that ends at the body; there is room. */
static void count_bound(Layer *l, uint32_t body, int change)
{
    MapKey key = {body, 0, 0};
    uint32_t count = 0;
    map_find(&l->bounds, key, &count);
    count += (uint32_t)change;
    if (count == 0)
        map_remove(&l->bounds, key);
    else
        (void)map_put(&l->bounds, key, count);
}

static void post_link(World *w, uint32_t layer, dig_event_kind kind, const LayerLink *k)
{
    dig_event *e = event_post(w, kind, k->a, k->b);
    if (!e)
        return;
    e->layer = layer;
    e->link = layer == DIG_LAYER_RANGE ? DIG_LINK_RANGE : DIG_LINK_PORT;
}

dig_status layer_add(World *w, uint32_t layer, uint32_t a, uint32_t b, bool bound, real ratio, uint32_t *link)
{
    Layer *l = &w->layers[layer];
    uint32_t slot, handle, gen;
    DIG_TRY(world_generation(w, "link", &gen));
    DIG_TRY(open_layer(l));
    DIG_TRY(list_reserve(&l->loose, l->loose.count + 2, &w->allocations));
    DIG_TRY(map_reserve(&l->bounds, (int)l->bounds.count + bound));
    DIG_TRY(add_node(l->graph, a));
    l->loose.data[l->loose.count++] = a;        /* should the rest fail */
    if (!bound) {
        DIG_TRY(add_node(l->graph, b));
        l->loose.data[l->loose.count++] = b;
    }
    DIG_TRY(world_slot(w, &l->links, &l->free_links, &slot));
    dig_link_kind kind = layer == DIG_LAYER_RANGE ? DIG_LINK_RANGE : DIG_LINK_PORT;
    dig_status s = graph_link_add(l->graph, a, b, bound, (uint8_t)kind, slot, world_time(w), &handle);
    if (s != DIG_OK) {
        slot_give(w, &l->free_links, slot);
        return s;
    }
    l->links.data[slot] = (LayerLink){.gen = gen, .alive = true, .a = a, .b = b, .link = handle, .ratio = ratio};
    if (bound)
        count_bound(l, b, 1);
    post_link(w, layer, DIG_EVENT_LINK, &l->links.data[slot]);
    *link = slot;
    return DIG_OK;
}

void layer_cut(World *w, uint32_t layer, uint32_t link)
{
    Layer *l = &w->layers[layer];
    LayerLink *k = &l->links.data[link];
    post_link(w, layer, DIG_EVENT_UNLINK, k);
    if (graph_link(l->graph, k->link)->bound)
        count_bound(l, k->b, -1);
    graph_link_remove(l->graph, k->link);
    if (k->kept)
        map_remove(&l->pairs, (MapKey){k->a, k->b, 0});
    k->alive = false;
    if (list_reserve(&l->loose, l->loose.count + 2, &w->allocations) == DIG_OK) {
        l->loose.data[l->loose.count++] = k->a;
        l->loose.data[l->loose.count++] = k->b;
    }
    slot_give(w, &l->free_links, link);
}

dig_status layer_mark(World *w, uint32_t layer, uint32_t a, uint32_t b, bool bound, uint32_t *link)
{
    Layer *l = &w->layers[layer];
    MapKey key = {a, b, 0};
    if (!map_find(&l->pairs, key, link)) {
        DIG_TRY(map_reserve(&l->pairs, (int)l->pairs.count + 1));
        DIG_TRY(layer_add(w, layer, a, b, bound, 0, link));
        (void)map_put(&l->pairs, key, *link);
        l->links.data[*link].kept = true;
    }
    l->links.data[*link].marked = true;
    return DIG_OK;
}

/* Bodies without a link leave the layer; that is no event. */
static void drop_loose(Layer *l)
{
    for (int i = 0; i < l->loose.count; i++) {
        uint32_t body = l->loose.data[i];
        if (graph_has_node(l->graph, body) && graph_link_first(l->graph, body) == GRAPH_END)
            graph_node_remove(l->graph, body);
    }
    l->loose.count = 0;
}

void layer_end(World *w, uint32_t layer, bool sweep)
{
    Layer *l = &w->layers[layer];
    if (!l->graph)
        return;
    for (int i = 0; sweep && i < l->links.count; i++) {
        LayerLink *k = &l->links.data[i];
        if (k->alive && k->kept && !k->marked)
            layer_cut(w, layer, (uint32_t)i);
        k->marked = false;
    }
    (void)graph_end(l->graph);
    post_graph_changes(w, layer);
    drop_loose(l);
}

void layers_forget(World *w, uint32_t body)
{
    for (uint32_t layer = 1; layer < DIG_LAYERS; layer++) {
        Layer *l = &w->layers[layer];
        if (!l->graph)
            continue;
        layer_begin(w, layer);
        for (int i = 0; i < l->links.count; i++)
            if (l->links.data[i].alive && (l->links.data[i].a == body || l->links.data[i].b == body))
                layer_cut(w, layer, (uint32_t)i);
        layer_end(w, layer, false);
    }
}

/* ---- the whole layer ---- */

void layer_close(Layer *l)
{
    graph_close(l->graph);
    list_close(&l->links);
    list_close(&l->free_links);
    list_close(&l->loose);
    map_close(&l->pairs);
    map_close(&l->bounds);
    *l = (Layer){0};
}

dig_status layer_copy(Layer *to, const Layer *from, uint64_t *allocations)
{
    if (!from->graph) {
        layer_close(to);
        return DIG_OK;
    }
    DIG_TRY(graph_copy(&to->graph, from->graph));
    DIG_TRY(list_copy(&to->links, &from->links, allocations));
    DIG_TRY(list_reserve(&to->free_links, from->free_links.capacity, allocations));
    DIG_TRY(list_copy(&to->free_links, &from->free_links, allocations));
    DIG_TRY(map_copy(&to->bounds, &from->bounds));
    return map_copy(&to->pairs, &from->pairs);
}

dig_status layer_connect(Layer *l)
{
    DIG_TRY(map_reserve(&l->pairs, l->links.count));
    DIG_TRY(map_reserve(&l->bounds, l->links.count));
    for (int i = 0; i < l->links.count; i++) {
        const LayerLink *k = &l->links.data[i];
        if (!k->alive)
            continue;
        if (k->kept)
            (void)map_put(&l->pairs, (MapKey){k->a, k->b, 0}, (uint32_t)i);
        if (graph_link(l->graph, k->link)->bound)
            count_bound(l, k->b, 1);
    }
    return DIG_OK;
}

size_t layer_bytes(const Layer *l)
{
    return (l->graph ? graph_bytes(l->graph) : 0) + list_bytes(&l->links) + list_bytes(&l->free_links) + list_bytes(&l->loose) + map_bytes(&l->pairs)
         + map_bytes(&l->bounds);
}

uint64_t layer_hash(uint64_t h, const Layer *l)
{
    if (!l->graph)
        return h;
    h = hash_u64(h, graph_hash(l->graph));
    for (int i = 0; i < l->links.count; i++) {
        const LayerLink *k = &l->links.data[i];
        if (k->alive)
            h = hash_real(hash_real(hash_real(hash_u64(h, (uint64_t)i), k->effort), k->flow), k->ratio);
    }
    return h;
}

bool layer_check(const Layer *l)
{
    if (!l->graph)
        return l->links.count == 0;
    for (int i = 0; i < l->links.count; i++) {
        const LayerLink *k = &l->links.data[i];
        const GraphLink *g = k->alive ? graph_link(l->graph, k->link) : NULL;
        if (k->alive && (!g || g->a != k->a || g->b != k->b || g->user != (uint32_t)i))
            return false;
    }
    return graph_check(l->graph);
}
