/* solve/blocks_plan.c - in which order a block matrix is eliminated, and which blocks its factor has.
 *
 * Least degree first. Putting off what changes fills the factor in: it is done where it saves work all the same.
 */
#include "solve/blocks.h"

#define REPEATS 4               /* factorisations of a matrix from one beginning by which an order is judged; five to fifteen are usual */
#define PLAINLY 0.25            /* of what goes first: what is late costs so little that no other order is looked at */
#define MOSTLY   0.75           /* of all: where fewer are not late, these are not tried first */
#define WIDEST   16             /* columns of a panel: what is read of it again and again stays near */
#define HOPELESS 4.0            /* of what goes first: so much that it is not looked at any further */

/* ---- least degree first ---- */

/* As solve/degree.h, but ties go to the lowest number, so that the order is a function of the links alone whatever became ready when; and by a
 * bit for each node, for what is eliminated here has many neighbours. */
typedef struct Order {
    Arena    *arena;
    int       n, words, least;  /* least: no more than the degree of any that waits */
    uint64_t *linked;           /* [n][words]  the neighbours of each, and itself */
    uint64_t *waiting;          /* [n][words]  who may go, by degree */
    int      *degree;           /* [n] */
    bool     *ready;            /* [n] */
} Order;

typedef struct NodeList { int *node; int count; } NodeList;         /* ascending */

static uint64_t bit_of(int node) { return (uint64_t)1 << node % 64; }
static uint64_t *word_of(const Order *o, uint64_t *bits, int row, int node) { return bits + (size_t)row * (size_t)o->words + (size_t)(node / 64); }

static void link_nodes(Order *o, int x, int y)
{
    bool new = !(*word_of(o, o->linked, x, y) & bit_of(y));
    *word_of(o, o->linked, x, y) |= bit_of(y);
    *word_of(o, o->linked, y, x) |= bit_of(x);
    o->degree[x] += new;
    o->degree[y] += new;
}

static bool open_order(Order *o, Arena *arena, const BlockLinks *of)
{
    size_t n = (size_t)of->n, words = n / 64 + 1;
    *o = (Order){.arena = arena, .n = of->n, .words = (int)words};
    o->linked = arena_zero(arena, n * words * sizeof *o->linked);
    o->waiting = arena_zero(arena, n * words * sizeof *o->waiting);
    o->degree = arena_zero(arena, n * sizeof *o->degree);
    o->ready = arena_zero(arena, n * sizeof *o->ready);
    if (!o->linked || !o->waiting || !o->degree || !o->ready)
        return false;
    for (int i = 0; i < of->n; i++)
        *word_of(o, o->linked, i, i) |= bit_of(i);
    for (int i = 0; i < of->links; i++)
        link_nodes(o, of->link[2 * i], of->link[2 * i + 1]);
    return true;
}

static void put(Order *o, int node)
{
    *word_of(o, o->waiting, o->degree[node], node) |= bit_of(node);
    o->least = int_min(o->least, o->degree[node]);
    o->ready[node] = true;
}

static void take(Order *o, int node) { *word_of(o, o->waiting, o->degree[node], node) &= ~bit_of(node); }

/* The next to go, no longer waiting; some node must be. */
static int next_node(Order *o)
{
    const uint64_t *word = o->waiting + (size_t)o->least * (size_t)o->words;
    while (*word == 0)
        word++;
    o->least = (int)((word - o->waiting) / o->words);
    int node = (int)((word - o->waiting) % o->words) * 64 + __builtin_ctzll(*word);
    take(o, node);
    return node;
}

static bool list_links(const Order *o, int node, NodeList *list)
{
    *list = (NodeList){arena_alloc(o->arena, (size_t)(o->degree[node] + 1) * sizeof *list->node), 0};
    for (int w = 0; list->node && w < o->words; w++)
        for (uint64_t rest = o->linked[(size_t)node * (size_t)o->words + (size_t)w]; rest; rest &= rest - 1) {
            int other = 64 * w + __builtin_ctzll(rest);
            if (other != node)
                list->node[list->count++] = other;
        }
    return list->node;
}

/* What is linked to what goes is linked to all of that. */
static void join(Order *o, int node, int gone, const NodeList *list)
{
    uint64_t *restrict to = word_of(o, o->linked, node, 0);
    const uint64_t *restrict from = word_of(o, o->linked, gone, 0);
    for (int w = list->node[0] / 64; w <= list->node[list->count - 1] / 64; w++) {
        uint64_t new = from[w] & ~to[w];
        to[w] |= new;
        for (; new; new &= new - 1)
            o->degree[node]++;
    }
    to[gone / 64] &= ~bit_of(gone);
    o->degree[node]--;
}

