/* world/graph.c - tables of a graph: nodes, links and DIG records, and the questions about them. */
#include "base/block.h"
#include "world/graph_inside.h"

#include <stdlib.h>

#define NODE_LIMIT (1u << 28)
#define LINK_LIMIT (1u << 29)

/* ---- memory ---- */

dig_status graph_open(Graph **g)
{
    Graph *fresh = calloc(1, sizeof *fresh);
    if (!fresh)
        return DIG_E_MEMORY;
    fresh->free_dig = fresh->free_link = NIL;
    fresh->next_id = 1;
    fresh->allocations = 1;
    *g = fresh;
    return DIG_OK;
}

static void free_tables(Graph *g)
{
    block_free(g->nodes, g->held[TABLE_NODES]);
    block_free(g->digs, g->held[TABLE_DIGS]);
    block_free(g->alive, g->held[TABLE_ALIVE]);
    block_free(g->touched, g->held[TABLE_TOUCHED]);
    block_free(g->queue, g->held[TABLE_QUEUE]);
    block_free(g->changes, g->held[TABLE_CHANGES]);
    block_free(g->links, g->held[TABLE_LINKS]);
    block_free(g->adds, g->held[TABLE_ADDS]);
    block_free(g->removes, g->held[TABLE_REMOVES]);
    map_close(&g->by_id);
}

void graph_close(Graph *g)
{
    if (!g)
        return;
    free_tables(g);
    free(g);
}

/* Enlarges the table whose pointer is stored at `where` to so many bytes, the new ones zero: they take no memory until they are written
 * to. False: out of memory, table unchanged. (memcpy because the pointers differ in type.) */
static bool enlarge(Graph *g, int which, void *where, size_t bytes)
{
    void *table;
    memcpy(&table, where, sizeof table);
    if (bytes <= g->held[which])
        return true;
    table = block_resize(table, g->held[which], bytes);
    if (!table)
        return false;
    memcpy(where, &table, sizeof table);
    g->held[which] = bytes;
    g->allocations++;
    return true;
}

static uint32_t grown(uint32_t have, uint32_t need, uint32_t limit)
{
    uint32_t doubled = have < limit / 2 ? have * 2 : limit;
    return need > doubled ? need : doubled < 16 ? 16 : doubled;
}

static dig_status reserve_nodes(Graph *g, uint32_t capacity)
{
    uint32_t have = g->node_capacity;
    if (capacity <= have)
        return DIG_OK;
    if (capacity > NODE_LIMIT)
        return DIG_E_FULL;
    if (!enlarge(g, TABLE_NODES, &g->nodes, sizeof *g->nodes * capacity) || !enlarge(g, TABLE_DIGS, &g->digs, sizeof *g->digs * capacity)
        || !enlarge(g, TABLE_ALIVE, &g->alive, sizeof *g->alive * capacity)
        || !enlarge(g, TABLE_TOUCHED, &g->touched, sizeof *g->touched * capacity)
        || !enlarge(g, TABLE_QUEUE, &g->queue, sizeof *g->queue * capacity)
        || !enlarge(g, TABLE_CHANGES, &g->changes, sizeof *g->changes * 2 * capacity))
        return DIG_E_MEMORY;
    DIG_TRY(map_reserve(&g->by_id, (int)capacity));     /* last: its size always fits node_capacity, see copy_contents */
    for (uint32_t i = have; i < capacity; i++)
        g->nodes[i] = (GraphNode){.dig = NIL, .next = NIL, .prev = NIL, .links = NIL};
    g->node_capacity = capacity;
    return DIG_OK;
}

static dig_status reserve_links(Graph *g, uint32_t capacity)
{
    uint32_t have = g->link_capacity;
    if (capacity <= have)
        return DIG_OK;
    if (capacity > LINK_LIMIT)
        return DIG_E_FULL;
    if (!enlarge(g, TABLE_LINKS, &g->links, sizeof *g->links * capacity) || !enlarge(g, TABLE_ADDS, &g->adds, sizeof *g->adds * capacity)
        || !enlarge(g, TABLE_REMOVES, &g->removes, sizeof *g->removes * capacity))
        return DIG_E_MEMORY;
    g->link_capacity = capacity;
    return DIG_OK;
}

