/* tests/bench/digs.c - what membership and messages cost: `make bench SCENE=digs`.
 *
 * 5000 DIGs of 50 bodies, each a chain with cross links as in a pile; in every frame one link in a hundred is replaced. Beside it,
 * on the same links, the simplest thing that works: union-find over all bodies anew in every frame, and a label for each.
 * Then merges and splits of DIGs of many sizes, a frame in which nothing changes, and messages.
 */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "digbox.h"
#include "world/graph.h"

enum { DIGS = 5000, SIZE = 50, NODES = DIGS * SIZE, FRAMES = 40, REPEATS = 5 };

static uint32_t noise(uint64_t *x)      /* MMIX constants of Knuth, upper half */
{
    *x = *x * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(*x >> 32);
}

/* us of CPU time */
static double now_us(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e6 + (double)t.tv_nsec * 1e-3;
}

static void need(bool good)
{
    if (good)
        return;
    fputs("bench: digs: out of memory\n", stderr);
    exit(1);
}

static Graph *graph_with(uint32_t nodes, uint32_t links)
{
    Graph *g = NULL;
    need(graph_open(&g) == DIG_OK && graph_reserve(g, (int)nodes, (int)links) == DIG_OK);
    for (uint32_t i = 0; i < nodes; i++)
        need(graph_node_add(g, i) == DIG_OK);
    return g;
}

static uint32_t join(Graph *g, uint32_t a, uint32_t b)
{
    uint32_t link;
    need(graph_link_add(g, a, b, false, 0, 0, 0, &link) == DIG_OK);
    return link;
}

static void row(const char *what, double measured, const char *unit, double target)
{
    printf("  %-58s %9.3f %-3s", what, measured, unit);
    if (target > 0)
        printf("  target %6.3f  %s", target, measured <= target ? "met" : "MISSED");
    printf("\n");
}

/* ---- a frame of a busy world ---- */

static Graph *piles(void)
{
    Graph *g = graph_with(NODES, 3 * NODES);
    graph_begin(g);
    for (uint32_t d = 0; d < DIGS; d++)
        for (uint32_t i = 0; i + 1 < SIZE; i++) {
            join(g, d * SIZE + i, d * SIZE + i + 1);
            if (i + 10 < SIZE)
                join(g, d * SIZE + i, d * SIZE + i + 10);
        }
    need(graph_end(g) == DIG_OK);
    return g;
}

/* Every second link that goes comes back, the others join two bodies of that DIG or, one in ten, of the next. */
static int change(Graph *g, uint32_t links, uint64_t *x)
{
    int changes = 0;
    uint32_t first = noise(x) % links;
    graph_begin(g);
    for (uint32_t i = 0; i < links / 100; i++) {
        uint32_t l = (first + i * 97) % links;          /* 97 * changes < links: each at most once */
        const GraphLink *old = graph_link(g, l);
        if (!old)
            continue;
        uint32_t a = old->a, b = old->b, base = a - a % SIZE;
        graph_link_remove(g, l);
        if (i % 2 == 0)
            join(g, a, b);
        else
            join(g, base + noise(x) % (SIZE - 1), (base + (i % 20 == 1 ? SIZE : 0) + SIZE - 1) % NODES);
        changes += 2;
    }
    need(graph_end(g) == DIG_OK);
    return changes;
}

static uint32_t root_of(uint32_t *parent, uint32_t i)
{
    while (parent[i] != i)
        i = parent[i] = parent[parent[i]];
    return i;
}

/* The yardstick: forget everything, unite along all links, label all bodies. Returns a sum so that nothing is left out. */
static uint32_t rebuild(const Graph *g, uint32_t links, uint32_t *parent, uint32_t *label)
{
    uint32_t sum = 0;
    for (uint32_t i = 0; i < NODES; i++)
        parent[i] = i;
    for (uint32_t l = 0; l < links; l++) {
        const GraphLink *k = graph_link(g, l);
        if (!k || k->bound)
            continue;
        uint32_t a = root_of(parent, k->a), b = root_of(parent, k->b);
        parent[a > b ? a : b] = a < b ? a : b;
    }
    for (uint32_t i = 0; i < NODES; i++)
        sum += label[i] = root_of(parent, i);
    return sum;
}

static void frames(void)
{
    Graph *g = piles();
    uint32_t links = DIGS * (2 * SIZE - 11), *parent = malloc(NODES * sizeof *parent), *label = malloc(NODES * sizeof *label);
    uint64_t x = 1;
    double sum = 0, worst = 0, flat = 0, idle = 0;
    volatile uint32_t kept = 0;
    need(parent && label);
    int changes = 0;
    for (int i = 0; i < FRAMES; i++) {
        double start = now_us();
        changes += change(g, links, &x);
        double us = now_us() - start;
        sum += us;
        worst = us > worst ? us : worst;
        start = now_us();
        kept += rebuild(g, links + links / 50, parent, label);
        flat += now_us() - start;
    }
    uint64_t visits = graph_visits(g);
    double start = now_us();
    for (int i = 0; i < 1000; i++) {
        graph_begin(g);
        need(graph_end(g) == DIG_OK);
    }
    idle = (now_us() - start) / 1000;
    printf("%d DIGs of %d bodies, %u links, %d changes a frame\n", DIGS, SIZE, links, changes / FRAMES);
    row("a frame with 1 % of the links changed, mean", sum / FRAMES * 1e-3, "ms", 8);
    row("the same, worst", worst * 1e-3, "ms", 15);
    row("a change", sum / changes, "us", 0);
    row("a flat union-find over all of it, per frame", flat / FRAMES * 1e-3, "ms", 0);
    row("ratio to that", sum / flat, "", 0);
    row("a frame in which nothing changes (all asleep)", idle, "us", 0.1);
    row("bodies and links looked at in it", (double)(graph_visits(g) - visits), "", 0);
    free(parent);
    free(label);
    graph_close(g);
}

