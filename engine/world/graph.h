/* world/graph.h - dynamic interaction graphs: who belongs together, and why.
 *
 * Nodes (bodies, by slot) and links between them, in one layer. The connected components are the DIGs. Labels are explicit:
 * merging relabels the smaller into the larger; removing a link grows a search from both ends at once, so that a split costs
 * what its smaller part costs. Static bodies are never nodes; links to them are marked `bound`, are listed among the links of
 * the dynamic end, and are skipped in labelling.
 *
 * Identity: on a merge the DIG with most members keeps its id (tie: lowest id); on a split the largest part does (tie: the part
 * with the lowest slot), the others get new ids. Ids count up from 1 and are never reused.
 *
 * Batch: graph_begin; any adds and removes; graph_end. Until graph_end the graph reads as before the batch. An add or a remove
 * outside a batch is a batch of its own.
 *
 * Net change: only the partition before and the partition after the batch count, not the order of the calls in it. Take the
 * finest partition that is coarser than both: its blocks are the sets of nodes that changed members among themselves. In each
 * block all old DIGs merge into one, the one with most members before the batch; then that one splits into the new DIGs, and the
 * new DIG with most of its old members keeps the id. So there is one MERGED per id that is gone, one SPLIT per id that is new,
 * and nothing for a DIG whose members are the same, whatever became of its links. Replay, merges first, rebuilds the labels:
 * MERGED gives all that carry `other` the label `kept`; SPLIT gives those that are now members of `other` that label.
 *
 * Cost: merge ~ nodes of the smaller DIG; removal of a link ~ twice the links of the smaller part, or until the two searches
 * meet; a node that leaves one large DIG for another in one batch costs itself, not the DIGs. Nothing is paid for nodes that
 * are not concerned.
 *
 * Owns:      its tables. They grow only in graph_reserve, graph_node_add and graph_link_add; graph_end never allocates.
 * Determinism: everything here depends on the sequence of calls only, not on capacities or addresses.
 * Files:     graph.c (tables), graph_split.c (batches), graph_check.c (checks and checksum); graph_inside.h is theirs alone.
 * Floor:     world, but needs base only, so that it can be tested alone.
 */
#ifndef DIG_GRAPH_H
#define DIG_GRAPH_H

#include "base/base.h"

#define GRAPH_NONE 0u                   /* no DIG */
#define GRAPH_END  UINT32_MAX           /* no more members, no more links */

typedef enum GraphChangeKind { GRAPH_MERGED, GRAPH_SPLIT } GraphChangeKind;

typedef struct GraphChange {            /* net change of one batch, in the order merges by gone id, then splits by new id */
    GraphChangeKind kind;
    uint32_t kept, other;               /* merged: survivor, gone; split: the part that kept the id (the parent), the new one */
} GraphChange;

typedef struct GraphLink {              /* link records are stable: index = handle */
    uint32_t a, b;                      /* node slots; a bound link's static end is b and is no node */
    uint8_t  kind;                      /* dig_link_kind */
    bool     bound, alive;
    uint8_t  state;                     /* private: free, adding, attached, removing, cancelled */
    uint32_t user;                      /* the caller's: contact slot, joint slot */
    real     began;                     /* s */
    uint32_t next[2], prev[2];          /* private: adjacency lists of a and b */
} GraphLink;

typedef struct Graph Graph;

dig_status graph_open(Graph **g);
void       graph_close(Graph *g);
/* Deep: same indices, ids and orders; for snapshots. *to NULL: a new one; else it is replaced and keeps its address.
 * No allocation when both have the same capacities. DIG_E_MEMORY: *to is unchanged. */
dig_status graph_copy(Graph **to, const Graph *from);
dig_status graph_reserve(Graph *g, int nodes, int links);       /* for node slots below `nodes`, and so many links at a time */
size_t     graph_bytes(const Graph *g);
uint64_t   graph_allocations(const Graph *g);                   /* calls to the allocator so far */

/* A new DIG of one, with a new id (not reported as a change; in a batch it counts as there before it).
 * DIG_E_ARG: it is there already; DIG_E_FULL: slot or ids beyond the limit; DIG_E_MEMORY. */
dig_status graph_node_add(Graph *g, uint32_t node);
/* Outside batches only. Its links, bound ones too, must be gone; its id is gone with it, which is not reported. */
void       graph_node_remove(Graph *g, uint32_t node);
bool       graph_has_node(const Graph *g, uint32_t node);

void       graph_begin(Graph *g);
/* Several links between the same two nodes are allowed and count separately. a must be a node; b too, and another one, unless
 * the link is bound, when b is only noted. DIG_E_ARG, DIG_E_FULL, DIG_E_MEMORY: nothing is added. */
dig_status graph_link_add(Graph *g, uint32_t a, uint32_t b, bool bound, uint8_t kind, uint32_t user, real began, uint32_t *link);
/* May remove what the same batch added. The handle is free again after graph_end. */
void       graph_link_remove(Graph *g, uint32_t link);
dig_status graph_end(Graph *g);         /* DIG_E_ARG: no batch; DIG_E_FULL: the ids are used up, the batch stays open */
int        graph_changes(const Graph *g, const GraphChange **out);      /* of the last batch; valid until the next change */

const GraphLink *graph_link(const Graph *g, uint32_t link);     /* NULL when not alive */
void       graph_link_set_user(Graph *g, uint32_t link, uint32_t user);
uint32_t   graph_of(const Graph *g, uint32_t node);             /* DIG id, GRAPH_NONE when no node */
int        graph_count(const Graph *g);                         /* DIGs alive */
uint32_t   graph_by_index(const Graph *g, int index);           /* id; a fixed order, but not by id. A DIG keeps its index until
                                                                 * an other one disappears */
int        graph_size(const Graph *g, uint32_t id);             /* 0 = no such DIG */
uint32_t   graph_first(const Graph *g, uint32_t id);            /* first member, members in list order; GRAPH_END: no such DIG */
uint32_t   graph_next(const Graph *g, uint32_t node);           /* next member; GRAPH_END at the end */
/* The DIG of a node without looking up its id: what a step asks for every body. GRAPH_END and 0 when it is no node. */
uint32_t   graph_lead(const Graph *g, uint32_t node);           /* first member of its DIG */
int        graph_fellows(const Graph *g, uint32_t node);        /* members of its DIG, itself included */
uint64_t   graph_user_of(const Graph *g, uint32_t node);        /* graph_user of its DIG */
/* Links of a node, newest first; GRAPH_END at the end. Includes bound links. */
uint32_t   graph_link_first(const Graph *g, uint32_t node);
uint32_t   graph_link_next(const Graph *g, uint32_t node, uint32_t link);
uint32_t   graph_link_after(const GraphLink *l, uint32_t node); /* the same of a link that is at hand and alive */
/* Per-DIG number of the caller (sleep state index, plan): kept by the surviving id on a merge, copied to new parts on a split.
 * 0 in a new DIG. */
void       graph_set_user(Graph *g, uint32_t id, uint64_t user);
uint64_t   graph_user(const Graph *g, uint32_t id);
uint64_t   graph_visits(const Graph *g);                        /* links and nodes looked at so far, for cost tests */
uint64_t   graph_hash(const Graph *g);                          /* of ids, membership and links: same state, same value */
bool       graph_check(const Graph *g);                         /* labels equal brute-force components, lists consistent;
                                                                 * slow, allocates; false also when there is no memory */

#endif
