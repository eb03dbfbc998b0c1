/* world/graph_inside.h - the tables of a graph; for graph*.c only. */
#ifndef DIG_GRAPH_INSIDE_H
#define DIG_GRAPH_INSIDE_H

#include "base/map.h"
#include "world/graph.h"

#define NIL UINT32_MAX

enum { LINK_FREE, LINK_ADDING, LINK_ATTACHED, LINK_REMOVING, LINK_CANCELLED };

/* An entry of an adjacency list is link * 2 + side; side 0 is in the list of link.a, side 1 in that of link.b. */
static inline uint32_t entry_link(uint32_t entry) { return entry >> 1; }
static inline uint32_t entry_side(uint32_t entry) { return entry & 1; }

typedef struct GraphNode {
    uint32_t dig;               /* record of its DIG; NIL = no node                   */
    uint32_t next, prev;        /* members of the DIG                                 */
    uint32_t links;             /* first entry of the adjacency list                  */
    uint64_t mark;              /* search * 2 + side that saw it last                 */
} GraphNode;

/* One DIG. Nodes point to the record, the record knows the id: giving a DIG another id costs nothing. */
typedef struct GraphDig {
    uint32_t id;                /* GRAPH_NONE = no id (yet)                           */
    uint32_t size;              /* members                                            */
    uint32_t first, last;       /* members; in a free record first is the next free   */
    uint32_t place;             /* in alive[]; NIL = not there                        */
    uint32_t touched;           /* place in touched[] + 1, within graph_end; 0 = not there */
    uint64_t user;
} GraphDig;

/* What graph_end asks of the DIGs that its batch touches; these know each other by their places in touched[]. Most batches touch few, and what
 * is never touched takes no memory. */
typedef struct GraphTouched {
    uint32_t dig;               /* its record                                         */
    uint32_t old_id, old_size;  /* before the batch; old_id GRAPH_NONE: split off in it */
    uint32_t origin;            /* the DIG it was part of before                      */
    uint32_t piece;             /* nodes of that DIG it had when merging began        */
    uint32_t into;              /* it was merged into that one; itself = none         */
    uint32_t overlap;           /* nodes of the DIG whose id the block keeps          */
    uint32_t block;             /* parent in the union-find over blocks; itself = root */
    uint32_t low;               /* lowest member slot, NIL = not known                */
    uint32_t holder;            /* root: that which had the id the block keeps        */
    uint32_t winner;            /* root: that which gets it                           */
    uint64_t kept_user;         /* root: user value that goes with it                 */
} GraphTouched;

enum { TABLE_NODES, TABLE_DIGS, TABLE_ALIVE, TABLE_TOUCHED, TABLE_QUEUE, TABLE_CHANGES, TABLE_LINKS, TABLE_ADDS, TABLE_REMOVES, GRAPH_TABLES };

struct Graph {
    GraphNode   *nodes;         /* [node_capacity] by slot                            */
    GraphDig    *digs;          /* [node_capacity] there are never more DIGs than nodes */
    uint32_t    *alive;         /* [node_capacity] records with an id, alive_count used */
    GraphTouched *touched;      /* [node_capacity] of graph_end                       */
    uint32_t    *queue;         /* [node_capacity] of the two searches, one from each end */
    GraphChange *changes;       /* [2 * node_capacity]                                */
    GraphLink   *links;         /* [link_capacity]                                    */
    uint32_t    *adds, *removes;/* [link_capacity] of the open batch, in call order   */
    Map          by_id;         /* id -> record                                       */
    uint32_t     node_capacity, link_capacity;
    size_t       held[GRAPH_TABLES];        /* bytes of each; more than the capacities say where a later one found no memory */
    uint32_t     node_count, alive_count, touched_count, change_count, add_count, remove_count;
    uint32_t     dig_top, link_top;         /* records ever used                      */
    uint32_t     free_dig, free_link;       /* last freed first; NIL = none           */
    uint32_t     next_id;
    bool         batch;                     /* between graph_begin and graph_end      */
    uint64_t     search;                    /* number of the last search              */
    uint64_t     visits, allocations;
};

/* graph.c: records. dig_take never fails: capacity is ensured when nodes are added. */
uint32_t graph_dig_take(Graph *g);
void     graph_dig_give(Graph *g, uint32_t dig);
void     graph_link_give(Graph *g, uint32_t link);
void     graph_id_set(Graph *g, uint32_t dig, uint32_t id);

/* graph_split.c: applies the open batch and finds the net change. */
void     graph_apply(Graph *g);

/* graph_check, in the room of a number for each node: no memory is to be told from no graph. */
bool     graph_check_in(const Graph *g, uint32_t *low);

#endif