dig_status graph_reserve(Graph *g, int nodes, int links)
{
    if (nodes < 0 || links < 0)
        return DIG_E_ARG;
    DIG_TRY(reserve_nodes(g, (uint32_t)nodes));
    return reserve_links(g, (uint32_t)links);
}

/* Takes over the contents; the capacities are equal. Scratch tables are not copied. */
static void copy_contents(Graph *to, const Graph *from)
{
    Graph own = *to;
    *to = *from;
    to->nodes = own.nodes;
    to->digs = own.digs;
    to->alive = own.alive;
    to->touched = own.touched;
    to->queue = own.queue;
    to->changes = own.changes;
    to->links = own.links;
    to->adds = own.adds;
    to->removes = own.removes;
    memcpy(to->held, own.held, sizeof to->held);
    to->by_id = own.by_id;
    to->allocations = own.allocations;
    if (to->node_capacity) {
        memcpy(to->nodes, from->nodes, from->node_capacity * sizeof *to->nodes);
        memcpy(to->digs, from->digs, from->dig_top * sizeof *to->digs);
        memcpy(to->alive, from->alive, from->alive_count * sizeof *to->alive);
        memcpy(to->changes, from->changes, from->change_count * sizeof *to->changes);
        dig_status copied = map_copy(&to->by_id, &from->by_id);
        DIG_ASSERT(copied == DIG_OK);       /* same node capacity, same size: no allocation */
        (void)copied;
    }
    if (to->link_capacity) {
        memcpy(to->links, from->links, from->link_top * sizeof *to->links);
        memcpy(to->adds, from->adds, from->add_count * sizeof *to->adds);
        memcpy(to->removes, from->removes, from->remove_count * sizeof *to->removes);
    }
}

dig_status graph_copy(Graph **to, const Graph *from)
{
    if (*to == from)
        return DIG_OK;
    if (!*to || (*to)->node_capacity != from->node_capacity || (*to)->link_capacity != from->link_capacity) {
        Graph *fresh;
        DIG_TRY(graph_open(&fresh));
        if (reserve_nodes(fresh, from->node_capacity) != DIG_OK || reserve_links(fresh, from->link_capacity) != DIG_OK) {
            graph_close(fresh);
            return DIG_E_MEMORY;
        }
        if (*to) {                          /* only the tables change hands */
            Graph old = **to;
            fresh->allocations += graph_allocations(&old);
            **to = *fresh;
            *fresh = old;
            graph_close(fresh);
        } else {
            *to = fresh;
        }
    }
    copy_contents(*to, from);
    return DIG_OK;
}

size_t graph_bytes(const Graph *g)
{
    size_t node = sizeof *g->nodes + sizeof *g->digs + sizeof *g->alive + sizeof *g->touched + sizeof *g->queue
                + 2 * sizeof *g->changes;
    size_t link = sizeof *g->links + sizeof *g->adds + sizeof *g->removes;
    return sizeof *g + node * g->node_capacity + link * g->link_capacity + map_bytes(&g->by_id);
}

uint64_t graph_allocations(const Graph *g)
{
    return g->allocations + g->by_id.allocations;
}

/* ---- DIG records ---- */

uint32_t graph_dig_take(Graph *g)
{
    uint32_t dig = g->free_dig;
    if (dig != NIL)
        g->free_dig = g->digs[dig].first;
    else
        dig = g->dig_top++;
    DIG_ASSERT(dig < g->node_capacity);
    g->digs[dig] = (GraphDig){.first = NIL, .last = NIL, .place = NIL};
    return dig;
}

/* Takes it out of alive[], whose last entry moves into the gap. */
void graph_dig_give(Graph *g, uint32_t dig)
{
    uint32_t place = g->digs[dig].place;
    if (place != NIL) {
        uint32_t moved = g->alive[--g->alive_count];
        g->alive[place] = moved;
        g->digs[moved].place = place;
    }
    g->digs[dig] = (GraphDig){.first = g->free_dig, .last = NIL, .place = NIL};
    g->free_dig = dig;
}

