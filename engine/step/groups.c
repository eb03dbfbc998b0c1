/* step/groups.c - DIGs that may meet in this step are advanced together.
 *
 * A group is a set of DIGs connected by pairs whose reach boxes overlap, with
 * at least one awake member. Static and kinematic bodies connect nothing, so
 * that the ground does not join all piles into one. Groups share no writable
 * data: any order, or any number of threads, gives the same bits.
 */
#include "step/step.h"

#include <stdlib.h>

static uint32_t find_root(World *w, uint32_t i)
{
    uint32_t *parent = w->parent.data;
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

/* The lower slot becomes the root: independent of the order of unions. */
static void unite(World *w, uint32_t a, uint32_t b)
{
    a = find_root(w, a);
    b = find_root(w, b);
    if (a < b)
        w->parent.data[b] = a;
    else
        w->parent.data[a] = b;
}

/* Every DIG is represented by its first member. */
static uint32_t dig_node(World *w, uint32_t body, uint32_t *nodes, int *count)
{
    uint32_t rep = graph_first(w->graph, graph_of(w->graph, body));
    if (w->parent.data[rep] == NONE) {
        w->parent.data[rep] = rep;
        nodes[(*count)++] = rep;
    }
    return rep;
}

static bool is_dynamic(const World *w, uint32_t body) { return body != NONE && w->bodies.data[body].kind == DIG_DYNAMIC; }

static box3 reach_now(const World *w, const Solid *s)
{
    const Body *b = s->body == NONE ? NULL : &w->bodies.data[s->body];
    if (b && b->listed)
        return s->reach;
    return s->leaf >= 0 ? tree_box(&w->tree, s->leaf) : (box3){{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};
}

typedef struct ActivePair { uint32_t root, pair; } ActivePair;

static int compare_active(const void *a, const void *b)
{
    const ActivePair *x = a, *y = b;
    if (x->root != y->root)
        return x->root < y->root ? -1 : 1;
    return x->pair < y->pair ? -1 : x->pair > y->pair;
}

/* A mover that may reach a sleeper wakes it: neither has an inverse mass, so no impulse would tell. */
static bool mover_wakes(World *w, uint32_t mover, uint32_t other)
{
    const Body *m = &w->bodies.data[mover], *o = &w->bodies.data[other];
    if (m->kind != DIG_KINEMATIC || o->awake || (vec3_length2(m->v) == 0 && vec3_length2(m->w) == 0))
        return false;
    body_wake(w, other);
    return true;
}

/* Pairs of awake bodies whose reach boxes overlap; unites DIGs across them. DIG_E_BUSY: a mover woke a sleeper. */
static dig_status collect_pairs(World *w, uint32_t *nodes, int *node_count, ActivePair *pairs, int *pair_count)
{
    uint64_t stamp = 2 * w->steps + 1;
    for (int i = 0; i < w->awake.count; i++) {
        uint32_t body = w->awake.data[i];
        bool moves = is_dynamic(w, body);
        if (moves)
            dig_node(w, body, nodes, node_count);
        for (uint32_t s = w->bodies.data[body].shape_first; s != NONE; s = w->solids.data[s].next)
            for (uint32_t l = w->solids.data[s].pair_first; l != NONE; l = w->pairs.data[l / 2].next[l % 2]) {
                Pair *p = &w->pairs.data[l / 2];
                uint32_t other = l % 2 ? p->body_a : p->body_b;
                if (p->seen == stamp || (!moves && !is_dynamic(w, other)))
                    continue;
                if (!box3_overlap(reach_now(w, &w->solids.data[p->solid_a]), reach_now(w, &w->solids.data[p->solid_b])))
                    continue;
                if (!moves && mover_wakes(w, body, other))
                    return DIG_E_BUSY;
                if (!moves && !w->bodies.data[other].awake)
                    continue;               /* a mover at rest and a sleeper */
                p->seen = stamp;
                uint32_t a = moves ? body : other;
                if (is_dynamic(w, other) && moves)
                    unite(w, dig_node(w, a, nodes, node_count), dig_node(w, other, nodes, node_count));
                else
                    dig_node(w, a, nodes, node_count);
                pairs[(*pair_count)++] = (ActivePair){a, l / 2};
            }
    }
    return DIG_OK;
}

static void forget_seen(World *w, const ActivePair *pairs, int count)
{
    for (int i = 0; i < count; i++)
        w->pairs.data[pairs[i].pair].seen = 0;
}

static int group_accuracy(const World *w, const uint32_t *digs, int count)
{
    int accuracy = w->accuracy;
    for (int i = 0; i < count; i++)
        accuracy = int_max(accuracy, (int)graph_user(w->graph, digs[i]));
    return accuracy;
}

/* The sum of what traced groups may cost is bounded by counts, never by the clock, so that results do not depend on the machine.
 * The first group fits always: one long chain is a world's main business, not one of a thousand. */
static bool within_budget(const World *w, const Step *s, const struct StepGroup *g, int64_t *spent)
{
    int64_t cost = g->pair_count;
    for (int i = 0; i < g->dig_count; i++)
        cost += graph_size(w->graph, s->digs[g->dig_first + i]);
    bool fits = *spent == 0 || *spent + cost <= accuracy_plan(g->accuracy)->trace_total;
    *spent += fits ? cost : 0;
    return fits;
}

typedef struct NodeRoot { uint32_t root, node; } NodeRoot;

/* Cuts the sorted lists into groups. */
static dig_status cut(World *w, Step *s, const NodeRoot *nodes, int node_count, const ActivePair *pairs, int pair_count)
{
    int p = 0;
    int64_t spent = 0;
    for (int i = 0; i < node_count; s->count++) {
        struct StepGroup *g = &s->parts[s->count];
        uint32_t root = nodes[i].root;
        *g = (struct StepGroup){.dig_first = i, .pair_first = p};
        for (; i < node_count && nodes[i].root == root; i++, g->dig_count++)
            s->digs[i] = graph_of(w->graph, nodes[i].node);
        for (; p < pair_count && pairs[p].root == root; p++, g->pair_count++)
            s->pairs[p] = pairs[p].pair;
        g->accuracy = group_accuracy(w, s->digs + g->dig_first, g->dig_count);
        g->may_trace = within_budget(w, s, g, &spent);
    }
    return DIG_OK;
}

dig_status form_groups(World *w, Step *s)
{
    int capacity = 0;
    for (int i = 0; i < w->awake.count; i++)
        for (uint32_t k = w->bodies.data[w->awake.data[i]].shape_first; k != NONE; k = w->solids.data[k].next)
            for (uint32_t l = w->solids.data[k].pair_first; l != NONE; l = w->pairs.data[l / 2].next[l % 2])
                capacity++;
    int most_nodes = w->awake.count + capacity;
    uint32_t *nodes = arena_alloc(&w->scratch, (size_t)(most_nodes + 1) * sizeof *nodes);
    ActivePair *pairs = arena_alloc(&w->scratch, (size_t)(capacity + 1) * sizeof *pairs);
    if (!nodes || !pairs)
        return world_fail(w, DIG_E_MEMORY, "not enough memory for the step's groups");
    int node_count = 0, pair_count = 0;
    dig_status status = collect_pairs(w, nodes, &node_count, pairs, &pair_count);

    NodeRoot *roots = arena_alloc(&w->scratch, (size_t)(node_count + 1) * sizeof *roots);
    s->digs = arena_alloc(&w->scratch, (size_t)(node_count + 1) * sizeof *s->digs);
    s->pairs = arena_alloc(&w->scratch, (size_t)(pair_count + 1) * sizeof *s->pairs);
    s->parts = arena_alloc(&w->scratch, (size_t)(node_count + 1) * sizeof *s->parts);
    s->groups = arena_zero(&w->scratch, (size_t)(node_count + 1) * sizeof *s->groups);
    s->count = 0;
    if (!roots || !s->digs || !s->pairs || !s->parts || !s->groups)
        status = world_fail(w, DIG_E_MEMORY, "not enough memory for the step's groups");
    if (status == DIG_OK) {
        for (int i = 0; i < node_count; i++)
            roots[i] = (NodeRoot){find_root(w, nodes[i]), nodes[i]};
        for (int i = 0; i < pair_count; i++)
            pairs[i].root = find_root(w, graph_first(w->graph, graph_of(w->graph, pairs[i].root)));
        qsort(roots, (size_t)node_count, sizeof *roots, compare_active);
        qsort(pairs, (size_t)pair_count, sizeof *pairs, compare_active);
        status = cut(w, s, roots, node_count, pairs, pair_count);
    }
    for (int i = 0; i < node_count; i++)
        w->parent.data[nodes[i]] = NONE;
    forget_seen(w, pairs, pair_count);
    return status;
}
