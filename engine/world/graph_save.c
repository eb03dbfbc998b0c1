/* world/graph_save.c - a graph as bytes: DIGs and members, links and the order of their lists. */
#include "world/graph_inside.h"
#include "world/graph_save.h"

#include <stdlib.h>

enum { DIG_BYTES = 24, MEMBER_BYTES = 8, LINK_BYTES = 5 };     /* at least */

/* ---- DIGs ---- */

static void write_digs(Pack *p, Graph *g)
{
    pack_count(p, g->alive_count, DIG_BYTES, "DIGs");
    for (uint32_t place = 0; place < g->alive_count; place++) {
        GraphDig *d = &g->digs[g->alive[place]];
        pack_u32(p, &d->id);
        pack_u64(p, &d->user);
        pack_count(p, d->size, MEMBER_BYTES, "members of a DIG");
        for (uint32_t node = d->first; node != NIL; node = g->nodes[node].next) {
            uint32_t member = node;
            pack_u32(p, &member);
            pack_u32(p, &g->nodes[node].links);
        }
    }
}

/* The last member of the DIG. The head of its list of links is checked with the links. */
static void read_member(Pack *p, Graph *g, uint32_t dig, uint32_t nodes)
{
    GraphDig *d = &g->digs[dig];
    uint32_t node = 0, links = NIL;
    pack_index(p, &node, nodes, false, "member of a DIG");
    pack_u32(p, &links);
    if (!pack_check(p, pack_good(p) && !graph_has_node(g, node), "a body is in two DIGs"))
        return;
    g->nodes[node] = (GraphNode){.dig = dig, .next = NIL, .prev = d->last, .links = links};
    if (d->last != NIL)
        g->nodes[d->last].next = node;
    else
        d->first = node;
    d->last = node;
    d->size++;
    g->node_count++;
}

static void read_digs(Pack *p, Graph *g, uint32_t nodes)
{
    uint32_t count = pack_count(p, 0, DIG_BYTES, "DIGs");
    if (!pack_check(p, count <= nodes, "there are more DIGs than bodies"))
        return;
    for (uint32_t i = 0; i < count && pack_good(p); i++) {
        uint32_t id = 0, dig = graph_dig_take(g);
        pack_index(p, &id, g->next_id, false, "number of a DIG");
        if (!pack_check(p, id != GRAPH_NONE && !map_find(&g->by_id, map_key(id), NULL), "two DIGs have one number"))
            return;
        graph_id_set(g, dig, id);
        pack_u64(p, &g->digs[dig].user);
        uint32_t size = pack_count(p, 0, MEMBER_BYTES, "members of a DIG");
        for (uint32_t m = 0; m < size && pack_good(p); m++)
            read_member(p, g, dig, nodes);
        pack_check(p, g->digs[dig].size > 0, "a DIG has no members");
    }
}

/* ---- links ---- */

/* Free links keep the next free one in next[0]. */
static void pack_link(Pack *p, const Graph *g, GraphLink *l, uint32_t nodes)
{
    pack_bool(p, &l->alive);
    if (!l->alive) {
        pack_u32(p, &l->next[0]);
        return;
    }
    pack_index(p, &l->a, nodes, false, "first body of a link");
    pack_index(p, &l->b, nodes, false, "second body of a link");
    pack_small(p, &l->kind, DIG_LINK_KINDS, "kind of a link");
    pack_bool(p, &l->bound);
    pack_u32(p, &l->user);
    pack_real_in(p, &l->began, 0, 1e30, "beginning of a link");
    pack_u32(p, &l->next[0]);
    pack_u32(p, &l->next[1]);
    if (!p->reading)
        return;
    l->state = LINK_ATTACHED;
    l->prev[0] = l->prev[1] = NIL;
    pack_check(p, pack_good(p) && graph_has_node(g, l->a) && l->a != l->b && (l->bound || graph_has_node(g, l->b)), "a link joins what cannot be joined");
}

static bool free_links_are_sound(const Graph *g)
{
    uint32_t unused = 0, count = 0;
    for (uint32_t i = 0; i < g->link_top; i++)
        unused += !g->links[i].alive;
    for (uint32_t i = g->free_link; i != NIL; i = g->links[i].next[0])
        if (i >= g->link_top || g->links[i].alive || ++count > unused)
            return false;
    return count == unused;
}

/* Fills prev. A link that is met twice would have two predecessors; graph_check finds links that are in no list. */
static bool lists_are_sound(Graph *g)
{
    for (uint32_t node = 0; node < g->node_capacity; node++) {
        uint32_t prev = NIL;
        for (uint32_t entry = graph_has_node(g, node) ? g->nodes[node].links : NIL; entry != NIL;) {
            uint32_t side = entry_side(entry);
            if (entry_link(entry) >= g->link_top)
                return false;
            GraphLink *l = &g->links[entry_link(entry)];
            bool head = entry == g->nodes[node].links;
            if (!l->alive || (side ? l->b : l->a) != node || (side && l->bound) || l->prev[side] != NIL || (prev != NIL && head))
                return false;
            l->prev[side] = prev;
            prev = entry;
            entry = l->next[side];
        }
    }
    return true;
}

static void write_links(Pack *p, Graph *g, uint32_t nodes)
{
    pack_count(p, g->link_top, LINK_BYTES, "links");
    pack_u32(p, &g->free_link);
    for (uint32_t i = 0; i < g->link_top; i++)
        pack_link(p, g, &g->links[i], nodes);
}

static void read_links(Pack *p, Graph *g, uint32_t nodes)
{
    uint32_t count = pack_count(p, 0, LINK_BYTES, "links");
    pack_u32(p, &g->free_link);
    if (!pack_good(p))
        return;
    if (graph_reserve(g, (int)nodes, (int)count) != DIG_OK) {
        pack_fail_memory(p);
        return;
    }
    g->link_top = count;
    for (uint32_t i = 0; i < count; i++) {
        g->links[i] = (GraphLink){.next = {NIL, NIL}};
        pack_link(p, g, &g->links[i], nodes);
    }
    uint32_t *room = malloc((g->node_capacity + 1) * sizeof *room);
    if (!room)
        pack_fail_memory(p);
    else if (!pack_good(p) || !free_links_are_sound(g) || !lists_are_sound(g) || !graph_check_in(g, room))
        pack_fail(p, "the links make no graph");
    free(room);
}

void graph_pack(Pack *p, Graph *g, uint32_t nodes)
{
    pack_u32(p, &g->next_id);
    if (!p->reading) {
        write_digs(p, g);
        write_links(p, g, nodes);
        return;
    }
    if (!pack_check(p, g->next_id >= 1, "the next DIG has no number"))
        return;
    if (graph_reserve(g, (int)nodes, 0) != DIG_OK) {
        pack_fail_memory(p);
        return;
    }
    read_digs(p, g, nodes);
    if (pack_good(p))
        read_links(p, g, nodes);
}
