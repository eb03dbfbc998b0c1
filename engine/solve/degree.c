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

static uint64_t bit_of(int node) { return (uint64_t)1 << node % 64; }
static uint64_t *links_of(const Degree *d, int node) { return d->linked + (size_t)node * (size_t)d->words; }

void degree_by_index(Degree *d)
{
    d->words = d->count / 64 + 1;
    size_t size = (size_t)d->words * ((size_t)d->count + 1) * sizeof *d->waiting;
    d->waiting = taken(d, size);
    d->linked = taken(d, size);
    d->degree = taken(d, ((size_t)d->count + 1) * sizeof *d->degree);
    for (int i = 0; !d->failed && i < d->count; i++)
        links_of(d, i)[i / 64] |= bit_of(i);
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

static void link_bits(Degree *d, int x, int y)
{
    bool new = !(links_of(d, x)[y / 64] & bit_of(y));
    links_of(d, x)[y / 64] |= bit_of(y);
    links_of(d, y)[x / 64] |= bit_of(x);
    d->degree[x] += new;
    d->degree[y] += new;
}

void degree_link(Degree *d, int x, int y)
{
    if (!d->failed && d->linked)
        link_bits(d, x, y);
    if (d->failed || d->linked || adjacent(&d->next[x], y))
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

static uint64_t *word_of(Degree *d, int node, int degree)
{
    return d->waiting + (size_t)degree * (size_t)d->words + (size_t)(node / 64);
}

static int degree_of(const Degree *d, int node) { return d->linked ? d->degree[node] : d->next[node].count; }

static void bucket_take(Degree *d, int node)
{
    int degree = degree_of(d, node);
    if (d->waiting) {
        *word_of(d, node, degree) &= ~bit_of(node);
        return;
    }
    if (d->before[node] >= 0)
        d->after[d->before[node]] = d->after[node];
    else
        d->head[degree] = d->after[node];
    if (d->after[node] >= 0)
        d->before[d->after[node]] = d->before[node];
}

static void bucket_put(Degree *d, int node)
{
    int degree = degree_of(d, node);
    if (d->waiting) {
        *word_of(d, node, degree) |= bit_of(node);
        d->least = int_min(d->least, degree);
        return;
    }
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

/* Its neighbours, ascending. */
static void list_links(Degree *d, int node)
{
    Adjacent *a = &d->next[node];
    const uint64_t *bits = links_of(d, node);
    a->node = arena_alloc(d->arena, (size_t)(d->degree[node] + 1) * sizeof *a->node);
    d->failed = d->failed || !a->node;
    for (int w = 0; !d->failed && w < d->words; w++)
        for (uint64_t rest = bits[w]; rest; rest &= rest - 1) {
            int other = 64 * w + __builtin_ctzll(rest);
            if (other != node)
                a->node[a->count++] = other;
        }
}

static int lowest(Degree *d)
{
    const uint64_t *word = d->waiting + (size_t)d->least * (size_t)d->words;
    while (*word == 0)
        word++;
    d->least = (int)((word - d->waiting) / d->words);
    return (int)((word - d->waiting) % d->words) * 64 + __builtin_ctzll(*word);
}

int degree_next(Degree *d)
{
    int least = 0;
    if (d->waiting) {
        least = lowest(d);
        bucket_take(d, least);
        list_links(d, least);
        return least;
    }
    while (d->head[least] < 0)
        least++;
    int node = d->head[least];
    bucket_take(d, node);
    return node;
}

/* What is linked to what goes is linked to all of that. */
static void join_bits(Degree *d, int node, int gone)
{
    uint64_t *restrict to = links_of(d, node);
    const uint64_t *restrict from = links_of(d, gone);
    const Adjacent *a = &d->next[gone];
    int more = -1;
    for (int w = a->node[0] / 64; w <= a->node[a->count - 1] / 64; w++) {
        uint64_t new = from[w] & ~to[w];
        to[w] |= new;
        for (; new; new &= new - 1)
            more++;
    }
    to[gone / 64] &= ~bit_of(gone);
    d->degree[node] += more;
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
            bucket_take(d, gone.node[i]);
    for (int i = 0; i < gone.count && d->linked; i++)
        join_bits(d, gone.node[i], node);
    for (int i = 0; i < gone.count && !d->linked; i++)
        disconnect(&d->next[gone.node[i]], node);
    for (int i = 0; i < gone.count && !d->linked && !d->failed; i++)
        link_to_rest(d, gone.node[i], gone.node + i + 1, gone.count - i - 1);
    for (int i = 0; i < gone.count; i++) {
        int u = gone.node[i];
        d->eligible[u] = d->eligible[u] || frees;
        if (d->eligible[u])
            bucket_put(d, u);
    }
}
