/* solve/blocks_plan.c - in which order a block matrix is eliminated, and which blocks its factor has.
 *
 * Least degree first. Putting off what changes fills the factor in: it is done where it saves work all the same.
 */
#include "solve/blocks.h"
#include "solve/degree.h"

#define REPEATS 4               /* factorisations of a matrix from one beginning by which an order is judged; five to fifteen are usual */
#define PLAINLY 0.25            /* of what goes first: what is late costs so little that no other order is looked at */
#define MOSTLY   0.75           /* of all: where fewer are not late, these are not tried first */
#define WIDEST   16             /* columns of a panel: what is read of it again and again stays near */
#define HOPELESS 4.0            /* of what goes first: so much that it is not looked at any further */

typedef struct Pattern {
    int      *place;            /* [n] */
    Adjacent *later;            /* [n] by place: what the columns have below the diagonal, by number */
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

static void go(Pattern *p, Degree *d, const BlockLinks *of, int place)
{
    int node = degree_next(d), thin = 0;
    Adjacent *later = &p->later[place];
    p->place[node] = place;
    *later = d->next[node];
    for (int i = 0; i < later->count; i++)
        thin += is_narrow(of, later->node[i]);
    *(place < p->early ? &p->begin_work : &p->late_work) += work_of(is_narrow(of, node), later->count, thin);
    p->blocks += later->count;
    degree_eliminate(d, node, false);
}

/* The first `early` to go are those that are not late; 0: all go as they come. *fits: what is late does not cost many times the rest, else
 * p is of no use. False: out of memory. */
static bool eliminate(Pattern *p, Arena *arena, const BlockLinks *of, int early, bool *fits)
{
    Degree d;
    *p = (Pattern){.early = early};
    p->place = arena_alloc(arena, (size_t)of->n * sizeof *p->place);
    p->later = arena_alloc(arena, (size_t)of->n * sizeof *p->later);
    degree_open(&d, arena, of->n);
    degree_by_index(&d);
    if (!p->place || !p->later || d.failed)
        return false;
    for (int i = 0; i < of->links; i++)
        if (of->link[2 * i] != of->link[2 * i + 1])
            degree_link(&d, of->link[2 * i], of->link[2 * i + 1]);
    for (int i = 0; i < of->n && !d.failed; i++)
        if (early == 0 || !of->late[i])
            degree_ready(&d, i);
    *fits = true;
    for (int place = 0; place < of->n && !d.failed && *fits; place++) {
        for (int i = 0; i < of->n && place == early && early > 0; i++)
            if (of->late[i])
                degree_ready(&d, i);
        go(p, &d, of, place);
        *fits = early == 0 || p->late_work < HOPELESS * p->begin_work;
    }
    return !d.failed;
}

static int count_early(const BlockLinks *of)
{
    int count = 0;
    for (int i = 0; i < of->n && of->late; i++)
        count += !of->late[i];
    return of->late && count < of->n ? count : 0;
}

/* Ascending, by a bit for each place; returns how many. */
static int sorted_rows(int *row, const Adjacent *later, const int *place, uint64_t *bits, int n)
{
    int count = 0;
    for (int i = 0; i < later->count; i++)
        bits[place[later->node[i]] / 64] |= (uint64_t)1 << place[later->node[i]] % 64;
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