static void remove_node(Order *o, int node, const NodeList *list)
{
    for (int i = 0; i < list->count; i++) {
        int other = list->node[i];
        if (o->ready[other])
            take(o, other);
        join(o, other, node, list);
        if (o->ready[other])
            put(o, other);
    }
}

/* ---- pattern ---- */

typedef struct Pattern {
    int      *place;            /* [n] */
    NodeList *later;          /* [n] by place: what the columns have below the diagonal, by number */
    int       early, blocks;
    real      begin_work, late_work;    /* multiplications */
} Pattern;

/* Multiplications of a column that many blocks long, of which that many are narrow. */
static real work_of(bool narrow, real blocks, real narrow_blocks)
{
    real all = 72 + 126 * blocks + 108 * blocks * (blocks + 1);
    real few = 72 + 18 * narrow_blocks + 13.5 * narrow_blocks * (narrow_blocks + 1), rest = blocks - narrow_blocks;
    return narrow ? few + 126 * rest + 108 * rest * (blocks + narrow_blocks + 1) : all;
}

static real mean_work(const Pattern *p) { return p->begin_work / REPEATS + p->late_work; }

static bool is_narrow(const BlockLinks *of, int i) { return of->narrow && of->narrow[i]; }

/* False: out of memory. */
static bool go(Pattern *p, Order *o, const BlockLinks *of, int place)
{
    int node = next_node(o), thin = 0;
    NodeList *later = &p->later[place];
    p->place[node] = place;
    if (!list_links(o, node, later))
        return false;
    for (int i = 0; i < later->count; i++)
        thin += is_narrow(of, later->node[i]);
    *(place < p->early ? &p->begin_work : &p->late_work) += work_of(is_narrow(of, node), later->count, thin);
    p->blocks += later->count;
    remove_node(o, node, later);
    return true;
}

/* The first `early` to go are those that are not late; 0: all go as they come. *fits: what is late does not cost many times the rest, else
 * p is of no use. False: out of memory. */
static bool eliminate(Pattern *p, Arena *arena, const BlockLinks *of, int early, bool *fits)
{
    Order o;
    *p = (Pattern){.early = early};
    p->place = arena_alloc(arena, (size_t)of->n * sizeof *p->place);
    p->later = arena_alloc(arena, (size_t)of->n * sizeof *p->later);
    if (!p->place || !p->later || !open_order(&o, arena, of))
        return false;
    for (int i = 0; i < of->n; i++)
        if (early == 0 || !of->late[i])
            put(&o, i);
    *fits = true;
    for (int place = 0; place < of->n && *fits; place++) {
        for (int i = 0; i < of->n && place == early && early > 0; i++)
            if (of->late[i])
                put(&o, i);
        if (!go(p, &o, of, place))
            return false;
        *fits = early == 0 || p->late_work < HOPELESS * p->begin_work;
    }
    return true;
}

static int count_early(const BlockLinks *of)
{
    int count = 0;
    for (int i = 0; i < of->n && of->late; i++)
        count += !of->late[i];
    return of->late && count < of->n ? count : 0;
}

/* Ascending, by a bit for each place; returns how many. */
static int sorted_rows(int *row, const NodeList *later, const int *place, uint64_t *bits, int n)
{
    int count = 0;
    for (int i = 0; i < later->count; i++)
        bits[place[later->node[i]] / 64] |= bit_of(place[later->node[i]]);
    for (int w = 0; w <= n / 64; w++)
        for (; bits[w]; bits[w] &= bits[w] - 1)
            row[count++] = 64 * w + __builtin_ctzll(bits[w]);
    return count;
}

/* Narrow columns that follow one another and have the same rows below all of them. They may be wide where nothing is late in between. */
static int panel_width(const Blocks *s, int j)
{
    int e = j + 1;
    while (s->narrow[j] && e < s->n && e - j < WIDEST && e != s->early && s->narrow[e] && s->first[e] > s->first[e - 1]
           && s->row[s->first[e - 1]] == e && s->first[e + 1] - s->first[e] == s->first[e] - s->first[e - 1] - 1)
        e++;
    return e - j;
}

