/* test_graph_random.c - DIGs against a model that recomputes everything by brute force: the properties P1 (labels are components),
 * P2 (the floor is in no DIG), P3 (each node in one DIG), P5 (changes rebuild the labels), P6 (order permutes ids only), P8 (add and
 * delete is the identity), P10 (stacks).
 */
#include "graph_fixture.h"

#include <stdlib.h>

enum { MODEL_NODES = 300, MODEL_LINKS = 4096 };

/* ---- the model ---- */

typedef struct Model {                  /* of MODEL_NODES nodes, all there from the start */
    struct { uint32_t a, b, handle; bool bound; } link[MODEL_LINKS];
    int      links;
    uint32_t part[MODEL_NODES];         /* lowest node of the component now         */
    uint32_t before[MODEL_NODES];       /* the same before the batch                */
    uint32_t id[MODEL_NODES];           /* id of the node's DIG, by the model's own rules */
    uint32_t next_id;
    GraphChange change[2 * MODEL_NODES];
    int      changes;
} Model;

static void model_parts(Model *m)
{
    uint32_t parent[MODEL_NODES];
    for (uint32_t i = 0; i < MODEL_NODES; i++)
        parent[i] = i;
    for (int k = 0; k < m->links; k++) {
        uint32_t a = m->link[k].a, b = m->link[k].b;
        if (m->link[k].bound)
            continue;
        while (parent[a] != a)
            a = parent[a];
        while (parent[b] != b)
            b = parent[b];
        parent[a > b ? a : b] = a < b ? a : b;
    }
    for (uint32_t i = 0; i < MODEL_NODES; i++)          /* parents are lower, so they are done */
        m->part[i] = parent[i] == i ? i : m->part[parent[i]];
}

/* Blocks: the finest partition coarser than `before` and `part`, as lowest nodes. */
static void model_blocks(const Model *m, uint32_t *block)
{
    for (uint32_t i = 0; i < MODEL_NODES; i++)
        block[i] = i;
    for (bool changed = true; changed;) {
        changed = false;
        for (uint32_t i = 0; i < MODEL_NODES; i++) {
            uint32_t of[3] = {i, m->before[i], m->part[i]}, low = i;
            for (int k = 0; k < 3; k++)
                low = block[of[k]] < low ? block[of[k]] : low;
            for (int k = 0; k < 3; k++) {
                changed |= block[of[k]] != low;
                block[of[k]] = low;
            }
        }
    }
}

static int by_kind_and_other(const void *x, const void *y)
{
    const GraphChange *a = x, *b = y;
    if (a->kind != b->kind)
        return a->kind < b->kind ? -1 : 1;
    return a->other < b->other ? -1 : a->other > b->other;
}

/* The rule of graph.h, word by word, for one block. New ids are taken from the graph: their order is its own affair. */
static void model_block(Model *m, const uint32_t *block, uint32_t root, const Graph *g, uint32_t *id)
{
    int size[MODEL_NODES] = {0}, overlap[MODEL_NODES] = {0};
    uint32_t kept = MODEL_NODES, winner = MODEL_NODES;
    for (uint32_t i = 0; i < MODEL_NODES; i++)
        size[m->before[i]] += block[i] == root;
    for (uint32_t i = 0; i < MODEL_NODES; i++)          /* largest before, tie: lowest id */
        if (size[i] && (kept == MODEL_NODES || size[i] > size[kept] || (size[i] == size[kept] && m->id[i] < m->id[kept])))
            kept = i;
    for (uint32_t i = 0; i < MODEL_NODES; i++)
        overlap[m->part[i]] += m->before[i] == kept;
    for (uint32_t i = 0; i < MODEL_NODES; i++)          /* most old members, tie: lowest slot */
        if (overlap[i] && (winner == MODEL_NODES || overlap[i] > overlap[winner]))
            winner = i;
    for (uint32_t i = 0; i < MODEL_NODES; i++) {
        if (block[i] != root)
            continue;
        if (m->before[i] == i && i != kept)
            m->change[m->changes++] = (GraphChange){GRAPH_MERGED, m->id[kept], m->id[i]};
        if (m->part[i] == i && i != winner)
            m->change[m->changes++] = (GraphChange){GRAPH_SPLIT, m->id[kept], graph_of(g, i)};
        id[i] = m->part[i] == winner ? m->id[kept] : graph_of(g, m->part[i]);
    }
}

