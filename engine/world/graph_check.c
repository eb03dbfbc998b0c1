/* world/graph_check.c - a graph against brute force, and its checksum. */
#include "world/graph_inside.h"

#include <stdlib.h>

/* ---- checksum ---- */

/* One round of the splitmix64 finaliser over the running value (see base/map.c for the source). */
static void stir(uint64_t *hash, uint64_t word)
{
    uint64_t x = *hash ^ (word + 0x9E3779B97F4A7C15u);
    x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9u;
    x = (x ^ x >> 27) * 0x94D049BB133111EBu;
    *hash = x ^ x >> 31;
}

uint64_t graph_hash(const Graph *g)
{
    uint64_t hash = g->next_id;
    for (uint32_t i = 0; i < g->node_capacity; i++) {
        if (graph_has_node(g, i)) {
            stir(&hash, i);
            stir(&hash, graph_of(g, i));
        }
    }
    for (uint32_t i = 0; i < g->link_top; i++) {
        const GraphLink *l = &g->links[i];
        if (!l->alive)
            continue;
        uint64_t began;
        memcpy(&began, &l->began, sizeof began);
        stir(&hash, (uint64_t)i << 32 | (uint64_t)l->kind << 1 | l->bound);
        stir(&hash, (uint64_t)l->a << 32 | l->b);
        stir(&hash, l->user);
        stir(&hash, began);
    }
    return hash;
}

/* ---- brute force ---- */

static bool in_lists(const GraphLink *l)
{
    return l->alive && (l->state == LINK_ATTACHED || l->state == LINK_REMOVING);
}

/* Colours every node with the lowest slot of its component by hooking and short-cutting until nothing changes (after Shiloach
 * and Vishkin, J. Algorithms 3, 1982); deliberately not the method of graph_split.c. low[i] <= i is always in i's component. */
static void colour(const Graph *g, uint32_t *low)
{
    for (uint32_t i = 0; i < g->node_capacity; i++)
        low[i] = i;
    for (bool changed = true; changed;) {
        changed = false;
        for (uint32_t i = 0; i < g->link_top; i++) {
            const GraphLink *l = &g->links[i];
            if (!in_lists(l) || l->bound || low[l->a] == low[l->b])
                continue;
            uint32_t x = low[l->a], y = low[l->b], least = x < y ? x : y, most = x < y ? y : x;
            if (low[most] > least)
                low[most] = least;
            changed = true;
        }
        for (uint32_t i = 0; i < g->node_capacity; i++)
            low[i] = low[low[i]];
    }
}

/* Same colour <=> same DIG: a node has the DIG of the node that gave it its colour, and there are as many DIGs as colours. */
static bool check_labels(const Graph *g, const uint32_t *low)
{
    uint32_t nodes = 0, colours = 0;
    for (uint32_t i = 0; i < g->node_capacity; i++) {
        if (!graph_has_node(g, i))
            continue;
        nodes++;
        colours += low[i] == i;
        if (g->nodes[i].dig >= g->dig_top || g->nodes[i].dig != g->nodes[low[i]].dig)
            return false;
    }
    return nodes == g->node_count && colours == g->alive_count;
}

static bool check_members(const Graph *g)
{
    uint64_t sum = 0;
    for (uint32_t place = 0; place < g->alive_count; place++) {
        uint32_t dig = g->alive[place], size = 0, last = NIL, found;
        const GraphDig *d = &g->digs[dig];
        if (d->place != place || d->touched || d->id == GRAPH_NONE || d->id >= g->next_id)
            return false;
        if (!map_find(&g->by_id, map_key(d->id), &found) || found != dig)
            return false;
        for (uint32_t node = d->first; node != NIL; node = g->nodes[node].next) {
            if (size++ == g->node_count || g->nodes[node].dig != dig || g->nodes[node].prev != last)
                return false;
            last = node;
        }
        if (size != d->size || last != d->last || !size)
            return false;
        sum += size;
    }
    return sum == g->node_count && g->by_id.count == g->alive_count;
}

static bool check_adjacency(const Graph *g)
{
    uint64_t expected = 0, listed = 0;
    for (uint32_t i = 0; i < g->link_top; i++)
        if (in_lists(&g->links[i]))
            expected += g->links[i].bound ? 1 : 2;
    for (uint32_t node = 0; node < g->node_capacity; node++) {
        uint32_t prev = NIL;
        if (!graph_has_node(g, node))
            continue;
        for (uint32_t entry = g->nodes[node].links; entry != NIL; ) {
            if (entry_link(entry) >= g->link_top || listed++ == expected)
                return false;
            const GraphLink *l = &g->links[entry_link(entry)];
            uint32_t side = entry_side(entry);
            if (!in_lists(l) || (side ? l->b : l->a) != node || (side && l->bound) || l->prev[side] != prev)
                return false;
            prev = entry;
            entry = l->next[side];
        }
    }
    return listed == expected;
}

bool graph_check_in(const Graph *g, uint32_t *low)
{
    if (!g->node_capacity)
        return g->node_count == 0 && g->alive_count == 0;
    colour(g, low);
    bool good = check_labels(g, low) && check_members(g) && check_adjacency(g);
    return good && (g->batch || (!g->add_count && !g->remove_count)) && !g->touched_count;
}

bool graph_check(const Graph *g)
{
    uint32_t *low = malloc((g->node_capacity + 1) * sizeof *low);
    bool good = low && graph_check_in(g, low);
    free(low);
    return good;
}
