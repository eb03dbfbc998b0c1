/* conserve/order.c - in which order bodies and joints are eliminated, and where their blocks lie.
 *
 * Least degree first (Tinney & Walker 1967), with buckets and last-in first-out ties: on trees there is no fill and the work is
 * linear. A joint with hard rows has no diagonal of its own; it may go once one of its bodies has gone.
 */
#include "conserve/system.h"

typedef struct Adjacent { int *node; int count, room; } Adjacent;

typedef struct Ordering {
    Arena    *arena;
    Adjacent *next;             /* neighbours not yet eliminated */
    int      *head, *after, *before;    /* buckets by degree     */
    bool     *eligible, *gone;
    int       count;
    bool      failed;
} Ordering;

static bool adjacent(const Adjacent *a, int node)
{
    for (int i = 0; i < a->count; i++)
        if (a->node[i] == node)
            return true;
    return false;
}

static void add_one(Ordering *o, int from, int to)
{
    Adjacent *a = &o->next[from];
    if (a->count == a->room) {
        int room = 2 * a->room + 4;
        int *node = arena_alloc(o->arena, (size_t)room * sizeof *node);
        if (!node) {
            o->failed = true;
            return;
        }
        if (a->count > 0)
            memcpy(node, a->node, (size_t)a->count * sizeof *node);
        a->node = node;
        a->room = room;
    }
    a->node[a->count++] = to;
}

static void connect(Ordering *o, int x, int y)
{
    if (adjacent(&o->next[x], y))
        return;
    add_one(o, x, y);
    add_one(o, y, x);
}

static void disconnect(Adjacent *a, int node)
{
    int n = 0;
    for (int i = 0; i < a->count; i++)
        if (a->node[i] != node)
            a->node[n++] = a->node[i];
    a->count = n;
}

static void bucket_take(Ordering *o, int node, int degree)
{
    if (o->before[node] >= 0)
        o->after[o->before[node]] = o->after[node];
    else
        o->head[degree] = o->after[node];
    if (o->after[node] >= 0)
        o->before[o->after[node]] = o->before[node];
}

static void bucket_put(Ordering *o, int node)
{
    int degree = o->next[node].count;
    o->after[node] = o->head[degree];
    o->before[node] = -1;
    if (o->head[degree] >= 0)
        o->before[o->head[degree]] = node;
    o->head[degree] = node;
}

static void *taken(Ordering *o, size_t bytes)
{
    void *p = arena_zero(o->arena, bytes);
    o->failed = o->failed || !p;
    return p;
}

static int node_size(const System *s, int node)
{
    return node < s->g->moving_count ? 6 : s->tie[node - s->g->moving_count].rows;
}

static void graph(const System *s, Ordering *o)
{
    for (int i = 0; i < s->tie_count && !o->failed; i++) {
        const Tie *t = &s->tie[i];
        int node = s->g->moving_count + i;
        bool a = s->piece[t->a].moves, b = s->piece[t->b].moves;
        if (a)
            connect(o, node, t->a);
        if (b)
            connect(o, node, t->b);
        if (a && b && t->coupled)
            connect(o, t->a, t->b);
        o->eligible[node] = !t->hard;
    }
    for (int i = 0; i < s->g->moving_count; i++)
        o->eligible[i] = true;
    for (int i = o->count - 1; i >= 0; i--)
        if (o->eligible[i])
            bucket_put(o, i);
}

/* Lays down the blocks of one node and its later neighbours. */
static void record(System *s, Ordering *o, int k, int node, Later **later)
{
    const Adjacent *a = &o->next[node];
    Elimination *e = &s->order[k];
    *e = (Elimination){.node = node, .size = node_size(s, node), .count = a->count};
    Later *list = arena_alloc(o->arena, (size_t)(a->count + 1) * sizeof *list);
    if (!list) {
        o->failed = true;
        return;
    }
    for (int i = 0; i < a->count; i++) {
        list[i] = (Later){a->node[i], node_size(s, a->node[i]), e->width};
        e->width += list[i].size;
    }
    later[k] = list;
    s->position[node] = k;
    e->diagonal = s->value_count;
    e->lower = e->diagonal + e->size * e->size;
    e->upper = e->lower + e->size * e->width;
    s->value_count = e->upper + e->size * e->width;
}