static void model_end(Model *m, const Graph *g)
{
    uint32_t block[MODEL_NODES], id[MODEL_NODES];
    bool changed[MODEL_NODES] = {false};
    memcpy(m->before, m->part, sizeof m->before);
    memcpy(id, m->id, sizeof id);
    model_parts(m);
    model_blocks(m, block);
    for (uint32_t i = 0; i < MODEL_NODES; i++)
        changed[block[i]] |= m->before[i] != m->part[i];
    m->changes = 0;
    for (uint32_t i = 0; i < MODEL_NODES; i++)
        if (changed[i])
            model_block(m, block, i, g, id);
    qsort(m->change, (size_t)m->changes, sizeof m->change[0], by_kind_and_other);
    memcpy(m->id, id, sizeof m->id);
}

/* P1 labels = components, P3 each node in one DIG, and the changes reported are those of the rule. */
static void model_compare(Model *m, const Graph *g)
{
    int sum = 0;
    uint32_t new_ids = m->next_id;
    check_changes(g, m->change, m->changes);
    for (int i = 0; i < m->changes; i++) {
        if (m->change[i].kind == GRAPH_SPLIT)           /* counting up from the last one, never reused */
            CHECK_INT(m->change[i].other, new_ids++);
    }
    m->next_id = new_ids;
    for (uint32_t i = 0; i < MODEL_NODES; i++)
        CHECK_INT(graph_of(g, i), m->id[i]);
    for (int i = 0; i < graph_count(g); i++) {
        uint32_t id = graph_by_index(g, i);
        int size = 0;
        for (uint32_t node = graph_first(g, id); node != GRAPH_END; node = graph_next(g, node), size++)
            CHECK_INT(graph_of(g, node), id);
        CHECK_INT(graph_size(g, id), size);
        sum += size;
    }
    CHECK_INT(sum, MODEL_NODES);
}

/* P5: labels kept by someone who hears of changes only. */
static void replay(const Graph *g, uint32_t *label, uint32_t nodes)
{
    const GraphChange *c;
    int count = graph_changes(g, &c);
    for (int i = 0; i < count; i++) {
        if (c[i].kind == GRAPH_MERGED) {
            for (uint32_t k = 0; k < nodes; k++)
                label[k] = label[k] == c[i].other ? c[i].kept : label[k];
        } else {
            for (uint32_t k = graph_first(g, c[i].other); k != GRAPH_END; k = graph_next(g, k)) {
                CHECK_INT(label[k], c[i].kept);
                label[k] = c[i].other;
            }
        }
    }
    for (uint32_t k = 0; k < nodes; k++)
        CHECK_INT(label[k], graph_of(g, k));
}

static void random_change(Model *m, Graph *g, uint64_t *seed, int target)
{
    bool add = m->links == 0 || (m->links < MODEL_LINKS && (int)(noise(seed) % (unsigned)(2 * target)) >= m->links);
    if (add) {
        uint32_t a = noise(seed) % MODEL_NODES, b = (a + 1 + noise(seed) % (MODEL_NODES - 1)) % MODEL_NODES;
        bool bound = noise(seed) % 8 == 0;
        m->link[m->links].a = a;
        m->link[m->links].b = b;
        m->link[m->links].bound = bound;
        m->link[m->links++].handle = bound ? rest_on_floor(g, a) : join(g, a, b);
    } else {
        int k = (int)(noise(seed) % (unsigned)m->links);
        graph_link_remove(g, m->link[k].handle);
        m->link[k] = m->link[--m->links];
    }
}

