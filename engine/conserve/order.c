/* conserve/order.c - in which order bodies and joints are eliminated, and where their blocks lie.
 *
 * Least degree first (solve/degree.h). A joint with hard rows has no diagonal of its own; it may go once one of its bodies has gone.
 */
#include "conserve/system.h"
#include "solve/degree.h"

static int node_size(const System *s, int node)
{
    return node < s->g->moving_count ? 6 : s->tie[node - s->g->moving_count].rows;
}

static void graph(const System *s, Degree *o)
{
    int bodies = s->g->moving_count;
    for (int i = 0; i < s->tie_count; i++) {
        const Tie *t = &s->tie[i];
        bool a = s->piece[t->a].moves, b = s->piece[t->b].moves;
        if (a)
            degree_link(o, bodies + i, t->a);
        if (b)
            degree_link(o, bodies + i, t->b);
        if (a && b && t->coupled)
            degree_link(o, t->a, t->b);
    }
    for (int i = o->count - 1; i >= 0; i--)
        if (i < bodies || !s->tie[i - bodies].hard)
            degree_ready(o, i);
}

/* Lays down the blocks of one node and its later neighbours. */
static void record(System *s, Degree *o, int k, int node, Later **later)
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

static void eliminate_all(System *s, Degree *o, Later **later)
{
    for (int k = 0; k < o->count && !o->failed; k++) {
        int node = degree_next(o);
        record(s, o, k, node, later);
        degree_eliminate(o, node, node < s->g->moving_count);
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
    DIG_ASSERT(other < 0);                      /* a block outside the pattern: no node has such a number */
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
    s->exchange = arena_alloc(s->g->arena, (size_t)(s->node_count + 1) * sizeof *s->exchange);
    s->side = arena_alloc(s->g->arena, (size_t)(6 * s->node_count + 1) * sizeof *s->side);
    if (!s->later || !s->target || !s->blocks || !s->value || !s->exchange || !s->side)
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
    Degree o;
    size_t n = (size_t)s->node_count + 1;
    degree_open(&o, s->g->arena, s->node_count);
    s->order = arena_zero(s->g->arena, n * sizeof *s->order);
    s->position = arena_zero(s->g->arena, n * sizeof *s->position);
    Later **later = arena_zero(s->g->arena, n * sizeof *later);
    if (o.failed || !s->order || !s->position || !later)
        return DIG_E_MEMORY;
    s->value_count = 0;
    graph(s, &o);
    if (!o.failed)
        eliminate_all(s, &o, later);
    return o.failed ? DIG_E_MEMORY : lay_out(s, later);
}