/* ---- merges and splits ---- */

/* Chains of n bodies merged pair by pair until one is left, in random order: us per body that changed its DIG. */
static double merge_us(uint32_t n, uint32_t count)
{
    double best = 1e30;
    for (int r = 0; r < REPEATS; r++) {
        Graph *g = graph_with(n * count, n * count);
        uint64_t x = 5;
        for (uint32_t c = 0; c < count; c++)
            for (uint32_t i = 0; i + 1 < n; i++)
                join(g, c * n + i, c * n + i + 1);
        uint64_t moved = graph_visits(g);
        double start = now_us();
        for (uint32_t left = count; left > 1;) {
            uint32_t a = noise(&x) % (n * count), b = noise(&x) % (n * count);
            if (graph_of(g, a) == graph_of(g, b))
                continue;
            join(g, a, b);
            left--;
        }
        double us = (now_us() - start) / (double)(graph_visits(g) - moved);
        best = us < best ? us : best;
        graph_close(g);
    }
    return best;
}

/* us to cut a part with `edges` links off a larger one, which is in the cache or was not used for long */
static double split_us(uint32_t edges, bool cold)
{
    enum { CHAINS = 50, ROUNDS = 20 };
    uint32_t chain = cold ? 4000 : 2 * edges + 8, cut[CHAINS];
    Graph *g = graph_with(chain * CHAINS, chain * CHAINS);
    double us = 0;
    for (uint32_t c = 0; c < CHAINS; c++)
        for (uint32_t i = 0; i + 1 < chain; i++) {
            uint32_t l = join(g, c * chain + i, c * chain + i + 1);
            if (i == chain - 2 - edges)
                cut[c] = l;
        }
    int rounds = cold ? 1 : ROUNDS;
    for (int r = 0; r < rounds; r++) {
        double start = now_us();
        for (uint32_t c = 0; c < CHAINS; c++)
            graph_link_remove(g, cut[c]);
        us += now_us() - start;
        for (uint32_t c = 0; c < CHAINS; c++)
            cut[c] = join(g, c * chain + chain - 2 - edges, c * chain + chain - 1 - edges);
    }
    graph_close(g);
    return us / (rounds * CHAINS);
}

static void parts(void)
{
    char what[80];
    printf("merges and splits\n");
    for (uint32_t n = 1; n <= 1000; n *= 10) {
        snprintf(what, sizeof what, "merging DIGs of %u, per body moved", n);
        row(what, merge_us(n, n < 1000 ? 1000 : 100), "us", 0.3);
    }
    for (uint32_t edges = 1; edges <= 1000; edges *= 10) {
        snprintf(what, sizeof what, "splitting off %u links", edges);
        row(what, split_us(edges, false), "us", 1 + 0.06 * edges);
        snprintf(what, sizeof what, "splitting off %u links that nobody used for long", edges);
        row(what, split_us(edges, true), "us", 0);
    }
}

/* ---- messages ---- */

static double post_ns(dig_world *w, const dig_body *body, dig_route route, int count)
{
    dig_post p = dig_post_defaults();
    dig_receipt r;
    int reached = 0;
    p.route = route;
    p.kind[0] = 'm';
    p.layer = DIG_LAYER_RANGE;
    double us = 0;
    for (int i = 0; i < count; i += 50) {               /* a step between, which empties the list of events */
        double start = now_us();
        for (int k = i; k < i + 50; k++) {
            p.from = body[(k * SIZE) % (100 * SIZE)];
            need(dig_message_post(w, &p, &r) == DIG_OK);
            reached += r.reached;
        }
        us += now_us() - start;
        need(dig_world_step(w) == DIG_OK);
    }
    return us * 1e3 / reached;
}

static void messages(void)
{
    dig_world_def def = dig_world_defaults();
    dig_world *w;
    char why[256];
    static dig_body body[100 * SIZE];
    def.gravity = (vec3){0, 0, 0};
    need(dig_world_open(&def, &w, why, sizeof why) == DIG_OK);
    const dig_sphere_def sphere = {0.1};
    const dig_shape_def shape = {.type = "sphere", .data = &sphere, .colour = {-1, -1, -1}};
    for (int i = 0; i < 100 * SIZE; i++) {
        dig_body_def d = dig_body_defaults();
        d.at = (vec3){i % SIZE, i / SIZE, 0};
        d.shapes = &shape;
        d.shape_count = 1;
        d.fixed = true;                                 /* nothing to be advanced */
        need(dig_body_create(w, &d, &body[i]) == DIG_OK);
        dig_wire wire;
        const dig_wire_def link = {DIG_LAYER_RANGE, body[i], body[i > 0 ? i - 1 : 0], false, 0};
        if (i % SIZE)
            need(dig_wire_add(w, &link, &wire) == DIG_OK);
    }
    post_ns(w, body, DIG_ROUTE_DIG, 500);               /* what is reused has grown */
    printf("messages in DIGs of %d\n", SIZE);
    row("to all members, per delivery", post_ns(w, body, DIG_ROUTE_DIG, 5000), "ns", 60);
    row("as a flood along links, per delivery", post_ns(w, body, DIG_ROUTE_FLOOD, 5000), "ns", 65);
    dig_world_close(w);
}

int main(void)
{
    frames();
    parts();
    messages();
    return 0;
}
