/* test_graph_cost.c - what merges and splits cost, counted in links and nodes looked at.
 *
 * With the argument "cost" (or DIG_COST in the environment) it prints how long they take instead.
 */
#include "graph_fixture.h"

#include <stdlib.h>
#include <time.h>

/* ---- cost ---- */

TEST(cutting_one_off_a_chain_of_20000_looks_at_few_links)
{
    enum { N = 20000 };
    Graph *g = graph_with(N);
    uint32_t last = 0, before_last = 0;
    for (uint32_t i = 0; i + 1 < N; i++) {
        before_last = last;
        last = join(g, i, i + 1);
    }
    uint64_t before = graph_visits(g);
    graph_link_remove(g, last);
    CHECK(graph_visits(g) - before <= 6);
    before = graph_visits(g);
    graph_link_remove(g, before_last);
    CHECK(graph_visits(g) - before <= 6);
    before = graph_visits(g);
    graph_link_remove(g, 99);           /* a hundred nodes at the other end: 100 nodes with two link ends each, from both sides,
                                         * and 100 moved */
    CHECK(graph_visits(g) - before <= 2 * (100 + 200) + 100 + 10);
    CHECK_INT(graph_count(g), 4);
    graph_close(g);
}

/* Each time a node is relabelled its DIG has at least doubled, so it happens log2(n) times at most. */
TEST(merging_in_any_order_relabels_each_node_at_most_log2_n_times)
{
    enum { N = 4096 };
    for (uint64_t seed = 1; seed <= 3; seed++) {
        Graph *g = graph_with(N);
        uint64_t x = seed;
        while (graph_count(g) > 1) {
            uint32_t a = noise(&x) % N, b = noise(&x) % N;
            if (graph_of(g, a) != graph_of(g, b))
                join(g, a, b);
        }
        CHECK(graph_visits(g) <= N * 12);
        CHECK(graph_visits(g) >= N - 1);
        graph_close(g);
    }
}

/* ---- how long it takes, on demand ---- */

static double now_us(void)
{
    struct timespec t;
    timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec * 1e6 + (double)t.tv_nsec * 1e-3;
}

static Graph *piles(uint32_t digs, uint32_t size, double *merge_us)
{
    Graph *g = graph_with(digs * size);
    CHECK_INT(graph_reserve(g, (int)(digs * size), (int)(digs * size * 3)), DIG_OK);
    double start = now_us();
    graph_begin(g);
    for (uint32_t d = 0; d < digs; d++)
        for (uint32_t i = 0; i + 1 < size; i++) {
            join(g, d * size + i, d * size + i + 1);
            if (i + 10 < size)
                join(g, d * size + i, d * size + i + 10);
        }
    CHECK_INT(graph_end(g), DIG_OK);
    *merge_us = now_us() - start;
    return g;
}

/* One link in a hundred is replaced by another in the same DIG, as in a frame of a busy world. */
static double frame_us(Graph *g, uint32_t links, uint32_t changes, uint64_t *x)
{
    double start = now_us();
    uint32_t first = noise(x) % links;
    graph_begin(g);
    for (uint32_t i = 0; i < changes; i++) {
        uint32_t l = (first + i * 97) % links;          /* 97 * changes < links: each at most once */
        const GraphLink *old = graph_link(g, l);
        if (!old)
            continue;
        uint32_t a = old->a, b = old->b;
        graph_link_remove(g, l);
        if (i % 2)
            join(g, a, b);
    }
    CHECK_INT(graph_end(g), DIG_OK);
    return now_us() - start;
}

static int print_costs(void)
{
    const uint32_t cases[][2] = {{100, 10}, {1000, 50}, {5000, 10}, {5000, 50}, {5000, 100}};
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        uint32_t digs = cases[c][0], size = cases[c][1];
        uint64_t x = 1;
        double merge, worst = 0, sum = 0;
        Graph *g = piles(digs, size, &merge);
        uint32_t links = digs * (2 * size - 11);
        const GraphChange *changes;
        int merged = graph_changes(g, &changes);
        enum { FRAMES = 20 };
        for (int i = 0; i < FRAMES; i++) {
            double us = frame_us(g, links, links / 100, &x);
            sum += us;
            worst = us > worst ? us : worst;
        }
        Graph *copy = NULL;
        CHECK_INT(graph_copy(&copy, g), DIG_OK);
        double start = now_us();
        CHECK_INT(graph_copy(&copy, g), DIG_OK);
        double copied = now_us() - start;
        printf("%5u DIGs x %3u: build %.3f us per link, %.3f us per node merged; frame with 1%% of %u links: mean %.0f us, "
               "worst %.0f us, %.2f us per change; copy %.0f us, %.1f MB\n", digs, size, merge / links, merge / merged, links,
               sum / FRAMES, worst, sum / FRAMES / (links / 100 * 1.5), copied, (double)graph_bytes(g) * 1e-6);
        graph_close(copy);
        graph_close(g);
    }
    for (uint32_t n = 100; n <= 100000; n *= 10) {      /* two halves of n nodes, cut apart and joined */
        Graph *g = graph_with(n);
        for (uint32_t i = 0; i + 1 < n; i++)
            join(g, i, i + 1);
        double cut = now_us();
        graph_link_remove(g, n / 2);
        double merge = now_us();
        join(g, n / 2, n / 2 + 1);
        double end = now_us(), leave = now_us();
        for (int i = 0; i < 1000; i++)
            graph_link_remove(g, graph_link_first(g, n - 1)), join(g, n - 2, n - 1);
        leave = (now_us() - leave) / 1000;
        printf("chain of %6u: cut in the middle %.1f us (%.4f per node moved), merge %.1f us (%.4f per node moved), "
               "one node off and on %.3f us\n", n, merge - cut, (merge - cut) / (n / 2), end - merge, (end - merge) / (n / 2), leave);
        graph_close(g);
    }
    return 0;
}

int main(int count, char **argument)
{
    if ((count > 1 && strcmp(argument[1], "cost") == 0) || getenv("DIG_COST"))
        return print_costs();
    RUN_TESTS(
        unit_test(cutting_one_off_a_chain_of_20000_looks_at_few_links),
        unit_test(merging_in_any_order_relabels_each_node_at_most_log2_n_times)
    );
}
