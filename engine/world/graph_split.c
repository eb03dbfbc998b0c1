/* world/graph_split.c - what a batch does to the DIGs: pieces fall off, pieces join, and then ids are given out.
 *
 * Order of work in graph_apply:
 *   1. attach the added links that lie within one DIG of before (or are bound): they change no label, but may hold it together;
 *   2. detach the removed links, one at a time, and split where the two ends are no longer connected;
 *   3. attach the added links between DIGs of before and merge.
 * Removing first is cheaper: what changes over from one large DIG to another is cut out and added, instead of two large DIGs
 * being merged and cut apart. The partition after 3 does not depend on the order. The pieces after 2 refine both the partition
 * before and the one after, so that uniting, in a union-find over DIG records, whatever was split from or merged with each other
 * gives exactly the blocks of graph.h, in which settle_ids gives out the ids.
 */
#include "world/graph_inside.h"

/* ---- adjacency ---- */

static uint32_t end_of(const GraphLink *l, uint32_t side)
{
    return side ? l->b : l->a;
}

static void list_link(Graph *g, uint32_t link, uint32_t side)
{
    GraphLink *l = &g->links[link];
    GraphNode *n = &g->nodes[end_of(l, side)];
    uint32_t entry = link * 2 + side;
    l->next[side] = n->links;
    l->prev[side] = NIL;
    if (n->links != NIL)
        g->links[entry_link(n->links)].prev[entry_side(n->links)] = entry;
    n->links = entry;
}

static void unlist_link(Graph *g, uint32_t link, uint32_t side)
{
    GraphLink *l = &g->links[link];
    uint32_t next = l->next[side], prev = l->prev[side];
    if (next != NIL)
        g->links[entry_link(next)].prev[entry_side(next)] = prev;
    if (prev != NIL)
        g->links[entry_link(prev)].next[entry_side(prev)] = next;
    else
        g->nodes[end_of(l, side)].links = next;
}

static void attach(Graph *g, uint32_t link)
{
    list_link(g, link, 0);
    if (!g->links[link].bound)
        list_link(g, link, 1);
    g->links[link].state = LINK_ATTACHED;
}

static void detach(Graph *g, uint32_t link)
{
    unlist_link(g, link, 0);
    if (!g->links[link].bound)
        unlist_link(g, link, 1);
}

/* ---- blocks ---- */

/* Notes what the record was before the batch; returns its place in touched[]. */
static uint32_t touch(Graph *g, uint32_t dig)
{
    GraphDig *d = &g->digs[dig];
    if (d->touched)
        return d->touched - 1;
    uint32_t at = g->touched_count++;
    d->touched = at + 1;
    g->touched[at] = (GraphTouched){.dig = dig, .old_id = d->id, .old_size = d->size, .piece = d->size, .origin = at, .into = at, .block = at,
                                    .low = NIL, .holder = NIL, .winner = NIL};
    return at;
}

static uint32_t block_of(Graph *g, uint32_t at)
{
    GraphTouched *t = g->touched;
    while (t[at].block != at)
        at = t[at].block = t[t[at].block].block;        /* path halving */
    return at;
}

/* The DIG that the members of the piece are in now. */
static uint32_t part_of(Graph *g, uint32_t at)
{
    GraphTouched *t = g->touched;
    while (t[at].into != at)
        at = t[at].into = t[t[at].into].into;
    return at;
}

static void unite_blocks(Graph *g, uint32_t x, uint32_t y)
{
    g->touched[block_of(g, y)].block = block_of(g, x);
}

/* ---- split ---- */

/* Breadth-first search from one end of a removed link. Two of them share the queue, one from its front, one from its back. */
typedef struct Search {
    uint32_t start;             /* index in the queue of the first node found */
    bool     backward;
    uint32_t found, taken;      /* nodes                                      */
    uint32_t entry;             /* next entry to look at, of the node taken last */
    uint64_t mark, other;       /* marks of this search and of its partner    */
} Search;

typedef enum Progress { GOES_ON, MET, EXHAUSTED } Progress;

static uint32_t *queue_at(Graph *g, const Search *s, uint32_t i)
{
    return &g->queue[s->backward ? s->start - i : s->start + i];
}

static Search search_from(Graph *g, uint32_t node, bool backward)
{
    Search s = {.start = backward ? g->node_capacity - 1 : 0, .backward = backward, .found = 1, .entry = NIL,
                .mark = g->search * 2 + backward, .other = g->search * 2 + !backward};
    *queue_at(g, &s, 0) = node;
    g->nodes[node].mark = s.mark;
    return s;
}