static void random_run(uint64_t seed, int total, int batch, int target)
{
    Model *m = calloc(1, sizeof *m);
    uint32_t label[MODEL_NODES];
    Graph *g = graph_with(MODEL_NODES);
    model_parts(m);
    for (uint32_t i = 0; i < MODEL_NODES; i++)
        label[i] = m->id[i] = i + 1;
    m->next_id = MODEL_NODES + 1;
    for (int done = 0, round = 0; done < total; round++) {
        int size = batch == 1 ? 1 : 1 + (int)(noise(&seed) % (unsigned)batch);
        if (batch > 1)
            graph_begin(g);
        for (int i = 0; i < size; i++)
            random_change(m, g, &seed, target);
        if (batch > 1)
            CHECK_INT(graph_end(g), DIG_OK);
        done += size;
        model_end(m, g);
        model_compare(m, g);
        replay(g, label, MODEL_NODES);
        if (round % 16 == 0)
            CHECK(graph_check(g));
    }
    CHECK_INT(graph_of(g, FLOOR), GRAPH_NONE);          /* P2: the floor is in no DIG */
    graph_close(g);
    free(m);
}

TEST(sixty_thousand_random_single_changes_agree_with_brute_force)
{
    random_run(1, 30000, 1, 150);       /* sparse: trees and pieces */
    random_run(2, 30000, 1, 300);       /* near the giant component */
}

TEST(random_batches_report_the_net_change_of_the_rule)
{
    for (uint64_t seed = 10; seed < 16; seed++) {
        random_run(seed, 8000, 6, 150);
        random_run(seed, 8000, 40, 200);
    }
}

/* ---- properties ---- */

/* P10: the thesis' program lost the third sphere of a stack. */
TEST(stacks_are_one_dig_in_whatever_order_they_are_found)
{
    const uint32_t heights[] = {3, 4, 10, 100};
    for (size_t h = 0; h < sizeof heights / sizeof heights[0]; h++) {
        for (int order = 0; order < 4; order++) {
            uint32_t n = heights[h], skip = order == 2 ? 7 : 1;         /* 7 has no factor in common with n - 1 */
            Graph *g = graph_with(n);
            if (order == 3)
                graph_begin(g);
            rest_on_floor(g, 0);
            for (uint32_t i = 0; i < n - 1; i++) {
                uint32_t k = order == 1 ? n - 2 - i : i * skip % (n - 1);
                join(g, k, k + 1);
            }
            if (order == 3)
                CHECK_INT(graph_end(g), DIG_OK);
            CHECK_INT(graph_count(g), 1);
            CHECK_INT(graph_size(g, graph_of(g, n - 1)), n);
            CHECK_INT(graph_of(g, 0), graph_of(g, n - 1));
            CHECK(graph_check(g));
            graph_close(g);
        }
    }
}

/* P6: the order of creation decides about ids, never about who belongs together. */
TEST(permuting_the_order_of_creation_permutes_ids_only)
{
    enum { N = 100, L = 90 };
    for (uint64_t seed = 1; seed <= 20; seed++) {
        uint64_t x = seed;
        uint32_t end[L][2], order[N], link_order[L];
        for (uint32_t i = 0; i < N; i++)
            order[i] = i;
        for (uint32_t i = 0; i < L; i++) {
            link_order[i] = i;
            end[i][0] = noise(&x) % N;
            end[i][1] = (end[i][0] + 1 + noise(&x) % (N - 1)) % N;
        }
        for (uint32_t i = N - 1; i > 0; i--) {
            uint32_t k = noise(&x) % (i + 1), t = order[i];
            order[i] = order[k];
            order[k] = t;
        }
        for (uint32_t i = L - 1; i > 0; i--) {
            uint32_t k = noise(&x) % (i + 1), t = link_order[i];
            link_order[i] = link_order[k];
            link_order[k] = t;
        }
        Graph *one = graph_with(N), *two = NULL;
        CHECK_INT(graph_open(&two), DIG_OK);
        for (uint32_t i = 0; i < N; i++)
            CHECK_INT(graph_node_add(two, order[i]), DIG_OK);
        for (uint32_t i = 0; i < L; i++) {
            join(one, end[i][0], end[i][1]);
            join(two, end[link_order[i]][1], end[link_order[i]][0]);
        }
        CHECK_INT(graph_count(one), graph_count(two));
        for (uint32_t i = 0; i < N; i++)
            for (uint32_t k = 0; k < i; k++)
                CHECK_INT(graph_of(one, i) == graph_of(one, k), graph_of(two, i) == graph_of(two, k));
        graph_close(one);
        graph_close(two);
    }
}