void graph_id_set(Graph *g, uint32_t dig, uint32_t id)
{
    GraphDig *d = &g->digs[dig];
    if (d->place == NIL) {
        d->place = g->alive_count;
        g->alive[g->alive_count++] = dig;
    }
    d->id = id;
    dig_status put = map_put(&g->by_id, map_key(id), dig);
    DIG_ASSERT(put == DIG_OK);          /* reserved with the nodes */
    (void)put;
}

static const GraphDig *find_dig(const Graph *g, uint32_t id)
{
    uint32_t dig;
    return map_find(&g->by_id, map_key(id), &dig) ? &g->digs[dig] : NULL;
}

/* ---- nodes ---- */

bool graph_has_node(const Graph *g, uint32_t node)
{
    return node < g->node_capacity && g->nodes[node].dig != NIL;
}

dig_status graph_node_add(Graph *g, uint32_t node)
{
    if (graph_has_node(g, node))
        return DIG_E_ARG;
    if (node >= NODE_LIMIT || g->next_id == UINT32_MAX)
        return DIG_E_FULL;
    if (node >= g->node_capacity)
        DIG_TRY(reserve_nodes(g, grown(g->node_capacity, node + 1, NODE_LIMIT)));
    uint32_t dig = graph_dig_take(g);
    g->digs[dig].size = 1;
    g->digs[dig].first = g->digs[dig].last = node;
    g->nodes[node] = (GraphNode){.dig = dig, .next = NIL, .prev = NIL, .links = NIL};
    g->node_count++;
    graph_id_set(g, dig, g->next_id++);
    return DIG_OK;
}

void graph_node_remove(Graph *g, uint32_t node)
{
    bool fit = !g->batch && graph_has_node(g, node) && g->nodes[node].links == NIL;
    DIG_ASSERT(fit);
    if (!fit)
        return;
    uint32_t dig = g->nodes[node].dig;
    map_remove(&g->by_id, map_key(g->digs[dig].id));
    graph_dig_give(g, dig);
    g->nodes[node].dig = NIL;
    g->node_count--;
    g->change_count = 0;
}

/* ---- links and batches ---- */

void graph_begin(Graph *g)
{
    DIG_ASSERT(!g->batch);
    if (g->batch)
        return;
    g->batch = true;
    g->change_count = 0;
}

dig_status graph_end(Graph *g)
{
    DIG_ASSERT(g->batch);
    if (!g->batch)
        return DIG_E_ARG;
    if (g->remove_count && UINT32_MAX - g->next_id < g->node_count)    /* a batch makes fewer new ids than there are nodes */
        return DIG_E_FULL;
    graph_apply(g);
    g->batch = false;
    return DIG_OK;
}

static dig_status take_link(Graph *g, uint32_t *link)
{
    if (g->free_link != NIL) {
        *link = g->free_link;
        g->free_link = g->links[*link].next[0];
        return DIG_OK;
    }
    if (g->link_top == g->link_capacity)
        DIG_TRY(reserve_links(g, grown(g->link_capacity, g->link_top + 1, LINK_LIMIT)));
    *link = g->link_top++;
    return DIG_OK;
}

void graph_link_give(Graph *g, uint32_t link)
{
    g->links[link] = (GraphLink){.next = {g->free_link, NIL}};
    g->free_link = link;
}

dig_status graph_link_add(Graph *g, uint32_t a, uint32_t b, bool bound, uint8_t kind, uint32_t user, real began, uint32_t *link)
{
    if (!graph_has_node(g, a) || (!bound && (a == b || !graph_has_node(g, b))))
        return DIG_E_ARG;
    uint32_t l;
    DIG_TRY(take_link(g, &l));
    g->links[l] = (GraphLink){.a = a, .b = b, .kind = kind, .bound = bound, .alive = true, .state = LINK_ADDING, .user = user,
                              .began = began, .next = {NIL, NIL}, .prev = {NIL, NIL}};
    bool alone = !g->batch;
    if (alone)
        graph_begin(g);
    g->adds[g->add_count++] = l;
    if (link)
        *link = l;
    return alone ? graph_end(g) : DIG_OK;
}

