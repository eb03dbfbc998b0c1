/* graph_fixture.h - what the tests of world/graph.h share. */
#ifndef DIG_GRAPH_FIXTURE_H
#define DIG_GRAPH_FIXTURE_H

#include "check.h"

#include "world/graph.h"

enum { FLOOR = 100000 };                /* slot of a static body: never a node */

static inline uint32_t noise(uint64_t *x)      /* MMIX constants of Knuth, upper half */
{
    *x = *x * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(*x >> 32);
}

static inline Graph *graph_with(uint32_t nodes)
{
    Graph *g = NULL;
    CHECK_INT(graph_open(&g), DIG_OK);
    for (uint32_t i = 0; i < nodes; i++)
        CHECK_INT(graph_node_add(g, i), DIG_OK);
    return g;
}

static inline uint32_t join(Graph *g, uint32_t a, uint32_t b)
{
    uint32_t link = GRAPH_END;
    CHECK_INT(graph_link_add(g, a, b, false, DIG_LINK_CONTACT, 0, 0, &link), DIG_OK);
    return link;
}

static inline uint32_t rest_on_floor(Graph *g, uint32_t a)
{
    uint32_t link = GRAPH_END;
    CHECK_INT(graph_link_add(g, a, FLOOR, true, DIG_LINK_CONTACT, 0, 0, &link), DIG_OK);
    return link;
}

/* The last batch reported exactly these changes. */
static inline void check_changes(const Graph *g, const GraphChange *want, int count)
{
    const GraphChange *got;
    CHECK_INT(graph_changes(g, &got), count);
    for (int i = 0; i < count; i++) {
        CHECK_INT(got[i].kind, want[i].kind);
        CHECK_INT(got[i].kept, want[i].kept);
        CHECK_INT(got[i].other, want[i].other);
    }
}

#define CHANGES(g, ...) check_changes(g, (const GraphChange[]){__VA_ARGS__}, \
                                      (int)(sizeof((const GraphChange[]){__VA_ARGS__}) / sizeof(GraphChange)))
#define NO_CHANGES(g) check_changes(g, NULL, 0)

#endif