/* P8 */
TEST(adding_and_deleting_a_link_is_the_identity)
{
    Graph *g = graph_with(50);
    uint64_t x = 3;
    for (uint32_t i = 0; i < 40; i++) {
        uint32_t a = noise(&x) % 50;
        join(g, a, (a + 1 + noise(&x) % 49) % 50);
    }
    for (uint32_t a = 0; a < 50; a++) {
        for (uint32_t b = 0; b < a; b++) {
            uint32_t part[50];
            bool inside = graph_of(g, a) == graph_of(g, b);
            uint64_t hash = graph_hash(g);
            int count = graph_count(g);
            for (uint32_t i = 0; i < 50; i++)
                part[i] = graph_first(g, graph_of(g, i));
            graph_link_remove(g, join(g, a, b));
            CHECK_INT(graph_count(g), count);
            if (inside)                 /* within one DIG nothing at all has changed */
                CHECK(graph_hash(g) == hash);
            for (uint32_t i = 0; i < 50; i++)           /* the same sets, whatever their ids */
                CHECK_INT(graph_of(g, part[i]), graph_of(g, i));
        }
    }
    CHECK(graph_check(g));
    graph_close(g);
}

TEST(a_copy_goes_on_exactly_like_the_original)
{
    Graph *g = graph_with(MODEL_NODES), *copy = NULL;
    Model *m = calloc(1, sizeof *m), *twin = calloc(1, sizeof *m);
    uint64_t x = 5;
    for (int i = 0; i < 500; i++)
        random_change(m, g, &x, 200);
    CHECK_INT(graph_copy(&copy, g), DIG_OK);
    CHECK(graph_hash(copy) == graph_hash(g));
    CHECK(graph_check(copy));
    *twin = *m;
    for (int round = 0; round < 3; round++) {
        uint64_t y = x;
        for (int i = 0; i < 500; i++) {
            random_change(m, g, &x, 200);
            random_change(twin, copy, &y, 200);
            CHECK_INT(graph_count(copy), graph_count(g));
        }
        CHECK(graph_hash(copy) == graph_hash(g));       /* handles, ids, all */
        for (int i = 0; i < graph_count(g); i++) {
            CHECK_INT(graph_by_index(copy, i), graph_by_index(g, i));
            CHECK_INT(graph_first(copy, graph_by_index(g, i)), graph_first(g, graph_by_index(g, i)));
        }
        Graph *same = copy;
        uint64_t allocations = graph_allocations(copy);
        CHECK_INT(graph_copy(&copy, g), DIG_OK);        /* into an existing one, which keeps its address and its memory */
        CHECK(copy == same);
        CHECK_INT(graph_allocations(copy), allocations);
        CHECK(graph_hash(copy) == graph_hash(g));
        if (round == 1) {
            CHECK_INT(graph_reserve(copy, 5000, 5000), DIG_OK);
            CHECK_INT(graph_copy(&copy, g), DIG_OK);    /* and into one of another capacity */
            CHECK(copy == same);
        }
    }
    graph_close(copy);
    graph_close(g);
    free(m);
    free(twin);
}

int main(void)
{
    RUN_TESTS(
        unit_test(sixty_thousand_random_single_changes_agree_with_brute_force),
        unit_test(random_batches_report_the_net_change_of_the_rule),
        unit_test(stacks_are_one_dig_in_whatever_order_they_are_found),
        unit_test(permuting_the_order_of_creation_permutes_ids_only),
        unit_test(adding_and_deleting_a_link_is_the_identity),
        unit_test(a_copy_goes_on_exactly_like_the_original)
    );
}