/* A panel's blocks row by row, from `at` on; returns where they end. */
static int lay_out(Blocks *s, int j, int at)
{
    const int width = s->width[j], rows = s->first[j + 1] - s->first[j];
    for (int i = 1; i <= rows; i++) {
        int wide = !s->narrow[s->row[s->first[j] + i - 1]], size = s->narrow[j] ? SMALL << wide : BLOCK;
        for (int m = 0; m < width && m < i; m++, at += size)
            s->at[s->first[j + m] + i - m - 1] = at;
    }
    return at;
}

static void write_pattern(Blocks *s, const Pattern *p, const BlockLinks *of, uint64_t *bits)
{
    int blocks = 0, at = 0;
    for (int i = 0; i < s->n; i++)
        s->narrow[p->place[i]] = is_narrow(of, i);
    for (int j = 0; j < s->n; j++) {
        s->first[j] = blocks;
        blocks += sorted_rows(s->row + blocks, &p->later[j], p->place, bits, s->n);
    }
    s->first[s->n] = blocks;
    for (int j = 0; j < s->n; j += s->width[j]) {
        s->width[j] = panel_width(s, j);
        at = lay_out(s, j, at);
    }
    s->at[blocks] = at;
}

/* The late ones last where that is plainly less, or less than what all as they come take. */
static bool choose(Pattern *p, Arena *arena, const BlockLinks *of)
{
    Pattern split;
    int early = count_early(of);
    bool fits = false;
    if (early > MOSTLY * of->n && !eliminate(&split, arena, of, early, &fits))
        return false;
    if (!fits || split.late_work > PLAINLY * split.begin_work) {
        bool always;
        if (!eliminate(p, arena, of, 0, &always))
            return false;
        fits = fits && mean_work(&split) < mean_work(p);
    }
    if (fits)
        *p = split;
    return true;
}

/* The rows below all of a panel: those of its last column. */
static int last_column(const Blocks *s, int j) { return j + s->width[j] - 1; }

/* Its rows from p on are rows of column row[q], too, with others between; no others from where as many are left of both. */
static void find_targets(Blocks *s)
{
    int *to = s->target;
    for (int j = 0; j < s->n; j += s->width[j]) {
        int last = last_column(s, j), end = s->first[last + 1];
        s->pair[j] = (int)(to - s->target);
        for (int q = s->first[last]; q < end; q++) {
            const int k_end = s->first[s->row[q] + 1];
            int p = q + 1, k = s->first[s->row[q]];
            for (; p < end && end - p < k_end - k; p++) {
                while (s->row[k] < s->row[p])
                    k++;
                *to++ = s->at[k++];
            }
            for (; p < end; p++)
                *to++ = s->at[k++];
        }
    }
}

/* What the factorisation needs besides: false: out of memory. */
static bool plan_work(Blocks *s, Arena *arena)
{
    size_t pairs = 0, most = 0;
    for (int j = 0; j < s->n; j += s->width[j]) {
        int last = last_column(s, j);
        size_t outside = (size_t)(s->first[last + 1] - s->first[last]), width = (size_t)s->width[j];
        size_t size = s->narrow[j] ? SMALL * width * (width + 2 * outside) : SPREAD * outside;
        pairs += outside * (outside + 1) / 2;
        most = size > most ? size : most;
    }
    s->target = arena_alloc(arena, (pairs + 1) * sizeof *s->target);
    s->spread = arena_alloc(arena, (most + 1) * sizeof *s->spread);
    if (!s->target || !s->spread)
        return false;
    find_targets(s);
    return true;
}

bool blocks_plan(Blocks *s, Arena *arena, const BlockLinks *of)
{
    Pattern p;
    if (!choose(&p, arena, of))
        return false;
    size_t n = (size_t)of->n;
    *s = (Blocks){.n = of->n, .early = p.early, .place = p.place,
                  .begin_work = p.begin_work, .late_work = p.late_work, .work = mean_work(&p)};
    if (of->most > 0 && s->work > of->most)
        return true;
    s->narrow = arena_alloc(arena, n * sizeof *s->narrow);
    s->first = arena_alloc(arena, (n + 1) * sizeof *s->first);
    s->row = arena_alloc(arena, (size_t)(p.blocks + 1) * sizeof *s->row);
    s->at = arena_alloc(arena, (size_t)(p.blocks + 1) * sizeof *s->at);
    s->pair = arena_alloc(arena, n * sizeof *s->pair);
    s->width = arena_alloc(arena, n * sizeof *s->width);
    uint64_t *bits = arena_zero(arena, (n / 64 + 1) * sizeof *bits);
    if (!s->narrow || !s->first || !s->row || !s->at || !s->pair || !s->width || !bits)
        return false;
    write_pattern(s, &p, of, bits);
    return plan_work(s, arena);
}