/* Looks at one link. */
static Progress search_step(Graph *g, Search *s)
{
    while (s->entry == NIL) {
        if (s->taken == s->found)
            return EXHAUSTED;
        s->entry = g->nodes[*queue_at(g, s, s->taken++)].links;
        g->visits++;
    }
    const GraphLink *l = &g->links[entry_link(s->entry)];
    uint32_t side = entry_side(s->entry);
    s->entry = l->next[side];
    g->visits++;
    if (l->bound)
        return GOES_ON;
    uint32_t node = end_of(l, !side);
    if (g->nodes[node].mark == s->other)
        return MET;
    if (g->nodes[node].mark != s->mark) {
        g->nodes[node].mark = s->mark;
        *queue_at(g, s, s->found++) = node;
    }
    return GOES_ON;
}

static void leave_dig(Graph *g, uint32_t node)
{
    GraphNode *n = &g->nodes[node];
    GraphDig *d = &g->digs[n->dig];
    if (n->prev != NIL)
        g->nodes[n->prev].next = n->next;
    else
        d->first = n->next;
    if (n->next != NIL)
        g->nodes[n->next].prev = n->prev;
    else
        d->last = n->prev;
    d->size--;
}

static void enter_dig(Graph *g, uint32_t node, uint32_t dig)
{
    GraphNode *n = &g->nodes[node];
    GraphDig *d = &g->digs[dig];
    n->dig = dig;
    n->next = NIL;
    n->prev = d->last;
    if (d->last != NIL)
        g->nodes[d->last].next = node;
    else
        d->first = node;
    d->last = node;
    d->size++;
}

/* The nodes found become a DIG of their own, which has no id yet. */
static void split_off(Graph *g, const Search *part)
{
    uint32_t from = g->nodes[*queue_at(g, part, 0)].dig, to = graph_dig_take(g);
    uint32_t whole = touch(g, from), piece = touch(g, to);
    unite_blocks(g, whole, piece);
    g->touched[piece].origin = g->touched[whole].origin;
    for (uint32_t i = 0; i < part->found; i++) {
        uint32_t node = *queue_at(g, part, i);
        leave_dig(g, node);
        enter_dig(g, node, to);
    }
    g->visits += part->found;
}

/* The link between a and b is gone: are they still connected? One link is looked at from each end in turn, so that the smaller
 * side sets the cost. */
static void separate(Graph *g, uint32_t a, uint32_t b)
{
    g->search++;
    Search side[2] = {search_from(g, a, false), search_from(g, b, true)};
    for (uint32_t turn = 0;; turn ^= 1) {
        Progress p = search_step(g, &side[turn]);
        if (p == EXHAUSTED)
            split_off(g, &side[turn]);
        if (p != GOES_ON)
            return;
    }
}

/* ---- merge ---- */

/* Moves the members of the smaller to the end of the larger one's list. The empty record stays until settle_ids. */
static void merge(Graph *g, uint32_t x, uint32_t y)
{
    uint32_t tx = touch(g, x), ty = touch(g, y);
    unite_blocks(g, tx, ty);
    bool y_stays = g->digs[y].size > g->digs[x].size
                || (g->digs[y].size == g->digs[x].size && g->touched[ty].old_id < g->touched[tx].old_id);
    uint32_t to = y_stays ? y : x;
    GraphDig *large = &g->digs[to], *small = &g->digs[y_stays ? x : y];
    g->touched[y_stays ? tx : ty].into = y_stays ? ty : tx;
    for (uint32_t node = small->first; node != NIL; node = g->nodes[node].next)
        g->nodes[node].dig = to;
    g->visits += small->size;
    g->nodes[large->last].next = small->first;
    g->nodes[small->first].prev = large->last;
    large->last = small->last;
    large->size += small->size;
    small->first = small->last = NIL;
    small->size = 0;
}

/* ---- ids ---- */

static uint32_t lowest_member(Graph *g, uint32_t at)
{
    GraphTouched *t = &g->touched[at];
    const GraphDig *d = &g->digs[t->dig];
    if (t->low == NIL) {
        for (uint32_t node = d->first; node != NIL; node = g->nodes[node].next)
            t->low = node < t->low ? node : t->low;
        g->visits += d->size;
    }
    return t->low;
}

/* Every block notes which id it keeps: of the largest DIG before, tie: the lower id. */
static void elect_holders(Graph *g)
{
    for (uint32_t i = 0; i < g->touched_count; i++) {
        const GraphTouched *t = &g->touched[i];
        if (t->old_id == GRAPH_NONE)
            continue;
        GraphTouched *block = &g->touched[block_of(g, i)];
        const GraphTouched *best = block->holder == NIL ? NULL : &g->touched[block->holder];
        if (!best || t->old_size > best->old_size || (t->old_size == best->old_size && t->old_id < best->old_id)) {
            block->holder = i;
            block->kept_user = g->digs[t->dig].user;
        }
    }
}