static void eliminate(System *s, Ordering *o, int node)
{
    const Adjacent gone = o->next[node];
    for (int i = 0; i < gone.count; i++)
        if (o->eligible[gone.node[i]])
            bucket_take(o, gone.node[i], o->next[gone.node[i]].count);
    for (int i = 0; i < gone.count; i++)
        disconnect(&o->next[gone.node[i]], node);
    for (int i = 0; i < gone.count && !o->failed; i++)
        for (int k = i + 1; k < gone.count && !o->failed; k++)
            connect(o, gone.node[i], gone.node[k]);
    for (int i = 0; i < gone.count; i++) {
        int u = gone.node[i];
        o->eligible[u] = o->eligible[u] || node < s->g->moving_count;
        if (o->eligible[u])
            bucket_put(o, u);
    }
    o->gone[node] = true;
}

static void eliminate_all(System *s, Ordering *o, Later **later)
{
    int least = 0;
    for (int k = 0; k < o->count && !o->failed; k++) {
        while (o->head[least] < 0)
            least++;
        int node = o->head[least];
        bucket_take(o, node, least);
        record(s, o, k, node, later);
        eliminate(s, o, node);
        least = 0;
    }
}

/* Where the block of row node r and column node c lies. */
static Block find(const System *s, int r, int c)
{
    int pr = s->position[r], pc = s->position[c];
    const Elimination *e = &s->order[int_min(pr, pc)];
    if (r == c)
        return (Block){e->diagonal, e->size};
    int other = pr < pc ? c : r;
    for (int i = 0; i < e->count; i++) {
        const Later *l = &s->later[e->first + i];
        if (l->node == other)
            return pr < pc ? (Block){e->upper + l->column, e->width} : (Block){e->lower + l->column * e->size, e->size};
    }
    DIG_ASSERT(!"a block of the pattern");
    return (Block){0, 0};
}

Block order_diagonal(const System *s, int node) { return find(s, node, node); }

static dig_status lay_out(System *s, Later **later)
{
    int links = 0, pairs = 0;
    for (int k = 0; k < s->node_count; k++) {
        s->order[k].first = links;
        s->order[k].pair = pairs;
        links += s->order[k].count;
        pairs += s->order[k].count * s->order[k].count;
    }
    s->later = arena_alloc(s->g->arena, (size_t)(links + 1) * sizeof *s->later);
    s->target = arena_alloc(s->g->arena, (size_t)(pairs + 1) * sizeof *s->target);
    s->blocks = arena_zero(s->g->arena, (size_t)(s->tie_count + 1) * sizeof *s->blocks);
    s->value = arena_alloc(s->g->arena, (size_t)(s->value_count + 1) * sizeof *s->value);
    s->side = arena_alloc(s->g->arena, (size_t)(6 * s->node_count + 1) * sizeof *s->side);
    if (!s->later || !s->target || !s->blocks || !s->value || !s->side)
        return DIG_E_MEMORY;
    for (int k = 0; k < s->node_count; k++)
        memcpy(s->later + s->order[k].first, later[k], (size_t)s->order[k].count * sizeof *s->later);
    for (int k = 0; k < s->node_count; k++) {
        const Elimination *e = &s->order[k];
        for (int i = 0; i < e->count; i++)
            for (int j = 0; j < e->count; j++)
                s->target[e->pair + i * e->count + j] = find(s, s->later[e->first + i].node, s->later[e->first + j].node);
    }
    for (int i = 0; i < s->tie_count; i++) {
        const Tie *t = &s->tie[i];
        TieBlocks *b = &s->blocks[i];
        for (int k = 0; k < 2; k++) {
            int body = k ? t->b : t->a, node = s->g->moving_count + i;
            if (!s->piece[body].moves)
                continue;
            b->ja[k] = find(s, node, body);
            b->aj[k] = find(s, body, node);
        }
        if (t->coupled && s->piece[t->a].moves && s->piece[t->b].moves) {
            b->ab = find(s, t->a, t->b);
            b->ba = find(s, t->b, t->a);
        }
    }
    return DIG_OK;
}

dig_status order_make(System *s)
{
    Ordering o = {.arena = s->g->arena, .count = s->node_count};
    size_t n = (size_t)s->node_count + 1;
    o.next = taken(&o, n * sizeof *o.next);
    o.head = taken(&o, n * sizeof *o.head);
    o.after = taken(&o, n * sizeof *o.after);
    o.before = taken(&o, n * sizeof *o.before);
    o.eligible = taken(&o, n * sizeof *o.eligible);
    o.gone = taken(&o, n * sizeof *o.gone);
    s->order = taken(&o, n * sizeof *s->order);
    s->position = taken(&o, n * sizeof *s->position);
    Later **later = taken(&o, n * sizeof *later);
    if (o.failed)
        return DIG_E_MEMORY;
    for (int i = 0; i <= s->node_count; i++)
        o.head[i] = -1;
    graph(s, &o);
    s->value_count = 0;
    if (!o.failed)
        eliminate_all(s, &o, later);
    return o.failed ? DIG_E_MEMORY : lay_out(s, later);
}
