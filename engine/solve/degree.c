/* solve/degree.c - least degree first, with buckets. */
#include "solve/degree.h"

static void *taken(Degree *d, size_t bytes)
{
    void *p = arena_zero(d->arena, bytes);
    d->failed = d->failed || !p;
    return p;
}

void degree_open(Degree *d, Arena *arena, int count)
{
    size_t n = (size_t)count + 1;
    *d = (Degree){.arena = arena, .count = count};
    d->next = taken(d, n * sizeof *d->next);
    d->head = taken(d, n * sizeof *d->head);
    d->after = taken(d, n * sizeof *d->after);
    d->before = taken(d, n * sizeof *d->before);
    d->eligible = taken(d, n * sizeof *d->eligible);
    d->mark = taken(d, n * sizeof *d->mark);
    for (int i = 0; !d->failed && i <= count; i++)
        d->head[i] = -1;
}

static bool adjacent(const Adjacent *a, int node)
{
    for (int i = 0; i < a->count; i++)
        if (a->node[i] == node)
            return true;
    return false;
}

static void add_one(Degree *d, int from, int to)
{
    Adjacent *a = &d->next[from];
    if (a->count == a->room) {
        int room = 2 * a->room + 4;
        int *node = arena_alloc(d->arena, (size_t)room * sizeof *node);
        if (!node) {
            d->failed = true;
            return;
        }
        if (a->count > 0)
            memcpy(node, a->node, (size_t)a->count * sizeof *node);
        a->node = node;
        a->room = room;
    }
    a->node[a->count++] = to;
}

void degree_link(Degree *d, int x, int y)
{
    if (d->failed || adjacent(&d->next[x], y))
        return;
    add_one(d, x, y);
    add_one(d, y, x);
}

static void disconnect(Adjacent *a, int node)
{
    int n = 0;
    for (int i = 0; i < a->count; i++)
        if (a->node[i] != node)
            a->node[n++] = a->node[i];
    a->count = n;
}

static void bucket_take(Degree *d, int node, int degree)
{
    if (d->before[node] >= 0)
        d->after[d->before[node]] = d->after[node];
    else
        d->head[degree] = d->after[node];
    if (d->after[node] >= 0)
        d->before[d->after[node]] = d->before[node];
}

static void bucket_put(Degree *d, int node)
{
    int degree = d->next[node].count;
    d->after[node] = d->head[degree];
    d->before[node] = -1;
    if (d->head[degree] >= 0)
        d->before[d->head[degree]] = node;
    d->head[degree] = node;
}

void degree_ready(Degree *d, int node)
{
    d->eligible[node] = true;
    bucket_put(d, node);
}

int degree_next(Degree *d)
{
    int least = 0;
    while (d->head[least] < 0)
        least++;
    int node = d->head[least];
    bucket_take(d, node, least);
    return node;
}

/* The same as degree_link with each of them, without looking through the list for each. */
static void link_to_rest(Degree *d, int node, const int *rest, int count)
{
    const Adjacent *a = &d->next[node];
    d->marks++;
    for (int i = 0; i < a->count; i++)
        d->mark[a->node[i]] = d->marks;
    for (int i = 0; i < count && !d->failed; i++)
        if (d->mark[rest[i]] != d->marks) {
            add_one(d, node, rest[i]);
            add_one(d, rest[i], node);
        }
}

void degree_eliminate(Degree *d, int node, bool frees)
{
    const Adjacent gone = d->next[node];
    for (int i = 0; i < gone.count; i++)
        if (d->eligible[gone.node[i]])
            bucket_take(d, gone.node[i], d->next[gone.node[i]].count);
    for (int i = 0; i < gone.count; i++)
        disconnect(&d->next[gone.node[i]], node);
    for (int i = 0; i < gone.count && !d->failed; i++)
        link_to_rest(d, gone.node[i], gone.node + i + 1, gone.count - i - 1);
    for (int i = 0; i < gone.count; i++) {
        int u = gone.node[i];
        d->eligible[u] = d->eligible[u] || frees;
        if (d->eligible[u])
            bucket_put(d, u);
    }
}