/* And who gets it: the DIG with most of the old members, tie: lowest slot. */
static void elect_winners(Graph *g)
{
    for (uint32_t i = 0; i < g->touched_count; i++) {
        const GraphTouched *t = &g->touched[i];
        if (t->origin == g->touched[block_of(g, i)].holder)
            g->touched[part_of(g, i)].overlap += t->piece;
    }
    for (uint32_t i = 0; i < g->touched_count; i++) {
        uint32_t overlap = g->touched[i].overlap;
        GraphTouched *block = &g->touched[block_of(g, i)];
        uint32_t best = block->winner == NIL ? 0 : g->touched[block->winner].overlap;
        if (overlap > best || (overlap && overlap == best && lowest_member(g, i) < lowest_member(g, block->winner)))
            block->winner = i;
    }
}

/* Heap sort of the changes by `other`, which are all different. */
static void sort_changes(GraphChange *c, uint32_t count)
{
    for (uint32_t heap = count / 2, end = count; end > 1;) {
        if (heap > 0) {
            heap--;
        } else {
            end--;
            GraphChange top = c[0];
            c[0] = c[end];
            c[end] = top;
        }
        GraphChange sinking = c[heap];
        uint32_t hole = heap, child;
        while ((child = 2 * hole + 1) < end) {
            if (child + 1 < end && c[child + 1].other > c[child].other)
                child++;
            if (c[child].other <= sinking.other)
                break;
            c[hole] = c[child];
            hole = child;
        }
        c[hole] = sinking;
    }
}

/* The record that gets the id takes the place in alive[] too, so that a DIG keeps its index. */
static void hand_over(Graph *g, uint32_t from, uint32_t to, uint32_t id)
{
    if (from != to) {
        uint32_t from_place = g->digs[from].place, to_place = g->digs[to].place;
        g->alive[from_place] = to;
        g->digs[to].place = from_place;
        if (to_place != NIL)
            g->alive[to_place] = from;
        g->digs[from].place = to_place;
    }
    graph_id_set(g, to, id);
}

static void settle_ids(Graph *g)
{
    elect_holders(g);
    elect_winners(g);
    const GraphTouched *t = g->touched;
    for (uint32_t i = 0; i < g->touched_count; i++) {
        uint32_t kept = t[t[block_of(g, i)].holder].old_id;
        if (t[i].old_id != GRAPH_NONE && t[i].old_id != kept) {
            map_remove(&g->by_id, map_key(t[i].old_id));
            g->changes[g->change_count++] = (GraphChange){GRAPH_MERGED, kept, t[i].old_id};
        }
    }
    sort_changes(g->changes, g->change_count);
    for (uint32_t i = 0; i < g->touched_count; i++)
        if (t[i].block == i)
            hand_over(g, t[t[i].holder].dig, t[t[i].winner].dig, t[t[i].holder].old_id);
    for (uint32_t i = 0; i < g->touched_count; i++) {
        const GraphTouched *root = &t[block_of(g, i)];
        g->digs[t[i].dig].user = root->kept_user;
        if (g->digs[t[i].dig].size && i != root->winner) {
            g->changes[g->change_count++] = (GraphChange){GRAPH_SPLIT, t[root->holder].old_id, g->next_id};
            graph_id_set(g, t[i].dig, g->next_id++);
        }
    }
    for (uint32_t i = 0; i < g->touched_count; i++) {
        g->digs[t[i].dig].touched = 0;
        if (!g->digs[t[i].dig].size)
            graph_dig_give(g, t[i].dig);
    }
    g->touched_count = 0;
}

/* ---- the batch ---- */

static bool same_dig(const Graph *g, const GraphLink *l)
{
    return g->nodes[l->a].dig == g->nodes[l->b].dig;
}

void graph_apply(Graph *g)
{
    uint32_t later = 0;
    for (uint32_t i = 0; i < g->add_count; i++) {
        uint32_t link = g->adds[i];
        const GraphLink *l = &g->links[link];
        if (l->state == LINK_CANCELLED)
            graph_link_give(g, link);
        else if (l->bound || same_dig(g, l))
            attach(g, link);
        else
            g->adds[later++] = link;
    }
    for (uint32_t i = 0; i < g->remove_count; i++) {
        GraphLink gone = g->links[g->removes[i]];
        detach(g, g->removes[i]);
        graph_link_give(g, g->removes[i]);
        if (!gone.bound) {
            DIG_ASSERT(same_dig(g, &gone));     /* whatever was split off so far was not connected by this link */
            separate(g, gone.a, gone.b);
        }
    }
    for (uint32_t i = 0; i < g->touched_count; i++)
        g->touched[i].piece = g->digs[g->touched[i].dig].size;
    for (uint32_t i = 0; i < later; i++) {
        const GraphLink *l = &g->links[g->adds[i]];
        attach(g, g->adds[i]);
        if (!same_dig(g, l))
            merge(g, g->nodes[l->a].dig, g->nodes[l->b].dig);
    }
    g->add_count = g->remove_count = 0;
    settle_ids(g);
}