void graph_link_remove(Graph *g, uint32_t link)
{
    bool fit = link < g->link_top && g->links[link].alive;
    DIG_ASSERT(fit);
    if (!fit)
        return;
    bool alone = !g->batch;
    if (alone)
        graph_begin(g);
    GraphLink *l = &g->links[link];
    if (l->state == LINK_ADDING) {
        l->state = LINK_CANCELLED;
        l->alive = false;
    } else if (l->state == LINK_ATTACHED) {
        l->state = LINK_REMOVING;
        g->removes[g->remove_count++] = link;
    }
    if (alone)
        (void)graph_end(g);
}

int graph_changes(const Graph *g, const GraphChange **out)
{
    *out = g->changes;
    return (int)g->change_count;
}

/* ---- questions ---- */

const GraphLink *graph_link(const Graph *g, uint32_t link)
{
    return link < g->link_top && g->links[link].alive ? &g->links[link] : NULL;
}

void graph_link_set_user(Graph *g, uint32_t link, uint32_t user)
{
    if (graph_link(g, link))
        g->links[link].user = user;
}

uint32_t graph_of(const Graph *g, uint32_t node)
{
    return graph_has_node(g, node) ? g->digs[g->nodes[node].dig].id : GRAPH_NONE;
}

int graph_count(const Graph *g)
{
    return (int)g->alive_count;
}

uint32_t graph_by_index(const Graph *g, int index)
{
    return index >= 0 && (uint32_t)index < g->alive_count ? g->digs[g->alive[index]].id : GRAPH_NONE;
}

int graph_size(const Graph *g, uint32_t id)
{
    const GraphDig *d = find_dig(g, id);
    return d ? (int)d->size : 0;
}

uint32_t graph_first(const Graph *g, uint32_t id)
{
    const GraphDig *d = find_dig(g, id);
    return d ? d->first : GRAPH_END;
}

uint32_t graph_next(const Graph *g, uint32_t node)
{
    return graph_has_node(g, node) ? g->nodes[node].next : GRAPH_END;
}

static const GraphDig *record_of(const Graph *g, uint32_t node)
{
    return graph_has_node(g, node) ? &g->digs[g->nodes[node].dig] : NULL;
}

uint32_t graph_lead(const Graph *g, uint32_t node)
{
    const GraphDig *d = record_of(g, node);
    return d ? d->first : GRAPH_END;
}

int graph_fellows(const Graph *g, uint32_t node)
{
    const GraphDig *d = record_of(g, node);
    return d ? (int)d->size : 0;
}

uint64_t graph_user_of(const Graph *g, uint32_t node)
{
    const GraphDig *d = record_of(g, node);
    return d ? d->user : 0;
}

uint32_t graph_link_first(const Graph *g, uint32_t node)
{
    uint32_t entry = graph_has_node(g, node) ? g->nodes[node].links : NIL;
    return entry == NIL ? GRAPH_END : entry_link(entry);
}

uint32_t graph_link_after(const GraphLink *l, uint32_t node)
{
    uint32_t entry = l->next[l->a == node ? 0 : 1];
    return entry == NIL ? GRAPH_END : entry_link(entry);
}

uint32_t graph_link_next(const Graph *g, uint32_t node, uint32_t link)
{
    const GraphLink *l = graph_link(g, link);
    return l ? graph_link_after(l, node) : GRAPH_END;
}

void graph_set_user(Graph *g, uint32_t id, uint64_t user)
{
    uint32_t dig;
    if (map_find(&g->by_id, map_key(id), &dig))
        g->digs[dig].user = user;
}

uint64_t graph_user(const Graph *g, uint32_t id)
{
    const GraphDig *d = find_dig(g, id);
    return d ? d->user : 0;
}

uint64_t graph_visits(const Graph *g)
{
    return g->visits;
}
